//! What a fit knows before it starts: motion and missing force along the training runs.

use super::orthonormal::orthonormal;
use crate::effect::{Cogging, Constants};
use crate::singular::decomposed;
use crate::solid::Weight;
use crate::units::Motion;
use nalgebra::{DMatrix, DVector};

/// One run, sample by sample, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Sample period in s.
    pub period_s: f64,
    /// Velocity.
    pub velocity: Vec<f64>,
    /// Acceleration.
    pub acceleration: Vec<f64>,
    /// Motor effort, empty where no signal tells it.
    pub motor_force: Vec<f64>,
    /// Missing force, empty where no signal tells the motor's effort.
    pub missing_force: Vec<f64>,
}

/// Motion and missing force along the training runs, thinned to a few thousand samples.
///
/// `missing_force` is what acts on the real moving part but not in the twin:
/// `d = m·a + c·v − F_motor`, positive along the axis' positive direction, low-pass filtered without
/// phase shift. It is empty when no signal tells the motor's effort.
#[derive(Debug, Clone)]
pub struct Screen {
    /// Prismatic or revolute.
    pub motion: Motion,
    /// Constants of the twin as it is.
    pub constants: Option<Constants>,
    /// Whether the twin has dry friction of the whole guide.
    pub has_dry_friction: bool,
    /// Time of the session in s.
    pub clock_s: Vec<f64>,
    /// Position in m or rad.
    pub position: Vec<f64>,
    /// Velocity in m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Acceleration in m/s² or rad/s².
    pub acceleration: Vec<f64>,
    /// Missing force in N or N·m.
    pub missing_force: Vec<f64>,
    /// Motor effort in N or N·m along the same samples, empty like the missing force.
    pub motor_force: Vec<f64>,
    /// Motor effort from current or voltage alone, where thrust was measured too.
    pub drive_force: Vec<f64>,
    /// Missing force with that effort: it has in it what lies between current and thrust.
    pub missing_drive_force: Vec<f64>,
    /// The runs whole, for what has a memory.
    pub runs: Vec<Series>,
    /// Load position less encoder position, where both ends of the drive train have their own sensor.
    pub load_difference: Vec<f64>,
    /// Largest motor effort of the runs, N or N·m; bounds what a force can plausibly be.
    pub largest_force: f64,
    /// Largest control effort that was logged, with what was fed forward, in V; zero where none was.
    pub largest_effort_v: f64,
    /// Mean of the voltage that the current takes more than was commanded, `(R·i + Ke·v)/gain − u` in V; none where not both were logged.
    pub missing_voltage: Option<f64>,
    /// Step of the grid on which all recorded positions lie, in m or rad, if there is one.
    pub reading_step: Option<f64>,
    /// Weight of a payload per kg·m of its mass times its lever; none where nothing hangs.
    pub lever_weight: Option<Weight>,
}

impl Default for Screen {
    fn default() -> Self {
        Self {
            motion: Motion::Prismatic,
            constants: None,
            has_dry_friction: false,
            clock_s: Vec::new(),
            position: Vec::new(),
            velocity: Vec::new(),
            acceleration: Vec::new(),
            missing_force: Vec::new(),
            motor_force: Vec::new(),
            drive_force: Vec::new(),
            missing_drive_force: Vec::new(),
            runs: Vec::new(),
            load_difference: Vec::new(),
            largest_force: 0.0,
            largest_effort_v: 0.0,
            missing_voltage: None,
            reading_step: None,
            lever_weight: None,
        }
    }
}

impl Screen {
    /// Moving mass of the twin in kg or kg·m².
    pub fn moving_mass(&self) -> f64 {
        self.constants.as_ref().map_or(1.0, |c| c.moving_mass)
    }

    /// Viscous coefficient of the twin in N·s/m or N·m·s/rad.
    pub fn viscous(&self) -> f64 {
        self.constants.as_ref().map_or(0.0, |c| c.viscous)
    }

    /// Coulomb friction of the twin with what the missing force shows of it, in N or N·m.
    pub fn coulomb(&self) -> f64 {
        let own = self.constants.as_ref().map_or(0.0, |c| c.friction.coulomb);
        own + self.four_coefficients().map_or(0.05 * self.largest_force, |[_, _, sign, _]| -sign)
    }

    /// Sample period in s.
    pub fn sample_period_s(&self) -> f64 {
        self.constants.as_ref().map_or(1e-3, |c| c.sample_period_s)
    }

