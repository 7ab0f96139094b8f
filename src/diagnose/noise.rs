//! The noise floor: how much of each signal not even a perfect twin could predict.

mod dwell;
pub(in crate::diagnose) mod standstill;
pub(in crate::diagnose) mod vibration;

use super::experiment::Experiment;
use super::thresholds::STATED_NOISE;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::Traces;
use crate::twin::Sensing;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use vibration::Shaken;

/// Where a noise floor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
    /// In a comparison: what the twin of the machine as it was leaves of the reference recording.
    Reference,
}

/// σ of each signal over time, and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    levels: BTreeMap<Signal, (f64, Source)>,
    profiles: BTreeMap<Channel, Vec<f64>>,
    /// σ of what one position sensor reads more than the other, from repeats; without them it is that of both together.
    between_sensors: Option<f64>,
    /// Signals whose noise was not seen in the recording, but only stated.
    unseen: BTreeSet<Signal>,
    /// Of a floor beside what a twin leaves anyway, the noise's own share of σ² of each signal that is raised by it.
    shares: BTreeMap<Signal, f64>,
}

/// Floors this close in RMS are the same.
const SAME_FLOOR: f64 = 0.1;
/// Fraction of a signal's RMS below which a floor would only measure rounding of numbers.
const LEAST_FRACTION: f64 = 1e-12;
/// Fraction of a signal's RMS taken where nothing is known.
const ASSUMED_FRACTION: f64 = 1e-4;

