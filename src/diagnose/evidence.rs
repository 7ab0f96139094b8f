//! Held-out evidence: how well fitted hypotheses predict runs they have not seen.

use super::autocorrelation::autocorrelation_time;
use super::experiment::{Experiment, HeldOut};
use super::noise::Floor;
use super::scalar_product::dot;
use super::thresholds::{ADEQUATE_GAP, quiet_signal};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::Traces;
use crate::twin::Sensing;
use rayon::prelude::*;

/// Sums of squared normalised residuals on the held-out runs, block by block and channel by channel.
#[derive(Debug, Clone)]
pub struct Score {
    /// One entry a block of consecutive samples, then one a channel: the recording's signals in their order, then what
    /// stands between two position sensors.
    blocks: Vec<Vec<Cell>>,
    /// Autocorrelation time of the residuals in samples, per channel: 1 for white noise, more for structure.
    autocorrelation_times: Vec<(Channel, f64)>,
    /// Of two position sensors, the one that tells nothing of the loop that the other and their difference do not tell.
    second_sensor: Option<Signal>,
    /// Mean square that its noise leaves of each channel for certain; 1 of those not listed (see [`Floor::noise_share`]).
    least: Vec<(Channel, f64)>,
    /// Whether the noise of each channel was seen in the recording and not only stated; it was of those not listed.
    is_seen: Vec<(Channel, bool)>,
}

/// What residuals are taken of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channel {
    /// A logged signal.
    Signal(Signal),
    /// What one position sensor reads more than the other.
    BetweenSensors,
}

/// What a block of samples shows of one channel.
#[derive(Debug, Clone, Copy)]
struct Cell {
    channel: Channel,
    /// Sum of squared normalised residuals.
    squares: f64,
    /// Sum of ln(σ/σ₀), where the noise floor is not the one that all hypotheses share.
    widening: f64,
    samples: usize,
}

/// Blocks over all held-out runs together; fewer than twenty leave a bootstrap without spread.
pub(super) const BLOCKS: usize = 40;

