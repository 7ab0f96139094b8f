//! A forged machine as it really is: its file, what its nominal parameters are off by, and the effects that act.

use super::nominal::{self, NominalErrors};
use crate::drive::motor::Circuit;
use crate::effect::{Constants, EffectId};
use crate::error::Result;
use crate::machine::{Machine, Tolerance};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An effect of a forged machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Acting {
    /// The effect.
    pub effect: EffectId,
    /// Its parameters in the law's order.
    pub values: Vec<f64>,
    /// Whether the tier asked for it.
    pub planned: bool,
}

impl Acting {
    /// What comes with another effect, or beside it.
    pub fn attendant(effect: EffectId, values: Vec<f64>) -> Self {
        Self { effect, values, planned: false }
    }
}

/// An effect with its parameters by their keys, as the truth file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Known {
    /// The effect.
    pub effect: EffectId,
    /// Its parameters.
    pub parameters: BTreeMap<String, f64>,
}

impl Known {
    /// Of an effect on a machine.
    pub fn new(acting: &Acting, machine: &Machine) -> Self {
        Self { effect: acting.effect, parameters: by_key(acting, machine) }
    }

    /// Its parameters in the law's order.
    pub fn acting(&self, machine: &Machine) -> Acting {
        Acting::attendant(self.effect, in_order(self.effect, &self.parameters, machine))
    }
}

/// Parameters by the keys of a machine's file.
pub fn by_key(acting: &Acting, machine: &Machine) -> BTreeMap<String, f64> {
    let keys = acting.effect.parameters().iter().map(|p| p.key(machine.motion()).to_owned());
    keys.zip(acting.values.iter().copied()).collect()
}

/// Parameters in the law's order; not a number where one is missing.
pub fn in_order(effect: EffectId, parameters: &BTreeMap<String, f64>, machine: &Machine) -> Vec<f64> {
    let keys = effect.parameters().iter().map(|p| p.key(machine.motion()));
    keys.map(|key| parameters.get(key).copied().unwrap_or(f64::NAN)).collect()
}

/// A forged machine but for what is hidden.
#[derive(Debug, Clone)]
pub struct Real<'a> {
    machine: &'a Machine,
    nominal: NominalErrors,
    known: Vec<Acting>,
    quiet: Constants,
    shift: Option<Shift>,
}

/// By how much a number of an effect is moved where the effect is hidden: a hidden viscous coefficient takes the place of the stated one, with the
/// tolerance of the stated one.
#[derive(Debug, Clone, Copy)]
struct Shift {
    effect: EffectId,
    parameter: usize,
    by: f64,
}

impl<'a> Real<'a> {
    /// A machine whose nominal parameters are off and on which some effects act that are not looked for: those that its twin states, as
    /// they really are, and those of before a change.
    ///
    /// # Errors
    /// Values that the description refuses.
    pub fn new(machine: &'a Machine, nominal: NominalErrors, known: Vec<Acting>) -> Result<Self> {
        let quiet = with_effects(&nominal.apply(machine)?, &known)?.constants();
        Ok(Self { machine, nominal, known, quiet, shift: None })
    }

    /// The machine with hidden effects. One that is known has the hidden values; a feature without what it modifies does nothing and is
    /// left out.
    ///
    /// # Errors
    /// Values that the description refuses, or effects that cannot stand beside each other.
    pub fn with(&self, hidden: &[Acting]) -> Result<Machine> {
        let is_hidden = |known: &&Acting| hidden.iter().all(|acting| acting.effect != known.effect);
        let hidden = hidden.iter().cloned().map(|acting| self.shifted(acting));
        let mut all: Vec<Acting> = self.known.iter().filter(is_hidden).cloned().chain(hidden).collect();
        let real = self.nominal.apply(self.machine)?;
        let guide = real.description();
        // What a feature modifies may itself be one that goes.
        loop {
            let is_there = |effect: EffectId| {
                all.iter().any(|acting| acting.effect == effect)
                    || guide.effect.contains(effect)
                    || guide.guide_has(effect)
            };
            let own: Vec<Acting> =
                all.iter().filter(|acting| acting.effect.has_modified(is_there)).cloned().collect();
            if own.len() == all.len() {
                break;
            }
            all = own;
        }
        with_effects(&real, &all)
    }

    fn shifted(&self, mut hidden: Acting) -> Acting {
        if let Some(shift) = self.shift.filter(|shift| shift.effect == hidden.effect) {
            hidden.values[shift.parameter] += shift.by;
        }
        hidden
    }

    /// The machine as its file states it.
    pub fn machine(&self) -> &Machine {
        self.machine
    }

    /// What is known of it.
    pub fn known(&self) -> &[Acting] {
        &self.known
    }

    /// Constants of the machine without anything hidden.
    pub fn constants(&self) -> &Constants {
        &self.quiet
    }

