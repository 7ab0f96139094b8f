//! What other minima of a fit leave uncertain: a weak wave may have one of several pitches, a weak mode one of several frequencies.

use super::candidate::Candidate;
use super::care::Care;
use super::descent::InitialGuess;
use super::evidence::{Score, predictions};
use super::experiment::{Experiment, HeldOut, Training};
use super::fit::{Fit, inside};
use super::found::Found;
use super::free::{Free, Freedom};
use super::half_pitch::halved_by_power;
use super::long_steps::descend_from;
use super::noise::Floor;
use super::objective::Objective;
use super::parameter::NORMAL_975;
use super::selection::Search;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Starts that are descended from roughly at most, and ends of these that are descended from to the end; choices of cost.
const MOST_STARTS: usize = 8;
const FINALISTS: usize = 4;
/// Steps of a descent to the end at most; a choice of cost.
const STEPS: usize = 30;

/// What other minima add to the covariance of the chosen fit, in units of its numbers' scales; none where the search has met none.
///
/// # Model
/// The likelihood of a period or a frequency has several maxima, of which a fit ends in one (see [`ends`]). With the likelihoods L_k of training and held-out runs in
/// others and L in that one, the weights of the others are `w_k = L_k/(L + Σ L_k)`, and the law of total variance gives `C + Σ w_k·d_k·d_kᵀ` about the value that is
/// told, d_k the way to a minimum.
///
/// # Validity
/// The covariance within each minimum is taken to be that of the fit, and as large a volume.
///
/// # Errors
/// Whatever a replay refuses.
pub(super) fn covariance(
    found: &Found,
    machine: &Machine,
    (training, held_out): (&Training, &HeldOut),
    floor: &Floor,
) -> Result<Option<DMatrix<f64>>> {
    let fit = &found.candidates[found.chosen].fit;
    let others = match found.other_minima.get(&found.chosen) {
        Some(known) => known.clone(),
        None => ends(found, machine, training, floor)?,
    };
    if others.is_empty() {
        return Ok(None);
    }
    let runs = [training.runs(), held_out.runs()];
    let fitted = scores(fit, machine, runs, floor, &fit.values)?;
    let minimum = |values: Vec<f64>| -> Result<(f64, DVector<f64>)> {
        let scored = scores(fit, machine, runs, floor, &values)?;
        let more = |of: &Score, by: &Score| {
            of.log_likelihoods(by).iter().zip(by.log_likelihoods(by)).map(|(of, by)| of - by).sum::<f64>()
        };
        let data: f64 = scored.iter().zip(&fitted).map(|(of, by)| more(of, by)).sum();
        Ok((data - (fit.hypothesis.strain(&values) - fit.strain()), fit.way(&values)))
    };
    let minima: Vec<(f64, DVector<f64>)> = others.into_iter().map(minimum).collect::<Result<_>>()?;
    Ok(mixed(&minima))
}

impl Search<'_> {
    /// Goes to another minimum of the chosen explanation that leaves less of the training runs; tells whether it did. Of several starts a fit descends from those that
    /// replay best, and a start near the least minimum may replay worse than one that only looks alike.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn go_to_a_better_minimum(&self, found: &mut Found) -> Result<bool> {
        let chosen = found.chosen;
        let others = ends(found, self.machine, self.training, &self.floors.common)?;
        if let Some(nearest) = others.first() {
            let fit = &found.candidates[chosen].fit;
            let other = self.evaluate(&fit.hypothesis, Some(nearest), Care::Thorough)?;
            if other.fit.size < fit.size {
                found.candidates[chosen] = other;
                found.bases.remove(&chosen);
                self.take_own_gaps(found)?;
                return Ok(true);
            }
        }
        found.other_minima.insert(chosen, others);
        Ok(false)
    }
}

