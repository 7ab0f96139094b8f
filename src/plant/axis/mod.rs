//! The reduced-order axis: winding, moving mass, viscous guide and base modes, discretised exactly.

mod dynamics;
mod kernel;
mod lanes;
mod response;
mod slide;

pub use kernel::{LANES, Lane};
pub use lanes::{Friction, Lanes};
pub use response::SampledResponse;

use super::{Drive, Plant, Resonance};
use crate::effect::Constants;
use crate::guide::{Coast, Response, StepForce};
use dynamics::{Discrete, Dynamics, Layout};
use kernel::{Apply, Multiply, NO_ROWS, ROWS, Rows};
use pulp::Arch;

/// The axis reduced to what moves along the joint, with the winding that drives it.
///
/// # Model
/// ```text
///   L·di/dt = u − R·i − Ke·q̇          F = Kt·i + F_guide − c·q̇
///   M_j·(η̈_j + 2ζ_j·ω_j·η̇_j + ω_j²·η_j) = −F
///   q̈   = F/m − Σ η̈_j
/// ```
/// q is the position of the moving part relative to the base point that receives the reaction, η_j are the base modes.
/// Voltage is held over a step (or switches once inside it), forces of the guide have a mean and a rise: for both the
/// matrix exponential of winding, mass and base together is exact. There is no numerical damping and no frequency error
/// at any step length, and the motor's force moves within the step as it does on the machine.
///
/// # Validity
/// The moving part is rigid; modes of the base move along the joint only.
///
/// # Source
/// Discretisation: Åström, Wittenmark (1997), *Computer-Controlled Systems*, sections 2.3 and 8.3.
#[derive(Debug, Clone)]
pub struct Axis {
    step_s: f64,
    dynamics: Dynamics,
    /// Voltage drives the winding.
    driven: Matrices,
    /// Response to the earlier voltage of a step in which it switches at this share.
    switched: Option<(f64, Vec<Rows>)>,
    /// A given force takes the motor's place; made when first asked for.
    forced: Option<Box<Matrices>>,
    /// Motor force per ampere (per volt of a direct motor).
    force_constant: f64,
    /// The states but the position, then the voltage; filled up with zeros.
    state: Vec<Rows>,
    position: f64,
    ahead: Vec<Rows>,
    /// Whether the step that was looked at is driven by a given force.
    is_forced: bool,
    arch: Arch,
}

/// Longest step of the axis plant in s: reversals and pushes are resolved to second order inside it.
pub const LONGEST_STEP_S: f64 = 250e-6;

/// The longest step that divides a sample period and is at most `longest_s`, all in s.
pub fn longest_step(period_s: f64, longest_s: f64) -> f64 {
    // A period that is a whole number of steps but for rounding is that number.
    period_s / (period_s / longest_s - 1e-9).ceil().max(1.0)
}

/// One step as blocks of rows.
///
/// Rows: the states but the position, a row of zeros for the voltage, the displacement. Columns: the states but the
/// position (which acts back on nothing), then the voltage.
#[derive(Debug, Clone)]
struct Matrices {
    /// `columns` entries for each block of rows.
    transition: Vec<Rows>,
    by_mean: Vec<Rows>,
    by_rise: Vec<Rows>,
    response: Response,
}

/// Row of state number `k` of `states`: the voltage stands between the other states and the position.
fn row(k: usize, states: usize) -> usize {
    if k + 1 == states { states } else { k }
}

fn blocks(entries: &nalgebra::DVector<f64>) -> Vec<Rows> {
    let states = entries.len();
    let mut blocks = vec![NO_ROWS; (states + 1).div_ceil(ROWS)];
    for (k, entry) in entries.iter().enumerate() {
        let row = row(k, states);
        blocks[row / ROWS][row % ROWS] = *entry;
    }
    blocks
}

