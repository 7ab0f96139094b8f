//! How well a hypothesis predicts the held-out runs where its numbers are as uncertain as the training runs leave them.

use super::evidence::{Score, predictions};
use super::experiment::{HeldOut, Training};
use super::fit::{Fit, inside};
use super::joint::{Place, joint};
use super::noise::Floor;
use super::objective::{Objective, weighted};
use super::predictive_weights::{squares, weights};
use super::thresholds::{MOST, SMALL_GAP};
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};

/// What a hypothesis leaves of the held-out runs, its numbers where training and held-out runs together have them.
#[derive(Debug, Clone)]
pub struct Predictive {
    /// The score there.
    pub score: Score,
    /// What that costs in log-likelihood, in nats: how far the numbers had to move, and how much they might have.
    pub cost: f64,
    /// The numbers there, in the order of the fit's; none where they stay.
    pub values: Option<Vec<f64>>,
}

impl Predictive {
    /// That of a fit whose numbers stay.
    pub fn of(score: Score) -> Self {
        Self { score, cost: 0.0, values: None }
    }
}

/// Rounds in which the variance of the residuals and the numbers are taken in turn; a choice of cost, the first two do nearly all.
const ROUNDS: usize = 4;
/// Places to which the numbers are moved, at most; a choice of cost, most stay at the first.
const MOST_PLACES: usize = 6;
/// Log-likelihood by which a replay may leave more than the linear form says, and that another place must gain, in nats: less than chance makes.
const A_NAT: f64 = 1.0;

/// The posterior-predictive score of a fit; `score` is that of its values.
///
/// # Model
/// A fit is not a number but a distribution N(θ̂, C), so that of two hypotheses the one whose numbers the training runs hardly tell must not be
/// judged by where its fit came to rest. With r and J the normalised residuals at θ̂ and their derivatives on the held-out runs, W their
/// weights,
/// ```text
///   ln p(held out | training) = −½·r'ᵀWr' − ½·ΔᵀC⁻¹Δ − ½·ln det(I + JᵀWJ·C)
///   Δ = −C·(I + JᵀWJ·C)⁻¹·JᵀWr,   r' = r + J·Δ
/// ```
/// the integral over θ of a Gaussian likelihood. W is 1/(v·τ·m) a sample: v the mean square of the signal's own r', at least that of its noise, τ its lag-summed
/// autocorrelation and m the number of signals, as in [`Score::log_likelihoods`]. The squares are those of a replay at θ̂ + Δ, not of the linear
/// prediction. From there Δ is found anew (Gauss–Newton) with v and τ of that place, and with J of it where the squares are more than foreseen by
/// more than a nat. Strokes of 20 mm leave a pitch of 44 mm uncertain by 7 mm, and over that what a stroke of 37 mm leaves is not linear.
///
/// # Validity
/// Hypotheses that were fitted to the end and share the common noise floor; the others are compared by the score of their fit. To first order in Δ
/// for its cost: the training runs are quadratic about θ̂. The last place stays whose replay, at the full step, gained more than it cost by the weights of that
/// step; the fit's own, where the first did not. Where the steps end before a further one would gain no more than a nat, and leave more than a small gap and more than
/// the fit leaves of the training runs, a fit to both kinds of run goes on from there, and its cost is that of a replay (see [`joint`]). A number that would leave its
/// range stays at the end of it; its cost is that of the step beyond, too small where that number is correlated with others.
///
/// # Source
/// Gelman, Carlin, Stern, Dunson, Vehtari, Rubin (2013), *Bayesian Data Analysis*, 3rd ed., ch. 7 and 14.
///
/// # Errors
/// Whatever a replay refuses.
pub fn predictive(
    machine: &Machine,
    fit: &Fit,
    (training, held_out): (&Training, &HeldOut),
    floor: &Floor,
    score: &Score,
) -> Result<Predictive> {
    let objective = Objective::new(machine, &fit.hypothesis, held_out.runs(), floor);
    if fit.values.is_empty() {
        return Ok(Predictive::of(score.clone()));
    }
    let begun = Place {
        values: fit.values.clone(),
        residuals: objective.residuals(&fit.values)?,
        score: score.clone(),
        strain: 0.0,
    };
    let Stepped { mut place, mut jacobian, has_arrived } = stepped(&objective, fit, held_out, begun)?;
    if !has_arrived && is_open(fit, &place.score) {
        let joint = joint(machine, fit, [training.runs(), held_out.runs()], floor, &place.values)?;
        let weights = weights(&objective, &joint.score, &joint.residuals);
        if cost(&joint, &weights) < cost(&place, &weights) {
            jacobian = objective.jacobian(&joint.values, &joint.residuals, None)?;
            place = joint;
        }
    }
    let weights = weights(&objective, &place.score, &place.residuals);
    let Some(occam) = occam(&jacobian, &weights, &fit.covariance) else {
        return Ok(Predictive::of(score.clone()));
    };
    let moved = place.values != fit.values;
    Ok(Predictive { score: place.score, cost: place.strain + occam, values: moved.then_some(place.values) })
}

