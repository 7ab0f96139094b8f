//! The force that the twin lacks, over speed, position, acceleration and time, with the fitted law drawn through.

use super::page::Part;
use super::partial;
use super::scale::{Scale, force_word, robust, speed_word, with_zero};
use crate::diagnose::Diagnosis;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};
use crate::report::material::{Force, Material};
use crate::report::words::together;
use crate::units::Motion;

/// What the section is called.
pub(super) fn title(motion: Motion) -> &'static str {
    match motion {
        Motion::Prismatic => "The force that the twin lacks",
        Motion::Revolute => "The torque that the twin lacks",
    }
}

/// The section.
pub(super) fn part(diagnosis: &Diagnosis, material: &Material) -> Part {
    let mut part = Part::default();
    let motion = material.motion;
    let word = force_word(motion);
    let Some(force) = &material.force else {
        part.paragraph(&format!(
            "No logged signal tells the motor's {word}, so what the twin lacks cannot be put into a {word}."
        ));
        partial::append(&mut part, material);
        return part;
    };
    let mass = if motion == Motion::Prismatic { "Mass" } else { "Inertia" };
    part.remark(&format!(
        "{mass} times measured acceleration, less every {word} that the twin knows of. Positive acts along positive \
         position; over speed, position and acceleration, moving samples of all runs."
    ));
    let effects: Vec<String> = diagnosis.causes.iter().map(|cause| cause.effect.clone()).collect();
    let law = if effects.is_empty() { "calibration".to_owned() } else { together(&effects) };
    let scale = Scale::force(motion, force.before.iter().chain(&force.after));
    part.figure(over(force, &scale, material, &law));
    part.figure(in_time(force, &scale, &law));
    partial::append(&mut part, material);
    part
}

fn over(force: &Force, scale: &Scale, material: &Material, law: &str) -> Figure {
    let motion = material.motion;
    let (speed, place) = (Scale::speed(motion, &force.velocity), Scale::position(motion, &force.position));
    let si = if motion == Motion::Prismatic { "m/s²" } else { "rad/s²" };
    let acceleration = Scale { factor: 1.0, unit: si.to_owned() };
    let charts = [
        (speed_word(motion), &force.velocity, speed),
        ("position", &force.position, place),
        ("acceleration", &force.acceleration, acceleration),
    ];
    let panels =
        charts.map(|(word, quantity, across)| Panel::Chart(over_one(force, scale, word, quantity, &across)));
    let caption = format!("What the {} lacks (dots), and the fitted law: {law}.", material.baseline);
    let law_words = format!("fitted: {law}");
    Figure::new("force", caption, panels.to_vec()).legend([
        (Ink::Before, "lacking before"),
        (Ink::After, "lacking with the causes"),
        (Ink::Law, &law_words),
    ])
}

fn over_one(force: &Force, scale: &Scale, word: &str, quantity: &[f64], across: &Scale) -> Chart {
    let moves = force.moves();
    let dots = |samples: &[f64]| -> Vec<[f64; 2]> {
        let all = quantity.iter().zip(samples).zip(&moves);
        all.filter(|(_, moves)| **moves).map(|((x, y), _)| [across.to(*x), scale.to(*y)]).collect()
    };
    let (before, after) = (dots(&force.before), dots(&force.after));
    let heights = with_zero(before.iter().chain(&after).map(|p| p[1]).collect());
    let widths = robust(before.iter().map(|p| p[0]).collect());
    let mut marks = vec![
        Mark::Dots { ink: Ink::Before, points: before.clone() },
        Mark::Dots { ink: Ink::After, points: after },
    ];
    for curve in force.law_over(quantity) {
        let points = curve.into_iter().map(|[x, y]| [across.to(x), scale.to(y)]);
        marks.push(Mark::line(Ink::Law, points));
    }
    Chart {
        title: format!("over {word}"),
        x: Axis::holding(across.label(word), widths),
        y: Axis::holding(scale.unit.clone(), heights),
        marks,
        height: 150.0,
        has_x_labels: true,
    }
}

fn in_time(force: &Force, scale: &Scale, law: &str) -> Figure {
    let (name, count) = &force.first;
    let curve = |samples: Vec<f64>| -> Vec<[f64; 2]> {
        force.time_s[..*count].iter().zip(samples).map(|(t, y)| [*t, scale.to(y)]).collect()
    };
    let moves = force.moves();
    let moving = |samples: Vec<f64>| -> Vec<f64> {
        samples.iter().zip(&moves).map(|(y, moves)| if *moves { *y } else { f64::NAN }).collect()
    };
    let (before, after) = (curve(moving(force.before.clone())), curve(moving(force.after.clone())));
    let fitted = curve(moving(force.law().collect()));
    let heights = with_zero(before.iter().chain(&after).map(|p| p[1]).collect());
    let end = force.time_s[..*count].last().copied().unwrap_or(1.0);
    let chart = Chart {
        title: format!("over time, run {name}"),
        x: Axis::linear("time in s", [0.0, end]),
        y: Axis::holding(scale.unit.clone(), heights),
        marks: vec![
            Mark::line(Ink::Before, before),
            Mark::line(Ink::After, after),
            Mark::line(Ink::Law, fitted),
        ],
        height: 160.0,
        has_x_labels: true,
    };
    let caption = format!(
        "The same along one run, with the fitted law: {law}. Left out at standstill, where friction takes any value."
    );
    Figure::new("force_time", caption, vec![Panel::Chart(chart)]).legend([
        (Ink::Before, "lacking before"),
        (Ink::After, "lacking with the causes"),
        (Ink::Law, "fitted law"),
    ])
}
