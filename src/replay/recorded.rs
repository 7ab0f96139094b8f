//! Replay of a recorded run: the twin follows the recorded reference from the recorded start.

use super::{Traces, run, run_together};
use crate::controller::Input;
use crate::drive::motor::Circuit;
use crate::effect::Constants;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::Plant;
use crate::plant::axis::Axis;
use crate::recording::{Run, Signal};
use crate::twin::{Command, Driven, Sensing, Twin};

/// How a recorded run begins, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Position at the first sample.
    pub position: f64,
    /// Velocity at the first sample; exactly zero where the run begins at rest.
    pub velocity: f64,
    /// Commanded voltage at the first sample, where it was logged.
    pub effort_v: Option<f64>,
    /// Motor current at the first sample, where it was logged.
    pub current: Option<f64>,
    /// Position and velocity that the controller saw at the first sample, where its effort is that of one sample
    /// and not a mean.
    pub reading: Option<(f64, f64)>,
    /// What the second sensor shows at the first sample, where there is one.
    pub load_position: Option<f64>,
}

/// Samples at the beginning of a moving run from which its start is read.
const START_SAMPLES: usize = 8;
/// A slope below so many of its standard errors is rest.
const REST_STANDARD_ERRORS: f64 = 5.0;
/// At most so much standstill is averaged, in s.
const REST_S: f64 = 0.1;

impl Start {
    /// Reads the start off the first samples: means over the standstill before the reference first moves, else
    /// a parabola through the first positions.
    pub fn of(run: &Run, reference: &[f64], position: &[f64]) -> Self {
        let period = run.sample_period_s();
        let still = reference.iter().take_while(|r| **r == reference[0]).count();
        let still = still.min((REST_S / period) as usize);
        let effort = run.signal(Signal::ControlEffort);
        if still >= START_SAMPLES
            && is_steady(&position[..still])
            && effort.is_none_or(|effort| is_steady(&effort[..still]))
        {
            let mean = |samples: &[f64]| samples[..still].iter().sum::<f64>() / still as f64;
            return Self {
                position: mean(position),
                velocity: 0.0,
                effort_v: run.signal(Signal::ControlEffort).map(mean),
                current: run.signal(Signal::Current).map(mean),
                reading: None,
                load_position: run.signal(Signal::LoadPosition).map(mean),
            };
        }
        let first = &position[..position.len().min(START_SAMPLES)];
        let mean = first.iter().sum::<f64>() / first.len() as f64;
        let (at_start, slope, slope_error) = parabola(first, period);
        let moves = slope.abs() > REST_STANDARD_ERRORS * slope_error && first.len() >= 5;
        let first_of = |signal| run.signal(signal).and_then(|samples| samples.first().copied());
        Self {
            position: if moves { at_start } else { mean },
            velocity: if moves { slope } else { 0.0 },
            effort_v: first_of(Signal::ControlEffort),
            current: match run.signal(Signal::Current) {
                // One sample of a noisy current would kick the axis; at rest a few milliseconds change little.
                Some(current) if !moves => {
                    Some(current[..first.len()].iter().sum::<f64>() / first.len() as f64)
                }
                _ => first_of(Signal::Current),
            },
            reading: first_of(Signal::Position).zip(first_of(Signal::Velocity)),
            load_position: first_of(Signal::LoadPosition),
        }
    }

    /// The motor's current in A: as logged, else what the logged effort settles at, else none.
    pub fn current_a(&self, constants: &Constants) -> f64 {
        let settled = |effort_v: f64| match constants.circuit {
            Circuit::Winding { resistance_ohm, back_emf, .. } => {
                (constants.amplifier.output_v(effort_v) - back_emf * self.velocity) / resistance_ohm
            }
            Circuit::Direct { .. } => 0.0,
        };
        self.current.or_else(|| self.effort_v.map(settled)).unwrap_or(0.0)
    }
}

/// Halves of a standstill whose means differ by more standard errors are no steady state.
const STEADY_STANDARD_ERRORS: f64 = 6.0;

/// Whether a standstill shows scatter about one value, not a transient.
pub fn is_steady(samples: &[f64]) -> bool {
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let (first, second) = samples.split_at(samples.len() / 2);
    let (a, b) = (mean(first), mean(second));
    let squares = |part: &[f64], m: f64| part.iter().map(|x| (x - m) * (x - m)).sum::<f64>();
    let variance = (squares(first, a) + squares(second, b)) / samples.len() as f64;
    let rounding = 1e-12 * a.abs();
    (a - b).abs() <= STEADY_STANDARD_ERRORS * (4.0 * variance / samples.len() as f64).sqrt() + rounding
}

