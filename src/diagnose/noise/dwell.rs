//! Noise from standstill.

use super::standstill::settled;
use super::vibration::{self, Shaken};
use crate::diagnose::experiment::Experiment;
use crate::recording::Signal;
use crate::replay::start::is_steady;
use std::collections::BTreeMap;

/// Scatter at standstill is taken over windows of this length, in s.
const STANDSTILL_S: f64 = 0.1;

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

/// Sum of squares about the least-squares line.
fn scatter(samples: &[f64]) -> f64 {
    vibration::levelled(samples).iter().map(|y| y * y).sum()
}
