//! Force ripple: a force constant that depends on position.

use super::harmonics::HIGHER;
use super::law::{FormNumber, infinite, is_zero, not_positive, outside};
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::wave::Wave;
use super::{Constants, Door, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// Force ripple: the motor's force constant varies along its magnets.
///
/// # Model
/// `F = Kt·i·(1 + s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ + A·(s₃·sin 3φ + c₃·cos 3φ + s₄·sin 4φ + c₄·cos 4φ))` with
/// `φ = 2π·x/p`, `A = √(s₁² + c₁²)` and x the axis coordinate. The third and the fourth harmonic are numbers of form, as of
/// [`Cogging`](super::Cogging). A further pitch has none of them: `F = Kt·i·(1 + s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ)`.
///
/// # Validity
/// Four harmonics of one pitch, in proportion to current: what remains without current is cogging. Back-EMF keeps its
/// mean constant.
///
/// # Prior
/// First harmonic of 1 to 15 % of the motor's force, log-uniform; second one 0 to 40 % of it; both phases anywhere. p is 10 to 60
/// mm, uniform; on a revolute axis 2π/n with 2 to 84 poles, slots or their least common multiple in a turn of the motor,
/// log-uniform; with probability one half a pitch that the machine file states. Boldea (2013), *Linear Electric Machines, Drives,
/// and MAGLEVs Handbook*; catalogues of linear and torque motors.
///
/// # Source
/// Gieras, Piech, Tomczuk (2011), *Linear Synchronous Motors*, section 3.8.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceRipple {
    /// p in m, or rad for a revolute axis; more than zero.
    #[serde(alias = "period_rad")]
    pub period_m: f64,
    /// s₁.
    pub sine: f64,
    /// c₁.
    pub cosine: f64,
    /// s₂.
    #[serde(default)]
    pub sine_2: f64,
    /// c₂.
    #[serde(default)]
    pub cosine_2: f64,
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

impl ForceRipple {
    /// The first harmonic alone: pitch in m or rad, sine and cosine as shares of the motor's force.
    pub fn single(period_m: f64, sine: f64, cosine: f64) -> Self {
        Self {
            period_m,
            sine,
            cosine,
            sine_2: 0.0,
            cosine_2: 0.0,
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

    /// Draws ripple of a pitch.
    pub(super) fn of_pitch(pitch: f64, _machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let amplitude = prior.log_uniform(0.01, 0.15);
        prior.wave(pitch, amplitude)
    }
}

impl Law for ForceRipple {
    const SITE: Site = Site::Motor;
    const PHRASE: &'static str = "force ripple of the motor";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::length("period_m", "period_rad").positive(),
        Parameter::same("sine", "1"),
        Parameter::same("cosine", "1"),
        Parameter::same("sine_2", "1"),
        Parameter::same("cosine_2", "1"),
    ];
    const FORM: &'static [FormNumber] = HIGHER;
    const DOORS: &'static [Door] = &[Door::MotorForce];

    fn fault(&self) -> Option<String> {
        not_positive("period_m", self.period_m)
            .or_else(|| infinite("sine", self.sine))
            .or_else(|| infinite("cosine", self.cosine))
            .or_else(|| infinite("sine_2", self.sine_2))
            .or_else(|| infinite("cosine_2", self.cosine_2))
            .or_else(|| outside("sine_3", self.sine_3, -1.0..=1.0))
            .or_else(|| outside("cosine_3", self.cosine_3, -1.0..=1.0))
            .or_else(|| outside("sine_4", self.sine_4, -1.0..=1.0))
            .or_else(|| outside("cosine_4", self.cosine_4, -1.0..=1.0))
    }

    #[inline]
    fn motor_change(&self, position: f64, _force: f64) -> f64 {
        let own = [self.sine, self.cosine, self.sine_2, self.cosine_2];
        Wave { period: self.period_m, own, higher: self.higher() }.at(position)
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 0.0, 0.0, 0.0, 0.0]
    }

    const STRETCH: Stretch = Stretch::MotorForce;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F = Kt·i·(1 + s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ + A·(s₃·sin 3φ + c₃·cos 3φ + s₄·sin 4φ + c₄·cos 4φ)) with φ = 2π·x/p, A = √(s₁² + c₁²)";
    const SYMBOLS: &'static [&'static str] = &["p", "s₁", "c₁", "s₂", "c₂", "s₃", "c₃", "s₄", "c₄"];
    const SOURCE: &'static str = "Gieras, Piech, Tomczuk (2011), Linear Synchronous Motors, section 3.8";
    const SHOWN_BY: &'static str =
        "Force in proportion to the motor's that repeats along the axis: accelerations over several pitches.";
    const EXAMPLE: &'static [f64] = &[0.012, 0.03, 0.01, 0.0, 0.0];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::Cogging, "where the motor's force hardly changes")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let pitch = prior.stated_pitch(machine).unwrap_or_else(|| prior.motor_pitch(machine));
        Self::of_pitch(pitch, machine, prior)
    }

    fn unlike(&self) -> Unlike {
        Unlike::RippleHarmonics { period: self.period_m, first: self.sine.hypot(self.cosine) }
    }

    const NOMINAL: Option<Nominal> = None;
}
