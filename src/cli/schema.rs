//! `slideway schema`: the JSON Schema of a TOML file, for editors.

use std::io::Write as _;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::{Failure, Screen};

/// Prints the JSON Schema of `machine.toml` or `recording.toml`. An editor with a TOML language server completes keys
/// and shows what they mean when the first line of the file names it: `#:schema PATH`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway schema machine > machine.schema.json\n  \
                        # then, as the first line of machine.toml:\n  #:schema machine.schema.json")]
pub(super) struct Schema {
    /// File that the schema describes
    #[arg(value_name = "FILE")]
    of: File,
}

/// A file that people write.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum File {
    /// A machine folder's machine.toml
    Machine,
    /// A recording's recording.toml
    Recording,
}

impl Schema {
    /// Shows the schema.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let schema = match self.of {
            File::Machine => slideway::machine::schema(),
            File::Recording => slideway::recording::schema(),
        };
        writeln!(screen.out, "{schema:#}")?;
        Ok(ExitCode::SUCCESS)
    }
}
