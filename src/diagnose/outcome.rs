//! What an explanation comes to.

use super::candidate::Candidate;
use super::decide::{Evidence, SignalEvidence};
use super::evidence::{Score, closed, closed_power};
use super::found::Found;
use super::hypothesis::{EffectSet, with_modified};
use crate::effect::EffectId;
use crate::machine::Machine;
use crate::recording::Signal;

impl Found {
    /// Share of the gap that a candidate closes with its numbers where training and held-out runs together have them; what calibration closes by itself is
    /// no merit of its causes.
    pub(super) fn share(&self, index: usize, before: &Score) -> f64 {
        let [calibrated, after] = [0, index].map(|k| &self.candidates[k].predictive.score);
        closed(before, after).value.min(closed(calibrated, after).value)
    }

    /// What a candidate comes to for each signal, beside the twin as it is or calibrated: the one that leaves less in all.
    fn by_signal(&self, index: usize, before: &Score) -> Vec<SignalEvidence> {
        let [calibrated, after] = [0, index].map(|k| &self.candidates[k].predictive.score);
        let base = if calibrated.mean_square() < before.mean_square() { calibrated } else { before };
        let base = base.by_signal();
        let beyond_noise: Vec<Signal> = after.beyond_noise().collect();
        let of = |(signal, left): (Signal, f64)| {
            let begun = base.iter().find(|(other, _)| *other == signal);
            let closed = begun.map_or(0.0, |(_, begun)| closed_power(*begun, left));
            SignalEvidence { signal, after: left.sqrt(), closed, is_quiet: !beyond_noise.contains(&signal) }
        };
        after.by_signal().into_iter().map(of).collect()
    }

    /// The evidence for a candidate; `noise_is_measured` tells whether the noise was seen in the recording.
    pub(super) fn evidence(&self, index: usize, before: &Score, noise_is_measured: bool) -> Evidence {
        let candidate = &self.candidates[index];
        Evidence {
            names_effects: !candidate.effects().is_empty(),
            was_quiet: before.is_quiet(),
            gap_after: candidate.predictive.score.gap(),
            closed: self.share(index, before),
            signals: self.by_signal(index, before),
            training_before: self.candidates[0].training_gap,
            training_after: candidate.training_gap,
            noise_is_measured,
            probability: self.probability(candidate.effects()),
        }
    }

    /// Whether all effects of a candidate show, and little is left of the held-out runs. What is left of the training runs withholds the verdict, and lets the search look
    /// further ([`Candidate::is_adequate`]).
    pub(super) fn is_sufficient(&self, index: usize, before: &Score, noise_is_measured: bool) -> bool {
        let evidence = self.evidence(index, before, noise_is_measured);
        self.is_resolved(index) && evidence.explains_held_out(&self.limits)
    }

    /// Whether besides what the chosen explanation closes more is not worth naming, or what is left is a small gap.
    pub(super) fn leaves_nothing_to_name(
        &self,
        index: usize,
        before: &Score,
        noise_is_measured: bool,
    ) -> bool {
        let is_small = self.candidates[index].predictive.score.gap() <= self.limits.small_gap;
        self.is_sufficient(index, before, noise_is_measured)
            && (is_small || !self.loses_ground(index, before))
    }

    /// What the chosen explanation lacks of those that leave little of held-out and training runs: the fewest further effects, those first that leave least of
    /// the training runs.
    pub(super) fn missing_in_training(&self, before: &Score, noise_is_measured: bool) -> Vec<EffectSet> {
        let is_it = |&k: &usize| {
            let evidence = self.evidence(k, before, noise_is_measured);
            let is_fuller = self.candidates[k].effects().is_superset(self.effects());
            is_fuller && self.is_sound(k) && evidence.leaves_little(&self.limits)
        };
        let sufficient = (0..self.candidates.len()).filter(is_it);
        let mut all: Vec<&Candidate> = sufficient.map(|k| &self.candidates[k]).collect();
        let fewest = all.iter().map(|candidate| candidate.effects().len()).min().unwrap_or(0);
        all.retain(|candidate| candidate.effects().len() == fewest);
        all.sort_by(|a, b| a.training_gap.total_cmp(&b.training_gap));
        let further =
            |candidate: &Candidate| candidate.effects().difference(self.effects()).copied().collect();
        all.into_iter().map(further).collect()
    }

