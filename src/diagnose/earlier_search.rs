//! When a search begins anew with other noise floors, and what it takes from the earlier one.

use super::candidate::Candidate;
use super::evidence::Score;
use super::found::{Base, Found};
use super::hypothesis::{EffectSet, Hypothesis};
use super::posterior::posterior;
use super::selection::{LEAST_SHARE, Search};
use crate::error::Result;

/// An explanation that left so many times the mean square of the best one, by the floor of the earlier search and by the present one, is not fitted again: another
/// weighting of the signals will not bring it there. A choice of cost.
const HOPELESS: f64 = 4.0;

impl Found {
    /// The sets of effects that a search would tell: the chosen one, that which predicts best, and those with more than a share that changes a verdict. Of a search that
    /// did not come to its end there are no shares: it tells the chosen one alone.
    fn told(&self) -> Vec<EffectSet> {
        let has_share = |k: &usize| self.posterior.get(*k).is_some_and(|share| *share > LEAST_SHARE);
        let best = self.predicts_best();
        let may_be = |k: &usize| *k == self.chosen || Some(*k) == best || has_share(k);
        let told = (0..self.candidates.len()).filter(may_be);
        told.map(|k| self.candidates[k].effects().clone()).collect()
    }

    /// Whether these effects were fitted to the end.
    fn has_fitted(&self, set: &EffectSet) -> bool {
        self.index(set).is_some_and(|k| self.candidates[k].thorough)
    }
}

impl Search<'_> {
    /// What the earlier search made ready of a candidate, where it looked for no less: another floor moves starts by little.
    pub(super) fn earlier_base(&self, found: &Found, index: usize) -> Option<&Base> {
        let earlier = self.earlier?;
        let k = earlier.index(found.candidates[index].effects())?;
        let is_whole = index == 0 || earlier.more_may_act(k) || !found.more_may_act(index);
        earlier.bases.get(&k).filter(|_| is_whole)
    }

    /// The best explanation of the earlier search, judged by the present floor.
    pub(super) fn earlier_best(&self) -> Result<Option<Candidate>> {
        let best = self.earlier.map(|found| &found.candidates[found.chosen]);
        best.map(|best| self.judge(best.fit.clone(), false)).transpose()
    }

    /// The fit of the earlier search, judged by the present floor, where it did not come near the best explanation by either; `best` is that one by the present
    /// floor.
    pub(super) fn hopeless(
        &self,
        hypothesis: &Hypothesis,
        best: Option<&Candidate>,
    ) -> Result<Option<Candidate>> {
        let Some((found, best)) = self.earlier.zip(best) else { return Ok(None) };
        let Some(index) = found.index(&hypothesis.effects) else { return Ok(None) };
        if found.left(index) <= HOPELESS * found.left(found.chosen) {
            return Ok(None);
        }
        let again = self.judge(found.candidates[index].fit.clone(), false)?;
        let is_hopeless = again.left() > HOPELESS * best.left();
        if is_hopeless {
            self.tell(hypothesis);
        }
        Ok(is_hopeless.then_some(again))
    }

    /// Looks at what the earlier search would have told, where this one has not come to it: what it chose, what predicted best, and what has more than a share
    /// that changes a verdict. Tells whether something is better than the chosen explanation, which is the chosen one then.
    ///
    /// By other noise floors a search takes another way. What an explanation is worth depends on the floors, and not on the way.
    pub(super) fn look_at_earlier(&self, found: &mut Found, before: &Score) -> Result<bool> {
        let Some(earlier) = self.earlier else { return Ok(false) };
        let sets: Vec<EffectSet> = earlier.told().into_iter().filter(|set| !found.has_fitted(set)).collect();
        if sets.is_empty() {
            return Ok(false);
        }
        self.explored(found, &sets)?;
        found.posterior = posterior(found, before);
        let better = found.better(before);
        found.chosen = better.unwrap_or(found.chosen);
        Ok(better.is_some())
    }

    /// Whether the chosen explanation is a first effect that leaves little of the gap, and noise takes another way through its twin. What is left of other noise
    /// looks like further effects, each of which would be fitted beside it.
    pub(super) fn begins_anew(&self, found: &Found, before: &Score) -> Result<bool> {
        let chosen = &found.candidates[found.chosen];
        let leaves_little = chosen.left() <= self.limits.open_share * before.mean_square();
        match self.has_other_floors.filter(|_| leaves_little && chosen.effects().len() == 1) {
            Some(asked) if found.has_material_left(before) => asked(&chosen.fit),
            _ => Ok(false),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};
    use crate::effect::EffectId;

    /// Told are the chosen explanation, the one that leaves least, however improbable, and those with more than a hundredth; of two others none.
    #[test]
    fn exact_a_search_tells_what_it_chose_what_predicts_best_and_what_has_a_share() {
        let one = |effect: EffectId, left: f64| candidate(&[effect], 1.0, left);
        let all = vec![
            candidate(&[], 0.0, 1e4),
            one(COULOMB, 9.0),
            one(BACKLASH, 4.0),
            one(EffectId::Cogging, 16.0),
            one(EffectId::Payload, 25.0),
        ];
        let mut found = found(all, 1);
        found.posterior = vec![0.0, 0.2, 0.001, 0.7, 0.009];
        let told = [COULOMB, BACKLASH, EffectId::Cogging].map(|effect| EffectSet::from([effect]));
        assert_eq!(found.told(), told);
        (found.posterior, found.candidates[2].thorough) = (vec![], true);
        assert_eq!(found.told(), told[..1]);
        found.candidates[1].thorough = false;
        assert_eq!(told.map(|set| found.has_fitted(&set)), [false, true, true]);
        assert!(!found.has_fitted(&EffectSet::from([EffectId::LoopDelay])));
    }
}
