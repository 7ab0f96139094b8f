//! Starting values and ranges for every effect, from one look at the motion.

use super::estimate::{self, Further, Screen};
use crate::effect::EffectId;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Where a fit of one effect begins and how far it may look.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// Starting values: one or several sets; none where the data show nothing to start from.
    pub starts: Vec<Vec<f64>>,
    /// Range of each parameter.
    pub ranges: Vec<(f64, f64)>,
    /// Of each number beside the parameters, in the order of [`Law::FURTHER`](crate::effect::Law::FURTHER); none of one that
    /// the recording does not tell.
    pub further: Vec<Option<Further>>,
    /// Starting values of the effect together with others that are found already, in the place of those.
    pub together: Vec<Together>,
}

/// Starting values of effects together.
#[derive(Debug, Clone, PartialEq)]
pub struct Together {
    /// Parameters of each effect.
    pub own: BTreeMap<EffectId, Vec<f64>>,
    /// What other numbers are beside these, by their key paths; those of a hypothesis that has one of them.
    pub beside: BTreeMap<String, f64>,
}

/// The proposals for a set of effects, all from the same screening.
#[derive(Debug, Clone, Default)]
pub struct Proposals(BTreeMap<EffectId, Proposal>);

impl Proposals {
    /// Screens for these effects, in parallel.
    pub fn of(screen: &Screen, effects: impl IntoIterator<Item = EffectId>) -> Self {
        let effects: Vec<EffectId> = effects.into_iter().collect();
        let propose = |&effect: &EffectId| {
            let ranges = estimate::range(effect, screen);
            let sound = |start: &Vec<f64>| start.iter().all(|value| value.is_finite());
            let starts = estimate::start(effect, screen).into_iter().filter(sound).collect();
            (
                effect,
                Proposal { starts, ranges, further: estimate::further(effect, screen), together: Vec::new() },
            )
        };
        Self(effects.par_iter().map(propose).collect())
    }

    /// Adds where an effect starts together with what it modifies, of a twin that has none of them.
    pub fn add_together(&mut self, effect: EffectId, bare: &Screen) {
        let members = members(effect);
        let set = |values: Vec<Vec<f64>>| Together {
            own: members.iter().copied().zip(values).collect(),
            beside: BTreeMap::new(),
        };
        let together = estimate::together(effect, bare).into_iter().map(set).collect();
        self.add(effect, Vec::new(), together);
    }

    /// Adds where an effect, or the effect with what it modifies, may start besides.
    pub fn add(&mut self, effect: EffectId, starts: Vec<Vec<f64>>, together: Vec<Together>) {
        let Some(proposal) = self.0.get_mut(&effect) else { return };
        proposal.starts.extend(starts);
        proposal.together.extend(together);
    }

    /// The proposal for one effect; none where it was not screened for.
    pub fn get(&self, effect: EffectId) -> Option<&Proposal> {
        self.0.get(&effect)
    }
}

/// What an effect modifies, what that modifies in turn, and itself, first the one that modifies nothing.
pub fn members(effect: EffectId) -> Vec<EffectId> {
    let mut members = vec![effect];
    while let Some(of) = members.last().and_then(|last| last.modifies().first()) {
        members.push(*of);
    }
    members.reverse();
    members
}
