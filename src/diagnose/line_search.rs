//! Frequencies of a vibration, from what the replays of a fit leave.

use super::hypothesis::path;
use super::objective::Objective;
use super::ordinates::around;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::DVector;
use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Frequencies lie this part of one over the longest run apart.
const OVERSAMPLING: usize = 4;
/// Fewer periods over the longest run are a trend.
const LEAST_PERIODS: usize = 3;
/// Highest frequency as a share of the sample rate: the one up to which a fit looks.
const HIGHEST: f64 = 0.4;
/// A line has so many times the median of its neighbours on both sides: enough to start a fit from, which decides.
const STANDS_OUT: f64 = 8.0;
/// The line's own ordinates, and its neighbours on either side, in ordinates one over the longest run apart: a Hann window has two of its own.
const OWN: usize = 2;
const NEIGHBOURS: usize = 6;
/// Amplitude of a vibration while its response is taken, as a share of the largest force: the size of a usual one, since dry friction answers a far
/// smaller one by when it sticks.
const SHARE: f64 = 1e-3;

/// Where the fit of a vibration may begin, frequency and amplitude, at most so many, the strongest line first.
///
/// # Model
/// The normalised residuals r of each signal of each run, with weights w, give a periodogram through a Hann window h; those of all are added up, since
/// a vibration has one frequency, and a phase of its own in each run:
/// ```text
///   P(f) = Σ |Σ h·w·r·e^(−i2πft)|² / Σ h·w
/// ```
/// A line is a peak that stands out from its neighbours. Its amplitude follows from the replay with a small vibration of that frequency and the phase that
/// suits each run, which changes the residuals by R a unit of amplitude: `A = −RᵀWr/RᵀWR`. Unlike the spectrum of the missing force this has what the
/// twin's motion explains taken out of it, and no derivative of the position in it.
///
/// # Validity
/// Runs sampled evenly. To first order in the amplitude.
///
/// # Source
/// P. D. Welch (1967), IEEE Trans. Audio Electroacoust. 15:70, averaging of periodograms, with runs as segments.
///
/// # Errors
/// Whatever a replay refuses.
pub fn vibrations(
    objective: &Objective,
    values: &[f64],
    largest_force: f64,
    most: usize,
) -> Result<Vec<Vec<f64>>> {
    let residuals = objective.residuals(values)?;
    let weights = objective.weights(&residuals);
    let frequencies = lines(objective, &residuals, &weights, most);
    let amplitude = SHARE * largest_force;
    let fitted = objective.hypothesis.machine(objective.machine, values)?;
    let shaken: Result<Vec<Machine>> = frequencies.iter().map(|f| shaken(&fitted, *f, amplitude)).collect();
    let changed = objective.residuals_at(&shaken?)?;
    let size = |changed: DVector<f64>| {
        let response = (changed - &residuals) / amplitude;
        let weighted = response.component_mul(&weights);
        (-weighted.dot(&residuals) / weighted.dot(&response)).clamp(0.0, largest_force)
    };
    let starts = frequencies.iter().zip(changed).map(|(f, changed)| vec![*f, size(changed)]);
    Ok(starts.filter(|start| start[1] > 0.0).collect())
}

/// A machine with a vibration.
fn shaken(machine: &Machine, frequency_hz: f64, amplitude: f64) -> Result<Machine> {
    let effect = EffectId::ExternalVibration;
    let names: Vec<String> =
        effect.parameters().iter().map(|parameter| path(effect, parameter.key(machine.motion()))).collect();
    let values = [frequency_hz, amplitude].map(toml::Value::Float);
    machine.with_settings(names.iter().map(String::as_str).zip(values))
}

/// Frequencies in Hz of the strongest lines.
fn lines(objective: &Objective, residuals: &DVector<f64>, weights: &DVector<f64>, most: usize) -> Vec<f64> {
    let (mut spectrum, mut offset) = (Spectrum::over(objective), 0);
    for experiment in objective.experiments {
        let is_even = experiment.run().instants_s().is_none();
        for _ in experiment.signals() {
            let rows = offset..offset + objective.rows(experiment);
            if is_even {
                spectrum.add(&residuals.as_slice()[rows.clone()], &weights.as_slice()[rows.clone()]);
            }
            offset = rows.end;
        }
    }
    spectrum.lines(most)
}