/// Where descents from other periods and frequencies of the chosen effects end, those that leave least of the training runs first. The search has met their starts, in
/// the chosen explanation and in parts of it; the numbers of the other effects begin as they are in the chosen fit.
fn ends(found: &Found, machine: &Machine, training: &Training, floor: &Floor) -> Result<Vec<Vec<f64>>> {
    let fit = &found.candidates[found.chosen].fit;
    let starts = starts(found);
    if starts.is_empty() {
        return Ok(starts);
    }
    // A wave has other derivatives at another pitch.
    let is_of_line = |free: &Free| {
        let of_effect = |other: &Free| other.effect == free.effect && other.is_line();
        free.freedom == Freedom::Cause && fit.hypothesis.free.iter().any(of_effect)
    };
    let sensitivities = fit.sensitivities(machine, training, floor)?.without(is_of_line);
    let fine = Objective::new(machine, &fit.hypothesis, training.runs(), floor);
    let care = Care::Rough(&sensitivities);
    let rough = Objective::new(machine, &fit.hypothesis, training.runs(), floor).for_care(care);
    let begun = rough.residuals_of(&starts)?;
    let begun = starts.into_iter().zip(begun).map(|(values, residuals)| InitialGuess { values, residuals });
    let begun = nearest(begun.map(|guess| (rough.size(&guess.residuals), guess)).collect(), MOST_STARTS);
    let descended = |guess: InitialGuess| -> Result<(f64, Vec<f64>)> {
        let arrived = descend_from(&rough, guess, care, care.iterations())?;
        Ok((rough.size(&arrived.residuals), arrived.values))
    };
    let roughly: Vec<(f64, Vec<f64>)> = begun.into_par_iter().map(descended).collect::<Result<_>>()?;
    let finalists =
        others(fit, nearest(roughly, MOST_STARTS)).into_iter().take(FINALISTS).collect::<Vec<_>>();
    let to_the_end = |values: Vec<f64>| -> Result<(f64, Vec<f64>)> {
        let guess = InitialGuess::at(&fine, values)?;
        let arrived = descend_from(&fine, guess, Care::Thorough, STEPS)?;
        Ok((fine.size(&arrived.residuals), arrived.values))
    };
    let ends: Vec<(f64, Vec<f64>)> = finalists.into_par_iter().map(to_the_end).collect::<Result<_>>()?;
    Ok(others(fit, nearest(ends, FINALISTS)))
}

/// So many of these at most, those with the smallest number first.
fn nearest<T>(mut all: Vec<(f64, T)>, most: usize) -> Vec<T> {
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.truncate(most);
    all.into_iter().map(|(_, one)| one).collect()
}

/// Those of some values that have other periods and frequencies than the fit, and than those before them; a wave of twice the period is told as the one that it nearly is.
fn others(fit: &Fit, all: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let told = |values: Vec<f64>| halved_by_power(&fit.hypothesis, &values).unwrap_or(values);
    let own = told(fit.values.clone());
    let mut others: Vec<Vec<f64>> = Vec::new();
    for values in all.into_iter().map(told) {
        let is_new = |known: &[f64]| !is_same(fit, &values, known);
        if is_new(&fit.values) && is_new(&own) && others.iter().all(|known| is_new(known)) {
            others.push(values);
        }
    }
    others
}

/// Σ w_k·d_k·d_kᵀ of minima with these log-odds against the fit and these ways from it; none where there are none.
fn mixed(minima: &[(f64, DVector<f64>)]) -> Option<DMatrix<f64>> {
    let most = minima.iter().map(|(log_odds, _)| *log_odds).fold(0.0, f64::max);
    let likelihood = |log_odds: f64| (log_odds - most).exp();
    let total = likelihood(0.0) + minima.iter().map(|(log_odds, _)| likelihood(*log_odds)).sum::<f64>();
    let parts = minima.iter().map(|(log_odds, way)| way * way.transpose() * (likelihood(*log_odds) / total));
    parts.reduce(|a, b| a + b)
}

