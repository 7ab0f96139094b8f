//! Which explanations stand by themselves, and simpler ones beside those that generalise them.

use super::evidence::{Score, closed};
use super::found::{ADEQUATE_GAP, Found, posterior};
use super::hypothesis::EffectSet;
use crate::effect::EffectId;

/// An explanation that is not adequate still stands where it leaves no more than this gap and closes this share.
const SMALL_GAP: f64 = 3.0;
pub(super) const LARGELY_CLOSED: f64 = 0.9;

impl Found {
    /// Share of the gap that a candidate closes; what calibration closes by itself is no merit of its causes.
    pub(super) fn share(&self, index: usize, before: &Score) -> f64 {
        let after = &self.candidates[index].score;
        closed(before, after).value.min(closed(&self.candidates[0].score, after).value)
    }

    /// Whether a candidate stands as an explanation: noise, or little more beside a large gap that it closes, is all that it
    /// leaves.
    pub(super) fn stands(&self, index: usize, before: &Score) -> bool {
        let gap = self.candidates[index].score.gap();
        gap <= ADEQUATE_GAP || (gap <= SMALL_GAP && self.share(index, before) >= LARGELY_CLOSED)
    }

    /// The explanation with simpler laws in the place of a chosen one that generalises them, where by itself it would stand
    /// as the cause: every guide yields a little before it slides and sticks a little more than it slides, and what that
    /// leaves of a large gap decides between the laws only where it is more than a small gap.
    pub(super) fn plainer(&self, before: &Score) -> Option<usize> {
        let simpler = (0..self.candidates.len()).filter(|&k| {
            self.is_plain_of(k, self.chosen)
                && self.candidates[k].thorough
                && self.is_resolved(k)
                && self.stands(k, before)
        });
        self.best_of(&simpler.collect::<Vec<_>>())
    }

    /// Whether a candidate is another one with simpler laws in the place of one that generalises them, and else the same.
    fn is_plain_of(&self, index: usize, general: usize) -> bool {
        let (own, other) = (self.candidates[index].effects(), self.candidates[general].effects());
        let laws = other.difference(own).copied().filter(|e| !e.supersedes().is_empty());
        let laws: Vec<EffectId> = laws.collect();
        let [law] = laws[..] else { return false };
        let rest: EffectSet = other.iter().copied().filter(|e| *e != law).collect();
        own.len() > rest.len() && own.is_superset(&rest) && own.is_subset(&self.plain(general, law))
    }

    /// Lets a chosen explanation stand beside one with a law that generalises its own, where it stands by itself and the other
    /// one has the probability: it, and all others without that law, are then counted as if it predicted as well.
    pub(super) fn let_stand_beside(&mut self, before: &Score) {
        let most =
            (0..self.candidates.len()).max_by(|&a, &b| self.posterior[a].total_cmp(&self.posterior[b]));
        let Some(law) = most else { return };
        let is_beside = self.is_plain_of(self.chosen, law)
            && self.stands(self.chosen, before)
            && self.likelihood(law) > self.likelihood(self.chosen);
        if is_beside {
            self.beside = Some((law, self.chosen));
            self.posterior = posterior(self, before);
        }
    }