/// Periodograms of series of one sample period, added up.
struct Spectrum {
    period_s: f64,
    /// Length to which series are padded with zeros.
    padded: usize,
    power: Vec<f64>,
    planner: RealFftPlanner<f64>,
}

impl Spectrum {
    fn over(objective: &Objective) -> Self {
        let longest = objective.experiments.iter().map(|e| objective.rows(e)).max().unwrap_or(0);
        let period_s = objective.machine.description().sample_period_s * objective.stride as f64;
        Self::new(period_s, longest)
    }

    fn new(period_s: f64, longest: usize) -> Self {
        let padded = (OVERSAMPLING * longest).max(2);
        Self { period_s, padded, power: vec![0.0; padded / 2 + 1], planner: RealFftPlanner::new() }
    }

    fn add(&mut self, series: &[f64], weights: &[f64]) {
        let hann = |k: usize| 0.5 - 0.5 * (TAU * (k as f64 + 0.5) / series.len() as f64).cos();
        let windowed: Vec<f64> = weights.iter().enumerate().map(|(k, w)| hann(k) * w).collect();
        let total: f64 = windowed.iter().sum();
        if total <= 0.0 {
            return;
        }
        let mean = series.iter().zip(&windowed).map(|(r, w)| r * w).sum::<f64>() / total;
        let mut samples: Vec<f64> = series.iter().zip(&windowed).map(|(r, w)| w * (r - mean)).collect();
        samples.resize(self.padded, 0.0);
        let transform = self.planner.plan_fft_forward(self.padded);
        let mut values = transform.make_output_vec();
        // It refuses other lengths than its own only.
        if transform.process(&mut samples, &mut values).is_ok() {
            for (power, value) in self.power.iter_mut().zip(values) {
                *power += value.norm_sqr() / total;
            }
        }
    }

    /// Frequencies in Hz of the strongest lines, at most so many.
    fn lines(&self, most: usize) -> Vec<f64> {
        let last = ((HIGHEST * self.padded as f64) as usize).min(self.power.len());
        let (near, far) = (OWN * OVERSAMPLING, (OWN + NEIGHBOURS) * OVERSAMPLING);
        let is_line = |k: &usize| {
            let own = self.power[k - OVERSAMPLING..(k + OVERSAMPLING + 1).min(self.power.len())].iter();
            let is_peak = self.power[*k] > 0.0 && own.copied().fold(0.0, f64::max) <= self.power[*k];
            is_peak && around(&self.power, *k, [near, far], 1).is_none_or(|a| self.power[*k] > STANDS_OUT * a)
        };
        let mut lines: Vec<usize> = (LEAST_PERIODS * OVERSAMPLING..last).filter(is_line).collect();
        lines.sort_by(|&a, &b| self.power[b].total_cmp(&self.power[a]));
        lines.into_iter().take(most).map(|k| k as f64 / (self.padded as f64 * self.period_s)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of a tenth of what else is left, which is slow, with another phase in each series.
    #[test]
    fn exact_line_beside_a_slow_rest() {
        let (period_s, frequency) = (1e-3, 20.26);
        let series = |phase: f64, count: usize| -> Vec<f64> {
            let time = |k: usize| k as f64 * period_s;
            (0..count)
                .map(|k| {
                    3.0 * time(k) + 10.0 * (2.0 * time(k)).sin() + (TAU * frequency * time(k) + phase).sin()
                })
                .collect()
        };
        let mut spectrum = Spectrum::new(period_s, 4000);
        for (phase, count) in [(0.3, 4000), (2.0, 2500)] {
            spectrum.add(&series(phase, count), &vec![1.0; count]);
        }
        let lines = spectrum.lines(3);
        assert!(lines.len() == 1 && (lines[0] - frequency).abs() < 0.05, "{lines:?}");
    }

    /// Nothing stands out of white noise, nor of nothing.
    #[test]
    fn exact_noise_has_no_line() {
        use rand::{RngExt, SeedableRng};
        let mut rng = rand::rngs::StdRng::seed_from_u64(5);
        let mut spectrum = Spectrum::new(1e-3, 4000);
        assert!(spectrum.lines(3).is_empty());
        for _ in 0..12 {
            let noise: Vec<f64> = (0..4000).map(|_| rng.random_range(-1.0..1.0)).collect();
            spectrum.add(&noise, &vec![1.0; 4000]);
        }
        assert!(spectrum.lines(3).is_empty());
    }
}
