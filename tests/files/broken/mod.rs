//! The table of broken inputs: what is broken, which file is at fault, and with which command it is tried.
#![allow(clippy::unwrap_used)]
#![allow(clippy::too_many_lines, reason = "tables are long")]

mod machines;
mod recordings;
mod words;

use std::path::Path;

/// What may become of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expected {
    /// It is refused.
    Refusal,
    /// It is refused, or it is sound after all.
    Either,
    /// It is sound: what the others were made from.
    Acceptance,
}

/// One broken input.
#[derive(Debug)]
pub struct Case {
    pub name: String,
    /// Files in a folder of its own, in which the command runs.
    pub files: Vec<(String, Vec<u8>)>,
    pub arguments: Vec<String>,
    /// A word that the message must have: the file at fault.
    pub at_fault: &'static str,
    pub expected: Expected,
}

impl Case {
    fn new(
        name: impl Into<String>,
        files: Vec<(String, Vec<u8>)>,
        arguments: &[&str],
        at_fault: &'static str,
    ) -> Self {
        let arguments = arguments.iter().map(|argument| (*argument).to_owned()).collect();
        Self { name: name.into(), files, arguments, at_fault, expected: Expected::Refusal }
    }

    fn sound(self) -> Self {
        Self { expected: Expected::Acceptance, ..self }
    }

    fn either(self) -> Self {
        Self { expected: Expected::Either, ..self }
    }
}

/// A text file.
fn file(name: &str, text: impl Into<Vec<u8>>) -> (String, Vec<u8>) {
    (name.to_owned(), text.into())
}

/// A file of a machine that ships with the program.
fn shipped(file: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file)).unwrap()
}

/// Every case.
pub fn cases() -> Vec<Case> {
    [recordings::cases(), machines::cases(), machines::solids(), machines::meshes(), words::cases()]
        .into_iter()
        .flatten()
        .collect()
}