impl Score {
    /// Scores a machine on held-out runs.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn of(machine: &Machine, held_out: &HeldOut, floor: &Floor) -> Result<Self> {
        let experiments = held_out.runs();
        let traces = predictions(machine, experiments)?;
        Ok(Self::of_traces(experiments, &traces, floor))
    }

    /// Scores a machine whose noise floor is its own, among others that share a common one.
    ///
    /// # Model
    /// ln L of a sample x of noise σ: −½·(x/σ)² − ln(σ/σ₀), with σ₀ that of the others. A hypothesis that explains larger residuals
    /// by larger noise pays for what it allows itself.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn with_own_floor(machine: &Machine, held_out: &HeldOut, [own, common]: [&Floor; 2]) -> Result<Self> {
        let experiments = held_out.runs();
        let traces = predictions(machine, experiments)?;
        let channels = |experiment: &Experiment, predicted: &Traces| {
            let own_residuals = channels(experiment, predicted, own);
            let widened = |(channel, residual): (Channel, Vec<f64>)| {
                let widening = match channel {
                    Channel::Signal(signal) => own.widening(common, experiment, signal),
                    Channel::BetweenSensors => {
                        let ratio = own.sigma_between_sensors() / common.sigma_between_sensors();
                        vec![ratio.ln(); residual.len()]
                    }
                };
                (channel, residual, widening)
            };
            own_residuals.into_iter().map(widened).collect()
        };
        Ok(Self::of_channels(experiments, &traces, channels).above(own))
    }

    /// Scores what was predicted for runs, one prediction a run.
    pub fn of_traces(experiments: &[Experiment], traces: &[Traces], floor: &Floor) -> Self {
        let channels = |experiment: &Experiment, predicted: &Traces| {
            let common = |(channel, residual): (Channel, Vec<f64>)| (channel, residual, Vec::new());
            channels(experiment, predicted, floor).into_iter().map(common).collect()
        };
        Self::of_channels(experiments, traces, channels).above(floor)
    }

    /// With what the noise of a floor leaves for certain, and where it was seen.
    fn above(mut self, floor: &Floor) -> Self {
        let signals: Vec<Signal> = self.levels(None).into_iter().map(|(signal, _)| signal).collect();
        let channels = || signals.iter().map(|&signal| (Channel::Signal(signal), signal));
        self.least = channels().map(|(channel, signal)| (channel, floor.noise_share(signal))).collect();
        self.is_seen = channels().map(|(channel, signal)| (channel, floor.is_seen(signal))).collect();
        self
    }

    /// Scores normalised residuals, and ln(σ/σ₀) of each sample, none where that is zero throughout.
    fn of_channels(
        experiments: &[Experiment],
        traces: &[Traces],
        channels: impl Fn(&Experiment, &Traces) -> Vec<(Channel, Vec<f64>, Vec<f64>)>,
    ) -> Self {
        let total: usize = experiments.iter().map(Experiment::samples).sum();
        let length = total.div_ceil(BLOCKS).max(1);
        let mut blocks = Vec::new();
        let mut lags: Vec<(Channel, f64, f64)> = Vec::new();
        for (experiment, predicted) in experiments.iter().zip(traces) {
            let residuals = channels(experiment, predicted);
            for (channel, residual, _) in &residuals {
                let weight = residual.len() as f64;
                let time = autocorrelation_time(residual);
                match lags.iter_mut().find(|(c, ..)| c == channel) {
                    Some((_, sum, weights)) => {
                        *sum += time * weight;
                        *weights += weight;
                    }
                    None => lags.push((*channel, time * weight, weight)),
                }
            }
            for from in (0..experiment.samples()).step_by(length) {
                let to = (from + length).min(experiment.samples());
                let block = residuals.iter().map(|(channel, residual, widening)| Cell {
                    channel: *channel,
                    squares: dot(&residual[from..to], &residual[from..to]),
                    widening: widening.get(from..to).map_or(0.0, |ratios| ratios.iter().sum()),
                    samples: to - from,
                });
                blocks.push(block.collect());
            }
        }
        let autocorrelation_times =
            lags.into_iter().map(|(channel, sum, weight)| (channel, sum / weight)).collect();
        let second_sensor = experiments.iter().find_map(Experiment::second_sensor);
        Self { blocks, autocorrelation_times, second_sensor, least: Vec::new(), is_seen: Vec::new() }
    }

    /// G² = mean square of all normalised residuals, every signal weighing the same; `weights` count blocks.
    fn mean_square_of(&self, weights: Option<&[f64]>) -> f64 {
        let levels = self.levels(weights);
        levels.iter().map(|(_, level)| level).sum::<f64>() / levels.len().max(1) as f64
    }

    /// Mean square of the normalised residuals, G².
    pub fn mean_square(&self) -> f64 {
        self.mean_square_of(None)
    }

    /// The gap G.
    pub fn gap(&self) -> f64 {
        self.mean_square().sqrt()
    }

    /// Whether nothing is left that noise would not leave.
    pub fn is_adequate(&self) -> bool {
        self.gap() <= ADEQUATE_GAP
    }

    /// Whether that holds of each signal by itself, too: several quiet signals must not hide one that is not.
    pub(super) fn is_quiet(&self) -> bool {
        self.is_adequate() && self.beyond_noise().next().is_none()
    }

    /// The signals that leave more than noise by themselves, of those whose noise was seen in the recording.
    pub(super) fn beyond_noise(&self) -> impl Iterator<Item = Signal> {
        let is_seen = |signal: &Signal| of(&self.is_seen, Channel::Signal(*signal)).unwrap_or(true);
        let beyond_noise = self.levels(None).into_iter().filter(|(_, level)| level.sqrt() > quiet_signal());
        beyond_noise.map(|(signal, _)| signal).filter(is_seen)
    }

    /// Mean square of each signal.
    pub(super) fn by_signal(&self) -> Vec<(Signal, f64)> {
        self.levels(None)
    }

    /// Mean square per signal.
    fn levels(&self, weights: Option<&[f64]>) -> Vec<(Signal, f64)> {
        let signal = |(channel, level)| match channel {
            Channel::Signal(signal) => Some((signal, level)),
            Channel::BetweenSensors => None,
        };
        self.channel_levels(weights).into_iter().filter_map(signal).collect()
    }

    fn channel_levels(&self, weights: Option<&[f64]>) -> Vec<(Channel, f64)> {
        let mut sums: Vec<(Channel, f64, f64)> = Vec::new();
        for (k, block) in self.blocks.iter().enumerate() {
            let weight = weights.map_or(1.0, |w| w[k]);
            for &Cell { channel, squares, samples, .. } in block {
                match sums.iter_mut().find(|(c, ..)| *c == channel) {
                    Some((_, total, counts)) => {
                        *total += weight * squares;
                        *counts += weight * samples as f64;
                    }
                    None => sums.push((channel, weight * squares, weight * samples as f64)),
                }
            }
        }
        sums.into_iter().map(|(channel, sum, count)| (channel, sum / count.max(1e-300))).collect()
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Log-likelihood of each block, up to a constant that all hypotheses share.
    ///
    /// # Model
    /// Gaussian residuals whose variance per channel is that of the best hypothesis (`reference`), at least that of
    /// the noise; each sample counts 1/τ, with τ the autocorrelation time of that hypothesis' residuals. The
    /// signals of one control loop are images of the same motion, so their mean counts, not their sum. What stands
    /// between two position sensors is no image of that motion: p(x₁, x₂) = p(x₁)·p(x₂ − x₁ | x₁), and it counts beside
    /// the mean of the others, in the place of the sensor that does not close the position loop.
    pub fn log_likelihoods(&self, reference: &Self) -> Vec<f64> {
        let deflation = reference.channel_deflations();
        let second = self.second_sensor.map(Channel::Signal);
        let score = |block: &Vec<Cell>| {
            let (mut mean, mut count, mut between) = (0.0, 0usize, 0.0);
            for cell in block.iter().filter(|cell| Some(cell.channel) != second) {
                let value = cell.squares * deflation(cell.channel)
                    + 2.0 * cell.widening / reference.autocorrelation_time_of(cell.channel);
                match cell.channel {
                    Channel::BetweenSensors => between += value,
                    Channel::Signal(_) => (mean, count) = (mean + value, count + 1),
                }
            }
            -0.5 * (mean / count.max(1) as f64 + between)
        };
        self.blocks.iter().map(score).collect()
    }

    /// What one squared normalised residual of a signal counts in the log-likelihood where this is the best
    /// hypothesis: 1/(level·τ).
    pub fn deflations(&self) -> impl Fn(Signal) -> f64 + use<> {
        let deflation = self.channel_deflations();
        move |signal| deflation(Channel::Signal(signal))
    }

    /// The signals of the control loop that the log-likelihood counts, each with its autocorrelation time in samples.
    pub fn counted(&self) -> Vec<(Signal, f64)> {
        let of = |(channel, time): &(Channel, f64)| match channel {
            Channel::Signal(signal) if Some(*signal) != self.second_sensor => Some((*signal, *time)),
            _ => None,
        };
        self.autocorrelation_times.iter().filter_map(of).collect()
    }

    /// Mean square of a signal that its noise leaves for certain.
    pub fn least(&self, signal: Signal) -> f64 {
        of(&self.least, Channel::Signal(signal)).unwrap_or(1.0)
    }

    fn channel_deflations(&self) -> impl Fn(Channel) -> f64 + use<> {
        let levels = self.channel_levels(None);
        let autocorrelation_times = self.autocorrelation_times.clone();
        let least = self.least.clone();
        move |channel| {
            let level = of(&levels, channel).unwrap_or(1.0).max(of(&least, channel).unwrap_or(1.0));
            1.0 / (level * of(&autocorrelation_times, channel).unwrap_or(1.0))
        }
    }

    fn autocorrelation_time_of(&self, channel: Channel) -> f64 {
        of(&self.autocorrelation_times, channel).unwrap_or(1.0)
    }

    /// The mean square of the signal that leaves least.
    pub fn quietest(&self) -> f64 {
        self.levels(None).iter().map(|(_, level)| *level).fold(f64::INFINITY, f64::min)
    }
}

