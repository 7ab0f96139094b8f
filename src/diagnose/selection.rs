//! Which effects: forward selection and backward elimination on held-out evidence.

use super::Progress;
use super::candidate::Candidate;
use super::cut::contradiction::StatedStretches;
use super::decide::Limits;
use super::estimate::Screen;
use super::evidence::Score;
use super::experiment::{HeldOut, Training};
use super::fit::{Care, Fit, Sensitivities, fit};
use super::floors::Floors;
use super::found::{Base, Found};
use super::hypothesis::{EffectSet, Hypothesis, has_modified, with_modified};
use super::motion;
use super::posterior::posterior;
use super::predictive::{Predictive, predictive};
use super::prior::MOST_EFFECTS;
use super::proposals::{Proposals, members};
use super::reached::Reached;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// What is asked of a fit.
type OfFit<'a> = dyn Fn(&Fit) -> Result<bool> + Sync + 'a;

/// What the search has to work with.
pub struct Search<'a> {
    /// The twin as it is.
    pub machine: &'a Machine,
    /// Runs that fits may see.
    pub training: &'a Training,
    /// Runs that only judge.
    pub held_out: &'a HeldOut,
    /// Noise floors.
    pub floors: &'a Floors,
    /// Effects that may be named.
    pub catalogue: &'a [EffectId],
    /// What the stretches of the signal path leave of the log, each replayed alone.
    pub stretches: &'a StatedStretches,
    /// What an earlier search found with another floor: its fits are where this one's start.
    pub earlier: Option<&'a Found>,
    /// Limits of the decision.
    pub limits: &'a Limits,
    /// Whether an explanation is wanted for what it predicts, and not for its names: what is found in part need not be certain then.
    pub for_prediction: bool,
    /// Told how far the fitting is.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Whether the noise floors of the twin of a fit are others than these. Asked of the first effect that leaves little of the gap; none where it was asked before.
    pub has_other_floors: Option<&'a OfFit<'a>>,
}

/// Of the hypotheses of one round, so many are fitted to the end.
const FINALISTS: usize = 4;
/// A fit to the end is taken to leave no less than this share of the mean square that a rough one leaves: of 72 on the measured runs of a ball screw
/// the least was 0.73. A choice of cost; what has a share of the posterior is fitted to the end in any case.
pub(super) const MOST_FALL: f64 = 0.5;
/// A share of the posterior below this changes no verdict.
pub(super) const LEAST_SHARE: f64 = 0.01;

