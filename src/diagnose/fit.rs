//! Bounded least squares of a hypothesis on training runs.

pub use super::care::{Care, Sensitivities};
use super::descent::{Arrived, InitialGuess};
use super::experiment::Training;
use super::free::{Free, Freedom};
use super::half_pitch::halved;
use super::hypothesis::{EffectSet, Hypothesis};
use super::long_steps::descend_from;
use super::noise::Floor;
use super::objective::Objective;
use super::parameter::NORMAL_975;
use super::sandwich::{inverted, scatter};
use super::wald::{independent_frequencies, shows};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};

/// A fitted hypothesis.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// Values of its free numbers.
    pub values: Vec<f64>,
    /// Size of what it leaves of the training runs, by which fits of one hypothesis are compared.
    pub size: f64,
    /// Mean square of the normalised residuals that it leaves of the training runs, every signal weighing the same.
    pub mean_square: f64,
    /// Standard errors of the values, robust to autocorrelated and uneven residuals.
    pub standard_errors: Vec<f64>,
    /// Their covariance, each in units of its number's scale.
    pub covariance: DMatrix<f64>,
    /// Effects that show: a parameter's 95 % interval leaves out the twin's own value, or the 95 % region of all of them does.
    /// The phase of what repeats far from the zero of position hangs on its period: sine and cosine by themselves are
    /// uncertain then, and both together are not.
    pub shown: EffectSet,
}

/// Rows that rough fits take at most.
const ROUGH_ROWS: usize = 20_000;

impl Fit {
    /// Negative logarithm of the numbers' prior; see [`Hypothesis::strain`].
    pub fn strain(&self) -> f64 {
        self.hypothesis.strain(&self.values)
    }

    /// The way from its values to others, in units of the numbers' scales.
    pub(super) fn way(&self, values: &[f64]) -> DVector<f64> {
        let pairs = self.hypothesis.free.iter().zip(values.iter().zip(&self.values));
        let way = pairs.map(|(free, (there, fitted))| (there - fitted) / free.scale);
        DVector::from_iterator(values.len(), way)
    }

    /// Standard error, to first order, of a quantity with this gradient with respect to some of the values.
    pub fn standard_error(&self, gradient: &[(usize, f64)]) -> f64 {
        let free = &self.hypothesis.free;
        let part = |(a, da): (usize, f64), (b, db): (usize, f64)| {
            da * db * free[a].scale * free[b].scale * self.covariance[(a, b)]
        };
        let all = gradient.iter().flat_map(|&a| gradient.iter().map(move |&b| part(a, b)));
        all.sum::<f64>().max(0.0).sqrt()
    }

