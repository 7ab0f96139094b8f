//! Periodic error of the encoder.

use super::law::{infinite, not_positive};
use super::reading_error::error;
use super::sizing::{Absorbed, Drawn, Scale, Sizes, Unlike};
use super::{Constants, Door, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Error of the encoder that repeats along the axis: an eccentric disc, interpolation within a grating period.
///
/// # Model
/// `reading = x + s·sin(2πx/p) + c·cos(2πx/p)`.
///
/// # Validity
/// Small slopes. Where this is the only sensor and it sits at the load, it is exactly a lead error of the drive train.
///
/// # Source
/// Encoder data sheets: position error over one signal period or one turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EncoderPeriodicError {
    /// p in m, or rad for a revolute axis; more than zero.
    #[serde(alias = "period_rad")]
    pub period_m: f64,
    /// s in m, or rad.
    #[serde(alias = "sine_rad")]
    pub sine_m: f64,
    /// c in m, or rad.
    #[serde(alias = "cosine_rad")]
    pub cosine_m: f64,
}

impl Law for EncoderPeriodicError {
    const SITE: Site = Site::Sensor;
    const PHRASE: &'static str = "a periodic error of the encoder";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::length("period_m", "period_rad").positive(),
        Parameter::length("sine_m", "sine_rad"),
        Parameter::length("cosine_m", "cosine_rad"),
    ];
    const DOORS: &'static [Door] = &[Door::Reading];

    fn fault(&self) -> Option<String> {
        not_positive("period_m", self.period_m)
            .or_else(|| infinite("sine_m", self.sine_m))
            .or_else(|| infinite("cosine_m", self.cosine_m))
    }

    #[inline]
    fn read(&self, position: f64) -> f64 {
        position + error(self.period_m, self.sine_m, self.cosine_m, position)
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 0.0, 0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<&'static str> {
        None
    }

    const EQUATION: &'static str = "reading = x + s·sin(2πx/p) + c·cos(2πx/p)";
    const SYMBOLS: &'static [&'static str] = &["p", "s", "c"];
    const SOURCE: &'static str = "encoder data sheets: position error over one signal period or one turn";
    const SHOWN_BY: &'static str = "Ripple of velocity and force that repeats along the axis and grows with speed: constant speed at several feeds.";
    const EXAMPLE: &'static [f64] = &[0.004, 2e-6, 1e-6];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn sizes(scale: &Scale, _absorbed: &Absorbed, drawn: Drawn) -> Sizes {
        let travel = scale.stroke.abs();
        Sizes::new((1e-8, 1e-3), move |s| drawn.wave(s * travel)[..3].to_vec())
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
