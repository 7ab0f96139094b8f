//! The sizes by which a machine's motion is measured: what a small or large effect is on it.

use super::engine::sketch;
use super::laws::Otherwise;
use super::runs::TrialRun;
use crate::effect::Scale;
use crate::error::Result;
use crate::machine::Machine;

/// Measures a machine on runs.
///
/// # Errors
/// As [`sketch`].
pub fn scale(machine: &Machine, runs: &[TrialRun], otherwise: &Otherwise) -> Result<Scale> {
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let (mut force, mut voltage_v) = (0.0_f64, 0.0_f64);
    for run in runs {
        let traces = sketch(machine, otherwise, &run.reference(machine), run.begins_s)?;
        force = force.max(largest(&traces.thrust));
        voltage_v = voltage_v.max(largest(&traces.effort_v));
    }
    let stroke =
        runs.iter().map(|r| r.travel(machine)).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let speed = runs.iter().map(|r| r.speed(machine)).fold(0.0, f64::max);
    Ok(Scale { constants: machine.constants(), force, voltage_v, speed, stroke })
}
