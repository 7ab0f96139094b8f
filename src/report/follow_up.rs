//! What was calibrated, what was noticed in the data, and what to do next.

use super::Style;
use super::changes::may_hide_a_change;
use super::findings::{Sentence, doubts, is_doubt, sentences};
use super::layout::{Align, INDENT, Ink, Table, paragraph};
use super::number::{interval, toml_number, twin, with_interval};
use super::withheld;
use super::wrap::{columns, wrap};
use crate::diagnose::Verdict;
use crate::diagnose::check::{Check, Severity};
use crate::diagnose::grounds::Veto;
use crate::diagnose::verdict::{Cause, Diagnosis};

/// Sentences about one kind of finding before the rest is only counted.
const SENTENCES: usize = 3;

/// Constants moved inside their tolerance; those at its edge are flagged.
pub(super) fn calibration(diagnosis: &Diagnosis, style: Style) -> String {
    let is_of_faulty_data = diagnosis.withheld.as_ref().is_some_and(|withheld| withheld.by == Veto::Data);
    if diagnosis.calibration.is_empty() || is_of_faulty_data {
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
                       measure it again, or widen its tolerance where the machine file has one.";
        out += &wrap(warning, style.width - columns(INDENT))
            .iter()
            .map(|line| format!("{INDENT}{}\n", style.ink(Ink::Warning, line)))
            .collect::<String>();
    }
    out
}

/// What was noticed in the data: warnings first, each sentence once with the runs it concerns. What stands above the verdict is
/// left out.
pub(super) fn checks(diagnosis: &Diagnosis, style: Style) -> String {
    let sentences = sentences(diagnosis);
    let is_said = |s: &&Sentence| s.severity == Severity::Fatal || is_doubt(s);
    let rest: Vec<&Sentence> = sentences.iter().filter(|s| !is_said(s)).collect();
    if rest.is_empty() {
        return String::new();
    }
    let mut out = style.heading("NOTICED IN THE DATA", "");
    let mut said: Vec<(Check, usize)> = Vec::new();
    for sentence in rest {
        said.push((sentence.check, sentence.runs.len().max(1)));
        if said.iter().filter(|(check, _)| *check == sentence.check).count() <= SENTENCES {
            out += &item(&sentence.text(), sentence.severity, style);
        }
    }
    out += &unsaid(&said, style);
    out
}

/// The same on a terminal.
pub(super) fn doubted(diagnosis: &Diagnosis, style: Style) -> String {
    doubts(diagnosis).iter().map(|text| item(text, Severity::Warning, style) + "\n").collect()
}

/// How often something like what was already said occurs beyond that.
fn unsaid(said: &[(Check, usize)], style: Style) -> String {
    let mut counts: Vec<(Check, Vec<usize>)> = Vec::new();
    for (check, runs) in said {
        match counts.iter_mut().find(|(known, _)| known == check) {
            Some((_, all)) => all.push(*runs),
            None => counts.push((*check, vec![*runs])),
        }
    }
    let more: usize = counts.iter().flat_map(|(_, all)| all.iter().skip(SENTENCES)).sum();
    if more == 0 {
        return String::new();
    }
    item(&format!("And the like {more} more times; --json FILE lists them all."), Severity::Note, style)
}

/// A sentence of a list; warnings are marked.
fn item(text: &str, severity: Severity, style: Style) -> String {
    let mark = match severity {
        Severity::Fatal | Severity::Warning => style.ink(Ink::Warning, "!"),
        Severity::Note => "·".to_owned(),
    };
    let lines = wrap(text, style.width - columns(INDENT) - 2);
    let row = |(row, line): (usize, &String)| {
        format!("{INDENT}{} {line}\n", if row == 0 { mark.as_str() } else { " " })
    };
    lines.iter().enumerate().map(row).collect()
}

