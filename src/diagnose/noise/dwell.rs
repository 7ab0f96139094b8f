//! Noise from standstill.

use super::vibration::{self, Shaken};
use crate::diagnose::experiment::Experiment;
use crate::recording::Signal;
use crate::replay::recorded::is_steady;
use std::collections::BTreeMap;
use std::ops::Range;

/// Scatter at standstill is taken over windows of this length, in s.
const STANDSTILL_S: f64 = 0.1;
/// After the reference has stopped, the axis settles for so long, in s.
const SETTLING_S: f64 = 0.4;

/// σ from standstill: the median, over windows of [`STANDSTILL_S`], of the scatter about each window's straight
/// line, windows in which the axis still settles left out. A vibration that shakes the axis there is motion, not noise.
pub fn scatters(experiments: &[&Experiment], shaken: &Shaken) -> BTreeMap<Signal, f64> {
    let mut windows: BTreeMap<Signal, Vec<f64>> = BTreeMap::new();
    for experiment in experiments {
        let period = experiment.run().sample_period_s();
        let shaken = shaken.get(experiment.run().name()).map_or(&[][..], Vec::as_slice);
        let width = ((STANDSTILL_S / period) as usize).max(8);
        for still in settled(experiment) {
            for &signal in experiment.signals() {
                let Some(samples) = experiment.run().signal(signal) else { continue };
                let still = vibration::without(&samples[still.clone()], shaken, period);
                let steady = still.chunks_exact(width).filter(|window| is_steady(window));
                let scatters = steady.map(|w| scatter(w) / (w.len() - 2) as f64);
                windows.entry(signal).or_default().extend(scatters);
            }
        }
    }
    let median = |mut list: Vec<f64>| {
        let middle = list.len() / 2;
        (!list.is_empty()).then(|| list.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt())
    };
    windows.into_iter().filter_map(|(signal, list)| Some((signal, median(list)?))).collect()
}

/// Stretches of samples in which the reference does not move and the axis has settled.
pub fn settled(experiment: &Experiment) -> Vec<Range<usize>> {
    let settle = (SETTLING_S / experiment.run().sample_period_s()) as usize;
    let settled = |(from, to): (usize, usize)| if from == 0 { 0..to } else { from + settle..to };
    standstills(experiment).into_iter().map(settled).filter(|still| still.start < still.end).collect()
}

/// Stretches of samples in which the reference does not move.
fn standstills(experiment: &Experiment) -> Vec<(usize, usize)> {
    let commands = experiment.recorded().commands();
    let mut stretches = Vec::new();
    let mut from = 0;
    for k in 1..=commands.len() {
        let moves =
            k == commands.len() || commands[k].position_reference != commands[k - 1].position_reference;
        if moves {
            if k - from > 1 {
                stretches.push((from, k));
            }
            from = k;
        }
    }
    stretches
}

/// Sum of squares about the least-squares line.
fn scatter(samples: &[f64]) -> f64 {
    vibration::levelled(samples).iter().map(|y| y * y).sum()
}
