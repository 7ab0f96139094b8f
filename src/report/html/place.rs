//! Where: along the signal path, in time and phase, frequency, position, speed.

use super::page::Part;
use super::scale::{Scale, speed_word};
use crate::diagnose::Diagnosis;
use crate::diagnose::verdict::{Band, Share};
use crate::effect::Site;
use crate::report::figure::{Axis, Chart, Figure, Heat, Ink, Mark, Panel, SignalPath};
use crate::report::material::{Material, RunTraces};
use crate::report::number::percent;
use crate::report::place::blocks;

/// Cells of the strip along time.
const CELLS: usize = 60;

/// The section.
pub(super) fn part(diagnosis: &Diagnosis, material: &Material) -> Part {
    let mut part = Part::default();
    let place = &diagnosis.place;
    part.figure(path(&place.site));
    let blocks = blocks(&place.site);
    if !blocks.is_empty() {
        part.remark(&format!("Not separated by any logged signal: {}.", blocks.join(" · ")));
    }
    if !place.segment.is_empty() {
        let list: Vec<String> = place
            .segment
            .iter()
            .map(|s| format!("{} {}", s.name.replace('+', " + "), percent(s.share)))
            .collect();
        part.remark(&format!(
            "Between logged signals (what a cause closes where it acts; what stays open by the residual of each, replayed alone): {}.",
            list.join(" · ")
        ));
    }
    if let Some(run) = material.runs.iter().find(|run| run.is_held_out) {
        part.figure(along_time(run, diagnosis, material));
    }
    part.figure(shares(diagnosis, material));
    part
}

fn path(shares: &[Share]) -> Figure {
    let share = |site: Site| shares.iter().find(|s| s.name == site.name()).map_or(f64::NAN, |s| s.share);
    let sites = Site::ALL.iter().map(|&site| (site.name().to_owned(), share(site), percent(share(site))));
    let path = SignalPath { sites: sites.collect() };
    Figure::new("path", "The signal path, and the share of the gap at each site.", vec![Panel::Path(path)])
}

/// Edges of bands as an axis; bands of unequal width count one cell each.
fn banded(title: &str, bands: &[Band], scale: &Scale, unit: &str) -> Panel {
    let shares = bands.iter().map(|band| band.share).collect();
    let [from, to] = [bands.first().map_or(0.0, |b| b.from), bands.last().map_or(1.0, |b| b.to)];
    let even = (to - from) / bands.len().max(1) as f64;
    let is_even = bands.iter().all(|b| ((b.to - b.from) - even).abs() < 1e-6 * (to - from).abs());
    let names = if is_even {
        Vec::new()
    } else {
        bands.iter().map(|b| format!("{} to {}", short(scale.to(b.from)), short(scale.to(b.to)))).collect()
    };
    let axis = Axis::linear(scale.label(unit), [scale.to(from), scale.to(to)]);
    let title = if is_even { title.to_owned() } else { format!("{title}, {}", scale.unit) };
    Panel::Heat(Heat { title, axis, shares, names })
}

fn short(value: f64) -> String {
    format!("{}", (value * 1000.0).round() / 1000.0)
}

fn shares(diagnosis: &Diagnosis, material: &Material) -> Figure {
    let (place, motion) = (&diagnosis.place, material.motion);
    let mut panels = vec![Panel::Heat(Heat {
        title: "By phase of the motion".to_owned(),
        axis: Axis::linear("", [0.0, 1.0]),
        shares: place.phase.iter().map(|s| s.share).collect(),
        names: place.phase.iter().map(|s| s.name.clone()).collect(),
    })];
    let edges = |bands: &[Band]| -> Vec<f64> { bands.iter().flat_map(|b| [b.from, b.to]).collect() };
    let hertz = Scale { factor: 1.0, unit: "Hz".to_owned() };
    if !place.frequency_hz.is_empty() {
        panels.push(banded("By frequency", &place.frequency_hz, &hertz, "frequency"));
    }
    if !place.position.is_empty() {
        let scale = Scale::position(motion, &edges(&place.position));
        panels.push(banded("By position", &place.position, &scale, "position"));
    }
    if !place.speed.is_empty() {
        let scale = Scale::speed(motion, &edges(&place.speed));
        panels.push(banded("By commanded speed", &place.speed, &scale, speed_word(motion)));
    }
    let caption = format!(
        "Shares of the gap of the {}, on unseen runs: the stronger the colour, the more of it lies there.",
        material.baseline
    );
    Figure::new("where", caption, panels)
}

/// The commanded position of one run with the gap in time below it.
fn along_time(run: &RunTraces, diagnosis: &Diagnosis, material: &Material) -> Figure {
    let samples = run.samples();
    let mut energy = vec![0.0; CELLS];
    for gap in &diagnosis.gap.signals {
        let trace = run.traces.iter().find(|t| t.signal.key(material.motion) == gap.signal);
        let Some(trace) = trace.filter(|_| gap.noise > 0.0) else { continue };
        for (k, (m, p)) in trace.measured.iter().zip(&trace.before).enumerate() {
            energy[(k * CELLS / samples.max(1)).min(CELLS - 1)] += ((m - p) / gap.noise).powi(2);
        }
    }
    let total: f64 = energy.iter().sum();
    let end = run.time_s(samples);
    let scale = Scale::position(material.motion, &run.reference);
    let points = run.reference.iter().enumerate().map(|(k, x)| [run.time_s(k), scale.to(*x)]);
    let mut marks = vec![Mark::line(Ink::Reference, points)];
    marks.extend(run.events.iter().map(|e| Mark::Event { x: e.time_s, word: e.word.to_owned() }));
    let chart = Chart {
        title: format!("Commanded position, run {}", run.name),
        x: Axis::linear("", [0.0, end]),
        y: Axis::holding(scale.unit.clone(), run.reference.iter().map(|x| scale.to(*x))),
        marks,
        height: 90.0,
        has_x_labels: false,
    };
    // The strip lies below the drawn area of the chart.
    let strip = Chart {
        title: "share of the run's gap".to_owned(),
        x: Axis::linear("time in s", [0.0, end]),
        y: Axis::linear("%", [0.0, 100.0 * energy.iter().copied().fold(0.0, f64::max) / total.max(1e-300)]),
        marks: vec![Mark::line(
            Ink::Before,
            energy.iter().enumerate().flat_map(|(k, e)| {
                let share = 100.0 * e / total.max(1e-300);
                let at = |edge: usize| (k + edge) as f64 * end / CELLS as f64;
                [[at(0), share], [at(1), share]]
            }),
        )],
        height: 90.0,
        has_x_labels: true,
    };
    let caption =
        "When the gap arises: the commanded position, and the share of the run's squared error by time.";
    Figure::new("time", caption, vec![Panel::Chart(chart), Panel::Chart(strip)])
}