    /// Posterior probability that an effect acts.
    pub(super) fn probability_of(&self, effect: EffectId) -> f64 {
        self.probability(&EffectSet::from([effect]))
    }

    /// Posterior probability that all of these effects act.
    pub(super) fn probability(&self, effects: &EffectSet) -> f64 {
        let pairs = self.candidates.iter().zip(&self.posterior);
        let having = pairs.filter(|(candidate, _)| candidate.effects().is_superset(effects));
        let sum: f64 = having.map(|(_, probability)| probability).sum();
        // Not `min`: it would make certainty of what is not a number.
        if sum > 1.0 { 1.0 } else { sum }
    }

    /// Those of the chosen effects that act with the probability that decides, whatever acts beside them; none where that is all of them
    /// or no explanation.
    ///
    /// What of an explanation is certain is told as the cause where it leaves little: that several effects may make the rest does not make it
    /// uncertain.
    pub(super) fn certain(&self, machine: &Machine, decides: f64) -> Option<EffectSet> {
        let chosen = self.effects();
        let acts = |effect: &EffectId| self.probability_of(*effect) >= decides;
        let certain = with_modified(machine, chosen.iter().copied().filter(acts).collect());
        let is_part = !certain.is_empty() && certain.len() < chosen.len();
        (is_part && self.probability(&certain) >= decides).then_some(certain)
    }

    /// The explanation with all effects that act with the probability that decides, where those are the chosen ones and more.
    pub(super) fn all_certain(&self, machine: &Machine, decides: f64) -> Option<usize> {
        let all = self.candidates.iter().flat_map(|candidate| candidate.effects().iter().copied());
        let acts = |effect: &EffectId| self.probability_of(*effect) >= decides;
        let certain = with_modified(machine, all.filter(acts).collect());
        let is_more = certain.len() > self.effects().len() && certain.is_superset(self.effects());
        let index =
            if is_more && self.probability(&certain) >= decides { self.index(&certain) } else { None };
        index.filter(|&index| self.candidates[index].left() < self.candidates[self.chosen].left())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::conclude;
    use crate::diagnose::folds::Folds;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};
    use crate::diagnose::posterior::posterior;
    use crate::diagnose::rivals;
    use crate::machine::shipped;

    /// Some machine that is shipped.
    fn machine() -> Machine {
        shipped().next().unwrap()
    }

    /// Of 1e4 as it is, 101 calibrated and 3 with friction, friction closes 98 of 100 beside calibration.
    #[test]
    fn exact_a_signal_is_closed_beside_what_leaves_less_in_all() {
        let closed = |before: f64, calibrated: f64, left: f64| {
            let all = vec![candidate(&[], 0.0, calibrated), candidate(&[COULOMB], 1.0, left)];
            let of = found(all, 1).by_signal(1, &Score::even(before))[0];
            (of.signal, (of.closed * 1e6).round() / 1e6, (of.after.powi(2) * 1e6).round() / 1e6)
        };
        assert_eq!(closed(1e4, 101.0, 3.0), (Signal::Position, 0.98, 3.0));
        assert_eq!(closed(51.0, 101.0, 3.0), (Signal::Position, 0.96, 3.0));
        assert_eq!(closed(51.0, 0.9, 3.0), (Signal::Position, 0.0, 3.0));
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
        let folds = Folds { fits: vec![] };
        let (causes, _) = conclude::causes(&found, &before, &folds);
        assert_eq!(causes[0].confusable_with, ["load_dependent_friction"]);
        // One effect with two numbers, that leaves a little less, is a detail of one with a single number.
        let more = found.candidates[2].fit.hypothesis.free[0].clone();
        found.candidates[2].fit.hypothesis.free.push(more);
        assert!(found.is_refinement(2, &before));
    }

