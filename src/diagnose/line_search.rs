//! Frequencies of a vibration, from what the replays of a fit leave.

use super::estimate::vibration::HIGHEST;
use super::hypothesis::with_effect;
use super::objective::Objective;
use super::ordinates::{self, OVERSAMPLING};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::DVector;
use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Fewer periods over the longest run are a trend.
const LEAST_PERIODS: usize = 3;
/// Amplitude of a vibration while its response is taken, as a share of the largest force. Machines have 0.05 to 2 % of the rated force (prior of
/// [`ExternalVibration`](crate::effect::ExternalVibration)). With far less, the instants at which dry friction sticks make most of the response.
const SHARE: f64 = 1e-3;

/// Where the fit of a vibration may begin: frequency in Hz and amplitude in N or N·m, at most so many, the strongest line first. `largest_force` is in
/// N or N·m; where it is zero there are none.
///
/// # Model
/// The normalised residuals r (no unit, predicted less measured) of each signal of each run, with weights w, give a periodogram through a Hann window h.
/// Those of all are added up: a vibration has one frequency, and a phase of its own in each run.
/// ```text
///   P(f) = Σ |Σ h·w·r·e^(−i2πft)|² / Σ h·w
/// ```
/// A line is a peak that stands out from its neighbours. A replay with a small vibration of that frequency, and the phase that suits each run, changes the
/// residuals by R per N or N·m; least squares then give the amplitude `A = −RᵀWr/RᵀWR`. Unlike the spectrum of the missing force this spectrum is free
/// of what the twin predicts of the motion, and takes no derivative of the position.
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
    let amplitude = SHARE * largest_force;
    if amplitude <= 0.0 {
        return Ok(Vec::new());
    }
    let residuals = objective.residuals(values)?;
    let weights = objective.weights(&residuals);
    let frequencies = lines(objective, &residuals, &weights, most);
    let fitted = objective.hypothesis.machine(objective.machine, values)?;
    let shaken = |f: &f64| with_effect(&fitted, EffectId::ExternalVibration, &[*f, amplitude]);
    let shaken: Result<Vec<Machine>> = frequencies.iter().map(shaken).collect();
    let changed = objective.residuals_at(&shaken?)?;
    let size = |changed: DVector<f64>| {
        let response = (changed - &residuals) / amplitude;
        let weighted = response.component_mul(&weights);
        (-weighted.dot(&residuals) / weighted.dot(&response)).clamp(0.0, largest_force)
    };
    let starts = frequencies.iter().zip(changed).map(|(f, changed)| vec![*f, size(changed)]);
    Ok(starts.filter(|start| start[1] > 0.0).collect())
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
        let last = (HIGHEST * self.padded as f64) as usize;
        let lines = ordinates::lines(&self.power, LEAST_PERIODS * OVERSAMPLING..last);
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
