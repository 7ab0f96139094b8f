//! Singular values, of matrices that may hold anything.

use nalgebra::{DMatrix, Dyn, SVD};

/// A decomposition converges in a few iterations a column; one of numbers that are none never does.
const MOST_ITERATIONS: usize = 10_000;
/// Relative size of what is left when it has converged.
const CONVERGED: f64 = 5.0 * f64::EPSILON;

/// The singular value decomposition U·Σ·Vᵀ of a matrix; none where there is no entry, or one is not finite, or it does not converge.
pub fn decomposed(matrix: DMatrix<f64>) -> Option<SVD<f64, Dyn, Dyn>> {
    let is_sound = !matrix.is_empty() && matrix.iter().all(|x| x.is_finite());
    is_sound.then(|| SVD::try_new(matrix, true, true, CONVERGED, MOST_ITERATIONS)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_singular_values_of_a_known_matrix_and_none_of_what_is_not_finite_or_empty() {
        assert!(decomposed(DMatrix::zeros(0, 0)).is_none() && decomposed(DMatrix::zeros(3, 0)).is_none());
        let values = |entries: [f64; 4]| {
            decomposed(DMatrix::from_row_slice(2, 2, &entries)).map(|svd| svd.singular_values)
        };
        let found = values([0.0, 3.0, 4.0, 0.0]).unwrap();
        assert!((found[0] - 4.0).abs() < 1e-14 && (found[1] - 3.0).abs() < 1e-14);
        assert!(
            values([f64::NAN, 0.0, 0.0, 1.0]).is_none() && values([f64::INFINITY, 1.0, 1.0, 1.0]).is_none()
        );
    }
}