impl Matrices {
    fn of(step: &Discrete) -> Self {
        let states = step.transition.nrows();
        let columns: Vec<Vec<Rows>> = (0..states)
            .map(|k| {
                let is_voltage = k + 1 == states;
                blocks(&if is_voltage {
                    step.by_voltage.clone()
                } else {
                    step.transition.column(k).into_owned()
                })
            })
            .collect();
        let row_blocks = columns[0].len();
        let transition = (0..row_blocks).flat_map(|b| columns.iter().map(move |column| column[b])).collect();
        let last = states - 1;
        let response =
            Response::new(step.by_mean[0], step.by_mean[last], step.by_rise[0], step.by_rise[last]);
        Self { transition, by_mean: blocks(&step.by_mean), by_rise: blocks(&step.by_rise), response }
    }
}

impl Axis {
    /// The axis with the longest step that divides the sample period and is at most [`LONGEST_STEP_S`].
    pub fn of(constants: &Constants) -> Self {
        Self::within(constants, LONGEST_STEP_S)
    }

    /// The axis with the longest step that divides the sample period and is at most `longest_s`, in s.
    pub fn within(constants: &Constants, longest_s: f64) -> Self {
        Self::new(constants, longest_step(constants.sample_period_s, longest_s))
    }

    /// The axis with these constants, advancing by `step_s` each time.
    pub fn new(constants: &Constants, step_s: f64) -> Self {
        let dynamics = Dynamics::of(constants);
        let driven = Matrices::of(&dynamics.over(step_s));
        let row_blocks = driven.by_mean.len();
        Self {
            step_s,
            driven,
            switched: None,
            forced: None,
            force_constant: constants.force_constant(),
            state: vec![NO_ROWS; row_blocks],
            position: 0.0,
            ahead: vec![NO_ROWS; row_blocks],
            is_forced: false,
            arch: Arch::new(),
            dynamics,
        }
    }

    /// Displacement of the base at the reaction point in m, positive along the joint's positive direction.
    pub fn base_displacement(&self) -> f64 {
        let first = self.layout().first_mode();
        (0..self.layout().modes).map(|j| at(&self.state, first + 2 * j)).sum()
    }

    /// Frequencies and damping ratios of moving part, drag and base together; the winding takes no part.
    pub fn resonances(&self) -> Vec<Resonance> {
        self.dynamics.resonances()
    }

    fn layout(&self) -> Layout {
        self.dynamics.layout
    }

    /// Place of the voltage among the columns; the displacement's row is the next one.
    fn voltage(&self) -> usize {
        self.layout().states() - 1
    }

    fn matrices(&self) -> &Matrices {
        match &self.forced {
            Some(forced) if self.is_forced => forced,
            _ => &self.driven,
        }
    }

    /// Whether a given force takes the motor's place in the coming step.
    #[inline]
    fn set_forced(&mut self, is_forced: bool) {
        self.is_forced = is_forced;
        if is_forced && self.forced.is_none() {
            let step = self.dynamics.without_motor().over(self.step_s);
            self.forced = Some(Box::new(Matrices::of(&step)));
        }
    }

    /// Change of the rows per volt more until the share `switch` of the step.
    fn by_earlier(&mut self, switch: f64) -> &[Rows] {
        if self.switched.as_ref().is_none_or(|(at, _)| *at != switch) {
            let earlier = self.dynamics.by_earlier_voltage(self.step_s, switch);
            self.switched = Some((switch, blocks(&earlier)));
        }
        self.switched.as_ref().map_or(&[], |(_, rows)| rows)
    }

    /// Prepares what the drive of the coming step needs: the voltage to hold, what the earlier one differs from it by, the
    /// force in the motor's place.
    #[inline]
    fn prepare(&mut self, drive: Drive) -> (f64, f64, f64) {
        self.set_forced(matches!(drive, Drive::Force(_)));
        match drive {
            Drive::Force(force) => (0.0, 0.0, force),
            Drive::Voltage { now_v, switch, .. } if switch <= 0.0 => (now_v, 0.0, 0.0),
            Drive::Voltage { earlier_v, switch, .. } if switch >= 1.0 => (earlier_v, 0.0, 0.0),
            Drive::Voltage { earlier_v, now_v, switch } => {
                self.by_earlier(switch);
                (now_v, earlier_v - now_v, 0.0)
            }
        }
    }

