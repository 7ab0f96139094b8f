//! Held-out evidence: how well fitted hypotheses predict runs they have not seen.

use super::experiment::Experiment;
use super::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::Traces;
use crate::twin::Sensing;

/// Sums of squared normalised residuals on the held-out runs, block by block and signal by signal.
#[derive(Debug, Clone)]
pub struct Score {
    /// One entry a block of consecutive samples, then one a signal in the order of the recording's signals.
    blocks: Vec<Vec<(Signal, f64, usize)>>,
    /// Lag-summed autocorrelation of the residuals, per signal: 1 for white noise, more for structure.
    inflation: Vec<(Signal, f64)>,
}

/// Blocks over all held-out runs together; fewer than twenty leave a bootstrap without spread.
const BLOCKS: usize = 40;

impl Score {
    /// Scores a machine on runs.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn of(machine: &Machine, experiments: &[Experiment], floor: &Floor) -> Result<Self> {
        let predict = |experiment: &Experiment| experiment.predict(machine, Sensing::Perfect);
        let traces: Result<Vec<Traces>> = experiments.iter().map(predict).collect();
        Ok(Self::of_traces(experiments, &traces?, floor))
    }

    /// Scores what was predicted for runs, one prediction a run.
    pub fn of_traces(experiments: &[Experiment], traces: &[Traces], floor: &Floor) -> Self {
        let total: usize = experiments.iter().map(Experiment::samples).sum();
        let length = total.div_ceil(BLOCKS).max(1);
        let mut blocks = Vec::new();
        let mut lags: Vec<(Signal, f64, f64)> = Vec::new();
        for (experiment, predicted) in experiments.iter().zip(traces) {
            let mut residuals: Vec<(Signal, Vec<f64>)> = Vec::new();
            for &signal in experiment.signals() {
                let residual = floor.normalised(experiment, signal, predicted);
                let residual: Vec<f64> = residual.into_iter().map(finite).collect();
                let weight = residual.len() as f64;
                let inflation = inflation(&residual);
                match lags.iter_mut().find(|(s, ..)| *s == signal) {
                    Some((_, sum, weights)) => {
                        *sum += inflation * weight;
                        *weights += weight;
                    }
                    None => lags.push((signal, inflation * weight, weight)),
                }
                residuals.push((signal, residual));
            }
            for from in (0..experiment.samples()).step_by(length) {
                let to = (from + length).min(experiment.samples());
                let block = residuals.iter().map(|(signal, r)| {
                    let sum = r[from..to].iter().map(|x| x * x).sum();
                    (*signal, sum, to - from)
                });
                blocks.push(block.collect());
            }
        }
        let inflation = lags.into_iter().map(|(signal, sum, weight)| (signal, sum / weight)).collect();
        Self { blocks, inflation }
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

    /// Mean square per signal.
    pub fn levels(&self, weights: Option<&[f64]>) -> Vec<(Signal, f64)> {
        let mut sums: Vec<(Signal, f64, f64)> = Vec::new();
        for (k, block) in self.blocks.iter().enumerate() {
            let weight = weights.map_or(1.0, |w| w[k]);
            for &(signal, sum, count) in block {
                match sums.iter_mut().find(|(s, ..)| *s == signal) {
                    Some((_, total, counts)) => {
                        *total += weight * sum;
                        *counts += weight * count as f64;
                    }
                    None => sums.push((signal, weight * sum, weight * count as f64)),
                }
            }
        }
        sums.into_iter().map(|(signal, sum, count)| (signal, sum / count.max(1e-300))).collect()
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Log-likelihood of each block, up to a constant that all hypotheses share.
    ///
    /// # Model
    /// Gaussian residuals whose variance per signal is that of the best hypothesis (`reference`), at least the
    /// floor; each sample counts 1/τ, with τ the lag-summed autocorrelation of that hypothesis' residuals; the
    /// signals of one control loop are images of the same motion, so their mean counts, not their sum.
    pub fn log_likelihoods(&self, reference: &Self) -> Vec<f64> {
        let deflation = reference.deflations();
        let score = |block: &Vec<(Signal, f64, usize)>| {
            let sum: f64 = block.iter().map(|&(signal, sum, _)| sum * deflation(signal)).sum();
            -0.5 * sum / block.len().max(1) as f64
        };
        self.blocks.iter().map(score).collect()
    }

    /// What one squared normalised residual of a signal counts in the log-likelihood where this is the best
    /// hypothesis: 1/(level·τ).
    pub fn deflations(&self) -> impl Fn(Signal) -> f64 + use<> {
        let levels = self.levels(None);
        let inflation = self.inflation.clone();
        move |signal| {
            let find = |list: &[(Signal, f64)]| list.iter().find(|(s, _)| *s == signal).map(|x| x.1);
            let level = find(&levels).unwrap_or(1.0).max(1.0);
            1.0 / (level * find(&inflation).unwrap_or(1.0))
        }
    }
}

fn finite(residual: f64) -> f64 {
    const LARGEST: f64 = 1e9;
    if residual.is_finite() { residual.clamp(-LARGEST, LARGEST) } else { LARGEST }
}

/// 1 + 2·Σ ρ(lag) up to the first lag at which the autocorrelation has died out; at least 1.
fn inflation(residual: &[f64]) -> f64 {
    let power: f64 = residual.iter().map(|x| x * x).sum();
    if power <= 0.0 {
        return 1.0;
    }
    let (mut sum, mut lag, mut width) = (1.0, 1, 1);
    while lag < residual.len() / 4 {
        let product: f64 = residual.iter().zip(&residual[lag..]).map(|(a, b)| a * b).sum();
        let correlation = product / power;
        if correlation < 0.05 {
            break;
        }
        // Long correlations change slowly: lags are taken ever farther apart.
        sum += 2.0 * width as f64 * correlation;
        width = (lag / 16).max(1);
        lag += width;
    }
    sum
}

/// How much of the gap is closed, with a block-bootstrap interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closed {
    /// 1 − (G_after² − 1)/(G_before² − 1).
    pub value: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
}

/// An excess of the mean square over its floor below this is the floor's own uncertainty.
pub const LEAST_EXCESS: f64 = 0.1;
/// Draws of the block bootstrap.
const DRAWS: usize = 400;

/// The closed share of the gap between two scores of the same runs.
///
/// Where noise alone accounts for what was there before, nothing is there to close and the share is zero.
pub fn closed(before: &Score, after: &Score) -> Closed {
    if before.mean_square() < 1.0 + LEAST_EXCESS {
        return Closed { value: 0.0, ci95: (0.0, 0.0) };
    }
    let share = |weights: Option<&[f64]>| {
        let excess = before.mean_square_of(weights) - 1.0;
        // Below the floor there is nothing left to close: noise was stated a little too large.
        if excess > 0.0 { (1.0 - (after.mean_square_of(weights) - 1.0) / excess).min(1.0) } else { 0.0 }
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
