//! Back-EMF off its stated value.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::drive::motor::Circuit;
use serde::{Deserialize, Serialize};

/// Back-EMF: voltage that the moving motor induces against its drive.
///
/// # Model
/// `L·di/dt = u − R·i − Ke·v`, with Ke in the place of the stated constant.
///
/// # Validity
/// Ke ≥ 0. Where the amplifier closes a fast current loop around the winding, that loop hides it.
///
/// # Prior
/// Where a constant is stated, Ke is 0.8 to 1.05 times it, uniform, as [`ForceConstant`](super::ForceConstant) is: both come from
/// the same flux. Where none is, Ke is 2 to 100 % of the force constant in SI units, log-uniform: all of it in a winding that is
/// fed with voltage as the energy balance has it, a small share where the amplifier compensates most. Leonhard, *Control of
/// Electrical Drives*, 3rd ed. (2001); data sheets of servo motors.
///
/// # Source
/// Any text on electrical drives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BackEmf {
    /// Ke in V·s/m, or V·s/rad for a revolute axis; not negative.
    #[serde(alias = "back_emf_v_s_per_rad")]
    pub back_emf_v_s_per_m: f64,
}

impl Law for BackEmf {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "back-EMF off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::differing("back_emf_v_s_per_m", "back_emf_v_s_per_rad", "V·s/m", "V·s/rad")
            .not_negative()];

    fn fault(&self) -> Option<String> {
        negative("back_emf_v_s_per_m", self.back_emf_v_s_per_m)
    }

    fn alter(&self, constants: &mut Constants) {
        if let Circuit::Winding { back_emf, .. } = &mut constants.circuit {
            *back_emf = self.back_emf_v_s_per_m;
        }
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.circuit {
            Circuit::Winding { back_emf, .. } => vec![back_emf],
            Circuit::Direct { .. } => vec![0.0],
        }
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!constants.has_voltage_fed_winding).then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "L·di/dt = u − R·i − Ke·v";
    const SYMBOLS: &'static [&'static str] = &["Ke"];
    const SOURCE: &'static str = "any text on electrical drives";
    const SHOWN_BY: &'static str =
        "Control effort beside current, in proportion to speed: constant speed at several feeds.";
    const EXAMPLE: &'static [f64] = &[20.0];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::ViscousFriction, "where neither current nor force is logged")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = Self::neutral(&machine.constants).first().copied().unwrap_or(0.0);
        vec![if stated > 0.0 {
            stated * prior.uniform(0.8, 1.05)
        } else {
            machine.constants.force_constant().abs() * prior.log_uniform(0.02, 1.0)
        }]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
