//! Voltage clipped below what is stated.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// A limit of the applied voltage below the stated one: a sagging supply, a limit set in the drive.
///
/// # Model
/// `u_applied = clip(u, ±U)`; the smaller of U and the stated limit holds.
///
/// # Validity
/// Symmetric and constant over a run. A limit that no run reaches leaves no trace.
///
/// # Prior
/// A sag of the supply: U is 60 to 95 % of the stated limit of the effort, uniform; where none is stated, 0.5 to 1.1 times the
/// largest voltage that ordinary motion takes, uniform. IEC 60034-1 expects supplies to vary by 10 %; IEC 61000-4-11 tests
/// equipment with dips to 80, 70 and 40 %.
///
/// # Source
/// Saturation of any real amplifier.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VoltageSaturation {
    /// U in V; more than zero.
    pub limit_v: f64,
}

impl Law for VoltageSaturation {
    const SITE: Site = Site::Amplifier;
    const PHRASE: &'static str = "voltage clipped below its stated limit";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("limit_v", "V").positive()];

    fn fault(&self) -> Option<String> {
        not_positive("limit_v", self.limit_v)
    }

    fn alter(&self, constants: &mut Constants) {
        let stated = constants.amplifier.voltage_limit_v.unwrap_or(f64::INFINITY);
        constants.amplifier.voltage_limit_v = Some(self.limit_v.min(stated));
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.amplifier.voltage_limit_v.unwrap_or(f64::INFINITY)]
    }

    const STRETCH: Stretch = Stretch::Drive;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "u_applied = clip(u, ±U)";
    const SYMBOLS: &'static [&'static str] = &["U"];
    const SOURCE: &'static str = "saturation of any real amplifier";
    const SHOWN_BY: &'static str =
        "Control effort beyond U that current or motor force do not follow, in runs fast enough to reach U.";
    const EXAMPLE: &'static [f64] = &[2.0];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let limit = match machine.constants.effort_limit_v() {
            Some(stated) => stated * (1.0 - prior.uniform(0.05, 0.40)),
            None => machine.voltage_v * prior.uniform(0.5, 1.1),
        };
        vec![limit]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
