//! The phase of a vibration in one run: the run's clock has nothing to do with the source.

use super::hypothesis::path;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::replay::Traces;
use crate::replay::recorded::shakes;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::Range;

/// The phase φ of a vibration from outside, F = A·sin(2π·f·t + φ), in one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunPhase {
    /// The run.
    pub run: String,
    /// φ in rad, −π to π; that which the run states, where it states one. t is the time of the session: the run begins at
    /// t = [`Run::begins_s`](crate::recording::Run::begins_s).
    pub phase_rad: f64,
}

/// Key of the phase.
pub(super) const KEY: &str = "phase_rad";
/// Phases from which a replay's first harmonic follows.
const PROBES: usize = 3;

/// The machines with the phase that suits the run best, where they have a vibration and the run does not state its phase.
///
/// # Model
/// To first order a replay depends on the phase as `y(φ) = ȳ + c·cos φ + s·sin φ`: exactly, where the loop is linear. ȳ, c and s
/// follow from replays at three phases; φ is the direction of the least-squares solution for (cos φ, sin φ), each signal
/// weighed by what the mean replay leaves of it. `replay` gives replays of several machines with perfect sensors.
///
/// # Errors
/// None in practice: any phase is one.
pub fn suited(
    run: &Run,
    signals: &[Signal],
    mut machines: Vec<Machine>,
    replay: impl Fn(&[Machine]) -> Vec<Traces>,
) -> Result<Vec<Machine>> {
    let key = path(EffectId::ExternalVibration, KEY);
    let open: Vec<usize> = (0..machines.len()).filter(|&k| shakes(&machines[k])).collect();
    if open.is_empty() || run.settings.contains_key(&key) {
        return Ok(machines);
    }
    let at =
        |machine: &Machine, phase: f64| machine.with_settings([(key.as_str(), toml::Value::Float(phase))]);
    let probe = |k: usize| TAU * k as f64 / PROBES as f64;
    let probes: Result<Vec<Machine>> = open
        .iter()
        .flat_map(|&m| (0..PROBES).map(move |k| (m, k)))
        .map(|(m, k)| at(&machines[m], probe(k)))
        .collect();
    let replayed = replay(&probes?);
    for (&m, traces) in open.iter().zip(replayed.chunks_exact(PROBES)) {
        if let Some(phase) = best(run, signals, traces) {
            machines[m] = at(&machines[m], phase)?;
        }
    }
    Ok(machines)
}

/// A machine as set in a run, with the phase of another one's vibration advanced by so many rad; unchanged where the run states its phase.
///
/// # Errors
/// None in practice: any phase is one.
pub fn advanced(run: &Run, of: &Machine, machine: Machine, advance_rad: f64) -> Result<Machine> {
    let key = path(EffectId::ExternalVibration, KEY);
    let vibration = of.description().effect.external_vibration.as_ref();
    match vibration.filter(|_| !run.settings.contains_key(&key)) {
        Some(law) => machine.with_settings([(key.as_str(), toml::Value::Float(law.phase_rad + advance_rad))]),
        None => Ok(machine),
    }
}

/// Derivatives of residuals, taken at a fixed phase in each run, become those with phases that follow; so do those taken at a fixed place in a play
/// where a run begins, whose derivative then stands in for that by the phase.
///
/// # Model
/// The phase of each run, whose rows are given, is what makes the weighted sum of squares smallest, `pᵀWr = 0`, with p the derivative of the residuals r
/// by the phase (1/rad). The derivative j by another number is then `j − p·(pᵀWj)/(pᵀWp)`. A phase that is stated or does nothing has p = 0.
///
/// # Validity
/// To first order in the residuals. [`suited`] weighs each signal by what the mean replay leaves of it, not by W: the derivatives are those of its phases
/// where both weigh alike, else a fit descends a little less directly.
///
/// # Source
/// L. Kaufman (1975), *A variable projection method for solving separable nonlinear least squares problems*, BIT 15:49.
pub fn follow(
    jacobian: &mut DMatrix<f64>,
    by_phase: &DVector<f64>,
    weights: &DVector<f64>,
    runs: &[Range<usize>],
) {
    for mut column in jacobian.column_iter_mut() {
        for rows in runs {
            let sum = |of: &dyn Fn(usize) -> f64| -> f64 {
                rows.clone().map(|row| by_phase[row] * weights[row] * of(row)).sum()
            };
            let own = sum(&|row| by_phase[row]);
            if own > 0.0 {
                let share = sum(&|row| column[row]) / own;
                rows.clone().for_each(|row| column[row] -= share * by_phase[row]);
            }
        }
    }
}

