//! The score as tables of at most [`WIDTH`] columns.

use std::io::{self, Write};

use slideway::report::confusion::table as confusion;
use slideway::report::wrap;
use slideway::trial::scoring::interval::{Level, Rate};
use slideway::trial::scoring::summary::{ByTier, Tally};
use slideway::trial::{Scores, Tier};

use crate::cli::table::Table;

/// Columns of the screen.
const WIDTH: usize = 100;
/// Most tiers that stand beside one another.
const ABREAST: usize = 4;
/// From so many seconds on, no fraction is shown.
const WHOLE_SECONDS: f64 = 10.0;

/// Shows a score.
pub(super) fn show(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
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
    writeln!(out, "\nBars:")?;
    bars(scores, out)?;
    writeln!(out, "\nEvery tier, with 95 % intervals (parameter error, gap closed, seconds: medians):")?;
    out.extend(tiers(&scores.tiers)?);
    section(!scores.bands.is_empty(), "By size, the smallest planned gap; shares in %:", out)?;
    bands(scores, out)?;
    section(!scores.effects.is_empty(), "Single cases by planned effect; shares in %:", out)?;
    effects(scores, out)?;
    section(!scores.nulls.is_empty(), "Null cases, in which nothing hidden makes 1 σ:", out)?;
    nulls(scores, out)?;
    reliability(scores, out)?;
    section(
        !scores.confusion.rows.is_empty(),
        "What was named first (one effect planned, catalogue whole):",
        out,
    )?;
    if !scores.confusion.rows.is_empty() {
        out.extend(confusion(&scores.confusion, WIDTH).into_bytes());
    }
    cases(scores, out)?;
    for skipped in &scores.skipped {
        paragraph(&format!("not forged: {}: {}", skipped.effect.name(), skipped.reason), 0, out)?;
    }
    Ok(())
}

fn section(has_any: bool, title: &str, out: &mut Vec<u8>) -> io::Result<()> {
    if has_any { writeln!(out, "\n{title}") } else { Ok(()) }
}

/// A share in percent with its interval.
fn percent(rate: &Rate) -> String {
    interval(rate.value, rate.ci95, 100.0, 0, " %")
}

/// The same under a head that says so.
fn bare(rate: &Rate) -> String {
    interval(rate.value, rate.ci95, 100.0, 0, "")
}

fn level(level: &Level, decimals: usize) -> String {
    interval(level.value, level.ci95, 1.0, decimals, "")
}

fn seconds(taken: &Level) -> String {
    level(taken, if taken.value.is_some_and(|value| value >= WHOLE_SECONDS) { 0 } else { 1 })
}

/// A share in percent to a tenth, under a name that says so.
fn parameter_error(error: &Level) -> String {
    interval(error.value, error.ci95, 100.0, 1, "")
}

fn interval(value: Option<f64>, ci95: Option<[f64; 2]>, scale: f64, decimals: usize, unit: &str) -> String {
    match (value, ci95) {
        (Some(value), Some([from, to])) => format!(
            "{:.decimals$}{unit} ({:.decimals$}–{:.decimals$})",
            scale * value,
            scale * from,
            scale * to
        ),
        _ => "-".to_owned(),
    }
}

fn bars(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    let mut table = Table::new(["", "measured (95 %)", "bar", "cases", ""]);
    for bar in &scores.bars {
        let cases = if bar.needs > 1 { format!("{} of {}", bar.of, bar.needs) } else { bar.of.to_string() };
        table.row([
            bar.name.to_owned(),
            interval(bar.value, bar.ci95, 100.0, 1, " %"),
            bar.limit.to_string(),
            cases,
            bar.outcome.words().to_owned(),
        ]);
    }
    table.write(out)
}

/// A row of the tiers' table: its name, what it shows, and whether the null tier has it, and the tier outside.
type Row = (&'static str, fn(&Tally) -> String, bool, bool);

const ROWS: [Row; 19] = [
    ("cases", |t| t.cases.to_string(), true, true),
    ("right", |t| percent(&t.right), true, true),
    ("named first", |t| percent(&t.top_1), false, false),
    ("  without equals", |t| percent(&t.top_1_without_equals), false, false),
    ("among the first two", |t| percent(&t.top_2), false, false),
    ("all planned named", |t| percent(&t.planned_named), false, false),
    ("all from 3 σ named", |t| percent(&t.all_named), true, false),
    ("nothing extra named", |t| percent(&t.nothing_extra), true, true),
    ("has equals, cases", |t| t.with_equals.of.to_string(), false, false),
    ("  itself or equal named", |t| percent(&t.with_equals), false, false),
    ("confident wrong names", |t| percent(&t.confident_wrong), true, true),
    ("unknown or undecided", |t| percent(&t.flagged), true, true),
    ("site right", |t| percent(&t.site), true, true),
    ("probability on truth", |t| level(&t.probability, 2), false, false),
    ("parameter error, %", |t| parameter_error(&t.parameter_error), false, false),
    ("truth in 95 % intervals", |t| level(&t.covered, 2), true, true),
    ("gap closed", |t| level(&t.closed, 2), true, true),
    ("predicted within ±0.1", |t| percent(&t.predicted_within), true, true),
    ("seconds on one core", |t| seconds(&t.seconds), true, true),
];

/// Every tier, as many beside one another as the screen has room for.
fn tiers(summaries: &[ByTier]) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    for abreast in (1..=ABREAST).rev() {
        out.clear();
        for (k, few) in summaries.chunks(abreast).enumerate() {
            out.extend(if k > 0 { b"\n".as_slice() } else { b"" });
            columns(few, &mut out)?;
        }
        if String::from_utf8_lossy(&out).lines().all(|line| line.chars().count() <= WIDTH) {
            break;
        }
    }
    Ok(out)
}

