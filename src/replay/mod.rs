//! Replay: strokes and recorded commands through the twin, for a whole run.

mod cell;
pub mod commands;
pub mod compared;
mod compensated;
mod controller_run;
pub mod crosscheck;
pub mod excitation;
pub mod feedforward;
mod figures;
pub mod friction;
pub mod gain_table;
mod grid;
pub mod ladder;
pub mod multisine;
mod plant_choice;
pub mod published;
pub mod recorded;
pub mod recording;
mod simulation;
pub mod sine_sweep;
pub mod start;
pub mod stroke;
mod together;
mod travel;
pub mod windows;

pub use cell::Cell;
pub use commands::Commands;
pub use compared::Compared;
pub use compensated::Compensated;
pub use controller_run::controller_run;
pub use feedforward::Feedforward;
pub use figures::{Figures, SETTLING_BAND};
pub use ladder::Ladder;
pub use plant_choice::PlantChoice;
pub use published::Published;
pub use recorded::Recorded;
pub use simulation::{run_seed, simulate};
pub use stroke::{Motion, Stroke};
pub use together::run_together;
pub use travel::{check_samples, planned_reference};

use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::Plant;
use crate::recording::Signal;
use crate::twin::{Command, Sample, Twin};

/// What a replay yields: one array per signal, one number per sample, in SI.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Traces {
    /// Encoder reading.
    pub position: Vec<f64>,
    /// Velocity estimate.
    pub velocity: Vec<f64>,
    /// Commanded voltage in V, injected disturbance included.
    pub effort_v: Vec<f64>,
    /// Motor current in A.
    pub current: Vec<f64>,
    /// Motor force or torque in N or N·m.
    pub thrust: Vec<f64>,
    /// Reading of the second sensor, at the load.
    pub load_position: Vec<f64>,
    /// Loads of sliders A–D in N, where the plant knows them.
    pub slider_loads: Vec<[f64; 4]>,
}

impl Traces {
    /// Room for `samples` samples.
    pub fn with_capacity(samples: usize) -> Self {
        let room = || Vec::with_capacity(samples);
        Self {
            position: room(),
            velocity: room(),
            effort_v: room(),
            current: room(),
            thrust: room(),
            load_position: room(),
            slider_loads: Vec::new(),
        }
    }

    /// Appends one sample.
    pub fn push(&mut self, sample: Sample) {
        self.position.push(sample.position);
        self.velocity.push(sample.velocity);
        self.effort_v.push(sample.effort_v);
        self.current.push(sample.current);
        self.thrust.push(sample.thrust);
        self.load_position.push(sample.load_position);
    }

    /// The trace of a signal; none of what a replay is told and does not predict.
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        match signal {
            Signal::ControlEffort => Some(&self.effort_v),
            Signal::Current => Some(&self.current),
            Signal::Thrust => Some(&self.thrust),
            Signal::Position => Some(&self.position),
            Signal::Velocity => Some(&self.velocity),
            Signal::LoadPosition => Some(&self.load_position),
            Signal::PositionReference
            | Signal::VelocityReference
            | Signal::TorqueEnabled
            | Signal::DisturbanceVoltage
            | Signal::SupplyVoltage
            | Signal::DisturbanceForce => None,
        }
    }

    /// Forgets the first samples.
    pub fn forget(&mut self, samples: usize) {
        let Self { position, velocity, effort_v, current, thrust, load_position, slider_loads } = self;
        for trace in [position, velocity, effort_v, current, thrust, load_position] {
            trace.drain(..samples.min(trace.len()));
        }
        slider_loads.drain(..samples.min(slider_loads.len()));
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Refuses the traces of a simulation that ran away.
    ///
    /// # Errors
    /// The first number that is not finite, with the machine's file.
    pub fn check_finite(&self, machine: &Machine) -> Result<()> {
        let signals = [
            (Signal::Position, &self.position),
            (Signal::ControlEffort, &self.effort_v),
            (Signal::Current, &self.current),
            (Signal::Thrust, &self.thrust),
        ];
        let wrong = |samples: &Vec<f64>| samples.iter().position(|sample| !sample.is_finite());
        let first = signals.iter().filter_map(|(signal, samples)| Some((wrong(samples)?, signal))).min();
        let Some((sample, signal)) = first else { return Ok(()) };
        Err(Error::new(ErrorKind::OutOfRange)
            .file(machine.file())
            .found(format!(
                "numbers with which the simulation runs away: {} is no finite number from sample {sample} on",
                signal.key(machine.motion())
            ))
            .expected("a machine that can be simulated")
            .remedy("correct what is too large or too small in it, gains first, or what was set on the command line"))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}

/// Walks the twin through the commands, one a period; `each` is told after every sample how many are done.
pub fn run<P: Plant>(
    twin: &mut Twin<P>,
    commands: impl ExactSizeIterator<Item = Command>,
    mut each: impl FnMut(usize),
) -> Traces {
    let mut traces = Traces::with_capacity(commands.len());
    for (done, command) in commands.enumerate() {
        if let Some(loads) = twin.slider_loads() {
            traces.slider_loads.push(loads);
        }
        traces.push(twin.step(command));
        each(done + 1);
    }
    traces
}

/// Commands that follow a sampled position reference; the reference velocity is its difference.
pub fn follow(reference: &[f64], period_s: f64) -> impl ExactSizeIterator<Item = Command> + '_ {
    reference.iter().enumerate().map(move |(k, &position)| {
        let before = if k == 0 { position } else { reference[k - 1] };
        Command::follow(position, (position - before) / period_s)
    })
}
