//! Which effects: forward selection and backward elimination on held-out evidence.

use super::evidence::{Score, bootstrap};
use super::experiment::Experiment;
use super::fit::{Fit, fit};
use super::hypothesis::{EffectSet, Freedom, Hypothesis};
use super::noise::Floor;
use crate::effect::{EffectId, Screen};
use crate::error::Result;
use crate::machine::Machine;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A hypothesis fitted on training runs and scored on held-out runs.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The fit.
    pub fit: Fit,
    /// Its score on the held-out runs.
    pub score: Score,
}

impl Candidate {
    /// Its effects.
    pub fn effects(&self) -> &EffectSet {
        &self.fit.hypothesis.effects
    }
}

/// What the search has to work with.
pub struct Search<'a> {
    /// The twin as it is.
    pub machine: &'a Machine,
    /// Runs that fits may see.
    pub training: &'a [Experiment],
    /// Runs that only judge.
    pub held_out: &'a [Experiment],
    /// Noise floor.
    pub floor: &'a Floor,
    /// Start values.
    pub screen: &'a Screen,
    /// Effects that may be named.
    pub catalogue: &'a [EffectId],
    /// What an earlier search found with another floor: its fits are where this one's start.
    pub earlier: Option<&'a Found>,
    /// Told after every fitted hypothesis.
    pub progress: &'a (dyn Fn(&str) + Sync),
}

/// What the search found.
pub struct Found {
    /// Every hypothesis looked at; the first leaves the twin as it is but for calibration.
    pub candidates: Vec<Candidate>,
    /// Index of the chosen one.
    pub chosen: usize,
    /// Posterior probability of each candidate.
    pub posterior: Vec<f64>,
    /// Effects that may be named.
    catalogue: Vec<EffectId>,
}

/// An effect more must be worth this much log-likelihood: a prior of 1 in 100 for each effect.
pub const PRICE_PER_EFFECT: f64 = 4.605;
/// An improvement must pay its price in this share of bootstrap draws over blocks of the held-out runs: it must
/// not rest on one or two moments.
const CERTAIN: f64 = 0.95;
/// Below this gap an explanation is adequate: nothing is left that noise would not leave.
pub const ADEQUATE_GAP: f64 = 1.25;
/// Where no explanation is adequate, the twin stays structurally wrong whatever is added; an effect is then
/// named only if it closes this share of the original gap.
const MATERIAL_SHARE: f64 = 0.005;
/// More effects than this are not named at once.
const MOST_EFFECTS: usize = 5;