    /// The step's outcome from the rows looked ahead.
    #[inline(always)]
    fn coast_of(&self, force: f64, voltage_v: f64) -> Coast {
        let (matrices, displacement) = (self.matrices(), self.voltage() + 1);
        let motor_force = match (self.is_forced, self.layout().has_winding) {
            (true, _) => [force; 2],
            (false, true) => [self.state[0][Layout::CURRENT], at(&self.ahead, Layout::CURRENT)]
                .map(|i| self.force_constant * i),
            (false, false) => [self.force_constant * voltage_v; 2],
        };
        Coast {
            velocity: self.state[0][0],
            free_velocity: at(&self.ahead, 0),
            free_travel: at(&self.ahead, displacement),
            motor_force,
            response: matrices.response,
        }
    }
}

impl Plant for Axis {
    fn step_s(&self) -> f64 {
        self.step_s
    }

    fn position(&self) -> f64 {
        self.position
    }

    fn velocity(&self) -> f64 {
        self.state[0][0]
    }

    fn current(&self) -> f64 {
        if self.layout().has_winding { self.state[0][Layout::CURRENT] } else { 0.0 }
    }

    fn set_current(&mut self, current_a: f64) {
        if self.layout().has_winding {
            self.state[0][Layout::CURRENT] = current_a;
        }
    }

    #[inline]
    fn coast(&mut self, drive: Drive) -> Coast {
        let (voltage_v, difference_v, force) = self.prepare(drive);
        let voltage = self.voltage();
        self.state[voltage / ROWS][voltage % ROWS] = voltage_v;
        let matrices = match &self.forced {
            Some(forced) if self.is_forced => forced,
            _ => &self.driven,
        };
        let (matrix, columns) = (matrices.transition.as_slice(), voltage + 1);
        self.arch.dispatch(Multiply { matrix, columns, by: &self.state, into: &mut self.ahead });
        if let Some((_, earlier)) = self.switched.as_ref().filter(|_| difference_v != 0.0) {
            add(&mut self.ahead, earlier, difference_v);
        }
        if force != 0.0 {
            add(&mut self.ahead, &matrices.by_mean, force);
        }
        self.coast_of(force, voltage_v)
    }

    #[inline]
    fn advance(&mut self, motor: StepForce, guide: StepForce) {
        let StepForce { mean, rise } = motor + guide;
        let matrices = match &self.forced {
            Some(forced) if self.is_forced => forced,
            _ => &self.driven,
        };
        let Matrices { by_mean, by_rise, .. } = matrices;
        let (ahead, into) = (self.ahead.as_slice(), self.state.as_mut_slice());
        self.arch.dispatch(Apply { ahead, by_mean, by_rise, mean, rise, into });
        self.position += at(&self.state, self.voltage() + 1);
    }

    fn place(&mut self, position: f64, velocity: f64) {
        self.state.fill(NO_ROWS);
        self.state[0][0] = velocity;
        self.position = position;
    }

    fn relocate(&mut self, position: f64, velocity: f64) {
        self.state[0][0] = velocity;
        self.position = position;
    }

    fn snapshot(&self) -> Vec<f64> {
        let states = self.state.iter().flat_map(|rows| rows.0);
        std::iter::once(self.position).chain(states).collect()
    }

    fn restore(&mut self, snapshot: &[f64]) {
        if let [position, state @ ..] = snapshot {
            self.position = *position;
            for (rows, from) in self.state.iter_mut().zip(state.chunks_exact(ROWS)) {
                rows.copy_from_slice(from);
            }
        }
    }
}

/// The number in a row.
#[inline(always)]
fn at(rows: &[Rows], row: usize) -> f64 {
    rows[row / ROWS][row % ROWS]
}

fn add(sum: &mut [Rows], rows: &[Rows], factor: f64) {
    for (sum, row) in sum.iter_mut().zip(rows) {
        for lane in 0..ROWS {
            sum[lane] += row[lane] * factor;
        }
    }
}
