//! What the priors of effects are scaled by: the machine alone.

use super::real::Real;
use super::strokes::{Strokes, largest_feed};
use crate::effect::Machinery;
use crate::machine::Machine;

/// Rated force of a motor as a share of the one that accelerates the axis on its ordinary motion: servo motors give two to three times
/// their rated force for as long as that takes.
const RATED: f64 = 0.5;

/// Scales of a machine as it really is, hidden effects aside.
///
/// # Model
/// The ordinary motion is the largest feed within the stated acceleration time, as far as the drive can give it. It takes
/// F = m·v/t + c·v, and the voltage that gives F at standstill.
pub fn machinery(machine: &Machine, real: &Real, runs: &[Strokes]) -> Machinery {
    let constants = real.constants().clone();
    let speed = largest_feed(machine);
    let ramp_s = machine.description().reference.acceleration_time_s.max(constants.sample_period_s);
    let force = constants.moving_mass * speed / ramp_s + constants.viscous * speed;
    let voltage_v = constants.effort_limit_v().unwrap_or(force / constants.force_per_volt());
    let travel = runs.iter().map(|r| r.stroke).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    let coulomb = constants.friction.level(1.0, 0.0).max(constants.friction.level(-1.0, 0.0));
    Machinery {
        motion: machine.motion(),
        rated_force: RATED * force,
        voltage_v,
        speed,
        travel,
        coulomb,
        constants,
    }
}
