//! What can be known without reading the source: schemas of the TOML files, lists of signals and kinds, likely meant names,
//! completions, the manual page.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::slideway as run;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;
use slideway::machine::{Description, Machine, file_tables};
use slideway::recording::{Recording, Signal};
use slideway::report::kind_example;
use slideway::{machine, recording};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[track_caller]
fn shown(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn refused(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8(output.stderr).unwrap()
}

/// What is wrong with a value under a schema; knows the keywords that the schemas use and no other.
fn faults(root: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let mut found = Vec::new();
    let fits = |schema: &Value| faults(root, schema, value, at).is_empty();
    for (keyword, rule) in schema.as_object().map(|object| object.iter()).into_iter().flatten() {
        let wrong = match keyword.as_str() {
            "$schema" | "title" | "description" | "default" | "$defs" => None,
            "$ref" => {
                let target = root.pointer(rule.as_str().unwrap().trim_start_matches('#')).unwrap();
                found.extend(faults(root, target, value, at));
                None
            }
            "type" => (!is_of(rule, value)).then(|| format!("is no {rule}")),
            "const" => (value != rule).then(|| format!("is not {rule}")),
            "enum" => (!rule.as_array().unwrap().contains(value)).then(|| format!("is none of {rule}")),
            "anyOf" => (!rule.as_array().unwrap().iter().any(fits)).then(|| "fits nothing".to_owned()),
            "allOf" => (!rule.as_array().unwrap().iter().all(fits)).then(|| format!("breaks {rule}")),
            "oneOf" => {
                let fitting = rule.as_array().unwrap().iter().filter(|schema| fits(schema)).count();
                (fitting != 1).then(|| format!("fits {fitting} of several"))
            }
            "required" => {
                let missing = |key: &&Value| value.is_object() && value.get(key.as_str().unwrap()).is_none();
                rule.as_array().unwrap().iter().find(missing).map(|key| format!("lacks {key}"))
            }
            "properties" => {
                for (key, inner) in value.as_object().map(|object| object.iter()).into_iter().flatten() {
                    if let Some(schema) = rule.get(key) {
                        found.extend(faults(root, schema, inner, &format!("{at}.{key}")));
                    }
                }
                None
            }
            "additionalProperties" => {
                let known =
                    |key: &str| schema.get("properties").is_some_and(|known| known.get(key).is_some());
                let object = value.as_object().map(|object| object.iter()).into_iter().flatten();
                let mut unknown = object.filter(|(key, _)| !known(key));
                match rule {
                    Value::Bool(false) => unknown.next().map(|(key, _)| format!("has an unknown {key}")),
                    schema => {
                        unknown.for_each(|(key, inner)| {
                            found.extend(faults(root, schema, inner, &format!("{at}.{key}")));
                        });
                        None
                    }
                }
            }
            "items" => {
                for (k, item) in value.as_array().into_iter().flatten().enumerate() {
                    found.extend(faults(root, rule, item, &format!("{at}.{k}")));
                }
                None
            }
            bound => is_beyond(bound, rule, value),
        };
        found.extend(wrong.map(|wrong| format!("{at} {wrong}")));
    }
    found
}

/// What is wrong with a value under a keyword that bounds it.
fn is_beyond(keyword: &str, rule: &Value, value: &Value) -> Option<String> {
    let length = || value.as_array().unwrap().len() as u64;
    let (is_wrong, what) = match keyword {
        "minItems" => (length() < rule.as_u64().unwrap(), "is short"),
        "maxItems" => (length() > rule.as_u64().unwrap(), "is long"),
        "minimum" => (value.as_f64() < rule.as_f64(), "is too small"),
        "maximum" => (value.as_f64() > rule.as_f64(), "is too large"),
        "exclusiveMinimum" => (value.as_f64().is_some_and(|v| v <= rule.as_f64().unwrap()), "is too small"),
        other => panic!("the schema uses `{other}`, which this test does not know"),
    };
    is_wrong.then(|| what.to_owned())
}

fn is_of(rule: &Value, value: &Value) -> bool {
    if let Value::Array(kinds) = rule {
        return kinds.iter().any(|kind| is_of(kind, value));
    }
    match rule.as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        other => panic!("type {other}"),
    }
}

fn faults_of(schema: &Value, text: &str) -> Vec<String> {
    let table: toml::Table = toml::from_str(text).unwrap();
    faults(schema, schema, &serde_json::to_value(table).unwrap(), "file")
}

