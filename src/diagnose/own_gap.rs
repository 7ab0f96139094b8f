//! What an effect of an explanation makes by itself: whether an explanation that leaves noise may hide another one.

use super::candidate::Candidate;
use super::decide::above_noise;
use super::evidence::Score;
use super::experiment::HeldOut;
use super::fit::Fit;
use super::found::Found;
use super::free::Free;
use super::noise::Floor;
use super::prior::overwhelming;
use super::selection::Search;
use super::thresholds::LARGELY;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use rayon::prelude::*;

/// The gap G that each effect of an explanation makes by itself on the held-out runs: of the fitted machine without it and what modifies it, or, where the twin states the
/// effect, with its numbers as stated; all other numbers kept. Effects are left out of which a run needs a number that is gone.
///
/// # Errors
/// Values that make no machine.
fn own_gaps(machine: &Machine, fit: &Fit, held_out: &HeldOut, floor: &Floor) -> Result<Vec<(EffectId, f64)>> {
    let whole = fit.machine(machine)?;
    let without = |effect: EffectId| match machine.description().effect.contains(effect) {
        true => fit.hypothesis.machine(machine, &as_stated(fit, effect)),
        false => whole.without_effect(effect),
    };
    let of = |&effect: &EffectId| {
        let score = without(effect).and_then(|machine| Score::of(&machine, held_out, floor)).ok()?;
        Some((effect, score.gap()))
    };
    let effects: Vec<&EffectId> = fit.hypothesis.effects.iter().collect();
    Ok(effects.into_par_iter().filter_map(of).collect())
}

/// The values of a fit with the numbers of an effect as the twin states them.
fn as_stated(fit: &Fit, effect: EffectId) -> Vec<f64> {
    let is_of_effect = |free: &Free| free.effect == effect && free.neutral.is_finite();
    let stated = |(free, value): (&Free, &f64)| if is_of_effect(free) { free.neutral } else { *value };
    fit.hypothesis.free.iter().zip(&fit.values).map(stated).collect()
}

impl Search<'_> {
    /// Takes the gaps that the effects make by themselves of the candidates that may take the place of another one.
    ///
    /// # Errors
    /// Values that make no machine.
    pub(super) fn take_own_gaps(&self, found: &mut Found) -> Result<()> {
        for k in found.far_likelier() {
            let fit = &found.candidates[k].fit;
            let gaps = own_gaps(self.machine, fit, self.held_out, &self.floors.common)?;
            found.candidates[k].own_gaps = Some(gaps);
        }
        Ok(())
    }
}

impl Found {
    /// The candidates fitted to the end that predict overwhelmingly better than another one though both leave noise, and whose own gaps are not known yet.
    fn far_likelier(&self) -> Vec<usize> {
        let is_close = |k: &usize| self.candidates[*k].predictive.score.is_adequate();
        let close: Vec<(usize, f64)> =
            (0..self.candidates.len()).filter(is_close).map(|k| (k, self.likelihood(k))).collect();
        let adequate = close.iter().filter(|(k, _)| self.is_adequate(*k));
        let least = adequate.map(|(_, likelihood)| *likelihood).fold(f64::INFINITY, f64::min);
        let is_unknown = |candidate: &Candidate| {
            candidate.thorough && !candidate.has_own_floor && candidate.own_gaps.is_none()
        };
        let is_wanted = |(k, likelihood): &(usize, f64)| {
            likelihood - least > overwhelming() && is_unknown(&self.candidates[*k])
        };
        close.into_iter().filter(is_wanted).map(|(k, _)| k).collect()
    }

    /// Whether beside a candidate more may act: what it leaves is more than noise, or it may only look like what acts.
    pub(super) fn more_may_act(&self, index: usize) -> bool {
        index == 0 || !self.is_adequate(index) || self.candidates[index].may_hide_another()
    }

    /// Whether `a` takes the place of `b`, which leaves noise and yet only looks like what acts.
    ///
    /// # Model
    /// Noise is known to 15 %, so that an explanation of another form may leave no more than noise: a delay in the place of an inductance and a resistance. Beside an
    /// explanation that predicts overwhelmingly better, on the same runs and by the same noise, it has no share in the posterior. `a` takes its place where it also
    /// closes more than a tenth of the power that `b` leaves, noise included, where no effect that it has more is a detail (see [`details`](Self::details)), and where no
    /// details beside `b` predict as well: a small error in the form of the laws of `b` is such a detail.
    pub(super) fn supersedes(&self, a: usize, b: usize, before: &Score) -> bool {
        let is_as_good = |k: usize| {
            self.candidates[k].thorough
                && self.candidates[k].effects().is_superset(self.candidates[b].effects())
                && self.likelihood(k) >= self.likelihood(a)
                && self.details(k, b, before).iter().all(|is_detail| *is_detail)
        };
        self.is_adequate(b)
            && self.left(a) < LARGELY * self.left(b)
            && self.likelihood(a) - self.likelihood(b) > overwhelming()
            && !self.details(a, b, before).contains(&true)
            && !(0..self.candidates.len()).any(|k| k != b && is_as_good(k))
    }

