//! Zero of the encoder off against the direction of gravity.

use super::law::outside;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// An encoder whose zero is not where the solid model has the joint's zero: a coupling, lever or horn fitted by eye, or a tooth off.
///
/// # Model
/// `reading = x + x₀`, x the joint's angle as the URDF counts it.
///
/// # Validity
/// Of a revolute axis whose weight depends on its angle: nothing else tells where zero is. Near the angle at which the part hangs, it
/// is a constant torque of m·g·l·x₀ to first order; runs of large angles tell them apart. A centre of mass beside the line that the solid model states turns the
/// weight by the same angle, and so do a payload there and the spring of a counterweight: no log tells which.
///
/// # Prior
/// With probability one half fitted by eye: |x₀| of 0.01 to 0.1 rad, log-uniform. Else a tooth off on a spline of 15 to 36 teeth:
/// |x₀| = 2π/n, n uniform. Either sign. Splines in catalogues of hobby and industrial servos; the rest is an engineering estimate.
///
/// # Source
/// Definition of the joint's zero (URDF); Duclusaud et al., *Extended friction models for the physics simulation of servo
/// actuators*, ICRA 2025, identify such an offset with every friction model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EncoderZero {
    /// x₀ in rad, from −π to π; 0: as stated.
    pub zero_rad: f64,
}

impl Law for EncoderZero {
    const SITE: Site = Site::Sensor;
    const PHRASE: &'static str = "an encoder zero, or a centre of mass, off against gravity";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("zero_rad", "rad").within(-PI, PI)];
    const DOORS: &'static [Door] = &[Door::Reading];

    fn fault(&self) -> Option<String> {
        outside("zero_rad", self.zero_rad, -PI..=PI)
    }

    #[inline]
    fn read(&self, position: f64) -> f64 {
        position + self.zero_rad
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!constants.has_turning_weight).then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "reading = x + x₀";
    const SYMBOLS: &'static [&'static str] = &["x₀"];
    const SOURCE: &'static str = "definition of the joint's zero (URDF); Duclusaud et al., ICRA 2025";
    const SHOWN_BY: &'static str =
        "Angles at which the part hangs at rest, and efforts that hold it at equal angles on both sides.";
    const EXAMPLE: &'static [f64] = &[0.05];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::similar(EffectId::ConstantForce, "near the angle at which the part hangs"),
        Likeness::similar(EffectId::Cogging, "of a pitch of one turn of the joint"),
    ];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let by_eye = prior.chance(0.5);
        let off = if by_eye { prior.log_uniform(0.01, 0.1) } else { TAU / prior.integer(15, 36) };
        vec![prior.sign() * off]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = Some(Nominal::EncoderZero);
}
