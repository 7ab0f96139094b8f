//! `slideway trial`: the diagnosis checked on data whose effect is withheld.

mod forge;
mod run;
mod score;

use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::{Failure, Screen};

/// Three steps, each a command: `forge` draws machines with hidden effects, seals the truth, prints its hash and
/// simulates recordings; `run` diagnoses them and commits the verdicts without opening the seal; `score` opens it against
/// the committed verdicts. Everything follows from the seed. A step that was killed goes on where it was when the same
/// command is given again.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  slideway trial forge --machine models/MACHINE --seed 7 --out /tmp/trial\n  \
                        slideway trial run /tmp/trial\n  \
                        slideway trial score /tmp/trial --json score.json --figure confusion.svg"
)]
pub(super) struct Trial {
    #[command(subcommand)]
    step: Step,
}

#[derive(Debug, Subcommand)]
enum Step {
    /// Draw machines with hidden effects, seal the truth, simulate recordings
    Forge(forge::Forge),
    /// Diagnose the recordings and commit the verdicts
    Run(run::Run),
    /// Open the seal against the committed verdicts and score them
    Score(score::Score),
}

impl Trial {
    /// Runs the step.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        match &self.step {
            Step::Forge(forge) => forge.run(screen),
            Step::Run(run) => run.run(screen),
            Step::Score(score) => score.run(screen),
        }
    }
}

/// Cores to work on where the user does not say.
fn all_cores() -> std::num::NonZeroUsize {
    std::thread::available_parallelism().unwrap_or(std::num::NonZeroUsize::MIN)
}
