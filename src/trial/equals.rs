//! Effects that are one another's equal: no recording of these signals tells them apart.

use crate::effect::{EffectId, Site};
use crate::machine::Machine;
use crate::recording::Signal;
use std::collections::BTreeSet;

/// The exact equals of an effect on logged signals, by the identities that the laws state.
pub fn equals(effect: EffectId, machine: &Machine, logged: &[Signal]) -> Vec<EffectId> {
    let constants = machine.constants();
    let likenesses = effect.likenesses();
    let equal = likenesses.iter().filter(|likeness| likeness.is_equal(&constants, logged));
    equal.map(|likeness| likeness.other).filter(|other| other.applies(&constants)).collect()
}

/// What must be struck from the catalogue for an effect to lie outside it: itself, its equals and its stand-ins.
///
/// # Model
/// f·Kt·i = m·a + c·v is Kt·i = (m/f)·a + (c/f)·v: where no force is logged, a payload stands in for a force constant, and with
/// one position sensor for an encoder scale, and they for it, with drag calibrated by the same factor.
pub fn struck(effect: EffectId, machine: &Machine, logged: &[Signal]) -> Vec<EffectId> {
    let constants = machine.constants();
    let likenesses = effect.likenesses();
    let stand_ins = likenesses.iter().filter(|likeness| likeness.is_stand_in(&constants, logged));
    let stand_ins = stand_ins.map(|likeness| likeness.other);
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
