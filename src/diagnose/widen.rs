//! Widening a search: what is missing beside the rivals of the chosen explanation.

use super::evidence::Score;
use super::found::Found;
use super::hypothesis::EffectSet;
use super::posterior::posterior;
use super::prior::MOST_EFFECTS;
use super::selection::Search;
use crate::error::Result;
use std::collections::BTreeSet;

/// So many of the next best explanations are built upon where the best one leaves too much open.
const RUNNERS_UP: usize = 2;
/// The same where the best one may only look like what acts: of two effects that act together, each may explain less than several others by themselves.
const MOST_RUNNERS_UP: usize = 4;
/// So often as many of the next ones are fitted for them, where those before are not identified.
const TRIES: usize = 2;
/// Mean squares whose ratio is this near to one are the same.
const SAME: f64 = 1e-6;

impl Search<'_> {
    /// Adds effects to the rivals of an explanation that is not most probable by far as well, to those that leave something open, no more
    /// than it does by what is worth naming, and were not `widened` before; tells whether something better than the chosen explanation was found so, which is the chosen one then.
    ///
    /// What is missing beside a rival makes it look worse than it is, and blurs the evidence between all. Where the chosen explanation leaves too
    /// much open for a cause, the next best ones count as rivals too: of two effects that act together, the one that explains most by itself may
    /// be neither. So they do where the calibrated twin leaves noise already: what is chosen stands by its likelihood then, and not by what it closes; and where the
    /// chosen explanation leaves noise and may hide another one (see [`may_hide_another`](super::candidate::Candidate::may_hide_another)).
    pub(super) fn widen(
        &self,
        found: &mut Found,
        before: &Score,
        widened: &mut BTreeSet<EffectSet>,
    ) -> Result<bool> {
        let share = 0.5 * (1.0 - self.limits.probability);
        self.converge(found, before, share)?;
        let is_sufficient = found.is_sufficient(found.chosen, before, self.floors.common.is_measured());
        let is_probable = found.posterior[found.chosen] >= self.limits.probability;
        let is_by_likelihood = found.is_by_likelihood();
        let may_hide = found.candidates[found.chosen].may_hide_another();
        if is_sufficient && is_probable && !is_by_likelihood && !may_hide {
            return Ok(false);
        }
        let may_turn = |k: &usize| {
            let effects = found.candidates[*k].effects();
            found.posterior[*k] > share
                && (1..MOST_EFFECTS).contains(&effects.len())
                && found.is_sound(*k)
                && !found.is_adequate(*k)
                && !found.loses_ground(*k, before)
        };
        let mut rivals: Vec<usize> =
            (0..found.candidates.len()).filter(|k| !is_probable && may_turn(k)).collect();
        if !is_sufficient || is_by_likelihood || may_hide {
            let most = if may_hide { MOST_RUNNERS_UP } else { RUNNERS_UP };
            rivals.extend(self.runners_up(found, widened, most)?);
        }
        for rival in rivals {
            let effects = found.candidates[rival].effects().clone();
            if rival != found.chosen && !widened.contains(&effects) {
                self.explore(found, &self.larger(&effects), rival)?;
                widened.insert(effects);
            }
        }
        if !is_probable {
            self.join_with_unidentified(found, before)?;
            self.shrink_rivals(found, share)?;
        }
        if found.better(before).is_none() {
            // Of two effects that nearly cancel neither leads to the other.
            for from in BTreeSet::from([0, found.chosen]) {
                self.explore_pairs(found, from)?;
            }
        }
        let better = found.better(before);
        found.chosen = better.unwrap_or(found.chosen);
        Ok(better.is_some())
    }

    /// Looks at the rivals of the chosen explanation, those that have more than `share` of the posterior, with one effect less: of two that are alike, one may have an effect that only the other needs.
    fn shrink_rivals(&self, found: &mut Found, share: f64) -> Result<()> {
        let is_rival = |k: &usize| found.posterior[*k] > share && *k != found.chosen && found.is_sound(*k);
        let rivals: Vec<usize> = (0..found.posterior.len()).filter(is_rival).collect();
        for rival in rivals {
            let sets = self.subsets(found.candidates[rival].effects());
            self.explore(found, &sets, rival)?;
        }
        Ok(())
    }

    /// Looks at the chosen effects together with those of an explanation that is more probable and not identified: what drives a number of it to
    /// its bound may be the chosen effect that is missing beside it.
    fn join_with_unidentified(&self, found: &mut Found, before: &Score) -> Result<()> {
        found.posterior = posterior(found, before);
        let most = found.most_probable();
        let both: EffectSet = found.effects().union(found.candidates[most].effects()).copied().collect();
        if !found.is_resolved(most) && both.len() <= MOST_EFFECTS && found.index(&both).is_none() {
            self.explored(found, &[both])?;
        }
        Ok(())
    }

    /// The explanations that leave least, with no more effects than the chosen one, that are identified and were not `widened` before; fitted to the end.
    /// Those that leave the same are one on these runs: the first of them stands for all.
    ///
    /// Where nothing is chosen yet they need not be beyond chance: while several effects are missing, what one of them explains is small beside what
    /// the others leave, and that is correlated over long times. What is chosen in the end has to be.
    fn runners_up(
        &self,
        found: &mut Found,
        widened: &BTreeSet<EffectSet>,
        up_to: usize,
    ) -> Result<Vec<usize>> {
        let most = found.effects().len().max(1);
        let is_next = |k: &usize| {
            let effects = found.candidates[*k].effects();
            *k != found.chosen
                && (1..=most).contains(&effects.len())
                && !widened.contains(effects)
                && (!found.candidates[*k].thorough || found.is_resolved(*k))
                && (found.chosen == 0 || found.beyond_chance(*k, 0))
        };
        let mut next: Vec<usize> = (0..found.candidates.len()).filter(is_next).collect();
        next.sort_by(|&a, &b| found.left(a).total_cmp(&found.left(b)));
        let mut runners_up: Vec<usize> = Vec::new();
        for some in next.chunks(up_to).take(TRIES) {
            let open = some.iter().copied().filter(|&k| !found.candidates[k].thorough).collect();
            self.fit_to_the_end(found, open)?;
            for &k in some.iter().filter(|&&k| found.is_resolved(k)) {
                let is_same = |other: &usize| (found.left(k) / found.left(*other) - 1.0).abs() < SAME;
                if !runners_up.iter().any(is_same) {
                    runners_up.push(k);
                }
            }
            if runners_up.len() >= up_to {
                break;
            }
        }
        runners_up.truncate(up_to);
        Ok(runners_up)
    }
}
