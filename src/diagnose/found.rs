//! What a search has found so far, and how explanations are compared.

use super::candidate::Candidate;
use super::decide::{Limits, above_noise};
use super::evidence::{Score, bootstrap};
use super::fit::Sensitivities;
use super::hypothesis::EffectSet;
use super::prior::{PRICE_PER_EFFECT, overwhelming, price};
use super::proposals::Proposals;
use super::thresholds::{ADEQUATE_GAP, LARGELY, MOST, SIGNIFICANCE};
use super::uncertainty::Uncertainty;
use std::collections::BTreeMap;

/// What the search found.
pub struct Found {
    /// Every hypothesis looked at; the first leaves the twin as it is but for calibration.
    pub candidates: Vec<Candidate>,
    /// Index of the chosen one.
    pub chosen: usize,
    /// Posterior probability of each candidate.
    pub posterior: Vec<f64>,
    /// Whether the twin as it is leaves no gap: what predicts better still explains what is not there.
    pub(super) is_settled: bool,
    /// Effects whose size scatters from run to run as if they were not there.
    pub(super) not_borne_out: EffectSet,
    /// Effects that the twin has already.
    pub(super) stated: EffectSet,
    /// What fits that build on a candidate need of it.
    pub(super) bases: BTreeMap<usize, Base>,
    /// How uncertain candidates are, of those where it was asked.
    pub(super) uncertainties: BTreeMap<usize, Uncertainty>,
    /// Other minima of candidates that were chosen.
    pub(super) other_minima: BTreeMap<usize, Vec<Vec<f64>>>,
    /// Limits of the decision.
    pub(super) limits: Limits,
}

/// What fits that build on a candidate need of it: its sensitivities, where other effects start beside it, and whether pairs of them were looked at.
pub(super) struct Base {
    pub(super) sensitivities: Sensitivities,
    pub(super) proposals: Proposals,
    pub(super) is_paired: bool,
}

impl Found {
    pub(super) fn effects(&self) -> &EffectSet {
        self.candidates[self.chosen].effects()
    }

    /// The candidate with exactly these effects.
    pub fn index(&self, set: &EffectSet) -> Option<usize> {
        self.candidates.iter().position(|candidate| candidate.effects() == set)
    }

    /// Best explanation so far; its residuals say how large and how correlated the unexplained part is.
    pub fn reference(&self) -> &Score {
        reference(&self.candidates)
    }

    pub(super) fn likelihood(&self, index: usize) -> f64 {
        self.candidates[index].log_likelihoods(self.reference()).iter().sum()
    }

    /// Log-likelihood less the price of the effects.
    pub(super) fn merit(&self, index: usize) -> f64 {
        let candidate = &self.candidates[index];
        self.likelihood(index) - price(candidate.effects(), &self.stated) - candidate.fit.strain()
    }

    /// Whether the twin leaves of the held-out runs what noise leaves: as it is, or calibrated inside its tolerances where no cause predicts overwhelmingly
    /// better. What noise leaves is no more than what the best explanation leaves: stated noise may be too large.
    pub(super) fn is_quiet(&self, before: &Score) -> bool {
        let is_noise = before.mean_square() <= ADEQUATE_GAP.powi(2) * self.reference().mean_square();
        (before.is_quiet() && (is_noise || !self.overwhelms())) || self.calibration_settles()
    }

    /// Whether the calibrated twin does.
    pub(super) fn calibration_settles(&self) -> bool {
        !self.candidates.is_empty() && self.predicts_to_noise(0) && !self.overwhelms()
    }

    /// Whether a cause is chosen though the calibrated twin leaves what noise leaves: by likelihood alone.
    pub(super) fn is_by_likelihood(&self) -> bool {
        self.chosen != 0 && self.predicts_to_noise(0)
    }

    /// Whether the chosen cause predicts overwhelmingly better than the calibrated twin, and closes more than a tenth of the power that this leaves: with
    /// many samples a likelihood tells less than the form of a law, the steps of a replay and constants that are not calibrated are known to.
    fn overwhelms(&self) -> bool {
        self.chosen != 0
            && self.likelihood(self.chosen) - self.likelihood(0) > overwhelming()
            && self.beyond_chance(self.chosen, 0)
            && self.left(self.chosen) < LARGELY * self.left(0)
    }

