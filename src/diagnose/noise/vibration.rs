//! A vibration that shakes the axis at standstill: a line in the spectrum of its position there.

use super::standstill::settled;
use crate::diagnose::experiment::Experiment;
use crate::diagnose::ordinates::around;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::singular::decomposed;
use crate::twin::Sensing;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;

/// Lines that are looked for at most: a vibration and its harmonics.
const MOST_LINES: usize = 3;
/// Fewer periods over the standstills of a run together are drift.
const LEAST_PERIODS: f64 = 3.0;
/// A line has so many times the power of its neighbours on either side: one of a thousand exponentially distributed ordinates
/// of noise exceeds 25 times their mean once in 10⁸ recordings.
const STANDS_OUT: f64 = 25.0;
/// Neighbours of a line on either side, in ordinates one over the length apart.
const NEIGHBOURS: usize = 12;
/// Frequencies lie this part of one over the length apart.
const OVERSAMPLING: usize = 4;
/// Frequencies tried at most.
const MOST_FREQUENCIES: usize = 1500;
/// A vibration explains so large a share of the scatter at standstill.
const MOST: f64 = 0.5;
/// Highest frequency in Hz, and as a share of the sample rate.
const HIGHEST_HZ: f64 = 100.0;
const HIGHEST: f64 = 0.4;
/// Samples a second that frequencies up to the highest need.
const ENOUGH_HZ: f64 = 600.0;

/// Frequencies in Hz at which the axis vibrates at standstill, run by run; none where it only scatters.
pub type Shaken = BTreeMap<String, Vec<f64>>;

/// Finds them: that of a vibration which the machine states, else lines that stand out, of the position at the standstills of
/// a run, or of what the machine's twin leaves of the whole run if that explains most of the scatter at standstill as well.
///
/// # Model
/// Least squares of a sine on all stretches together, mean and trend of each taken out (Lomb's periodogram with gaps). An
/// ordinate counts as a line where it stands out from the median of those on either side.
///
/// # Source
/// Lomb (1976), *Least-squares frequency analysis of unequally spaced data*.
///
/// # Errors
/// Whatever a replay refuses.
pub fn frequencies(machine: &Machine, experiments: &[&Experiment]) -> Result<Shaken> {
    let of_run = |experiment: &&Experiment| {
        let found = lines(machine, experiment)?;
        Ok((experiment.run().name().to_owned(), found))
    };
    experiments.par_iter().map(of_run).collect()
}

fn lines(machine: &Machine, experiment: &Experiment) -> Result<Vec<f64>> {
    if let Some(stated) = &machine.description().effect.external_vibration {
        return Ok(vec![stated.frequency_hz]);
    }
    let run = experiment.run();
    let Some(position) = run.signal(Signal::Position).filter(|_| run.instants_s().is_none()) else {
        return Ok(Vec::new());
    };
    let stretches: Vec<Range<usize>> = settled(experiment).into_iter().filter(|s| s.len() >= 20).collect();
    if stretches.is_empty() {
        return Ok(Vec::new());
    }
    let period_s = run.sample_period_s();
    let still = Still::of(position, &stretches, period_s);
    let found = still.clone().lines();
    if !found.is_empty() {
        return Ok(found);
    }
    // Standstills too short to tell a frequency: the whole run does, where the twin predicts the rest of its motion.
    let predicted = experiment.predict(machine, Sensing::Perfect)?;
    let left: Vec<f64> = position.iter().zip(&predicted.position).map(|(m, p)| m - p).collect();
    let whole = 0..position.len();
    let mut all = Still::of(&left, std::slice::from_ref(&whole), period_s).lines();
    all.retain(|frequency| still.is_mostly(*frequency));
    Ok(all)
}

/// Samples without the sines of these frequencies, their mean and trend kept; as they are where they are too few.
pub fn without(samples: &[f64], frequencies: &[f64], period_s: f64) -> Vec<f64> {
    let columns = 2 + 2 * frequencies.len();
    if frequencies.is_empty() || samples.len() < 4 * columns {
        return samples.to_vec();
    }
    let middle = 0.5 * (samples.len() - 1) as f64;
    let matrix = DMatrix::from_fn(samples.len(), columns, |row, column| {
        let place = row as f64 - middle;
        match column {
            0 => 1.0,
            1 => place / middle,
            _ => {
                let angle = TAU * frequencies[(column - 2) / 2] * place * period_s;
                if column % 2 == 0 { angle.sin() } else { angle.cos() }
            }
        }
    });
    let target = DVector::from_column_slice(samples);
    // Frequencies that two runs share are there twice: the pseudo-inverse takes them as one.
    let solution = decomposed(matrix.clone()).and_then(|parts| parts.solve(&target, 1e-9).ok());
    let Some(solution) = solution else { return samples.to_vec() };
    let sines = matrix.columns(2, columns - 2) * solution.rows(2, columns - 2);
    samples.iter().zip(&sines).map(|(sample, sine)| sample - sine).collect()
}

