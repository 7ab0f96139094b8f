//! Several pitches at once: each is estimated again beside the others until none moves.

use super::Screen;
use super::periodogram::{AS_MUCH, Grid, Moment, Pitch, pitches};
use super::screening::Base;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Samples used at most.
const MOST_SAMPLES: usize = 1000;
/// Pitches that a set is begun with, one after the other.
const BEGUN: usize = 2;
/// Rounds in which each pitch is estimated again at most.
const MOST_ROUNDS: usize = 8;
/// Spatial frequencies are at rest when none moves by more than this part of the grid's step.
const AT_REST: f64 = 1e-2;
/// Steps of the golden-section search around a frequency of the grid.
const SECTIONS: usize = 12;

/// Sets of `count` pitches that together explain most of `target`, each with the largest wave first.
///
/// # Model
/// RELAX: the pitch that explains most beside the others is added until there are `count`, then each is estimated again beside all
/// others, in the whole grid once and around its place thereafter, until none moves. Within a travel of few periods a wave
/// estimated alone takes up part of the others, and its second harmonic takes the place of another pitch.
///
/// # Validity
/// That of [`pitches`].
///
/// # Source
/// Li, Stoica (1996), *Efficient mixed-spectrum estimation with applications to target feature extraction*, IEEE Trans. Signal
/// Process. 44:281; over position instead of time, each wave with two harmonics.
pub(super) fn pitch_sets(
    screen: &Screen,
    target: &[f64],
    columns: impl Fn(f64, Moment) -> [f64; 4] + Sync,
    count: usize,
) -> Vec<Vec<Pitch>> {
    let Some(grid) = Grid::of(screen, target, MOST_SAMPLES) else { return Vec::new() };
    let waves = Waves { grid: &grid, columns: &columns };
    let first = pitches(screen, target, |rate, m| columns(rate, m).to_vec(), BEGUN);
    let mut sets: Vec<Vec<Pitch>> = Vec::new();
    for pitch in first {
        let Some(mut set) = waves.pitches(&waves.relaxed(1.0 / pitch.period, count)) else { continue };
        set.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let is_same =
            |(a, b): (&Pitch, &Pitch)| (1.0 / a.period - 1.0 / b.period).abs() < AT_REST * grid.spacing();
        if !sets.iter().any(|other| other.iter().zip(&set).all(is_same)) {
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

impl<C: Fn(f64, Moment) -> [f64; 4] + Sync> Waves<'_, C> {
    /// The spatial frequencies at rest that begin with this one.
    fn relaxed(&self, first: f64, count: usize) -> Vec<f64> {
        let mut frequencies = vec![first];
        while frequencies.len() < count {
            frequencies.push(self.strongest(&self.beside(&frequencies, None)));
        }
        for round in 0..MOST_ROUNDS {
            let before = frequencies.clone();
            for k in 0..frequencies.len() {
                let others = self.beside(&frequencies, Some(k));
                frequencies[k] = match round {
                    0 => self.strongest(&others),
                    _ => self.undoubled(self.refined(frequencies[k], &others), &others),
                };
            }
            let moved = |(a, b): (&f64, &f64)| (a - b).abs() > AT_REST * self.grid.spacing();
            if round > 0 && !before.iter().zip(&frequencies).any(moved) {
                break;
            }
        }
        frequencies
    }

    /// What every start needs, with the waves of all frequencies but one.
    fn beside(&self, frequencies: &[f64], but: Option<usize>) -> Base {
        let others = frequencies.iter().enumerate().filter(|(k, _)| Some(*k) != but);
        let blocks: Vec<DMatrix<f64>> = others.map(|(_, f)| self.block(*f)).collect();
        self.grid.base.with(&blocks)
    }

    /// The columns of a wave.
    fn block(&self, frequency: f64) -> DMatrix<f64> {
        let moments = &self.grid.moments;
        let rows: Vec<[f64; 4]> = moments.iter().map(|m| (self.columns)(TAU * frequency, *m)).collect();
        DMatrix::from_fn(rows.len(), 4, |row, column| rows[row][column])
    }

    /// Sum of squares that a wave explains beside others.
    fn gain(&self, frequency: f64, beside: &Base) -> f64 {
        self.grid.explained(&self.block(frequency), beside).map_or(0.0, |(gain, _)| gain)
    }

    /// The frequency that explains most beside others.
    fn strongest(&self, beside: &Base) -> f64 {
        let gains: Vec<(f64, f64)> =
            self.grid.frequencies.par_iter().map(|&f| (f, self.gain(f, beside))).collect();
        let best = gains.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |(f, _)| f);
        self.undoubled(self.refined(best, beside), beside)
    }

    /// A frequency, or its second harmonic where that explains as much by itself.
    fn undoubled(&self, mut frequency: f64, beside: &Base) -> f64 {
        let highest = self.grid.frequencies.last().copied().unwrap_or(frequency);
        let explains_as_much = |f: f64| self.gain(2.0 * f, beside) > AS_MUCH * self.gain(f, beside);
        while 2.0 * frequency <= highest && explains_as_much(frequency) {
            frequency = self.refined(2.0 * frequency, beside);
        }
        frequency
    }

    /// The frequency that explains most within one step of the grid, by golden section.
    fn refined(&self, frequency: f64, beside: &Base) -> f64 {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (lowest, step) =
            (self.grid.frequencies.first().copied().unwrap_or(frequency), self.grid.spacing());
        let (mut low, mut high) = ((frequency - step).max(lowest), frequency + step);
        let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
        let [mut a, mut b] = inner(low, high);
        let (mut at_a, mut at_b) = (self.gain(a, beside), self.gain(b, beside));
        for _ in 0..SECTIONS {
            if at_a > at_b {
                (high, b, at_b) = (b, a, at_a);
                a = inner(low, high)[0];
                at_a = self.gain(a, beside);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = inner(low, high)[1];
                at_b = self.gain(b, beside);
            }
        }
        0.5 * (low + high)
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