/// Where the steps of the update end.
struct Stepped {
    place: Place,
    /// Derivatives of the residuals of the held-out runs, taken there or at a place before.
    jacobian: DMatrix<f64>,
    /// Whether a further step would gain no more than a nat.
    has_arrived: bool,
}

/// Takes the steps of the update from the fit on.
fn stepped(objective: &Objective, fit: &Fit, held_out: &HeldOut, begun: Place) -> Result<Stepped> {
    let mut place = begun;
    let mut jacobian = objective.jacobian(&place.values, &place.residuals, None)?;
    for round in 0..MOST_PLACES {
        // What is left at the fit, as it looks from here.
        let at_fit = &place.residuals - &jacobian * fit.way(&place.values);
        let weights = |left: &DVector<f64>| weights(objective, &place.score, left);
        let Some(update) = Update::of(&at_fit, &jacobian, &fit.covariance, weights) else { break };
        let linear = at_fit + &jacobian * &update.step;
        let foreseen = squares(&linear, &update.weights) + 2.0 * update.strain;
        let now = cost(&place, &update.weights);
        if round > 0 && now - foreseen <= 2.0 * A_NAT {
            return Ok(Stepped { place, jacobian, has_arrived: true });
        }
        let free = fit.hypothesis.free.iter().zip(&fit.values).zip(&update.step);
        let beyond: Vec<f64> = free.map(|((free, value), step)| value + step * free.scale).collect();
        let values = inside(&fit.hypothesis, &beyond);
        let Ok(moved) = fit.hypothesis.machine(objective.machine, &values) else { break };
        let traces = predictions(&moved, held_out.runs())?;
        let residuals = objective.residuals_from(&traces);
        let there = squares(&residuals, &update.weights) + 2.0 * update.strain;
        if there > now {
            break;
        }
        let score = Score::of_traces(held_out.runs(), &traces, objective.floor);
        place = Place { values, residuals, score, strain: update.strain };
        if there - foreseen > 2.0 * A_NAT {
            jacobian = objective.jacobian(&place.values, &place.residuals, None)?;
        }
    }
    Ok(Stepped { place, jacobian, has_arrived: false })
}

/// Twice the negative logarithm of what the held-out runs and those before have of a place, but for a constant.
fn cost(place: &Place, weights: &DVector<f64>) -> f64 {
    squares(&place.residuals, weights) + 2.0 * place.strain
}

/// Whether more than a small gap is left of the held-out runs, most of it more than the training runs leave: numbers farther away than the training runs are
/// quadratic about the fit may close it.
fn is_open(fit: &Fit, score: &Score) -> bool {
    let left = (fit.mean_square - 1.0).max(0.0);
    score.gap() > SMALL_GAP && left < (1.0 - MOST) * (score.mean_square() - 1.0)
}

/// I + JᵀWJ·C.
fn system(weighted: &DMatrix<f64>, jacobian: &DMatrix<f64>, covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let information = weighted.tr_mul(jacobian);
    DMatrix::identity(information.nrows(), information.nrows()) + information * covariance
}