/// Position at the standstills of a run, mean and trend of each taken out.
#[derive(Clone)]
struct Still {
    /// Times of the samples in s, standstill by standstill.
    times: Vec<Vec<f64>>,
    rests: Vec<Vec<f64>>,
    length_s: f64,
    period_s: f64,
}

impl Still {
    fn of(position: &[f64], stretches: &[Range<usize>], period_s: f64) -> Self {
        let every = ((1.0 / (ENOUGH_HZ * period_s)) as usize).max(1);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let starts =
            |s: &Range<usize>| s.clone().step_by(every).filter(|k| k + every <= position.len()).collect();
        let starts: Vec<Vec<usize>> = stretches.iter().map(starts).collect();
        let middle = 0.5 * (every - 1) as f64;
        let times =
            starts.iter().map(|s| s.iter().map(|&k| (k as f64 + middle) * period_s).collect()).collect();
        let thinned = |s: &Vec<usize>| s.iter().map(|&k| mean(&position[k..k + every])).collect::<Vec<f64>>();
        let rests = starts.iter().map(|s| levelled(&thinned(s))).collect();
        let length_s = stretches.iter().map(|s| s.len() as f64 * period_s).sum();
        Self { times, rests, length_s, period_s: every as f64 * period_s }
    }

    /// The lines that stand out, strongest first.
    fn lines(mut self) -> Vec<f64> {
        let mut found = Vec::new();
        while found.len() < MOST_LINES {
            let Some(frequency) = self.line() else { break };
            self.take_out(frequency);
            found.push(frequency);
        }
        found
    }

    /// Whether a sine of this frequency explains most of the scatter.
    fn is_mostly(&self, frequency: f64) -> bool {
        let all: f64 = self.rests.iter().flatten().map(|x| x * x).sum();
        self.fit(frequency).is_some_and(|fit| fit.gain > MOST * all)
    }

    /// The strongest line that stands out.
    fn line(&self) -> Option<f64> {
        let (from, to) = (LEAST_PERIODS / self.length_s, HIGHEST_HZ.min(HIGHEST / self.period_s));
        let step = 1.0 / (OVERSAMPLING as f64 * self.length_s);
        let count = (((to - from) / step).max(0.0) as usize).min(MOST_FREQUENCIES);
        let gains = self.gains(from, step, count);
        let best = (0..count).max_by(|&a, &b| gains[a].total_cmp(&gains[b]))?;
        // The line's own ordinates, wider where standstills have gaps between them, are not its neighbours.
        let (near, far) = (2 * OVERSAMPLING, (2 + NEIGHBOURS) * OVERSAMPLING);
        let around = around(&gains, best, [near, far], OVERSAMPLING * NEIGHBOURS / 3)?;
        // The median of an exponential distribution is ln 2 of its mean.
        let mean = around / std::f64::consts::LN_2;
        (gains[best] > STANDS_OUT * mean && gains[best] > 0.0)
            .then(|| self.refined(from + best as f64 * step, step))
    }

    /// The frequency near one of the grid that explains most.
    fn refined(&self, frequency: f64, step: f64) -> f64 {
        let gain = |f: f64| self.fit(f).map_or(0.0, |fit| fit.gain);
        let (mut low, mut high) = (frequency - step, frequency + step);
        for _ in 0..30 {
            let third = (high - low) / 3.0;
            if gain(low + third) < gain(high - third) { low += third } else { high -= third }
        }
        0.5 * (low + high)
    }

    /// The sums of squares that sines of `count` frequencies explain, `step` apart.
    fn gains(&self, from: f64, step: f64, count: usize) -> Vec<f64> {
        let mut waves = self.waves(from);
        let turns = self.waves(step);
        let gains = (0..count).map(|_| {
            let gain = self.fit_waves(&waves).map_or(0.0, |fit| fit.gain);
            // Sine and cosine of the next frequency by the theorem of addition: some ten times as fast as by themselves.
            for ([sine, cosine], [by_sine, by_cosine]) in
                waves.iter_mut().flatten().zip(turns.iter().flatten())
            {
                (*sine, *cosine) =
                    (*sine * by_cosine + *cosine * by_sine, *cosine * by_cosine - *sine * by_sine);
            }
            gain
        });
        gains.collect()
    }

