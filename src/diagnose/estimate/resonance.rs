//! Where a mode that is not listed might lie: the missing force as the reaction of an oscillator.

use super::Screen;
use crate::base::{BaseMotion, Mode, Modes};

/// A mode that the missing force suggests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Modal mass in kg or kg·m².
    pub mass: f64,
}

/// Frequencies tried, evenly on a logarithmic scale.
const FREQUENCIES: usize = 60;
/// Lowest frequency tried in Hz.
pub const LOWEST_HZ: f64 = 2.0;
/// The smoothing of the missing force passes changes up to about this frequency, in Hz.
const HIGHEST_HZ: f64 = 120.0;
/// Damping ratio of the trial oscillators.
const DAMPING: f64 = 0.03;
/// Columns of every regression beside the oscillator: acceleration, velocity, direction, constant.
const BASE: usize = 4;

/// The frequencies at which an oscillator explains most of the missing force, best first.
///
/// # Model
/// An oscillator of unit modal mass is driven by the motor's force; the moving part feels m·η̈ of it. The missing force is
/// regressed on that beside acceleration, velocity, direction and a constant, frequency by frequency; the coefficient of m·η̈
/// is −1/M.
pub fn resonances(screen: &Screen, most: usize) -> Vec<Resonance> {
    let found: Vec<(f64, f64, f64)> = (0..FREQUENCIES)
        .map(|k| LOWEST_HZ * (HIGHEST_HZ / LOWEST_HZ).powf(k as f64 / (FREQUENCIES - 1) as f64))
        .filter(|f| *f < 0.3 / screen.sample_period_s())
        .filter_map(|f| explain(screen, f).map(|(gain, coefficient)| (f, gain, coefficient)))
        .collect();
    let is_peak = |k: usize| {
        let around = k.saturating_sub(2)..(k + 3).min(found.len());
        found[k].2 < 0.0 && around.into_iter().all(|j| found[j].1 <= found[k].1)
    };
    let mut peaks: Vec<usize> = (0..found.len()).filter(|&k| is_peak(k)).collect();
    peaks.sort_by(|&a, &b| found[b].1.total_cmp(&found[a].1));
    let of = |&k: &usize| Resonance { frequency_hz: found[k].0, mass: -1.0 / found[k].2 };
    peaks.iter().take(most).map(of).collect()
}

/// Sum of squares that the oscillator explains beyond the base, and its coefficient.
fn explain(screen: &Screen, frequency_hz: f64) -> Option<(f64, f64)> {
    let modes = Modes::new(vec![Mode::new(frequency_hz, 1.0, DAMPING).ok()?]);
    let mass = screen.moving_mass();
    let still = 0.02 * screen.largest_speed();
    let mut gram = nalgebra::DMatrix::zeros(BASE + 1, BASE + 1);
    let mut right = nalgebra::DVector::zeros(BASE + 1);
    for run in &screen.runs {
        let oscillator = BaseMotion::new(&modes, run.period_s).ok()?;
        let mut state = vec![0.0; oscillator.state_len()];
        let mut before = 0.0;
        for k in 0..run.missing_force.len() {
            oscillator.advance(&mut state, -run.motor_force[k]);
            let now = oscillator.velocity(&state);
            let reaction = mass * (now - before) / run.period_s;
            before = now;
            let v = run.velocity[k];
            if v.abs() <= still {
                continue;
            }
            let row = nalgebra::dvector![run.acceleration[k], v, v.signum(), 1.0, reaction];
            right.axpy(run.missing_force[k], &row, 1.0);
            gram.ger(1.0, &row, &row, 1.0);
        }
    }
    // In units of each column's own size; a column that is zero throughout stays out by the ridge.
    let size = gram.diagonal().map(|d: f64| d.max(f64::MIN_POSITIVE).sqrt());
    let scaled = |count: usize| -> Option<(f64, f64)> {
        let matrix = nalgebra::DMatrix::from_fn(count, count, |r, c| {
            gram[(r, c)] / (size[r] * size[c]) + if r == c { 1e-9 } else { 0.0 }
        });
        let target = nalgebra::DVector::from_fn(count, |r, _| right[r] / size[r]);
        let solution = matrix.cholesky()?.solve(&target);
        Some((solution.dot(&target), solution[count - 1] / size[count - 1]))
    };
    let (without, _) = scaled(BASE)?;
    let (with, coefficient) = scaled(BASE + 1)?;
    Some((with - without, coefficient))
}