fn of<T: Copy>(list: &[(Channel, T)], channel: Channel) -> Option<T> {
    list.iter().find(|(c, _)| *c == channel).map(|(_, value)| *value)
}

/// What a machine's twin predicts of each of these runs, sensors perfect.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub(super) fn predictions(machine: &Machine, experiments: &[Experiment]) -> Result<Vec<Traces>> {
    experiments.par_iter().map(|experiment| experiment.predict(machine, Sensing::Perfect)).collect()
}

/// Residuals of a run in units of their noise: one list a channel, the recording's signals in their order, then what stands between two
/// position sensors.
pub fn residuals(experiment: &Experiment, predicted: &Traces, floor: &Floor) -> Vec<Vec<f64>> {
    channels(experiment, predicted, floor).into_iter().map(|(_, residual)| residual).collect()
}

/// Normalised residuals of a run, channel by channel.
fn channels(experiment: &Experiment, predicted: &Traces, floor: &Floor) -> Vec<(Channel, Vec<f64>)> {
    let signals = experiment.signals().iter();
    let signals = signals.map(|&s| (Channel::Signal(s), floor.normalised(experiment, s, predicted)));
    let between = floor.between_sensors(experiment, predicted);
    let all = signals.chain(between.map(|residual| (Channel::BetweenSensors, residual)));
    all.map(|(channel, residual)| (channel, residual.into_iter().map(finite).collect())).collect()
}

