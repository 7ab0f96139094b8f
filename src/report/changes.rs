//! WHAT CHANGED: in a comparison of two recordings, every parameter before and after.

use super::Style;
use super::layout::{Align, Table, labelled, paragraph};
use super::number::{moved, percent, plain, ratio, twin, value, with_interval};
use super::remains::{by_calibration, remains};
use super::words::{described, is_resolved, name, placed, times_noise};
use crate::diagnose::Verdict;
use crate::diagnose::grounds::Veto;
use crate::diagnose::thresholds::ADEQUATE_GAP;
use crate::diagnose::verdict::{Cause, Diagnosis, Parameter, Reference};
use crate::units::Motion;

/// Width of the labels.
const LABEL: usize = 9;

/// The section; empty where the diagnosis is no comparison.
pub(super) fn section(diagnosis: &Diagnosis, style: Style) -> String {
    let Some(reference) = &diagnosis.reference else { return String::new() };
    let mut out = style.heading("WHAT CHANGED", "between the reference and the recording");
    if diagnosis.causes.is_empty() {
        out += &paragraph("No effect is named as a change.", style);
    } else {
        out += &table(&diagnosis.causes).text(style);
    }
    out += "\n";
    out += &labelled("reference", LABEL, &runs(reference), style);
    if let Some(note) = &reference.data.note {
        out += &labelled("", LABEL, note, style);
    }
    out + &labelled("had", LABEL, &had(reference), style)
}

pub(super) fn runs(reference: &Reference) -> String {
    let data = &reference.data;
    format!("{}; held out {}", data.training.join(", "), data.held_out.join(", "))
}

/// What the reference had beside the machine file, and how well the baseline predicts it.
pub(super) fn had(reference: &Reference) -> String {
    let found: Vec<String> = reference.causes.iter().map(described).collect();
    let found =
        if found.is_empty() { "nothing beside the machine file".to_owned() } else { found.join("; ") };
    let (before, after) = (plain(reference.gap_before), times_noise(reference.gap_after));
    let open = match reference.verdict {
        Verdict::Undecided => {
            "; its diagnosis is undecided: other explanations predict it as well, with other values before"
                .to_owned()
        }
        Verdict::Unknown if matches!(reference.withheld, Some(Veto::Unidentified | Veto::Stretch)) => {
            format!(
                "; its diagnosis is unknown: this explanation is not identified, and {} of its gap stays open",
                percent(reference.open_share())
            )
        }
        Verdict::Unknown if reference.is_explained() => format!(
            "; its diagnosis is unknown: {} of its gap has no explanation and counts as noise here",
            percent(reference.open_share())
        ),
        Verdict::Unknown => "; its diagnosis is unknown: no explanation fits it".to_owned(),
        Verdict::NoGap | Verdict::Cause => String::new(),
    };
    format!("{found} (G = {before} → {after}){open}")
}

fn table(causes: &[Cause]) -> Table {
    use Align::{Left, Right};
    let mut table =
        Table::new(&[("parameter", Left), ("before", Right), ("after", Right), ("change", Right)]);
    for cause in causes {
        for (key, parameter) in cause.numbers() {
            table.row(vec![
                format!("{}.{key}", cause.effect),
                twin(parameter),
                with_interval(parameter),
                verdict(parameter),
            ]);
        }
    }
    table
}

/// "× 0.16", "new", "gone", or "not resolved" where the interval holds the value before.
pub(super) fn verdict(parameter: &Parameter) -> String {
    let Parameter { value, twin, ci95: [from, to], .. } = *parameter;
    if !is_resolved(parameter) {
        "not resolved".to_owned()
    } else if twin == 0.0 || !twin.is_finite() {
        "new".to_owned()
    } else if (from..=to).contains(&0.0) {
        "gone".to_owned()
    } else if value * twin > 0.0 {
        format!("× {}", ratio(parameter))
    } else {
        moved(parameter)
    }
}

/// What changed as a sentence; none where the diagnosis is no comparison or its words are those of any diagnosis.
pub(super) fn sentence(diagnosis: &Diagnosis, motion: Motion) -> Option<String> {
    let reference = diagnosis.reference.as_ref()?;
    let gap = &diagnosis.gap;
    match diagnosis.verdict {
        Verdict::NoGap => Some(format!(
            "{} since the reference beyond tolerance: the twin of the machine as it was then predicts the \
             unseen runs as well as it does the reference (G = {}).{}",
            if may_hide_a_change(reference) { "No change shows" } else { "Nothing changed" },
            times_noise(gap.after),
            undetectable(reference)
        )),
        Verdict::Cause | Verdict::Unknown if !diagnosis.causes.is_empty() && is_found(diagnosis) => {
            let parts: Vec<String> = diagnosis.causes.iter().map(part).collect();
            let mut text = format!("Changed since the reference: {}", parts.join(", and "));
            if parts.len() > 1 {
                text += &format!(", together {} of the difference", percent(gap.closed));
            }
            text += ".";
            Some(text + &by_calibration(diagnosis) + &remains(diagnosis, motion))
        }
        _ => None,
    }
}

/// Whether the twin leaves more of the reference than noise, in which a change may be hidden.
pub(super) fn may_hide_a_change(reference: &Reference) -> bool {
    reference.gap_after > ADEQUATE_GAP
}

/// What may have changed all the same, where the twin leaves more of the reference than noise.
fn undetectable(reference: &Reference) -> String {
    if !may_hide_a_change(reference) {
        return String::new();
    }
    let left = times_noise(reference.gap_after);
    format!(" A change that makes less than the {left} that the twin leaves of the reference does not show.")
}

fn is_found(diagnosis: &Diagnosis) -> bool {
    diagnosis.verdict == Verdict::Cause || diagnosis.is_found_in_part()
}

/// "Coulomb friction on the guide, 973 → 165 N (64 %)", with the parameters that changed beyond their interval.
fn part(cause: &Cause) -> String {
    let alone = cause.parameters.len() == 1;
    let parameters: Vec<String> = cause
        .told()
        .filter(|(_, parameter)| alone || is_resolved(parameter))
        .map(|(key, parameter)| {
            let numbers = match parameter.twin.is_finite() {
                true => moved(parameter),
                false => value(parameter.value, &parameter.unit),
            };
            if alone { numbers } else { format!("{} {numbers}", name(key)) }
        })
        .collect();
    let what = placed(cause);
    let list = parameters.iter().map(|text| format!(", {text}")).collect::<String>();
    format!("{what}{list} ({})", percent(cause.closes))
}