/// Value and slope at the first sample of the least-squares parabola, and the slope's standard error.
fn parabola(samples: &[f64], period_s: f64) -> (f64, f64, f64) {
    let count = samples.len();
    if count < 5 {
        return (samples[0], 0.0, f64::INFINITY);
    }
    let matrix =
        nalgebra::DMatrix::from_fn(count, 3, |row, power| (row as f64 * period_s).powi(power as i32));
    let target = nalgebra::DVector::from_column_slice(samples);
    let normal = matrix.transpose() * &matrix;
    let Some(inverse) = normal.try_inverse() else { return (samples[0], 0.0, f64::INFINITY) };
    let solution = &inverse * matrix.transpose() * &target;
    let residual = (&target - &matrix * &solution).norm_squared() / (count - 3) as f64;
    (solution[0], solution[1], (residual * inverse[(1, 1)]).sqrt())
}

/// A recorded run made ready for replays: its commands and its start.
#[derive(Debug, Clone)]
pub struct Recorded {
    commands: Vec<Command>,
    start: Start,
}

impl Recorded {
    /// Commands and start of a run that has a position reference and a position.
    ///
    /// # Errors
    /// A run without position reference or position.
    pub fn of(run: &Run) -> Result<Self> {
        Self::along(run, run.require(Signal::PositionReference)?)
    }

    /// Commands and start of a run along a position reference of its length, logged or not.
    ///
    /// # Errors
    /// A run without position.
    pub fn along(run: &Run, reference: &[f64]) -> Result<Self> {
        Ok(Self::from(run, reference, Start::of(run, reference, run.require(Signal::Position)?)))
    }

    /// Commands of a run along a position reference of its length, from a start that is known.
    pub(super) fn from(run: &Run, reference: &[f64], start: Start) -> Self {
        let period = run.sample_period_s();
        let disturbance = run.signal(Signal::DisturbanceVoltage);
        let commands = (0..reference.len())
            .map(|k| {
                let velocity_reference = match k {
                    // Nothing stands before the first sample: a run that begins at rest begins with none.
                    0 if start.velocity == 0.0 || reference.len() < 2 => 0.0,
                    0 => (reference[1] - reference[0]) / period,
                    _ => (reference[k] - reference[k - 1]) / period,
                };
                Command {
                    position_reference: reference[k],
                    velocity_reference,
                    disturbance_v: disturbance.map_or(0.0, |d| d[k]),
                    effort_v: None,
                    thrust: None,
                    thrust_rise: 0.0,
                }
            })
            .collect();
        Self { commands, start }
    }

    /// The same with the run's efforts, in V, in the place of the controller's: open loop.
    #[must_use]
    pub fn driven_by(mut self, effort_v: &[f64]) -> Self {
        for (command, effort) in self.commands.iter_mut().zip(effort_v) {
            command.effort_v = Some(*effort);
        }
        self
    }

    /// How the run begins.
    pub fn start(&self) -> Start {
        self.start
    }

    /// The commands, one a sample.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// Replays the run in closed loop on a plant.
    pub fn replay<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing) -> Traces {
        run(&mut self.twin(machine, plant, sensing), self.commands.iter().copied(), |_| ())
    }

    /// The same for several machines with perfect sensors, on the reduced axis and in one pass.
    pub fn replay_together(&self, machines: &[Machine]) -> Vec<Traces> {
        let twin = |machine: &Machine| self.twin(machine, Axis::of(&machine.constants()), Sensing::Perfect);
        let room = || Traces::with_capacity(self.commands.len());
        let mut traces: Vec<Traces> = machines.iter().map(|_| room()).collect();
        run_together(
            machines.iter().map(twin).collect(),
            Driven::ByControllers,
            self.commands.len(),
            |_, k| self.commands[k],
            |_| None,
            |twin, _, sample| traces[twin].push(sample),
        );
        traces
    }

    /// The twin as the run finds it: moved to the start, its controller taken over.
    pub(super) fn twin<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing) -> Twin<P> {
        let mut twin = Twin::new(machine, plant, sensing);
        let Start { position, velocity, effort_v, reading, load_position, .. } = self.start;
        let on_load = machine.description().load_sensor.as_ref().is_some_and(|s| s.closes_position_loop);
        let mut seen = reading.unwrap_or((position, velocity));
        twin.start(position, velocity, effort_v.unwrap_or(0.0));
        if let Some(shown) = load_position {
            twin.set_load_reading(shown);
            seen.0 = if on_load { shown } else { seen.0 };
        }
        if let (Some(effort_v), Some(first)) = (effort_v, self.commands.first()) {
            let input = Input {
                position_reference: first.position_reference,
                velocity_reference: first.velocity_reference,
                position: seen.0,
                velocity: seen.1,
            };
            twin.take_over(effort_v - first.disturbance_v, input);
        }
        twin.set_current(self.start.current_a(&machine.constants()));
        twin
    }
}
