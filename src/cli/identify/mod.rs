//! `slideway identify`: what a recording or a machine's solid model tells of the axis, one identifier a file.

mod gains;
mod transfer;

use std::process::ExitCode;

use clap::{Args, Subcommand};
use slideway::error::{Error, ErrorKind};
use slideway::recording::{Recording, Run};

use super::{Failure, Screen};

/// A transfer function by ARX, or one of the other identifiers by its name.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "Examples:\n  slideway identify --machine models/MACHINE\n  \
                        slideway identify recordings/LOG --input thrust_n --output velocity_m_per_s --period 0.025")]
pub(super) struct Identify {
    #[command(subcommand)]
    kind: Option<Kind>,
    #[command(flatten)]
    transfer: transfer::Transfer,
}

/// A new identifier is a file here, a line in this list and one in [`Identify::run`].
#[derive(Debug, Subcommand)]
enum Kind {
    /// The gains that a controller ran with, from its recorded signals
    Gains(gains::Gains),
}

impl Identify {
    /// Identifies and prints.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        match &self.kind {
            Some(Kind::Gains(gains)) => gains.run(screen),
            None => self.transfer.run(screen),
        }
    }
}

/// The run of that name, or all runs.
fn runs_of<'a>(recording: &'a Recording, name: Option<&str>) -> Result<Vec<&'a Run>, Error> {
    let Some(name) = name else { return Ok(recording.runs().iter().collect()) };
    let run = recording.run(name).ok_or_else(|| {
        let names: Vec<&str> = recording.runs().iter().map(Run::name).collect();
        Error::new(ErrorKind::Missing)
            .file(&recording.path)
            .key("--run")
            .found(format!("`{name}`"))
            .expected(format!("one of {}", names.join(", ")))
            .remedy("name a run of the recording, or leave --run out for all")
    })?;
    Ok(vec![run])
}
