//! Periodic error of the encoder.

use super::law::{infinite, not_positive};
use super::prior::{Machinery, Prior};
use super::reading_error::error;
use super::unlike::Unlike;
use super::{Constants, Door, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::units::Motion;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Signal periods of optical scales in m.
const OPTICAL_M: [f64; 3] = [4e-6, 20e-6, 40e-6];
/// Signal periods of magnetic and inductive scales in m.
const MAGNETIC_M: [f64; 3] = [1e-3, 2e-3, 4e-3];
/// Lines in a turn of rotary encoders.
const LINES: [f64; 8] = [256.0, 512.0, 1000.0, 1024.0, 2000.0, 2048.0, 2500.0, 4096.0];

/// Error of the encoder that repeats along the axis: an eccentric disc, interpolation within a grating period.
///
/// # Model
/// `reading = x + s·sin(2πx/p) + c·cos(2πx/p)`.
///
/// # Validity
/// Small slopes. Where this is the only sensor and it sits at the load, it is exactly a lead error of the drive train.
///
/// # Prior
/// A prismatic axis: p is the signal period of an optical scale (4, 20 or 40 µm) or of a magnetic or inductive one (1, 2 or 4
/// mm), each kind with probability one half; amplitude of 10 to 500 nm, log-uniform, 2 % of p at most. A revolute axis: with
/// probability one half p = 2π/n with n of 256 to 4096 lines and an amplitude of 0.1 to 2 % of p, log-uniform; else once or twice
/// a turn, an eccentricity of 1 to 20 µm, log-uniform, at a disc's radius of 10 to 50 mm. Phase anywhere. HEIDENHAIN's brochures
/// *Exposed Linear Encoders*, *Linear Encoders for Numerically Controlled Machine Tools* and *Rotary Encoders*: ±1 to ±2 % of the
/// signal period.
///
/// # Source
/// Encoder data sheets: position error over one signal period or one turn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "reading = x + s·sin(2πx/p) + c·cos(2πx/p)";
    const SYMBOLS: &'static [&'static str] = &["p", "s", "c"];
    const SOURCE: &'static str = "encoder data sheets: position error over one signal period or one turn";
    const SHOWN_BY: &'static str = "Ripple of velocity and force that repeats along the axis and grows with speed: constant speed at several feeds.";
    const EXAMPLE: &'static [f64] = &[0.004, 2e-6, 1e-6];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let is_fine = prior.chance(0.5);
        let (pitch, amplitude) = match (machine.motion, is_fine) {
            (Motion::Prismatic, _) => {
                let pitch = prior.one_of(if is_fine { &OPTICAL_M } else { &MAGNETIC_M });
                (pitch, prior.log_uniform(10e-9, (0.02 * pitch).min(500e-9)))
            }
            (Motion::Revolute, true) => {
                let pitch = TAU / prior.one_of(&LINES);
                (pitch, pitch * prior.log_uniform(0.001, 0.02))
            }
            (Motion::Revolute, false) => {
                let eccentricity = prior.log_uniform(1e-6, 20e-6);
                (TAU / prior.integer(1, 2), prior.at_surface(eccentricity, machine))
            }
        };
        prior.periodic(pitch, amplitude)
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
