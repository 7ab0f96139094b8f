//! Scale of the encoder off its stated value.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::recording::Signal;
use serde::{Deserialize, Serialize};

/// An encoder whose unit is not the stated one: a wrong count per turn, lead or ratio, a warm scale.
///
/// # Model
/// `reading = f·x`.
///
/// # Validity
/// On position, velocity, effort and current it is exactly a force constant off by the same factor f: only a force
/// signal or a second sensor tells them apart.
///
/// # Prior
/// With probability one half a scale that is warm or cold: |f − 1| of 1e-5 to 1e-3, log-uniform; steel gains 11e-6/K, so that is
/// 1 to 90 K. Else a wrong lead, ratio or number of lines: |f − 1| of 1 to 20 %, log-uniform. Either sign. Thermal expansion in
/// catalogues of linear encoders; the wrong numbers are an engineering estimate.
///
/// # Source
/// Unit conversion; thermal expansion of steel scales, 10.5 µm/(m·K).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EncoderScale {
    /// f, more than zero; 1: as stated.
    pub factor: f64,
}

impl Law for EncoderScale {
    const SITE: Site = Site::Sensor;
    const PHRASE: &'static str = "an encoder scale off its stated value";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("factor", "1").positive()];
    const DOORS: &'static [Door] = &[Door::Reading];

    fn fault(&self) -> Option<String> {
        not_positive("factor", self.factor)
    }

    #[inline]
    fn read(&self, position: f64) -> f64 {
        self.factor * position
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![1.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "reading = f·x";
    const SYMBOLS: &'static [&'static str] = &["f"];
    const SOURCE: &'static str = "unit conversion; thermal expansion of steel scales, 10.5 µm/(m·K)";
    const SHOWN_BY: &'static str = "A second position beside the encoder's. Without one: motor force beside acceleration, where a force is logged.";
    const EXAMPLE: &'static [f64] = &[1.08];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::stand_in(
        EffectId::Payload,
        "where neither a force nor a second position is logged, with drag calibrated by the same factor",
        |_, logged| !logged.contains(&Signal::Thrust) && !logged.contains(&Signal::LoadPosition),
    )];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let is_thermal = prior.chance(0.5);
        let off = if is_thermal { prior.log_uniform(1e-5, 1e-3) } else { prior.log_uniform(0.01, 0.20) };
        vec![1.0 + prior.sign() * off]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
