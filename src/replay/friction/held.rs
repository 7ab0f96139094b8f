//! What is held fixed: by how much its tolerance moves the numbers that are found.

use super::interval::moved;
use super::subject::{Subject, path};
use super::{Held, Numbers};
use crate::drive::motor::Circuit;
use crate::effect::EffectId;
use crate::error::Result;
use crate::identify::nonlinear::Solution;
use crate::machine::Machine;
use rayon::prelude::*;

/// Shifts of Coulomb friction (at place `coulomb`) and acceleration time (at place 0, where there is one) under each
/// constant's tolerance, to first order.
pub(super) fn held(
    solution: &Solution,
    (subjects, all): (&[Subject], &[Numbers]),
    machine: &Machine,
    coulomb: usize,
) -> Result<Vec<Held>> {
    let shift = |(constant, tolerance, effect, value): (&'static str, f64, EffectId, f64)| {
        let others = [(path(effect, machine.motion()), value)];
        let changes = subjects.par_iter().zip(all).map(|(subject, numbers)| subject.change(numbers, &others));
        // A change of residuals is that of a prediction with its sign turned.
        let shifts = moved(solution, changes.collect::<Result<Vec<_>>>()?.concat())?;
        let acceleration_time_s = (coulomb > 0).then(|| shifts[0]);
        Ok(Held { constant, tolerance, coulomb: shifts[coulomb], acceleration_time_s })
    };
    let has_viscous = all.iter().any(|numbers| numbers.viscous.is_some());
    constants(machine)
        .into_iter()
        .filter(|(.., effect, _)| !(has_viscous && *effect == EffectId::ViscousFriction))
        .map(shift)
        .collect()
}

/// Constants that have a tolerance: name, tolerance, the effect that states another value, the value at its upper end.
fn constants(machine: &Machine) -> Vec<(&'static str, f64, EffectId, f64)> {
    let (tolerance, constants) = (&machine.description().tolerance, machine.constants());
    let stated = machine.stated_constants();
    let payload = constants.moving_mass - stated.moving_mass;
    let mut list = vec![
        ("moving mass", tolerance.mass, EffectId::Payload, payload + tolerance.mass * constants.moving_mass),
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
            let value = (1.0 + tolerance.resistance) * resistance_ohm;
            list.push(("winding resistance", tolerance.resistance, EffectId::WindingResistance, value));
            now / file
        }
        (Circuit::Direct { force_per_volt: now }, Circuit::Direct { force_per_volt: file }) => now / file,
        _ => 1.0,
    };
    let factor = (1.0 + tolerance.force_constant) * of_stated;
    list.push(("force constant", tolerance.force_constant, EffectId::ForceConstant, factor));
    list
}
