//! Nonlinear least squares with bounds.

use super::excitation::{Excitation, NotExcited, Outcome};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// Steps after which a descent ends in any case.
const MOST_STEPS: usize = 40;
/// Relative fall of the sum of squares below which it has arrived.
const ARRIVED: f64 = 1e-9;
/// Damping of the first step, and its range.
const DAMPING: [f64; 3] = [1e-3, 1e-12, 1e9];

/// A number to be found.
#[derive(Debug, Clone, PartialEq)]
pub struct Unknown {
    /// What it is called.
    pub name: String,
    /// Where the search begins.
    pub start: f64,
    /// From, to.
    pub range: (f64, f64),
    /// Change from which the derivative is taken: small beside what the model bends over, large beside rounding.
    pub step: f64,
}

/// The least-squares solution.
#[derive(Debug, Clone)]
pub struct Solution {
    /// One a number.
    pub values: Vec<f64>,
    /// Residuals there.
    pub residuals: DVector<f64>,
    /// Derivatives of the residuals, one column a number.
    pub jacobian: DMatrix<f64>,
    /// Condition number of the column-scaled Jacobian.
    pub condition: f64,
}

/// Finds the numbers that make the sum of squared residuals least.
///
/// # Model
/// θ = argmin Σ r(θ)² within the ranges, by Levenberg and Marquardt: (JᵀJ + λ·diag JᵀJ)·δ = −Jᵀr, J from differences
/// over the stated steps; a number on the edge of its range whose gradient points outward is held.
///
/// # Validity
/// A local minimum: the start must lie in its valley.
///
/// # Source
/// Marquardt, *J. Soc. Indust. Appl. Math.* 11 (1963) 431.
///
/// # Errors
/// What the residuals refuse.
pub fn solve(
    unknowns: &[Unknown],
    remedy: &str,
    residuals: impl Fn(&[f64]) -> Result<DVector<f64>>,
) -> Result<Outcome<Solution>> {
    let inside = |k: usize, value: f64| value.clamp(unknowns[k].range.0, unknowns[k].range.1);
    let mut values: Vec<f64> = unknowns.iter().enumerate().map(|(k, u)| inside(k, u.start)).collect();
    let mut now = residuals(&values)?;
    let mut damping = DAMPING[0];
    let mut slopes = jacobian(unknowns, &values, &now, &residuals)?;
    for _ in 0..MOST_STEPS {
        let (normal, gradient) = (slopes.tr_mul(&slopes), slopes.tr_mul(&now));
        let is_held = |k: usize| {
            (values[k] <= unknowns[k].range.0 && gradient[k] > 0.0)
                || (values[k] >= unknowns[k].range.1 && gradient[k] < 0.0)
        };
        let held: Vec<bool> = (0..values.len()).map(is_held).collect();
        let mut fall = None;
        while damping < DAMPING[2] {
            let Some(step) = damped(&normal, &gradient, &held, damping) else {
                damping *= 10.0;
                continue;
            };
            let moved: Vec<f64> = (0..values.len()).map(|k| inside(k, values[k] + step[k])).collect();
            let trial = residuals(&moved)?;
            let (before, after) = (now.norm_squared(), trial.norm_squared());
            if after < before {
                fall = Some((before - after) / before);
                (values, now) = (moved, trial);
                damping = (0.1 * damping).max(DAMPING[1]);
                break;
            }
            damping *= 10.0;
        }
        let Some(fall) = fall else { break };
        slopes = jacobian(unknowns, &values, &now, &residuals)?;
        if fall < ARRIVED {
            break;
        }
    }
    let excitation = Excitation::of(&slopes)?;
    if !excitation.is_full_rank() {
        let names: Vec<String> = unknowns.iter().map(|unknown| unknown.name.clone()).collect();
        let refusal: NotExcited = excitation.refusal(&names, remedy);
        return Ok(Outcome::NotExcited(refusal));
    }
    let condition = excitation.condition();
    Ok(Outcome::Identified(Solution { values, residuals: now, jacobian: slopes, condition }))
}

/// Derivatives by differences, towards the inside of the range.
fn jacobian(
    unknowns: &[Unknown],
    values: &[f64],
    now: &DVector<f64>,
    residuals: &impl Fn(&[f64]) -> Result<DVector<f64>>,
) -> Result<DMatrix<f64>> {
    let mut slopes = DMatrix::zeros(now.len(), values.len());
    for (k, unknown) in unknowns.iter().enumerate() {
        let step = if values[k] + unknown.step <= unknown.range.1 { unknown.step } else { -unknown.step };
        let mut moved = values.to_vec();
        moved[k] += step;
        slopes.set_column(k, &((residuals(&moved)? - now) / step));
    }
    Ok(slopes)
}

fn damped(
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    held: &[bool],
    damping: f64,
) -> Option<DVector<f64>> {
    let mut matrix = normal.clone();
    let mut right = -gradient;
    for (k, held) in held.iter().enumerate() {
        matrix[(k, k)] += damping * normal[(k, k)].max(f64::MIN_POSITIVE);
        if *held {
            matrix.row_mut(k).fill(0.0);
            matrix.column_mut(k).fill(0.0);
            matrix[(k, k)] = 1.0;
            right[k] = 0.0;
        }
    }
    // Numbers of very different size: scaled to a unit diagonal before the factorisation.
    let scale = DVector::from_fn(right.len(), |k, _| matrix[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip());
    let scaled = DMatrix::from_diagonal(&scale) * matrix * DMatrix::from_diagonal(&scale);
    let solution = scaled.cholesky()?.solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknown(name: &str, start: f64, range: (f64, f64)) -> Unknown {
        Unknown { name: name.to_owned(), start, range, step: 1e-6 }
    }

    /// y = a·e^(−b·t), a = 2, b = 3.
    fn decay(values: &[f64]) -> Result<DVector<f64>> {
        let t = |k: usize| 0.02 * k as f64;
        let model = |k: usize| values[0] * (-values[1] * t(k)).exp() - 2.0 * (-3.0 * t(k)).exp();
        Ok(DVector::from_fn(100, |k, _| model(k)))
    }

    #[test]
    fn exact_a_decay_is_found_again() {
        let unknowns = [unknown("a", 1.0, (0.0, 10.0)), unknown("b", 1.0, (0.0, 10.0))];
        let found = solve(&unknowns, "", decay).unwrap().identified().unwrap();
        assert!((found.values[0] - 2.0).abs() < 1e-6 && (found.values[1] - 3.0).abs() < 1e-6);
    }

    #[test]
    fn exact_a_bound_holds() {
        let unknowns = [unknown("a", 1.0, (0.0, 10.0)), unknown("b", 1.0, (0.0, 2.5))];
        let found = solve(&unknowns, "", decay).unwrap().identified().unwrap();
        assert_eq!(found.values[1], 2.5);
    }

    #[test]
    fn exact_numbers_that_only_their_sum_shows_are_refused() {
        let unknowns = [unknown("a", 1.0, (-9.0, 9.0)), unknown("b", 1.0, (-9.0, 9.0))];
        let line = |values: &[f64]| Ok(DVector::from_fn(50, |k, _| (values[0] + values[1] - 3.0) * k as f64));
        let Outcome::NotExcited(refused) = solve(&unknowns, "move", line).unwrap() else {
            panic!("a sum tells neither part");
        };
        assert_eq!(refused.remedy, "move");
    }
}
