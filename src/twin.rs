//! The twin: one control period walked in hardware order, from command to sensor.
//!
//! ```text
//! command → controller → amplifier → motor → guide → structure → sensor → (back to controller)
//! ```

use crate::controller::{Controller, Input, Memory};
use crate::drive::amplifier::{Amplifier, SplitDelay};
use crate::drive::motor::CircuitStep;
use crate::effect::{Constants, Effect};
use crate::guide::stick_slip::friction;
use crate::machine::Machine;
use crate::plant::Plant;
use crate::sensor::{CurrentSensor, Encoder, VelocityMemory};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// What reaches the axis from outside in one period, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Position reference.
    pub position_reference: f64,
    /// Velocity reference.
    pub velocity_reference: f64,
    /// Voltage injected between controller and amplifier.
    pub disturbance_v: f64,
    /// Effort to apply instead of the controller's (the disturbance is then part of it already).
    pub effort_v: Option<f64>,
}

impl Command {
    /// Follow a reference, nothing injected.
    pub fn follow(position_reference: f64, velocity_reference: f64) -> Self {
        Self { position_reference, velocity_reference, disturbance_v: 0.0, effort_v: None }
    }
}

/// What a recording would hold of one sample, in SI.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sample {
    /// Encoder reading.
    pub position: f64,
    /// The controller's velocity estimate.
    pub velocity: f64,
    /// Voltage commanded to the amplifier, injected disturbance included.
    pub effort_v: f64,
    /// Motor current in A (voltage, for a direct motor) at the sample.
    pub current: f64,
    /// Motor force or torque at the sample, in N or N·m.
    pub thrust: f64,
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

/// A piece of the period in which the applied voltage does not change.
#[derive(Debug, Clone, Copy)]
struct Piece {
    circuit: CircuitStep,
    /// Whether the voltage of one period earlier is still applied.
    earlier: bool,
    /// Whether a step of the plant ends with this piece.
    ends_step: bool,
}

/// A machine's twin on one plant: configuration and everything that moves.
#[derive(Debug)]
pub struct Twin<P> {
    controller: Option<Controller>,
    amplifier: Amplifier,
    delay_periods: usize,
    pieces: Vec<Piece>,
    resistances: Vec<Effect>,
    pushes: Vec<Effect>,
    encoder: Encoder,
    current_sensor: CurrentSensor,
    period_s: f64,
    plant: P,
    moving: Moving,
    noise: Option<StdRng>,
}

/// What moves beside the plant.
#[derive(Debug, Clone)]
struct Moving {
    memory: Memory,
    velocity: VelocityMemory,
    current: f64,
    /// Commanded voltages, newest last; long enough for the delay.
    commanded_v: Vec<f64>,
}

impl<P: Plant> Twin<P> {
    /// The machine's twin on `plant`, whose step must divide the sample period.
    pub fn new(machine: &Machine, plant: P, sensing: Sensing) -> Self {
        let description = machine.description();
        let constants = machine.constants();
        let delay = SplitDelay::new(constants.delay_s, constants.sample_period_s);
        let acting = machine.effects();
        let select = |wanted: fn(&Effect) -> bool| acting.iter().filter(|e| wanted(e)).cloned().collect();
        let mut twin = Self {
            controller: description.controller.clone(),
            amplifier: Amplifier { voltage_limit_v: constants.voltage_limit_v, delay_s: constants.delay_s },
            delay_periods: delay.periods,
            pieces: pieces(&constants, delay.fraction, plant.step_s()),
            resistances: select(|effect| effect.acts().0),
            pushes: select(|effect| effect.acts().1),
            encoder: description.encoder.clone(),
            current_sensor: description.current_sensor.clone(),
            period_s: constants.sample_period_s,
            plant,
            moving: Moving {
                memory: Memory::default(),
                velocity: VelocityMemory::moving(0.0, 0.0, constants.sample_period_s),
                current: 0.0,
                commanded_v: Vec::new(),
            },
            noise: match sensing {
                Sensing::Perfect => None,
                Sensing::AsStated { seed } => Some(StdRng::seed_from_u64(seed)),
            },
        };
        twin.start(0.0, 0.0, 0.0);
        twin
    }

    /// Starts anew at a position with a velocity and a steadily commanded voltage.
    pub fn start(&mut self, position: f64, velocity: f64, effort_v: f64) {
        self.plant.place(position, velocity);
        self.moving.velocity = VelocityMemory::moving(position, velocity, self.period_s);
        self.moving.memory = Memory::default();
        self.moving.commanded_v = vec![effort_v; self.delay_periods + 2];
        self.moving.current = 0.0;
    }

    /// Sets the controller's memory so that it would command `effort_v` on `input`.
    pub fn take_over(&mut self, effort_v: f64, input: Input) {
        if let Some(controller) = &self.controller {
            self.moving.memory = controller.memory_for(effort_v, input, self.period_s);
        }
    }