    /// Its sensitivities.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn sensitivities(
        &self,
        machine: &Machine,
        training: &Training,
        floor: &Floor,
    ) -> Result<Sensitivities> {
        let experiments = training.runs();
        let mut objective = Objective::new(machine, &self.hypothesis, experiments, floor);
        let rows: usize = experiments.iter().map(|e| objective.rows(e) * e.signals().len()).sum();
        objective.stride = rows.div_ceil(ROUGH_ROWS).max(1);
        let mut residuals = objective.residuals(&self.values)?;
        if let Some(coarse) = objective.lengthened(&self.values, &residuals)? {
            (objective, residuals) = coarse;
        }
        let columns = objective.jacobian(&self.values, &residuals, None)?;
        let Objective { stride, longest_step_s, .. } = objective;
        Ok(Sensitivities { free: self.hypothesis.free.clone(), columns, stride, longest_step_s })
    }

    /// Whether it leaves more of the training runs than one of a hypothesis with more effects, without the effects that that one has more,
    /// replayed as it is: it ended in a minimum that is not the least. The values from there, where that is so.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn improved_by(
        &self,
        fuller: &Self,
        machine: &Machine,
        training: &Training,
        floor: &Floor,
    ) -> Result<Option<Vec<f64>>> {
        let value = |free: &Free| fuller.hypothesis.value(&free.path, &fuller.values);
        let Some(values) = self.hypothesis.free.iter().map(value).collect::<Option<Vec<f64>>>() else {
            return Ok(None);
        };
        let values = inside(&self.hypothesis, &values);
        let objective = Objective::new(machine, &self.hypothesis, training.runs(), floor);
        let size = objective.size(&objective.residuals(&values)?);
        Ok((size < self.size).then_some(values))
    }

    /// Whether the other fit has a number that exists with its effect only (a period, a frequency, a place) outside the 95 % interval which this fit gives it: these numbers
    /// have many minima, and the other fit is in another one. The other fit's interval is not asked: where an effect is missing in it, that may be as wide as the number's range.
    pub fn is_elsewhere(&self, other: &Self) -> bool {
        let is_apart = |free: &Free| {
            let value = |of: &Self| of.hypothesis.value(&free.path, &of.values);
            let own = value(self).zip(self.hypothesis.value(&free.path, &self.standard_errors));
            own.zip(value(other)).is_some_and(|((own, e), others)| (own - others).abs() > NORMAL_975 * e)
        };
        let is_searched = |free: &Free| free.freedom == Freedom::Cause && free.neutral.is_nan();
        self.hypothesis.free.iter().any(|free| is_searched(free) && is_apart(free))
    }

    /// Whether it has a period or a frequency that differs from that of the other fit by more than a tenth.
    pub fn has_other_period(&self, other: &Self) -> bool {
        let value = |of: &Self, free: &Free| of.hypothesis.value(&free.path, &of.values);
        let is_other = |free: &Free| {
            let both = value(self, free).zip(value(other, free));
            both.is_some_and(|(own, others)| (own - others).abs() > OTHER_PERIOD * others.abs())
        };
        self.hypothesis.free.iter().filter(|free| free.is_line()).any(is_other)
    }

    /// Adds a covariance, in units of the numbers' scales, to that of its values.
    pub(super) fn widen(&mut self, added: &DMatrix<f64>) {
        self.covariance += added;
        for (k, free) in self.hypothesis.free.iter().enumerate() {
            self.standard_errors[k] =
                self.standard_errors[k].hypot(free.scale * added[(k, k)].max(0.0).sqrt());
        }
    }

    /// The machine as fitted.
    ///
    /// # Errors
    /// A value that the machine's description refuses.
    pub fn machine(&self, machine: &Machine) -> Result<Machine> {
        self.hypothesis.machine(machine, &self.values)
    }
}

/// Periods, or frequencies, that differ by more than this share are two. An estimate: shares of the gap depend on it, and no verdict.
const OTHER_PERIOD: f64 = 0.1;

/// Starts that build on what is found, and are descended from at most.
const DESCENTS: usize = 2;

/// Fits a hypothesis to training runs from its starts, or from `warm` alone, and keeps the best.
///
/// # Model
/// Of several starts, those that already replay best are descended from; after a few steps of a rough fit only the best of them goes on. The best of
/// those that replace what is found are descended from beside them. Levenberg–Marquardt between bounds. Residuals far outside their own spread count
/// linearly (Huber). A wave whose second harmonic alone shows is fitted again with half the pitch. Standard errors are the sandwich
/// `H⁻¹·(Σ g_b·g_bᵀ)·H⁻¹` over blocks b of consecutive samples, which holds for autocorrelated and uneven residuals alike.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub fn fit(
    machine: &Machine,
    hypothesis: &Hypothesis,
    training: &Training,
    floor: &Floor,
    warm: Option<&[f64]>,
    care: Care,
) -> Result<Fit> {
    let objective = Objective::new(machine, hypothesis, training.runs(), floor).for_care(care);
    let starts = match warm {
        Some(values) => {
            let begun = InitialGuess::at(&objective, inside(hypothesis, values))?;
            Starts { building: vec![begun], replacing: Vec::new() }
        }
        None => promising(&objective, care)?,
    };
    let mut all: Vec<Arrived> = raced(&objective, starts.building, care)?.into_iter().collect();
    for start in starts.replacing {
        all.push(descend_from(&objective, start, care, care.iterations())?);
    }
    let arrived = match best(&objective, all) {
        Some(arrived) => arrived,
        None => Arrived { values: Vec::new(), residuals: objective.residuals(&[])?, jacobian: None },
    };
    let fit = finish(&objective, arrived, care)?;
    match halved(hypothesis, &fit.values, &fit.covariance).filter(|_| matches!(care, Care::Thorough)) {
        Some(values) => {
            let begun = InitialGuess::at(&objective, inside(hypothesis, &values))?;
            let arrived = descend_from(&objective, begun, care, care.iterations())?;
            let half = finish(&objective, arrived, care)?;
            let is_as_good = half.size <= fit.size + ALIKE && half.shown.is_superset(&fit.shown);
            Ok(if is_as_good { half } else { fit })
        }
        None => Ok(fit),
    }
}

