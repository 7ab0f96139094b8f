//! A clock that drifts against that of the drive.

use super::{digits, on_steps, reading_steps, remade};
use crate::effect::Prior;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A second device that logs the sensors on a clock of its own.
///
/// # Model
/// Position, velocity and load position come from the second device; references, effort, current and thrust from the
/// drive. Both begin together with each run and count the same nominal period T. Sample k of the second device was
/// taken at the drive's time
/// ```text
///   t_k = k·T + e(k·T)        e(t) = ∫₀ᵗ r + w·sin(2π·(t₀ + τ)/P + φ) dτ
/// ```
/// with t₀ the begin of the run within the session. The signals between their samples are interpolated by the cubic
/// through four of them (Lagrange), beyond the ends they are held; positions are rounded again to the sensor's step. The
/// controller is on the drive's clock.
///
/// # Validity
/// Readings between two samples have less noise than those at samples: in the middle 0.8 of its σ. One device with a
/// wrong clock for all signals would be a sample period that is off by ppm, which hardly shows.
///
/// # Ranges
/// r: 50–500 ppm fast or slow, even on a logarithmic scale; a quartz is good for some ten ppm, a ceramic resonator for
/// some thousand. w: 0–30 % of r; P: 5–60 s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DriftingClock {
    /// Rate r in ppm; positive: the second device samples ever later.
    pub rate_ppm: f64,
    /// Amplitude w of the slow wander of the rate in ppm.
    pub wander_ppm: f64,
    /// Its period P in s.
    pub wander_period_s: f64,
    /// Its phase φ in rad at time 0 of the session.
    pub wander_phase_rad: f64,
}

const RATES_PPM: (f64, f64) = (50.0, 500.0);
const MOST_WANDER: f64 = 0.3;
const WANDER_PERIODS_S: (f64, f64) = (5.0, 60.0);
/// Samples that a cubic needs.
const CUBIC: usize = 4;

impl DriftingClock {
    /// What the second device logs.
    const SIGNALS: [Signal; 3] = [Signal::Position, Signal::Velocity, Signal::LoadPosition];

    /// Draws a clock.
    pub fn draw(random: &mut StdRng) -> Self {
        let rate_ppm =
            digits(Prior::new(random).sign() * Prior::new(random).log_uniform(RATES_PPM.0, RATES_PPM.1));
        Self {
            rate_ppm,
            wander_ppm: digits(rate_ppm.abs() * random.random_range(0.0..MOST_WANDER)),
            wander_period_s: digits(Prior::new(random).log_uniform(WANDER_PERIODS_S.0, WANDER_PERIODS_S.1)),
            wander_phase_rad: digits(random.random_range(0.0..TAU)),
        }
    }

    /// How late e(t) the second device samples, in s, so long after the begin of a run at a time of the session, both in s.
    pub fn late_s(&self, begins_s: f64, after_s: f64) -> f64 {
        let wave = |time_s: f64| (TAU * time_s / self.wander_period_s + self.wander_phase_rad).cos();
        let wandered = self.wander_period_s / TAU * (wave(begins_s) - wave(begins_s + after_s));
        1e-6 * (self.rate_ppm * after_s + self.wander_ppm * wandered)
    }

    /// What is logged of a run; one of fewer than four samples is left as it is.
    pub(super) fn logged(&self, run: &Run, machine: &Machine) -> Result<Run> {
        let mut signals = run.signals().clone();
        let period_s = run.sample_period_s();
        let place = |k: usize| k as f64 + self.late_s(run.begins_s, k as f64 * period_s) / period_s;
        for (signal, samples) in &mut signals {
            if Self::SIGNALS.contains(signal) && samples.len() >= CUBIC {
                let steps = reading_steps(*signal, machine);
                let at = |k: usize| on_steps(interpolated(samples, place(k)), steps);
                *samples = (0..samples.len()).map(at).collect();
            }
        }
        remade(run, signals, run.extra_columns().clone())
    }
}

/// At least four samples at a place between them, counted in samples.
fn interpolated(samples: &[f64], place: f64) -> f64 {
    let last = samples.len() - 1;
    let place = place.clamp(0.0, last as f64);
    let near = (place as usize).clamp(1, last - 2);
    let s = place - near as f64;
    let weights = [
        -s * (s - 1.0) * (s - 2.0) / 6.0,
        (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
        -(s + 1.0) * s * (s - 2.0) / 2.0,
        (s + 1.0) * s * (s - 1.0) / 6.0,
    ];
    // Around the nearest sample, so that a constant stays what it is.
    let about = samples[near];
    let around = weights.iter().zip(&samples[near - 1..]);
    about + around.map(|(weight, sample)| weight * (sample - about)).sum::<f64>()
}
