//! What a short travel cannot tell apart: a spring, and a wave longer than the travel.

use super::cause::Cause;
use super::estimate::screening::BEYOND_TRAVEL;
use super::experiment::Experiment;
use super::untested;
use crate::effect::{Cogging, EffectId};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::units::engineering;

/// Names cogging beside a spring where the runs travel less than two thirds of the longest pitch that the motor may have.
///
/// # Model
/// Over a part of a pitch p, the first and the second wave of a cogging make any straight line:
/// `s₁·sin φ + s₂·sin 2φ = (s₁ + 2·s₂)·φ − (s₁ + 8·s₂)·φ³/6 + …`, φ = 2πx/p, has no cubic term with s₁ = −8·s₂. A fit of
/// the spring, which has fewer numbers, is then as good and may be preferred.
///
/// # Validity
/// Where the catalogue has cogging and none is named.
pub fn qualify(causes: &mut [Cause], machine: &Machine, runs: &[&Experiment], catalogue: &[EffectId]) {
    let constants = machine.constants();
    let may_be = catalogue.contains(&EffectId::Cogging) && EffectId::Cogging.applies(&constants);
    let name = EffectId::Cogging.name();
    let travel = untested::travel(runs);
    let longest = Cogging::longest_pitch(&constants, machine.motion());
    if !may_be || causes.iter().any(|cause| cause.effect == name) || BEYOND_TRAVEL * travel >= longest {
        return;
    }
    let unit = Signal::Position.si_unit(machine.motion());
    let told = |length: f64| engineering(length, unit);
    for cause in causes.iter_mut().filter(|cause| cause.effect == EffectId::CableSpring.name()) {
        if !cause.confusable_with.iter().any(|other| other == name) {
            cause.confusable_with.push(name.to_owned());
            cause.confusable_with.sort();
        }
        let own = cause.confusable_reason.take().map_or_else(String::new, |reason| reason + " ");
        cause.confusable_reason = Some(format!(
            "{own}These runs travel {}: cogging with a pitch above {} looks like a spring there, and strokes of {} tell it.",
            told(travel),
            told(BEYOND_TRAVEL * travel),
            told(longest)
        ));
    }
}
