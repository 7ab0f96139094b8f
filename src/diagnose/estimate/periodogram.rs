//! Pitches that are not known beforehand: a periodogram over position.

use super::Screen;
use super::screening::Base;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// One moving sample of the training runs, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Position.
    pub position: f64,
    /// Velocity.
    pub velocity: f64,
    /// Acceleration.
    pub acceleration: f64,
    /// Motor force or torque from current or voltage.
    pub drive_force: f64,
}

/// A pitch with the coefficients that belong to its columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Pitch {
    /// Pitch in m or rad.
    pub period: f64,
    /// Coefficients of the columns at this pitch.
    pub coefficients: Vec<f64>,
    /// Share of the target's mean square, base taken out, that they explain.
    pub share: f64,
}

/// Pitches tried at most.
const MOST_PITCHES: usize = 500;
/// Spatial frequencies lie this part of the resolution (one over the travel) apart.
const OVERSAMPLING: f64 = 5.0;
/// Samples used at most.
const MOST_SAMPLES: usize = 2500;
/// The smoothing of the missing force passes changes up to about this frequency, in Hz.
pub(super) const PASSED_HZ: f64 = 80.0;
/// Pitches are harmonics of each other within this share.
const SAME_PITCH: f64 = 0.1;
/// Share of what a pitch explains that its harmonic must explain to stand for it.
pub(super) const AS_MUCH: f64 = 0.9;
/// Samples with less than this share of the largest acceleration move at an even pace.
const EVEN_PACE: f64 = 0.1;
/// Where so large a share of the moving samples does, the others are left out.
const ENOUGH: f64 = 0.5;
/// A pitch is a peak if no better one lies this many grid points around it.
const PEAK_WIDTH: usize = 4;

/// The pitches that the machine's file states, then those that explain most of `target`, best first, at most `most` of them.
///
/// # Model
/// For each pitch p of a grid that is even in 1/p, `target ≈ base·b + columns(2π/p)·c` by least squares over the
/// moving samples (those of ramps left out where most move at an even pace); what the columns explain beyond the base (acceleration, velocity, direction, constant) ranks the
/// pitches.
///
/// # Validity
/// Pitches from those that pass at 80 Hz at slow speed up to [`Screen::longest_pitch`].
///
/// # Source
/// Lomb (1976), least-squares frequency analysis, over position instead of time.
pub fn pitches<const N: usize>(
    screen: &Screen,
    target: &[f64],
    columns: impl Fn(f64, Moment) -> [f64; N],
    most: usize,
) -> Vec<Pitch> {
    let Some(grid) = Grid::of(screen, target, MOST_SAMPLES) else { return Vec::new() };
    let found: Vec<(f64, f64, Vec<f64>)> = grid
        .frequencies
        .iter()
        .filter_map(|&f| grid.explain(TAU * f, &columns).map(|(gain, c)| (f, gain, c)))
        .collect();
    let is_peak = |k: usize| {
        let around = k.saturating_sub(PEAK_WIDTH)..(k + PEAK_WIDTH + 1).min(found.len());
        around.into_iter().all(|j| found[j].1 <= found[k].1)
    };
    let mut peaks: Vec<usize> = (0..found.len()).filter(|&k| is_peak(k)).collect();
    peaks.sort_by(|&a, &b| found[b].1.total_cmp(&found[a].1));
    // A pitch whose harmonic explains as much is that harmonic's, counted twice.
    let doubled = |k: usize| {
        peaks
            .iter()
            .any(|&j| (found[j].0 / found[k].0 - 2.0).abs() < SAME_PITCH && found[j].1 > AS_MUCH * found[k].1)
    };
    let pitch = |frequency: f64, gain: f64, coefficients: Vec<f64>| Pitch {
        period: 1.0 / frequency,
        coefficients,
        share: grid.share(gain),
    };
    let stated = screen.stated_pitches().into_iter().filter_map(|period| {
        grid.explain(TAU / period, &columns).map(|(gain, c)| pitch(1.0 / period, gain, c))
    });
    let seen = peaks.iter().copied().filter(|&k| !doubled(k)).take(most);
    stated.chain(seen.map(|k| pitch(found[k].0, found[k].1, found[k].2.clone()))).collect()
}

/// Moving samples with a target, and the spatial frequencies that they can tell.
pub(super) struct Grid {
    pub(super) moments: Vec<Moment>,
    pub(super) base: Base,
    target: DVector<f64>,
    /// Target with the base taken out.
    rest: DVector<f64>,
    /// Spatial frequencies, one over a pitch each, evenly spaced.
    pub(super) frequencies: Vec<f64>,
}