/// Fits whose sizes differ by no more than this (a share of the mean squares) describe the runs alike: two numbers that do not show take 6 off the
/// sum of squares (χ² at 5 %), 1 % of 600 independent samples.
const ALIKE: f64 = 0.01;

/// Steps after which a rough fit goes on from the best alone of its starts that build on what is found: a choice of cost. A start that is overtaken
/// later is lost. Those that put others in the place of what is found are not raced: they begin far from where the other numbers are at rest.
const RACED: usize = 2;
/// Of the starts that put others in the place of what is found, so many are descended from: a choice of cost.
const REPLACING: usize = 3;

/// Where the best of these starts leads, that goes on by itself after a few steps of a rough fit; none of none.
fn raced(objective: &Objective, starts: Vec<InitialGuess>, care: Care) -> Result<Option<Arrived>> {
    let is_race = starts.len() > 1 && matches!(care, Care::Rough(_));
    let steps = if is_race { RACED } else { care.iterations() };
    let all = starts.into_iter().map(|start| descend_from(objective, start, care, steps));
    let leader = best(objective, all.collect::<Result<Vec<Arrived>>>()?);
    match leader {
        Some(leader) if is_race && leader.jacobian.is_none() => {
            let begun = InitialGuess { values: leader.values, residuals: leader.residuals };
            descend_from(objective, begun, care, care.iterations() - RACED).map(Some)
        }
        leader => Ok(leader),
    }
}

/// The one that leaves least, the first one of equals.
fn best(objective: &Objective, all: Vec<Arrived>) -> Option<Arrived> {
    let sized = all.into_iter().map(|arrived| (objective.size(&arrived.residuals), arrived));
    sized.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, arrived)| arrived)
}

/// Where a fit is descended from.
struct Starts {
    /// What builds on what a fit of another hypothesis left.
    building: Vec<InitialGuess>,
    /// What puts other values in the place of that.
    replacing: Vec<InitialGuess>,
}

