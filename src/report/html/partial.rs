//! Each cause on what the twin lacks that has all the others: its own law on its own partial residual.

use super::page::Part;
use super::scale::{Scale, force_word, robust, speed_word, with_zero};
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};
use crate::report::material::Force;
use crate::report::material::Material;
use crate::report::material::partial::{Partial, PartialForce, PartialSignal, Quantity};
use crate::report::words::phrase;
use crate::units::Motion;

/// Appends a figure with a panel a cause; one cause that is a force is drawn whole already.
pub(super) fn append(part: &mut Part, material: &Material) {
    let list = &material.partials;
    if list.is_empty() || matches!((&list[..], &material.force), ([Partial::Force(_)], Some(_))) {
        return;
    }
    let panels: Vec<Panel> =
        list.iter().filter_map(|partial| panel(partial, material)).map(Panel::Chart).collect();
    let caption = "Each cause by itself: what the twin lacks that has all the other causes and the calibration, and the law of \
                   this one. A law fits where it runs through its dots.";
    let figure = Figure::new("partial", caption, panels)
        .legend([(Ink::Before, "lacking without this cause"), (Ink::Law, "its law")]);
    part.figure(figure);
}

fn panel(partial: &Partial, material: &Material) -> Option<Chart> {
    match partial {
        Partial::Force(of) => {
            let force = material.force.as_ref()?;
            Some(match &of.over {
                Some((quantity, _)) => over_quantity(of, *quantity, force, material.motion),
                None => in_time(of, force, material.motion),
            })
        }
        Partial::Signal(of) => Some(of_signal(of, material.motion)),
    }
}

fn scaled(quantity: Quantity, force: &Force, motion: Motion) -> (&'static str, Scale) {
    match quantity {
        Quantity::Velocity => (speed_word(motion), Scale::speed(motion, &force.velocity)),
        Quantity::Position => ("position", Scale::position(motion, &force.position)),
        Quantity::Acceleration => {
            let unit = if motion == Motion::Prismatic { "m/s²" } else { "rad/s²" };
            ("acceleration", Scale { factor: 1.0, unit: unit.to_owned() })
        }
    }
}

fn over_quantity(of: &PartialForce, quantity: Quantity, force: &Force, motion: Motion) -> Chart {
    let scale = Scale::force(motion, &of.lacking);
    let (word, across) = scaled(quantity, force, motion);
    let moves = force.moves();
    let all = quantity.of(force).iter().zip(&of.lacking).zip(&moves);
    let dots: Vec<[f64; 2]> =
        all.filter(|(_, moves)| **moves).map(|((x, y), _)| [across.to(*x), scale.to(*y)]).collect();
    let curves = of.over.iter().flat_map(|(_, over)| &over.curves);
    let lines: Vec<Vec<[f64; 2]>> =
        curves.map(|curve| curve.iter().map(|[x, y]| [across.to(*x), scale.to(*y)]).collect()).collect();
    let heights = dots.iter().chain(lines.iter().flatten()).map(|p| p[1]);
    let (heights, widths) = (with_zero(heights.collect()), dots.iter().map(|p| p[0]));
    let x = Axis::holding(across.label(word), robust(widths.collect()));
    let mut marks = vec![Mark::Dots { ink: Ink::Before, points: dots }];
    marks.extend(lines.into_iter().map(|line| Mark::line(Ink::Law, line)));
    Chart {
        title: format!("{}, over {word}", phrase(&of.effect)),
        x,
        y: Axis::holding(scale.unit.clone(), heights),
        marks,
        height: 130.0,
        has_x_labels: true,
    }
}

fn in_time(of: &PartialForce, force: &Force, motion: Motion) -> Chart {
    let scale = Scale::force(motion, &of.lacking);
    let (run, count) = &force.first;
    let moves = force.moves();
    let curve = |samples: &[f64]| -> Vec<[f64; 2]> {
        let all = force.time_s.iter().zip(samples).zip(&moves).take(*count);
        all.map(|((t, y), moves)| [*t, if *moves { scale.to(*y) } else { f64::NAN }]).collect()
    };
    let (lacking, law) = (curve(&of.lacking), curve(&of.law));
    let heights = with_zero(lacking.iter().chain(&law).map(|p| p[1]).collect());
    let end = lacking.last().map_or(1.0, |p| p[0]);
    Chart {
        title: format!("{}, {} over time, run {run}", phrase(&of.effect), force_word(motion)),
        x: Axis::linear("time in s", [0.0, end]),
        y: Axis::holding(scale.unit.clone(), heights),
        marks: vec![Mark::line(Ink::Before, lacking), Mark::line(Ink::Law, law)],
        height: 130.0,
        has_x_labels: true,
    }
}

fn of_signal(of: &PartialSignal, motion: Motion) -> Chart {
    let scale = Scale::of(of.signal.si_unit(motion), of.residual.iter().chain(&of.law));
    let curve = |samples: &[f64]| -> Vec<[f64; 2]> {
        samples.iter().enumerate().map(|(k, y)| [k as f64 * of.period_s, scale.to(*y)]).collect()
    };
    let (residual, law) = (curve(&of.residual), curve(&of.law));
    let heights: Vec<f64> = residual.iter().chain(&law).map(|p| p[1]).collect();
    Chart {
        title: format!(
            "{} exerts no force: {} over time, run {}",
            phrase(&of.effect),
            of.signal.word(motion),
            of.run
        ),
        x: Axis::linear("time in s", [0.0, of.period_s * of.residual.len() as f64]),
        y: Axis::holding(scale.unit.clone(), heights),
        marks: vec![Mark::line(Ink::Before, residual), Mark::line(Ink::Law, law)],
        height: 130.0,
        has_x_labels: true,
    }
}