    /// Of each effect that `a` has more than `b`: whether it makes less by itself than a small gap, or less of the gap's power than may stay open.
    fn details(&self, a: usize, b: usize, before: &Score) -> Vec<bool> {
        let least =
            above_noise(self.limits.small_gap).max(self.limits.open_share * self.uncalibrated(before));
        let [all, known] = [a, b].map(|k| &self.candidates[k]);
        let own = |effect: &EffectId| all.own_gaps.iter().flatten().find(|(of, _)| of == effect);
        let is_detail = |effect: &EffectId| own(effect).is_none_or(|(_, gap)| above_noise(*gap) < least);
        all.effects().difference(known.effects()).map(is_detail).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Candidate, EffectId, Score};
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};

    /// Effects that leave noise may hide others from 1.11 times its power on; the twin as it is, and what leaves more than noise, hide nothing.
    #[test]
    fn exact_what_leaves_noise_may_hide_another_explanation() {
        let may_hide = |effects: &[EffectId], left: f64| candidate(effects, 1.0, left).may_hide_another();
        assert!(may_hide(&[COULOMB], 1.12) && !may_hide(&[COULOMB], 1.1));
        assert!(!may_hide(&[], 1.12) && !may_hide(&[COULOMB], 1.6));
        let room = |left: f64| found(vec![candidate(&[], 0.0, 9.0), candidate(&[COULOMB], 1.0, left)], 1);
        assert!(room(1.12).more_may_act(1) && room(1.6).more_may_act(1) && !room(1.1).more_may_act(1));
        assert!(room(1.1).more_may_act(0));
    }

    /// Of two explanations that leave no more than noise, the one that leaves a tenth less is told where its further effect makes three times the noise, and 0.1 % of the
    /// gap's power: 10 of a gap of 316.
    #[test]
    fn exact_what_leaves_noise_is_superseded_by_an_explanation_that_leaves_less() {
        let supersedes = |before: f64, left: f64, other: f64, own: f64| {
            let own_gaps = Some(vec![(COULOMB, 99.0), (BACKLASH, own)]);
            let pair = Candidate { own_gaps, ..candidate(&[COULOMB, BACKLASH], 1.0, left) };
            let all = vec![candidate(&[], 0.0, before), candidate(&[COULOMB], 1.0, other), pair];
            found(all, 1).supersedes(2, 1, &Score::even(before))
        };
        assert!(
            supersedes(100.0, 1.0, 1.2, 3.0)
                && !supersedes(100.0, 1.0, 1.2, 2.9)
                && !supersedes(100.0, 1.1, 1.2, 3.0)
        );
        assert!(supersedes(1e5, 1.0, 1.2, 10.1) && !supersedes(1e5, 1.0, 1.2, 9.9));
        // More than noise is left: what closes half of that decides.
        assert!(!supersedes(100.0, 1.0, 1.6, 3.0));
        // A detail predicts as well: that may be all there is.
        let beside = |effect, own, left| {
            let own_gaps = Some(vec![(COULOMB, 99.0), (effect, own)]);
            Candidate { own_gaps, ..candidate(&[COULOMB, effect], 1.0, left) }
        };
        let supersedes = |detail: f64| {
            let pair = beside(BACKLASH, 30.0, 1.0);
            let detail = beside(EffectId::CableSpring, 2.0, detail);
            let all = vec![candidate(&[], 0.0, 100.0), candidate(&[COULOMB], 1.0, 1.2), pair, detail];
            found(all, 1).supersedes(2, 1, &Score::even(100.0))
        };
        assert!(supersedes(1.01) && !supersedes(0.99));
        // A detail on top of it is another matter.
        let pair = beside(BACKLASH, 30.0, 1.0);
        let effects = [COULOMB, BACKLASH, EffectId::CableSpring];
        let own_gaps = Some(vec![(COULOMB, 99.0), (BACKLASH, 30.0), (EffectId::CableSpring, 2.0)]);
        let more = Candidate { own_gaps, ..candidate(&effects, 1.0, 0.99) };
        let all = vec![candidate(&[], 0.0, 100.0), candidate(&[COULOMB], 1.0, 1.2), pair, more];
        assert!(found(all, 1).supersedes(2, 1, &Score::even(100.0)));
    }
}