/// Of several starts, those whose replays come closest once the numbers whose sensitivities are known have gone with them: what a wave takes
/// up, calibration had taken up before.
fn promising(objective: &Objective, care: Care) -> Result<Starts> {
    let starts: Vec<Vec<f64>> =
        objective.hypothesis.starts.iter().map(|start| inside(objective.hypothesis, start)).collect();
    let Hypothesis { building, inherited, .. } = *objective.hypothesis;
    let residuals = objective.residuals_of(&starts)?;
    let begun =
        starts.into_iter().zip(residuals).map(|(values, residuals)| InitialGuess { values, residuals });
    if begun.len() <= DESCENTS && inherited == 0 {
        let mut build: Vec<InitialGuess> = begun.collect();
        let replacing = build.split_off(building);
        return Ok(Starts { building: build, replacing });
    }
    let known = care.known().map(|known| objective.known_columns(known));
    let left = |InitialGuess { values, residuals }: &InitialGuess| {
        let Some(columns) = &known else { return objective.size(residuals) };
        let weights = objective.weights(residuals);
        let (normal, gradient) = objective.normal(columns, residuals, &weights, values);
        objective.size(&(residuals - columns * (inverted(&normal) * gradient)))
    };
    let descents = DESCENTS.min(building - inherited);
    let mut build: Vec<(f64, InitialGuess)> = begun.map(|begun| (left(&begun), begun)).collect();
    // What is found was fitted, what would take its place was not: by their replays alone the one always looks better.
    let mut replacing = build.split_off(building);
    for starts in [&mut build, &mut replacing] {
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    build.truncate(descents);
    replacing.truncate(REPLACING);
    let bare = |starts: Vec<(f64, InitialGuess)>| starts.into_iter().map(|(_, begun)| begun).collect();
    Ok(Starts { building: bare(build), replacing: bare(replacing) })
}

/// Values inside the ranges of a hypothesis.
pub(super) fn inside(hypothesis: &Hypothesis, values: &[f64]) -> Vec<f64> {
    hypothesis.free.iter().zip(values).map(|(free, v)| v.clamp(free.range.0, free.range.1)).collect()
}

fn finish(objective: &Objective, arrived: Arrived, care: Care) -> Result<Fit> {
    let Arrived { values, residuals, jacobian } = arrived;
    let jacobian = match jacobian {
        Some(jacobian) => jacobian,
        None => objective.jacobian(&values, &residuals, care.known())?,
    };
    let values = match care {
        Care::Thorough => without_idle(objective, values, &residuals, &jacobian)?,
        Care::Rough(_) => values,
    };
    let count = values.len();
    let weights = objective.weights(&residuals);
    let (weight, _) = objective.hypothesis.prior(&values);
    let (normal, _) = objective.normal(&jacobian, &residuals, &weights, &values);
    let scatter = scatter(objective, &jacobian, &weights.component_mul(&residuals));
    let inverse = inverted(&normal);
    let covariance = &inverse * (scatter + DMatrix::from_diagonal(&weight)) * &inverse;
    let free = &objective.hypothesis.free;
    let standard_errors = (0..count).map(|k| covariance[(k, k)].max(0.0).sqrt() * free[k].scale).collect();
    // What does nothing here has neither interval nor effect; what only starts set has no interval either.
    let tells = |k: usize| free[k].held || normal[(k, k)] > 0.0;
    let effects = objective.hypothesis.effects.iter().copied();
    let frequencies = independent_frequencies(objective.experiments.iter().map(|e| objective.rows(e)).sum());
    let shows = |effect: &EffectId| {
        let own = |k: &usize| free[*k].effect == *effect && free[*k].freedom == Freedom::Cause && tells(*k);
        shows((0..free.len()).filter(own).collect(), free, &values, &covariance, frequencies)
    };
    let shown = effects.filter(shows).collect();
    let (size, mean_square) = (objective.size(&residuals), objective.mean_square(&residuals));
    let hypothesis = objective.hypothesis.clone();
    Ok(Fit { hypothesis, values, size, mean_square, standard_errors, covariance, shown })
}

/// The values with those of the twin in the place of numbers that do nothing on these runs: where a fit of them started says nothing. A
/// number that does nothing nearby and something where the twin has it stays.
fn without_idle(
    objective: &Objective,
    values: Vec<f64>,
    residuals: &DVector<f64>,
    jacobian: &DMatrix<f64>,
) -> Result<Vec<f64>> {
    let is_idle = |k: &usize| {
        let free = &objective.hypothesis.free[*k];
        let is_away = free.neutral.is_finite() && values[*k] != free.neutral;
        free.freedom == Freedom::Cause && !free.held && is_away && jacobian.column(*k).amax() == 0.0
    };
    let mut rest = values.clone();
    for k in (0..values.len()).filter(is_idle) {
        rest[k] = objective.hypothesis.free[k].neutral;
    }
    let is_same = rest == values || objective.residuals(&rest)? == *residuals;
    Ok(if is_same { rest } else { values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::tests::hypothesis;

    fn at(value: f64, neutral: f64, standard_error: f64) -> Fit {
        Fit {
            hypothesis: hypothesis(vec![Free { neutral, ..number(EffectId::Cogging, "period_m") }]),
            values: vec![value],
            size: 0.0,
            mean_square: 0.0,
            standard_errors: vec![standard_error],
            covariance: DMatrix::zeros(1, 1),
            shown: EffectSet::new(),
        }
    }

    /// A period is in another minimum where it is outside this fit's 95 % interval, ±1.96·3 mm, whatever its own interval (±196 mm here); an amplitude never is.
    #[test]
    fn exact_a_period_is_in_another_minimum_beyond_the_own_interval() {
        let apart = |mm: f64, neutral: f64| {
            at(0.036, neutral, 0.003).is_elsewhere(&at(0.036 + mm * 1e-3, neutral, 0.1))
        };
        assert!(!apart(5.8, f64::NAN) && apart(5.9, f64::NAN) && apart(-5.9, f64::NAN));
        assert!(!apart(100.0, 0.0));
    }
}
