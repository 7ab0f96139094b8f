//! Small voltages that do not reach the motor.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Dead zone of the amplifier: commands below a threshold have no effect, larger ones lack it.
///
/// # Model
/// ```text
///   |u| ≤ w:  u_applied = 0
///   |u| > w:  u_applied = u − w·sgn(u)
/// ```
/// w comes on top of a stated half width.
///
/// # Validity
/// Symmetric; PWM interlock time of a bridge behaves so at small currents.
///
/// # Prior
/// w of 0.2 to 5 % of the effort's full scale, log-uniform: an interlock time of 0.5 to 4 µs at a switching frequency of 4 to 16
/// kHz takes that share of the bus voltage. Data sheets of IGBT and MOSFET drivers; Choi, Sul (1996), *Inverter output voltage
/// synthesis using novel dead time compensation*.
///
/// # Source
/// Slotine, Li (1991), *Applied Nonlinear Control*, section 5.2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeadZone {
    /// w in V; not negative.
    pub half_width_v: f64,
}

impl Law for DeadZone {
    const SITE: Site = Site::Amplifier;
    const PHRASE: &'static str = "a dead zone of the amplifier";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("half_width_v", "V").not_negative()];

    fn fault(&self) -> Option<String> {
        negative("half_width_v", self.half_width_v)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.amplifier.dead_zone_v += self.half_width_v;
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "|u| ≤ w:  u_applied = 0\n|u| > w:  u_applied = u − w·sgn(u)";
    const SYMBOLS: &'static [&'static str] = &["w"];
    const SOURCE: &'static str = "Slotine, Li (1991), Applied Nonlinear Control, section 5.2";
    const SHOWN_BY: &'static str =
        "Control effort that passes zero without current or motor force: dwells, reversals, slow motion.";
    const EXAMPLE: &'static [f64] = &[0.05];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::CoulombFriction, "where neither current nor force is logged")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.log_uniform(0.002, 0.05) * machine.voltage_v]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
