//! `slideway crosscheck`: the same strokes on every plant, differences held against bounds.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::machine::Machine;
use slideway::replay::Cell;
use slideway::replay::crosscheck::{Crosscheck, cells_of};
use slideway::report::{crosscheck, html};

use super::output::{Pictures, command_line};
use super::setting::{Setting, set};
use super::{Failure, Screen, style};

/// Exit code where a bound is exceeded, as `diff` has it.
const EXCEEDED: u8 = 1;

/// Replays strokes on the reduced axis, the rigid-body scene and, where this program was built with it, MuJoCo;
/// compares position, velocity, thrust and slider loads, and what needs no replay: masses, loads at rest,
/// oscillations. The exit code is 1 where a difference exceeds its bound.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  slideway crosscheck models/MACHINE --html crosscheck.html")]
pub(super) struct CrosscheckCommand {
    /// Machine folder, or a machine file
    machine: PathBuf,
    /// Strokes at feeds: m@m/min, or rad@rad/s for a turning axis [default: those of the machine file's
    /// table [crosscheck], otherwise four of the axis' own size]
    #[arg(long = "cell", value_name = "STROKE@FEED", num_args = 1..)]
    cells: Vec<Cell>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    #[command(flatten)]
    pictures: Pictures,
}

impl CrosscheckCommand {
    /// Replays, compares, shows.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        self.pictures.check_places(&[], &[&self.machine])?;
        let machine = Machine::read(&self.machine)?;
        let machine = set(&machine, &self.settings)?;
        let cells = if self.cells.is_empty() { cells_of(&machine)? } else { self.cells.clone() };
        let check = Crosscheck::of(&machine, &cells)?;
        let progress = screen.progress(check.samples() as u64, "replaying");
        let outcome = check.run(|samples| progress.inc(samples as u64));
        progress.finish_and_clear();
        let outcome = outcome?;
        write!(screen.out, "{}", crosscheck(&outcome, &machine, style()))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::crosschecked(&outcome, &machine, &command_line()), screen)?;
        }
        Ok(if outcome.is_within() { ExitCode::SUCCESS } else { ExitCode::from(EXCEEDED) })
    }
}
