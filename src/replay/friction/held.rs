//! What is held fixed: by how much its tolerance moves the numbers that are found.

use super::subject::path;
use super::{Friction, identify};
use crate::drive::motor::Circuit;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Run;
use crate::units::Motion;
use rayon::prelude::*;

/// A constant that was held fixed, and what it would change at the upper end of its tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Its name.
    pub constant: &'static str,
    /// Its tolerance, a fraction of its value.
    pub tolerance: f64,
    /// By how much F_c would move, N or N·m.
    pub coulomb: f64,
    /// By how much the acceleration time would move, in s.
    pub acceleration_time_s: Option<f64>,
}

/// Identifies again with each constant at the upper end of its tolerance, and tells by how much the numbers move.
///
/// # Errors
/// As [`identify`].
pub fn held(runs: &[&Run], machine: &Machine, found: &Friction) -> Result<Vec<Held>> {
    let with_viscous = found.viscous.is_some();
    let is_held = |effect: EffectId| !(with_viscous && effect == EffectId::ViscousFriction);
    let shift = |(constant, tolerance, effect, value): (&'static str, f64, EffectId, f64)| {
        let other = machine.with_settings([(path(effect, machine.motion()).as_str(), value.into())])?;
        let moved = identify(runs, &other, with_viscous)?;
        let ramps = moved.acceleration_time_s.zip(found.acceleration_time_s);
        Ok(Held {
            constant,
            tolerance,
            coulomb: moved.coulomb.value - found.coulomb.value,
            acceleration_time_s: ramps.map(|(moved, found)| moved.value - found.value),
        })
    };
    constants(machine).into_par_iter().filter(|(.., effect, _)| is_held(*effect)).map(shift).collect()
}

/// Constants that have a tolerance: name, tolerance, the effect that states another value, the value at its upper end.
fn constants(machine: &Machine) -> Vec<(&'static str, f64, EffectId, f64)> {
    let (tolerance, constants) = (&machine.description().tolerance, machine.constants());
    let stated = machine.stated_constants();
    let payload = machine.number(&path(EffectId::Payload, machine.motion())).unwrap_or(0.0);
    let mass = if machine.motion() == Motion::Prismatic { "moving mass" } else { "inertia" };
    let mut list = vec![
        (mass, tolerance.mass, EffectId::Payload, payload + tolerance.mass * constants.moving_mass),
        (
            "viscous",
            tolerance.viscous,
            EffectId::ViscousFriction,
            (1.0 + tolerance.viscous) * constants.viscous,
        ),
    ];
    // The force constant is stated as a factor on the machine file's.
    let of_stated = match (constants.circuit, stated.circuit) {
        (
            Circuit::Winding { force_constant: now, resistance_ohm, .. },
            Circuit::Winding { force_constant: file, .. },
        ) => {
            if constants.has_voltage_fed_winding {
                let value = (1.0 + tolerance.resistance) * resistance_ohm;
                list.push(("winding resistance", tolerance.resistance, EffectId::WindingResistance, value));
            }
            now / file
        }
        (Circuit::Direct { force_per_volt: now }, Circuit::Direct { force_per_volt: file }) => now / file,
        _ => 1.0,
    };
    let factor = (1.0 + tolerance.force_constant) * of_stated;
    list.push(("force constant", tolerance.force_constant, EffectId::ForceConstant, factor));
    list
}
