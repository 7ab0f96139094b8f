//! The JSON Schema of `machine.toml`, made of the types that read it.

use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::Description;

/// Keys and how they may be spelt otherwise, in the units of the other kind of axis; schemars does not know aliases.
const OTHERWISE: [(&str, &str); 27] = [
    ("back_emf_v_s_per_m", "back_emf_v_s_per_rad"),
    ("centre_m", "centre_rad"),
    ("cosine_2_n", "cosine_2_nm"),
    ("cosine_m", "cosine_rad"),
    ("cosine_n", "cosine_nm"),
    ("damping_n_s_per_m", "damping_nm_s_per_rad"),
    ("derivative_gain_v_s_per_m", "derivative_gain_v_s_per_rad"),
    ("force_constant_n_per_a", "torque_constant_nm_per_a"),
    ("force_n", "torque_nm"),
    ("force_n_per_v", "torque_nm_per_v"),
    ("friction_n", "friction_nm"),
    ("magnet_pitch_m", "magnet_pitch_rad"),
    ("mass_kg", "inertia_kg_m2"),
    ("noise_m", "noise_rad"),
    ("period_m", "period_rad"),
    ("position_gain_v_per_m", "position_gain_v_per_rad"),
    ("ratio", "ratio_rad_per_m"),
    ("resolution_m", "resolution_rad"),
    ("saturation_per_n", "saturation_per_nm"),
    ("sine_2_n", "sine_2_nm"),
    ("sine_m", "sine_rad"),
    ("sine_n", "sine_nm"),
    ("stiffness_n_per_m", "stiffness_nm_per_rad"),
    ("stribeck_velocity_m_per_s", "stribeck_velocity_rad_per_s"),
    ("velocity_gain_v_s_per_m", "velocity_gain_v_s_per_rad"),
    ("viscous_n_s_per_m", "viscous_nm_s_per_rad"),
    ("width_m", "width_rad"),
];
/// Types whose keys have one spelling only.
const ONE_SPELLING: [&str; 1] = ["Mode"];
/// A law that has two names.
const PROPORTIONAL: (&str, &str) = ("pd", "p");

/// The JSON Schema of `machine.toml` (draft 2020-12): what an editor with a TOML language server completes by.
///
/// ```
/// let schema = slideway::machine::schema();
/// assert_eq!(schema["properties"]["sample_period_s"]["description"], "Sample period of the controller in s.");
/// ```
pub fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = generator.into_root_schema_for::<Description>().to_value();
    shorten(&mut schema);
    spell_otherwise(&mut schema);
    schema["title"] = "machine.toml".into();
    schema
}

/// Descriptions of one paragraph, without links; defaults of keys only, not of whole tables.
fn shorten(node: &mut Value) {
    match node {
        Value::Object(object) => {
            if let Some(Value::String(text)) = object.get_mut("description") {
                let paragraph = text.split("\n\n").next().unwrap_or_default();
                *text = unlinked(&paragraph.replace('\n', " "));
            }
            object.remove("format");
            if object.get("default").is_some_and(|value| value.is_null() || value.is_object()) {
                object.remove("default");
            }
            object.values_mut().for_each(shorten);
        }
        Value::Array(list) => list.iter_mut().for_each(shorten),
        _ => {}
    }
}

/// A text whose links are their words: ``[`Name`](place)`` becomes `Name`.
fn unlinked(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, link)) = rest.split_once("[`") {
        let Some((name, behind)) = link.split_once("`]") else { break };
        let target = behind.strip_prefix('(').and_then(|target| target.split_once(')'));
        out += before;
        out += name;
        rest = target.map_or(behind, |(_, behind)| behind);
    }
    out + rest
}

/// Every key in each of its spellings, of which a file has one.
fn spell_otherwise(node: &mut Value) {
    match node {
        Value::Object(object) => {
            let mut either = Vec::new();
            for (key, other) in OTHERWISE {
                let Some(mut value) = object.get("properties").and_then(|known| known.get(key)).cloned()
                else {
                    continue;
                };
                let said = value.get("description").and_then(Value::as_str).unwrap_or_default();
                value["description"] = format!("{said} The same as {key}.").trim_start().into();
                object["properties"][other] = value;
                if let Some(Value::Array(required)) = object.get_mut("required")
                    && let Some(place) = required.iter().position(|name| name == key)
                {
                    required.remove(place);
                    either.push(json!({ "oneOf": [{ "required": [key] }, { "required": [other] }] }));
                }
            }
            if !either.is_empty() {
                object.insert("allOf".to_owned(), either.into());
            }
            if let Some(law) = object.get_mut("const").filter(|law| *law == PROPORTIONAL.0) {
                *law = Value::Null;
                object.remove("const");
                object.insert("enum".to_owned(), json!([PROPORTIONAL.0, PROPORTIONAL.1]));
            }
            let inner = object.iter_mut().filter(|(name, _)| !ONE_SPELLING.contains(&name.as_str()));
            inner.for_each(|(_, value)| spell_otherwise(value));
        }
        Value::Array(list) => list.iter_mut().for_each(spell_otherwise),
        _ => {}
    }
}
