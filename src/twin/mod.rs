//! The twin: one control period walked in hardware order, from command to sensor.
//!
//! ```text
//! command → controller → amplifier → motor → guide → structure → sensor → (back to controller)
//! ```
//!
//! - [`Twin`]: the signal path and one plant.
//! - [`Batch`]: several parameter sets of one machine in one pass.
//! - [`LinearLoop`]: what of it is linear, as a frequency response.

mod acting;
mod batch;
mod current;
mod front;
mod laws;
mod linear;
mod path;
mod slides;
mod wave_lanes;

pub use batch::{Batch, Driven};
pub use laws::{InitialForces, load_positions};
pub use linear::{LinearLoop, LinearPlant};

use crate::controller::Input;
use crate::machine::Machine;
use crate::plant::Plant;
use path::Path;

/// What reaches the axis from outside in one period, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Position reference.
    pub position_reference: f64,
    /// Velocity reference.
    pub velocity_reference: f64,
    /// Voltage injected between controller and amplifier.
    pub disturbance_v: f64,
    /// Voltage fed forward between controller and amplifier beside the effort, which is recorded without it.
    pub feedforward_v: f64,
    /// Effort to apply instead of the controller's (the disturbance is then part of it already).
    pub effort_v: Option<f64>,
    /// Supply voltage in V that was recorded, for an amplifier that is commanded by a duty cycle; else the stated one holds.
    pub supply_v: Option<f64>,
    /// Whether the drive is enabled; without it the bridge is open, the motor exerts nothing, and its controller begins anew
    /// when it is enabled again.
    pub is_enabled: bool,
    /// Motor force or torque to apply instead of the motor's, its mean over the period in N or N·m.
    pub thrust: Option<f64>,
    /// By how much that force rises over the period, in N or N·m.
    pub thrust_rise: f64,
}

impl Command {
    /// Follow a reference, nothing injected.
    pub const fn follow(position_reference: f64, velocity_reference: f64) -> Self {
        Self {
            position_reference,
            velocity_reference,
            disturbance_v: 0.0,
            feedforward_v: 0.0,
            effort_v: None,
            supply_v: None,
            is_enabled: true,
            thrust: None,
            thrust_rise: 0.0,
        }
    }
}

impl Command {
    /// The command with no force in the motor's place where the drive is not enabled.
    fn with_bridge_open(self) -> Self {
        if self.is_enabled { self } else { Self { thrust: Some(0.0), thrust_rise: 0.0, ..self } }
    }
}

/// What a recording would hold of one sample, in SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sample {
    /// Encoder reading.
    pub position: f64,
    /// The controller's velocity estimate.
    pub velocity: f64,
    /// Voltage commanded to the amplifier, injected disturbance included, without what is fed forward beside it.
    pub effort_v: f64,
    /// Motor current in A (voltage, for a direct motor) at the sample.
    pub current: f64,
    /// Motor force or torque at the sample, in N or N·m.
    pub thrust: f64,
    /// Reading of the second sensor, at the load; that of the encoder where there is none.
    pub load_position: f64,
}

/// Whether sensors are perfect or as the machine file states them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensing {
    /// No noise, no rounding: what fits run on.
    Perfect,
    /// Noise and rounding as stated, drawn from this seed.
    AsStated {
        /// Seed of the random numbers.
        seed: u64,
    },
}

/// A machine's twin on one plant: configuration and everything that moves.
#[derive(Debug)]
pub struct Twin<P> {
    path: Path,
    plant: P,
}

impl<P: Plant> Twin<P> {
    /// The machine's twin on `plant`, whose step must divide the sample period.
    pub fn new(machine: &Machine, plant: P, sensing: Sensing) -> Self {
        let mut twin = Self { path: Path::new(machine, &plant, sensing), plant };
        twin.start(0.0, 0.0, 0.0);
        twin
    }

    /// Starts anew where the encoder shows `position`, with a velocity and a steadily commanded voltage.
    pub fn start(&mut self, position: f64, velocity: f64, effort_v: f64) {
        let motor = self.path.start(position, velocity, effort_v);
        self.plant.place(motor, velocity);
    }

    /// Goes on where the encoder shows `position` with a velocity; base, current, voltages under way, friction and
    /// the place inside every play stay as they are.
    pub fn restart(&mut self, position: f64, velocity: f64) {
        let [motor, speed] = self.path.restart(self.state(), position, velocity);
        self.plant.relocate(motor, speed);
    }

    /// Sets the session's clock in s, which [`start`](Self::start) leaves as it is.
    pub fn set_clock(&mut self, clock_s: f64) {
        self.path.set_clock(clock_s);
    }

    /// Sets the zero of the second sensor by what it shows at the start.
    pub fn set_load_reading(&mut self, reading: f64) {
        self.path.set_load_reading(self.plant.position(), reading);
    }

    /// Sets the controller's memory so that it would command `effort_v` on `input`.
    pub fn take_over(&mut self, effort_v: f64, input: Input) {
        self.path.take_over(effort_v, input);
    }

    /// Sets the motor's current in A.
    pub fn set_current(&mut self, current: f64) {
        self.plant.set_current(current);
    }

    /// Sets the initial state of the guide's friction from these forces; [`start`](Self::start) leaves its bristles undeflected.
    pub fn initialise_friction(&mut self, start: InitialForces) {
        self.path.initialise_friction(self.state(), start);
    }

    /// The plant.
    pub fn plant(&self) -> &P {
        &self.plant
    }

    /// Position and velocity of the plant.
    pub fn state(&self) -> [f64; 2] {
        [self.plant.position(), self.plant.velocity()]
    }

    /// Vertical loads of the bearing sliders A–D in N, where the plant knows them.
    pub fn slider_loads(&mut self) -> Option<[f64; 4]> {
        self.plant.slider_loads()
    }

    /// The sample period in s.
    pub fn period_s(&self) -> f64 {
        self.path.period_s()
    }

    /// One control period: senses, controls, records, then lets the axis move until the next sample.
    #[inline(always)]
    pub fn step(&mut self, command: Command) -> Sample {
        let command = command.with_bridge_open();
        if !command.is_enabled {
            self.plant.set_current(0.0);
        }
        let (sample, applied_v) = self.path.sample(command, self.plant.position(), self.plant.current());
        for step in 0..self.path.steps() {
            let drive = self.path.drive(step, applied_v, command.thrust);
            let (coast, position) = (self.plant.coast(drive), self.plant.position());
            let [motor, guide] = self.path.forces(drive, coast, position, || self.plant.slider_loads());
            self.plant.advance(motor, guide);
        }
        sample
    }
}