impl Search<'_> {
    /// Runs the search.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn run(&self, before: &Score) -> Result<Reached> {
        let description = self.machine.description();
        let stated = EffectId::ALL.iter().copied().filter(|effect| description.effect.contains(*effect));
        let mut found = Found {
            candidates: Vec::new(),
            chosen: 0,
            posterior: Vec::new(),
            is_settled: false,
            not_borne_out: EffectSet::new(),
            stated: stated.collect(),
            bases: BTreeMap::new(),
            uncertainties: BTreeMap::new(),
            other_minima: BTreeMap::new(),
            limits: *self.limits,
        };
        let nothing = Hypothesis::new(self.machine, &EffectSet::new(), &Proposals::default(), &[]);
        (self.progress)(Progress::Asked(nothing.iter().len()));
        let calibrated = nothing.map(|h| self.evaluate(&h, None, Care::Thorough)).transpose()?;
        found.candidates.extend(calibrated);
        let mut widened = BTreeSet::new();
        if !self.climb_and_widen(&mut found, before, &mut widened)? {
            return Ok(Reached::OtherFloors(found));
        }
        if self.look_at_earlier(&mut found, before)? {
            self.climb_and_widen(&mut found, before, &mut widened)?;
        }
        self.continue_to_equals(&mut found)?;
        self.converge(&mut found, before, LEAST_SHARE)?;
        // Which explanations count beside the chosen one depends on it.
        for _ in 0..MOST_EFFECTS {
            let Some(decided) = found.decided(before) else { break };
            found.chosen = decided;
            found.posterior = posterior(&found, before);
        }
        self.settle_for_certain(&mut found, before)?;
        self.keep_what_is_borne_out(&mut found, before)?;
        // What is less probable than the twin as it is, calibrated, explains nothing.
        if found.posterior[found.chosen] < found.posterior[0] {
            found.chosen = 0;
            found.posterior = posterior(&found, before);
        }
        self.take_what_is_probable(&mut found, before);
        self.leave_out_what_a_form_leaves(&mut found, before)?;
        Ok(Reached::End(found))
    }

    /// Goes to better explanations, and widens the search, until nothing better is found. Tells whether the search goes on.
    fn climb_and_widen(
        &self,
        found: &mut Found,
        before: &Score,
        widened: &mut BTreeSet<EffectSet>,
    ) -> Result<bool> {
        for _ in 0..MOST_EFFECTS {
            if !self.climb(found, before)? {
                return Ok(false);
            }
            if self.go_to_a_better_minimum(found)? {
                continue;
            }
            if !self.widen(found, before, widened)? {
                break;
            }
        }
        Ok(true)
    }

    /// Goes from the chosen explanation to better ones step by step: adds effects, takes some away, puts others in their place. Tells whether the search goes on.
    fn climb(&self, found: &mut Found, before: &Score) -> Result<bool> {
        // Every explanation seen sharpens the weights of all: the steps are gone through until they change nothing.
        let mut settled = None;
        for _ in 0..MOST_EFFECTS {
            let sound = found.chosen;
            if !self.grow(found, before)? {
                return Ok(false);
            }
            // An effect that led on may have become superfluous.
            self.shrink(found, before)?;
            if !found.is_resolved(found.chosen) {
                // With another effect in the place of one of them every number may be inside.
                self.swap(found, before)?;
            }
            if !found.is_resolved(found.chosen) {
                // What led on has led nowhere: the best that was found on the way.
                found.chosen = sound;
                let all: Vec<usize> = (0..found.candidates.len()).collect();
                let sound: Vec<usize> = all.into_iter().filter(|&k| found.may_follow(k, before)).collect();
                found.chosen = found.best_of(&sound).unwrap_or(found.chosen);
                self.shrink(found, before)?;
            }
            self.swap(found, before)?;
            if settled == Some(found.chosen) {
                break;
            }
            settled = Some(found.chosen);
        }
        Ok(true)
    }

    /// The candidates with these sets of effects, fitted to the end; without those that cannot be looked at.
    pub(super) fn explored(&self, found: &mut Found, sets: &[EffectSet]) -> Result<Vec<usize>> {
        let indices = self.explore(found, sets, found.chosen)?;
        let open = indices.iter().copied().filter(|&k| !found.candidates[k].thorough).collect();
        self.fit_to_the_end(found, open)?;
        Ok(indices)
    }

    /// Makes a candidate ready to be built upon.
    pub(super) fn prepare(&self, found: &mut Found, index: usize) -> Result<()> {
        if !found.bases.contains_key(&index) {
            let fit = &found.candidates[index].fit;
            let sensitivities = fit.sensitivities(self.machine, self.training, &self.floors.common)?;
            let proposals = match self.earlier_base(found, index) {
                Some(base) => base.proposals.clone(),
                None => self.proposals(found, index, &sensitivities)?,
            };
            found.bases.insert(index, Base { sensitivities, proposals, is_paired: false });
        }
        Ok(())
    }

    /// Where the numbers of other effects may start beside a candidate.
    fn proposals(&self, found: &Found, index: usize, sensitivities: &Sensitivities) -> Result<Proposals> {
        let fit = &found.candidates[index].fit;
        let machine = fit.machine(self.machine)?;
        let screen = motion::screen(self.training.runs(), &machine)?;
        let effects = self.catalogue.iter().copied();
        let set = &fit.hypothesis.effects;
        let may_come = |e: &EffectId| !e.follows() || has_modified(self.machine, *e, set);
        let others = effects.filter(|e| !set.contains(e) && may_come(e));
        let mut proposals = Proposals::of(&screen, others.clone());
        let is_found = |e: &EffectId| members(*e).iter().all(|of| of == e || set.contains(of));
        for effect in others.filter(|e| e.follows() && is_found(e)) {
            proposals.add_together(effect, &self.bare_screen(&machine, set, effect)?);
        }
        // A cause may be below the level of the noise and leave residuals that are not white.
        if found.more_may_act(index) {
            let screened = proposals.clone();
            let (fine, waves) = rayon::join(
                || self.fine_periods(&screened, &machine, &screen),
                || self.add_waves(&mut proposals, fit, sensitivities, &screen),
            );
            waves?;
            fine?.into_iter().for_each(|(effect, starts)| proposals.add(effect, starts, Vec::new()));
            self.add_vibrations(&mut proposals, fit, &screen)?;
            self.add_modes(&mut proposals, fit, sensitivities, &screen)?;
        }
        Ok(proposals)
    }

    /// The motion as a twin sees it that has none of the found effects that one modifies.
    fn bare_screen(&self, machine: &Machine, found: &EffectSet, effect: EffectId) -> Result<Screen> {
        let modified = members(effect).into_iter().filter(|of| found.contains(of));
        let bare = modified.rev().try_fold(machine.clone(), |machine, of| machine.without_effect(of))?;
        motion::screen(self.training.runs(), &bare)
    }

    /// Looks at sets of effects, building on a candidate: those not looked at yet are fitted roughly, the best of
    /// all of them to the end. Returns the indices of those that can be looked at.
    pub(super) fn explore(&self, found: &mut Found, sets: &[EffectSet], from: usize) -> Result<Vec<usize>> {
        let fresh: BTreeSet<&EffectSet> = sets.iter().filter(|set| found.index(set).is_none()).collect();
        if !fresh.is_empty() {
            self.fit_roughly(found, fresh, from)?;
        }
        let indices: Vec<usize> = sets.iter().filter_map(|set| found.index(set)).collect();
        self.finish(found, &indices, from)?;
        Ok(indices)
    }

    /// Fits sets of effects that were not looked at yet, roughly, building on a candidate.
    fn fit_roughly(&self, found: &mut Found, fresh: BTreeSet<&EffectSet>, from: usize) -> Result<()> {
        self.prepare(found, from)?;
        let base = &found.bases[&from];
        let known = &found.candidates[from].fit;
        let hypotheses: Vec<Hypothesis> =
            fresh.into_iter().filter_map(|set| self.hypothesis(set, base, known, found)).collect();
        let rough = Care::Rough(&base.sensitivities);
        (self.progress)(Progress::Asked(hypotheses.len()));
        let best = self.earlier_best()?;
        let evaluated = |hypothesis: &Hypothesis| match self.hopeless(hypothesis, best.as_ref())? {
            Some(candidate) => Ok(candidate),
            None => self.evaluate(hypothesis, None, rough),
        };
        let fitted: Result<Vec<Candidate>> = hypotheses.par_iter().map(evaluated).collect();
        found.candidates.extend(fitted?);
        Ok(())
    }

    /// A hypothesis that begins where a known fit left its numbers, and where fits of the other subsets with one effect less left theirs: beside
    /// the known effects the screening may not see what the fit of such a subset has found.
    fn hypothesis(&self, set: &EffectSet, base: &Base, known: &Fit, found: &Found) -> Option<Hypothesis> {
        let earlier = self.earlier.and_then(|found| found.index(set).map(|k| &found.candidates[k].fit));
        let begun = |first: Option<&Fit>| {
            let fits = first.into_iter().chain([known]).map(|fit| (&fit.hypothesis, fit.values.as_slice()));
            Hypothesis::new(self.machine, set, &base.proposals, &fits.collect::<Vec<_>>())
        };
        let mut hypothesis = begun(earlier)?;
        let subsets = set.iter().filter_map(|effect| found.index(&self.without(set, [*effect])));
        for k in subsets {
            begun(Some(&found.candidates[k].fit)).into_iter().for_each(|other| hypothesis.inherit(other));
        }
        // The chosen explanation may have the numbers of these effects in another minimum, which is the right one beside the new effect too.
        let chosen = &found.candidates[found.chosen].fit;
        if chosen.is_elsewhere(known) {
            begun(Some(chosen))
                .into_iter()
                .for_each(|other| hypothesis.replace(other, &chosen.hypothesis.effects));
        }
        Some(hypothesis)
    }

    /// Fits to the end whatever has more than this share of the posterior: only what has converged is compared.
    pub(super) fn converge(&self, found: &mut Found, before: &Score, share: f64) -> Result<()> {
        // Each round fits at least one of them to the end.
        loop {
            found.posterior = posterior(found, before);
            let is_open = |k: &usize| !found.candidates[*k].thorough && found.posterior[*k] > share;
            let open: Vec<usize> = (0..found.candidates.len()).filter(is_open).collect();
            // Where calibration leaves no gap, no share changes the verdict.
            if open.is_empty() || found.calibration_settles() {
                return Ok(());
            }
            self.fit_to_the_end(found, open)?;
        }
    }

    /// Fits to the end those of the candidates that may matter: the best of those that have fewer effects or predict better than what they build on, and may come
    /// near the chosen one.
    fn finish(&self, found: &mut Found, indices: &[usize], from: usize) -> Result<()> {
        let own = found.likelihood(from);
        // The likelihood by a floor of its own is no sum of squares alone.
        let chosen = found.likelihood(found.chosen);
        let may_come_near =
            |k: usize| found.candidates[k].has_own_floor || MOST_FALL * found.likelihood(k) > chosen;
        let smaller = |k: usize| found.candidates[k].effects().len() < found.candidates[from].effects().len();
        let mut open: Vec<usize> = indices
            .iter()
            .copied()
            .filter(|&k| !found.candidates[k].thorough)
            .filter(|&k| smaller(k) || found.likelihood(k) > own + self.limits.log_odds())
            .filter(|&k| may_come_near(k))
            .collect();
        open.sort_by(|&a, &b| found.merit(b).total_cmp(&found.merit(a)));
        open.dedup();
        open.truncate(FINALISTS);
        self.fit_to_the_end(found, open)
    }

    pub(super) fn fit_to_the_end(&self, found: &mut Found, open: Vec<usize>) -> Result<()> {
        (self.progress)(Progress::Asked(open.len()));
        let better: Result<Vec<Candidate>> = open
            .par_iter()
            .map(|&k| {
                let fit = &found.candidates[k].fit;
                self.evaluate(&fit.hypothesis, Some(&fit.values), Care::Thorough)
            })
            .collect();
        for (&k, candidate) in open.iter().zip(better?) {
            found.candidates[k] = candidate;
        }
        self.nest(found, &open)?;
        self.take_own_gaps(found)
    }

    /// Tells that a hypothesis is fitted.
    pub(super) fn tell(&self, hypothesis: &Hypothesis) {
        let names: Vec<&str> = hypothesis.effects.iter().map(|e| e.name()).collect();
        (self.progress)(Progress::Fitted(&names.join(" + ")));
    }

    pub(super) fn evaluate(
        &self,
        hypothesis: &Hypothesis,
        warm: Option<&[f64]>,
        care: Care,
    ) -> Result<Candidate> {
        let fit = fit(self.machine, hypothesis, self.training, &self.floors.common, warm, care)?;
        self.tell(hypothesis);
        self.judge(fit, matches!(care, Care::Thorough))
    }

    /// Scores a fit on the held-out runs.
    pub(super) fn judge(&self, fit: Fit, thorough: bool) -> Result<Candidate> {
        let (score, has_own_floor) = self.floors.score(self.machine, &fit, self.held_out)?;
        let predictive = if thorough && !has_own_floor {
            predictive(self.machine, &fit, (self.training, self.held_out), &self.floors.common, &score)?
        } else {
            Predictive::of(score.clone())
        };
        let training_gap = self.floors.training_gap(self.machine, &fit, self.training, has_own_floor)?;
        let contradiction = self.stretches.contradiction(self.machine, &fit, self.training.runs())?;
        Ok(Candidate {
            fit,
            score,
            predictive,
            training_gap,
            has_own_floor,
            contradiction,
            own_gaps: None,
            thorough,
        })
    }

    /// Adds the best effect as long as that is beyond chance and material. Tells whether the search goes on.
    fn grow(&self, found: &mut Found, before: &Score) -> Result<bool> {
        while found.effects().len() < MOST_EFFECTS && found.has_material_left(before) {
            let indices = self.explore_larger(found, before)?;
            let fit_to = |next: &dyn Fn(usize) -> bool| -> Vec<usize> {
                indices.iter().copied().filter(|&index| next(index)).collect()
            };
            let next = found.best_of(&fit_to(&|index| found.may_follow(index, before)));
            let leads = found.best_of(&fit_to(&|index| found.may_lead_on(index, before)));
            let Some(best) = next.or(leads) else { break };
            found.chosen = best;
            if self.begins_anew(found, before)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Looks at the chosen set with one effect more, and then at those in which a feature comes with what it modifies. Such a pair is a detail of an explanation
    /// that it holds and that leaves nothing to name: it is not fitted then.
    fn explore_larger(&self, found: &mut Found, before: &Score) -> Result<Vec<usize>> {
        let (from, size) = (found.chosen, found.effects().len());
        let (single, pairs): (Vec<EffectSet>, Vec<EffectSet>) =
            self.larger(found.effects()).into_iter().partition(|set| set.len() == size + 1);
        let mut indices = self.explore(found, &single, from)?;
        let is_open = |set: &EffectSet| !found.holds_all_there_is(set, before);
        let open: Vec<EffectSet> = pairs.into_iter().filter(is_open).collect();
        indices.extend(self.explore(found, &open, from)?);
        Ok(indices)
    }

    /// The set with one effect more; a feature that would have nothing to modify comes with what it modifies.
    pub(super) fn larger(&self, set: &EffectSet) -> Vec<EffectSet> {
        let with = |effect: &EffectId| {
            let plus = |more: &[EffectId]| -> EffectSet { set.iter().chain(more).copied().collect() };
            if has_modified(self.machine, *effect, set) {
                return Some(plus(&[*effect]));
            }
            let modified = effect.modifies().iter().find(|of| self.catalogue.contains(of))?;
            (!effect.follows()).then(|| plus(&[*effect, *modified]))
        };
        self.catalogue.iter().filter(|effect| !set.contains(effect)).filter_map(with).collect()
    }

    /// Takes away effects that the others make superfluous, and features that are not worth naming.
    fn shrink(&self, found: &mut Found, before: &Score) -> Result<()> {
        while found.effects().len() > 1 {
            let smaller = self.subsets(found.effects());
            let indices = self.explore(found, &smaller, found.chosen)?;
            self.fit_from(found, &indices, found.chosen)?;
            // What was added beyond chance stays while it pays; more explanations seen since then change the weights. A feature
            // may have come with what it modifies, which alone was beyond chance.
            let superfluous = |index: &usize| {
                let taken = found.effects().difference(found.candidates[*index].effects());
                let is_detail = taken.copied().all(|e| !e.modifies().is_empty())
                    && !found.worth_naming(found.chosen, *index, before);
                found.merit(*index) >= found.merit(found.chosen) || is_detail
            };
            let indices: Vec<usize> = indices.into_iter().filter(superfluous).collect();
            let Some(best) = found.best_of(&indices) else { break };
            found.chosen = best;
        }
        Ok(())
    }

    /// Fits those of the candidates again that ended in a minimum which is not their least, as a fuller one shows; those that were only fitted
    /// roughly too, since it may be that minimum which made them look hopeless.
    fn fit_from(&self, found: &mut Found, indices: &[usize], fuller: usize) -> Result<()> {
        for &k in indices {
            let fuller = &found.candidates[fuller].fit;
            let fit = &found.candidates[k].fit;
            let floor = &self.floors.common;
            let Some(values) = fit.improved_by(fuller, self.machine, self.training, floor)? else { continue };
            (self.progress)(Progress::Asked(1));
            let again = self.evaluate(&fit.hypothesis, Some(&values), Care::Thorough)?;
            if again.fit.size < fit.size {
                found.candidates[k] = again;
            }
        }
        self.take_own_gaps(found)
    }

    /// The set without each of its members, and without the features that then have nothing to modify.
    pub(super) fn subsets(&self, set: &EffectSet) -> Vec<EffectSet> {
        let mut sets: Vec<EffectSet> = set.iter().map(|effect| self.without(set, [*effect])).collect();
        sets.dedup();
        sets
    }

    /// A set without some of its effects, and without the features that then have nothing to modify.
    pub(super) fn without(&self, set: &EffectSet, left: impl IntoIterator<Item = EffectId>) -> EffectSet {
        let left: EffectSet = left.into_iter().collect();
        with_modified(self.machine, set.difference(&left).copied().collect())
    }

    /// Puts every other effect in the place of each chosen one: what was found first may only have stood for another.
    fn swap(&self, found: &mut Found, before: &Score) -> Result<()> {
        let chosen = found.effects().clone();
        if chosen.len() < 2 {
            return Ok(());
        }
        for rest in self.subsets(&chosen) {
            let Some(from) = found.index(&rest) else { continue };
            let sets = self.larger(&rest);
            self.explore(found, &sets, from)?;
        }
        let rivals: Vec<usize> = (0..found.candidates.len())
            .filter(|&k| found.candidates[k].effects().len() <= chosen.len())
            .collect();
        let best = found.best_of(&rivals).filter(|&best| {
            found.is_sound(best)
                && found.merit(best) > found.merit(found.chosen) + self.limits.log_odds()
                && !found.loses_ground(best, before)
        });
        if let Some(best) = best {
            found.chosen = best;
        }
        Ok(())
    }
}
