//! Hypotheses: probability, parameters, what each is confusable with and why, what was not looked at.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::verdict::{Cause, Parameter};
use crate::effect::EffectId;
use crate::report::changes::{had, runs, verdict};
use crate::report::figure::{Axis, Bar, Bars, Figure, Ink, Panel, Row};
use crate::report::number::{angle, interval, plain, probability, twin, with_interval};
use crate::report::words::{name, phrase};

/// Effects and explanations that are listed before the rest is folded.
const LISTED: usize = 8;

/// The section.
pub(super) fn part(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let had = if diagnosis.reference.is_some() { "reference" } else { "twin" };
    if diagnosis.causes.is_empty() {
        part.paragraph("No effect is named.");
    } else {
        part.table(
            &["effect", "place", ">probability", ">closes", "parameters, 95 % interval", "confusable with"],
            &diagnosis.causes.iter().map(|cause| self::cause(cause, had)).collect::<Vec<_>>(),
        );
    }
    part.figure(probabilities(diagnosis));
    part.folded("Every explanation, best first", ranking(diagnosis));
    part.folded("Every effect", effects(diagnosis));
    part.folded("Calibration of stated constants", calibration(diagnosis));
    part.folded("Effects that were not looked at, or ruled out", ruled_out(diagnosis));
    part
}

fn cause(cause: &Cause, had: &str) -> Vec<String> {
    let parameter = |(key, p): (&String, &Parameter)| {
        let before = if p.twin.is_finite() { format!(" ({had}: {})", twin(p)) } else { String::new() };
        format!("{} {}{before}", name(key), with_interval(p))
    };
    let phases = cause.phases.iter().map(|p| format!("phase of run {} {}", p.run, angle(p.phase_rad)));
    vec![
        phrase(&cause.effect),
        cause.site.clone(),
        probability(cause.probability),
        crate::report::number::percent(cause.closes),
        cause.numbers().map(parameter).chain(phases).collect::<Vec<_>>().join("\n"),
        confusable(cause),
    ]
}

/// What could stand in its place, and why.
fn confusable(cause: &Cause) -> String {
    if cause.confusable_with.is_empty() {
        return "nothing in the catalogue".to_owned();
    }
    let names: Vec<String> = cause.confusable_with.iter().map(|effect| phrase(effect)).collect();
    format!("{}. {}", names.join(", "), worded(why(cause)))
}

/// The same with effects in words instead of their ids.
fn worded(text: &str) -> String {
    let word = |word: &str| {
        let id = word.trim_end_matches([',', '.', ':', ';']);
        let is_id = id.contains('_') && EffectId::ALL.iter().any(|effect| effect.name() == id);
        if is_id { word.replacen(id, &phrase(id), 1) } else { word.to_owned() }
    };
    let text: String = text.split(' ').map(word).collect::<Vec<_>>().join(" ");
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Why these data cannot tell the effect from its rivals.
fn why(cause: &Cause) -> &str {
    cause.confusable_reason.as_deref().unwrap_or("does equally well on the unseen runs")
}

fn probabilities(diagnosis: &Diagnosis) -> Figure {
    let named = |effect: &str| diagnosis.causes.iter().any(|cause| cause.effect == effect);
    let rows = diagnosis.effects.iter().take(LISTED).map(|effect| Row {
        label: phrase(&effect.effect),
        bars: vec![Bar {
            ink: if named(&effect.effect) { Ink::Law } else { Ink::Reference },
            value: 100.0 * effect.probability,
            text: probability(effect.probability),
        }],
    });
    let bars = Bars {
        title: String::new(),
        axis: Axis::linear("probability that it acts, %", [0.0, 100.0]),
        rows: rows.collect(),
    };
    let caption = "Probability of the likeliest effects; those that are named stand out.";
    Figure::new("probability", caption, vec![Panel::Bars(bars)])
}

fn together(effects: &[String]) -> String {
    let phrases: Vec<String> = effects.iter().map(|effect| phrase(effect)).collect();
    if phrases.is_empty() { "the twin as it is, calibrated".to_owned() } else { phrases.join(" + ") }
}

fn ranking(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let rows: Vec<Vec<String>> = diagnosis
        .ranking
        .iter()
        .take(4 * LISTED)
        .map(|ranked| {
            vec![
                together(&ranked.effects),
                probability(ranked.probability),
                format!("{} × noise", plain(ranked.held_out_gap)),
            ]
        })
        .collect();
    part.table(&["explanation", ">probability", ">gap on unseen runs"], &rows);
    if !diagnosis.refinements.is_empty() {
        let list: Vec<String> = diagnosis.refinements.iter().map(|r| together(&r.effects)).collect();
        part.paragraph(&format!(
            "Predict a little better still, too little to be named beside this gap: {}.",
            list.join("; ")
        ));
    }
    part
}

fn effects(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let site = |effect: &str| {
        EffectId::ALL
            .iter()
            .find(|id| id.name() == effect)
            .map_or(String::new(), |id| id.site().name().to_owned())
    };
    let rows: Vec<Vec<String>> = diagnosis
        .effects
        .iter()
        .map(|e| vec![phrase(&e.effect), e.effect.clone(), site(&e.effect), probability(e.probability)])
        .collect();
    part.table(&["effect", "id", "place", ">probability"], &rows);
    part
}

fn calibration(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let rows: Vec<Vec<String>> = diagnosis
        .calibration
        .iter()
        .map(|c| {
            let edge =
                if c.at_tolerance { "at the edge of its tolerance: measure it again" } else { "inside" };
            vec![
                c.path.clone(),
                with_interval(&c.parameter),
                interval(&c.parameter),
                twin(&c.parameter),
                edge.to_owned(),
            ]
        })
        .collect();
    part.table(&["constant", ">value", ">95 % interval", ">twin has", "tolerance"], &rows);
    part
}

/// Effects that no search looked at: those that leave no trace, and those whose stretch of the signal path is clean.
fn ruled_out(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let rows: Vec<Vec<String>> = diagnosis
        .not_examined
        .iter()
        .chain(&diagnosis.ruled_out)
        .map(|not| vec![phrase(&not.effect), not.reason.clone()])
        .collect();
    part.table(&["effect", "why"], &rows);
    part
}

/// In a comparison, every parameter before and after; empty elsewhere.
pub(super) fn changes(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let Some(reference) = &diagnosis.reference else { return part };
    let rows: Vec<Vec<String>> = diagnosis
        .causes
        .iter()
        .flat_map(|cause| {
            cause.numbers().map(|(key, parameter)| {
                vec![
                    format!("{}, {}", phrase(&cause.effect), name(key)),
                    twin(parameter),
                    with_interval(parameter),
                    verdict(parameter),
                ]
            })
        })
        .collect();
    if rows.is_empty() {
        part.paragraph("No effect is named as a change.");
    }
    part.table(&["parameter", ">before", ">after", ">change"], &rows);
    part.remark(&format!("Reference runs: {}. It had: {}.", runs(reference), had(reference)));
    part
}