/// ½·ln det(I + JᵀWJ·C): how much the numbers might have moved; none where that is not finite.
fn occam(jacobian: &DMatrix<f64>, weights: &DVector<f64>, covariance: &DMatrix<f64>) -> Option<f64> {
    let factors = system(&weighted(jacobian, weights), jacobian, covariance).lu();
    let occam = 0.5 * factors.u().diagonal().iter().map(|pivot| pivot.abs().ln()).sum::<f64>();
    occam.is_finite().then_some(occam.max(0.0))
}

/// Where the numbers go when held-out runs are taken in as well.
struct Update {
    /// Step in units of the numbers' scales.
    step: DVector<f64>,
    /// Weights of the residuals there.
    weights: DVector<f64>,
    /// ½·ΔᵀC⁻¹Δ, in nats.
    strain: f64,
}

impl Update {
    /// The update; none where the numbers are not finite.
    fn of(
        residuals: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        covariance: &DMatrix<f64>,
        weights: impl Fn(&DVector<f64>) -> DVector<f64>,
    ) -> Option<Self> {
        let mut update: Option<Self> = None;
        for _ in 0..ROUNDS {
            let left = update.as_ref().map_or_else(|| residuals.clone(), |u| residuals + jacobian * &u.step);
            let weights = weights(&left);
            let weighted = weighted(jacobian, &weights);
            let factors = system(&weighted, jacobian, covariance).lu();
            let pulled = factors.solve(&weighted.tr_mul(residuals))?;
            let step = -(covariance * &pulled);
            let strain = 0.5 * pulled.dot(&(covariance * &pulled));
            if !(strain.is_finite() && step.iter().all(|s| s.is_finite())) {
                return None;
            }
            update = Some(Self { step, weights, strain: strain.max(0.0) });
        }
        update
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{COULOMB, candidate};

    /// Against the Gaussian integral itself: residuals r = x − θ·j with θ ~ N(0, c), so that x ~ N(0, I + c·jjᵀ).
    #[test]
    fn exact_the_cost_is_that_of_the_integral_over_the_numbers() {
        let j = DVector::from_vec(vec![1.0, -2.0, 0.5]);
        let x = DVector::from_vec(vec![3.0, -5.0, 2.0]);
        let c = 0.7;
        let jacobian = DMatrix::from_columns(&[-&j]);
        let even = |left: &DVector<f64>| DVector::from_element(left.len(), 1.0);
        let update = Update::of(&x, &jacobian, &DMatrix::from_element(1, 1, c), even).unwrap();
        let left = &x + &jacobian * &update.step;
        let occam = occam(&jacobian, &even(&x), &DMatrix::from_element(1, 1, c)).unwrap();
        let found = -0.5 * left.norm_squared() - update.strain - occam;
        let covariance = DMatrix::identity(3, 3) + c * &j * j.transpose();
        let inverse = covariance.clone().try_inverse().unwrap();
        let expected = -0.5 * x.dot(&(inverse * &x)) - 0.5 * covariance.determinant().ln();
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }

    /// Numbers that are certain do not move and cost nothing.
    #[test]
    fn exact_certain_numbers_stay() {
        let jacobian = DMatrix::from_element(4, 2, 1.0);
        let even = |left: &DVector<f64>| DVector::from_element(left.len(), 1.0);
        let update =
            Update::of(&DVector::from_element(4, 3.0), &jacobian, &DMatrix::zeros(2, 2), even).unwrap();
        let occam = occam(&jacobian, &even(&DVector::zeros(4)), &DMatrix::zeros(2, 2));
        assert_eq!((update.step.norm(), update.strain, occam), (0.0, 0.0, Some(0.0)));
    }

    /// What the training runs leave as well is no matter of numbers, and a small gap is none either.
    #[test]
    fn exact_a_fit_to_both_is_asked_for_where_the_held_out_runs_leave_more() {
        let open = |training: f64, held_out: f64| {
            let fit = candidate(&[COULOMB], 1.0, training).fit;
            is_open(&fit, &Score::even(held_out))
        };
        assert!(open(1.0, 9.1) && open(5.0, 9.1) && open(0.5, 100.0));
        assert!(!open(1.0, 8.9) && !open(5.1, 9.1) && !open(60.0, 100.0));
    }
}