    /// The parameters of an effect where it is not hidden: as known, or at which it does nothing.
    pub fn absent(&self, effect: EffectId) -> Vec<f64> {
        let known = self.known.iter().find(|known| known.effect == effect);
        known.map_or_else(|| effect.neutral(&self.quiet), |known| known.values.clone())
    }

    /// The machine with each constant that has a tolerance moved by a share of it, one at a time; one that a hidden effect states anew is moved there.
    pub fn moved(&self, share: f64) -> Vec<Self> {
        let Tolerance { mass, viscous, force_constant, resistance, inductance, zero_rad, effect } =
            self.machine.description().tolerance.clone();
        let mut moved = Vec::new();
        let mut nominal =
            |part: fn(&mut NominalErrors) -> &mut f64, tolerance: f64, anew: Option<(EffectId, f64)>| {
                let mut one = self.clone();
                *part(&mut one.nominal) += share * tolerance;
                one.shift =
                    anew.map(|(effect, unit)| Shift { effect, parameter: 0, by: share * tolerance * unit });
                moved.push(one);
            };
        let [resistance_ohm, inductance_h] = match self.quiet.circuit {
            Circuit::Winding { resistance_ohm, inductance_h, .. } => [resistance_ohm, inductance_h],
            Circuit::Direct { .. } => [0.0; 2],
        };
        // A payload and a factor of the force constant come on top of what those are off by.
        nominal(|n| &mut n.mass, mass, None);
        nominal(|n| &mut n.viscous, viscous, Some((EffectId::ViscousFriction, self.quiet.viscous)));
        nominal(|n| &mut n.force_constant, force_constant, None);
        nominal(|n| &mut n.resistance, resistance, Some((EffectId::WindingResistance, resistance_ohm)));
        nominal(|n| &mut n.inductance, inductance, Some((EffectId::WindingInductance, inductance_h)));
        if self.quiet.has_turning_weight {
            nominal(|n| &mut n.zero_rad, zero_rad, Some((EffectId::EncoderZero, 1.0)));
        }
        for (place, known) in self.known.iter().enumerate() {
            for parameter in 0..known.values.len() {
                let mut one = self.clone();
                let by = share * effect * known.values[parameter];
                one.known[place].values[parameter] += by;
                one.shift = Some(Shift { effect: known.effect, parameter, by });
                moved.push(one);
            }
        }
        moved
    }
}

/// A machine with effects in it. A payload comes on top of what the mass is off by.
fn with_effects(machine: &Machine, effects: &[Acting]) -> Result<Machine> {
    let mut settings: Vec<(String, toml::Value)> = Vec::new();
    for acting in effects {
        for (parameter, &value) in acting.effect.parameters().iter().zip(&acting.values) {
            let key = parameter.key(machine.motion());
            let (path, value) = match acting.effect {
                EffectId::Payload if ["mass_kg", "inertia_kg_m2"].contains(&key) => {
                    nominal::payload(machine, value)
                }
                effect => (format!("effect.{}.{key}", effect.name()), value),
            };
            settings.push((path, toml::Value::Float(value)));
        }
    }
    machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), value.clone())))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::machine::shipped;

    /// A hidden effect that states a constant anew is calibrated like the constant: a viscous coefficient by 12 % of the stated one, a stated
    /// friction by its tolerance. Without the hidden effect the constant itself moves.
    #[test]
    fn exact_constants_stated_anew_have_their_tolerance() {
        let drags = |machine: &Machine| machine.constants().viscous > 0.0;
        let machine = shipped().find(drags).unwrap();
        let known = Acting::attendant(EffectId::CoulombFriction, vec![10.0]);
        let real = Real::new(&machine, NominalErrors::default(), vec![known]).unwrap();
        let stated = machine.constants().viscous;
        let hidden = [
            Acting { effect: EffectId::ViscousFriction, values: vec![2.0 * stated], planned: true },
            Acting { effect: EffectId::CoulombFriction, values: vec![30.0], planned: true },
        ];
        let Tolerance { viscous, effect, .. } = machine.description().tolerance.clone();
        let moved = |hidden: &[Acting]| -> Vec<[f64; 2]> {
            let of = |constants: Constants| [constants.viscous, constants.friction.coulomb];
            real.moved(0.5).iter().map(|real| of(real.with(hidden).unwrap().constants())).collect()
        };
        let near = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9 * b);
        let has =
            |all: Vec<[f64; 2]>, one: [f64; 2]| all.iter().filter(|moved| near(**moved, one)).count() == 1;
        assert!(has(moved(&[]), [(1.0 + 0.5 * viscous) * stated, 10.0]));
        assert!(has(moved(&[]), [stated, 10.0 * (1.0 + 0.5 * effect)]));
        assert!(has(moved(&hidden), [(2.0 + 0.5 * viscous) * stated, 30.0]));
        assert!(has(moved(&hidden), [2.0 * stated, 30.0 + 0.5 * effect * 10.0]));
    }
}