    /// Mean square that a candidate leaves.
    pub(super) fn left(&self, index: usize) -> f64 {
        self.candidates[index].left()
    }

    pub(super) fn is_adequate(&self, index: usize) -> bool {
        self.candidates[index].is_adequate()
    }

    /// Whether a candidate leaves noise of each signal of the held-out runs, whatever it leaves of the training runs.
    pub(super) fn predicts_to_noise(&self, index: usize) -> bool {
        self.candidates[index].predictive.score.is_quiet()
    }

    /// Whether a candidate may take the chosen one's place.
    pub(super) fn may_follow(&self, index: usize, before: &Score) -> bool {
        index != self.chosen
            && self.candidates[index].thorough
            && self.is_resolved(index)
            && self.beyond_chance(index, self.chosen)
            && self.worth_naming(index, self.chosen, before)
    }

    /// Whether a candidate explains most of what is open, though a number of it ran off or an effect found before does not show
    /// any more: with what is missing beside it, the one may be found inside, and the other be taken out. Beside what leaves noise nothing need be missing.
    pub(super) fn may_lead_on(&self, index: usize, before: &Score) -> bool {
        let open = |k: usize| (self.candidates[k].left() - 1.0).max(0.0);
        index != self.chosen
            && !self.is_adequate(self.chosen)
            && self.candidates[index].thorough
            && open(index) < MOST * open(self.chosen)
            && self.beyond_chance(index, self.chosen)
            && self.worth_naming(index, self.chosen, before)
    }

    /// The explanation that has the probability that decides, where it is not the chosen one. One that has the chosen effects and more
    /// must be worth naming: what it adds pays its price in most draws, if not in as many as a step of the search asks for.
    pub(super) fn decided(&self, before: &Score) -> Option<usize> {
        let most = self.most_probable();
        // What does not show has no probability of its own and gives way to whatever is most probable.
        if self.posterior[most] < self.limits.probability && self.is_resolved(self.chosen) {
            return None;
        }
        let (set, own) = (self.candidates[most].effects(), self.effects());
        let is_other = most != self.chosen && !own.is_empty() && !set.is_empty();
        (is_other && self.is_sound(most) && self.is_worth_it(most, before)).then_some(most)
    }

    pub(super) fn most_probable(&self) -> usize {
        let by_probability = |&a: &usize, &b: &usize| self.posterior[a].total_cmp(&self.posterior[b]);
        (0..self.candidates.len()).max_by(by_probability).unwrap_or(self.chosen)
    }

    /// Whether what a candidate has more than the chosen explanation is worth naming, where it has all of that.
    fn is_worth_it(&self, index: usize, before: &Score) -> bool {
        let is_fuller = self.candidates[index].effects().is_superset(self.effects());
        !is_fuller || self.worth_naming(index, self.chosen, before)
    }

    /// Whether a candidate was fitted to the end, and all of its effects show.
    pub(super) fn is_sound(&self, index: usize) -> bool {
        self.candidates[index].thorough && self.is_resolved(index)
    }

    /// The explanation that has more merit than the chosen one, most of all that there are; one that has the chosen effects and more must
    /// be worth naming.
    pub(super) fn better(&self, before: &Score) -> Option<usize> {
        let least = self.merit(self.chosen) + self.limits.log_odds();
        let may_be = |k: usize| k != self.chosen && self.is_sound(k) && self.is_worth_it(k, before);
        let better: Vec<usize> =
            (0..self.candidates.len()).filter(|&k| may_be(k) && self.merit(k) > least).collect();
        self.best_of(&better)
    }

    /// Whether the chosen explanation leaves so much open that closing it may be worth naming.
    pub(super) fn has_material_left(&self, before: &Score) -> bool {
        self.leaves_material(self.chosen, before) || self.candidates[self.chosen].may_hide_another()
    }

    fn leaves_material(&self, index: usize, before: &Score) -> bool {
        let left = self.candidates[index].left();
        index == 0
            || !self.is_adequate(index)
            || left - 1.0 > self.limits.open_share * self.uncalibrated(before)
    }

