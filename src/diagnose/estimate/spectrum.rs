//! Lines in the spectrum of the missing force: what acts in time and not along the travel.

use super::Screen;
use super::periodogram::PASSED_HZ;
use super::screening::{Base, Series};
use crate::diagnose::ordinates::{self, OVERSAMPLING};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// A line: a frequency and the amplitude of the force there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Amplitude in N or N·m.
    pub amplitude: f64,
}

/// Fewer periods over a run are a trend.
const LEAST_PERIODS: f64 = 3.0;
/// Samples used of a run at most.
const MOST_SAMPLES: usize = 2000;
/// Frequencies tried at most.
const MOST_FREQUENCIES: usize = 600;

/// The strongest lines of the missing force, at most so many, strongest first.
///
/// # Model
/// Run by run the part of the missing force that acceleration, velocity, direction and a constant explain is taken out; the
/// power of the rest is added up over the runs at each frequency, since phases of different runs have nothing to do with each
/// other.
///
/// # Source
/// Welch (1967), averaging of periodograms, with runs as segments.
pub fn lines(screen: &Screen, most: usize) -> Vec<Line> {
    let rests: Vec<(f64, Vec<f64>)> = screen.runs.iter().filter_map(|run| rest(screen, run)).collect();
    let longest_s = rests.iter().map(|(step_s, rest)| step_s * rest.len() as f64).fold(0.0, f64::max);
    let fastest_s = rests.iter().map(|(step_s, _)| *step_s).fold(0.0, f64::max);
    if longest_s <= 0.0 {
        return Vec::new();
    }
    let (from, to) = (LEAST_PERIODS / longest_s, PASSED_HZ.min(0.4 / fastest_s));
    let step = (1.0 / (OVERSAMPLING as f64 * longest_s)).max((to - from) / MOST_FREQUENCIES as f64);
    let count = if to > from { ((to - from) / step) as usize } else { 0 };
    let power: Vec<(f64, f64)> = (0..count)
        .map(|k| {
            let frequency = from + k as f64 * step;
            let total: f64 = rests.iter().map(|(step_s, rest)| power(rest, frequency * step_s)).sum();
            (frequency, total)
        })
        .collect();
    let samples: usize = rests.iter().map(|(_, rest)| rest.len()).sum();
    let totals: Vec<f64> = power.iter().map(|(_, total)| *total).collect();
    // A sine of amplitude A over N samples has |Σ y·e^(−iωt)|² = (N·A/2)², and power() gives that over N.
    let amplitude = |total: f64| 2.0 * (total / samples as f64).sqrt();
    let line = |k: usize| Line { frequency_hz: power[k].0, amplitude: amplitude(power[k].1) };
    ordinates::lines(&totals, 0..count).into_iter().take(most).map(line).collect()
}

/// What the base leaves of a run's missing force, thinned, with its sample period.
fn rest(screen: &Screen, run: &Series) -> Option<(f64, Vec<f64>)> {
    let every = run.missing_force.len().div_ceil(MOST_SAMPLES).max(1);
    // What is thinned beyond the band that the smoothing passes would fold into it.
    let every = every.min((0.25 / (PASSED_HZ * run.period_s)).max(1.0) as usize);
    let chosen: Vec<usize> = (0..run.missing_force.len()).step_by(every).collect();
    if chosen.len() < 50 {
        return None;
    }
    let still = 0.02 * screen.largest_speed();
    let direction = |v: f64| if v.abs() > still { v.signum() } else { 0.0 };
    let motion = chosen.iter().map(|&k| [run.acceleration[k], run.velocity[k], direction(run.velocity[k])]);
    let base = Base::of(&motion.collect::<Vec<_>>());
    let rest =
        base.rest_of(&DVector::from_iterator(chosen.len(), chosen.iter().map(|&k| run.missing_force[k])));
    Some((every as f64 * run.period_s, rest.iter().copied().collect()))
}

/// |Σ y·e^(−iωt)|² over the number of samples, the frequency in cycles a sample.
fn power(samples: &[f64], cycles: f64) -> f64 {
    let (s, c) = (TAU * cycles).sin_cos();
    let (mut real, mut imaginary, mut turn) = (0.0, 0.0, (1.0, 0.0));
    for y in samples {
        real += y * turn.0;
        imaginary += y * turn.1;
        turn = (turn.0 * c - turn.1 * s, turn.0 * s + turn.1 * c);
    }
    (real * real + imaginary * imaginary) / samples.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_line_is_found_with_its_amplitude() {
        let run = |phase: f64, count: usize| {
            let time = |k: usize| k as f64 * 1e-3;
            let velocity: Vec<f64> = (0..count).map(|k| 0.2 * (3.0 * time(k)).sin()).collect();
            let missing = |k: usize| 5.0 * velocity[k] + 12.0 * (TAU * 11.3 * time(k) + phase).sin();
            Series {
                period_s: 1e-3,
                acceleration: (0..count).map(|k| 0.6 * (3.0 * time(k)).cos()).collect(),
                motor_force: vec![0.0; count],
                missing_force: (0..count).map(missing).collect(),
                velocity,
            }
        };
        let runs = vec![run(0.3, 3000), run(2.0, 2500)];
        let velocity = runs.iter().flat_map(|run| run.velocity.clone()).collect();
        let screen = Screen { runs, velocity, ..Screen::default() };
        let line = lines(&screen, 1)[0];
        assert!((line.frequency_hz - 11.3).abs() < 0.1, "{line:?}");
        assert!((line.amplitude / 12.0 - 1.0).abs() < 0.1, "{line:?}");
    }
}
