//! Winding inductance off its stated value.

use super::law::not_positive;
use super::prior::{LINES_TO_PHASE, Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::drive::motor::Circuit;
use serde::{Deserialize, Serialize};

/// Winding inductance off its stated value.
///
/// # Model
/// `L·di/dt = u − R·i − Ke·v`, with L in the place of the stated inductance.
///
/// # Validity
/// Constant over a run: no dependence on current or position.
///
/// # Prior
/// L of 0.7 to 1.3 times the stated one, uniform: data sheets give inductances to 20 to 30 %, iron saturates, and lines between
/// or to the star point are mistaken. Data sheets of servo motors; Boldea (2013), *Linear Electric Machines, Drives, and MAGLEVs
/// Handbook*, on saturation. A diagnosis takes ln(L/L_stated) as normal, with ln 2 at two standard deviations, an
/// engineering estimate.
///
/// # Source
/// Any text on electrical drives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WindingInductance {
    /// L in H; more than zero.
    pub inductance_h: f64,
}

impl Law for WindingInductance {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "a winding inductance off its stated value";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::same("inductance_h", "H").positive().usually_within(LINES_TO_PHASE)];

    fn fault(&self) -> Option<String> {
        not_positive("inductance_h", self.inductance_h)
    }

    fn alter(&self, constants: &mut Constants) {
        if let Circuit::Winding { inductance_h, .. } = &mut constants.circuit {
            *inductance_h = self.inductance_h;
        }
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.circuit {
            Circuit::Winding { inductance_h, .. } => vec![inductance_h],
            Circuit::Direct { .. } => vec![0.0],
        }
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!constants.has_voltage_fed_winding).then_some(Lack::NothingToChange)
    }

    const EQUATION: &'static str = "L·di/dt = u − R·i − Ke·v";
    const SYMBOLS: &'static [&'static str] = &["L"];
    const SOURCE: &'static str = "any text on electrical drives";
    const SHOWN_BY: &'static str =
        "Current behind quick changes of the control effort. Slow smooth strokes do not show it.";
    const EXAMPLE: &'static [f64] = &[0.011];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = Self::neutral(&machine.constants).first().copied().unwrap_or(0.0);
        vec![stated * prior.uniform(0.7, 1.3)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = Some(Nominal::Inductance);
}
