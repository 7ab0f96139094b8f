//! Errors on standard error: what was read, where, and what to do, with the line of a TOML file beside it.

use std::fmt;
use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;

use miette::{Diagnostic, LabeledSpan, MietteHandlerOpts, NamedSource, SourceCode};
use slideway::error::Error;

use super::BAD_INPUT;

/// A file with longer lines is not shown beside its error, in bytes.
const LONGEST_LINE: usize = 400;

/// An [`Error`] as miette shows it.
#[derive(Debug)]
struct Refusal {
    error: Error,
    source: Option<NamedSource<String>>,
    label: Option<LabeledSpan>,
}

/// Tells the error and returns the exit code that goes with it.
pub(super) fn tell(error: &Error) -> ExitCode {
    let terminal = std::io::stderr().is_terminal();
    // A log keeps one line a sentence, so that paths in it can be searched for.
    let hook = miette::set_hook(Box::new(move |_| {
        let options = MietteHandlerOpts::new().break_words(false);
        let options = if terminal { options } else { options.color(false).wrap_lines(false) };
        Box::new(options.build())
    }));
    // The hook is set once a process; where it stands already, so does its layout.
    drop(hook);
    let report = miette::Report::new(Refusal::new(error.clone()));
    // Nobody is left to be told when standard error is closed too.
    let _ = writeln!(std::io::stderr(), "{report:?}");
    ExitCode::from(BAD_INPUT)
}

impl Refusal {
    fn new(error: Error) -> Self {
        match Self::line_of_toml(&error) {
            Some((source, label)) => Self { error, source: Some(source), label: Some(label) },
            None => Self { error, source: None, label: None },
        }
    }

    /// The text of a TOML file and the place in it: the key in its line, or the whole line.
    fn line_of_toml(error: &Error) -> Option<(NamedSource<String>, LabeledSpan)> {
        let path = error.path()?;
        if path.extension().is_none_or(|ending| ending != "toml") {
            return None;
        }
        let row = usize::try_from(error.row_number()?).ok()?.checked_sub(1)?;
        let text = std::fs::read_to_string(path).ok()?;
        // Long lines hide the message, and others than texts are none.
        if text.split('\n').any(|line| line.len() > LONGEST_LINE) {
            return None;
        }
        let text: String = text.chars().map(|c| if c.is_control() && c != '\n' { ' ' } else { c }).collect();
        let line = text.split_inclusive('\n').nth(row)?;
        let start: usize = text.split_inclusive('\n').take(row).map(str::len).sum();
        let key = error.key_name().and_then(|key| key.rsplit('.').next()).unwrap_or_default();
        let (offset, length) = match line.find(key) {
            Some(at) if !key.is_empty() => (at, key.len()),
            _ => (0, line.trim_end().len()),
        };
        let label = LabeledSpan::new(Some("here".to_owned()), start + offset, length);
        Some((NamedSource::new(path.display().to_string(), text), label))
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.error.statement())
    }
}

impl std::error::Error for Refusal {}

impl Diagnostic for Refusal {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.error.remedy_text().map(|remedy| Box::new(remedy) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.label.as_ref().map(|label| Box::new(std::iter::once(label.clone())) as Box<_>)
    }
}
