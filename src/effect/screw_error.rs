//! Lead error of the drive train, periodic in position.

use super::law::{infinite, not_positive};
use super::prior::{Machinery, Prior};
use super::reading_error::error;
use super::unlike::Unlike;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::recording::Signal;
use crate::units::Motion;
use serde::{Deserialize, Serialize};

/// A minute of arc in rad.
const ARCMIN: f64 = std::f64::consts::TAU / 21600.0;
/// Nominal leads of ball screws in m, ISO 3408-2.
const LEADS_M: [f64; 14] =
    [0.002, 0.0025, 0.003, 0.004, 0.005, 0.006, 0.008, 0.010, 0.012, 0.016, 0.020, 0.025, 0.032, 0.040];

/// Periodic lead error: the load runs ahead of and behind the motor once a turn of the screw.
///
/// # Model
/// `x = q + e(q)`, `e(q) = s·sin(2πq/p) + c·cos(2πq/p)`, with q the motor's end of the drive train and x the load. Where there is
/// play each flank of the thread has its own error: `e_forward = min(1, 1 + f)·e`, `e_backward = min(1, 1 − f)·e`, forward that of
/// the flank which drives the load forward. f = 0: both alike; f = 1: forward only; f = −1: backward only. Without play both
/// flanks bear, and their mean counts.
///
/// # Validity
/// Kinematic: small slopes, no inertia of its own. With a single sensor at the load it is exactly a periodic error of
/// that sensor; a second sensor at the motor tells them apart.
///
/// # Prior
/// p is a nominal lead of 2 to 40 mm, any alike; on a revolute axis a turn of the motor divided by 1 to 100 teeth or cams,
/// log-uniform; with probability one half a pitch that the machine file states. Amplitude of 0.5 to 20 µm, log-uniform, or 0.1 to
/// 3 arcmin (0.029 to 0.87 mrad); 1 % of p at most. Phase anywhere; f = 0. ISO 3408-2 for the leads; ISO 3408-3 for the travel
/// variation within one revolution, ground and rolled; catalogues of planetary and strain-wave gearboxes for their transmission
/// errors.
///
/// # Source
/// ISO 3408-3, travel variation within one revolution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScrewError {
    /// p in m, or rad for a revolute axis; more than zero.
    #[serde(alias = "period_rad")]
    pub period_m: f64,
    /// s in m, or rad.
    #[serde(alias = "sine_rad")]
    pub sine_m: f64,
    /// c in m, or rad.
    #[serde(alias = "cosine_rad")]
    pub cosine_m: f64,
    /// f, from −1 to 1.
    #[serde(default)]
    pub flank: f64,
}

impl Law for ScrewError {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a lead error that repeats along the axis";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::length("period_m", "period_rad").positive(),
        Parameter::length("sine_m", "sine_rad"),
        Parameter::length("cosine_m", "cosine_rad"),
        Parameter::same("flank", "1").held().within(-1.0, 1.0),
    ];
    const DOORS: &'static [Door] = &[Door::Transmission];

    fn fault(&self) -> Option<String> {
        not_positive("period_m", self.period_m)
            .or_else(|| infinite("sine_m", self.sine_m))
            .or_else(|| infinite("cosine_m", self.cosine_m))
            .or_else(|| {
                (self.flank.abs() > 1.0 || self.flank.is_nan())
                    .then(|| format!("flank = {}, expected from -1 to 1", self.flank))
            })
    }

    #[inline]
    fn stops(&self, stops: [f64; 2]) -> [f64; 2] {
        let [rear, front] = stops.map(|q| error(self.period_m, self.sine_m, self.cosine_m, q));
        let [forward, backward] = [(1.0 + self.flank).min(1.0), (1.0 - self.flank).min(1.0)];
        [stops[0] + forward * rear, stops[1] + backward * front]
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 0.0, 0.0, 0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!constants.sees_load).then_some(Lack::LoadUnseen)
    }

    const EQUATION: &'static str = "x = q + e(q), e(q) = s·sin(2πq/p) + c·cos(2πq/p)\ne_forward = min(1, 1 + f)·e, e_backward = min(1, 1 − f)·e";
    const SYMBOLS: &'static [&'static str] = &["p", "s", "c", "f"];
    const SOURCE: &'static str = "ISO 3408-3, travel variation within one revolution";
    const SHOWN_BY: &'static str = "Load position beside motor position over several turns of the screw; play and both directions tell the flanks apart.";
    const EXAMPLE: &'static [f64] = &[0.01, 5e-6, 2e-6, 0.0];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::equal(
        EffectId::EncoderPeriodicError,
        "where one sensor sees the load and no other the motor",
        |constants, logged| !logged.contains(&Signal::LoadPosition) && !constants.sees_both_ends,
    )];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let stated = prior.stated_pitch(machine);
        let (pitch, amplitude) = match machine.motion {
            Motion::Prismatic => (prior.one_of(&LEADS_M), prior.log_uniform(0.5e-6, 20e-6)),
            Motion::Revolute => {
                (machine.turn() / prior.count(1.0, 100.0), prior.log_uniform(0.1, 3.0) * ARCMIN)
            }
        };
        let (pitch, both_flanks) = (stated.unwrap_or(pitch), 0.0);
        [prior.periodic(pitch, amplitude.min(0.01 * pitch)), vec![both_flanks]].concat()
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