    /// Sets the motor's current in A.
    pub fn set_current(&mut self, current: f64) {
        self.moving.current = current;
    }

    /// The plant.
    pub fn plant(&self) -> &P {
        &self.plant
    }

    /// The sample period in s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// One control period: senses, controls, records, then lets the axis move until the next sample.
    pub fn step(&mut self, command: Command) -> Sample {
        let (position, velocity) = self.sense();
        let effort_v = match (command.effort_v, &self.controller) {
            (Some(effort_v), _) => effort_v,
            (None, Some(controller)) => {
                let input = Input {
                    position_reference: command.position_reference,
                    velocity_reference: command.velocity_reference,
                    position,
                    velocity,
                };
                controller.effort_v(&mut self.moving.memory, input, self.period_s) + command.disturbance_v
            }
            (None, None) => 0.0,
        };
        let commanded = &mut self.moving.commanded_v;
        commanded.rotate_left(1);
        if let Some(newest) = commanded.last_mut() {
            *newest = effort_v;
        }
        let applied_v = [
            self.amplifier.clip_v(commanded[commanded.len() - 1 - self.delay_periods]),
            self.amplifier.clip_v(commanded[commanded.len() - 2 - self.delay_periods]),
        ];
        let current = self.sampled_current(applied_v);
        let sample = Sample {
            position,
            velocity,
            effort_v,
            current: current + self.current_noise(),
            thrust: current * self.pieces[0].circuit.effort_constant(),
        };
        self.travel(applied_v);
        sample
    }

    fn sense(&mut self) -> (f64, f64) {
        let position = self.plant.position();
        let reading = match &mut self.noise {
            None => position,
            Some(random) => {
                let noise: f64 = StandardNormal.sample(random);
                self.encoder.read(position, noise * self.encoder.noise_m)
            }
        };
        let velocity = self.encoder.velocity.update(&mut self.moving.velocity, reading, self.period_s);
        (reading, velocity)
    }

    /// Current at the sample; a direct motor follows its voltage at once.
    fn sampled_current(&self, applied_v: [f64; 2]) -> f64 {
        let first = &self.pieces[0];
        if first.circuit.has_current() { self.moving.current } else { applied_v[usize::from(first.earlier)] }
    }

    fn current_noise(&mut self) -> f64 {
        match &mut self.noise {
            None => 0.0,
            Some(random) => {
                let noise: f64 = StandardNormal.sample(random);
                noise * self.current_sensor.noise_a
            }
        }
    }

    /// Motor, guide and structure over one period.
    fn travel(&mut self, applied_v: [f64; 2]) {
        let mut impulse = 0.0;
        let step_s = self.plant.step_s();
        for piece in &self.pieces {
            let velocity = self.plant.velocity();
            let voltage = applied_v[usize::from(piece.earlier)];
            impulse += piece.circuit.advance(&mut self.moving.current, voltage, velocity)
                * piece.circuit.duration_s();
            if !piece.ends_step {
                continue;
            }
            let motor_force = impulse / step_s * piece.circuit.effort_constant();
            impulse = 0.0;
            // Position forces vary little over a step: their value halfway makes them second order.
            let halfway = self.plant.position() + 0.5 * step_s * velocity;
            let push: f64 = self.pushes.iter().map(|effect| effect.push(halfway, velocity)).sum();
            let coast = self.plant.coast(motor_force + push);
            let held = if self.resistances.is_empty() {
                0.0
            } else {
                friction(coast, |direction, speed| {
                    self.resistances.iter().map(|effect| effect.resistance(direction, speed)).sum()
                })
            };
            self.plant.advance(motor_force, push + held);
        }
    }
}

/// Cuts the period at plant steps and at the instant at which a fractional delay changes the voltage.
fn pieces(constants: &Constants, fraction: f64, step_s: f64) -> Vec<Piece> {
    let steps = (constants.sample_period_s / step_s).round().max(1.0) as usize;
    let change_s = fraction * constants.sample_period_s;
    let circuit = |duration_s| CircuitStep::new(&constants.circuit, duration_s);
    let mut pieces = Vec::with_capacity(steps + 1);
    for step in 0..steps {
        let (from, to) = (step as f64 * step_s, (step + 1) as f64 * step_s);
        let inside = change_s > from + 1e-9 * step_s && change_s < to - 1e-9 * step_s;
        if inside {
            pieces.push(Piece { circuit: circuit(change_s - from), earlier: true, ends_step: false });
            pieces.push(Piece { circuit: circuit(to - change_s), earlier: false, ends_step: true });
        } else {
            let earlier = change_s >= to - 1e-9 * step_s;
            pieces.push(Piece { circuit: circuit(step_s), earlier, ends_step: true });
        }
    }
    pieces
}