/// The starts that the search has met of the chosen effects with other periods and frequencies.
fn starts(found: &Found) -> Vec<Vec<f64>> {
    let fit = &found.candidates[found.chosen].fit;
    let free = &fit.hypothesis.free;
    let is_part = |known: &&Candidate| known.effects().is_subset(&fit.hypothesis.effects);
    let lines = || free.iter().filter(|free| free.freedom == Freedom::Cause && free.is_line());
    let mut all = Vec::new();
    for known in found.candidates.iter().filter(is_part).map(|candidate| &candidate.fit) {
        for begun in known.hypothesis.starts.iter().chain([&known.values]) {
            // The numbers of one effect at a time.
            all.extend(lines().map(|line| {
                let of_line = |of: &Free| of.freedom == Freedom::Cause && of.effect == line.effect;
                let begun = |of: &Free| known.hypothesis.value(&of.path, begun).filter(|_| of_line(of));
                let values = free.iter().zip(&fit.values).map(|(of, value)| begun(of).unwrap_or(*value));
                inside(&fit.hypothesis, &values.collect::<Vec<_>>())
            }));
        }
    }
    others(fit, all)
}

/// Whether some values, `a`, have the periods and the frequencies of others, `b`, within the 95 % intervals of the fit, whichever effect has which: of two waves each may
/// be called the first.
fn is_same(fit: &Fit, a: &[f64], b: &[f64]) -> bool {
    let free = &fit.hypothesis.free;
    let sorted = |line: &Free, values: &[f64]| {
        let alike = (0..free.len()).filter(|&k| free[k].is_line() && free[k].name == line.name);
        let mut lines: Vec<(f64, f64)> = alike.map(|k| (values[k], fit.standard_errors[k])).collect();
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        lines
    };
    let agree =
        |((a, own), (b, other)): ((f64, f64), (f64, f64))| (a - b).abs() <= NORMAL_975 * own.max(other);
    free.iter()
        .filter(|line| line.is_line())
        .all(|line| sorted(line, a).into_iter().zip(sorted(line, b)).all(agree))
}

/// Scores of some values on training and held-out runs.
fn scores(
    fit: &Fit,
    machine: &Machine,
    runs: [&[Experiment]; 2],
    floor: &Floor,
    values: &[f64],
) -> Result<[Score; 2]> {
    let machine = fit.hypothesis.machine(machine, values)?;
    let of = |runs: &[Experiment]| -> Result<Score> {
        Ok(Score::of_traces(runs, &predictions(&machine, runs)?, floor))
    };
    Ok([of(runs[0])?, of(runs[1])?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::EffectSet;
    use crate::diagnose::hypothesis::tests::hypothesis;
    use crate::effect::EffectId;

    /// A minimum 10 scales away that is as likely as the fit has half of the weight: a variance of 50 about the value that is told. One that is e⁻⁵⁰ times as likely adds
    /// nothing that shows, and one that is e¹⁰⁰⁰ times as likely all of its distance.
    #[test]
    fn exact_a_minimum_as_likely_as_the_fit_adds_half_the_square_of_its_distance() {
        let at = |log_odds: f64| mixed(&[(log_odds, DVector::from_vec(vec![10.0, -1.0]))]).unwrap();
        assert!((at(0.0)[(0, 0)] - 50.0).abs() < 1e-12 && (at(0.0)[(0, 1)] + 5.0).abs() < 1e-12);
        assert!(at(-50.0)[(0, 0)] < 1e-18 && (at(1000.0)[(0, 0)] - 100.0).abs() < 1e-9);
        assert!(mixed(&[]).is_none());
    }

    /// Two waves whose pitches change places are the same two waves.
    #[test]
    fn exact_waves_that_change_places_are_the_same() {
        let line = |effect| Free { neutral: f64::NAN, ..number(effect, "period_m") };
        let fit = Fit {
            hypothesis: hypothesis(vec![line(EffectId::Cogging), line(EffectId::SecondCogging)]),
            values: vec![0.03, 0.05],
            size: 0.0,
            mean_square: 0.0,
            standard_errors: vec![1e-3; 2],
            covariance: DMatrix::zeros(2, 2),
            shown: EffectSet::new(),
        };
        assert!(is_same(&fit, &fit.values, &[0.0515, 0.0285]));
        assert!(!is_same(&fit, &fit.values, &[0.03, 0.0525]));
    }
}