    /// Whether a set holds all effects of an explanation that leaves nothing worth naming: what it has more is a detail.
    pub(super) fn holds_all_there_is(&self, set: &EffectSet, before: &Score) -> bool {
        let is_held = |k: usize| self.candidates[k].effects().is_subset(set);
        (1..self.candidates.len()).any(|k| is_held(k) && self.is_sound(k) && !self.leaves_material(k, before))
    }

    /// Whether a candidate leaves more open than the chosen one, by as much as is worth naming.
    pub(super) fn loses_ground(&self, index: usize, before: &Score) -> bool {
        self.worth_naming(self.chosen, index, before) && !self.is_adequate(index)
    }

    /// Whether every effect of a candidate shows (see [`Fit::shown`]), and no number went to the end of where a fit may look.
    pub(super) fn is_resolved(&self, index: usize) -> bool {
        self.candidates[index].is_resolved()
    }

    /// Whether a candidate predicts better than the chosen one by less than is worth naming: a detail that only
    /// shows once the chosen effects are in the twin, not a rival of them.
    /// Beside a twin that leaves no gap, whatever predicts better is one.
    pub fn is_refinement(&self, index: usize, before: &Score) -> bool {
        if self.is_settled {
            return index != self.chosen && self.likelihood(index) > self.likelihood(self.chosen);
        }
        let (other, chosen) = (&self.candidates[index], &self.candidates[self.chosen]);
        let (more, own) = (self.candidates[index].effects(), self.effects());
        let numbers = |k: usize| self.candidates[k].fit.hypothesis.numbers();
        let is_fuller = more.len() > own.len() || numbers(index) > numbers(self.chosen);
        // Beside an explanation that leaves nothing open, whatever does as well is its rival; so is another one as simple,
        // in effects and in numbers.
        index != self.chosen
            && is_fuller
            && !self.is_adequate(self.chosen)
            && other.left() < chosen.left()
            && !self.worth_naming(index, self.chosen, before)
    }

    /// Whether a candidate has the chosen effects, which leave no more than noise, and others beside them that are not worth naming.
    pub(super) fn is_detail(&self, index: usize, before: &Score) -> bool {
        index != self.chosen
            && !self.effects().is_empty()
            && self.is_adequate(self.chosen)
            && !self.is_worth_it(index, before)
    }

    /// Largest log-likelihood of an explanation that is identified. What is not identified has no share where it predicts no better: a number at its
    /// bound says that something is missing beside it, and there nothing is.
    pub(super) fn identified(&self) -> f64 {
        let sound = (0..self.candidates.len()).filter(|&k| self.is_sound(k));
        sound.map(|k| self.likelihood(k)).fold(f64::NEG_INFINITY, f64::max)
    }

    pub(super) fn best_of(&self, indices: &[usize]) -> Option<usize> {
        indices.iter().copied().max_by(|&a, &b| self.merit(a).total_cmp(&self.merit(b)))
    }

    /// Whether candidate `a` explains the held-out runs better than `b` by more than its extra effects cost and
    /// does so wherever the held-out runs are looked at.
    pub(super) fn beyond_chance(&self, a: usize, b: usize) -> bool {
        let reference = self.reference();
        let gains: Vec<f64> = self.candidates[a]
            .log_likelihoods(reference)
            .iter()
            .zip(self.candidates[b].log_likelihoods(reference))
            .map(|(a, b)| a - b)
            .collect();
        let more = self.candidates[a].effects().len() as f64 - self.candidates[b].effects().len() as f64;
        let price = PRICE_PER_EFFECT * more.max(1.0);
        let pays = |weights: &[f64]| gains.iter().zip(weights).map(|(g, w)| g * w).sum::<f64>() > price;
        let draws = bootstrap(gains.len(), DRAWS);
        let paid = draws.iter().filter(|weights| pays(weights)).count();
        // Not resting on one or two moments: in so many draws over blocks of the held-out runs.
        gains.iter().sum::<f64>() > price && paid as f64 >= (1.0 - SIGNIFICANCE) * draws.len() as f64
    }

