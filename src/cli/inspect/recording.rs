//! What is in a recording.

use std::io::Write;

use slideway::recording::{PeriodSource, Recording, Run, Signal, Split, SplitRule};
use slideway::report::{stretches, wrap};
use slideway::units::{Motion, Unit, engineering};

use crate::cli::table::Table;
use crate::cli::{Failure, style};

/// Before the note; further lines of it stand below its first.
const NOTE: &str = "note       ";

/// Shows a recording.
pub(super) fn show(recording: &Recording, out: &mut dyn Write) -> Result<(), Failure> {
    writeln!(out, "recording  {}", recording.path.display())?;
    let note = wrap(recording.note.as_deref().unwrap_or("none"), style().width.saturating_sub(NOTE.len()));
    writeln!(out, "{NOTE}{}", note.join(&format!("\n{:1$}", "", NOTE.len())))?;
    let machine = recording.machine.as_ref().map_or("none named".to_owned(), |m| m.display().to_string());
    writeln!(out, "machine    {machine}")?;
    writeln!(out, "axis       {}", recording.motion())?;
    writeln!(out, "period     {}", engineering(recording.sample_period_s(), "s"))?;
    writeln!(out, "sha256     {}", recording.sha256())?;
    runs(recording, out)?;
    details(recording, out)?;
    signals(recording, out)?;
    columns(recording, out)
}

fn runs(recording: &Recording, out: &mut dyn Write) -> Result<(), Failure> {
    let split = recording.split_within(SplitRule::default(), usize::MAX);
    let held_out = split.as_ref().map(|split| &split.held_out);
    let role = |run: &Run| match (run.role, &held_out) {
        (Some(role), _) => role.to_string(),
        (None, Ok(_)) if recording.runs().len() == 1 => "(cut)".to_owned(),
        (None, Ok(held)) if held.runs().iter().any(|r| r.name() == run.name()) => "(held_out)".to_owned(),
        (None, Ok(_)) => "(training)".to_owned(),
        (None, Err(_)) => "-".to_owned(),
    };
    writeln!(out, "\nruns")?;
    let mut table =
        Table::new(["run", "role", "samples", "duration", "clock", "worst jitter", "irregular"]).left(2);
    for run in recording.runs() {
        let timing = &run.timing;
        let (clock, jitter) = match timing.source {
            PeriodSource::Declared => ("declared", "-".to_owned()),
            PeriodSource::Measured => ("time column", percent(timing.worst_jitter())),
            PeriodSource::DeclaredAndMeasured => ("both", percent(timing.worst_jitter())),
        };
        table.row([
            run.name().to_owned(),
            role(run),
            run.len().to_string(),
            engineering(run.duration_s(), "s"),
            clock.to_owned(),
            jitter,
            timing.irregular_intervals.to_string(),
        ]);
    }
    table.write(out)?;
    if recording.runs().iter().any(|run| run.role.is_none()) {
        match &split {
            Ok(Split { cut: Some(cut), .. }) => writeln!(out, "  {}", stretches::cut(cut))?,
            Ok(_) => writeln!(out, "  (role) = not declared, as the default split shares the runs out")?,
            Err(error) => writeln!(out, "  not split: {}", error.statement())?,
        }
    }
    Ok(())
}

fn percent(fraction: f64) -> String {
    format!("{:.2} %", 100.0 * fraction)
}

/// Settings and metadata of the runs.
fn details(recording: &Recording, out: &mut dyn Write) -> Result<(), Failure> {
    let stated = |run: &&Run| !run.settings.is_empty() || !run.metadata.is_empty();
    if recording.runs().iter().any(|run| stated(&run)) {
        writeln!(out, "\nstated of the runs")?;
    }
    for run in recording.runs().iter().filter(stated) {
        let metadata = run.metadata.iter().map(|(key, value)| format!("{key} = {value}"));
        let settings = run.settings.iter().map(|(key, value)| format!("set {key} = {value}"));
        let list: Vec<String> = metadata.chain(settings).collect();
        writeln!(out, "  {}: {}", run.name(), list.join(", "))?;
    }
    Ok(())
}

fn signals(recording: &Recording, out: &mut dyn Write) -> Result<(), Failure> {
    writeln!(out, "\nsignals, over all runs")?;
    let mut table = Table::new(["signal", "column", "lowest", "highest", "in runs"]).left(2);
    let motion = recording.motion();
    for signal in Signal::ALL {
        let columns: Vec<&[f64]> = recording.runs().iter().filter_map(|run| run.signal(signal)).collect();
        if columns.is_empty() {
            continue;
        }
        let (low, high) = range(&columns);
        table.row([
            signal.word(motion).to_owned(),
            signal.key(motion).to_owned(),
            shown(low, signal, motion),
            shown(high, signal, motion),
            format!("{} of {}", columns.len(), recording.runs().len()),
        ]);
    }
    let names: std::collections::BTreeSet<&String> =
        recording.runs().iter().flat_map(|run| run.extra_columns().keys()).collect();
    for name in names {
        let columns: Vec<&[f64]> = recording
            .runs()
            .iter()
            .filter_map(|run| run.extra_columns().get(name))
            .map(Vec::as_slice)
            .collect();
        let (low, high) = range(&columns);
        table.row([
            "extra column".to_owned(),
            name.clone(),
            engineering(low, ""),
            engineering(high, ""),
            format!("{} of {}", columns.len(), recording.runs().len()),
        ]);
    }
    table.write(out)?;
    Ok(())
}

fn range(columns: &[&[f64]]) -> (f64, f64) {
    let all = columns.iter().flat_map(|samples| samples.iter());
    all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)))
}

/// In the unit of the shop floor: feeds in m/min, the rest to three digits in a readable unit.
fn shown(value: f64, signal: Signal, motion: Motion) -> String {
    let feed = matches!(signal, Signal::Velocity | Signal::VelocityReference) && motion == Motion::Prismatic;
    match Unit::parse("m/min") {
        Ok(unit) if feed => format!("{:.3} m/min", unit.from_si(value)),
        _ => engineering(value, signal.si_unit(motion)),
    }
}

/// What was converted, and what was left aside.
fn columns(recording: &Recording, out: &mut dyn Write) -> Result<(), Failure> {
    writeln!(out, "\nunits converted")?;
    if recording.units_read.is_empty() {
        writeln!(out, "  none: every column has its canonical name and SI unit")?;
    }
    for conversion in &recording.units_read {
        let all = conversion.runs.len() == recording.runs().len();
        let runs = if all { "all runs".to_owned() } else { conversion.runs.join(", ") };
        writeln!(out, "  {conversion}  ({runs})")?;
    }
    let remarked: Vec<&Run> = recording.runs().iter().filter(|run| !run.remarks.is_empty()).collect();
    if !remarked.is_empty() {
        writeln!(out, "\nread")?;
    }
    for run in remarked {
        writeln!(out, "  {}: {}", run.name(), run.remarks.join("; "))?;
    }
    let ignored: std::collections::BTreeSet<&str> =
        recording.runs().iter().flat_map(|run| run.ignored_columns.iter().map(String::as_str)).collect();
    if !ignored.is_empty() {
        let list: Vec<&str> = ignored.into_iter().collect();
        writeln!(out, "\ncolumns ignored\n  {}", list.join(", "))?;
    }
    Ok(())
}
