//! Normal matrix of a fit and the scatter of its gradient: what residuals that are autocorrelated and uneven make of the errors of its numbers.

use super::objective::Objective;
use crate::singular::decomposed;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Blocks of consecutive samples, over all runs together at least.
const BLOCKS: usize = 40;
/// Smallest singular value of a correlation matrix that is more than rounding.
const ROUNDING: f64 = 1e-14;

/// Sum over blocks b of consecutive samples of `g_b·g_bᵀ`, with g_b what the block adds to the gradient JᵀWr of half the sum of squares; `pulls` is W·r.
///
/// # Source
/// H. White (1980), *A heteroskedasticity-consistent covariance matrix estimator*, Econometrica 48:817; sums over blocks as for clustered samples.
pub(super) fn scatter(objective: &Objective, jacobian: &DMatrix<f64>, pulls: &DVector<f64>) -> DMatrix<f64> {
    scatter_over(&blocks(objective), jacobian, pulls)
}

fn scatter_over(blocks: &[Vec<Range<usize>>], jacobian: &DMatrix<f64>, pulls: &DVector<f64>) -> DMatrix<f64> {
    let count = jacobian.ncols();
    let mut scatter = DMatrix::zeros(count, count);
    for block in blocks {
        let product = |k: usize, Range { start, end }: &Range<usize>| {
            jacobian.column(k).rows_range(*start..*end).dot(&pulls.rows_range(*start..*end))
        };
        let gradient = DVector::from_fn(count, |k, _| block.iter().map(|range| product(k, range)).sum());
        scatter.ger(1.0, &gradient, &gradient, 1.0);
    }
    scatter
}

/// Rows of each block: the same stretch of time in every signal of a run.
fn blocks(objective: &Objective) -> Vec<Vec<Range<usize>>> {
    let total: usize = objective.experiments.iter().map(|e| objective.rows(e)).sum();
    let length = total.div_ceil(BLOCKS).max(1);
    let mut offset = 0;
    let mut all = Vec::new();
    for experiment in objective.experiments {
        let samples = objective.rows(experiment);
        let signals = experiment.signals().len();
        for from in (0..samples).step_by(length) {
            let to = (from + length).min(samples);
            all.push((0..signals).map(|s| offset + s * samples + from..offset + s * samples + to).collect());
        }
        offset += samples * signals;
    }
    all
}

/// The inverse of a normal matrix; of numbers that do nothing, and of combinations that do nothing to rounding, zero.
///
/// It is taken of the correlation matrix: numbers are in units of their own, and one that the data tell a million times better than another
/// does not make the other one nothing.
pub(super) fn inverted(normal: &DMatrix<f64>) -> DMatrix<f64> {
    // Those that do nothing stay out: rounding would mix them into what the data hardly tell.
    let told: Vec<usize> = (0..normal.nrows()).filter(|&k| normal[(k, k)] > 0.0).collect();
    let size = |k: usize| normal[(k, k)].sqrt();
    let scaled = |a: usize, b: usize| normal[(a, b)] / (size(a) * size(b));
    let correlation = DMatrix::from_fn(told.len(), told.len(), |a, b| scaled(told[a], told[b]));
    let mut inverse = DMatrix::zeros(normal.nrows(), normal.nrows());
    let Some(part) = decomposed(correlation).and_then(|parts| parts.pseudo_inverse(ROUNDING).ok()) else {
        return inverse;
    };
    for (i, &a) in told.iter().enumerate() {
        for (j, &b) in told.iter().enumerate() {
            inverse[(a, b)] = part[(i, j)] / (size(a) * size(b));
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two numbers in very different units each has its own variance; one that does nothing has none.
    #[test]
    fn exact_the_inverse_does_not_depend_on_units() {
        let normal = DMatrix::from_row_slice(3, 3, &[4e18, 1e9, 0.0, 1e9, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let inverse = inverted(&normal);
        let determinant = 4e18 - 1e18;
        for (place, expected) in
            [((0, 0), 1.0 / determinant), ((1, 1), 4e18 / determinant), ((0, 1), -1e9 / determinant)]
        {
            assert!((inverse[place] / expected - 1.0).abs() < 1e-9, "{place:?}: {}", inverse[place]);
        }
        assert_eq!(inverse[(2, 2)], 0.0);
    }

    /// Of 1200 residuals of ±1 the scatter is 1200 where their signs are independent; those that keep their sign for 30 samples have 30 times that, and
    /// alternating ones none.
    #[test]
    fn exact_autocorrelation_multiplies_the_scatter() {
        let (count, kept) = (1200, 30);
        let block = |b: usize| std::iter::once(b * kept..(b + 1) * kept).collect();
        let blocks: Vec<Vec<Range<usize>>> = (0..count / kept).map(block).collect();
        let of = |sign: &dyn Fn(usize) -> bool| {
            let pulls = DVector::from_fn(count, |k, _| if sign(k) { 1.0 } else { -1.0 });
            scatter_over(&blocks, &DMatrix::from_element(count, 1, 1.0), &pulls)[(0, 0)]
        };
        assert_eq!(of(&|k| (k / kept) % 2 == 0), (count * kept) as f64);
        assert_eq!(of(&|k| k % 2 == 0), 0.0);
    }

    /// A hypothesis without numbers, and one whose numbers do nothing, have nothing to invert.
    #[test]
    fn exact_nothing_is_inverted_to_nothing() {
        for count in [0, 2] {
            let normal = DMatrix::zeros(count, count);
            assert_eq!(inverted(&normal), normal);
        }
    }
}