/// Residuals beyond this many σ weigh as this many: keeps a diverging candidate finite.
pub(super) const LARGEST: f64 = 1e9;

/// A residual of at most [`LARGEST`].
pub(super) fn finite(residual: f64) -> f64 {
    if residual.is_finite() { residual.clamp(-LARGEST, LARGEST) } else { LARGEST }
}

/// How much of the gap is closed, with a block-bootstrap interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closed {
    /// 1 − (G_after² − 1)/(G_before² − 1).
    pub value: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
}

/// Draws of the block bootstrap.
const DRAWS: usize = 400;

/// The closed share of the gap between two scores of the same runs.
///
/// Where noise alone accounts for what was there before, nothing is there to close and the share is zero.
pub fn closed(before: &Score, after: &Score) -> Closed {
    if before.is_adequate() {
        return Closed { value: 0.0, ci95: (0.0, 0.0) };
    }
    let share = |weights: Option<&[f64]>| {
        let [before, after] = [before, after].map(|score| score.mean_square_of(weights));
        closed_power(before, after)
    };
    let mut draws: Vec<f64> = bootstrap(before.blocks(), DRAWS).iter().map(|w| share(Some(w))).collect();
    draws.sort_by(f64::total_cmp);
    let at = |fraction: f64| {
        let place = (fraction * (draws.len() - 1) as f64).round() as usize;
        draws.get(place).copied().unwrap_or(f64::NAN)
    };
    let value = share(None);
    Closed { value, ci95: (at(0.025).min(value), at(0.975).max(value)) }
}

/// Share of a gap's power that is closed, from the mean squares before and after; zero where nothing was open.
pub(super) fn closed_power(before: f64, after: f64) -> f64 {
    let excess = before - 1.0;
    // Below the floor there is nothing left to close: noise was stated a little too large.
    if excess > 0.0 { (1.0 - (after - 1.0) / excess).min(1.0) } else { 0.0 }
}

/// Weights of the blocks in each draw: how often a draw with replacement takes each.
pub fn bootstrap(blocks: usize, draws: usize) -> Vec<Vec<f64>> {
    use rand::{RngExt, SeedableRng};
    // A fixed seed: the same data give the same interval.
    let mut random = rand::rngs::StdRng::seed_from_u64(20_200_229);
    (0..draws)
        .map(|_| {
            let mut weights = vec![0.0; blocks];
            for _ in 0..blocks {
                weights[random.random_range(0..blocks)] += 1.0;
            }
            weights
        })
        .collect()
}