impl Search<'_> {
    /// Runs the search.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn run(&self, before: &Score) -> Result<Found> {
        let mut found = Found {
            candidates: Vec::new(),
            chosen: 0,
            posterior: Vec::new(),
            catalogue: self.catalogue.to_vec(),
        };
        self.add(&mut found, &[EffectSet::new()], None)?;
        for _ in 0..MOST_EFFECTS {
            self.grow(&mut found, before)?;
            self.shrink(&mut found)?;
            if !self.refine(&mut found, before)? {
                break;
            }
        }
        found.posterior = posterior(&found, before);
        Ok(found)
    }

    /// Fits and scores the sets that were not looked at yet; returns the indices of all of them.
    fn add(&self, found: &mut Found, sets: &[EffectSet], from: Option<usize>) -> Result<Vec<usize>> {
        let fresh: BTreeSet<&EffectSet> = sets.iter().filter(|set| found.index(set).is_none()).collect();
        let fresh: Vec<&EffectSet> = fresh.into_iter().collect();
        let known = from.map(|index| &found.candidates[index].fit);
        let fitted: Result<Vec<Candidate>> = fresh.par_iter().map(|set| self.evaluate(set, known)).collect();
        found.candidates.extend(fitted?);
        Ok(sets.iter().filter_map(|set| found.index(set)).collect())
    }

    fn evaluate(&self, effects: &EffectSet, known: Option<&Fit>) -> Result<Candidate> {
        let mut hypothesis = Hypothesis::new(self.machine, effects, self.screen);
        if let Some(known) = known {
            hypothesis.start_from(&known.hypothesis, &known.values);
        }
        let earlier = self.earlier.and_then(|found| found.index(effects).map(|k| &found.candidates[k].fit));
        let warm = earlier.map(|fit| fit.values.as_slice());
        let fit = fit(self.machine, &hypothesis, self.training, self.floor, warm)?;
        let machine = fit.machine(self.machine)?;
        let score = Score::of(&machine, self.held_out, self.floor)?;
        let names: Vec<&str> = effects.iter().map(|e| e.name()).collect();
        (self.progress)(&names.join(" + "));
        Ok(Candidate { fit, score })
    }

    /// Adds the best elementary effect as long as that is beyond chance and material.
    fn grow(&self, found: &mut Found, before: &Score) -> Result<()> {
        while found.effects().len() < MOST_EFFECTS {
            let current = found.effects().clone();
            let taken: Vec<EffectId> = current.iter().flat_map(|e| e.supersedes()).copied().collect();
            let sets: Vec<EffectSet> = self
                .catalogue
                .iter()
                .filter(|e| e.supersedes().is_empty() && !current.contains(e) && !taken.contains(e))
                .map(|e| current.iter().copied().chain([*e]).collect())
                .collect();
            let mut indices = self.add(found, &sets, Some(found.chosen))?;
            indices.retain(|&index| found.is_resolved(index));
            let Some(best) = found.best_of(&indices) else { break };
            let real = found.beyond_chance(best, found.chosen);
            if !real || !found.worth_naming(best, found.chosen, before) {
                break;
            }
            found.chosen = best;
        }
        Ok(())
    }

    /// Takes away effects that the others make superfluous.
    fn shrink(&self, found: &mut Found) -> Result<()> {
        while found.effects().len() > 1 {
            let smaller = subsets(found.effects());
            let indices = self.add(found, &smaller, Some(found.chosen))?;
            let Some(best) = found.best_of(&indices) else { break };
            if found.beyond_chance(found.chosen, best) {
                break;
            }
            found.chosen = best;
        }
        Ok(())
    }

    /// Tries laws that take over several elementary effects, alone and beside the rest.
    fn refine(&self, found: &mut Found, before: &Score) -> Result<bool> {
        for &law in self.catalogue.iter().filter(|e| !e.supersedes().is_empty()) {
            let current = found.effects().clone();
            if current.contains(&law) {
                continue;
            }
            let rest: EffectSet = current.iter().filter(|e| !law.supersedes().contains(e)).copied().collect();
            let full: EffectSet = rest.iter().copied().chain([law]).collect();
            let mut sets = subsets(&full);
            sets.retain(|set| set.contains(&law));
            sets.extend([full, EffectSet::from([law])]);
            let indices = self.add(found, &sets, Some(found.chosen))?;
            let Some(best) = found.best_of(&indices) else { continue };
            let plain = found.plain(best, law);
            self.add(found, &[plain], Some(found.chosen))?;
            let needed = found.is_needed(best, law);
            let better = found.merit(best) > found.merit(found.chosen);
            if needed && better && found.worth_naming(best, found.chosen, before) {
                found.chosen = best;
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// The set without each of its members.
fn subsets(set: &EffectSet) -> Vec<EffectSet> {
    set.iter().map(|left| set.iter().filter(|e| *e != left).copied().collect()).collect()
}

impl Found {
    fn effects(&self) -> &EffectSet {
        self.candidates[self.chosen].effects()
    }

    /// The candidate with exactly these effects.
    pub fn index(&self, set: &EffectSet) -> Option<usize> {
        self.candidates.iter().position(|candidate| candidate.effects() == set)
    }

    /// Best explanation so far; its residuals say how large and how correlated the unexplained part is.
    fn reference(&self) -> &Score {
        reference(&self.candidates)
    }

    /// Log-likelihood less the price of the effects.
    fn merit(&self, index: usize) -> f64 {
        let total: f64 = self.candidates[index].score.log_likelihoods(self.reference()).iter().sum();
        total - PRICE_PER_EFFECT * self.candidates[index].effects().len() as f64
    }

    /// A candidate's effects with what a law generalises in the law's place, as far as that may be named.
    fn plain(&self, index: usize, law: EffectId) -> EffectSet {
        let general = law.supersedes().iter().filter(|e| self.catalogue.contains(e));
        self.candidates[index].effects().iter().filter(|e| **e != law).chain(general).copied().collect()
    }

    /// Whether every effect of a candidate has a parameter whose 95 % interval leaves out the twin's own value.
    fn is_resolved(&self, index: usize) -> bool {
        let fit = &self.candidates[index].fit;
        let resolved = |effect: &EffectId| {
            fit.hypothesis.free.iter().enumerate().any(|(k, free)| {
                let away = (fit.values[k] - free.neutral).abs();
                free.effect == *effect
                    && free.freedom == Freedom::Cause
                    && away > 1.96 * fit.standard_errors[k]
            })
        };
        fit.hypothesis.effects.iter().all(resolved)
    }

    /// Whether a law that generalises others beats every set of those others that was looked at: if it does not,
    /// its extra freedom says nothing and the simpler effects stand for it.
    fn is_needed(&self, index: usize, law: EffectId) -> bool {
        let plain = self.plain(index, law);
        let simpler = self.candidates.iter().enumerate().filter(|(_, c)| c.effects().is_subset(&plain));
        simpler.map(|(k, _)| k).all(|simple| self.beyond_chance(index, simple))
    }

    /// Whether a candidate predicts better than the chosen one by less than is worth naming: a detail that only
    /// shows once the chosen effects are in the twin, not a rival of them.
    pub fn is_refinement(&self, index: usize, before: &Score) -> bool {
        let (other, chosen) = (&self.candidates[index].score, &self.candidates[self.chosen].score);
        index != self.chosen
            && other.mean_square() < chosen.mean_square()
            && !self.worth_naming(index, self.chosen, before)
    }

    fn best_of(&self, indices: &[usize]) -> Option<usize> {
        indices.iter().copied().max_by(|&a, &b| self.merit(a).total_cmp(&self.merit(b)))
    }

    /// Whether candidate `a` explains the held-out runs better than `b` by more than its extra effects cost and
    /// does so wherever the held-out runs are looked at.
    fn beyond_chance(&self, a: usize, b: usize) -> bool {
        let reference = self.reference();
        let gains: Vec<f64> = self.candidates[a]
            .score
            .log_likelihoods(reference)
            .iter()
            .zip(self.candidates[b].score.log_likelihoods(reference))
            .map(|(a, b)| a - b)
            .collect();
        let more = self.candidates[a].effects().len() as f64 - self.candidates[b].effects().len() as f64;
        let price = PRICE_PER_EFFECT * more.max(1.0);
        let pays = |weights: &[f64]| gains.iter().zip(weights).map(|(g, w)| g * w).sum::<f64>() > price;
        let draws = bootstrap(gains.len(), DRAWS);
        let paid = draws.iter().filter(|weights| pays(weights)).count();
        gains.iter().sum::<f64>() > price && paid as f64 >= CERTAIN * draws.len() as f64
    }

    /// Whether the step from `b` to `a` matters: it makes the explanation adequate, or closes a material share.
    fn worth_naming(&self, a: usize, b: usize, before: &Score) -> bool {
        let (after, now) = (&self.candidates[a].score, &self.candidates[b].score);
        let gained = now.mean_square() - after.mean_square();
        after.gap() <= ADEQUATE_GAP || gained >= MATERIAL_SHARE * (before.mean_square() - 1.0)
    }
}

fn reference(candidates: &[Candidate]) -> &Score {
    let least = |a: &&Candidate, b: &&Candidate| a.score.mean_square().total_cmp(&b.score.mean_square());
    // There is always the candidate that leaves the twin as it is.
    candidates.iter().min_by(least).map_or(&candidates[0].score, |candidate| &candidate.score)
}

/// Draws of the bootstrap over which the posterior is averaged.
const DRAWS: usize = 200;

/// Posterior probabilities of the candidates: likelihood times prior, averaged over a bootstrap of the
/// held-out blocks, so that evidence resting on a few blocks counts less.
fn posterior(found: &Found, before: &Score) -> Vec<f64> {
    let candidates = &found.candidates;
    let best = reference(candidates);
    let stands: Vec<bool> = (0..candidates.len())
        .map(|index| {
            let mut laws = candidates[index].effects().iter().filter(|e| !e.supersedes().is_empty());
            laws.all(|&law| found.is_needed(index, law)) && !found.is_refinement(index, before)
        })
        .collect();
    let blocks: Vec<Vec<f64>> = candidates.iter().map(|c| c.score.log_likelihoods(best)).collect();
    let mut sum = vec![0.0; candidates.len()];
    for weights in bootstrap(best.blocks(), DRAWS) {
        let merits: Vec<f64> = candidates
            .iter()
            .zip(&blocks)
            .zip(&stands)
            .map(|((candidate, block), stands)| {
                if !stands {
                    return f64::NEG_INFINITY;
                }
                let likelihood: f64 = block.iter().zip(&weights).map(|(l, w)| l * w).sum();
                likelihood - PRICE_PER_EFFECT * candidate.effects().len() as f64
            })
            .collect();
        let most = merits.iter().copied().fold(f64::MIN, f64::max);
        let total: f64 = merits.iter().map(|m| (m - most).exp()).sum();
        for (sum, merit) in sum.iter_mut().zip(&merits) {
            *sum += (merit - most).exp() / total;
        }
    }
    sum.into_iter().map(|s| s / DRAWS as f64).collect()
}
