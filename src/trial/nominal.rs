//! Nominal parameters that are a little off, inside their tolerances, as on every real machine.

use crate::drive::motor::Motor;
use crate::error::Result;
use crate::machine::Machine;
use crate::units::Motion;
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};

/// By how much the real machine differs from its file, as fractions; a zero in rad.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NominalErrors {
    /// Moving mass or inertia.
    pub mass: f64,
    /// Viscous coefficient.
    pub viscous: f64,
    /// Force or torque constant.
    pub force_constant: f64,
    /// Resistance of the winding.
    pub resistance: f64,
    /// Inductance of the winding.
    pub inductance: f64,
    /// Zero of the encoder, in rad; of a revolute axis that has weight.
    #[serde(default)]
    pub zero_rad: f64,
    /// Modal masses of the base, each.
    pub modal_mass: Vec<f64>,
}

/// How far nominal parameters are off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Care {
    /// Up to a sixth of each tolerance.
    Careful,
    /// A third of each tolerance, all together: mass 1 %, drag 4 %, force constant 0.5 %, resistance 1 % where the
    /// file states no tolerances of its own.
    Poor,
}

impl Care {
    /// The error of a parameter with a tolerance, from a number between −1 and 1.
    pub(super) fn off(self, tolerance: f64, share: f64) -> f64 {
        match self {
            Self::Careful => CAREFUL * tolerance * share,
            Self::Poor => POOR * tolerance * share.signum(),
        }
    }
}

const CAREFUL: f64 = 1.0 / 6.0;
const POOR: f64 = 1.0 / 3.0;
/// Modal masses have no tolerance; so much of an error stays below the noise of a fine encoder.
const MODAL_MASS: f64 = 0.01;
/// The key of the encoder's zero.
const ZERO: &str = "effect.encoder_zero.zero_rad";

impl NominalErrors {
    /// Draws the errors of a machine.
    pub fn draw(machine: &Machine, care: Care, random: &mut StdRng) -> Self {
        let tolerance = &machine.description().tolerance;
        let constants = machine.constants();
        let mut error = |tolerance: f64| care.off(tolerance, random.random_range(-1.0..1.0));
        Self {
            mass: error(tolerance.mass),
            viscous: error(tolerance.viscous),
            force_constant: error(tolerance.force_constant),
            resistance: error(tolerance.resistance),
            inductance: error(tolerance.inductance),
            zero_rad: if constants.has_turning_weight { error(tolerance.zero_rad) } else { 0.0 },
            modal_mass: (0..constants.modes.len())
                .map(|_| random.random_range(-MODAL_MASS..MODAL_MASS))
                .collect(),
        }
    }

    /// The machine as it really is, before any hidden effect. Its payload is what its mass is off by.
    ///
    /// # Errors
    /// A value that the description refuses.
    pub fn apply(&self, machine: &Machine) -> Result<Machine> {
        let d = machine.description();
        let constants = machine.constants();
        let mut settings: Vec<(String, f64)> = Vec::new();
        let keys = |prismatic: &'static str, revolute: &'static str| {
            let own = if machine.motion() == Motion::Prismatic { prismatic } else { revolute };
            [prismatic, revolute]
                .into_iter()
                .find(|key| machine.number(key).is_some())
                .unwrap_or(own)
                .to_owned()
        };
        match &d.motor {
            Motor::Winding(w) => {
                settings
                    .push(("motor.resistance_ohm".to_owned(), w.resistance_ohm * (1.0 + self.resistance)));
                settings.push(("motor.inductance_h".to_owned(), w.inductance_h * (1.0 + self.inductance)));
                let key = keys("motor.force_constant_n_per_a", "motor.torque_constant_nm_per_a");
                settings.push((key, w.force_constant_n_per_a * (1.0 + self.force_constant)));
            }
            // R and L of the copper are inside the loop.
            Motor::CurrentLoop(current_loop) => {
                let key = keys("motor.force_constant_n_per_a", "motor.torque_constant_nm_per_a");
                settings.push((key, current_loop.force_constant_n_per_a * (1.0 + self.force_constant)));
            }
            Motor::Direct(direct) => {
                let key = keys("motor.force_n_per_v", "motor.torque_nm_per_v");
                settings.push((key, direct.force_n_per_v * (1.0 + self.force_constant)));
            }
        }
        let modes = d.base.iter().flat_map(|base| &base.mode);
        for ((k, mode), error) in modes.enumerate().zip(&self.modal_mass) {
            settings.push((format!("base.mode.{k}.mass_kg"), mode.mass_kg() * (1.0 + error)));
        }
        if self.zero_rad != 0.0 {
            let stated = machine.number(ZERO).unwrap_or(0.0);
            settings.push((ZERO.to_owned(), stated + self.zero_rad));
        }
        let (path, payload) = payload(machine, self.mass * constants.moving_mass);
        settings.push((path, payload));
        let machine =
            machine.with_settings([viscous(machine, d.guide.viscous_n_s_per_m * (1.0 + self.viscous))])?;
        machine
            .with_settings(settings.iter().map(|(path, value)| (path.as_str(), toml::Value::Float(*value))))
    }
}

/// The setting of a payload, on top of one that the machine has.
pub(super) fn payload(machine: &Machine, more: f64) -> (String, f64) {
    let [prismatic, revolute] = ["effect.payload.mass_kg", "effect.payload.inertia_kg_m2"];
    let own = if machine.motion() == Motion::Prismatic { prismatic } else { revolute };
    let stated = [prismatic, revolute].into_iter().find_map(|key| machine.number(key).map(|n| (key, n)));
    let (key, before) = stated.unwrap_or((own, 0.0));
    (key.to_owned(), before + more)
}

/// The setting of the guide's viscous coefficient, under the key that the machine's file uses.
fn viscous(machine: &Machine, value: f64) -> (&'static str, toml::Value) {
    let keys = ["guide.viscous_n_s_per_m", "guide.viscous_nm_s_per_rad"];
    let own = if machine.motion() == Motion::Prismatic { keys[0] } else { keys[1] };
    let key = keys.into_iter().find(|key| machine.number(key).is_some()).unwrap_or(own);
    (key, toml::Value::Float(value))
}
