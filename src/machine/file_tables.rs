//! The tables of `machine.toml` as its schema has them: keys, what they mean, and the kinds of tables that have some.

use serde_json::{Map, Value};

use super::schema::schema;

/// Tables that no one writes by hand, or that have a list of their own.
const ELSEWHERE: [&str; 2] = ["effect", "provenance"];

/// Tables in the order of the signal path.
const ORDER: [&str; 14] = [
    "reference",
    "controller",
    "amplifier",
    "motor",
    "transmission",
    "screw",
    "guide",
    "base",
    "encoder",
    "load_sensor",
    "current_sensor",
    "tolerance",
    "crosscheck",
    "tune",
];

/// A table of a machine file; of one that comes in several kinds, one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct FileTable {
    /// Key path; empty for the top of the file.
    pub path: String,
    /// The key that chooses the kind, where there is one, `law` or `kind`.
    pub chosen_by: Option<String>,
    /// The kind.
    pub kind: Option<String>,
    /// Whether the table is one of a list, `[[path]]`.
    pub listed: bool,
    /// What it is, in a sentence or two.
    pub description: String,
    /// Its keys, those that must be there first.
    pub keys: Vec<FileKey>,
}

/// A key of such a table.
#[derive(Debug, Clone, PartialEq)]
pub struct FileKey {
    /// The key.
    pub name: String,
    /// What it is, with its unit.
    pub description: String,
    /// Whether it must be there.
    pub required: bool,
    /// What holds where it is not there, if that is a value.
    pub default: Option<String>,
}

/// The tables of a machine file, one a kind, with the table of a part before those inside it.
///
/// ```
/// let tables = slideway::machine::file_tables();
/// assert!(tables.iter().any(|table| table.path == "motor" && table.kind.as_deref() == Some("winding")));
/// ```
pub fn file_tables() -> Vec<FileTable> {
    let root = schema();
    let mut tables = Vec::new();
    walk(&root, &root, "", false, "The machine.", &mut tables);
    let place = |table: &FileTable| {
        let part = table.path.split('.').next().unwrap_or_default();
        ORDER.iter().position(|known| *known == part).map_or(0, |place| place + 1)
    };
    tables.sort_by_key(place);
    // The filters are the same behind every law.
    let mut seen = Vec::new();
    tables.retain(|table| {
        let is_new = !seen.contains(table);
        seen.push(table.clone());
        is_new
    });
    tables
}

/// What stands behind references and behind what may be left out.
fn resolved<'a>(root: &'a Value, node: &'a Value) -> &'a Value {
    if let Some(name) = node.get("$ref").and_then(Value::as_str) {
        return root.pointer(name.trim_start_matches('#')).map_or(node, |inner| resolved(root, inner));
    }
    let choices = node.get("anyOf").and_then(Value::as_array);
    match choices.and_then(|list| list.iter().find(|choice| choice.get("type") != Some(&"null".into()))) {
        Some(inner) => resolved(root, inner),
        None => node,
    }
}

fn walk(root: &Value, node: &Value, path: &str, listed: bool, said: &str, tables: &mut Vec<FileTable>) {
    let node = resolved(root, node);
    let kinds = node.get("oneOf").and_then(Value::as_array);
    let variants: Vec<&Value> = kinds.map_or_else(|| vec![node], |kinds| kinds.iter().collect());
    for variant in variants {
        let Some(properties) = variant.get("properties").and_then(Value::as_object) else { continue };
        let tag = properties.iter().find_map(|(name, value)| Some((name.clone(), kind_of(value)?)));
        let description = if tag.is_some() { text(variant) } else { said.to_owned() };
        let (chosen_by, kind) = tag.unzip();
        let place = tables.len();
        let table =
            FileTable { path: path.to_owned(), chosen_by, kind, listed, description, keys: Vec::new() };
        tables.push(table);
        let keys = keys(root, variant, properties, path, tables);
        tables[place].keys = keys;
    }
}

/// The kind that a key chooses, where it does.
fn kind_of(value: &Value) -> Option<String> {
    let first = value.get("enum").and_then(|names| names.get(0));
    value.get("const").or(first)?.as_str().map(str::to_owned)
}

/// The keys of a table that hold values; tables inside it are walked.
fn keys(
    root: &Value,
    table: &Value,
    properties: &Map<String, Value>,
    path: &str,
    tables: &mut Vec<FileTable>,
) -> Vec<FileKey> {
    let must = |name: &str| {
        let named = |list: &Value| list.as_array().is_some_and(|list| list.iter().any(|key| key == name));
        let either = table.get("allOf").and_then(Value::as_array);
        let among = |choice: &Value| {
            choice["oneOf"].as_array().is_some_and(|list| list.iter().any(|one| named(&one["required"])))
        };
        table.get("required").is_some_and(named) || either.is_some_and(|list| list.iter().any(among))
    };
    let mut keys = Vec::new();
    for (name, value) in properties {
        if kind_of(value).is_some() || (path.is_empty() && ELSEWHERE.contains(&name.as_str())) {
            continue;
        }
        let inner = resolved(root, value);
        let item = inner.get("items").map(|items| resolved(root, items));
        let is_table = |node: &Value| {
            node.get("properties").is_some()
                || node["oneOf"]
                    .as_array()
                    .is_some_and(|l| l.iter().any(|one| one.get("properties").is_some()))
        };
        let below = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match (is_table(inner), item.filter(|item| is_table(item))) {
            (true, _) => walk(root, inner, &below, false, &text(value), tables),
            (false, Some(item)) => walk(root, item, &below, true, &text(value), tables),
            (false, None) => keys.push(FileKey {
                name: name.clone(),
                description: text(value),
                required: must(name),
                default: value.get("default").map(Value::to_string),
            }),
        }
    }
    keys.sort_by_key(|key| !key.required);
    keys
}

fn text(node: &Value) -> String {
    node.get("description").and_then(Value::as_str).unwrap_or_default().to_owned()
}
