//! A TOML text whose every key knows its line, so that a refusal can name it.

use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};

use crate::error::toml_text::{self, line_of};
use crate::error::{Error, ErrorKind, Result, spelling};

/// One step of a key path: a key, or an index into an array of tables.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// A parsed TOML file: the values, and the text to find lines in.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) path: PathBuf,
    pub(super) values: toml::Table,
    text: String,
}

impl Document {
    /// Parses a text; a syntax error is refused with its line.
    pub(super) fn parse(path: &Path, text: String) -> Result<Self> {
        let values = text.parse::<toml::Table>().map_err(|error| {
            toml_text::located(ErrorKind::Syntax, path, &text, &error)
                .found(format!("a syntax error ({})", error.message().trim().replace('\n', ", ")))
                .expected("valid TOML")
                .remedy("correct that line")
        })?;
        Ok(Self { path: path.to_path_buf(), values, text })
    }

    /// The text as it was read.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// A refusal at a key path: file, line and dotted key.
    pub(super) fn refuse(&self, kind: ErrorKind, steps: &[Step<'_>]) -> Error {
        let key = steps
            .iter()
            .map(|step| match step {
                Step::Key(key) => (*key).to_owned(),
                Step::Index(index) => (index + 1).to_string(),
            })
            .collect::<Vec<_>>()
            .join(".");
        let error = Error::new(kind).file(&self.path);
        let error = match self.line(steps) {
            Some(line) => error.row(line),
            None => error,
        };
        if key.is_empty() { error } else { error.key(key) }
    }

    /// A value of the wrong kind.
    pub(super) fn wrong_type(&self, steps: &[Step<'_>], found: &toml::Value, expected: &str) -> Error {
        let read = match found {
            toml::Value::Array(_) => "a list".to_owned(),
            toml::Value::Table(_) => "a table".to_owned(),
            plain => format!("the {} {plain}", plain.type_str()),
        };
        self.refuse(ErrorKind::Syntax, steps).found(read).expected(expected).remedy("correct that line")
    }

    /// A key that is not known at this place.
    pub(super) fn unknown_key(&self, steps: &[Step<'_>], name: &str, known: &[&str]) -> Error {
        let hint = spelling::hint(name, known.iter().copied());
        self.refuse(ErrorKind::UnknownKey, steps)
            .found(format!("unknown key `{name}`{hint}"))
            .expected(format!("one of {}", known.join(", ")))
            .remedy("correct or remove it")
    }

    /// The line (from 1) of a key path, as far as it exists.
    fn line(&self, steps: &[Step<'_>]) -> Option<u64> {
        let parsed = DeTable::parse(&self.text).ok()?;
        let root = DeValue::Table(parsed.into_inner());
        let (mut value, mut at) = (&root, None);
        for step in steps {
            let found = match step {
                Step::Key(key) => {
                    value.as_table()?.iter().find(|(name, _)| name.get_ref() == key).map(|(name, inner)| {
                        // Keys of an array of tables share one name; its elements carry the lines.
                        (name.span().start, inner.get_ref())
                    })
                }
                Step::Index(index) => value
                    .as_array()
                    .and_then(|array| array.get(*index))
                    .map(|inner| (inner.span().start, inner.get_ref())),
            };
            let Some((start, inner)) = found else { break };
            (value, at) = (inner, Some(start));
        }
        at.map(|start| line_of(&self.text, start))
    }
}

/// A number, whole or not.
pub(super) fn number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// An optional text.
pub(super) fn text_at<'a>(
    document: &Document,
    table: &'a toml::Table,
    base: &[Step<'_>],
    key: &str,
) -> Result<Option<&'a str>> {
    let Some(value) = table.get(key) else { return Ok(None) };
    value.as_str().map(Some).ok_or_else(|| {
        let steps = [base, &[Step::Key(key)]].concat();
        document.wrong_type(&steps, value, "a text in quotes")
    })
}
