//! Vibration from outside: a force in time.

use super::law::{infinite, not_positive};
use super::prior::{Machinery, Prior};
use super::{Constants, Door, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch, Unlike};
use crate::elementary::sin_cos_turns;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Vibration that comes from outside: a press beside the machine, a pump or a fan on it, the floor.
///
/// # Model
/// ```text
///   F = A·sin(2π·f·t + φ)
/// ```
/// on the moving part, along the axis' positive direction; t is the time of the session. A floor that shakes the base by b(t)
/// acts on the moving part as −m·b̈(t). φ is not known of a recorded run, whose clock has nothing to do with the source: a
/// diagnosis takes the one that suits the run best, unless the run states it
/// (`set = { "effect.external_vibration.phase_rad" = 0.3 }`).
///
/// # Validity
/// One steady frequency below half the sample rate, the same in all runs, at standstill too.
///
/// # Prior
/// f of 5 to 60 Hz, log-uniform, below 0.4 times the sample rate: fans, pumps, presses and the floor. A of 0.05 to 2 % of the
/// rated force, log-uniform. Rivin (2003), *Passive Vibration Isolation*; data sheets of fans and pumps for the speeds. The
/// force's bounds are an engineering estimate.
///
/// # Source
/// Rivin (2003), *Passive Vibration Isolation*.
///
/// ```
/// use slideway::effect::{ExternalVibration, Law};
/// let pump = ExternalVibration { frequency_hz: 25.0, force_n: 3.0, phase_rad: 0.0 };
/// assert!(pump.shake(0.0).abs() < 1e-12 && (pump.shake(0.01) - 3.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExternalVibration {
    /// f in Hz; more than zero.
    pub frequency_hz: f64,
    /// A in N, or N·m for a revolute axis.
    #[serde(alias = "torque_nm")]
    pub force_n: f64,
    /// φ in rad.
    #[serde(default)]
    pub phase_rad: f64,
}

impl Law for ExternalVibration {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "vibration from outside";
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::same("frequency_hz", "Hz").positive(), Parameter::effort("force_n", "torque_nm")];
    const DOORS: &'static [Door] = &[Door::Shake];

    fn fault(&self) -> Option<String> {
        not_positive("frequency_hz", self.frequency_hz)
            .or_else(|| infinite("force_n", self.force_n))
            .or_else(|| infinite("phase_rad", self.phase_rad))
    }

    #[inline]
    fn shake(&self, time_s: f64) -> f64 {
        self.force_n * sin_cos_turns(self.frequency_hz * time_s + self.phase_rad / TAU)[0]
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F = A·sin(2π·f·t + φ)";
    const SYMBOLS: &'static [&'static str] = &["f", "A"];
    const SOURCE: &'static str = "Rivin (2003), Passive Vibration Isolation";
    const SHOWN_BY: &'static str = "A line in the spectrum, at standstill as well as in motion, whatever the axis does: record a second of standstill.";
    const EXAMPLE: &'static [f64] = &[25.0, 3.0];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let most = (0.4 / machine.constants.sample_period_s).min(60.0);
        let frequency = prior.log_uniform((0.5 * most).min(5.0), most);
        vec![frequency, prior.log_uniform(0.0005, 0.02) * machine.rated_force]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
