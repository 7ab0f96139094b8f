//! `slideway ladder`: what each term of a feed-forward leaves to the feedback.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::diagnose::{Options, Progress, diagnose};
use slideway::error::Error;
use slideway::machine::Machine;
use slideway::recording::Recording;
use slideway::replay::Ladder;
use slideway::report::{html, ladder, sentence};

use super::output::{Pictures, command_line, given};
use super::setting::{Setting, set};
use super::subject::{machine_of, runs_of};
use super::{Failure, Screen, advance, style};

/// Replays a recording's references with nothing fed forward, then inertia, viscous and Coulomb friction (and weight, where the
/// machine has any) one after the other, with the machine's own numbers, and shows what the feedback is left to command;
/// beside it what runs measured that state a `feedforward`. The machine needs friction to tell anything of it:
/// `slideway diagnose --write-machine` writes one, and --diagnose finds it from a recording at once.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway diagnose recordings/LOG --write-machine diagnosed\n  \
                        slideway ladder recordings/LOG --machine diagnosed\n  \
                        slideway ladder recordings/STAGES --diagnose recordings/LOG")]
pub(super) struct LadderCommand {
    /// Recording: a folder with recording.toml, or such a file
    recording: PathBuf,
    /// Machine folder, or a machine file [default: the one that the recording names]
    #[arg(long, value_name = "DIR")]
    machine: Option<PathBuf>,
    /// Diagnose this recording first, and take the machine with the causes and the calibration that explain it best
    #[arg(long, value_name = "RECORDING")]
    diagnose: Option<PathBuf>,
    /// Run of the recording; otherwise all
    #[arg(long, value_name = "NAME")]
    run: Option<String>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    #[command(flatten)]
    pictures: Pictures,
}

impl LadderCommand {
    /// Replays and shows.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let mut inputs = given([&self.machine, &self.diagnose]);
        inputs.push(&self.recording);
        self.pictures.check_places(&[], &inputs)?;
        let recording = Recording::read(&self.recording)?;
        let machine = set(&machine_of(&recording, self.machine.as_ref())?, &self.settings)?;
        let runs = runs_of(&recording, self.run.as_deref())?;
        let (machine, named) = self.diagnosed(machine, screen)?;
        let found = Ladder::of(&runs, &machine)
            .map_err(|error| if error.path().is_some() { error } else { error.file(&recording.path) })?;
        let mut sheet = ladder(&found, &machine, &recording, runs.len());
        if let Some(named) = named {
            sheet.sentence = format!("{named} {}", sheet.sentence);
        }
        write!(screen.out, "{}", sheet.text(style()))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::sheet(&sheet, &command_line()), screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// The machine as the diagnosis that was asked for improves it, and what that found.
    fn diagnosed(&self, machine: Machine, screen: &Screen) -> Result<(Machine, Option<String>), Error> {
        let Some(path) = &self.diagnose else { return Ok((machine, None)) };
        let recording = Recording::read(path)?;
        let bar = screen.hypotheses();
        let progress = |progress: Progress| advance(&bar, progress);
        let found = diagnose(&machine, &recording, &Options { progress: &progress, ..Options::default() });
        bar.finish_and_clear();
        let found = found?;
        let said = format!("{}, diagnosed: {}", recording.path.display(), sentence(&found, machine.motion()));
        Ok((found.improved(&machine)?, Some(said)))
    }
}
