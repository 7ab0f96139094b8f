//! Where a TOML text is wrong, and what TOML says about it.

use std::path::Path;

use super::{Error, ErrorKind, spelling};

/// Line (from 1) of a byte.
pub(crate) fn line_of(text: &str, start: usize) -> u64 {
    1 + text.as_bytes().iter().take(start).filter(|byte| **byte == b'\n').count() as u64
}

/// A refusal at the place that `error` points to: file, line and what stands there.
pub(crate) fn located(kind: ErrorKind, file: &Path, text: &str, error: &toml::de::Error) -> Error {
    let refusal = Error::new(kind).file(file);
    let Some(span) = error.span() else { return refusal };
    let refusal = refusal.row(line_of(text, span.start));
    let read = text.get(span).and_then(|part| part.lines().next()).unwrap_or_default().trim();
    // A stray sign names nothing that one could look for in the line.
    if read.contains(char::is_alphanumeric) { refusal.key(read) } else { refusal }
}

/// The refusal of a text that is no TOML, or that does not hold what `error` says it must.
pub(crate) fn refusal(file: &Path, text: &str, error: &toml::de::Error) -> Error {
    let message = error.message();
    let kind = if message.starts_with("unknown field") || message.starts_with("unknown variant") {
        ErrorKind::UnknownKey
    } else if message.starts_with("missing field") {
        ErrorKind::Missing
    } else {
        ErrorKind::Syntax
    };
    let first = error.span().map_or(0, |span| span.start);
    if let Some((row, key)) = unknown_field(text, first, message) {
        return explained(Error::new(kind).file(file).row(row).key(key), message)
            .remedy("correct or remove that line of the file");
    }
    explained(located(kind, file, text, error), message).remedy("correct that line of the file")
}

/// What TOML says, shared out between what was read and what was expected.
pub(crate) fn explained(error: Error, message: &str) -> Error {
    let message = message.trim().replace('\n', " ");
    if let Some(name) = message.strip_prefix("missing field ") {
        return error.found(format!("a table without {name}")).expected(format!("{name} in it"));
    }
    if message == "duplicate key" {
        return error.found("a key or table for the second time").expected("each once");
    }
    let message = in_words(message);
    match message.split_once(", expected ") {
        Some((found, expected)) => {
            error.found(format!("{found}{}", meant(found, expected))).expected(expected)
        }
        None => error.found(message).expected("a file as README.md describes it"),
    }
}

/// What a library calls the kinds of values, in the words of a file.
fn in_words(message: String) -> String {
    let Some((found, expected)) = message.split_once(", expected ") else { return message };
    let is_word =
        found == "invalid boolean" || found == "invalid float" && ["`inf`", "`nan`"].contains(&expected);
    if is_word {
        // What begins like true, false, inf or nan is read as that: most of the time it is a text.
        return "a word without quotes, expected text in quotes, or a value".to_owned();
    }
    let whole = ["i64", "i32", "u64", "u32", "u16", "u8", "usize"];
    let is_table =
        |word: &str| ["internally tagged enum ", "struct ", "a map"].iter().any(|w| word.starts_with(w));
    let expected = match expected {
        word if whole.contains(&word) => "a whole number",
        "f64" => "a number",
        "a boolean" => "true or false",
        "a sequence" => "a list",
        word if is_table(word) => "a table",
        word => word,
    };
    let found = found.replace("invalid type: sequence", "a list").replace("invalid type: map", "a table");
    let found = found.replace("invalid type: floating point", "the number").replace("invalid type: ", "the ");
    let found = found.replace("invalid value: ", "the ");
    format!("{found}, expected {expected}")
}

/// Which of the names that TOML lists was meant by the unknown one, where one is near.
fn meant(found: &str, expected: &str) -> String {
    let quoted = |text: &'_ str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    match quoted(found).first() {
        Some(name) if found.starts_with("unknown ") => {
            spelling::hint(name, quoted(expected).iter().map(String::as_str))
        }
        _ => String::new(),
    }
}

/// Line and name of an unknown field: TOML tells the table's head only where the table is a tagged enum.
fn unknown_field(text: &str, start: usize, message: &str) -> Option<(u64, String)> {
    let name = message.strip_prefix("unknown field `")?.split('`').next()?;
    let first = line_of(text, start);
    let is_it = |line: &str| {
        let behind = line.trim_start().trim_start_matches('[').strip_prefix(name);
        behind.is_some_and(|rest| rest.trim_start().starts_with(['=', '.', ']']))
    };
    let row = (1..).zip(text.lines()).find(|(row, line)| *row >= first && is_it(line))?.0;
    Some((row, name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Axis {
        #[serde(rename = "mass_kg")]
        _mass_kg: f64,
    }

    fn refused(text: &str) -> Error {
        refusal(Path::new("axis.toml"), text, &toml::from_str::<Axis>(text).unwrap_err())
    }

    /// Words that begin like true, false, inf or nan.
    #[test]
    fn exact_a_word_without_quotes_is_told_as_that() {
        for word in ["training", "first", "in", "new_run"] {
            let error = refused(&format!("mass_kg = {word}\n")).to_string();
            assert!(error.contains("a word without quotes") && error.contains("text in quotes"), "{error}");
        }
    }

    #[test]
    fn exact_wrong_text_is_refused_with_its_line() {
        let cases = [
            ("# axis\n\nmass_kg = = 3\n", ErrorKind::Syntax, Some(3), None),
            ("# axis\nmass_kg = \"3 kg\"\n", ErrorKind::Syntax, Some(2), Some("\"3 kg\"")),
            ("mass_kg = 3.0\n\nmass_g = 1\n", ErrorKind::UnknownKey, Some(3), Some("mass_g")),
        ];
        for (text, kind, row, key) in cases {
            let error = refused(text);
            assert_eq!((error.kind(), error.row_number(), error.key_name()), (kind, row, key), "{error}");
            assert_eq!(error.path(), Some(Path::new("axis.toml")));
        }
        assert_eq!(refused("# empty\n").kind(), ErrorKind::Missing);
    }

    #[test]
    fn exact_kinds_of_values_are_told_in_the_words_of_a_file() {
        let told = |message: &str| in_words(message.to_owned());
        assert_eq!(
            told("invalid type: integer `3`, expected internally tagged enum Controller"),
            "the integer `3`, expected a table"
        );
        assert_eq!(
            told("invalid type: string \"x\", expected u64"),
            "the string \"x\", expected a whole number"
        );
        assert_eq!(told("unknown field `a`, expected `b`"), "unknown field `a`, expected `b`");
    }

    #[test]
    fn exact_unknown_field_of_a_nested_table_is_found_behind_its_head() {
        let text = "stiff = 1\n[[mode]]\nmass_kg = 1.0\nstiff = 2\n";
        let start = text.find("[[mode]]").unwrap();
        assert_eq!(unknown_field(text, start, "unknown field `stiff`"), Some((4, "stiff".to_owned())));
    }
}
