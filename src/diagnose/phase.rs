//! The phase of a vibration in one run: the run's clock has nothing to do with the source.

use super::hypothesis::path;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::replay::Traces;
use crate::replay::recorded::shakes;
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

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
const KEY: &str = "phase_rad";
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
