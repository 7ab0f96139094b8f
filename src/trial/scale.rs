//! What the priors of effects are scaled by: the machine alone.

use super::real::Real;
use super::runs::{Bounds, TrialRun};
use crate::effect::Machinery;
use crate::error::Result;
use crate::machine::Machine;

/// Rated force of a motor as a share of the one that accelerates the axis on its ordinary motion: servo motors give two to three times
/// their rated force for as long as that takes.
const RATED: f64 = 0.5;

/// Scales of a machine as it really is, hidden effects aside.
///
/// # Model
/// The ordinary motion has the largest speed v and acceleration a that runs ask for; see [`Bounds`]. It takes F = m·a + c·v, and the voltage
/// that gives F at standstill.
///
/// # Errors
/// A joint without room on either side of zero.
pub fn machinery(machine: &Machine, real: &Real, runs: &[TrialRun]) -> Result<Machinery> {
    let constants = real.constants().clone();
    let bounds = Bounds::of(machine)?;
    let speed = bounds.speed;
    let force = constants.moving_mass * bounds.acceleration + constants.viscous * speed;
    let voltage_v = constants.effort_limit_v().unwrap_or(force / constants.force_per_volt());
    let travel =
        runs.iter().map(|r| r.travel(machine)).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let coulomb = constants.friction.at_rest();
    Ok(Machinery {
        motion: machine.motion(),
        rated_force: RATED * force,
        voltage_v,
        speed,
        travel,
        coulomb,
        constants,
    })
}
