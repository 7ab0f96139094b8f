//! What to do next: the machine file, the next experiment and what it should show.

use super::page::{Part, command};
use super::scale::Scale;
use crate::diagnose::{Diagnosis, Verdict};
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel, escape};
use crate::report::follow_up::{is_for_the_twin, snippet, what_to_do};
use crate::report::material::{Material, Predicted};
use crate::report::untested;
use crate::report::words::together;
use crate::units::Motion;

/// The section.
pub(super) fn part(diagnosis: &Diagnosis, material: &Material) -> Part {
    let mut part = Part::default();
    let words = what_to_do(diagnosis);
    if !words.is_empty() {
        part.paragraph(words);
    }
    if is_for_the_twin(diagnosis) {
        part.raw(&format!("<pre>{}</pre>\n", escape(&snippet(diagnosis))));
    }
    for gap in &diagnosis.untested {
        part.paragraph(&format!("Not tested, {}: {}", untested::limit(gap), untested::words(gap)));
    }
    match &diagnosis.next_experiment {
        Some(experiment) => {
            part.paragraph(&format!("Next experiment: {}", experiment.sentence));
            part.raw(&format!("<pre class=\"command\">{}</pre>\n", command(&experiment.command)));
        }
        None => {
            part.remark(match diagnosis.verdict {
                _ if diagnosis.withheld.is_some() => "No motion is proposed while there is no verdict.",
                Verdict::Undecided => "No motion was found that would tell the rivals apart.",
                Verdict::Unknown if diagnosis.is_found_in_part() => {
                    "No motion is proposed for the rest: the catalogue has no explanation of it that one could put to the test."
                }
                Verdict::Unknown => {
                    "No motion is proposed: the catalogue has no explanation that one could put to the test."
                }
                _ if diagnosis.causes.iter().any(|cause| !cause.confusable_with.is_empty()) => {
                    "No motion was found that would tell the named explanation from its rivals."
                }
                _ => "No further experiment is needed to tell the named explanation from others.",
            });
        }
    }
    if let Some(predicted) = &material.next {
        part.figure(figure(predicted, material.motion));
    }
    part
}

/// The signal that tells, as either explanation predicts it, and their difference.
fn figure(predicted: &Predicted, motion: Motion) -> Figure {
    let Predicted { signal, period_s, reference, events, effects, traces } = predicted;
    let end = reference.len() as f64 * period_s;
    let scale = Scale::signal(*signal, motion, &traces[0]);
    let curve = |samples: &[f64], factor: f64| -> Vec<[f64; 2]> {
        samples.iter().enumerate().map(|(k, x)| [k as f64 * period_s, factor * x]).collect()
    };
    let marks = |list: Vec<Mark>, has_words: bool| -> Vec<Mark> {
        let events = events.iter().map(|e| Mark::Event {
            x: e.time_s,
            word: if has_words { e.word.to_owned() } else { String::new() },
        });
        list.into_iter().chain(events).collect()
    };
    let difference: Vec<f64> = traces[0].iter().zip(&traces[1]).map(|(a, b)| a - b).collect();
    let fine = Scale::of(signal.si_unit(motion), &difference);
    let word = signal.word(motion);
    let both =
        [Ink::After, Ink::Before].iter().zip(traces).map(|(ink, t)| Mark::line(*ink, curve(t, scale.factor)));
    let panels = vec![
        Panel::Chart(Chart {
            title: format!("{word}, predicted"),
            x: Axis::linear("", [0.0, end]),
            y: Axis::holding(scale.unit.clone(), traces.iter().flatten().map(|x| scale.to(*x))),
            marks: marks(both.collect(), true),
            height: 130.0,
            has_x_labels: false,
        }),
        Panel::Chart(Chart {
            title: "the difference that tells".to_owned(),
            x: Axis::linear("time in s", [0.0, end]),
            y: Axis::holding(fine.unit.clone(), difference.iter().map(|x| fine.to(*x))),
            marks: marks(vec![Mark::line(Ink::Law, curve(&difference, fine.factor))], false),
            height: 110.0,
            has_x_labels: true,
        }),
    ];
    let [chosen, rival] = effects.each_ref().map(|list| together(list));
    let caption =
        format!("What the proposed motion should show if the cause is {chosen}, and if it is {rival}.");
    Figure::new("next", caption, panels).legend([(Ink::After, &chosen), (Ink::Before, &rival)])
}