    /// Whether the step from `b` to `a` matters: it makes an explanation adequate that was not, of the held-out runs, closes more of the gap than may stay
    /// open, or most of what `b` leaves of the held-out runs or of those that it was fitted to: a large gap must not hide a small cause that is most of the rest. It matters,
    /// too, where `b` leaves noise and is no explanation beside `a` (see [`supersedes`](Self::supersedes)).
    pub(super) fn worth_naming(&self, a: usize, b: usize, before: &Score) -> bool {
        let [after, now] = [a, b].map(|k| &self.candidates[k].predictive.score);
        let gained = now.mean_square() - after.mean_square();
        let is_most_of_rest = gained >= MOST * (now.mean_square() - 1.0);
        let of_rest = !now.is_adequate() && (after.is_adequate() || is_most_of_rest);
        of_rest
            || self.closes_training(a, b)
            || gained >= self.limits.open_share * self.uncalibrated(before)
            || self.supersedes(a, b, before)
    }

    /// Whether `a` closes most of what `b` leaves of the training runs, where that is more than noise. Any number more leaves a little less there.
    fn closes_training(&self, a: usize, b: usize) -> bool {
        let [left, begun] = [a, b].map(|k| above_noise(self.candidates[k].training_gap));
        self.candidates[b].training_gap > ADEQUATE_GAP && left <= (1.0 - MOST) * begun
    }

    /// What calibration leaves open, as mean square above noise: the gap that causes are measured by.
    pub(super) fn uncalibrated(&self, before: &Score) -> f64 {
        self.candidates[0].left().min(before.mean_square()) - 1.0
    }
}

fn reference(candidates: &[Candidate]) -> &Score {
    let least = |a: &&Candidate, b: &&Candidate| a.left().total_cmp(&b.left());
    // There is always the candidate that leaves the twin as it is.
    let best = candidates.iter().min_by(least).unwrap_or(&candidates[0]);
    &best.predictive.score
}

