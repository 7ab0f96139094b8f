//! By how much numbers that a fit does not have would lower its sum of squares.

use super::objective::Objective;
use super::sandwich::inverted;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Normal equations of further numbers beside those of a fit.
///
/// # Model
/// The normalised residuals r (no unit, predicted less measured) change with the further numbers a by R·a. With J the derivatives by the numbers of
/// the fit, W the weights and N = JᵀWJ + prior:
/// ```text
///   G = Rᵀ(W − W·J·N⁻¹·Jᵀ·W)·R,   b = −RᵀWr + RᵀWJ·N⁻¹·(gradient),   a = G⁻¹·b,   gain = bᵀG⁻¹b
/// ```
/// The gain is by how much a fit of a, and of its own numbers with it, lowers the weighted sum of squares.
///
/// # Validity
/// To first order in all numbers.
///
/// # Source
/// The score test: C. R. Rao (1948), Math. Proc. Cambridge Philos. Soc. 44:50.
pub struct ScoreTest {
    /// G.
    pub normal: DMatrix<f64>,
    /// b.
    pub right: DVector<f64>,
}

impl ScoreTest {
    /// Of responses R, one column a number, of a fit with these values, residuals and derivatives.
    pub fn of(
        objective: &Objective,
        values: &[f64],
        residuals: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        responses: &DMatrix<f64>,
    ) -> Self {
        let weights = objective.weights(residuals);
        let own = objective.normal(jacobian, residuals, &weights, values);
        Self::beside(own, [jacobian, responses], residuals, &weights)
    }

    /// G and b of each response as if it were the only one.
    pub fn each(
        objective: &Objective,
        values: &[f64],
        residuals: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        responses: &[DVector<f64>],
    ) -> Vec<[f64; 2]> {
        let weights = objective.weights(residuals);
        let own = objective.normal(jacobian, residuals, &weights, values);
        Self::each_beside(own, jacobian, responses, residuals, &weights)
    }

    /// The same from N and the gradient of the fit.
    fn each_beside(
        (normal, gradient): (DMatrix<f64>, DVector<f64>),
        jacobian: &DMatrix<f64>,
        responses: &[DVector<f64>],
        residuals: &DVector<f64>,
        weights: &DVector<f64>,
    ) -> Vec<[f64; 2]> {
        let inverse = inverted(&normal);
        let one = |response: &DVector<f64>| {
            let weighted = response.component_mul(weights);
            let cross = jacobian.tr_mul(&weighted);
            let taken = &inverse * &cross;
            [weighted.dot(response) - taken.dot(&cross), taken.dot(&gradient) - weighted.dot(residuals)]
        };
        responses.par_iter().map(one).collect()
    }

    /// G and b of all responses together, from N and the gradient of the fit.
    fn beside(
        (normal, gradient): (DMatrix<f64>, DVector<f64>),
        [jacobian, responses]: [&DMatrix<f64>; 2],
        residuals: &DVector<f64>,
        weights: &DVector<f64>,
    ) -> Self {
        let count = responses.ncols();
        let products = |k: usize| {
            let weighted = responses.column(k).component_mul(weights);
            // RᵀWR is symmetric.
            let with = (0..=k).map(|j| weighted.dot(&responses.column(j))).collect();
            (with, jacobian.tr_mul(&weighted), weighted.dot(residuals))
        };
        let rows: Vec<(Vec<f64>, DVector<f64>, f64)> = (0..count).into_par_iter().map(products).collect();
        let own = DMatrix::from_fn(count, count, |a, b| rows[a.max(b)].0[a.min(b)]);
        let beside = DMatrix::from_fn(count, normal.nrows(), |k, number| rows[k].1[number]);
        let pull = DVector::from_fn(count, |k, _| rows[k].2);
        let cross = &beside * inverted(&normal);
        Self { normal: own - &cross * beside.transpose(), right: cross * gradient - pull }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against linear least squares with the further number and without it, the fit itself not at its minimum.
    #[test]
    fn exact_the_gain_is_the_fall_of_the_sum_of_squares() {
        let rows = 7;
        let of =
            |column: usize| DVector::from_fn(rows, |k, _| ((k * k + 3 * column * k + column) as f64).sin());
        let (jacobian, response, residuals) = (DMatrix::from_columns(&[of(1), of(2)]), of(3), of(4));
        let weights = DVector::from_fn(rows, |k, _| 1.0 + k as f64);
        let weighted = |matrix: &DMatrix<f64>| DMatrix::from_diagonal(&weights) * matrix;
        let least = |columns: &DMatrix<f64>| {
            let (normal, pull) = (weighted(columns).tr_mul(columns), weighted(columns).tr_mul(&residuals));
            let left = &residuals - columns * inverted(&normal) * pull;
            left.component_mul(&weights).dot(&left)
        };
        let own = (weighted(&jacobian).tr_mul(&jacobian), weighted(&jacobian).tr_mul(&residuals));
        let responses = DMatrix::from_columns(std::slice::from_ref(&response));
        let test = ScoreTest::beside(own.clone(), [&jacobian, &responses], &residuals, &weights);
        let alone =
            ScoreTest::each_beside(own, &jacobian, std::slice::from_ref(&response), &residuals, &weights);
        let [g, b] = alone[0];
        assert!((g - test.normal[(0, 0)]).abs() < 1e-9 && (b - test.right[0]).abs() < 1e-9, "{g} {b}");
        let gain = test.right[0].powi(2) / test.normal[(0, 0)];
        let all = DMatrix::from_columns(&[of(1), of(2), response]);
        assert!((gain - (least(&jacobian) - least(&all))).abs() < 1e-9, "{gain}");
    }
}
