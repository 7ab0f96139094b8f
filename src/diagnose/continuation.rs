//! Equals of the chosen explanation: another effect put in the place of one of its own along a path on which both act.

use super::candidate::Candidate;
use super::care::Care;
use super::descent::{InitialGuess, descend};
use super::fit::Fit;
use super::found::{Base, Found};
use super::free::{Free, Freedom};
use super::hypothesis::{EffectSet, Hypothesis, has_modified};
use super::objective::Objective;
use super::sandwich::inverted;
use super::selection::Search;
use crate::effect::EffectId;
use crate::error::Result;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Steps in which an effect goes to nothing, and Gauss–Newton steps with which the others follow each.
const STEPS: usize = 4;
const FOLLOWING: usize = 6;
/// In the place of each effect, so many others are tried.
const MOST_OTHERS: usize = 2;

impl Search<'_> {
    /// Adds the explanations in which another effect does what one of the chosen ones does.
    ///
    /// # Model
    /// With J the derivatives of the normalised residuals at the chosen fit, W their weights, P the precision of the priors, and d = J_a·(θ_a − θ_a⁰) what
    /// effect a makes of its way from the twin, an effect b that is not in the explanation leaves of it
    /// ```text
    ///   u = (dᵀWd − cᵀ(JᵀWJ + P)⁻¹c)/dᵀWd,   c = JᵀWd,   J: of b and of all others but a
    /// ```
    /// Where u is no more than the share that may stay open, b can do what a does, near the fit. So a goes to nothing in steps, and b and all others
    /// follow: each step goes along the tangent (Euler predictor), and least squares correct it. A fit of b that begins elsewhere may end in another minimum, and evidence would be of
    /// the minima: behind a wrong scale of the encoder a pitch has another length than beside the payload that is its equal.
    ///
    /// # Validity
    /// Effects whose numbers all have a value at which they do nothing: no periods or frequencies.
    ///
    /// # Source
    /// Allgower, Georg (1990), *Numerical Continuation Methods*.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn continue_to_equals(&self, found: &mut Found) -> Result<()> {
        if found.effects().len() < 2 {
            return Ok(());
        }
        self.prepare(found, found.chosen)?;
        let pairs = self.equals(found)?;
        let reached = |(gone, other): &(EffectId, EffectId)| self.replaced(found, *gone, *other);
        let all: Vec<Option<Candidate>> = pairs.par_iter().map(reached).collect::<Result<_>>()?;
        for candidate in all.into_iter().flatten() {
            match found.index(candidate.effects()) {
                Some(k) if candidate.fit.size < found.candidates[k].fit.size => {
                    found.candidates[k] = candidate
                }
                Some(_) => {}
                None => found.candidates.push(candidate),
            }
        }
        self.take_own_gaps(found)
    }

    /// Pairs of a chosen effect and another one that can do what it does.
    fn equals(&self, found: &Found) -> Result<Vec<(EffectId, EffectId)>> {
        let fit = &found.candidates[found.chosen].fit;
        let set = &fit.hypothesis.effects;
        let may_go = |effect: &EffectId| {
            self.without(set, [*effect]).len() + 1 == set.len() && has_neutral(fit, *effect)
        };
        let goes: Vec<EffectId> = set.iter().copied().filter(may_go).collect();
        let may_come = |e: &EffectId| !set.contains(e) && !e.follows() && has_modified(self.machine, *e, set);
        let others: Vec<EffectId> = self.catalogue.iter().copied().filter(may_come).collect();
        let base = &found.bases[&found.chosen];
        let left = |other: &EffectId| self.left_beside(fit, base, *other, &goes);
        let all: Vec<Vec<f64>> = others.par_iter().map(left).collect::<Result<_>>()?;
        let mut pairs = Vec::new();
        for (k, gone) in goes.iter().enumerate() {
            let mut own: Vec<(f64, EffectId)> =
                all.iter().zip(&others).filter_map(|(left, other)| Some((*left.get(k)?, *other))).collect();
            // What modifies the effect that goes has nothing to modify in its place.
            let rest = self.without(set, [*gone]);
            own.retain(|(left, other)| {
                *left <= self.limits.open_share && has_modified(self.machine, *other, &rest)
            });
            own.sort_by(|a, b| a.0.total_cmp(&b.0));
            pairs.extend(own.into_iter().take(MOST_OTHERS).map(|(_, other)| (*gone, other)));
        }
        Ok(pairs)
    }

    /// For each of some effects of a fit, the share of what it makes that another effect beside the rest cannot make; nothing where that one has no place to
    /// start from.
    fn left_beside(&self, fit: &Fit, base: &Base, other: EffectId, goes: &[EffectId]) -> Result<Vec<f64>> {
        let Some((hypothesis, values)) = self.beside(fit, base, other) else { return Ok(Vec::new()) };
        let objective = self.objective(&hypothesis).for_care(Care::Rough(&base.sensitivities));
        let residuals = objective.residuals(&values)?;
        let weights = objective.weights(&residuals);
        let jacobian = objective.jacobian(&values, &residuals, Some(&base.sensitivities))?;
        let share = |gone: &EffectId| {
            let own = |k: usize| is_of(&hypothesis, k, *gone);
            let mut change = DVector::zeros(residuals.len());
            let mut rest = jacobian.clone();
            for k in (0..values.len()).filter(|&k| own(k)) {
                let free = &hypothesis.free[k];
                change.axpy((values[k] - free.neutral) / free.scale, &jacobian.column(k), 1.0);
                rest.column_mut(k).fill(0.0);
            }
            let (normal, taken) = projected(&objective, &rest, &change, &weights, &values);
            let whole = change.component_mul(&weights).dot(&change);
            if whole > 0.0 { (whole - taken.dot(&(inverted(&normal) * &taken))) / whole } else { 1.0 }
        };
        Ok(goes.iter().map(share).collect())
    }

    /// The explanation with `other` in the place of `gone`, by continuation from a fit; none where `other` cannot be fitted.
    fn replaced(&self, found: &Found, gone: EffectId, other: EffectId) -> Result<Option<Candidate>> {
        let fit = &found.candidates[found.chosen].fit;
        let base = &found.bases[&found.chosen];
        let Some((mut both, begun)) = self.beside(fit, base, other) else { return Ok(None) };
        let own: Vec<usize> = (0..begun.len()).filter(|&k| is_of(&both, k, gone)).collect();
        own.iter().for_each(|&k| both.free[k].held = true);
        let mut values = begun.clone();
        for step in 1..=STEPS {
            let share = 1.0 - step as f64 / STEPS as f64;
            let moved =
                own.iter().map(|&k| (k, both.free[k].neutral + share * (begun[k] - both.free[k].neutral)));
            let objective = self.objective(&both);
            let guess =
                InitialGuess::at(&objective, predicted(&objective, &values, &moved.collect::<Vec<_>>())?)?;
            values = descend(&objective, guess, Care::Thorough, FOLLOWING)?.values;
        }
        let set: EffectSet = both.effects.iter().copied().filter(|effect| *effect != gone).collect();
        let Some(hypothesis) = Hypothesis::new(self.machine, &set, &base.proposals, &[(&both, &values)])
        else {
            return Ok(None);
        };
        let warm = hypothesis.starts[0].clone();
        self.evaluate(&hypothesis, Some(&warm), Care::Thorough).map(Some)
    }

    /// A fit's hypothesis with another effect that does nothing yet; none where that has no such values.
    fn beside(&self, fit: &Fit, base: &Base, other: EffectId) -> Option<(Hypothesis, Vec<f64>)> {
        let mut set = fit.hypothesis.effects.clone();
        set.insert(other);
        let known = [(&fit.hypothesis, fit.values.as_slice())];
        let hypothesis = Hypothesis::new(self.machine, &set, &base.proposals, &known)?;
        let neutral = |k: usize| {
            let free = &hypothesis.free[k];
            fit.hypothesis.value(&free.path, &fit.values).unwrap_or(free.neutral)
        };
        let values: Vec<f64> = (0..hypothesis.free.len()).map(neutral).collect();
        let is_inside =
            |(free, value): (&Free, &f64)| value.is_finite() && (free.range.0..=free.range.1).contains(value);
        hypothesis.free.iter().zip(&values).all(is_inside).then_some((hypothesis, values))
    }

    pub(super) fn objective<'a>(&'a self, hypothesis: &'a Hypothesis) -> Objective<'a> {
        Objective::new(self.machine, hypothesis, self.training.runs(), &self.floors.common)
    }
}