/// Draws of the bootstrap over which the posterior is averaged.
pub(super) const DRAWS: usize = 200;

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::diagnose::fit::Fit;
    use crate::diagnose::free::Free;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::tests::hypothesis;
    use crate::diagnose::predictive::Predictive;
    use crate::effect::EffectId;

    pub(in crate::diagnose) const COULOMB: EffectId = EffectId::CoulombFriction;
    pub(in crate::diagnose) const BACKLASH: EffectId = EffectId::Backlash;

    /// An explanation with one number per effect, in −10 to 10, that leaves this mean square; all of them show.
    pub(in crate::diagnose) fn candidate(effects: &[EffectId], value: f64, mean_square: f64) -> Candidate {
        let effects: EffectSet = effects.iter().copied().collect();
        let free: Vec<Free> = effects.iter().map(|effect| number(*effect, "n")).collect();
        let fit = Fit {
            values: vec![value; free.len()],
            size: 0.0,
            mean_square,
            standard_errors: vec![0.1; free.len()],
            covariance: nalgebra::DMatrix::from_diagonal_element(free.len(), free.len(), 0.01),
            shown: effects,
            hypothesis: hypothesis(free),
        };
        let score = Score::even(mean_square);
        let predictive = Predictive::of(score.clone());
        let training_gap = mean_square.sqrt();
        Candidate {
            fit,
            score,
            predictive,
            training_gap,
            has_own_floor: false,
            contradiction: None,
            own_gaps: None,
            thorough: true,
        }
    }

    pub(in crate::diagnose) fn found(candidates: Vec<Candidate>, chosen: usize) -> Found {
        Found {
            candidates,
            chosen,
            posterior: vec![],
            is_settled: false,
            not_borne_out: EffectSet::new(),
            stated: EffectSet::new(),
            bases: BTreeMap::new(),
            uncertainties: BTreeMap::new(),
            other_minima: BTreeMap::new(),
            limits: Limits::default(),
        }
    }

    /// Beside a gap of 100, what closes half of the rest is named, what closes 0.1 % of all is named, and less is not.
    #[test]
    fn exact_what_closes_half_of_the_rest_is_worth_naming() {
        let before = Score::even(1e4);
        let worth = |rest: f64, left: f64| {
            let pair = candidate(&[COULOMB, BACKLASH], 1.0, left);
            let all = vec![candidate(&[], 0.0, 1e4), candidate(&[COULOMB], 1.0, rest), pair];
            found(all, 1).may_follow(2, &before)
        };
        assert!(worth(11.0, 5.9) && !worth(11.0, 6.1));
        assert!(worth(101.0, 90.9) && !worth(101.0, 91.1));
    }

    /// Beside a gap of 100, friction that leaves 1.2 × noise, and shows, leaves nothing to name to what holds it; friction that leaves 1.3 does.
    #[test]
    fn exact_what_holds_all_there_is_is_a_detail() {
        let before = Score::even(1e4);
        let holds = |left: f64, set: &[EffectId]| {
            let all = vec![candidate(&[], 0.0, 1e4), candidate(&[COULOMB], 1.0, left)];
            found(all, 0).holds_all_there_is(&set.iter().copied().collect(), &before)
        };
        let pair = [COULOMB, EffectId::StribeckFriction];
        assert!(holds(1.44, &pair) && !holds(1.69, &pair) && !holds(1.44, &[BACKLASH]));
    }

    /// A number at the end of its range is no finding, but its effect may lead on where it explains most of what is open.
    #[test]
    fn exact_a_number_that_runs_off_leads_on_and_is_no_finding() {
        let before = Score::even(1e4);
        let step = |value: f64, left: f64| {
            let found = found(vec![candidate(&[], 0.0, 1e4), candidate(&[COULOMB], value, left)], 0);
            [found.may_follow(1, &before), found.may_lead_on(1, &before)]
        };
        assert_eq!(step(1.0, 100.0), [true, true]);
        assert_eq!(step(10.0, 100.0), [false, true]);
        assert_eq!(step(10.0, 6000.0), [false, false]);
        assert_eq!(step(-10.0, 100.0), [false, true]);
    }

    /// Beside a gap of 1000, friction that predicts the held-out runs to 1.05 × noise and leaves 3.5 × of its own runs is not all there is: what takes both to the
    /// noise is worth naming, and no detail of it.
    #[test]
    fn exact_what_its_own_runs_refute_is_not_all_there_is() {
        let before = Score::even(1e6);
        let beside = |training_gap: f64| {
            let friction = Candidate { training_gap, ..candidate(&[COULOMB], 1.0, 1.1) };
            let all = vec![candidate(&[], 0.0, 1e6), friction, candidate(&[COULOMB, BACKLASH], 1.0, 1.0)];
            let found = found(all, 1);
            [found.has_material_left(&before), found.may_follow(2, &before), found.is_detail(2, &before)]
        };
        assert_eq!(beside(1.2), [false, false, true]);
        assert_eq!(beside(3.5), [true, true, false]);
    }

    /// Beside friction that predicts the held-out runs to 0.9 × noise and leaves 3.5 × of its own runs, what leaves a little more of both is neither worth naming
    /// nor leads on, and what leaves 3.4 × of these for one number more is a detail.
    #[test]
    fn exact_what_closes_nothing_of_its_own_runs_is_not_worth_naming() {
        let before = Score::even(1e6);
        let of = |left: f64, training_gap: f64| {
            let friction = Candidate { training_gap: 3.5, ..candidate(&[COULOMB], 1.0, 0.81) };
            let pair = Candidate { training_gap, ..candidate(&[COULOMB, BACKLASH], 1.0, left) };
            let found = found(vec![candidate(&[], 0.0, 1e6), friction, pair], 1);
            [found.worth_naming(2, 1, &before), found.may_lead_on(2, &before)]
        };
        assert_eq!(
            [of(0.85, 3.6), of(0.8, 3.4), of(0.8, 1.2)],
            [[false, false], [false, false], [true, false]]
        );
    }

    /// Of a range over nine decades a number a thousand times the lower end is inside, and one at that end is not.
    #[test]
    fn exact_a_soft_bristle_is_inside_a_range_of_decades() {
        let runs_off = |value: f64| {
            let mut soft = candidate(&[COULOMB], value, 100.0);
            soft.fit.hypothesis.free[0].range = (8.0, 8e9);
            soft.unidentified().is_some()
        };
        assert_eq!([8.0, 7000.0, 8080.0, 8e9].map(runs_off), [true, false, false, true]);
    }

    /// The explanation that has the probability that decides is taken, one with more effects where they are worth naming.
    #[test]
    fn exact_the_decided_explanation_is_taken() {
        let before = Score::even(1e4);
        let taken = |other: Candidate, share: f64| {
            let all = vec![candidate(&[], 0.0, 1e4), candidate(&[COULOMB], 1.0, 100.0), other];
            let mut found = found(all, 1);
            found.posterior = vec![0.0, 1.0 - share, share];
            found.decided(&before)
        };
        let pair = |value: f64, left: f64| candidate(&[COULOMB, BACKLASH], value, left);
        assert_eq!(taken(pair(1.0, 40.0), 0.8), Some(2));
        assert_eq!(taken(pair(1.0, 40.0), 0.6), None);
        assert_eq!(taken(pair(1.0, 99.0), 0.8), None);
        assert_eq!(taken(pair(10.0, 40.0), 0.8), None);
        let other = |share: f64| taken(candidate(&[BACKLASH], 1.0, 40.0), share);
        assert_eq!([other(0.8), other(0.6)], [Some(2), None]);
        assert_eq!(taken(candidate(&[BACKLASH], 10.0, 40.0), 0.8), None);
        assert_eq!(taken(candidate(&[], 1.0, 40.0), 0.8), None);
    }

    /// What has more merit takes the chosen one's place; more effects only where they are worth naming, and none with a number that ran off.
    #[test]
    fn exact_the_better_explanation_is_taken() {
        let before = Score::even(1e4);
        let better = |other: Candidate| {
            let all = vec![candidate(&[], 0.0, 1e4), candidate(&[COULOMB], 1.0, 100.0), other];
            found(all, 1).better(&before)
        };
        assert_eq!(better(candidate(&[BACKLASH], 1.0, 40.0)), Some(2));
        assert_eq!(better(candidate(&[BACKLASH], 1.0, 101.0)), None);
        assert_eq!(better(candidate(&[BACKLASH], 10.0, 40.0)), None);
        let pair = |left: f64| candidate(&[COULOMB, BACKLASH], 1.0, left);
        assert_eq!([better(pair(40.0)), better(pair(95.0))], [Some(2), None]);
    }

    /// A twin as it is that leaves the noise has no gap, however much better a cause follows its course; where the noise is really half of what is
    /// stated, there is one.
    #[test]
    fn exact_what_leaves_no_more_than_the_noise_has_no_gap() {
        let is_quiet = |before: f64, left: f64| {
            let all = vec![candidate(&[], 0.0, before), candidate(&[COULOMB], 1.0, left)];
            found(all, 1).is_quiet(&Score::even(before))
        };
        assert!(is_quiet(1.0, 0.9) && is_quiet(1.5, 1.0));
        assert!(!is_quiet(1.6, 1.0) && !is_quiet(1.0, 0.5));
    }

    /// A cause beside a calibrated twin that leaves noise stands by its likelihood; beside one that leaves more by what it closes.
    #[test]
    fn exact_a_cause_beside_noise_stands_by_its_likelihood() {
        let of = |calibrated: f64, chosen: usize| {
            let all = vec![candidate(&[], 0.0, calibrated), candidate(&[COULOMB], 1.0, 1.0)];
            found(all, chosen).is_by_likelihood()
        };
        assert!(of(1.05, 1) && !of(1.7, 1) && !of(1.05, 0));
    }

    /// A calibrated twin that leaves no gap settles it, unless a cause predicts overwhelmingly better and closes more than a tenth of what is left.
    #[test]
    fn exact_calibration_settles_but_against_overwhelming_evidence() {
        let settles = |calibrated: f64, left: f64| {
            found(vec![candidate(&[], 0.0, calibrated), candidate(&[COULOMB], 1.0, left)], 1)
                .calibration_settles()
        };
        // 2000 samples: a hundredth of the mean square is worth 10 of log-likelihood.
        assert!(settles(1.0, 0.99) && settles(1.0, 0.91) && settles(1.05, 1.05));
        assert!(!settles(1.0, 0.89) && settles(1.5, 1.5) && !settles(1.6, 1.6));
    }
}
