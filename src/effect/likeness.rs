//! Effects that are another one's equal, or look like it, on what a log holds.

use super::{Constants, EffectId};
use crate::recording::Signal;

/// Whether a likeness holds for a machine with these constants and these logged signals.
pub type Rule = fn(&Constants, &[Signal]) -> bool;

/// Another effect that a diagnosis may name in the place of one.
#[derive(Debug, Clone, Copy)]
pub struct Likeness {
    /// The other effect.
    pub other: EffectId,
    /// How much alike they are.
    pub degree: Degree,
    /// Where they are, in words that begin with "where" or "in".
    pub place: &'static str,
}

/// How much two effects are alike.
#[derive(Debug, Clone, Copy)]
pub enum Degree {
    /// One another's equal: where the rule holds, no recording tells them apart.
    Equal(Rule),
    /// Equal up to constants inside their tolerances, which are calibrated with them.
    StandIn(Rule),
    /// Alike as far as the motion goes: another motion tells them apart.
    Similar,
}

impl Likeness {
    /// The exact equal of an effect.
    pub const fn equal(other: EffectId, place: &'static str, rule: Rule) -> Self {
        Self { other, degree: Degree::Equal(rule), place }
    }

    /// What stands in for an effect, with constants calibrated.
    pub const fn stand_in(other: EffectId, place: &'static str, rule: Rule) -> Self {
        Self { other, degree: Degree::StandIn(rule), place }
    }

    /// What looks like an effect in some motions.
    pub const fn similar(other: EffectId, place: &'static str) -> Self {
        Self { other, degree: Degree::Similar, place }
    }

    /// Whether the other one is the effect's exact equal on these signals.
    pub fn is_equal(&self, constants: &Constants, logged: &[Signal]) -> bool {
        matches!(self.degree, Degree::Equal(rule) if rule(constants, logged))
    }

    /// Whether the other one stands in for the effect on these signals.
    pub fn is_stand_in(&self, constants: &Constants, logged: &[Signal]) -> bool {
        matches!(self.degree, Degree::StandIn(rule) if rule(constants, logged))
    }
}

impl EffectId {
    /// What the effect is confusable with. A pair is stated by one of the two laws and read from both.
    pub fn likenesses(self) -> Vec<Likeness> {
        let mirrored = Self::ALL.iter().flat_map(|&by| {
            let of_self = by.confusable().iter().filter(move |likeness| likeness.other == self);
            of_self.map(move |likeness| Likeness { other: by, ..*likeness })
        });
        self.confusable().iter().copied().chain(mirrored).collect()
    }
}