    /// Whether a candidate lacks the law beside which the chosen one stands.
    pub(super) fn is_simple(&self, index: usize) -> bool {
        self.beside.is_some_and(|(law, plain)| {
            let laws = self.candidates[law].effects().difference(self.candidates[plain].effects());
            laws.copied().all(|law| !self.candidates[index].effects().contains(&law))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::conclude;
    use crate::diagnose::folds::Folds;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};
    use crate::diagnose::verdict::Verdict;

    /// A law that generalises another is named where the other leaves more than a small gap.
    #[test]
    fn exact_the_plainer_law_is_taken_where_it_stands() {
        let before = Score::even(1e4);
        let plainer = |left: f64, value: f64| {
            let all = vec![
                candidate(&[], 0.0, 1e4),
                candidate(&[COULOMB], value, left),
                candidate(&[EffectId::Presliding], 1.0, 1.0),
            ];
            found(all, 2).plainer(&before)
        };
        assert_eq!((plainer(4.0, 1.0), plainer(16.0, 1.0), plainer(4.0, 10.0)), (Some(1), None, None));
        // The twin as it is is no simpler law.
        let all = vec![candidate(&[], 0.0, 1.2), candidate(&[EffectId::Presliding], 1.0, 0.9)];
        assert_eq!(found(all, 1).plainer(&before), None);
    }

    /// A simpler law that stands, and the law that generalises it and predicts much better, have about the same probability, and the
    /// verdict is open between them.
    #[test]
    fn exact_a_simpler_law_stands_beside_the_one_that_generalises_it() {
        const PRESLIDING: EffectId = EffectId::Presliding;
        let before = Score::even(1e4);
        let all = vec![
            candidate(&[], 0.0, 1e4),
            candidate(&[COULOMB], 1.0, 4.0),
            candidate(&[PRESLIDING], 1.0, 1.0),
            candidate(&[BACKLASH], 1.0, 90.0),
        ];
        let mut found = found(all, 1);
        found.posterior = posterior(&found, &before);
        assert!(found.posterior[2] > 0.99 && found.posterior[1] < 1e-9, "{:?}", found.posterior);
        found.let_stand_beside(&before);
        assert!(found.posterior[1] > 0.3 && found.posterior[2] > 0.05, "{:?}", found.posterior);
        assert!(found.posterior[3] < 1e-9);
        assert_eq!(conclude::verdict(&found, &before, true), Verdict::Undecided);
        let folds = Folds { predicted_closed: 1.0, values: vec![] };
        let causes = conclude::causes(&found, &before, &folds);
        assert_eq!((causes.len(), &causes[0].confusable_with[..]), (1, &["presliding".to_owned()][..]));
    }

    /// An equal of the chosen effect is its rival, whichever of them happens to leave a billionth less; more effects that gain too
    /// little to be named are a detail.
    #[test]
    fn exact_an_equal_is_no_refinement() {
        let before = Score::even(1e4);
        let all = vec![
            candidate(&[], 0.0, 1e4),
            candidate(&[COULOMB], 1.0, 2.0),
            candidate(&[EffectId::LoadDependentFriction], 1.0, 2.0 - 2e-9),
            candidate(&[COULOMB, BACKLASH], 1.0, 1.8),
        ];
        let mut found = found(all, 1);
        assert_eq!([2, 3].map(|k| found.is_refinement(k, &before)), [false, true]);
        found.posterior = posterior(&found, &before);
        let folds = Folds { predicted_closed: 1.0, values: vec![] };
        let causes = conclude::causes(&found, &before, &folds);
        assert_eq!(causes[0].confusable_with, ["load_dependent_friction"]);
        // One effect with two numbers, that leaves a little less, is a detail of one with a single number.
        let more = found.candidates[2].fit.hypothesis.free[0].clone();
        found.candidates[2].fit.hypothesis.free.push(more);
        assert!(found.is_refinement(2, &before));
    }

    /// What predicts far better and was not chosen for other reasons is no equal of what was.
    #[test]
    fn exact_what_predicts_far_better_is_not_confusable() {
        let before = Score::even(1e4);
        let all = vec![
            candidate(&[], 0.0, 1e4),
            candidate(&[COULOMB], 1.0, 900.0),
            candidate(&[BACKLASH], 10.0, 4.0),
            candidate(&[EffectId::LoopDelay], 1.0, 900.0),
        ];
        let mut found = found(all, 1);
        found.posterior = posterior(&found, &before);
        let folds = Folds { predicted_closed: 1.0, values: vec![] };
        assert!(conclude::causes(&found, &before, &folds)[0].confusable_with.is_empty());
        let rivals = conclude::open_rivals(&found, Verdict::Undecided);
        assert!(rivals.iter().all(|rival| rival.weight.is_finite()));
    }

    /// Five times a noise that was seen is more than a detail, however large the gap was; of noise that is only stated nobody
    /// knows that.
    #[test]
    fn exact_more_than_a_small_gap_is_unknown_where_the_noise_was_seen() {
        let before = Score::even(1e6);
        let verdict = |gap: f64, is_measured: bool| {
            let all = vec![candidate(&[], 0.0, 1e6), candidate(&[COULOMB], 1.0, gap * gap)];
            let found = Found { posterior: vec![0.0, 1.0], ..found(all, 1) };
            conclude::verdict(&found, &before, is_measured)
        };
        assert_eq!([verdict(5.0, true), verdict(5.0, false)], [Verdict::Unknown, Verdict::Cause]);
        assert_eq!([verdict(2.5, true), verdict(200.0, false)], [Verdict::Cause, Verdict::Unknown]);
    }
}