impl Floor {
    /// Estimates the floor: from repeats, else from declared noise and the scatter at standstill.
    ///
    /// # Model
    /// Declared noise reaches every signal through the loop of `machine`: σ(t) is the RMS difference between
    /// logs with it and what the same twin predicts of them from the start that it reads off each, over several draws and a short window of time. It is
    /// not the same all the time: a start is known as well as a few samples tell it, and what it is off by dies out with the transient after it; on a
    /// guide with dry friction, noise shakes a resting axis loose at moments that nobody can predict, and σ grows where that happens.
    /// The signal's level is the median of σ(t); the rest is its profile, at least 1.
    /// At standstill a stuck axis shows less noise than a moving one, and one that a coarse encoder holds between two steps shows more: a limit cycle.
    /// So the scatter at standstill raises the declared noise only by how far it exceeds both that and what the twin's own logs with declared
    /// noise show at the same standstills.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn estimate(machine: &Machine, experiments: &[&Experiment]) -> Result<Self> {
        let shaken = vibration::frequencies(machine, experiments)?;
        let repeats = repeats(experiments, &shaken);
        let dwell = dwell::scatters(experiments, &shaken);
        let declared = Declared::of(machine, experiments)?;
        let made = declared.scatters(machine, experiments, &shaken)?;
        let mut levels = BTreeMap::new();
        let mut unseen = BTreeSet::new();
        for signal in experiments.iter().flat_map(|e| e.signals()).copied() {
            let own_size = size(experiments, signal);
            // Of a signal that is zero throughout any σ serves, it must only be a number.
            let size = if own_size == 0.0 { 1.0 } else { own_size };
            let least = LEAST_FRACTION * size;
            let still = dwell.get(&signal).map(|&sigma| (sigma, Source::Dwell));
            let stated = declared.level(signal).map(|sigma| {
                let own = made.get(&signal).map_or(sigma, |&made| sigma.max(made));
                match still {
                    Some((still, source)) if still > own => (sigma * still / own, source),
                    _ => (sigma, Source::Declared),
                }
            });
            let repeated = repeats.get(&signal).map(|&sigma| (sigma, Source::Repeats));
            let level = repeated
                .or(stated)
                .or(still)
                .filter(|(sigma, _)| *sigma > least)
                .unwrap_or((ASSUMED_FRACTION * size, Source::Assumed));
            let seen = repeated.or(still).map_or(0.0, |(sigma, _)| sigma);
            // A signal that is zero throughout says nothing of its noise, and has no gap either.
            if own_size != 0.0 && STATED_NOISE * seen * seen < level.0 * level.0 {
                unseen.insert(signal);
            }
            levels.insert(signal, level);
        }
        let profiles = declared.profiles(&levels);
        Ok(Self {
            levels,
            profiles,
            between_sensors: repeats_between(experiments),
            unseen,
            shares: BTreeMap::new(),
        })
    }

    /// The floor with what a twin leaves anyway, RMS of each signal in SI, as far as it is more than noise.
    ///
    /// # Model
    /// σ'(t)² = σ(t)² + max(0, r² − mean σ²): what no twin at hand has described is there at all times alike.
    #[must_use]
    pub fn beside(mut self, left: &BTreeMap<Signal, f64>) -> Self {
        for (signal, rms) in left {
            let Some((level, source)) = self.levels.get_mut(signal) else { continue };
            let own = self.profiles.iter_mut().filter(|((_, s), _)| s == signal);
            let profiles: Vec<&mut Vec<f64>> = own.map(|(_, profile)| profile).collect();
            let noise = mean_square(profiles.iter().flat_map(|p| p.iter().copied())).unwrap_or(1.0);
            let structure = (rms * rms - noise * *level * *level).max(0.0);
            let raised = (*level * *level + structure).sqrt();
            if structure > 0.0 {
                self.shares.insert(*signal, (*level / raised).powi(2));
            }
            for sigma in profiles.into_iter().flatten() {
                *sigma = ((*sigma * *level).powi(2) + structure).sqrt() / raised;
            }
            if structure > *level * *level {
                *source = Source::Reference;
            }
            *level = raised;
        }
        self
    }

    /// Residuals of one signal of a run, recorded less predicted, in units of their noise.
    pub fn normalised(&self, experiment: &Experiment, signal: Signal, predicted: &Traces) -> Vec<f64> {
        self.normalised_every(experiment, signal, predicted, 1)
    }

    /// Every so many of these residuals one, from the first on.
    pub fn normalised_every(
        &self,
        experiment: &Experiment,
        signal: Signal,
        predicted: &Traces,
        stride: usize,
    ) -> Vec<f64> {
        let measured = experiment.run().signal(signal).unwrap_or_default();
        let pairs = measured.iter().zip(predicted.signal(signal).unwrap_or_default());
        let scale = 1.0 / self.sigma(signal);
        let even = |(m, p): (&f64, &f64)| (m - p) * scale;
        let uneven = |(pair, wider): ((&f64, &f64), &f64)| even(pair) / wider;
        // Without a stride the loops are over slices, which become vector instructions.
        match (self.profile(experiment, signal), stride) {
            (None, 1) => pairs.map(even).collect(),
            (None, _) => pairs.step_by(stride).map(even).collect(),
            (Some(profile), 1) => pairs.zip(profile).map(uneven).collect(),
            (Some(profile), _) => pairs.zip(profile).step_by(stride).map(uneven).collect(),
        }
    }

    /// Residuals of what one position sensor of a run reads more than the other, in units of the noise of both together;
    /// none where there is one sensor only.
    pub fn between_sensors(&self, experiment: &Experiment, predicted: &Traces) -> Option<Vec<f64>> {
        experiment.second_sensor()?;
        let residual = |signal: Signal| -> Option<Vec<f64>> {
            let pairs = experiment.run().signal(signal)?.iter().zip(predicted.signal(signal)?);
            Some(pairs.map(|(m, p)| m - p).collect())
        };
        let (motor, load) = (residual(Signal::Position)?, residual(Signal::LoadPosition)?);
        let scale = 1.0 / self.sigma_between_sensors();
        Some(motor.iter().zip(load).map(|(motor, load)| (motor - load) * scale).collect())
    }

    /// σ of what one position sensor reads more than the other, in SI.
    pub fn sigma_between_sensors(&self) -> f64 {
        let both = self.sigma(Signal::Position).hypot(self.sigma(Signal::LoadPosition));
        self.between_sensors.map_or(both, |own| own.min(both))
    }

    /// ln(σ(t)/σ₀(t)) of a signal of a run against another floor.
    pub fn widening(&self, other: &Self, experiment: &Experiment, signal: Signal) -> Vec<f64> {
        let logarithms = |floor: &Self| -> Vec<f64> {
            let level = floor.sigma(signal).ln();
            match floor.profile(experiment, signal) {
                None => vec![level; experiment.samples()],
                Some(profile) => profile.iter().map(|wider| level + wider.ln()).collect(),
            }
        };
        logarithms(self).iter().zip(logarithms(other)).map(|(own, other)| own - other).collect()
    }

    /// σ(t) of a signal of a run in units of the signal's level, at least 1; none where it is 1 throughout.
    pub fn profile(&self, experiment: &Experiment, signal: Signal) -> Option<&[f64]> {
        self.profiles.get(&(experiment.run().name().to_string(), signal)).map(Vec::as_slice)
    }

    /// What noise leaves of a signal over these runs, RMS in SI: level and profile together.
    pub fn root_mean_square(&self, signal: Signal, experiments: &[Experiment]) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for experiment in experiments {
            let samples = experiment.samples() as f64;
            sum += match self.profile(experiment, signal) {
                None => samples,
                Some(profile) => profile.iter().map(|wider| wider * wider).sum(),
            };
            count += samples;
        }
        self.sigma(signal) * (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Whether another floor of these runs says the same, within what a few draws of noise leave open.
    pub fn is_like(&self, other: &Self, experiments: &[Experiment]) -> bool {
        self.levels.keys().all(|&signal| {
            let ratio =
                self.root_mean_square(signal, experiments) / other.root_mean_square(signal, experiments);
            (ratio - 1.0).abs() < SAME_FLOOR
        })
    }

    /// σ of a signal in SI.
    pub fn sigma(&self, signal: Signal) -> f64 {
        self.levels.get(&signal).map_or(1.0, |level| level.0)
    }

    /// Whether the noise of every signal was seen in the recording and not only stated: in repeats, or at standstill as at least
    /// a tenth of the power that is stated.
    pub fn is_measured(&self) -> bool {
        self.unseen.is_empty()
    }

    /// Share of a signal's σ² that is noise for certain. In a comparison the rest is what the twin leaves of the reference: an explanation of this
    /// recording may leave less.
    pub fn noise_share(&self, signal: Signal) -> f64 {
        self.shares.get(&signal).copied().unwrap_or(1.0)
    }

    /// Whether that is so of a signal, and nothing that the twin leaves of a reference is on top of its noise.
    pub(super) fn is_seen(&self, signal: Signal) -> bool {
        !self.unseen.contains(&signal) && self.source(signal) != Source::Reference
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

/// σ from runs with the same command, settings and length: their differences have twice the variance. A signal
/// whose zero means nothing is compared about its mean.
fn repeats(experiments: &[&Experiment], shaken: &Shaken) -> BTreeMap<Signal, f64> {
    let mut sums: BTreeMap<Signal, (f64, usize)> = BTreeMap::new();
    for (a, b) in repeated(experiments) {
        let of = |e: &Experiment| shaken.get(e.run().name()).cloned().unwrap_or_default();
        let shaken = [of(a), of(b)].concat();
        for &signal in a.signals() {
            let (Some(x), Some(y)) = (a.run().signal(signal), b.run().signal(signal)) else { continue };
            let differences: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
            let differences = vibration::without(&differences, &shaken, a.run().sample_period_s());
            let sum = sums.entry(signal).or_insert((0.0, 0));
            sum.0 += squares(&differences, a.second_sensor() == Some(signal));
            sum.1 += 2 * x.len();
        }
    }
    sums.into_iter().map(|(signal, (sum, count))| (signal, (sum / count as f64).sqrt())).collect()
}

/// σ of what one position sensor reads more than the other, from repeats: what both sensors follow is not in it.
fn repeats_between(experiments: &[&Experiment]) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for (a, b) in repeated(experiments) {
        let (Some(x), Some(y)) = (between(a), between(b)) else { continue };
        let differences: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
        sum += squares(&differences, true);
        count += 2 * differences.len();
    }
    (sum > 0.0).then(|| (sum / count as f64).sqrt())
}

/// What one position sensor of a run reads more than the other.
fn between(experiment: &Experiment) -> Option<Vec<f64>> {
    experiment.second_sensor()?;
    let signal = |signal| experiment.run().signal(signal);
    let (motor, load) = (signal(Signal::Position)?, signal(Signal::LoadPosition)?);
    Some(motor.iter().zip(load).map(|(motor, load)| motor - load).collect())
}

/// Sum of squares, of deviations from the mean where that means nothing.
fn squares(differences: &[f64], about_mean: bool) -> f64 {
    let mean = if about_mean { differences.iter().sum::<f64>() / differences.len() as f64 } else { 0.0 };
    differences.iter().map(|difference| (difference - mean).powi(2)).sum()
}

/// Pairs of runs with the same command, settings and length.
fn repeated<'a>(experiments: &[&'a Experiment]) -> Vec<(&'a Experiment, &'a Experiment)> {
    let same = |a: &Experiment, b: &Experiment| {
        // In windows the measured input tells repeats apart: their difference is no noise.
        let closed = a.input().is_none() && b.input().is_none();
        closed && a.recorded().commands() == b.recorded().commands() && a.run().settings == b.run().settings
    };
    let from = |k: usize| experiments[k + 1..].iter().map(move |b| (experiments[k], *b));
    (0..experiments.len()).flat_map(from).filter(|(a, b)| same(a, b)).collect()
}