/// Every TOML file below `models` and `assets` that is a machine or a recording, with its schema and that one's name.
fn shipped() -> Vec<(PathBuf, String, Value, &'static str)> {
    let mut files = Vec::new();
    for folder in ["models", "assets"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let inner = entry.unwrap().path();
            let Ok(inner) = std::fs::read_dir(inner) else { continue };
            files.extend(
                inner
                    .map(|entry| entry.unwrap().path())
                    .filter(|p| p.extension().is_some_and(|e| e == "toml")),
            );
        }
    }
    files.sort();
    let read = |path: PathBuf| {
        let text = std::fs::read_to_string(&path).unwrap();
        let table: toml::Table = toml::from_str(&text).unwrap();
        match (table.contains_key("urdf"), table.contains_key("run")) {
            (true, _) => Some((path, text, machine::schema(), "machine.json")),
            (_, true) => Some((path, text, recording::schema(), "recording.json")),
            _ => None,
        }
    };
    files.into_iter().filter_map(read).collect()
}

#[test]
fn exact_shipped_schemas_are_what_the_program_makes() {
    for (name, made) in [("machine", machine::schema()), ("recording", recording::schema())] {
        let path = root().join(format!("assets/schema/{name}.json"));
        let shipped: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        assert!(shipped == made, "slideway schema {name} > assets/schema/{name}.json");
        assert_eq!(serde_json::from_str::<Value>(&shown(&["schema", name])).unwrap(), made);
    }
}

#[test]
fn exact_every_shipped_file_names_its_schema_and_keeps_to_it() {
    let files = shipped();
    assert!(files.len() > 15, "{}", files.len());
    for (path, text, schema, name) in files {
        let first = text.lines().next().unwrap();
        let stated = first.strip_prefix("#:schema ").unwrap_or_else(|| panic!("{}: {first}", path.display()));
        let meant = path.parent().unwrap().join(stated).canonicalize().unwrap();
        assert_eq!(
            meant,
            root().join("assets/schema").join(name).canonicalize().unwrap(),
            "{}",
            path.display()
        );
        assert_eq!(faults_of(&schema, &text), Vec::<String>::new(), "{}", path.display());
    }
}

#[test]
fn exact_schema_refuses_what_the_reader_refuses() {
    let schema = machine::schema();
    let text = std::fs::read_to_string(root().join("models/grinder/machine.toml")).unwrap();
    for (from, to) in [
        ("resistance_ohm", "resistence_ohm"),
        ("kind = \"winding\"", "kind = \"coil\""),
        ("sample_period_s = 250e-6", "sample_period_s = \"fast\""),
        ("[encoder]", "[encodr]"),
    ] {
        assert!(text.contains(from), "{from}");
        let spoilt = text.replacen(from, to, 1);
        assert!(!faults_of(&schema, &spoilt).is_empty(), "{to}");
        assert!(toml::from_str::<Description>(&spoilt).is_err(), "{to}");
    }
}

/// The aliases that the types below a folder of the source state, as often as they are stated.
fn aliases(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(root().join("src").join(folder)).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        let stated = text.split("alias = \"").skip(1).filter_map(|rest| rest.split('"').next());
        found.extend(stated.filter(|alias| *alias != "p").map(str::to_owned));
    }
    found
}

fn spelt_otherwise(node: &Value, found: &mut Vec<String>) {
    match node {
        Value::Object(object) => {
            let properties = object.get("properties").and_then(Value::as_object);
            for (key, value) in properties.into_iter().flatten() {
                let said = value["description"].as_str().unwrap_or_default();
                if said.contains("The same as ") && said.ends_with('.') {
                    found.push(key.clone());
                }
            }
            object.values().for_each(|value| spelt_otherwise(value, found));
        }
        Value::Array(list) => list.iter().for_each(|value| spelt_otherwise(value, found)),
        _ => {}
    }
}

#[test]
fn exact_schema_knows_every_alias_of_the_types() {
    let folders = ["sensor", "drive", "controller", "base", "guide", "effect", "machine"];
    let mut stated: Vec<String> = folders.iter().flat_map(|folder| aliases(folder)).collect();
    let mut known = Vec::new();
    spelt_otherwise(&machine::schema(), &mut known);
    stated.sort();
    known.sort();
    assert_eq!(known, stated);
}

/// `over` laid over `table`, tables merged.
fn merged(mut table: toml::Table, over: toml::Table) -> toml::Table {
    for (key, value) in over {
        let inner = match (table.remove(&key), value) {
            // A table that chooses a kind stands for itself.
            (Some(toml::Value::Table(old)), toml::Value::Table(new))
                if !new.contains_key("kind") && !new.contains_key("law") =>
            {
                toml::Value::Table(merged(old, new))
            }
            (_, value) => value,
        };
        table.insert(key, inner);
    }
    table
}

