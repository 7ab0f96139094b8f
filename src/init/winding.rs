//! Resistance, inductance and back-EMF, from effort, current and motion.

use nalgebra::{Matrix4, Vector4};

use super::delay;
use crate::identify::least_squares::Estimate;
use crate::recording::{Run, Signal};

/// Late by so many samples at most.
const MOST_DELAY: usize = 8;
/// Samples by which the instrument is older than the current: its noise is then another.
const OLDER: usize = 2;
/// Lags over which the residual of a sampled circuit is correlated: noise of two currents, and of the instrument.
const LAGS: usize = 6;
/// The circuit must leave less than this share of the current's variance.
const FITS: f64 = 0.02;
/// Fewest samples.
const LEAST: usize = 200;

/// A winding as effort and current show it.
///
/// # Model
/// ```text
///   i(k+1) = α·i(k) + β·u(k − n) + γ·v(k) + δ        v(k): mean over the period, from the positions
///   R = (1 − α)/β        L = −R·T/ln α        Ke = −γ/β
/// ```
/// Noise in i(k) would pull α towards zero: i(k−2) stands in for it (instrumental variable). Intervals from the residual's
/// own correlation. A current loop of first order has the same equation, with Ke = 0: only a back-EMF tells the two apart.
///
/// # Source
/// Söderström, Stoica, *System Identification* (1989), section 8.1.
#[derive(Debug, Clone, Copy)]
pub struct FoundWinding {
    /// R in Ω.
    pub resistance: Estimate,
    /// L in H.
    pub inductance: Estimate,
    /// Ke in V·s/m or V·s/rad.
    pub back_emf: Estimate,
    /// Time from the effort to the voltage, in s.
    pub delay: Estimate,
    /// Share of the current's variance that one step of the circuit explains.
    pub explained: f64,
}

struct Solved {
    theta: Vector4<f64>,
    covariance: Matrix4<f64>,
    left: f64,
}

/// The winding; none where a signal is missing or no such circuit shows.
pub fn winding(runs: &[Run]) -> Option<FoundWinding> {
    let period_s = runs.first()?.sample_period_s();
    let solved: Vec<Solved> = (0..=MOST_DELAY).map_while(|delay| solve(runs, delay)).collect();
    // One step of a slow circuit hardly tells which effort it was; a whole run does.
    let costs: Vec<f64> = solved
        .iter()
        .enumerate()
        .map(|(delay, s)| simulated(runs, &s.theta, delay).unwrap_or(f64::INFINITY))
        .collect();
    let best = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map(|(k, _)| k)?;
    let Solved { theta, covariance, left } = &solved[best];
    let constants = |theta: &Vector4<f64>| -> [f64; 3] {
        let resistance = (1.0 - theta[0]) / theta[1];
        [resistance, -resistance * period_s / theta[0].ln(), -theta[2] / theta[1]]
    };
    let values = constants(theta);
    let is_circuit = theta[0] > 0.0 && theta[0] < 1.0 && theta[1] > 0.0 && *left < FITS;
    if !is_circuit || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let estimate = |which: usize| {
        let slope = Vector4::from_fn(|j, _| {
            let step = 1e-4 * covariance[(j, j)].sqrt().max(1e-12);
            let mut moved = *theta;
            moved[j] += step;
            (constants(&moved)[which] - values[which]) / step
        });
        let standard_error = slope.dot(&(covariance * slope)).max(0.0).sqrt();
        Estimate::of_many(values[which], standard_error)
    };
    Some(FoundWinding {
        resistance: estimate(0),
        inductance: estimate(1),
        back_emf: estimate(2),
        delay: delay::of_costs(&costs, best, period_s),
        explained: 1.0 - left,
    })
}

/// Mean square by which the circuit's current, computed from effort and motion alone, is off.
fn simulated(runs: &[Run], theta: &Vector4<f64>, delay: usize) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for run in runs {
        let current = run.signal(Signal::Current)?;
        let (effort, position) = (run.signal(Signal::ControlEffort)?, run.signal(Signal::Position)?);
        let mut own = *current.get(MOST_DELAY)?;
        for k in MOST_DELAY..current.len().saturating_sub(1) {
            let velocity = (position[k + 1] - position[k]) / run.sample_period_s();
            own = theta.dot(&Vector4::new(own, effort[k - delay], velocity, 1.0));
            sum += (current[k + 1] - own).powi(2);
            count += 1.0;
        }
    }
    Some(sum / count.max(1.0)).filter(|mean| mean.is_finite())
}

fn solve(runs: &[Run], delay: usize) -> Option<Solved> {
    let mut rows: Vec<(Vector4<f64>, Vector4<f64>, f64)> = Vec::new();
    let (mut sum, mut square) = (0.0, 0.0);
    for run in runs {
        let current = run.signal(Signal::Current)?;
        let (effort, position) = (run.signal(Signal::ControlEffort)?, run.signal(Signal::Position)?);
        for k in OLDER.max(delay)..current.len().saturating_sub(1) {
            let velocity = (position[k + 1] - position[k]) / run.sample_period_s();
            let others = [effort[k - delay], velocity, 1.0];
            let with = |first: f64| Vector4::new(first, others[0], others[1], others[2]);
            rows.push((with(current[k]), with(current[k - OLDER]), current[k + 1]));
            sum += current[k + 1];
            square += current[k + 1].powi(2);
        }
    }
    let count = rows.len() as f64;
    let variance = square / count - (sum / count).powi(2);
    if rows.len() < LEAST || variance <= 0.0 {
        return None;
    }
    let (mut cross, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for (x, z, y) in &rows {
        cross += z * x.transpose();
        right += z * *y;
    }
    let inverse = cross.try_inverse()?;
    let theta = inverse * right;
    let residuals: Vec<f64> = rows.iter().map(|(x, _, y)| y - theta.dot(x)).collect();
    let mut middle = Matrix4::zeros();
    for lag in 0..=LAGS {
        let weight = 1.0 - lag as f64 / (LAGS as f64 + 1.0);
        let mut own = Matrix4::zeros();
        for k in lag..rows.len() {
            own += rows[k].1 * rows[k - lag].1.transpose() * (residuals[k] * residuals[k - lag]);
        }
        middle += if lag == 0 { own } else { (own + own.transpose()) * weight };
    }
    let left = residuals.iter().map(|e| e * e).sum::<f64>() / count / variance;
    Some(Solved { theta, covariance: inverse * middle * inverse.transpose(), left })
}
