//! `slideway trial run`: verdicts on forged cases, committed before the truth is known.

use std::io::Write as _;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::trial::{self, run};

use super::all_cores;
use crate::cli::count::jobs;
use crate::cli::{Failure, Screen};

/// Diagnoses every case that has no committed verdict yet, one core a case, and commits each verdict with its SHA-256 as
/// it comes. Nothing sealed is read. Once the seal is open, nothing is committed any more.
#[derive(Debug, Args)]
pub(super) struct Run {
    /// Folder of the trial
    trial: PathBuf,
    /// Cases at a time [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = jobs)]
    jobs: Option<NonZeroUsize>,
}

impl Run {
    /// Diagnoses, and tells how many verdicts stand.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let trial = trial::Trial::read(&self.trial)?;
        let bar = screen.progress(trial.announcement.cases as u64, "diagnosing");
        let ran = run(&trial, self.jobs.unwrap_or_else(all_cores), &|_| bar.inc(1));
        bar.finish_and_clear();
        let ran = ran?;
        writeln!(
            screen.out,
            "{} verdicts committed, {} before; next: slideway trial score {}",
            ran.diagnosed,
            ran.committed_before,
            self.trial.display()
        )?;
        Ok(ExitCode::SUCCESS)
    }
}
