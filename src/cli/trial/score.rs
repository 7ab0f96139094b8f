//! `slideway trial score`: what committed verdicts were worth.

mod tables;

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::error::{Error, ErrorKind};
use slideway::report::confusion::svg;
use slideway::trial::scoring::bars::Outcome;
use slideway::trial::{self, Scores, score};

use crate::cli::output::{Output, check_apart, check_outside, check_place, write};
use crate::cli::{Failure, Screen};

/// Exit code with `--exit-code` when a bar is missed.
const BAR_MISSED: u8 = 1;

/// Opens the seal, which it does for no other verdicts afterwards, and compares. Every number has a 95 % interval:
/// Wilson's for shares, bootstrap for means and medians.
///
/// Sizes are gaps in standard deviations of the noise, σ. An effect must be named from 3 σ on, and may be from 1 σ on; where
/// nothing hidden makes 1 σ, the case is a null case. The name of an equal, which nobody could tell from the effect on these
/// runs, or a reported group with the effect in it, names it. A name of nothing hidden is an extra one; with a probability of 0.9
/// or more in a verdict `cause` it is a confident wrong name. Named first: no extra name stands before.
#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 done, 2 bad input; with --exit-code 1 when a bar is missed. A bar that was not measured, or on \
                  fewer cases than it takes, is neither passed nor missed."
)]
pub(super) struct Score {
    /// Folder of the trial
    trial: PathBuf,
    /// Write the score as JSON, schema slideway-score/2; - for standard output instead of the tables
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Draw the confusion matrix, as SVG
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    /// Exit with 1 when a bar is missed
    #[arg(long)]
    exit_code: bool,
}

impl Score {
    /// Scores, writes and shows.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let to_stdout = self.json.as_ref().is_some_and(|path| path.as_os_str() == "-");
        let file = self.json.as_deref().filter(|_| !to_stdout);
        let places = [Output::file("--json", file), Output::file("--figure", self.figure.as_deref())];
        check_apart(&places, &[])?;
        check_outside(&self.trial, &places)?;
        file.iter().try_for_each(|path| check_place(path, "--json"))?;
        self.figure.iter().try_for_each(|path| check_place(path, "--figure"))?;
        let scores = score(&trial::Trial::read(&self.trial)?)?;
        if let Some(path) = &self.json {
            let text = json(&scores)?;
            if to_stdout {
                let mut stdout = io::stdout().lock();
                stdout.write_all(text.as_bytes())?;
                stdout.flush()?;
            } else {
                write(path, &text)?;
            }
        }
        if let Some(path) = &self.figure {
            let title =
                format!("Blind trial of {}, seed {} ({})", scores.machine, scores.seed, scores.purpose);
            write(path, &svg(&scores.confusion, &title))?;
        }
        if !to_stdout {
            tables::show(&scores, &mut screen.out)?;
        }
        let missed = scores.bars.iter().any(|bar| bar.outcome == Outcome::Missed);
        Ok(if self.exit_code && missed { ExitCode::from(BAR_MISSED) } else { ExitCode::SUCCESS })
    }
}

fn json(scores: &Scores) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(scores).map_err(|error| {
        Error::new(ErrorKind::Syntax)
            .key("--json")
            .found(error.to_string())
            .expected("a score that JSON can hold")
    })?;
    Ok(text + "\n")
}