    /// Largest speed of the runs.
    pub fn largest_speed(&self) -> f64 {
        self.velocity.iter().fold(0.0, |most, v| f64::max(most, v.abs()))
    }

    /// Range of the positions, in m or rad.
    pub fn travel(&self) -> f64 {
        let (low, high) = self.ends();
        (high - low).max(1e-9)
    }

    /// Middle of the range of the positions.
    pub fn middle(&self) -> f64 {
        let (low, high) = self.ends();
        0.5 * (low + high)
    }

    /// The lowest and the highest position, in m or rad.
    pub fn ends(&self) -> (f64, f64) {
        if self.position.is_empty() {
            return (0.0, 0.0);
        }
        self.position.iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(*x), high.max(*x)))
    }

    /// The longest pitch that is looked for: one period within the travel of all runs together, and what turns repeats once
    /// a turn at the latest.
    pub fn longest_pitch(&self) -> f64 {
        match self.motion {
            Motion::Prismatic => self.travel(),
            Motion::Revolute => self.travel().min(1.01 * std::f64::consts::TAU),
        }
    }

    /// Pitches that the machine's file states and of which the travel has enough.
    pub fn stated_pitches(&self) -> Vec<f64> {
        let stated = self.constants.as_ref().map_or(&[][..], |c| &c.stated_pitches);
        stated.iter().copied().filter(|pitch| *pitch <= BEYOND_TRAVEL * self.longest_pitch()).collect()
    }

    /// Pitches of a motor's force that a fit may come to: as long as motors have them, though the travel be shorter. A ripple of the motor's force
    /// longer than the travel is no spring, and cogging is one to first order only.
    pub fn pitch_range(&self) -> (f64, f64) {
        let (shortest, longest) = self.period_range();
        let usual = self.constants.as_ref().map_or(0.0, |c| Cogging::longest_pitch(c, self.motion));
        (shortest, longest.max(usual))
    }

    /// Periods of a reading's error that a fit may come to: what is longer than the travel is a scale.
    pub fn period_range(&self) -> (f64, f64) {
        let (coarse, read) = (3e-4 * self.longest_pitch(), self.shortest_read());
        (if read > 0.0 { coarse.min(read) } else { coarse }, BEYOND_TRAVEL * self.longest_pitch())
    }

    /// The shortest period that readings tell; 0 where no step of theirs is stated or seen.
    pub fn shortest_read(&self) -> f64 {
        let stated = self.constants.as_ref().map_or(0.0, |c| c.encoder_step);
        STEPS_A_PERIOD * stated.max(self.reading_step.unwrap_or(0.0))
    }

    /// The largest control effort of the runs: as logged, or what the largest motor effort takes at standstill.
    pub fn largest_voltage(&self) -> f64 {
        (self.largest_force / self.force_per_volt()).max(self.largest_effort_v).max(1e-9)
    }

    /// Motor effort per volt at standstill, in N/V or N·m/V.
    pub fn force_per_volt(&self) -> f64 {
        self.constants.as_ref().map_or(1.0, Constants::force_per_volt)
    }

    /// Mean difference of the second sensor's offset between the directions of motion: the width of a play.
    pub fn lost_motion(&self) -> Option<f64> {
        let direction = self.directions();
        let mean = |wanted: f64| {
            let pairs = self.load_difference.iter().zip(&direction).filter(|(_, s)| **s == wanted);
            let (sum, count) = pairs.fold((0.0, 0usize), |(sum, n), (d, _)| (sum + d, n + 1));
            (count > 0).then(|| sum / count as f64)
        };
        Some((mean(-1.0)? - mean(1.0)?).max(0.0))
    }

    /// +1, −1, or 0 at standstill (below 2 % of the largest speed, where the sign is noise).
    pub fn directions(&self) -> Vec<f64> {
        let still = 0.02 * self.largest_speed();
        self.velocity.iter().map(|v| if v.abs() > still { v.signum() } else { 0.0 }).collect()
    }

    /// Least-squares coefficients of the missing force on the given columns beside those that every start
    /// needs (acceleration, velocity, direction, constant); `None` when the data do not determine them.
    ///
    /// Only moving samples count: at standstill friction takes any value.
    pub fn regress(&self, columns: &[Vec<f64>]) -> Option<Vec<f64>> {
        let direction = self.directions();
        let moving: Vec<usize> = (0..self.missing_force.len()).filter(|&k| direction[k] != 0.0).collect();
        if moving.len() < 10 * (columns.len() + 1) {
            return None;
        }
        let scale: Vec<f64> =
            columns.iter().map(|c| root_mean_square(moving.iter().map(|&k| c[k]))).collect();
        if !scale.iter().all(|&s| s > 0.0) {
            return None;
        }
        let matrix = DMatrix::from_fn(moving.len(), columns.len(), |r, c| columns[c][moving[r]] / scale[c]);
        let target = DVector::from_iterator(moving.len(), moving.iter().map(|&k| self.missing_force[k]));
        let solution = decomposed(matrix)?.solve(&target, 1e-6).ok()?;
        Some(solution.iter().zip(&scale).map(|(value, s)| value / s).collect())
    }

    /// The missing force beside acceleration, velocity, direction and a constant; none where nothing tells it.
    pub fn beside_base(&self) -> Option<Beside> {
        let direction = self.directions();
        let moving: Vec<usize> = (0..self.missing_force.len()).filter(|&k| direction[k] != 0.0).collect();
        if moving.len() < 50 {
            return None;
        }
        let motion = moving.iter().map(|&k| [self.acceleration[k], self.velocity[k], direction[k]]);
        let base = Base::of(&motion.collect::<Vec<_>>());
        let wanted = DVector::from_iterator(moving.len(), moving.iter().map(|&k| self.missing_force[k]));
        let rest = base.rest_of(&wanted);
        Some(Beside { moving, base, rest })
    }

    /// Coefficients of acceleration, velocity, direction and constant in the missing force.
    pub fn four_coefficients(&self) -> Option<[f64; 4]> {
        let ones = vec![1.0; self.missing_force.len()];
        let columns = [self.acceleration.clone(), self.velocity.clone(), self.directions(), ones];
        self.regress(&columns)?.try_into().ok()
    }
}