/// One column a tier, one row a number.
fn columns(abreast: &[ByTier], out: &mut Vec<u8>) -> io::Result<()> {
    let heads = abreast.iter().map(|summary| summary.tier.name().to_owned());
    let mut table = Table::of(std::iter::once(String::new()).chain(heads).collect());
    for (name, cell, in_null, in_outside) in ROWS {
        let one = |summary: &ByTier| match summary.tier {
            Tier::Null if !in_null => "-".to_owned(),
            Tier::Outside if !in_outside => "-".to_owned(),
            _ => cell(&summary.tally),
        };
        table.cells(std::iter::once(name.to_owned()).chain(abreast.iter().map(one)).collect());
    }
    table.write(out)
}

const SHARES: [&str; 5] = ["cases", "first", "all", "no extra", "probability"];

fn shares(tally: &Tally) -> [String; 5] {
    [
        tally.cases.to_string(),
        bare(&tally.top_1),
        bare(&tally.planned_named),
        bare(&tally.nothing_extra),
        level(&tally.probability, 2),
    ]
}

fn bands(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    if scores.bands.is_empty() {
        return Ok(());
    }
    let heads = ["tier", "gap"].into_iter().chain(SHARES).map(str::to_owned).collect();
    let mut table = Table::of(heads).left(2);
    for summary in &scores.bands {
        let names = [summary.tier.name().to_owned(), summary.band.name().to_owned()];
        table.cells(names.into_iter().chain(shares(&summary.tally)).collect());
    }
    table.write(out)
}

fn effects(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    if scores.effects.is_empty() {
        return Ok(());
    }
    let heads = std::iter::once("effect").chain(SHARES).map(str::to_owned).collect();
    let mut table = Table::of(heads);
    for summary in &scores.effects {
        table.cells(std::iter::once(summary.effect.to_owned()).chain(shares(&summary.tally)).collect());
    }
    table.write(out)
}

fn nulls(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    if scores.nulls.is_empty() {
        return Ok(());
    }
    let mut table = Table::new(["tier", "cases", "false alarms", "a false name", "none, but not no_gap"]);
    for summary in &scores.nulls {
        table.row([
            summary.tier.map_or("all", Tier::name).to_owned(),
            summary.false_alarms.of.to_string(),
            percent(&summary.false_alarms),
            percent(&summary.false_names),
            percent(&summary.other_verdicts),
        ]);
    }
    table.write(out)
}

fn reliability(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    let reliability = &scores.reliability;
    let Some((brier, error)) = reliability.brier_score.zip(reliability.expected_calibration_error) else {
        return Ok(());
    };
    writeln!(
        out,
        "\nReliability of {} stated probabilities (Brier score {brier:.3}, expected calibration error {error:.3}):",
        reliability.statements
    )?;
    let mut table = Table::new(["stated", "number", "mean stated", "true of them"]);
    for bin in &reliability.bins {
        table.row([
            format!("{}–{}", bin.from, bin.to),
            bin.share_true.of.to_string(),
            bin.stated.map_or_else(|| "-".to_owned(), |stated| format!("{stated:.3}")),
            percent(&bin.share_true),
        ]);
    }
    table.write(out)
}

/// Confident wrong names, each; then the worst of the other wrong cases.
fn cases(scores: &Scores, out: &mut Vec<u8>) -> io::Result<()> {
    let wrong = &scores.confident_wrong;
    section(true, &format!("Confident wrong names: {}", wrong.len()), out)?;
    for name in wrong {
        let what = format!("{:>4} {}: {} {:.3}", name.case, name.tier, name.effect, name.probability);
        writeln!(out, "  {what}")?;
        paragraph(&name.story, 7, out)?;
    }
    let worst = scores.worst();
    section(!worst.is_empty(), "The worst of the other wrong cases:", out)?;
    for case in worst {
        writeln!(out, "  {:>4} {}", case.case, case.tier)?;
        paragraph(&case.story, 7, out)?;
    }
    Ok(())
}

fn paragraph(text: &str, indent: usize, out: &mut dyn Write) -> io::Result<()> {
    wrap(text, WIDTH - indent).iter().try_for_each(|line| writeln!(out, "{:indent$}{line}", ""))
}
