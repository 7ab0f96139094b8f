//! What an explanation comes to.

use super::decide::Evidence;
use super::evidence::{Score, closed};
use super::found::Found;
use super::rivals::rivals;

impl Found {
    /// Share of the gap that a candidate closes; what calibration closes by itself is no merit of its causes.
    pub(super) fn share(&self, index: usize, before: &Score) -> f64 {
        let after = &self.candidates[index].score;
        closed(before, after).value.min(closed(&self.candidates[0].score, after).value)
    }

    /// The evidence for the chosen explanation; `noise_is_measured` tells whether the noise was seen in the recording.
    pub(super) fn evidence(&self, before: &Score, noise_is_measured: bool) -> Evidence {
        let chosen = &self.candidates[self.chosen];
        let rivals: f64 = rivals(self).map(|(_, probability)| probability).sum();
        Evidence {
            names_effects: !chosen.effects().is_empty(),
            gap_before: before.gap(),
            gap_after: chosen.score.gap(),
            closed: self.share(self.chosen, before),
            noise_is_measured,
            probability: 1.0 - rivals,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::conclude;
    use crate::diagnose::folds::Folds;
    use crate::diagnose::found::posterior;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};
    use crate::diagnose::rivals;
    use crate::effect::EffectId;

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
        let rivals = rivals::open_rivals(&found, true);
        assert!(rivals.iter().all(|rival| rival.weight.is_finite()));
    }
}
