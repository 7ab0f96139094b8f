//! Columns that are perpendicular to each other.

use nalgebra::DMatrix;

/// Gram–Schmidt; a column that the others explain becomes zero.
pub(super) fn orthonormal(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    for c in 0..matrix.ncols() {
        let full = matrix.column(c).norm();
        for before in 0..c {
            let share = matrix.column(before).dot(&matrix.column(c));
            let other = matrix.column(before).into_owned();
            matrix.column_mut(c).axpy(-share, &other, 1.0);
        }
        let norm = matrix.column(c).norm();
        let scale = if norm > 1e-9 * full && norm > 0.0 { 1.0 / norm } else { 0.0 };
        matrix.column_mut(c).scale_mut(scale);
    }
    matrix
}