    /// Friction is in every explanation, what acts beside it differs: the friction is certain. Where each explanation has another effect,
    /// nothing is, and where one has the probability by itself, there is no part to take.
    #[test]
    fn exact_what_all_explanations_share_is_certain() {
        let certain = |sets: [&[EffectId]; 3], posterior: [f64; 3]| {
            let all = sets.map(|set| candidate(set, 1.0, 2.0));
            let mut found = found([candidate(&[], 0.0, 1e4)].into_iter().chain(all).collect(), 1);
            found.posterior = [0.0].into_iter().chain(posterior).collect();
            found.certain(&machine(), 0.7)
        };
        let delay = EffectId::LoopDelay;
        let shared: [&[EffectId]; 3] = [&[COULOMB, BACKLASH], &[COULOMB, delay], &[COULOMB]];
        assert_eq!(certain(shared, [0.5, 0.3, 0.2]), Some(EffectSet::from([COULOMB])));
        assert_eq!(certain(shared, [0.8, 0.1, 0.1]), None);
        assert_eq!(certain([&[COULOMB, BACKLASH], &[delay], &[COULOMB]], [0.4, 0.4, 0.2]), None);
    }

    /// Coulomb friction is chosen and leaves much. Backlash acts beside it with 0.9, whatever else does: both are told. With 0.6 it is not, and what leaves
    /// no less is not either.
    #[test]
    fn exact_all_that_is_certain_is_told() {
        let delay = EffectId::LoopDelay;
        let sets: [&[EffectId]; 3] = [&[COULOMB], &[COULOMB, BACKLASH], &[COULOMB, BACKLASH, delay]];
        let told = |posterior: [f64; 3], left: f64| {
            let own = sets.iter().zip([1e3, left, 1.0]).map(|(set, left)| candidate(set, 1.0, left));
            let mut found = found([candidate(&[], 0.0, 1e4)].into_iter().chain(own).collect(), 1);
            found.posterior = [0.0].into_iter().chain(posterior).collect();
            found.all_certain(&machine(), 0.7)
        };
        assert_eq!(told([0.1, 0.3, 0.6], 2.0), Some(2));
        assert_eq!(told([0.4, 0.3, 0.3], 2.0), None);
        assert_eq!(told([0.1, 0.3, 0.6], 2e3), None);
        assert_eq!(told([0.0, 0.2, 0.8], 2.0), Some(3));
    }

    /// Beside a gap of 100 × noise, what is certain and leaves 2.9 is told as the cause, whatever closes the rest. Where it leaves 3.1, an effect that
    /// closes half of that is worth naming, be it uncertain which one it is, and one that closes less is not.
    #[test]
    fn exact_what_is_certain_is_told_where_the_rest_need_not_be_named() {
        let before = Score::even(1e4);
        let told = |certain: f64, all: f64| {
            let of = |effects: &[EffectId], gap: f64| candidate(effects, 1.0, gap * gap);
            let all = vec![of(&[], 100.0), of(&[COULOMB], certain), of(&[COULOMB, BACKLASH], all)];
            found(all, 2).leaves_nothing_to_name(1, &before, true)
        };
        assert!(told(2.9, 1.3) && !told(3.1, 1.3) && told(3.1, 2.6));
        assert!(!told(40.0, 39.0));
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
        let folds = Folds { fits: vec![] };
        assert!(conclude::causes(&found, &before, &folds).0[0].confusable_with.is_empty());
        let rivals = rivals::open_rivals(&found, true);
        assert!(rivals.iter().all(|rival| rival.weight.is_finite()));
    }
}
