//! Traces: machine against twin, before and after.

use super::page::Part;
use super::scale::Scale;
use crate::recording::Signal;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};
use crate::report::material::{Material, RunTraces, Trace};
use crate::units::Motion;

/// Runs whose figures are in the page; the live view has them all.
const STILL: usize = 2;

/// The section.
pub(super) fn part(material: &Material) -> Part {
    let mut part = Part::default();
    let held_out: Vec<&RunTraces> = material.runs.iter().filter(|run| run.is_held_out).collect();
    let mut still = Part::default();
    for run in held_out.iter().take(STILL) {
        still.figure(figure(run, material.motion, material.baseline));
    }
    if held_out.len() > STILL {
        still.remark(&format!("{} more unseen runs are in the live view.", held_out.len() - STILL));
    }
    part.live("traces", still);
    part
}

/// Every signal of a run, its value and its error.
pub(super) fn figure(run: &RunTraces, motion: Motion, baseline: &str) -> Figure {
    let end = run.time_s(run.samples());
    let count = run.traces.len();
    let mut panels = Vec::new();
    for (k, trace) in run.traces.iter().enumerate() {
        let has_twin = !trace.before.is_empty();
        let is_last = k + 1 == count;
        panels.push(Panel::Chart(values(run, trace, motion, end, is_last && !has_twin)));
        if has_twin {
            panels.push(Panel::Chart(errors(run, trace, motion, end, is_last)));
        }
    }
    let name: String = run.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let kind = if run.role.is_empty() { String::new() } else { format!(" ({})", run.role) };
    let has_twin = run.traces.iter().any(|trace| !trace.before.is_empty());
    let (caption, legend) = if has_twin {
        let caption =
            format!("Run {}{kind}: every signal of machine and twin, and what the twin misses.", run.name);
        (
            caption,
            vec![
                (Ink::Measured, "machine"),
                (Ink::Before, baseline),
                (Ink::After, "twin with the causes"),
                (Ink::Reference, "command"),
            ],
        )
    } else {
        (
            format!("Run {}{kind}: every signal.", run.name),
            vec![(Ink::Measured, "recorded"), (Ink::Reference, "command")],
        )
    };
    let mut figure = Figure::new(format!("traces_{name}"), caption, panels);
    figure.legend = legend.into_iter().map(|(ink, word)| (ink, word.to_owned())).collect();
    figure
}

fn points<'a>(run: &'a RunTraces, samples: &'a [f64], factor: f64) -> impl Iterator<Item = [f64; 2]> + 'a {
    samples.iter().enumerate().map(move |(k, x)| [run.time_s(k), factor * x])
}

fn events(run: &RunTraces, has_words: bool) -> impl Iterator<Item = Mark> + '_ {
    run.events.iter().map(move |event| Mark::Event {
        x: event.time_s,
        word: if has_words { event.word.to_owned() } else { String::new() },
    })
}

fn values(run: &RunTraces, trace: &Trace, motion: Motion, end: f64, has_x_labels: bool) -> Chart {
    let Trace { signal, measured, before, after } = trace;
    let scale = Scale::signal(*signal, motion, measured);
    let mut marks = Vec::new();
    let mut all: Vec<f64> = [measured, before, after].into_iter().flatten().copied().collect();
    if *signal == Signal::Position {
        marks.push(Mark::dashed(Ink::Reference, points(run, &run.reference, scale.factor)));
        all.extend(&run.reference);
    }
    for (ink, samples) in [(Ink::Measured, measured), (Ink::Before, before), (Ink::After, after)] {
        marks.push(Mark::line(ink, points(run, samples, scale.factor)));
    }
    marks.extend(events(run, true));
    Chart {
        title: signal.word(motion).to_owned(),
        x: Axis::linear(if has_x_labels { "time in s" } else { "" }, [0.0, end]),
        y: Axis::holding(scale.unit.clone(), all.iter().map(|x| scale.to(*x))),
        marks,
        height: 110.0,
        has_x_labels,
    }
}

fn errors(run: &RunTraces, trace: &Trace, motion: Motion, end: f64, has_x_labels: bool) -> Chart {
    let Trace { signal, measured, before, after } = trace;
    let less =
        |predicted: &[f64]| -> Vec<f64> { measured.iter().zip(predicted).map(|(m, p)| m - p).collect() };
    let (before, after) = (less(before), less(after));
    let scale = Scale::of(signal.si_unit(motion), before.iter().chain(&after));
    let mut marks = vec![
        Mark::line(Ink::Before, points(run, &before, scale.factor)),
        Mark::line(Ink::After, points(run, &after, scale.factor)),
    ];
    marks.extend(events(run, false));
    Chart {
        title: String::new(),
        x: Axis::linear(if has_x_labels { "time in s" } else { "" }, [0.0, end]),
        y: Axis::holding(format!("error, {}", scale.unit), before.iter().chain(&after).map(|x| scale.to(*x))),
        marks,
        height: 100.0,
        has_x_labels,
    }
}
