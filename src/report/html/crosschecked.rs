//! A cross-check of the plants as a page.

use super::page::{Builder, Page, Part};
use super::replayed::version;
use super::scale::Scale;
use super::{data, head, provenance};
use crate::machine::Machine;
use crate::plant::mujoco;
use crate::replay::crosscheck::{Outcome, Quantity, Replayed};
use crate::report::crosscheck as rows;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel, escape};
use crate::units::Motion;

/// One ink a pair of plants.
const INKS: [Ink; 3] = [Ink::Before, Ink::After, Ink::Law];

/// A cross-check as a page: the verdict, what needs no replay, every stroke, the differences over time of the stroke that comes
/// nearest to a bound.
pub fn crosschecked(outcome: &Outcome, machine: &Machine, command: &str) -> Page {
    let (name, motion) = (&machine.description().name, machine.motion());
    let mut sentence = rows::verdict(outcome);
    sentence = sentence.replacen("WITHIN BOUNDS", "Within bounds", 1).replacen("EXCEEDED", "Exceeded", 1);
    let head = head::plain_head(name, "cross-check", &sentence, None);
    let mut page = Builder::new(&format!("{name}: cross-check"), head);
    let mut statics = Part::default();
    statics.paragraph(&rows::subject(outcome));
    if !mujoco::IS_BUILT_IN {
        statics.paragraph("This program was built without MuJoCo; the other two are compared. To have it:");
        statics.raw(&format!("<pre class=\"command\">{}</pre>\n", escape(&rows::HOW_TO.join("\n"))));
    }
    table(&mut statics, &rows::static_heads(), &rows::static_rows(outcome));
    statics.remark("Differences are relative; those of the centre of mass to its radius of gyration, those of loads to the weight.");
    page.section("statics", "Without replay", statics);
    let mut worst = Part::default();
    if let Some(stroke) = outcome.worst() {
        worst.figure(figure(stroke, motion));
    }
    page.section("differences", "Differences over time", worst);
    page.section("strokes", "Strokes", strokes(outcome, motion));
    page.section("bounds", "Steps and bounds", bounds(outcome, motion));
    let list = [("machine file", machine.file().display().to_string()), version()];
    page.section("provenance", "Where this comes from", provenance::list(&list, command));
    page.finish(&data::of(motion, &[], None))
}

fn table(part: &mut Part, heads: &[String], rows: &[Vec<String>]) {
    let last = heads.len() - 1;
    let marked =
        |(k, head): (usize, &String)| if k == 0 || k == last { head.clone() } else { format!(">{head}") };
    let heads: Vec<String> = heads.iter().enumerate().map(marked).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    part.table(&heads, rows);
}

fn strokes(outcome: &Outcome, motion: Motion) -> Part {
    let mut part = Part::default();
    for stroke in &outcome.strokes {
        part.raw(&format!("<h3>{}</h3>\n", escape(&rows::title(stroke, motion))));
        table(&mut part, &rows::stroke_heads(stroke), &rows::stroke_rows(stroke, motion));
    }
    part.remark("RMS, and in brackets the peak, of each difference.");
    part
}

fn bounds(outcome: &Outcome, motion: Motion) -> Part {
    let mut part = Part::default();
    for line in rows::steps(outcome, motion) {
        part.paragraph(&line);
    }
    let items =
        outcome.bounds().into_iter().map(|bound| format!("<li>{}</li>\n", escape(&rows::reason(&bound))));
    part.raw(&format!("<ul class=\"findings\">\n{}</ul>\n", items.collect::<String>()));
    part
}

/// Differences of a stroke over time, a panel a quantity and a curve a pair.
fn figure(stroke: &Replayed, motion: Motion) -> Figure {
    let quantities = [Quantity::Position, Quantity::Velocity, Quantity::Thrust];
    let charts = quantities
        .into_iter()
        .enumerate()
        .map(|(k, quantity)| Panel::Chart(chart(stroke, quantity, motion, k + 1 == quantities.len())));
    let caption = format!(
        "Differences of the plants on the stroke {}, which comes nearest to a bound of all.",
        rows::title(stroke, motion)
    );
    let mut figure = Figure::new("crosscheck", caption, charts.collect());
    figure.legend = INKS.into_iter().zip(stroke.pairs()).map(|(ink, pair)| (ink, pair.to_string())).collect();
    figure
}

fn chart(stroke: &Replayed, quantity: Quantity, motion: Motion, has_x_labels: bool) -> Chart {
    let of_quantity: Vec<_> = stroke.differences.iter().filter(|d| d.quantity == quantity).collect();
    let all = || of_quantity.iter().flat_map(|difference| &difference.series);
    let scale = Scale::of(rows::unit(quantity, motion), all());
    let samples = of_quantity.first().map_or(0, |difference| difference.series.len());
    let curve = |(ink, difference): (Ink, &&crate::replay::crosscheck::Difference)| {
        let points = difference.series.iter().enumerate();
        Mark::line(ink, points.map(|(k, x)| [k as f64 * stroke.period_s, scale.to(*x)]))
    };
    Chart {
        title: quantity.to_string(),
        x: Axis::linear(if has_x_labels { "time in s" } else { "" }, [0.0, samples as f64 * stroke.period_s]),
        y: Axis::holding(scale.unit.clone(), all().map(|x| scale.to(*x))),
        marks: INKS.into_iter().zip(&of_quantity).map(curve).collect(),
        height: 130.0,
        has_x_labels,
    }
}
