//! The strokes of a cross-check, and one of them on a plant.

use super::super::simulation::simulate;
use super::super::travel::check_travel;
use super::super::{Cell, Motion, PlantChoice, Stroke, Traces, run};
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::{Plant, axis::Axis, mujoco::MujocoRig, rapier::Rig};
use crate::twin::{Command, Sensing, Twin};
use crate::units;

/// Shares of travel and speed of a machine whose file names no cells.
const SHARES_OF_TRAVEL: [f64; 2] = [0.1, 0.4];
const SHARES_OF_SPEED: [f64; 2] = [0.2, 0.8];
/// Share of the drive's effort that a ramp may need at most.
const SHARE_OF_EFFORT: f64 = 0.5;
/// Travel where the joint has no limits: 0.1 m or a turn; and the time in which it is travelled, in s.
const TRAVEL_M: f64 = 0.1;
const TRAVEL_RAD: f64 = std::f64::consts::TAU;
const TRAVEL_TIME_S: f64 = 1.0;
/// Standstill before and after the stroke, in s.
const LEAD_S: f64 = 0.02;
const DWELL_S: f64 = 0.6;

/// The strokes of a machine: those of its table `[crosscheck]`, or four of its own size.
///
/// # Model
/// 10 % and 40 % of the longer side of the travel from zero, each at 20 % and 80 % of the joint's speed.
///
/// # Errors
/// None in practice: cells are checked where the machine is read.
pub fn cells_of(machine: &Machine) -> Result<Vec<Cell>> {
    if let Some(plan) = &machine.description().crosscheck {
        let cell = |text: &String| {
            text.parse::<Cell>().map_err(|error| error.file(machine.file()).key("crosscheck.cells"))
        };
        return plan.cells.iter().map(cell).collect();
    }
    let joint = &machine.solid().joint;
    let (travel, per_si) = match machine.motion() {
        units::Motion::Prismatic => (TRAVEL_M, 60.0),
        units::Motion::Revolute => (TRAVEL_RAD, 1.0),
    };
    let side = if joint.upper >= -joint.lower { joint.upper } else { joint.lower };
    let travel = if side.is_finite() { side } else { travel };
    let is_limited = joint.velocity.is_finite() && joint.velocity > 0.0;
    let speed = if is_limited { joint.velocity } else { travel.abs() / TRAVEL_TIME_S };
    let both = SHARES_OF_SPEED.into_iter().flat_map(|v| SHARES_OF_TRAVEL.map(|s| [s * travel, v * speed]));
    both.map(|[stroke, feed]| Cell::new(two_digits(stroke), two_digits(per_si * feed))).collect()
}

/// Two significant digits, towards zero: what is planned within a limit stays there.
fn two_digits(value: f64) -> f64 {
    let decade = 10f64.powf(value.abs().log10().floor() - 1.0);
    let rounded = ((value / decade) + 1e-9 * value.signum()).trunc() * decade;
    // As it is written: no digits of the power of ten.
    format!("{rounded:.1e}").parse().unwrap_or(rounded)
}

/// A stroke as it is commanded.
#[derive(Debug, Clone)]
pub struct Planned {
    /// The stroke at its feed.
    pub cell: Cell,
    /// Time from rest to the feed, in s.
    pub ramp_s: f64,
    /// Position reference, a number a sample.
    pub reference: Vec<f64>,
}

impl Planned {
    /// The stroke with the machine's ramp, or with a longer one where half of the drive's effort would not do.
    ///
    /// # Errors
    /// A stroke beyond the travel.
    pub fn of(machine: &Machine, cell: Cell) -> Result<Self> {
        let stroke = cell.stroke(machine.motion())?;
        let ramp_s = ramp_s(machine, &stroke);
        let motion = Motion { strokes: vec![stroke], lead_s: LEAD_S, dwell_s: DWELL_S, ramp_s };
        // Before what would be a stroke of many hours is sampled.
        check_travel(machine, &[stroke.stroke])?;
        let reference = motion.reference(machine.description().sample_period_s);
        Ok(Self { cell, ramp_s, reference })
    }

    /// The stroke on a plant with perfect sensors: in closed loop, or by the force that it needs where the machine has no
    /// controller.
    ///
    /// # Errors
    /// What the plant refuses.
    pub fn replay(&self, machine: &Machine, plant: PlantChoice) -> Result<Traces> {
        if machine.description().controller.is_some() {
            return simulate(machine, plant, Sensing::Perfect, &self.reference, |_| ());
        }
        let force = self.force(machine);
        Ok(match plant {
            PlantChoice::Axis => pushed(machine, Axis::of(&machine.constants()), &force),
            PlantChoice::Rapier => pushed(machine, Rig::new(machine)?, &force),
            PlantChoice::Mujoco => pushed(machine, MujocoRig::new(machine)?, &force),
        })
    }

    /// Force (torque) by which mass and drag follow the reference, held from sample to sample.
    ///
    /// # Model
    /// `F = m·(v[k+1] − v[k])/T + c·v[k] − W(x[k])`, v the backward difference of the reference, W weight along the joint.
    fn force(&self, machine: &Machine) -> Vec<f64> {
        let (constants, weight) = (machine.constants(), machine.weight());
        let (x, period_s) = (&self.reference, constants.sample_period_s);
        let at = |k: usize| x[k.min(x.len() - 1)];
        let velocity = |k: usize| (at(k) - at(k.saturating_sub(1))) / period_s;
        (0..x.len())
            .map(|k| {
                constants.moving_mass * (velocity(k + 1) - velocity(k)) / period_s
                    + constants.viscous * velocity(k)
                    - weight.map_or(0.0, |weight| weight.effort(at(k)))
            })
            .collect()
    }
}

fn pushed(machine: &Machine, plant: impl Plant, force: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, plant, Sensing::Perfect);
    let command = |force: &f64| Command { thrust: Some(*force), ..Command::follow(0.0, 0.0) };
    run(&mut twin, force.iter().map(command), |_| ())
}

/// Time from rest to the feed, s: the machine's own, or a longer one where half of the drive's effort would not do.
pub fn ramp_s(machine: &Machine, stroke: &Stroke) -> f64 {
    let (description, constants) = (machine.description(), machine.constants());
    let by_voltage = constants.effort_limit_v().map(|limit| limit * constants.force_per_volt());
    let limits = [Some(machine.solid().joint.effort), by_voltage].into_iter().flatten();
    let effort = limits.filter(|limit| *limit > 0.0).fold(f64::INFINITY, f64::min);
    let needed_s = stroke.feed * constants.moving_mass / (SHARE_OF_EFFORT * effort);
    description.reference.acceleration_time_s.max(needed_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_planned_numbers_stay_within_their_limit() {
        let cases =
            [(0.035, 0.035), (0.1 * 0.35, 0.035), (0.8 * 60.0, 48.0), (-0.0499, -0.049), (TRAVEL_RAD, 6.2)];
        for (value, rounded) in cases {
            assert_eq!(two_digits(value), rounded, "{value}");
        }
    }
}