/// The phase in rad at which the replays come nearest to the run; none where they do not depend on it.
fn best(run: &Run, signals: &[Signal], traces: &[Traces]) -> Option<f64> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for &signal in signals {
        let probed: Option<Vec<&[f64]>> = traces.iter().map(|traces| traces.signal(signal)).collect();
        let Some((measured, probed)) = run.signal(signal).zip(probed) else { continue };
        let (mut own, mut target, mut misfit) = (Matrix2::zeros(), Vector2::zeros(), 0.0);
        for (k, measured) in measured.iter().enumerate() {
            let harmonic = |weight: &dyn Fn(f64) -> f64| -> f64 {
                let probes = probed.iter().enumerate();
                probes.map(|(p, trace)| weight(TAU * p as f64 / PROBES as f64) * trace[k]).sum()
            };
            let share = 2.0 / PROBES as f64;
            let row = Vector2::new(share * harmonic(&f64::cos), share * harmonic(&f64::sin));
            let left = measured - 0.5 * share * harmonic(&|_| 1.0);
            own += row * row.transpose();
            target += row * left;
            misfit += left * left;
        }
        if misfit > 0.0 {
            normal += own / misfit;
            right += target / misfit;
        }
    }
    let solution = normal.try_inverse()? * right;
    (solution.norm().is_finite() && solution.norm() > 0.0).then(|| solution.y.atan2(solution.x))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// sin(ω·t + φ) in two runs that begin at other times, φ the best one at each ω: the derivative by ω against differences.
    #[test]
    fn exact_phases_follow_a_frequency() {
        let (omega, phases, samples) = (7.0, [0.4, -1.1], 200);
        let time = |run: usize, k: usize| 3.0 * run as f64 + 0.01 * k as f64;
        let rows = 2 * samples;
        let wave = |omega: f64, phases: [f64; 2]| {
            DVector::from_fn(rows, |row, _| {
                let (run, k) = (row / samples, row % samples);
                (omega * time(run, k) + phases[run]).sin()
            })
        };
        let measured = wave(omega, phases);
        let weights = DVector::from_fn(rows, |row, _| if row % 3 == 0 { 0.5 } else { 2.0 });
        let best = |omega: f64, run: usize| {
            let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
            for k in 0..samples {
                let angle = omega * time(run, k);
                let row = Vector2::new(angle.cos(), angle.sin());
                let weight = weights[run * samples + k];
                normal += weight * row * row.transpose();
                right += weight * measured[run * samples + k] * row;
            }
            // a·cos + b·sin = sin(ωt + φ)
            let solution: Vector2<f64> = normal.try_inverse().unwrap() * right;
            solution.x.atan2(solution.y)
        };
        let step = 1e-5;
        let followed = |omega: f64| wave(omega, [best(omega, 0), best(omega, 1)]);
        let expected = (followed(omega + step) - followed(omega - step)) / (2.0 * step);
        let fixed = (wave(omega + step, phases) - wave(omega - step, phases)) / (2.0 * step);
        let turned = |by: f64| wave(omega, phases.map(|phase| phase + by));
        let by_phase = (turned(step) - turned(-step)) / (2.0 * step);
        let mut jacobian = DMatrix::from_columns(std::slice::from_ref(&fixed));
        follow(&mut jacobian, &by_phase, &weights, &[0..samples, samples..rows]);
        let off = |column: &DVector<f64>| (column - &expected).norm() / expected.norm();
        assert!(off(&jacobian.column(0).into_owned()) < 1e-3, "{}", off(&jacobian.column(0).into_owned()));
        assert!(off(&fixed) > 1.0);
    }
}
