//! Cogging: a force that depends on position alone.

use super::harmonics::HIGHER;
use super::law::{FormNumber, infinite, is_zero, not_positive, outside};
use super::prior::{A_TURN, Machinery, PITCHES_M, Prior};
use super::unlike::Unlike;
use super::wave::Wave;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::units::Motion;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Cogging (detent force): magnets and teeth attract each other, current or not.
///
/// # Model
/// `F = s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ + A·(s₃·sin 3φ + c₃·cos 3φ + s₄·sin 4φ + c₄·cos 4φ)` with `φ = 2π·x/p`,
/// `A = √(s₁² + c₁²)` and x the axis coordinate. Positive force acts along positive position. The third and the fourth harmonic are numbers of form:
/// every motor has a few per cent of them, which are calibrated and never named.
///
/// # Validity
/// Four harmonics of one pitch; no dependence on current or speed. The pitch is found from the data where several
/// periods are travelled.
///
/// # Prior
/// First harmonic of 0.5 to 10 % of the rated force, log-uniform; second one 0 to 40 % of it; both phases anywhere. p is 10 to 60
/// mm, uniform; on a revolute axis 2π/n with 2 to 84 poles, slots or their least common multiple in a turn of the motor,
/// log-uniform; with probability one half a pitch that the machine file states. Boldea (2013), *Linear Electric Machines, Drives,
/// and MAGLEVs Handbook*; Zhu, Howe (2000), *Influence of design parameters on cogging torque in permanent magnet machines*;
/// catalogues of linear and torque motors.
///
/// # Source
/// Gieras, Piech, Tomczuk (2011), *Linear Synchronous Motors*, section 3.8.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cogging {
    /// p in m, or rad for a revolute axis; more than zero.
    #[serde(alias = "period_rad")]
    pub period_m: f64,
    /// s₁ in N, or N·m.
    #[serde(alias = "sine_nm")]
    pub sine_n: f64,
    /// c₁ in N, or N·m.
    #[serde(alias = "cosine_nm")]
    pub cosine_n: f64,
    /// s₂ in N, or N·m.
    #[serde(default, alias = "sine_2_nm")]
    pub sine_2_n: f64,
    /// c₂ in N, or N·m.
    #[serde(default, alias = "cosine_2_nm")]
    pub cosine_2_n: f64,
    /// s₃ as a share of A.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sine_3: f64,
    /// c₃ as a share of A.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub cosine_3: f64,
    /// s₄ as a share of A.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub sine_4: f64,
    /// c₄ as a share of A.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub cosine_4: f64,
}

impl Cogging {
    /// The first harmonic alone: pitch in m or rad, sine and cosine in N or N·m.
    pub fn single(period_m: f64, sine_n: f64, cosine_n: f64) -> Self {
        Self {
            period_m,
            sine_n,
            cosine_n,
            sine_2_n: 0.0,
            cosine_2_n: 0.0,
            sine_3: 0.0,
            cosine_3: 0.0,
            sine_4: 0.0,
            cosine_4: 0.0,
        }
    }

    /// The third and the fourth harmonic.
    fn higher(&self) -> [f64; 4] {
        [self.sine_3, self.cosine_3, self.sine_4, self.cosine_4]
    }

    /// The longest pitch of a motor with these constants, in m or rad: the longest that the machine's file states, else 60 mm, or half a turn.
    pub fn longest_pitch(constants: &Constants, motion: Motion) -> f64 {
        let usual = match motion {
            Motion::Prismatic => PITCHES_M.1,
            Motion::Revolute => TAU / A_TURN.0,
        };
        constants.stated_pitches.iter().copied().reduce(f64::max).unwrap_or(usual)
    }

    /// Draws cogging of a pitch.
    pub(super) fn of_pitch(pitch: f64, machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let amplitude = prior.log_uniform(0.005, 0.10) * machine.rated_force;
        prior.wave(pitch, amplitude)
    }
}

impl Law for Cogging {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "cogging of the motor";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::length("period_m", "period_rad").positive(),
        Parameter::effort("sine_n", "sine_nm"),
        Parameter::effort("cosine_n", "cosine_nm"),
        Parameter::effort("sine_2_n", "sine_2_nm"),
        Parameter::effort("cosine_2_n", "cosine_2_nm"),
    ];
    const FORM: &'static [FormNumber] = HIGHER;
    const DOORS: &'static [Door] = &[Door::Push];

    fn fault(&self) -> Option<String> {
        not_positive("period_m", self.period_m)
            .or_else(|| infinite("sine_n", self.sine_n))
            .or_else(|| infinite("cosine_n", self.cosine_n))
            .or_else(|| infinite("sine_2_n", self.sine_2_n))
            .or_else(|| infinite("cosine_2_n", self.cosine_2_n))
            .or_else(|| outside("sine_3", self.sine_3, -1.0..=1.0))
            .or_else(|| outside("cosine_3", self.cosine_3, -1.0..=1.0))
            .or_else(|| outside("sine_4", self.sine_4, -1.0..=1.0))
            .or_else(|| outside("cosine_4", self.cosine_4, -1.0..=1.0))
    }

    #[inline]
    fn push_wave(&self) -> Option<Wave> {
        let own = [self.sine_n, self.cosine_n, self.sine_2_n, self.cosine_2_n];
        Some(Wave { period: self.period_m, own, higher: self.higher() })
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 0.0, 0.0, 0.0, 0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F = s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ + A·(s₃·sin 3φ + c₃·cos 3φ + s₄·sin 4φ + c₄·cos 4φ) with φ = 2π·x/p, A = √(s₁² + c₁²)";
    const SYMBOLS: &'static [&'static str] = &["p", "s₁", "c₁", "s₂", "c₂", "s₃", "c₃", "s₄", "c₄"];
    const SOURCE: &'static str = "Gieras, Piech, Tomczuk (2011), Linear Synchronous Motors, section 3.8";
    const SHOWN_BY: &'static str = "Force that repeats along the axis whatever the motor does: slow constant speed over several pitches.";
    const EXAMPLE: &'static [f64] = &[0.012, 8.0, 3.0, 2.0, 0.0];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::CableSpring, "where less than a pitch is travelled")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let pitch = prior.stated_pitch(machine).unwrap_or_else(|| prior.motor_pitch(machine));
        Self::of_pitch(pitch, machine, prior)
    }

    fn unlike(&self) -> Unlike {
        Unlike::ForceHarmonics { period: self.period_m, first: self.sine_n.hypot(self.cosine_n) }
    }

    const NOMINAL: Option<Nominal> = None;
}