impl Grid {
    /// The grid of at most so many samples.
    pub(super) fn of(screen: &Screen, target: &[f64], most_samples: usize) -> Option<Self> {
        let moving = cruising(screen, target.len());
        let every = moving.len().div_ceil(most_samples).max(1);
        let chosen: Vec<usize> = moving.into_iter().step_by(every).collect();
        if chosen.len() < 40 {
            return None;
        }
        let force = |k: usize| screen.drive_force.get(k).copied().unwrap_or(0.0);
        let moments: Vec<Moment> = chosen
            .iter()
            .map(|&k| Moment {
                position: screen.position[k],
                velocity: screen.velocity[k],
                acceleration: screen.acceleration[k],
                drive_force: force(k),
            })
            .collect();
        let motion = moments.iter().map(|m| [m.acceleration, m.velocity, m.velocity.signum()]);
        let base = Base::of(&motion.collect::<Vec<_>>());
        let wanted = DVector::from_iterator(chosen.len(), chosen.iter().map(|&k| target[k]));
        let rest = base.rest_of(&wanted);
        let frequencies = frequencies(&moments, screen.longest_pitch())?;
        Some(Self { moments, base, target: wanted, rest, frequencies })
    }

    /// Sum of squares that the columns explain, and their coefficients.
    fn explain<const N: usize>(
        &self,
        rate: f64,
        columns: &impl Fn(f64, Moment) -> [f64; N],
    ) -> Option<(f64, Vec<f64>)> {
        let mut matrix = DMatrix::zeros(self.moments.len(), N);
        for (row, moment) in self.moments.iter().enumerate() {
            columns(rate, *moment).into_iter().enumerate().for_each(|(k, value)| matrix[(row, k)] = value);
        }
        self.explained(&matrix, &self.base)
    }

    /// The same of given columns beside another base.
    pub(super) fn explained(&self, columns: &DMatrix<f64>, base: &Base) -> Option<(f64, Vec<f64>)> {
        let (matrix, width) = (base.rest_of_each(columns), columns.ncols());
        let gram = matrix.tr_mul(&matrix);
        let size = gram.diagonal().max();
        // The columns have nothing of the base left, so that the target may have it.
        let right = matrix.tr_mul(&self.target);
        // Columns that the base all but explains would blow up: a ridge far below any real column.
        let ridge = DMatrix::from_diagonal_element(width, width, 1e-6 * size.max(f64::MIN_POSITIVE));
        let solution = (gram + ridge).cholesky()?.solve(&right);
        Some((solution.dot(&right), solution.iter().copied().collect()))
    }

    /// A sum of squares as a share of the target's, base taken out.
    pub(super) fn share(&self, gain: f64) -> f64 {
        gain / self.rest.norm_squared().max(f64::MIN_POSITIVE)
    }

    /// From one spatial frequency to the next.
    pub(super) fn spacing(&self) -> f64 {
        match self.frequencies[..] {
            [first, second, ..] => second - first,
            _ => 0.0,
        }
    }
}

/// The moving samples, without those of ramps where enough others are left: where acceleration takes most of the force, a
/// fraction of a sample between force and motion is more than what repeats along the axis.
fn cruising(screen: &Screen, count: usize) -> Vec<usize> {
    let direction = screen.directions();
    let moving: Vec<usize> = (0..count.min(direction.len())).filter(|&k| direction[k] != 0.0).collect();
    let most = screen.acceleration.iter().fold(0.0, |most, a| f64::max(most, a.abs()));
    let is_even = |k: &usize| screen.acceleration[*k].abs() <= EVEN_PACE * most;
    let even: Vec<usize> = moving.iter().copied().filter(is_even).collect();
    if even.len() as f64 >= ENOUGH * moving.len() as f64 { even } else { moving }
}

