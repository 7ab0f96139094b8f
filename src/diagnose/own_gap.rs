//! What an effect of an explanation makes by itself: whether an explanation that leaves noise may hide another one.

use super::decide::above_noise;
use super::evidence::Score;
use super::experiment::HeldOut;
use super::fit::Fit;
use super::found::Found;
use super::noise::Floor;
use super::prior::overwhelming;
use super::thresholds::LARGELY;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use rayon::prelude::*;

/// The gap G that each effect of an explanation makes on the held-out runs: of the fitted machine without it, all other numbers kept.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub(super) fn own_gaps(
    machine: &Machine,
    fit: &Fit,
    held_out: &HeldOut,
    floor: &Floor,
) -> Result<Vec<(EffectId, f64)>> {
    let whole = fit.machine(machine)?;
    let of =
        |&effect: &EffectId| Ok((effect, Score::of(&whole.without_effect(effect)?, held_out, floor)?.gap()));
    fit.hypothesis.effects.iter().collect::<Vec<_>>().into_par_iter().map(of).collect()
}

impl Found {
    /// Whether `a` is an explanation, and `b`, which leaves noise, only looks like one.
    ///
    /// # Model
    /// Noise is known to 15 %, so that an explanation of another form may leave no more than noise: a delay in the place of an inductance and a resistance. Beside an
    /// explanation that predicts overwhelmingly better, on the same runs and by the same noise, it has no share in the posterior. `a` takes its place where it also
    /// closes more than a tenth of the power that `b` leaves, where no effect that it has more is a detail (see [`has_details`](Self::has_details)), and where no detail
    /// beside `b` predicts as well: a small error in the form of the laws of `b` is such a detail.
    pub(super) fn sees_through(&self, a: usize, b: usize, before: &Score) -> bool {
        let is_as_good = |k: usize| {
            self.candidates[k].thorough
                && self.candidates[k].effects().is_superset(self.candidates[b].effects())
                && self.likelihood(k) >= self.likelihood(a)
                && self.has_details(k, b, before)
        };
        self.is_adequate(b)
            && self.left(a) < LARGELY * self.left(b)
            && self.likelihood(a) - self.likelihood(b) > overwhelming()
            && !self.has_details(a, b, before)
            && !(0..self.candidates.len()).any(is_as_good)
    }

    /// Whether an effect that `a` has more than `b` makes less by itself than a small gap, or less of the gap's power than may stay open.
    fn has_details(&self, a: usize, b: usize, before: &Score) -> bool {
        let least =
            above_noise(self.limits.small_gap).max(self.limits.open_share * self.uncalibrated(before));
        let [all, known] = [a, b].map(|k| &self.candidates[k]);
        let own = |effect: &EffectId| all.own_gaps.iter().find(|(of, _)| of == effect);
        let is_detail = |effect: &EffectId| own(effect).is_none_or(|(_, gap)| above_noise(*gap) < least);
        all.effects().difference(known.effects()).any(is_detail)
    }
}

#[cfg(test)]
mod tests {
    use super::{EffectId, Score};
    use crate::diagnose::candidate::Candidate;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};

    /// Of two explanations that leave no more than noise, the one that leaves a tenth less is told where its further effect makes three times the noise, and 0.1 % of the
    /// gap's power: 10 of a gap of 316.
    #[test]
    fn exact_what_leaves_noise_is_seen_through_by_an_explanation_that_leaves_less() {
        let sees = |before: f64, left: f64, other: f64, own: f64| {
            let own_gaps = vec![(COULOMB, 99.0), (BACKLASH, own)];
            let pair = Candidate { own_gaps, ..candidate(&[COULOMB, BACKLASH], 1.0, left) };
            let all = vec![candidate(&[], 0.0, before), candidate(&[COULOMB], 1.0, other), pair];
            found(all, 1).sees_through(2, 1, &Score::even(before))
        };
        assert!(sees(100.0, 1.0, 1.2, 3.0) && !sees(100.0, 1.0, 1.2, 2.9) && !sees(100.0, 1.1, 1.2, 3.0));
        assert!(sees(1e5, 1.0, 1.2, 10.1) && !sees(1e5, 1.0, 1.2, 9.9));
        // More than noise is left: what closes half of that decides.
        assert!(!sees(100.0, 1.0, 1.6, 3.0));
        // A detail predicts as well: that may be all there is.
        let beside = |effect, own, left| {
            let own_gaps = vec![(COULOMB, 99.0), (effect, own)];
            Candidate { own_gaps, ..candidate(&[COULOMB, effect], 1.0, left) }
        };
        let sees = |detail: f64| {
            let pair = beside(BACKLASH, 30.0, 1.0);
            let detail = beside(EffectId::CableSpring, 2.0, detail);
            let all = vec![candidate(&[], 0.0, 100.0), candidate(&[COULOMB], 1.0, 1.2), pair, detail];
            found(all, 1).sees_through(2, 1, &Score::even(100.0))
        };
        assert!(sees(1.01) && !sees(0.99));
    }
}
