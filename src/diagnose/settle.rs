//! Which explanation is told where the search ends: what of the chosen one is certain, or the most probable one.

use super::evidence::Score;
use super::found::Found;
use super::hypothesis::EffectSet;
use super::posterior::posterior;
use super::prior::MOST_EFFECTS;
use super::selection::{MOST_FALL, Search};
use super::thresholds::LARGELY;
use crate::error::Result;

impl Found {
    /// Takes the twin as it is for the explanation: it is quiet (see [`is_quiet`](Self::is_quiet)).
    pub(super) fn settle(&mut self, before: &Score) {
        self.chosen = 0;
        self.is_settled = true;
        self.posterior = posterior(self, before);
    }

    /// The explanation that leaves least of the held-out runs, the uncertainty of its numbers included, of those that have a share of the posterior.
    pub(super) fn predicts_best(&self) -> Option<usize> {
        let has_share = |k: usize| self.posterior.get(k).is_some_and(|share| *share > 0.0);
        let counts = |k: &usize| self.candidates[*k].thorough && has_share(*k);
        (0..self.candidates.len()).filter(counts).min_by(|&a, &b| self.left(a).total_cmp(&self.left(b)))
    }

    /// Whether a candidate leaves no more than the chosen explanation but for what the form of a law may leave; of one that is not fitted to the end, whether it may
    /// then.
    fn is_of_form(&self, index: usize, before: &Score) -> bool {
        let share = if self.candidates[index].thorough { 1.0 } else { MOST_FALL };
        let (own, left) = (self.left(self.chosen), share * self.left(index));
        // What closes nine tenths of the rest is no detail of another law.
        let closes_the_rest = own - 1.0 <= (1.0 - LARGELY) * (left - 1.0);
        !closes_the_rest && left - own < self.limits.open_share * self.uncalibrated(before)
    }
}

impl Search<'_> {
    /// Takes what of the chosen explanation is certain, where that by itself leaves nothing that need be named, or where all of it leaves too much
    /// for a cause: what is found in part has to be certain.
    pub(super) fn settle_for_certain(&self, found: &mut Found, before: &Score) -> Result<()> {
        if found.probability(found.effects()) >= self.limits.probability {
            return Ok(());
        }
        let Some(certain) = found.certain(self.machine, self.limits.probability) else { return Ok(()) };
        let Some(&index) = self.explored(found, &[certain])?.first() else { return Ok(()) };
        let measured = self.floors.common.is_measured();
        let is_in_part = !self.for_prediction
            && found.is_resolved(index)
            && !found.is_sufficient(found.chosen, before, measured);
        if is_in_part || found.leaves_nothing_to_name(index, before, measured) {
            found.chosen = index;
        }
        found.posterior = posterior(found, before);
        Ok(())
    }

    /// Takes out of an explanation that leaves more than noise the effects without which no more of the gap stays open than the form of a law may leave, and which do
    /// not close nine tenths of what is left without them: a law whose form is only nearly right leaves something that another effect can follow. What that closes
    /// makes no verdict either.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn leave_out_what_a_form_leaves(&self, found: &mut Found, before: &Score) -> Result<()> {
        while found.effects().len() > 1 && !found.predicts_to_noise(found.chosen) {
            let may_be = |set: &EffectSet| found.index(set).is_none_or(|k| found.is_of_form(k, before));
            let smaller: Vec<EffectSet> = self.subsets(found.effects()).into_iter().filter(may_be).collect();
            let indices = self.explored(found, &smaller)?;
            let may_go = |k: &usize| found.is_sound(*k) && found.is_of_form(*k, before);
            let open: Vec<usize> = indices.into_iter().filter(may_go).collect();
            let Some(rest) = found.best_of(&open) else { break };
            found.chosen = rest;
            found.posterior = posterior(found, before);
        }
        Ok(())
    }

    /// Where the chosen explanation leaves too much for a cause: takes the most probable one if it is improbable, and else the one with all effects that
    /// are certain, if those are more. Where an explanation is wanted for what it predicts it is the one that predicts best, whatever its probability. No verdict rests on it
    /// where the training runs do not identify it (see [`Unidentified`](super::grounds::Unidentified)).
    ///
    /// # Source
    /// M. M. Barbieri, J. O. Berger (2004), *Optimal predictive model selection*, Ann. Statist. 32:870: of several explanations that share the
    /// posterior, the one of all effects that are probable predicts best.
    pub(super) fn take_what_is_probable(&self, found: &mut Found, before: &Score) {
        let measured = self.floors.common.is_measured();
        // Which explanations count beside the chosen one depends on it.
        for _ in 0..MOST_EFFECTS {
            let own = match found.chosen {
                0 => found.posterior[0],
                _ => found.probability(found.effects()),
            };
            if found.is_sufficient(found.chosen, before, measured) {
                return;
            }
            let decides = self.limits.probability;
            let other = match own < decides {
                _ if self.for_prediction => found.predicts_best(),
                true => Some(found.most_probable()),
                false => found.all_certain(self.machine, decides),
            };
            let Some(other) = other.filter(|&other| found.candidates[other].thorough) else { return };
            found.chosen = other;
            found.posterior = posterior(found, before);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};

    /// The explanation that predicts best is the one that leaves least of those that have a share and are fitted to the end, whatever its share.
    #[test]
    fn exact_what_predicts_best_need_not_be_most_probable() {
        let least = |share: f64, is_thorough: bool| {
            let one = |effect, left: f64| candidate(&[effect], 1.0, left);
            let mut found = found(vec![candidate(&[], 0.0, 1e4), one(COULOMB, 9.0), one(BACKLASH, 4.0)], 1);
            found.posterior = vec![0.0, 1.0 - share, share];
            found.candidates[2].thorough = is_thorough;
            found.predicts_best()
        };
        assert_eq!([least(0.01, true), least(0.0, true), least(0.01, false)], [2, 1, 1].map(Some));
    }

    /// Beside a gap of 100, of which a thousandth may stay as the form of a law leaves it: what leaves 9.9 of mean square more may be that, and not what leaves 10.1.
    #[test]
    fn exact_what_a_form_may_leave_is_a_thousandth_of_the_gap() {
        let of_form = |more: f64| {
            let pair = candidate(&[COULOMB, BACKLASH], 1.0, 5.0);
            let all = vec![candidate(&[], 0.0, 1e4), candidate(&[COULOMB], 1.0, 5.0 + more), pair];
            found(all, 2).is_of_form(1, &Score::even(1e4))
        };
        assert!(of_form(9.9) && !of_form(10.1));
        // What leaves 1.5 where 8 were is worth keeping.
        let all = vec![
            candidate(&[], 0.0, 1e4),
            candidate(&[COULOMB], 1.0, 8.0),
            candidate(&[COULOMB, BACKLASH], 1.0, 1.5),
        ];
        assert!(!found(all, 2).is_of_form(1, &Score::even(1e4)));
    }
}