/// Values of which some have moved to given places and the others have followed to first order, inside their ranges (Euler predictor).
fn predicted(objective: &Objective, values: &[f64], moved: &[(usize, f64)]) -> Result<Vec<f64>> {
    let free = &objective.hypothesis.free;
    let residuals = objective.residuals(values)?;
    let weights = objective.weights(&residuals);
    // The derivatives leave out what is held.
    let mut loose = objective.hypothesis.clone();
    moved.iter().for_each(|(k, _)| loose.free[*k].held = false);
    let with_moved = Objective { hypothesis: &loose, ..*objective };
    let mut columns = with_moved.jacobian(values, &residuals, None)?;
    let mut change = DVector::zeros(residuals.len());
    for &(k, to) in moved {
        change.axpy((to - values[k]) / free[k].scale, &columns.column(k), 1.0);
        columns.column_mut(k).fill(0.0);
    }
    let (normal, taken) = projected(objective, &columns, &change, &weights, values);
    let follow = inverted(&normal) * taken;
    let mut predicted: Vec<f64> = values
        .iter()
        .zip(free)
        .zip(follow.iter())
        .map(|((value, free), step)| (value - step * free.scale).clamp(free.range.0, free.range.1))
        .collect();
    moved.iter().for_each(|&(k, to)| predicted[k] = to);
    Ok(predicted)
}

/// Normal matrix of columns with the prior, and what the columns have of a change.
fn projected(
    objective: &Objective,
    columns: &DMatrix<f64>,
    change: &DVector<f64>,
    weights: &DVector<f64>,
    values: &[f64],
) -> (DMatrix<f64>, DVector<f64>) {
    let (normal, _) = objective.normal(columns, change, weights, values);
    (normal, columns.tr_mul(&change.component_mul(weights)))
}

/// Whether a number of a hypothesis is one of an effect of it.
fn is_of(hypothesis: &Hypothesis, k: usize, effect: EffectId) -> bool {
    hypothesis.free[k].effect == effect && hypothesis.free[k].freedom == Freedom::Cause
}

/// Whether every number of an effect has a value at which it does nothing.
fn has_neutral(fit: &Fit, effect: EffectId) -> bool {
    let mut own = fit.hypothesis.free.iter().filter(|f| f.effect == effect && f.freedom == Freedom::Cause);
    own.all(|free| free.neutral.is_finite() && !free.held)
}
