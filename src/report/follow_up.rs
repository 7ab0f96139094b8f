//! What was calibrated, what was noticed in the data, and what to do next.

use super::Style;
use super::layout::{Align, INDENT, Ink, Table, columns, paragraph, wrap};
use super::number::{interval, toml_number, twin, with_interval};
use crate::diagnose::Verdict;
use crate::diagnose::verdict::Diagnosis;

/// Runs that are named before the rest is only counted.
const RUNS: usize = 4;

/// Constants moved inside their tolerance; those at its edge are flagged.
pub(super) fn calibration(diagnosis: &Diagnosis, style: Style) -> String {
    if diagnosis.calibration.is_empty() {
        return String::new();
    }
    use Align::{Left, Right};
    let mut out = style.heading("CALIBRATED", "constants moved inside their stated tolerance; no causes");
    let mut table = Table::new(&[("constant", Left), ("value", Right), ("twin has", Right), ("", Left)]);
    for calibration in &diagnosis.calibration {
        let edge = if calibration.at_tolerance { "at the edge of its tolerance" } else { "" };
        table.row(vec![
            calibration.path.clone(),
            with_interval(&calibration.parameter),
            twin(&calibration.parameter),
            edge.to_owned(),
        ]);
    }
    out += &table.text(style);
    if diagnosis.calibration.iter().any(|calibration| calibration.at_tolerance) {
        let warning = "A constant at the edge of its tolerance would go further if it were free: \
                       measure it again, or widen its tolerance.";
        out += &wrap(warning, style.width - columns(INDENT))
            .iter()
            .map(|line| format!("{INDENT}{}\n", style.ink(Ink::Warning, line)))
            .collect::<String>();
    }
    out
}

/// What was noticed in the data, each once, with the runs it concerns.
pub(super) fn checks(diagnosis: &Diagnosis, style: Style) -> String {
    let mut messages: Vec<(&str, Vec<&str>)> = Vec::new();
    for finding in &diagnosis.checks {
        let place = match messages.iter().position(|(message, _)| *message == finding.message) {
            Some(place) => place,
            None => {
                messages.push((&finding.message, Vec::new()));
                messages.len() - 1
            }
        };
        if !finding.run.is_empty() {
            messages[place].1.push(&finding.run);
        }
    }
    if messages.is_empty() {
        return String::new();
    }
    let count = diagnosis.data.training.len() + diagnosis.data.held_out.len();
    let mut out = style.heading("NOTICED IN THE DATA", "");
    for (message, runs) in messages {
        let text = match runs_text(&runs, count) {
            Some(runs) => format!("{message} ({runs})"),
            None => message.to_owned(),
        };
        for (row, line) in wrap(&text, style.width - columns(INDENT) - 2).iter().enumerate() {
            out += &format!("{INDENT}{} {line}\n", if row == 0 { "·" } else { " " });
        }
    }
    out
}

fn runs_text(runs: &[&str], count: usize) -> Option<String> {
    match runs.len() {
        0 => None,
        all if all >= count && count > 1 => Some("all runs".to_owned()),
        some if some <= RUNS => Some(runs.join(", ")),
        some => Some(format!("{} and {} more runs", runs[..RUNS].join(", "), some - RUNS)),
    }
}

/// What to do now.
pub(super) fn next(diagnosis: &Diagnosis, style: Style) -> String {
    let mut out = style.heading("NEXT", "");
    let words = match diagnosis.verdict {
        Verdict::NoGap => "Nothing to add: on runs like these the twin stands in for the machine.",
        Verdict::Cause if diagnosis.causes.is_empty() => "",
        Verdict::Cause => "Give the twin what it lacks, in machine.toml, and diagnose again:",
        Verdict::Undecided => {
            "Nothing to put into machine.toml yet: record a run in which the rivals differ, or strike those \
             that the machine cannot have with --without, and diagnose again."
        }
        Verdict::Unknown => {
            "Look at the machine where the gap is largest; a law that the catalogue lacks can be added to it \
             as one file."
        }
    };
    out += &paragraph(words, style);
    if diagnosis.verdict == Verdict::Cause && !diagnosis.causes.is_empty() {
        out += "\n";
        out += &snippet(diagnosis);
    }
    if let Some(experiment) = &diagnosis.next_experiment {
        out += &paragraph(&format!("Next experiment: {experiment}"), style);
    }
    out
}

/// The causes as tables of a machine file.
fn snippet(diagnosis: &Diagnosis) -> String {
    let mut out = String::new();
    for cause in &diagnosis.causes {
        out += &format!("[effect.{}]\n", cause.effect);
        for (name, parameter) in &cause.parameters {
            let line = format!("{name} = {}", toml_number(parameter));
            out += &format!("{line:<28}  # 95 %: {}\n", interval(parameter));
        }
    }
    out
}