/// Draws of the declared noise; with the window below, σ(t) is known within some 10 %.
const DRAWS: u64 = 4;
/// Half width of the window over which σ(t) is averaged, in s.
const WINDOW_S: f64 = 10e-3;

/// A signal of a run.
type Channel = (String, Signal);

/// σ(t) of each signal of each run from the declared noise of the sensors.
struct Declared {
    sigma: BTreeMap<Channel, Vec<f64>>,
}

impl Declared {
    fn of(machine: &Machine, experiments: &[&Experiment]) -> Result<Self> {
        if machine.description().has_perfect_sensors() {
            return Ok(Self { sigma: BTreeMap::new() });
        }
        let all: Result<Vec<Vec<_>>> = experiments.par_iter().map(|e| Self::of_run(machine, e)).collect();
        Ok(Self { sigma: all?.into_iter().flatten().collect() })
    }

    fn of_run(machine: &Machine, experiment: &Experiment) -> Result<Vec<(Channel, Vec<f64>)>> {
        let known = experiment.predict(machine, Sensing::Perfect)?;
        let mut squares = vec![vec![0.0; experiment.samples()]; experiment.signals().len()];
        for seed in 0..DRAWS {
            let noisy = experiment.predict(machine, Sensing::AsStated { seed })?;
            let read = experiment.foreseen(machine, &noisy)?;
            let clean = read.as_ref().unwrap_or(&known);
            for (sum, &signal) in squares.iter_mut().zip(experiment.signals()) {
                let (a, b) = (clean.signal(signal), noisy.signal(signal));
                let pairs = a.unwrap_or_default().iter().zip(b.unwrap_or_default());
                for (sum, (a, b)) in sum.iter_mut().zip(pairs) {
                    *sum += (a - b) * (a - b) / DRAWS as f64;
                }
            }
        }
        if experiment.machine(machine)?.constants().reading_step > 0.0 {
            squares.iter_mut().for_each(|squares| spread(squares));
        }
        let half = (WINDOW_S / experiment.run().sample_period_s()).round() as usize;
        let name = experiment.run().name().to_string();
        let keyed = squares.into_iter().zip(experiment.signals());
        Ok(keyed.map(|(s, &signal)| ((name.clone(), signal), moving_root_mean(&s, half))).collect())
    }

