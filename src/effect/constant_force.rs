//! A constant force along the axis.

use super::law::infinite;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::recording::Signal;
use serde::{Deserialize, Serialize};

/// A constant force on the moving part: weight on a tilted guide, a hanging cable, a drive offset.
///
/// # Model
/// `F = −F_0` on the moving part: F_0 is the load that the motor has to hold, positive when it must push along
/// positive position. That is the sign of the inverse dynamic model `F_motor = m·a + c·v + F_c·sgn(v) + F_0`.
///
/// # Validity
/// At standstill on a guide with friction it acts only as far as friction does not hold it.
///
/// # Prior
/// F_0 of 0.1 to 10 % of the rated force, log-uniform, either sign: a guide a millimetre per metre out of level, a hanging cable,
/// a counterbalance that is filled too high or too low. Sizing guides for vertical axes in catalogues of servo motors and linear
/// guides.
///
/// # Source
/// Janot, Gautier, Brunot (2019), eq. 2, term `offset`, same sign.
///
/// ```
/// use slideway::effect::{ConstantForce, Law};
/// let law = ConstantForce { force_n: -3.0 };
/// assert_eq!(law.push(0.1, 0.2), law.push(0.0, -0.2));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConstantForce {
    /// F_0 in N (load convention), or N·m for a revolute axis.
    #[serde(alias = "torque_nm")]
    pub force_n: f64,
}

impl Law for ConstantForce {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "a constant force";
    const PARAMETERS: &'static [Parameter] = &[Parameter::effort("force_n", "torque_nm")];
    const DOORS: &'static [Door] = &[Door::Push];

    fn fault(&self) -> Option<String> {
        infinite("force_n", self.force_n)
    }

    fn push(&self, _position: f64, _velocity: f64) -> f64 {
        -self.force_n
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F = −F_0";
    const SYMBOLS: &'static [&'static str] = &["F_0"];
    const SOURCE: &'static str = "Janot, Gautier, Brunot (2019), eq. 2, term offset";
    const SHOWN_BY: &'static str =
        "Motor force that stays the same in both directions: strokes both ways, slow motion.";
    const EXAMPLE: &'static [f64] = &[-12.0];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::equal(
            EffectId::AmplifierOffset,
            "where neither current nor force is logged",
            |_, logged| !logged.contains(&Signal::Thrust) && !logged.contains(&Signal::Current),
        ),
        Likeness::similar(
            EffectId::CableSpring,
            "where the travel is short against the distance from the spring's point",
        ),
    ];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.sign() * prior.log_uniform(0.001, 0.10) * machine.rated_force]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
