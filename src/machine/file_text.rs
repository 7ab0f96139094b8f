//! The text of a machine file with values changed and its comments kept.

use crate::error::{Error, ErrorKind, Result, toml_text};
use std::path::Path;

/// The text of a machine file that holds `target`: the text as it was with the changed values in their places
/// and new ones behind it, comments kept; where that does not read back as `target`, the table written afresh.
///
/// # Errors
/// A file that cannot be read any more, or values that TOML cannot hold.
pub(super) fn file_text(file: &Path, target: &toml::Table) -> Result<String> {
    let text = std::fs::read_to_string(file).map_err(|e| Error::io(file, &e))?;
    let table: toml::Table = toml::from_str(&text).map_err(|e| toml_text::refusal(file, &text, &e))?;
    let edited = edited(without_schema(&text), &table, target);
    match edited.filter(|edited| toml::from_str::<toml::Table>(edited).is_ok_and(|t| t == *target)) {
        Some(edited) => Ok(edited),
        None => serialised(target).map_err(|e| e.file(file)),
    }
}

/// The text without a first line that names its schema by a path: that is not the way from the new file to it.
fn without_schema(text: &str) -> &str {
    match text.split_once('\n') {
        Some((first, rest)) if first.starts_with("#:schema .") => rest,
        _ => text,
    }
}

fn serialised(table: &toml::Table) -> Result<String> {
    toml::to_string(table).map_err(|e| {
        Error::new(ErrorKind::Syntax).found(e.to_string()).expected("values that a machine file can hold")
    })
}

/// The text with every value of `target` that `table` does not have.
fn edited(text: &str, table: &toml::Table, target: &toml::Table) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut behind = toml::Table::new();
    for (path, value) in changes(table, target) {
        let (key, tables) = path.split_last()?;
        let head = format!("[{}]", tables.join("."));
        let at = lines.iter().position(|line| line.trim_end() == head);
        let from = match (tables.is_empty() && !is_list_of_tables(&value), at) {
            (true, _) => 0,
            (false, Some(at)) => at + 1,
            (false, None) => {
                let inner = tables.iter().try_fold(&mut behind, |inner, name| {
                    inner.entry(name.clone()).or_insert_with(|| toml::Table::new().into()).as_table_mut()
                })?;
                inner.insert(key.clone(), value);
                continue;
            }
        };
        put(&mut lines, from, key, &value);
    }
    let mut text = lines.join("\n") + "\n";
    if !behind.is_empty() {
        text += "\n";
        text += &serialised(&behind).ok()?;
    }
    Some(text)
}

/// Puts a value on its line in the table whose first line is `from`, or on a line of its own at the table's head.
fn put(lines: &mut Vec<String>, from: usize, key: &str, value: &toml::Value) {
    let is_it = |line: &&String| {
        line.trim_start().strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with('='))
    };
    let own = lines[from..].iter().take_while(|line| !line.starts_with('['));
    match own.enumerate().find(|(_, line)| is_it(line)) {
        Some((at, _)) => {
            let line = &mut lines[from + at];
            let comment = line.find('#').map(|at| format!("  {}", &line[at..])).unwrap_or_default();
            *line = format!("{key} = {value}{comment}");
        }
        None => lines.insert(from, format!("{key} = {value}")),
    }
}

/// Key path and value of everything in `target` that is not so in `table`, table by table; lists count as one value.
fn changes(table: &toml::Table, target: &toml::Table) -> Vec<(Vec<String>, toml::Value)> {
    let mut all = Vec::new();
    for (key, value) in target {
        let before = table.get(key);
        if before == Some(value) {
            continue;
        }
        match (before, value) {
            (None | Some(toml::Value::Table(_)), toml::Value::Table(inner)) => {
                let nothing = toml::Table::new();
                let before = before.and_then(toml::Value::as_table).unwrap_or(&nothing);
                let behind = changes(before, inner).into_iter();
                all.extend(behind.map(|(path, v)| ([vec![key.clone()], path].concat(), v)));
            }
            // A list of tables that has grown: only what is new is written, behind the rest.
            (Some(toml::Value::Array(before)), toml::Value::Array(list))
                if is_list_of_tables(value) && list.starts_with(before) =>
            {
                all.push((vec![key.clone()], list[before.len()..].to_vec().into()));
            }
            _ => all.push((vec![key.clone()], value.clone())),
        }
    }
    all
}

fn is_list_of_tables(value: &toml::Value) -> bool {
    value.as_array().is_some_and(|list| !list.is_empty() && list.iter().all(toml::Value::is_table))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    const TEXT: &str =
        "# A slide.\nname = \"slide\"  # on the left\n\n[motor]\nforce_n_per_v = 35.0  # data sheet\n";

    fn written(text: &str, target: &str) -> String {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(text.as_bytes()).unwrap();
        file_text(file.path(), &toml::from_str(target).unwrap()).unwrap()
    }

    #[test]
    fn exact_comments_stay_where_values_change() {
        let target = "name = \"slide\"\n[motor]\nforce_n_per_v = 34.5\nkind = \"direct\"\n[effect.payload]\nmass_kg = 2.0\n[[provenance]]\nversion = \"1\"\n";
        let text = written(TEXT, target);
        assert_eq!(
            toml::from_str::<toml::Table>(&text).unwrap(),
            toml::from_str::<toml::Table>(target).unwrap()
        );
        for kept in ["# A slide.", "# on the left", "force_n_per_v = 34.5  # data sheet", "[effect.payload]"]
        {
            assert!(text.contains(kept), "`{kept}` is not in {text}");
        }
    }

    #[test]
    fn exact_lists_of_tables_grow_behind_the_text() {
        let text = format!("{TEXT}[[provenance]]\nversion = \"1\"\n");
        let target = format!("{text}[[provenance]]\nversion = \"2\"\n");
        assert_eq!(written(&text, &target).replace("\n\n", "\n"), target.replace("\n\n", "\n"));
    }

    #[test]
    fn exact_what_cannot_be_edited_is_written_afresh() {
        // A key that is taken away, an inline table, a key in a table that a dotted head opens.
        for (text, target) in [
            (TEXT, "name = \"slide\"\n"),
            (
                "motor = { kind = \"direct\", force_n_per_v = 35.0 }\n",
                "[motor]\nkind = \"direct\"\nforce_n_per_v = 1.0\n",
            ),
            ("motor.kind = \"direct\"\n", "[motor]\nkind = \"winding\"\n"),
        ] {
            let written = written(text, target);
            assert_eq!(
                toml::from_str::<toml::Table>(&written).unwrap(),
                toml::from_str::<toml::Table>(target).unwrap()
            );
        }
    }
}
