//! Effects that are one another's equal: no recording of these signals tells them apart.

use crate::effect::{EffectId, Site};
use crate::machine::Machine;
use crate::recording::Signal;
use std::collections::BTreeSet;

/// The exact equals of an effect on logged signals, by the identities that the laws document.
///
/// # Model
/// - A force constant off by f and an encoder scale of f, where neither force nor a second position is logged.
/// - Friction by the sliders' loads and Coulomb friction, where the loads do not change.
/// - A lead error and an encoder error of the same period, where one sensor sees the load.
/// - A constant force and an amplifier offset, where neither current nor force is logged.
pub fn equals(effect: EffectId, machine: &Machine, logged: &[Signal]) -> Vec<EffectId> {
    let constants = machine.constants();
    let force = logged.contains(&Signal::Thrust);
    let one_sensor = !logged.contains(&Signal::LoadPosition);
    let pairs = [
        (EffectId::ForceConstant, EffectId::EncoderScale, !force && one_sensor),
        (EffectId::LoadDependentFriction, EffectId::CoulombFriction, constants.has_slider_loads),
        (EffectId::ScrewError, EffectId::EncoderPeriodicError, one_sensor && !constants.sees_both_ends),
        (EffectId::ConstantForce, EffectId::AmplifierOffset, !force && !logged.contains(&Signal::Current)),
    ];
    let partner = |(a, b, holds): (EffectId, EffectId, bool)| match (holds, a == effect, b == effect) {
        (true, true, _) => Some(b),
        (true, _, true) => Some(a),
        _ => None,
    };
    pairs.into_iter().filter_map(partner).filter(|other| other.applies(&constants)).collect()
}

/// What must be struck from the catalogue for an effect to lie outside it: itself, its equals and its stand-ins.
///
/// # Model
/// f·Kt·i = m·a + c·v is Kt·i = (m/f)·a + (c/f)·v: where no force is logged, a payload stands in for a force constant, and with
/// one position sensor for an encoder scale, and they for it, with drag calibrated by the same factor.
pub fn struck(effect: EffectId, machine: &Machine, logged: &[Signal]) -> Vec<EffectId> {
    let one_sensor = !logged.contains(&Signal::LoadPosition);
    let alike =
        [(EffectId::ForceConstant, true), (EffectId::Payload, true), (EffectId::EncoderScale, one_sensor)];
    let alike = alike.into_iter().filter(|(_, holds)| *holds && !logged.contains(&Signal::Thrust));
    let alike: Vec<EffectId> = alike.map(|(effect, _)| effect).collect();
    let stand_ins = alike.iter().copied().filter(|_| alike.contains(&effect));
    let equals = equals(effect, machine, logged);
    let own: BTreeSet<EffectId> = std::iter::once(effect).chain(equals).chain(stand_ins).collect();
    own.into_iter().collect()
}

/// The sites at which an effect or one of its equals lies.
pub fn sites(effect: EffectId, equals: &[EffectId]) -> Vec<Site> {
    let mut sites: Vec<Site> = std::iter::once(&effect).chain(equals).map(|e| e.site()).collect();
    sites.dedup();
    sites
}
