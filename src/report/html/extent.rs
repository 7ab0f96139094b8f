//! How far: before, after, held out and floor, signal by signal.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::verdict::SignalGap;
use crate::recording::Signal;
use crate::report::extent::{noise_sources, overstated};
use crate::report::figure::{Axis, Bar, Bars, Figure, Ink, Panel, Row};
use crate::report::material::Material;
use crate::report::number::{determination, percent, plain, value};
use crate::report::words::name;
use crate::units::Motion;

/// The section.
pub(super) fn part(diagnosis: &Diagnosis, material: &Material) -> Part {
    let mut part = Part::default();
    let gap = &diagnosis.gap;
    part.figure(figure(&gap.signals, material));
    let heads = [
        "signal",
        ">unseen runs, before",
        ">unseen runs, after",
        ">training, before",
        ">training, after",
        ">noise floor σ",
    ];
    let rows: Vec<Vec<String>> = gap.signals.iter().map(|signal| row(signal, material)).collect();
    part.remark("Unseen runs are held out: no parameter was fitted to them.");
    part.table(&heads, &rows);
    part.folded("Peaks, mean errors, determination, noise", detail(diagnosis, material.motion));
    part
}

fn unit(signal: &SignalGap, motion: Motion) -> &'static str {
    Signal::from_key(&signal.signal).map_or("", |(signal, _)| signal.si_unit(motion))
}

fn row(signal: &SignalGap, material: &Material) -> Vec<String> {
    let unit = unit(signal, material.motion);
    let known = Signal::from_key(&signal.signal).map(|(signal, _)| signal);
    let training = material.training.iter().find(|(of, _)| Some(*of) == known);
    let [before, after] = training.map_or([f64::NAN; 2], |(_, both)| *both);
    let numbers = [signal.rms_before, signal.rms_after, before, after, signal.noise];
    [name(&signal.signal)].into_iter().chain(numbers.map(|number| value(number, unit))).collect()
}

/// Bars of every signal on one scale: multiples of its noise.
fn figure(signals: &[SignalGap], material: &Material) -> Figure {
    let motion = material.motion;
    let ratio = |rms: f64, noise: f64| (rms / noise.max(f64::MIN_POSITIVE)).max(1e-3);
    let rows: Vec<Row> = signals
        .iter()
        .map(|signal| {
            let bar = |ink: Ink, rms: f64| Bar {
                ink,
                value: ratio(rms, signal.noise),
                text: format!("{} ({} × noise)", value(rms, unit(signal, motion)), plain(rms / signal.noise)),
            };
            let bars = vec![bar(Ink::Before, signal.rms_before), bar(Ink::After, signal.rms_after)];
            Row { label: name(&signal.signal), bars }
        })
        .collect();
    let all: Vec<f64> = rows.iter().flat_map(|row| &row.bars).map(|bar| bar.value).collect();
    let least = all.iter().copied().fold(1.0, f64::min).max(0.1);
    let most = all.iter().copied().fold(10.0, f64::max);
    let axis = Axis {
        label: "RMS error on unseen runs as a multiple of the signal's noise".to_owned(),
        range: [0.7 * least, 1.2 * most],
        is_log: true,
    };
    Figure::new(
        "extent",
        "RMS of recorded less predicted on unseen runs, signal by signal, before and after; 1 is the noise floor.",
        vec![Panel::Bars(Bars { title: String::new(), axis, rows })],
    )
    .legend([(Ink::Before, material.baseline), (Ink::After, "with the causes, calibrated")])
}

fn detail(diagnosis: &Diagnosis, motion: Motion) -> Part {
    let mut part = Part::default();
    let gap = &diagnosis.gap;
    let rows: Vec<Vec<String>> = gap
        .signals
        .iter()
        .map(|s| {
            let unit = unit(s, motion);
            vec![
                name(&s.signal),
                value(s.peak_before, unit),
                value(s.peak_after, unit),
                value(s.mae_before, unit),
                value(s.mae_after, unit),
                determination(s.r2_before),
                determination(s.r2_after),
            ]
        })
        .collect();
    part.table(
        &[
            "signal",
            ">peak before",
            ">peak after",
            ">mean |error| before",
            ">after",
            ">R² before",
            ">R² after",
        ],
        &rows,
    );
    part.paragraph(&format!("Noise σ: {}.", noise_sources(&gap.signals)));
    if let Some(words) = overstated(&gap.signals) {
        part.paragraph(&format!("Noise is {words}."));
    }
    part.paragraph(&format!(
        "Gap G, all signals together: {} → {} × noise; {} is what noise alone leaves.",
        plain(gap.before),
        plain(gap.after),
        plain(gap.floor)
    ));
    if let Some(scene) = &gap.rigid_body {
        part.paragraph(&format!(
            "Repeated in the rigid-body scene built from URDF and meshes: {} → {} × noise, {} closed ({} on the reduced axis), on {}{}.",
            plain(scene.before),
            plain(scene.after),
            percent(scene.closed),
            percent(scene.closed_on_axis),
            scene.runs.join(", "),
            if scene.has_failed() { ": the explanation is not confirmed there" } else { "" }
        ));
    }
    if let Some(left) = &diagnosis.left {
        part.paragraph(&left.sentence);
    }
    part
}