    /// σ at standstill of the twin's own logs with declared noise; none where no noise is declared.
    fn scatters(
        &self,
        machine: &Machine,
        experiments: &[&Experiment],
        shaken: &Shaken,
    ) -> Result<BTreeMap<Signal, f64>> {
        if self.sigma.is_empty() {
            return Ok(BTreeMap::new());
        }
        let imagined: Vec<Experiment> =
            experiments.par_iter().map(|e| e.imagined(machine, 0)).collect::<Result<_>>()?;
        Ok(dwell::scatters(&imagined.iter().collect::<Vec<_>>(), shaken))
    }

    fn level(&self, signal: Signal) -> Option<f64> {
        let of_signal = self.sigma.iter().filter(|((_, s), _)| *s == signal);
        let mut all: Vec<f64> = of_signal.flat_map(|(_, sigma)| sigma).copied().collect();
        if all.is_empty() {
            return None;
        }
        let middle = all.len() / 2;
        Some(*all.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    fn profiles(self, levels: &BTreeMap<Signal, (f64, Source)>) -> BTreeMap<Channel, Vec<f64>> {
        let widen = |((name, signal), sigma): (Channel, Vec<f64>)| {
            let level = levels.get(&signal).map_or(1.0, |level| level.0);
            ((name, signal), sigma.into_iter().map(|s| (s / level).max(1.0)).collect())
        };
        self.sigma.into_iter().map(widen).collect()
    }
}

/// Where positions are read in coarse steps, a replay and the same replay with noise read alike for long, but where between
/// two steps the axis truly stands nobody knows: at no time is a square less than the mean of all.
fn spread(squares: &mut [f64]) {
    let mean = mean_square(squares.iter().map(|s| s.sqrt())).unwrap_or(0.0);
    squares.iter_mut().for_each(|square| *square = square.max(mean));
}

/// Root of the mean of squares over a window of `2·half + 1` samples, cut at the ends.
fn moving_root_mean(squares: &[f64], half: usize) -> Vec<f64> {
    let mut sums = Vec::with_capacity(squares.len() + 1);
    sums.push(0.0);
    for square in squares {
        sums.push(sums[sums.len() - 1] + square);
    }
    (0..squares.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(half), (k + half + 1).min(squares.len()));
            ((sums[to] - sums[from]).max(0.0) / (to - from) as f64).sqrt()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a twin leaves anyway adds to the variance at all times alike; what is no more than noise adds nothing.
    #[test]
    fn exact_what_is_left_anyway_adds_in_variance() {
        let channel = ("a".to_string(), Signal::Position);
        let floor = Floor {
            levels: BTreeMap::from([(Signal::Position, (3.0, Source::Declared))]),
            profiles: BTreeMap::from([(channel.clone(), vec![1.0, 1.0, 2.0, 2.0])]),
            between_sensors: None,
            unseen: BTreeSet::from([Signal::Position]),
            shares: BTreeMap::new(),
        };
        // The mean of the variances is 22.5.
        let same = floor.clone().beside(&BTreeMap::from([(Signal::Position, 4.7), (Signal::Velocity, 1.0)]));
        assert_eq!(same, floor);
        let raised = floor.beside(&BTreeMap::from([(Signal::Position, 8.0)]));
        assert!((raised.noise_share(Signal::Position) - 9.0 / 50.5).abs() < 1e-12);
        assert_eq!([same.noise_share(Signal::Position), raised.noise_share(Signal::Velocity)], [1.0; 2]);
        let sigma: Vec<f64> =
            raised.profiles[&channel].iter().map(|p| p * raised.sigma(Signal::Position)).collect();
        for (sigma, own) in sigma.iter().zip([9.0, 9.0, 36.0, 36.0_f64]) {
            assert!((sigma - (own + 41.5).sqrt()).abs() < 1e-12);
        }
        assert_eq!((raised.profiles[&channel][0], raised.source(Signal::Position)), (1.0, Source::Reference));
    }

    /// Between two coarse steps a replay and one with noise read alike most of the time; the floor there is their mean
    /// square difference, and where they differ more it stays.
    #[test]
    fn exact_coarse_steps_leave_the_mean_difference_at_all_times() {
        let mut squares = vec![0.0, 0.0, 0.0, 16.0];
        spread(&mut squares);
        assert_eq!(squares, [4.0, 4.0, 4.0, 16.0]);
    }
}