#[test]
fn exact_every_kind_has_an_example_that_is_read() {
    let text = std::fs::read_to_string(root().join("models/grinder/machine.toml")).unwrap();
    let base: toml::Table = toml::from_str(&text).unwrap();
    let mut shown = 0;
    for table in file_tables() {
        let Some(example) = kind_example(&table) else {
            assert!(table.kind.is_none() && !table.keys.iter().any(|key| key.required), "{table:?}");
            continue;
        };
        shown += 1;
        let over: toml::Table = toml::from_str(example).unwrap_or_else(|e| panic!("{example}\n{e}"));
        let machine = merged(base.clone(), over);
        let read: Result<Description, _> = machine.clone().try_into();
        read.unwrap_or_else(|e| panic!("{example}\n{e}"))
            .check()
            .unwrap_or_else(|e| panic!("{example}\n{e}"));
        let schema = machine::schema();
        let faults = faults(&schema, &schema, &serde_json::to_value(machine).unwrap(), "file");
        assert_eq!(faults, Vec::<String>::new(), "{example}");
        if let Some(kind) = &table.kind {
            assert!(example.contains(&format!("\"{kind}\"")), "{example}");
        }
    }
    assert!(shown >= 20, "{shown}");
}

#[test]
fn exact_lists_name_everything_that_exists() {
    let signals = shown(&["signals"]);
    for key in Signal::keys(None) {
        assert!(signals.contains(key), "{key}");
        assert!(shown(&["signals", key]).contains(key), "{key}");
    }
    assert!(shown(&["signals", "position_m"]).contains("position_m = { column = "));
    let kinds = shown(&["kinds"]);
    let mut names = BTreeSet::new();
    for table in file_tables() {
        assert!(kinds.contains(&table.path), "{}", table.path);
        names.extend(table.kind);
    }
    assert!(names.contains("cascade") && names.contains("taps"));
    for kind in names {
        assert!(kinds.contains(&format!("\"{kind}\"")), "{kind}");
        assert!(shown(&["kinds", &kind]).contains(&kind));
    }
    let winding = shown(&["kinds", "winding"]);
    for word in ["resistance_ohm", "R in Ω", "Required", "[motor] kind = \"winding\"", "inductance_h = 8e-3"]
    {
        assert!(winding.contains(word), "`{word}` is not in {winding}");
    }
}

#[test]
fn exact_mistyped_names_are_answered_with_the_one_that_was_meant() {
    let folder = tempfile::TempDir::new().unwrap();
    let text = std::fs::read_to_string(root().join("models/grinder/machine.toml")).unwrap();
    for (from, to, meant) in [
        ("resistance_ohm", "resistence_ohm", "did you mean `resistance_ohm`?"),
        ("kind = \"winding\"", "kind = \"windnig\"", "did you mean `winding`?"),
        ("[encoder]", "[encodr]", "did you mean `encoder`?"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(folder.path().join("machine.toml"), text.replacen(from, to, 1)).unwrap();
        let error = Machine::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains(meant), "{error}");
    }
    let recording = "sample_period_s = 1e-3\n[[run]]\nfile = \"a.csv\"\n[columns]\npositon_m = \"x\"\n";
    std::fs::write(folder.path().join("recording.toml"), recording).unwrap();
    let error = Recording::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("did you mean `position_m`?"), "{error}");
    for (arguments, meant) in [
        (vec!["effects", "coulomb_fricton"], "coulomb_friction"),
        (vec!["signals", "positon_m"], "position_m"),
        (vec!["kinds", "cascde"], "cascade"),
        (vec!["diagnos"], "diagnose"),
        (vec!["inspect", "--htm"], "--html"),
    ] {
        let told = refused(&arguments);
        assert!(told.contains(meant) && told.contains("similar"), "{told}");
    }
}

#[test]
fn exact_completions_and_manual_know_every_command() {
    let commands = ["diagnose", "replay", "identify", "effects", "signals", "kinds", "schema", "inspect"];
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = shown(&["completions", shell]);
        assert!(commands.iter().all(|command| script.contains(command)), "{shell}");
    }
    let page = shown(&["man"]);
    assert!(page.contains(".TH"), "{page}");
    assert!(commands.iter().all(|command| page.contains(command)), "{page}");
    let folder = tempfile::TempDir::new().unwrap();
    shown(&["man", "--out", folder.path().to_str().unwrap()]);
    for page in ["slideway.1", "slideway-diagnose.1", "slideway-identify-gains.1"] {
        assert!(folder.path().join(page).is_file(), "{page}");
    }
}
