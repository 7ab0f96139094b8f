//! What each residual weighs where it is predicted and not fitted.

use super::evidence::Score;
use super::objective::Objective;
use nalgebra::DVector;

/// The weight of each residual, 1/(v·τ·m): v the mean square of its signal among these residuals, at least that of the signal's noise, τ the lag-summed
/// autocorrelation that a score has of it, m the number of signals.
pub(super) fn weights(objective: &Objective, score: &Score, residuals: &DVector<f64>) -> DVector<f64> {
    let counted = score.counted();
    let share = 1.0 / counted.len().max(1) as f64;
    let mut weights = DVector::zeros(residuals.len());
    for (signal, inflation) in counted {
        let rows = objective.rows_of(signal);
        let count = rows.iter().map(ExactSizeIterator::len).sum::<usize>().max(1) as f64;
        let squares: f64 = rows.iter().flat_map(Clone::clone).map(|row| residuals[row].powi(2)).sum();
        let weight = share / ((squares / count).max(score.least(signal)) * inflation);
        rows.into_iter().flatten().for_each(|row| weights[row] = weight);
    }
    weights
}

/// Weighted sum of squares of residuals.
pub(super) fn squares(residuals: &DVector<f64>, weights: &DVector<f64>) -> f64 {
    residuals.component_mul(weights).dot(residuals)
}
