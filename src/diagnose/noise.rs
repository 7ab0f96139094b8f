//! The noise floor: how much of each signal not even a perfect twin could predict.

use super::experiment::{Experiment, trace};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;
use serde::Serialize;
use std::collections::BTreeMap;

/// Where a noise floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// Difference of runs with the same command.
    Repeats,
    /// Scatter at standstill.
    Dwell,
    /// Declared noise and resolution of the sensors, carried through the control loop by the twin.
    Declared,
    /// Nothing to go by: 10⁻⁴ of the signal's own size.
    Assumed,
}

/// σ of each signal and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    levels: BTreeMap<Signal, (f64, Source)>,
}

/// Fraction of a signal's RMS below which a floor would only measure rounding.
const LEAST_FRACTION: f64 = 1e-6;
/// Fraction of a signal's RMS taken where nothing is known.
const ASSUMED_FRACTION: f64 = 1e-4;

impl Floor {
    /// Estimates the floor: from repeats, else the larger of standstill scatter and declared noise.
    ///
    /// # Model
    /// Declared noise reaches every signal through the loop: σ is the RMS difference between replays with and
    /// without it. At standstill a stuck axis shows less noise than a moving one, hence the larger of the two.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn estimate(machine: &Machine, experiments: &[&Experiment]) -> Result<Self> {
        let repeats = repeats(experiments);
        let dwell = dwell(experiments);
        let declared = declared(machine, experiments)?;
        let mut levels = BTreeMap::new();
        for signal in experiments.iter().flat_map(|e| e.signals()).copied() {
            let size = size(experiments, signal).max(f64::MIN_POSITIVE);
            let least = LEAST_FRACTION * size;
            let still = dwell.get(&signal).map(|&sigma| (sigma, Source::Dwell));
            let stated = declared.get(&signal).map(|&sigma| (sigma, Source::Declared));
            let repeated = repeats.get(&signal).map(|&sigma| (sigma, Source::Repeats));
            let level = repeated
                .or_else(|| still.into_iter().chain(stated).max_by(|a, b| a.0.total_cmp(&b.0)))
                .filter(|(sigma, _)| *sigma > least)
                .unwrap_or((ASSUMED_FRACTION * size, Source::Assumed));
            levels.insert(signal, level);
        }
        Ok(Self { levels })
    }

    /// σ of a signal in SI.
    pub fn sigma(&self, signal: Signal) -> f64 {
        self.levels.get(&signal).map_or(1.0, |level| level.0)
    }

    /// Where a signal's σ comes from.
    pub fn source(&self, signal: Signal) -> Source {
        self.levels.get(&signal).map_or(Source::Assumed, |level| level.1)
    }
}

fn mean_square(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v * v, count + 1));
    (count > 0).then(|| sum / count as f64)
}

fn size(experiments: &[&Experiment], signal: Signal) -> f64 {
    let samples = experiments.iter().filter_map(|e| e.run().signal(signal)).flatten().copied();
    mean_square(samples).unwrap_or(0.0).sqrt()
}

/// σ from runs with the same command, settings and length: their differences have twice the variance.
fn repeats(experiments: &[&Experiment]) -> BTreeMap<Signal, f64> {
    let mut sums: BTreeMap<Signal, (f64, usize)> = BTreeMap::new();
    for (k, a) in experiments.iter().enumerate() {
        for b in &experiments[k + 1..] {
            let same =
                a.recorded().commands() == b.recorded().commands() && a.run().settings == b.run().settings;
            if !same {
                continue;
            }
            for &signal in a.signals() {
                let (Some(x), Some(y)) = (a.run().signal(signal), b.run().signal(signal)) else { continue };
                let sum = sums.entry(signal).or_insert((0.0, 0));
                sum.0 += x.iter().zip(y).map(|(x, y)| (x - y) * (x - y)).sum::<f64>();
                sum.1 += 2 * x.len();
            }
        }
    }
    sums.into_iter().map(|(signal, (sum, count))| (signal, (sum / count as f64).sqrt())).collect()
}

/// Standstill must last so long, in s, before its scatter counts.
const STANDSTILL_S: f64 = 0.1;
/// After the reference has stopped, the axis settles for so long, in s.
const SETTLING_S: f64 = 0.4;

/// σ from standstill: half the mean square of second differences' share that white noise would give is not
/// robust to slow settling, so a straight line is taken off each stretch first.
fn dwell(experiments: &[&Experiment]) -> BTreeMap<Signal, f64> {
    let mut sums: BTreeMap<Signal, (f64, usize)> = BTreeMap::new();
    for experiment in experiments {
        let period = experiment.run().sample_period_s();
        let (settle, least) = ((SETTLING_S / period) as usize, (STANDSTILL_S / period) as usize);
        for (from, to) in standstills(experiment) {
            let from = if from == 0 { 0 } else { from + settle };
            if to < from + least.max(8) {
                continue;
            }
            for &signal in experiment.signals() {
                let Some(samples) = experiment.run().signal(signal) else { continue };
                let sum = sums.entry(signal).or_insert((0.0, 0));
                sum.0 += scatter(&samples[from..to]);
                sum.1 += to - from - 2;
            }
        }
    }
    sums.into_iter().map(|(signal, (sum, count))| (signal, (sum / count as f64).sqrt())).collect()
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
    let count = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let middle = 0.5 * (count - 1.0);
    let (mut cross, mut spread) = (0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        cross += (k as f64 - middle) * (sample - mean);
        spread += (k as f64 - middle).powi(2);
    }
    let slope = cross / spread;
    samples.iter().enumerate().map(|(k, y)| (y - mean - slope * (k as f64 - middle)).powi(2)).sum()
}

/// Runs from which the declared noise is carried through the loop; a few suffice for a σ within percents.
const NOISE_RUNS: usize = 3;

fn declared(machine: &Machine, experiments: &[&Experiment]) -> Result<BTreeMap<Signal, f64>> {
    let description = machine.description();
    let silent = description.encoder.noise_m == 0.0
        && description.encoder.resolution_m == 0.0
        && description.current_sensor.noise_a == 0.0;
    if silent {
        return Ok(BTreeMap::new());
    }
    let mut sums: BTreeMap<Signal, (f64, usize)> = BTreeMap::new();
    for (seed, experiment) in experiments.iter().take(NOISE_RUNS).enumerate() {
        let clean = experiment.predict(machine, Sensing::Perfect)?;
        let noisy = experiment.predict(machine, Sensing::AsStated { seed: seed as u64 })?;
        for &signal in experiment.signals() {
            let sum = sums.entry(signal).or_insert((0.0, 0));
            let pairs = trace(&clean, signal).iter().zip(trace(&noisy, signal));
            sum.0 += pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            sum.1 += experiment.samples();
        }
    }
    Ok(sums.into_iter().map(|(signal, (sum, count))| (signal, (sum / count as f64).sqrt())).collect())
}
