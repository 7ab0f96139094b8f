//! When a search begins anew with other noise floors, and what it takes from the earlier one.

use super::candidate::Candidate;
use super::evidence::Score;
use super::found::{Base, Found};
use super::hypothesis::Hypothesis;
use super::selection::Search;
use crate::error::Result;

/// An explanation that left so many times the mean square of the best one, by the floor of the earlier search and by the present one, is not fitted again: another
/// weighting of the signals will not bring it there. A choice of cost.
const HOPELESS: f64 = 4.0;

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
