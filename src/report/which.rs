//! WHICH: the effects named, with parameters and rivals, and the best explanations of the ranking.

use super::Style;
use super::layout::{Align, Table, paragraph};
use super::number::{NONE, angle, estimate, interval, percent, plain, probability, twin};
use super::words::baseline;
use crate::diagnose::Verdict;
use crate::diagnose::verdict::{Cause, Diagnosis};

/// Explanations of the ranking that are shown.
const EXPLANATIONS: usize = 6;

/// The section.
pub(super) fn section(diagnosis: &Diagnosis, style: Style) -> String {
    let remark = match diagnosis.verdict {
        Verdict::Undecided => "the best explanation; not decided against its rivals",
        _ if diagnosis.causes.is_empty() => "no effect is named",
        _ if diagnosis.withheld.is_some() => "the nearest explanation; no verdict rests on it",
        Verdict::Unknown if diagnosis.is_found_in_part() => {
            "they close most of the gap; more than noise is left"
        }
        Verdict::Unknown => "the nearest explanation; it leaves more than a detail open",
        _ => "",
    };
    let mut out = style.heading("WHICH", remark);
    if !diagnosis.causes.is_empty() {
        out += &effects(&diagnosis.causes).text(style);
        out += "\n";
        out += &parameters(&diagnosis.causes).text(style);
        out += "\n";
    }
    for cause in &diagnosis.causes {
        if let Some(reason) = &cause.confusable_reason {
            out += &paragraph(&format!("{}: {reason}", cause.effect), style);
            out += "\n";
        }
    }
    out += &ranking(diagnosis).text(style);
    out += &refinements(diagnosis, style);
    out + &ruled_out(diagnosis, style)
}

/// Effects that cannot be the cause because their stretch of the signal path shows no gap of its own.
fn ruled_out(diagnosis: &Diagnosis, style: Style) -> String {
    let mut reasons: Vec<&str> = Vec::new();
    for out in &diagnosis.ruled_out {
        if !reasons.contains(&out.reason.as_str()) {
            reasons.push(&out.reason);
        }
    }
    let of = |reason: &str| -> String {
        let same = diagnosis.ruled_out.iter().filter(|out| out.reason == reason);
        same.map(|out| out.effect.as_str()).collect::<Vec<_>>().join(", ")
    };
    reasons
        .iter()
        .map(|why| format!("\n{}", paragraph(&format!("Ruled out: {}. {why}", of(why)), style)))
        .collect()
}

fn effects(causes: &[Cause]) -> Table {
    use Align::{Left, Right};
    let mut table = Table::new(&[
        ("effect", Left),
        ("place", Left),
        ("probability", Right),
        ("closes", Right),
        ("confusable with", Left),
    ]);
    for cause in causes {
        let rivals = cause.confusable_with.join(", ");
        table.row(vec![
            cause.effect.clone(),
            cause.site.clone(),
            probability(cause.probability),
            percent(cause.closes),
            if rivals.is_empty() { NONE.to_owned() } else { rivals },
        ]);
    }
    table
}

fn parameters(causes: &[Cause]) -> Table {
    use Align::{Left, Right};
    let mut table =
        Table::new(&[("parameter", Left), ("value", Right), ("95 % interval", Right), ("twin has", Right)]);
    for cause in causes {
        for (name, parameter) in cause.numbers() {
            table.row(vec![
                format!("{}.{name}", cause.effect),
                estimate(parameter),
                interval(parameter),
                twin(parameter),
            ]);
        }
        for phase in &cause.phases {
            table.row(vec![
                format!("phase_rad in {}", phase.run),
                angle(phase.phase_rad),
                NONE.to_owned(),
                NONE.to_owned(),
            ]);
        }
    }
    table
}

/// What a diagnosis with the causes in the twin would look at next.
fn refinements(diagnosis: &Diagnosis, style: Style) -> String {
    let named = |effect: &&String| !diagnosis.causes.iter().any(|cause| cause.effect == **effect);
    let mut further: Vec<&str> = Vec::new();
    for effect in diagnosis.refinements.iter().flat_map(|ranked| &ranked.effects).filter(named) {
        if !further.contains(&effect.as_str()) {
            further.push(effect);
        }
    }
    if further.is_empty() {
        return String::new();
    }
    let text = format!(
        "Predict a little better still, too little to be named beside this gap: {}. Diagnose again with the \
         causes in the twin to look at them.",
        further.join(", ")
    );
    format!("\n{}", paragraph(&text, style))
}

fn ranking(diagnosis: &Diagnosis) -> Table {
    use Align::{Left, Right};
    let mut table = Table::new(&[
        ("explanation (each calibrated inside tolerance)", Left),
        ("probability", Right),
        ("held-out gap", Right),
    ]);
    for ranked in diagnosis.ranking.iter().take(EXPLANATIONS) {
        let effects = ranked.effects.join(" + ");
        table.row(vec![
            if effects.is_empty() { format!("the {}", baseline(diagnosis)) } else { effects },
            probability(ranked.probability),
            format!("{} × noise", plain(ranked.held_out_gap)),
        ]);
    }
    table
}