/// What to do now.
pub(super) fn next(diagnosis: &Diagnosis, style: Style) -> String {
    let mut out = style.heading("NEXT", "");
    out += &paragraph(what_to_do(diagnosis), style);
    if is_for_the_twin(diagnosis) {
        out += "\n";
        out += &snippet(diagnosis);
    }
    if let Some(experiment) = &diagnosis.next_experiment {
        out += "\n";
        out += &paragraph(&format!("Next experiment: {}", experiment.sentence), style);
        // Lines that can be pasted as they stand.
        let lines = wrap(&experiment.command, style.width - columns(INDENT) - 2);
        let rows: Vec<String> = lines.iter().map(|line| format!("{INDENT}{line}")).collect();
        out += &format!("\n{}\n", rows.join(" \\\n"));
    }
    out
}

/// Whether the causes named belong into the machine's file.
pub(super) fn is_for_the_twin(diagnosis: &Diagnosis) -> bool {
    let is_found = diagnosis.verdict == Verdict::Cause || diagnosis.is_found_in_part();
    is_found && !diagnosis.causes.is_empty() && diagnosis.reference.is_none()
}

/// What to do now, in a sentence; empty where nothing can be said.
pub(super) fn what_to_do(diagnosis: &Diagnosis) -> &'static str {
    if let Some(withheld) = &diagnosis.withheld {
        return withheld::what_to_do(withheld.by);
    }
    let compares = diagnosis.reference.is_some();
    match diagnosis.verdict {
        Verdict::NoGap if diagnosis.reference.as_ref().is_some_and(may_hide_a_change) => {
            "No change shows; a smaller one would with a twin that explains the reference: diagnose that by itself first and give the twin what it lacks."
        }
        Verdict::NoGap if compares => "Nothing to repair: the machine is as it was.",
        Verdict::NoGap => "Nothing to add: on runs like these the twin stands in for the machine.",
        Verdict::Cause if diagnosis.causes.is_empty() => "",
        Verdict::Cause if compares => {
            "Repair or set back what changed. For a twin of the machine as it is now, diagnose the recording alone."
        }
        Verdict::Cause => "Give the twin what it lacks, in machine.toml, and diagnose again:",
        Verdict::Unknown if diagnosis.is_found_in_part() && compares => {
            "Repair or set back what changed, and look at the machine where the rest is largest."
        }
        Verdict::Unknown if diagnosis.is_found_in_part() && diagnosis.gap.training.is_only_here => {
            "Give the twin what it lacks, in machine.toml, and look at the machine and its log in that stretch: hold out a run that has it, or, if it was \
             one event, leave that run out:"
        }
        Verdict::Unknown if diagnosis.is_found_in_part() => {
            "Give the twin what it lacks, in machine.toml, and look at the machine where the rest is largest:"
        }
        Verdict::Undecided => {
            "Nothing to put into machine.toml yet: record a run in which the rivals differ, or strike those \
             that the machine cannot have with --without, and diagnose again."
        }
        Verdict::Unknown if diagnosis.gap.training.is_only_here => {
            "Look at the machine and its log in that stretch. If what happens there comes back, hold out a run that has it; if it was one event, \
             leave that run out; and diagnose again."
        }
        Verdict::Unknown => {
            "Look at the machine where the gap is largest; a law that the catalogue lacks can be added to it \
             as one file."
        }
    }
}

/// The causes as tables of a machine file.
pub(super) fn snippet<'d>(diagnosis: &'d Diagnosis) -> String {
    let mut out = String::new();
    let tables = |cause: &'d Cause| {
        let harmonics = cause.harmonics.iter().map(|harmonic| (&harmonic.effect, &harmonic.parameters));
        std::iter::once((&cause.effect, &cause.parameters)).chain(harmonics)
    };
    for (effect, parameters) in diagnosis.causes.iter().flat_map(tables) {
        out += &format!("[effect.{effect}]\n");
        for (name, parameter) in parameters {
            let line = format!("{name} = {}", toml_number(parameter));
            out += &format!("{line:<28}  # 95 %: {}\n", interval(parameter));
        }
    }
    out
}
