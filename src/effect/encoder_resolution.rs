//! Steps of the encoder coarser than stated.

use super::law::not_positive;
use super::sizing::{Absorbed, Drawn, Scale, Sizes, Unlike};
use super::{Constants, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

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
/// # Source
/// Quantisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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

    fn lacks(_constants: &Constants) -> Option<&'static str> {
        None
    }

    const EQUATION: &'static str = "reading = r·round(x/r)";
    const SYMBOLS: &'static [&'static str] = &["r"];
    const SOURCE: &'static str = "quantisation";
    const SHOWN_BY: &'static str =
        "Recorded positions on a coarser grid than stated, and a control effort that jumps with each step.";
    const EXAMPLE: &'static [f64] = &[5e-6];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn sizes(scale: &Scale, _absorbed: &Absorbed, _drawn: Drawn) -> Sizes {
        let (step, travel) = (scale.constants.encoder_step, scale.stroke.abs());
        let step = if step > 0.0 { step } else { 1e-6 * travel };
        Sizes::one((3.0, 1e3), move |s| s * step)
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
