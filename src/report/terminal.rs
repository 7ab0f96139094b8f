//! The report on a terminal.

use super::layout::{Ink, labelled, paragraph};
use super::style::{NARROWEST, Style};
use super::{changes, drive, extent, follow_up, place, sentence, stretches, untested, which, withheld};
use crate::diagnose::Verdict;
use crate::diagnose::verdict::Diagnosis;
use crate::units::Motion;

/// Width of the labels at the head.
const LABEL: usize = 8;

/// A diagnosis of an axis of this motion as text: what makes its verdict doubtful, why it is withheld, if it is, data, verdict, what changed, where, which, how far, calibration, remarks,
/// next step.
///
/// # Design
/// Every number is one of the diagnosis, rounded to what its interval allows; what is not finite is a dash,
/// and no probability is rounded to certainty.
pub fn terminal(diagnosis: &Diagnosis, motion: Motion, style: Style) -> String {
    let style = Style { width: style.width.max(NARROWEST), ..style };
    let sections = [
        follow_up::doubted(diagnosis, style),
        withheld::section(diagnosis, style),
        head(diagnosis, style),
        verdict(diagnosis, motion, style),
        changes::section(diagnosis, style),
        place::section(diagnosis, motion, style),
        which::section(diagnosis, style),
        extent::section(diagnosis, motion, style),
        untested::section(diagnosis, style),
        follow_up::calibration(diagnosis, style),
        follow_up::checks(diagnosis, style),
        follow_up::next(diagnosis, style),
    ];
    sections.concat()
}

fn head(diagnosis: &Diagnosis, style: Style) -> String {
    let data = &diagnosis.data;
    let runs = |names: &[String]| format!("{} ({})", names.join(", "), names.len());
    let mut out = format!("{}\n", style.ink(Ink::Heading, &data.machine));
    if let Some(note) = &data.note {
        let lines = labelled("data", LABEL, note, style);
        out += &lines.lines().map(|line| format!("{}\n", style.ink(Ink::Warning, line))).collect::<String>();
    }
    out += &labelled("training", LABEL, &runs(&data.training), style);
    out += &labelled("held out", LABEL, &runs(&data.held_out), style);
    stretches::sentences(data).iter().fold(out, |out, text| out + &labelled("", LABEL, text, style))
}

fn verdict(diagnosis: &Diagnosis, motion: Motion, style: Style) -> String {
    let (word, ink) = match diagnosis.verdict {
        Verdict::NoGap => ("NO GAP", Ink::Good),
        Verdict::Cause => ("CAUSE FOUND", Ink::Bad),
        Verdict::Undecided => ("UNDECIDED", Ink::Warning),
        Verdict::Unknown if diagnosis.withheld.is_some() => ("NO VERDICT", Ink::Bad),
        Verdict::Unknown if diagnosis.is_found_in_part() => ("CAUSE FOUND IN PART", Ink::Warning),
        Verdict::Unknown => ("UNKNOWN CAUSE", Ink::Bad),
    };
    let words = match &diagnosis.withheld {
        Some(_) => withheld::rest(diagnosis),
        None => sentence::sentence(diagnosis, motion),
    };
    let text = paragraph(&words, style);
    let beside = drive::on_the_drive(diagnosis, motion);
    let beside = if beside.is_empty() { String::new() } else { format!("\n{}", paragraph(&beside, style)) };
    format!("\n{}\n{text}{beside}", style.ink(ink, word))
}
