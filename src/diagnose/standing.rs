//! Which explanations stand by themselves.

use super::evidence::{Score, closed};
use super::found::{ADEQUATE_GAP, Found};

/// An explanation that is not adequate still stands where it leaves no more than this gap and closes this share.
const SMALL_GAP: f64 = 3.0;
pub(super) const LARGELY_CLOSED: f64 = 0.9;
/// Open share of the gap's power up to which an explanation stands whatever it leaves: 3 % of the amplitude, as stated constants
/// and the form of a law are known. A tenth, as the statistical model has it, let a cause stand that left 717 × noise.
const OPEN_SHARE: f64 = 1e-3;
/// The same where the noise is only stated, not seen in the recording: nobody knows how many times the noise is left.
const OPEN_SHARE_OF_STATED_NOISE: f64 = 1e-2;

impl Found {
    /// Share of the gap that a candidate closes; what calibration closes by itself is no merit of its causes.
    pub(super) fn share(&self, index: usize, before: &Score) -> f64 {
        let after = &self.candidates[index].score;
        closed(before, after).value.min(closed(&self.candidates[0].score, after).value)
    }

    /// Whether a candidate stands as an explanation: noise, or little more beside a large gap that it closes, is all that it
    /// leaves; or a share of the gap that is as small as the twin is known. `is_measured` tells whether the noise was seen in the
    /// recording.
    pub(super) fn stands(&self, index: usize, before: &Score, is_measured: bool) -> bool {
        let gap = self.candidates[index].score.gap();
        let closed = self.share(index, before);
        let open = if is_measured { OPEN_SHARE } else { OPEN_SHARE_OF_STATED_NOISE };
        gap <= ADEQUATE_GAP || (gap <= SMALL_GAP && closed >= LARGELY_CLOSED) || closed >= 1.0 - open
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
    use crate::diagnose::verdict::Verdict;
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

    /// Beside a gap of 1000 × noise, 30 left are a thousandth of its power, 100 a hundredth: that much may stay open where the noise
    /// was seen, and where it is only stated.
    #[test]
    fn exact_a_small_share_of_the_gap_may_stay_open() {
        let before = Score::even(1e6);
        let verdict = |gap: f64, is_measured: bool| {
            let all = vec![candidate(&[], 0.0, 1e6), candidate(&[COULOMB], 1.0, gap * gap)];
            let found = Found { posterior: vec![0.0, 1.0], ..found(all, 1) };
            conclude::verdict(&found, &before, is_measured)
        };
        assert_eq!([verdict(30.0, true), verdict(33.0, true)], [Verdict::Cause, Verdict::Unknown]);
        assert_eq!([verdict(95.0, false), verdict(105.0, false)], [Verdict::Cause, Verdict::Unknown]);
    }
}
