//! What an engineer at the drive makes of a diagnosis: the following error, and which setting acts on each cause.

use super::number::value;
use super::words::listed;
use crate::diagnose::Verdict;
use crate::diagnose::verdict::Diagnosis;
use crate::effect::EffectId;
use crate::units::Motion;

/// The following error of the unseen runs, and what to change on the drive, in a sentence each; empty where neither can be said.
///
/// A comparison says what to repair instead.
pub(super) fn on_the_drive(diagnosis: &Diagnosis, motion: Motion) -> String {
    let mut sentences = Vec::new();
    if let Some(error) = diagnosis.following_error {
        let unit = if motion == Motion::Prismatic { "m" } else { "rad" };
        let [rms, peak] = [error.rms, error.peak].map(|error| value(error, unit));
        sentences.push(format!("Following error of the machine on these runs: {rms} RMS, {peak} at most."));
    }
    let is_found = diagnosis.verdict == Verdict::Cause || diagnosis.is_found_in_part();
    if is_found && diagnosis.reference.is_none() {
        let mut settings: Vec<String> = Vec::new();
        for effect in diagnosis.causes.iter().filter_map(|cause| EffectId::named(&cause.effect)) {
            let setting = setting(effect).to_owned();
            if !settings.contains(&setting) {
                settings.push(setting);
            }
        }
        if !settings.is_empty() {
            sentences.push(format!("On the drive: {}.", listed(&settings)));
        }
    }
    sentences.join(" ")
}

/// The setting of a drive or control that acts on an effect.
fn setting(effect: EffectId) -> &'static str {
    use EffectId as E;
    match effect {
        E::PositionGain => "set the position gain to the stated value",
        E::VelocityGain => "set the velocity gain to the stated value",
        E::IntegralGain => "set the integral time to the stated value",
        E::VelocityFeedforward => "set the velocity feed-forward to the stated value",
        E::VelocityFilter => "set the filter of the actual velocity to the stated time constant",
        E::LoopDelay => {
            "a shorter cycle or faster bus, else lower gains, since no setting takes a delay away"
        }
        E::VoltageSaturation => {
            "lower the acceleration or raise the supply, and let the integrator stop at the limit"
        }
        E::DeadZone => "dead-zone compensation of the amplifier",
        E::AmplifierOffset => "offset adjustment of the amplifier",
        E::CurrentLoop => "tune the current controller again",
        E::WindingResistance | E::WindingInductance => {
            "identify the motor again and tune the current controller"
        }
        E::BackEmf | E::ForceConstant => {
            "enter the motor constant again, since feed-forward and limits scale with it"
        }
        E::ForceSaturation => {
            "enter the saturation of the motor where the drive has a table for it, else a lower peak current"
        }
        E::ForceRipple | E::SecondForceRipple | E::Cogging | E::SecondCogging | E::ThirdCogging => {
            "cogging compensation, a force table over position with the pitch below"
        }
        E::ViscousFriction => "velocity feed-forward of the force, with the coefficient below",
        E::CoulombFriction | E::AsymmetricFriction | E::StribeckFriction => {
            "friction compensation, the force below fed forward with the sign of the commanded velocity"
        }
        E::Presliding => {
            "let the friction compensation rise over the breakaway distance and not jump at reversal"
        }
        E::LoadDependentFriction => "friction compensation in proportion to the load",
        E::LocalFriction => "nothing, but look at the guide at the place below",
        E::FrictionDrift => {
            "nothing fixed, but warm the axis up, or set the friction compensation anew when warm"
        }
        E::ConstantForce | E::CableSpring => "force offset (weight compensation), over position for a spring",
        E::ExternalVibration => "nothing, but find the source of the frequency below, or isolate the axis",
        E::Payload => {
            "enter the moving mass or inertia again, since acceleration feed-forward and gains scale with it"
        }
        E::BaseModeShift | E::FlexibleMode => {
            "notch filter at the frequency below, or a jerk limit of the reference"
        }
        E::Backlash => {
            "backlash compensation at reversal, or close the position loop on the load, if it is not closed there"
        }
        E::ScrewError => "lead-screw error compensation, a position table with the pitch below",
        E::SensorScale => "set the scaling of the logged signal",
        E::EncoderScale => "set the scale of the encoder",
        E::EncoderZero => {
            "look where the part hangs at rest: set the zero of the encoder there, or state the centre of mass"
        }
        E::EncoderPeriodicError => "adjust offset, gain and phase of the encoder's signals",
        E::EncoderResolution => "set the resolution of the encoder, or filter the velocity",
    }
}
