//! The JSON Schema of `recording.toml`, from the same lists of keys as its reader.

use serde_json::{Map, Value, json};

use super::columns;
use super::manifest::{KEYS, RUN_KEYS};
use super::signal::{Signal, TIME_KEY};
use crate::units::{Dimension, Motion};

/// The JSON Schema of `recording.toml` (draft 2020-12): what an editor with a TOML language server completes by.
///
/// Free keys of a `[[run]]` are metadata, so that a mistyped one is told only where it is near a known key, when the file is read.
pub fn schema() -> Value {
    let properties: Map<String, Value> = KEYS.iter().map(|key| ((*key).to_owned(), top(key))).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "recording.toml",
        "description": "Which files hold the runs of a recording, and which column is which signal.",
        "type": "object",
        "properties": properties,
        "required": ["run"],
        "additionalProperties": false,
        "$defs": { "columns": columns_table() },
    })
}

fn top(key: &str) -> Value {
    match key {
        "sample_period_s" => json!({
            "description": "Time between two samples in s; optional where the files have a time column.",
            "type": "number", "exclusiveMinimum": 0,
        }),
        "motion" => json!({
            "description": "Whether the axis slides or turns; optional where a signal name tells it.",
            "type": "string", "enum": [Motion::Prismatic.to_string(), Motion::Revolute.to_string()],
        }),
        "machine" => text("Folder of the machine, or its TOML file; relative to this file."),
        "note" => text("Where the data come from; shown wherever results are."),
        "data_folder" => text(
            "Folder that the files of the runs are relative to; the environment variable SLIDEWAY_DATA overrides it. A relative one may lead out of the recording's folder, then to tables only.",
        ),
        "run" => json!({
            "description": "The runs, a [[run]] each.",
            "type": "array", "minItems": 1, "items": run(),
        }),
        _ => json!({ "$ref": "#/$defs/columns" }),
    }
}

fn run() -> Value {
    let known = RUN_KEYS.iter().map(|key| ((*key).to_owned(), run_key(key)));
    let free = [
        (
            "begins_s",
            json!({
                "description": "When the run begins within the session, in s; for all runs or for none.",
                "type": "number",
            }),
        ),
        (
            "feedforward",
            json!({
                "description": "What was fed forward beside the logged effort.",
                "type": "object",
            }),
        ),
        (
            "published",
            json!({
                "description": "Published errors of this run, by signal: { unit, mae, r2 }.",
                "type": "object",
            }),
        ),
    ];
    let free = free.into_iter().map(|(key, value)| (key.to_owned(), value));
    let properties: Map<String, Value> = known.chain(free).collect();
    json!({
        "description": "One run. Further keys are metadata.",
        "type": "object",
        "properties": properties,
        "required": ["file"],
    })
}

fn run_key(key: &str) -> Value {
    match key {
        "file" => text("File of the run."),
        "name" => text("Name of the run; otherwise the file name without its ending."),
        "role" => json!({
            "description": "What the run may be used for; where no run says, runs are split by whole run.",
            "type": "string", "enum": ["training", "held_out"],
        }),
        "set" => json!({
            "description": "Machine settings in force in this run, by key path: { \"controller.integral\" = 22 }.",
            "type": "object",
        }),
        "columns" => json!({ "$ref": "#/$defs/columns" }),
        "extra_columns" => json!({
            "description": "Columns kept beside the signals, as they stand in the file.",
            "type": "array", "items": { "type": "string" },
        }),
        "from_s" => number("Only the samples from this time on, in s."),
        "to_s" => number("Only the samples before this time, in s."),
        _ => json!({}),
    }
}

fn columns_table() -> Value {
    let mut properties = Map::new();
    properties.insert(TIME_KEY.to_owned(), source("Time of the sample.", Dimension::Time));
    for signal in Signal::ALL {
        for motion in [Motion::Prismatic, Motion::Revolute] {
            let key = signal.key(motion).to_owned();
            properties.entry(key).or_insert_with(|| source(signal.meaning(), signal.dimension(motion)));
        }
    }
    json!({
        "description": "Which column holds which signal, where its name or unit is not the canonical one.",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
    })
}

/// A column name, or a table with its unit: SI = reading · unit · scale + offset.
fn source(meaning: &str, dimension: Dimension) -> Value {
    let si = dimension.si_symbol();
    let properties: Map<String, Value> = columns::KEYS
        .iter()
        .map(|key| {
            let value = match *key {
                "column" => text("Column of the file."),
                "unit" => json!({
                    "description": format!("Unit of the column, or {si} per count."),
                    "anyOf": [
                        { "enum": dimension.symbols() },
                        { "type": "string" },
                        { "type": "number", "exclusiveMinimum": 0 },
                    ],
                }),
                "scale" => number("Factor on the reading in SI; −1 turns the sign."),
                _ => number(&format!("Added afterwards, in {si}.")),
            };
            ((*key).to_owned(), value)
        })
        .collect();
    json!({
        "description": format!("{meaning} In {si}."),
        "anyOf": [
            { "type": "string" },
            { "type": "object", "properties": properties, "additionalProperties": false },
        ],
    })
}

fn text(description: &str) -> Value {
    json!({ "description": description, "type": "string" })
}

fn number(description: &str) -> Value {
    json!({ "description": description, "type": "number" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_key_of_the_reader_is_described() {
        let schema = schema();
        let described = |at: &str| schema.pointer(at).is_some_and(|key| key != &json!({}));
        assert!(KEYS.iter().all(|key| described(&format!("/properties/{key}"))));
        assert!(RUN_KEYS.iter().all(|key| described(&format!("/properties/run/items/properties/{key}"))));
        assert!(Signal::keys(None).iter().all(|key| described(&format!("/$defs/columns/properties/{key}"))));
    }
}