    /// Sine and cosine at the samples, standstill by standstill.
    fn waves(&self, frequency: f64) -> Vec<Vec<[f64; 2]>> {
        let wave = |t: &f64| {
            let (sine, cosine) = (TAU * frequency * t).sin_cos();
            [sine, cosine]
        };
        self.times.iter().map(|times| times.iter().map(wave).collect()).collect()
    }

    fn fit(&self, frequency: f64) -> Option<Wave> {
        self.fit_waves(&self.waves(frequency))
    }

    /// Least squares of a wave whose sine and cosine are these, mean and trend of each standstill taken out of them.
    ///
    /// The rests have neither mean nor trend, so that only the sums of squares of the wave have to be freed of them.
    fn fit_waves(&self, waves: &[Vec<[f64; 2]>]) -> Option<Wave> {
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for (waves, rests) in waves.iter().zip(&self.rests) {
            let middle = 0.5 * (waves.len() as f64 - 1.0);
            let (mut sum, mut trend, mut spread) = (Vector2::zeros(), Vector2::zeros(), 0.0);
            for (k, (&[sine, cosine], rest)) in waves.iter().zip(rests).enumerate() {
                let (wave, place) = (Vector2::new(sine, cosine), k as f64 - middle);
                normal += Matrix2::new(sine * sine, sine * cosine, sine * cosine, cosine * cosine);
                right += wave * *rest;
                sum += wave;
                trend += wave * place;
                spread += place * place;
            }
            if spread > 0.0 {
                normal -= sum * sum.transpose() / waves.len() as f64 + trend * trend.transpose() / spread;
            }
        }
        let amplitudes = normal.try_inverse()? * right;
        Some(Wave { gain: amplitudes.dot(&right), amplitudes: [amplitudes.x, amplitudes.y] })
    }

    fn take_out(&mut self, frequency: f64) {
        let waves = self.waves(frequency);
        let Some(Wave { amplitudes: [by_sine, by_cosine], .. }) = self.fit_waves(&waves) else { return };
        for (rests, waves) in self.rests.iter_mut().zip(&waves) {
            let wave: Vec<f64> =
                waves.iter().map(|[sine, cosine]| by_sine * sine + by_cosine * cosine).collect();
            for (rest, wave) in rests.iter_mut().zip(levelled(&wave)) {
                *rest -= wave;
            }
        }
    }
}

/// A sine fitted to the standstills of a run.
struct Wave {
    /// Sum of squares that it explains.
    gain: f64,
    /// Of its sine and its cosine.
    amplitudes: [f64; 2],
}

/// Samples about their straight line.
pub fn levelled(samples: &[f64]) -> Vec<f64> {
    let count = samples.len() as f64;
    let (mean, middle) = (samples.iter().sum::<f64>() / count, 0.5 * (count - 1.0));
    let (mut cross, mut spread) = (0.0, 0.0);
    for (k, sample) in samples.iter().enumerate() {
        cross += (k as f64 - middle) * (sample - mean);
        spread += (k as f64 - middle).powi(2);
    }
    let slope = if spread > 0.0 { cross / spread } else { 0.0 };
    samples.iter().enumerate().map(|(k, y)| y - mean - slope * (k as f64 - middle)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic noise of unit variance, near enough.
    fn noise(k: usize) -> f64 {
        let hash = (k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66;
        let hash = (hash ^ (hash >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((hash >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    }

    #[test]
    fn exact_line_is_found_over_two_standstills_and_noise_is_none() {
        let (period_s, stretches) = (2e-3, [0..200, 700..1000]);
        let shaken: Vec<f64> =
            (0..1000).map(|k| noise(k) + 3.0 * (TAU * 11.3 * k as f64 * period_s + 0.4).sin()).collect();
        let line = Still::of(&shaken, &stretches, period_s).line().unwrap();
        assert!((line - 11.3).abs() < 0.1, "{line}");
        let quiet: Vec<f64> = (0..1000).map(noise).collect();
        assert_eq!(Still::of(&quiet, &stretches, period_s).line(), None);
        let left = levelled(&without(&shaken[700..], &[line], period_s));
        let variance = left.iter().map(|x| x * x).sum::<f64>() / left.len() as f64;
        assert!((0.7..1.3).contains(&variance), "{variance}");
    }
}
