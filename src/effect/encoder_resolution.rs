//! Steps of the encoder coarser than stated.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::units::Motion;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Steps of linear encoders in m.
const STEPS_M: [f64; 9] = [10e-9, 50e-9, 100e-9, 200e-9, 500e-9, 1e-6, 2e-6, 5e-6, 10e-6];
/// Counts in a turn of rotary encoders.
const COUNTS: [f64; 13] = [
    1000.0,
    1024.0,
    2000.0,
    2048.0,
    4000.0,
    4096.0,
    8000.0,
    8192.0,
    10000.0,
    16384.0,
    65536.0,
    131_072.0,
    1_048_576.0,
];

/// Readings in coarser steps than stated: lost interpolation, a wrong divider, a log with few digits.
///
/// # Model
/// `reading = r·round(x/r)`, for the controller as for the log.
///
/// # Validity
/// The step is read off the recorded positions, which all lie on its grid; the fit decides only whether the loop ran on
/// it. A log that was rounded later leaves the loop alone. In a loop that differentiates the readings, a step crossed a
/// moment earlier makes another course of all that follows: what the twin's noise floor makes of that is noise.
///
/// # Prior
/// A step that encoders have, any alike of those at least twice the stated one: 10, 50, 100, 200 or 500 nm, 1, 2, 5 or 10 µm; on
/// a revolute axis 2π/n with n of 1000 to 10000 counts of usual line discs read fourfold, or of 2¹⁰ to 2²⁰. Where none is coarser
/// than stated, 2, 4, 5 or 10 times that. Catalogues of linear and rotary encoders and their interpolation electronics.
///
/// # Source
/// Quantisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EncoderResolution {
    /// r in m, or rad for a revolute axis; more than zero.
    #[serde(alias = "resolution_rad")]
    pub resolution_m: f64,
}

impl Law for EncoderResolution {
    const SITE: Site = Site::Sensor;
    const PHRASE: &'static str = "an encoder coarser than stated";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::length("resolution_m", "resolution_rad").held().positive()];
    const MAKES_NOISE: bool = true;

    fn fault(&self) -> Option<String> {
        not_positive("resolution_m", self.resolution_m)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.reading_step = self.resolution_m;
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.encoder_step]
    }

    const STRETCH: Stretch = Stretch::Rounding;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "reading = r·round(x/r)";
    const SYMBOLS: &'static [&'static str] = &["r"];
    const SOURCE: &'static str = "quantisation";
    const SHOWN_BY: &'static str =
        "Recorded positions on a coarser grid than stated, and a control effort that jumps with each step.";
    const EXAMPLE: &'static [f64] = &[5e-6];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = machine.constants.encoder_step;
        let steps: Vec<f64> = match machine.motion {
            Motion::Prismatic => STEPS_M.to_vec(),
            Motion::Revolute => COUNTS.iter().map(|counts| TAU / counts).collect(),
        };
        let coarser: Vec<f64> = steps.into_iter().filter(|step| *step >= 2.0 * stated).collect();
        vec![if coarser.is_empty() {
            stated * prior.one_of(&[2.0, 4.0, 5.0, 10.0])
        } else {
            prior.one_of(&coarser)
        }]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
