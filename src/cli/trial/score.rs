//! `slideway trial score`: what committed verdicts were worth.

use std::io::{self, Write as _};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::error::{Error, ErrorKind};
use slideway::report::confusion::{svg, table};
use slideway::trial::bars::{BEST_PUBLIC_PROBABILITY, Bar};
use slideway::trial::interval::{Level, Rate};
use slideway::trial::score::{BySize, Summary};
use slideway::trial::{self, Scores, score};

use crate::cli::output::{check_place, write};
use crate::cli::table::Table;
use crate::cli::{Failure, Screen};

/// Exit code with `--exit-code` when a bar is missed.
const BAR_MISSED: u8 = 1;

/// Opens the seal, which it does for no other verdicts afterwards, and compares. Every number has a 95 % interval:
/// Wilson's for shares, bootstrap for means and medians. A hidden effect counts as named where it is reported as one that
/// could stand in the place of the cause named.
#[derive(Debug, Args)]
#[command(after_help = "Exit codes: 0 done, 2 bad input; with --exit-code 1 when a bar is missed.")]
pub(super) struct Score {
    /// Folder of the trial
    trial: PathBuf,
    /// Write the score as JSON, schema slideway-score/1; - for standard output instead of the tables
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
        if let (Some(path), false) = (&self.json, to_stdout) {
            check_place(path, "--json")?;
        }
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
            show(&scores, screen)?;
        }
        let missed = scores.bars.iter().any(|bar| bar.is_reached() == Some(false));
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

fn percent(rate: &Rate) -> String {
    match (rate.value, rate.ci95) {
        (Some(value), Some([from, to])) => {
            format!("{:.0} % ({:.0}–{:.0})", 100.0 * value, 100.0 * from, 100.0 * to)
        }
        _ => "-".to_owned(),
    }
}

fn level(level: &Level, decimals: usize) -> String {
    match (level.value, level.ci95) {
        (Some(value), Some([from, to])) => format!("{value:.decimals$} ({from:.decimals$}–{to:.decimals$})"),
        _ => "-".to_owned(),
    }
}

fn show(scores: &Scores, screen: &mut Screen) -> Result<(), Failure> {
    let out = &mut screen.out;
    writeln!(
        out,
        "Blind trial of {}, {} cases, seed {} ({}), forged on {}",
        scores.machine,
        scores.cases.len(),
        scores.seed,
        scores.purpose,
        scores.engine
    )?;
    if scores.purpose == "development" {
        writeln!(out, "A development seed: the diagnosis may have been changed with these cases in sight.")?;
    }
    writeln!(out, "\nEvery tier, with 95 % intervals:")?;
    tiers(scores, out)?;
    if !scores.sizes.is_empty() {
        writeln!(out, "\nSingle effects by size (the gap that the effect alone makes, in units of noise):")?;
        sizes(&scores.sizes, out)?;
    }
    if !scores.bars.is_empty() {
        writeln!(out, "\nBars:")?;
        bars(&scores.bars, out)?;
        writeln!(out, "  (best public mean probability on the true cause: {BEST_PUBLIC_PROBABILITY})")?;
    }
    if !scores.confusion.rows.is_empty() {
        writeln!(out, "\nWhat was named for what (one effect hidden, catalogue whole):")?;
        out.extend(table(&scores.confusion).into_bytes());
    }
    for skipped in &scores.skipped {
        writeln!(out, "not forged: {}: {}", skipped.effect.name(), skipped.reason)?;
    }
    writeln!(out, "\nThe worst cases:")?;
    for case in scores.worst() {
        let mark = if case.is_right() { "right" } else { "WRONG" };
        writeln!(out, "  {:>3} {} {mark}: {}", case.case, case.tier, case.story)?;
    }
    Ok(())
}

/// One column a tier, one row a number.
fn tiers(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    type Cell = fn(&Summary) -> String;
    let rows: [(&str, Cell); 16] = [
        ("cases", |s| s.cases.to_string()),
        ("top-1", |s| percent(&s.top_1)),
        ("top-2", |s| percent(&s.top_2)),
        ("named alone, by its name", |s| percent(&s.exact)),
        ("all hidden named", |s| percent(&s.all_named)),
        ("something else named too", |s| percent(&s.extra)),
        ("false alarms", |s| percent(&s.false_alarms)),
        ("  with a cause named", |s| percent(&s.false_causes)),
        ("unknown or undecided", |s| percent(&s.flagged)),
        ("site right", |s| percent(&s.site)),
        ("probability on the truth, mean", |s| level(&s.probability, 2)),
        ("gap closed, median", |s| level(&s.closed, 3)),
        ("predicted within ±0.1", |s| percent(&s.predicted_within)),
        ("parameter error, median", |s| level(&s.parameter_error, 3)),
        ("truth inside its interval", |s| level(&s.covered, 2)),
        ("seconds a case on one core", |s| level(&s.seconds, 1)),
    ];
    let applies = |name: &str, s: &Summary| match s.tier {
        trial::Tier::Null => {
            ["cases", "false alarms", "  with a cause named", "seconds a case on one core"].contains(&name)
        }
        trial::Tier::Outside => [
            "cases",
            "unknown or undecided",
            "site right",
            "gap closed, median",
            "predicted within ±0.1",
            "seconds a case on one core",
        ]
        .contains(&name),
        _ => !name.starts_with("false") && !name.starts_with("  "),
    };
    for summary in &scores.tiers {
        let mut table = Table::new([summary.tier.name(), ""]).left(2);
        for (name, cell) in &rows {
            if applies(name, summary) {
                table.row([(*name).to_owned(), cell(summary)]);
            }
        }
        table.write(out)?;
    }
    Ok(())
}

fn sizes(sizes: &[BySize], out: &mut Vec<u8>) -> io::Result<()> {
    let mut table = Table::new(["gap", "cases", "top-1", "top-2", "probability", "closed"]);
    for size in sizes {
        table.row([
            size.to.map_or(format!("from {:.0}", size.from), |to| format!("{:.0}–{to:.0}", size.from)),
            size.cases.to_string(),
            percent(&size.top_1),
            percent(&size.top_2),
            level(&size.probability, 2),
            level(&size.closed, 3),
        ]);
    }
    table.write(out)
}

fn bars(bars: &[Bar], out: &mut Vec<u8>) -> io::Result<()> {
    let mut table = Table::new(["", "tier", "measured", "bar", "cases", ""]).left(2);
    for bar in bars {
        let sign = if bar.at_most { "≤" } else { "≥" };
        let verdict = match bar.is_reached() {
            Some(true) => "pass",
            Some(false) => "MISS",
            None => "not measured",
        };
        let measured = match (bar.value, bar.ci95) {
            (Some(value), Some([from, to])) => format!("{value:.3} ({from:.3}–{to:.3})"),
            _ => "-".to_owned(),
        };
        table.row([
            bar.name.to_owned(),
            bar.tier.to_string(),
            measured,
            format!("{sign} {}", bar.bar),
            bar.of.to_string(),
            verdict.to_owned(),
        ]);
    }
    table.write(out)
}
