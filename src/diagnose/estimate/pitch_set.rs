//! Several pitches at once, from the missing force along the motion.

use super::Screen;
use super::periodogram::{Grid, Moment, Pitch, pitches};
use super::relax::{Spectrum, is_same, relaxed};
use super::screening::Base;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Samples used at most.
const MOST_SAMPLES: usize = 1000;
/// Pitches that a set is begun with, one after the other.
const BEGUN: usize = 2;
/// Sets of `count` pitches that together explain most of `target`, each with the largest wave first.
///
/// # Model
/// [`relaxed`] over the periodogram of [`pitches`].
///
/// # Validity
/// That of [`pitches`].
pub(super) fn pitch_sets(
    screen: &Screen,
    target: &[f64],
    columns: impl Fn(f64, Moment) -> [f64; 4] + Sync,
    count: usize,
) -> Vec<Vec<Pitch>> {
    let Some(grid) = Grid::of(screen, target, MOST_SAMPLES) else { return Vec::new() };
    let waves = Waves { grid: &grid, columns: &columns };
    let first = pitches(screen, target, &columns, BEGUN);
    let mut sets: Vec<Vec<Pitch>> = Vec::new();
    for pitch in first {
        let Some(mut set) = waves.pitches(&relaxed(&waves, 1.0 / pitch.period, count)) else { continue };
        set.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let frequencies = |set: &[Pitch]| set.iter().map(|pitch| 1.0 / pitch.period).collect::<Vec<f64>>();
        if !sets.iter().any(|other| is_same(&waves, &frequencies(other), &frequencies(&set))) {
            sets.push(set);
        }
    }
    sets
}

/// Sum of the squares of a wave's coefficients.
fn size(pitch: &Pitch) -> f64 {
    pitch.coefficients.iter().map(|c| c * c).sum()
}

struct Waves<'a, C> {
    grid: &'a Grid,
    columns: &'a C,
}

impl<C: Fn(f64, Moment) -> [f64; 4] + Sync> Spectrum for Waves<'_, C> {
    type Beside = Base;

    fn frequencies(&self) -> &[f64] {
        &self.grid.frequencies
    }

    fn spacing(&self) -> f64 {
        self.grid.spacing()
    }

    fn beside(&self, frequencies: &[f64]) -> Base {
        let blocks: Vec<DMatrix<f64>> = frequencies.iter().map(|f| self.block(*f)).collect();
        self.grid.base.with(&blocks)
    }

    fn gain(&self, frequency: f64, beside: &Base) -> f64 {
        self.grid.explained(&self.block(frequency), beside).map_or(0.0, |(gain, _)| gain)
    }
}

impl<C: Fn(f64, Moment) -> [f64; 4] + Sync> Waves<'_, C> {
    /// The columns of a wave.
    fn block(&self, frequency: f64) -> DMatrix<f64> {
        let moments = &self.grid.moments;
        let rows: Vec<[f64; 4]> = moments.iter().map(|m| (self.columns)(TAU * frequency, *m)).collect();
        DMatrix::from_fn(rows.len(), 4, |row, column| rows[row][column])
    }

    /// The pitches of these frequencies with the coefficients of all of them together.
    fn pitches(&self, frequencies: &[f64]) -> Option<Vec<Pitch>> {
        let blocks: Vec<DMatrix<f64>> = frequencies.iter().map(|f| self.block(*f)).collect();
        let rows = self.grid.moments.len();
        let all =
            DMatrix::from_fn(rows, 4 * blocks.len(), |row, column| blocks[column / 4][(row, column % 4)]);
        let (gain, coefficients) = self.grid.explained(&all, &self.grid.base)?;
        let share = self.grid.share(gain);
        let own = |(f, c): (&f64, &[f64])| Pitch { period: 1.0 / f, coefficients: c.to_vec(), share };
        Some(frequencies.iter().zip(coefficients.chunks(4)).map(own).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::estimate::periodogram::tests::swinging;

    /// Two pitches of which one lies near the second harmonic of the other, on a travel of three periods: alone, the first takes the
    /// second one's wave for its own harmonic.
    #[test]
    fn exact_two_near_pitches_are_told_apart() {
        let screen = swinging(0.05);
        let waves = |x: &f64| {
            [(0.0343, 5.0, 0.4), (0.0181, 2.0, 1.3)]
                .map(|(p, a, phase): (f64, f64, f64)| a * (TAU * x / p + phase).sin())
        };
        let target: Vec<f64> = screen
            .position
            .iter()
            .zip(&screen.velocity)
            .map(|(x, v)| 3.0 * v + waves(x).iter().sum::<f64>())
            .collect();
        let columns = |rate: f64, m: Moment| {
            let (s, c) = (rate * m.position).sin_cos();
            [s, c, 2.0 * s * c, 1.0 - 2.0 * s * s]
        };
        let mut found: Vec<f64> =
            pitch_sets(&screen, &target, columns, 2)[0].iter().map(|p| p.period).collect();
        found.sort_by(f64::total_cmp);
        assert!(
            (found[0] / 0.0181 - 1.0).abs() < 1e-3 && (found[1] / 0.0343 - 1.0).abs() < 1e-3,
            "{found:?}"
        );
    }
}