fn frequencies(moments: &[Moment], longest: f64) -> Option<Vec<f64>> {
    let positions = moments.iter().map(|m| m.position);
    let (low, high) =
        positions.fold((f64::MAX, f64::MIN), |(low, high), x| (f64::min(low, x), f64::max(high, x)));
    let travel = high - low;
    let mut speeds: Vec<f64> = moments.iter().map(|m| m.velocity.abs()).collect();
    let place = speeds.len() / 5;
    let slow = *speeds.select_nth_unstable_by(place, f64::total_cmp).1;
    if !(travel > 0.0 && slow > 0.0) {
        return None;
    }
    let (from, to) = (1.0 / longest, PASSED_HZ / slow);
    let count = ((to - from) * OVERSAMPLING * travel).clamp(1.0, MOST_PITCHES as f64) as usize;
    // Where the grid is cut short it keeps its resolution: the longest pitches are the likeliest.
    Some((0..count).map(|k| from + k as f64 / (OVERSAMPLING * travel)).collect())
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Four seconds of a sine of 2 rad/s.
    pub(in crate::diagnose::estimate) fn swinging(amplitude: f64) -> Screen {
        let angle = |k: usize| 2e-3 * k as f64;
        Screen {
            position: (0..4000).map(|k| amplitude * angle(k).sin()).collect(),
            velocity: (0..4000).map(|k| 2.0 * amplitude * angle(k).cos()).collect(),
            acceleration: (0..4000).map(|k| -4.0 * amplitude * angle(k).sin()).collect(),
            ..Screen::default()
        }
    }

    #[test]
    fn exact_pitch_of_a_sine_is_found() {
        let screen = swinging(0.1);
        let target: Vec<f64> = screen
            .position
            .iter()
            .zip(&screen.velocity)
            .map(|(x, v)| 7.0 * v + 3.0 * (TAU * x / 0.024).sin() - 1.0 * (TAU * x / 0.024).cos())
            .collect();
        let columns = |rate: f64, m: Moment| [(rate * m.position).sin(), (rate * m.position).cos()];
        let found = pitches(&screen, &target, columns, 2);
        let best = &found[0];
        // The grid's own resolution: a fifth of one over the travel.
        assert!((best.period / 0.024 - 1.0).abs() < 0.03, "{best:?}");
        assert!((best.coefficients[0] - 3.0).abs() < 0.8, "{best:?}");
    }

    /// A pitch that the machine's file states is tried first, whatever stands out; one that the travel has too little of is not.
    #[test]
    fn exact_stated_pitches_come_first() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
        let folders = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let machines = folders.filter_map(|folder| crate::machine::Machine::read(&folder).ok());
        let machine = machines.into_iter().find(|m| m.motion() == crate::units::Motion::Prismatic).unwrap();
        let pitch = |stated: f64| machine.with_settings([("motor.magnet_pitch_m", stated.into())]).unwrap();
        let screen = |stated: f64| Screen {
            position: (0..1000).map(|k| k as f64 * 1e-4).collect(),
            velocity: vec![0.1; 1000],
            acceleration: (0..1000).map(|k| (k as f64 * 0.01).sin()).collect(),
            constants: Some(pitch(stated).constants()),
            ..Screen::default()
        };
        let target: Vec<f64> = (0..1000).map(|k| (TAU * k as f64 * 1e-4 / 0.008).sin()).collect();
        let columns = |rate: f64, m: Moment| [(rate * m.position).sin(), (rate * m.position).cos()];
        let first = |stated: f64| pitches(&screen(stated), &target, columns, 1)[0].period;
        assert!((first(0.03) - 0.03).abs() < 1e-15);
        assert!((first(1.0) / 0.008 - 1.0).abs() < 0.03);
    }

    /// On a short travel pitches of a motor are looked for as long as motors have them (60 mm), periods of a reading up to one and a half travels.
    #[test]
    fn exact_pitches_may_be_longer_than_a_short_travel() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
        let folders = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut machines = folders.filter_map(|folder| crate::machine::Machine::read(&folder).ok());
        let is_linear = |m: &crate::machine::Machine| {
            m.motion() == crate::units::Motion::Prismatic && m.constants().stated_pitches.is_empty()
        };
        let machine = machines.find(is_linear).unwrap();
        let longest = |travel: f64| {
            let position = (0..=1000).map(|k| travel * k as f64 * 1e-3).collect();
            let screen = Screen { position, constants: Some(machine.constants()), ..Screen::default() };
            [screen.period_range().1, screen.pitch_range().1]
        };
        let close = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(longest(0.02), [0.03, 0.06]) && close(longest(0.1), [0.15, 0.15]));
    }

    /// A force that comes half a sample late leaves much in ramps, and nothing at an even pace; where no pace is even, every
    /// moving sample serves.
    #[test]
    fn exact_ramps_are_left_out_where_enough_else_moves() {
        let screen = |ramps: usize| Screen {
            position: (0..1000).map(|k| k as f64 * 1e-4).collect(),
            velocity: vec![0.1; 1000],
            acceleration: (0..1000).map(|k| if k < ramps { 5.0 } else { 0.01 }).collect(),
            ..Screen::default()
        };
        assert_eq!(cruising(&screen(300), 1000), (300..1000).collect::<Vec<usize>>());
        assert_eq!(cruising(&screen(600), 1000).len(), 1000);
        let target: Vec<f64> =
            (0..1000)
                .map(|k| {
                    if k < 300 {
                        40.0 * (k as f64 * 0.31).sin()
                    } else {
                        (TAU * k as f64 * 1e-4 / 0.008).sin()
                    }
                })
                .collect();
        let columns = |rate: f64, m: Moment| [(rate * m.position).sin(), (rate * m.position).cos()];
        let found = pitches(&screen(300), &target, columns, 1);
        assert!((found[0].period / 0.008 - 1.0).abs() < 0.03, "{found:?}");
    }
}