#[cfg(test)]
impl Score {
    /// A score whose residuals of one signal have this mean square throughout, each sample worth what it is.
    pub(super) fn even(mean_square: f64) -> Self {
        let channel = Channel::Signal(Signal::Position);
        let block = vec![Cell { channel, squares: 50.0 * mean_square, widening: 0.0, samples: 50 }];
        Self {
            blocks: vec![block; BLOCKS],
            autocorrelation_times: vec![(channel, 1.0)],
            second_sensor: None,
            least: Vec::new(),
            is_seen: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One block a channel: effort, position of the motor, position of the load, which closes the loop, and their difference.
    fn score(sums: [f64; 4]) -> Score {
        let channels = [
            Channel::Signal(Signal::ControlEffort),
            Channel::Signal(Signal::Position),
            Channel::Signal(Signal::LoadPosition),
            Channel::BetweenSensors,
        ];
        let cell =
            |(&channel, squares): (&Channel, f64)| Cell { channel, squares, widening: 0.0, samples: 100 };
        let block = channels.iter().zip(sums).map(cell).collect();
        let autocorrelation_times = channels.iter().map(|channel| (*channel, 5.0)).collect();
        Score {
            blocks: vec![block],
            autocorrelation_times,
            second_sensor: Some(Signal::Position),
            least: Vec::new(),
            is_seen: Vec::new(),
        }
    }

    /// ln L = −½·(mean over the loop's signals + what stands between the sensors)/τ, the motor's position in neither; G has
    /// all signals and no difference.
    #[test]
    fn exact_what_stands_between_two_sensors_counts_beside_the_loop() {
        let best = score([100.0; 4]);
        let gain = |other: [f64; 4]| best.log_likelihoods(&best)[0] - score(other).log_likelihoods(&best)[0];
        assert!((gain([300.0, 100.0, 100.0, 100.0]) - 0.5 * 200.0 / 5.0 / 2.0).abs() < 1e-12);
        assert!((gain([100.0, 300.0, 100.0, 100.0])).abs() < 1e-12);
        assert!((gain([100.0, 100.0, 100.0, 300.0]) - 0.5 * 200.0 / 5.0).abs() < 1e-12);
        assert!((score([300.0, 100.0, 200.0, 900.0]).mean_square() - 2.0).abs() < 1e-12);
    }

    /// A signal of 1.41 times its noise is beyond noise where the noise was seen, and not where it is only stated; one of 1.38 times is not.
    #[test]
    fn exact_a_signal_by_itself_may_leave_more_than_noise() {
        let of = |position: f64, is_seen: bool| Score {
            is_seen: vec![(Channel::Signal(Signal::Position), is_seen)],
            ..score([100.0, 100.0 * position * position, 100.0, 100.0])
        };
        assert!(of(1.38, true).is_quiet() && !of(1.41, true).is_quiet() && of(1.41, false).is_quiet());
        assert_eq!(of(1.41, true).beyond_noise().collect::<Vec<_>>(), [Signal::Position]);
    }

    /// Residuals that are half a floor of which a sixteenth of the variance is noise are weighed by what they are; those of a floor that is all noise by
    /// the floor.
    #[test]
    fn exact_a_floor_that_is_no_noise_is_no_bound_from_below() {
        let gain = |least: f64| {
            let of = |mean_square: f64| Score {
                least: vec![(Channel::Signal(Signal::Position), least)],
                ..Score::even(mean_square)
            };
            of(0.25).log_likelihoods(&of(0.25))[0] - of(0.5).log_likelihoods(&of(0.25))[0]
        };
        assert!((gain(1.0) - 0.5 * 50.0 * 0.25).abs() < 1e-12);
        assert!((gain(1.0 / 16.0) - 0.5 * 50.0 * 0.25 / 0.25).abs() < 1e-12);
    }

    /// A wider noise of its own costs ln(σ/σ₀) a sample; with what it takes off the squares, it pays where these are more than
    /// σ₀²·2·ln(σ/σ₀)/(1 − (σ₀/σ)²).
    #[test]
    fn exact_a_wider_noise_pays_where_the_residuals_are_as_wide() {
        let widening = 4.0_f64.ln();
        let wide = |mean_square: f64| {
            let mut score = Score::even(mean_square / 16.0);
            score.blocks.iter_mut().flatten().for_each(|cell| cell.widening = 50.0 * widening);
            score
        };
        let gain = |mean_square: f64| {
            let noise = Score::even(1.0);
            wide(mean_square).log_likelihoods(&noise)[0] - Score::even(mean_square).log_likelihoods(&noise)[0]
        };
        let even = 2.0 * widening / (1.0 - 1.0 / 16.0);
        assert!(gain(even).abs() < 1e-9 && gain(1.01 * even) > 0.0 && gain(0.99 * even) < 0.0);
        assert!((gain(16.0) - 50.0 * (0.5 * 15.0 - widening)).abs() < 1e-9);
    }
}
