//! `slideway signals`: what an axis can log, or one of the signals.

use std::io::Write as _;
use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use slideway::recording::{Signal, TIME_KEY};
use slideway::report::{signal_list, signal_sheet};

use super::{Failure, Screen, style};

/// Lists the signals that a recording may hold, in the order of the signal path, with their columns and SI units. With a
/// name: what the signal is, the units that its column may have, and a line for recording.toml.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway signals\n  slideway signals position_m")]
pub(super) struct Signals {
    /// Column name of a signal
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(Signal::keys(None)), hide_possible_values = true)]
    name: Option<String>,
}

impl Signals {
    /// Shows the list, or the signal.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let text = match &self.name {
            Some(name) if name != TIME_KEY => Signal::from_key(name)
                .map_or_else(|| signal_list(style()), |(signal, _)| signal_sheet(signal, style())),
            _ => signal_list(style()),
        };
        write!(screen.out, "{text}")?;
        Ok(ExitCode::SUCCESS)
    }
}
