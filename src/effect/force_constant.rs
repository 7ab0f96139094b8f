//! The motor's force constant off its stated value.

use super::law::not_positive;
use super::prior::{LINE_VOLTAGE_TO_PHASE, Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::drive::motor::Circuit;
use crate::recording::Signal;
use serde::{Deserialize, Serialize};

/// Force or torque constant of the motor off its stated value: warm magnets, saturation, a wrong data sheet.
///
/// # Model
/// `Kt = f·Kt_stated`; for a direct motor, force per volt alike. Back-EMF keeps its own stated constant.
///
/// # Validity
/// Constant over a run. Without a force sensor, a factor f cannot be told from mass, friction and every other
/// force being 1/f times theirs, nor from an encoder whose scale is off by f: position, velocity, effort and current
/// are the same.
///
/// # Prior
/// f of 0.80 to 1.05, uniform: catalogues state the constant to ±10 %, of cold magnets; those of NdFeB lose 0.1 % of their flux
/// per kelvin, and iron saturates at peak force. Data sheets of motors and magnets; IEC 60034-1 for the temperatures. A diagnosis takes ln(f)
/// as normal, with ln √3 at two standard deviations: constants are stated by phase or line (√3), and by RMS or peak current (√2). That width is
/// an engineering estimate.
///
/// # Source
/// Magnets lose about 0.1 to 0.2 % of their flux per kelvin; any motor data sheet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceConstant {
    /// f, more than zero; 1: as stated.
    pub factor: f64,
}

impl Law for ForceConstant {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "a force or torque constant off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::same("factor", "1").positive().usually_within(LINE_VOLTAGE_TO_PHASE)];

    fn fault(&self) -> Option<String> {
        not_positive("factor", self.factor)
    }

    fn alter(&self, constants: &mut Constants) {
        match &mut constants.circuit {
            Circuit::Winding { force_constant, .. } => *force_constant *= self.factor,
            Circuit::Direct { force_per_volt } => *force_per_volt *= self.factor,
        }
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![1.0]
    }

    const STRETCH: Stretch = Stretch::MotorForce;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "Kt = f·Kt_stated";
    const SYMBOLS: &'static [&'static str] = &["f"];
    const SOURCE: &'static str = "any motor data sheet; magnets lose 0.1 to 0.2 % of their flux per kelvin";
    const SHOWN_BY: &'static str = "Motor force beside current. Without a force signal: accelerations, as far as mass and drag are known.";
    const EXAMPLE: &'static [f64] = &[0.9];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::equal(
            EffectId::EncoderScale,
            "where neither a force nor a second position is logged",
            |_, logged| !logged.contains(&Signal::Thrust) && !logged.contains(&Signal::LoadPosition),
        ),
        Likeness::stand_in(
            EffectId::Payload,
            "where no force is logged, with drag calibrated by the same factor",
            |_, logged| !logged.contains(&Signal::Thrust),
        ),
    ];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.uniform(0.80, 1.05)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = Some(Nominal::ForceConstant);
}