/// What every start needs beside what it looks for: acceleration, velocity, direction of motion and a constant.
pub(super) struct Base(DMatrix<f64>);

impl Base {
    /// That of samples with these accelerations, velocities and directions.
    pub fn of(motion: &[[f64; 3]]) -> Self {
        let column = |row: usize, column: usize| motion[row].get(column).copied().unwrap_or(1.0);
        Self(orthonormal(DMatrix::from_fn(motion.len(), 4, column)))
    }

    /// With further columns.
    pub fn with(&self, blocks: &[DMatrix<f64>]) -> Self {
        let width = self.0.ncols();
        let mut all =
            self.0.clone().resize_horizontally(width + blocks.iter().map(DMatrix::ncols).sum::<usize>(), 0.0);
        let mut from = width;
        for block in blocks {
            all.columns_mut(from, block.ncols()).copy_from(block);
            from += block.ncols();
        }
        Self(orthonormal(all))
    }

    /// What it leaves of a column.
    pub fn rest_of(&self, column: &DVector<f64>) -> DVector<f64> {
        column - &self.0 * self.0.tr_mul(column)
    }

    /// What it leaves of each column of a matrix.
    pub fn rest_of_each(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        columns - &self.0 * self.0.tr_mul(columns)
    }
}

/// The missing force of the moving samples beside what every start needs: what single columns explain of it.
pub struct Beside {
    moving: Vec<usize>,
    base: Base,
    rest: DVector<f64>,
}

impl Beside {
    /// Sum of squares of what the base leaves.
    pub fn left(&self) -> f64 {
        self.rest.norm_squared()
    }

    /// Coefficient of a column, given by sample, and the sum of squares that it explains beyond the base.
    pub fn explain(&self, column: impl Fn(usize) -> f64) -> Option<(f64, f64)> {
        let column = DVector::from_iterator(self.moving.len(), self.moving.iter().map(|&k| column(k)));
        let own = self.base.rest_of(&column);
        let size = own.norm_squared();
        // A column that the base all but explains has no coefficient of its own.
        let is_own = size > LEAST_OWN * column.norm_squared();
        is_own.then(|| (own.dot(&self.rest) / size, own.dot(&self.rest).powi(2) / size))
    }
}

/// A column of which the base leaves less than this share of its square is the base's.
const LEAST_OWN: f64 = 1e-6;

/// A period of a reading's error has so many steps of the reading at least: rounding the place then takes `1 − sinc(π/8)`, 2.6 %, off its amplitude.
const STEPS_A_PERIOD: f64 = 8.0;

/// A fit may look for a pitch so many times the longest from which it starts.
pub const BEYOND_TRAVEL: f64 = 1.5;

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(s, n), v| (s + v * v, n + 1));
    if count == 0 { 0.0 } else { (sum / count as f64).sqrt() }
}
