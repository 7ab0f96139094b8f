//! Winding resistance off its stated value.

use super::law::not_positive;
use super::prior::{LINES_TO_PHASE, Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::drive::motor::Circuit;
use serde::{Deserialize, Serialize};

/// Relative change of copper's resistance per kelvin.
const COPPER_PER_K: f64 = 0.0039;

/// Winding resistance off its stated value.
///
/// # Model
/// `L·di/dt = u − R·i − Ke·v`, with R in the place of the stated resistance.
///
/// # Validity
/// Constant over a run. Copper gains 0.39 % per kelvin, so a warm winding is 20 to 40 % above its cold value.
///
/// # Prior
/// A winding at another temperature: R = R_stated·(1 + 0.0039/K·ΔT), ΔT of −10 to +100 K, uniform. IEC 60034-1: class F allows a
/// rise of 105 K; IEC 60228: copper. A diagnosis takes ln(R/R_stated) as normal, with ln 2 at two standard deviations: lines between and lines
/// to the star point are mistaken for each other. That width is an engineering estimate.
///
/// # Source
/// Temperature coefficient of copper, IEC 60228.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindingResistance {
    /// R in Ω, cables and amplifier included; more than zero.
    pub resistance_ohm: f64,
}

impl Law for WindingResistance {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "a winding resistance off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::same("resistance_ohm", "Ω").positive().usually_within(LINES_TO_PHASE)];

    fn fault(&self) -> Option<String> {
        not_positive("resistance_ohm", self.resistance_ohm)
    }

    fn alter(&self, constants: &mut Constants) {
        if let Circuit::Winding { resistance_ohm, .. } = &mut constants.circuit {
            *resistance_ohm = self.resistance_ohm;
        }
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.circuit {
            Circuit::Winding { resistance_ohm, .. } => vec![resistance_ohm],
            Circuit::Direct { .. } => vec![0.0],
        }
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!constants.has_voltage_fed_winding).then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "L·di/dt = u − R·i − Ke·v";
    const SYMBOLS: &'static [&'static str] = &["R"];
    const SOURCE: &'static str = "temperature coefficient of copper, IEC 60228";
    const SHOWN_BY: &'static str =
        "Control effort beside current, where the motor accelerates or holds a load.";
    const EXAMPLE: &'static [f64] = &[1.6];
    const CONFUSABLE: &'static [Likeness] = &[
        Likeness::similar(EffectId::BackEmf, "where no current is logged and drag takes most of the force"),
        Likeness::similar(EffectId::ForceConstant, "where no current is logged"),
    ];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = Self::neutral(&machine.constants).first().copied().unwrap_or(0.0);
        vec![stated * (1.0 + COPPER_PER_K * prior.uniform(-10.0, 100.0))]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = Some(Nominal::Resistance);
}
