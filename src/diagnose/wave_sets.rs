//! Sets of waves that explain most together: every set of a grid is looked at.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Waves of a set lie at least so many places of the grid apart: nearer ones are one wave, their amplitudes large and opposite.
const APART: usize = 2;

/// Waves on a grid, with what a set of them is judged by.
///
/// # Model
/// A set with the columns M explains bᵀM·(MᵀGM)⁻¹·Mᵀb of a quadratic form with the matrix G and the right side b. A wave that is estimated alone
/// takes up part of others on a travel of few periods, and its harmonic stands for another one, so that steps from one wave to the next end in a
/// set that is not the best: with G and b small, all sets are quickly gone through.
pub struct WaveSets {
    /// MᵢᵀGMⱼ for j ≤ i.
    crossed: Vec<Vec<DMatrix<f64>>>,
    /// Mᵢᵀb.
    right: Vec<DVector<f64>>,
    columns: usize,
    ridge: f64,
}

/// A set and what it explains.
type Explained = (f64, Vec<usize>);

impl WaveSets {
    /// Waves with these columns, all equally many, in the order of the grid; `ridge` is added to the diagonal of normal matrices, as a share of
    /// their largest entry.
    pub fn new(waves: &[DMatrix<f64>], normal: &DMatrix<f64>, right: &DVector<f64>, ridge: f64) -> Self {
        let taken: Vec<DMatrix<f64>> = waves.iter().map(|wave| normal * wave).collect();
        let crossed = |(i, wave): (usize, &DMatrix<f64>)| {
            taken[..=i].iter().map(|taken| wave.tr_mul(taken)).collect::<Vec<_>>()
        };
        Self {
            crossed: waves.iter().enumerate().map(crossed).collect(),
            right: waves.iter().map(|wave| wave.tr_mul(right)).collect(),
            columns: waves.first().map_or(0, DMatrix::ncols),
            ridge,
        }
    }

    /// The `most` sets of `count` waves that explain most, best first; none is like a better one, each wave within a few places.
    pub fn best(&self, count: usize, most: usize) -> Vec<Vec<usize>> {
        let begun = (0..self.right.len()).into_par_iter();
        let mut all: Vec<Explained> = begun
            .flat_map_iter(|first| {
                let mut sets = Vec::new();
                self.extend(&mut vec![first], count, &mut sets);
                sets
            })
            .collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut best: Vec<Vec<usize>> = Vec::new();
        for (_, set) in all {
            let is_like = |other: &Vec<usize>| set.iter().zip(other).all(|(a, b)| a.abs_diff(*b) <= APART);
            if best.len() == most {
                break;
            }
            if !best.iter().any(is_like) {
                best.push(set);
            }
        }
        best
    }

    fn extend(&self, set: &mut Vec<usize>, count: usize, sets: &mut Vec<Explained>) {
        if set.len() == count {
            sets.extend(self.gain(set).map(|gain| (gain, set.clone())));
            return;
        }
        let next = set.last().map_or(0, |last| last + APART);
        for wave in next..self.right.len() {
            set.push(wave);
            self.extend(set, count, sets);
            set.pop();
        }
    }

    /// What a set explains, from the blocks of its pairs: the sets of a grid are thousands. None where its waves cannot be told apart.
    fn gain(&self, set: &[usize]) -> Option<f64> {
        let size = self.columns * set.len();
        let mut normal = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for (row, &i) in set.iter().enumerate() {
            right.rows_mut(row * self.columns, self.columns).copy_from(&self.right[i]);
            for (column, &j) in set.iter().enumerate().take(row + 1) {
                let at = (row * self.columns, column * self.columns);
                normal.view_mut(at, (self.columns, self.columns)).copy_from(&self.crossed[i][j]);
            }
        }
        let ridge = self.ridge * normal.diagonal().amax().max(f64::MIN_POSITIVE);
        for k in 0..size {
            normal[(k, k)] += ridge;
        }
        // Only the lower triangle is read.
        normal.cholesky()?.l_dirty().solve_lower_triangular(&right).map(|whitened| whitened.norm_squared())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Three pitches of which two lie about the second harmonic of the first, on a travel of one period of that: step by step the harmonic takes
    /// the place of both.
    #[test]
    fn exact_the_set_that_makes_the_data_is_the_best() {
        let places: Vec<f64> = (0..200).map(|k| f64::from(k) / 200.0).collect();
        let frequencies: Vec<f64> = (0..36).map(|k| 0.5 + 0.2 * f64::from(k)).collect();
        let wave = |f: f64| {
            DMatrix::from_fn(places.len(), 4, |row, k| {
                let (s, c) = (TAU * f * places[row] * (1 + k / 2) as f64).sin_cos();
                [s, c][k % 2]
            })
        };
        let waves: Vec<DMatrix<f64>> = frequencies.iter().map(|f| wave(*f)).collect();
        let amplitudes = |values: [f64; 4]| DVector::from_row_slice(&values);
        let data = &waves[3] * amplitudes([29.0, -10.0, 0.1, 10.0])
            + &waves[8] * amplitudes([0.7, -4.1, 0.1, 0.1])
            + &waves[11] * amplitudes([-7.0, 12.0, 1.8, -2.2]);
        let normal = DMatrix::identity(places.len(), places.len());
        let sets = WaveSets::new(&waves, &normal, &data, 1e-10);
        let best = sets.best(3, 3);
        assert_eq!((best[0].as_slice(), best.len()), (&[3, 8, 11][..], 3));
        let gain = |set: &[usize]| sets.gain(set).unwrap();
        assert!((gain(&[3, 8, 11]) / data.norm_squared() - 1.0).abs() < 1e-6);
        assert!(gain(&best[0]) >= gain(&best[1]) && gain(&best[1]) >= gain(&best[2]));
    }
}
