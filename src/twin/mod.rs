//! The twin: one control period walked in hardware order, from command to sensor.
//!
//! ```text
//! command → controller → amplifier → motor → guide → structure → sensor → (back to controller)
//! ```

use crate::controller::{Controller, Input, Memory, ReferenceDelay};
use crate::drive::amplifier::{Amplifier, SplitDelay};
use crate::drive::motor::CircuitStep;
use crate::effect::{Constants, Door, Effect};
use crate::guide::Bristle;
use crate::guide::stick_slip::friction;
use crate::machine::Machine;
use crate::plant::{LoadModel, Plant};
use crate::sensor::{CurrentSensor, Encoder, End, LoadSensor, VelocityEstimate, VelocityMemory, rounded};
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
    /// Motor force or torque to apply instead of the motor's, in N or N·m.
    pub thrust: Option<f64>,
}

impl Command {
    /// Follow a reference, nothing injected.
    pub fn follow(position_reference: f64, velocity_reference: f64) -> Self {
        Self { position_reference, velocity_reference, disturbance_v: 0.0, effort_v: None, thrust: None }
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

/// A piece of the period in which the applied voltage does not change.
#[derive(Debug, Clone, Copy)]
struct Piece {
    circuit: CircuitStep,
    /// Whether the voltage of one period earlier is still applied.
    earlier: bool,
    /// Whether a step of the plant ends with this piece.
    ends_step: bool,
}

/// Laws that act along the path while the twin runs, by the door through which they do.
#[derive(Debug, Clone)]
struct Laws {
    resistances: Vec<Effect>,
    pushes: Vec<Effect>,
    ripples: Vec<Effect>,
    transmissions: Vec<Effect>,
    readings: Vec<Effect>,
    bristle: Option<Bristle>,
    /// Coulomb friction per sum of slider loads, and the loads where the plant does not know them.
    loaded: Option<(f64, LoadModel)>,
}

impl Laws {
    fn of(machine: &Machine) -> Self {
        let acting = machine.effects();
        let through = |door| acting.iter().filter(|e| e.acts_through(door)).cloned().collect::<Vec<_>>();
        let coefficient: f64 = acting.iter().map(Effect::load_coefficient).sum();
        Self {
            resistances: through(Door::Resistance),
            pushes: through(Door::Push),
            ripples: through(Door::Ripple),
            transmissions: through(Door::Transmission),
            readings: through(Door::Reading),
            bristle: acting.iter().find_map(Effect::bristle),
            loaded: (coefficient > 0.0)
                .then(|| LoadModel::of(machine).map(|model| (coefficient, model)))
                .flatten(),
        }
    }

    fn push(&self, position: f64, velocity: f64) -> f64 {
        self.pushes.iter().map(|effect| effect.push(position, velocity)).sum()
    }

    fn ripple(&self, position: f64) -> f64 {
        1.0 + self.ripples.iter().map(|effect| effect.ripple(position)).sum::<f64>()
    }

    /// Stops between which the drive train holds the load while the motor's end stands at `motor`.
    fn stops(&self, motor: f64) -> [f64; 2] {
        self.transmissions.iter().fold([motor; 2], |stops, effect| effect.stops(stops))
    }

    /// The load's position behind the drive train, from that before.
    fn transmit(&self, motor: f64, before: f64) -> f64 {
        let [rear, front] = self.stops(motor);
        // Not `clamp`: a position that a diverged replay has lost must not stop the program.
        if rear < front { before.max(rear).min(front) } else { 0.5 * (rear + front) }
    }

    /// The load's position with every play at its middle.
    fn middle(&self, motor: f64) -> f64 {
        let [rear, front] = self.stops(motor);
        0.5 * (rear + front)
    }

    fn read(&self, position: f64) -> f64 {
        self.readings.iter().fold(position, |reading, effect| effect.read(reading))
    }

    /// The position of the motor's end at which the encoder would show `reading`, every play at its middle.
    fn position_at(&self, reading: f64, end: End) -> f64 {
        let shown = |motor: f64| self.read(if end == End::Motor { motor } else { self.middle(motor) });
        // Errors of a reading are small against it, but a scale is not: divide by it first.
        let slope = (shown(reading + 1.0) - shown(reading)).abs().max(1e-3);
        (0..MOST_INVERSIONS).fold(reading, |motor, _| motor + (reading - shown(motor)) / slope)
    }
}

/// Readings that change less with position than this do not tell it.
const LEAST_SLOPE: f64 = 1e-3;
/// Fixed-point steps with which a reading is traced back to a position.
const MOST_INVERSIONS: usize = 12;

/// Positions of the load behind the machine's drive train while an encoder at the motor's end shows `shown`; every play
/// begins at its middle.
pub fn load_positions(machine: &Machine, shown: &[f64]) -> Vec<f64> {
    let laws = Laws::of(machine);
    let place = |&reading: &f64| {
        if laws.readings.is_empty() { reading } else { laws.position_at(reading, End::Motor) }
    };
    let mut load = shown.first().map_or(0.0, |first| laws.middle(place(first)));
    let follow = |reading| {
        load = laws.transmit(place(reading), load);
        load
    };
    shown.iter().map(follow).collect()
}

/// A machine's twin on one plant: configuration and everything that moves.
#[derive(Debug)]
pub struct Twin<P> {
    reference_delay: Option<ReferenceDelay>,
    controller: Option<Controller>,
    amplifier: Amplifier,
    delay_periods: usize,
    pieces: Vec<Piece>,
    laws: Laws,
    encoder: Encoder,
    velocity_estimate: VelocityEstimate,
    reading_step: f64,
    load_sensor: Option<LoadSensor>,
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
    /// Friction force in the bristles.
    bristle: f64,
    /// The load's position behind the drive train.
    load: f64,
    /// Reading of the second sensor less what it would be with the encoder's zero.
    load_zero: f64,
    /// Motor and guide force of the step before.
    forces: [f64; 2],
}

impl<P: Plant> Twin<P> {
    /// The machine's twin on `plant`, whose step must divide the sample period.
    pub fn new(machine: &Machine, plant: P, sensing: Sensing) -> Self {
        let description = machine.description();
        let constants = machine.constants();
        let delay = SplitDelay::new(constants.amplifier.delay_s, constants.sample_period_s);
        let laws = Laws::of(machine);
        let mut twin = Self {
            reference_delay: ReferenceDelay::new(description.reference.delay_s, constants.sample_period_s),
            delay_periods: delay.periods,
            pieces: pieces(&constants, delay.fraction, plant.step_s()),
            controller: constants.controller,
            amplifier: constants.amplifier,
            encoder: description.encoder.clone(),
            velocity_estimate: constants.velocity,
            reading_step: constants.reading_step,
            load_sensor: description.load_sensor.clone(),
            current_sensor: description.current_sensor.clone(),
            period_s: constants.sample_period_s,
            plant,
            moving: Moving {
                memory: Memory::default(),
                velocity: VelocityMemory::moving(0.0, 0.0, constants.sample_period_s),
                current: 0.0,
                commanded_v: Vec::new(),
                bristle: 0.0,
                load: 0.0,
                load_zero: 0.0,
                forces: [0.0; 2],
            },
            laws,
            noise: match sensing {
                Sensing::Perfect => None,
                Sensing::AsStated { seed } => Some(StdRng::seed_from_u64(seed)),
            },
        };
        twin.start(0.0, 0.0, 0.0);
        twin
    }

    /// Starts anew where the encoder shows `position`, with a velocity and a steadily commanded voltage.
    pub fn start(&mut self, position: f64, velocity: f64, effort_v: f64) {
        let motor = self.laws.position_at(position, self.encoder.end);
        self.plant.place(motor, velocity);
        let moving = &mut self.moving;
        moving.velocity = VelocityMemory::moving(position, velocity, self.period_s);
        moving.memory = Memory::default();
        moving.commanded_v = vec![effort_v; self.delay_periods + 2];
        moving.current = 0.0;
        moving.bristle = 0.0;
        moving.load = self.laws.middle(motor);
        moving.load_zero = 0.0;
        moving.forces = [0.0; 2];
        if let Some(delay) = &mut self.reference_delay {
            delay.clear();
        }
    }

    /// Goes on where the encoder shows `position` with a velocity; base, current, voltages under way, friction and
    /// the place inside every play stay as they are.
    pub fn restart(&mut self, position: f64, velocity: f64) {
        let (now, end) = (self.plant.position(), self.encoder.end);
        let shown = |motor: f64| {
            let load = self.laws.transmit(motor, self.moving.load + motor - now);
            self.laws.read(if end == End::Motor { motor } else { load })
        };
        let slope = shown(now + 1.0) - shown(now);
        let slope = if slope.abs() > LEAST_SLOPE { slope } else { 1.0 };
        let motor = (0..MOST_INVERSIONS).fold(now, |motor, _| motor + (position - shown(motor)) / slope);
        let travel = self.period_s * velocity;
        let local = (shown(motor + travel) - shown(motor)) / travel;
        let local = if local.abs() > LEAST_SLOPE { local } else { slope };
        let jump = [position - shown(now), velocity - self.plant.velocity() * local];
        self.plant.relocate(motor, velocity / local);
        self.moving.velocity = self.moving.velocity.shifted(jump[0], jump[1], self.period_s);
        self.moving.load += motor - now;
    }

    /// Sets the zero of the second sensor by what it shows at the start.
    pub fn set_load_reading(&mut self, reading: f64) {
        let load = self.laws.transmit(self.plant.position(), self.moving.load);
        self.moving.load_zero = reading - load;
    }

    /// Sets the controller's memory so that it would command `effort_v` on `input`.
    pub fn take_over(&mut self, effort_v: f64, mut input: Input) {
        if let Some(delay) = &self.reference_delay {
            input.position_reference = delay.extrapolated(input.position_reference, input.velocity_reference);
        }
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
        let Reading { position, velocity, load_position, controlled } = self.sense();
        let [position_reference, velocity_reference] = match &mut self.reference_delay {
            Some(delay) => delay.pass(command.position_reference, command.velocity_reference),
            None => [command.position_reference, command.velocity_reference],
        };
        let effort_v = match (command.effort_v, &self.controller) {
            (Some(effort_v), _) => effort_v,
            (None, Some(controller)) => {
                let input = Input { position_reference, velocity_reference, position: controlled, velocity };
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
            self.amplifier.output_v(commanded[commanded.len() - 1 - self.delay_periods]),
            self.amplifier.output_v(commanded[commanded.len() - 2 - self.delay_periods]),
        ];
        let current = self.sampled_current(applied_v);
        let own_thrust =
            current * self.pieces[0].circuit.effort_constant() * self.laws.ripple(self.plant.position());
        let sample = Sample {
            position,
            velocity,
            effort_v,
            current: current + self.current_noise(),
            thrust: command.thrust.unwrap_or(own_thrust),
            load_position,
        };
        self.travel(applied_v, command.thrust);
        sample
    }

    fn sense(&mut self) -> Reading {
        let motor = self.plant.position();
        let load = self.laws.transmit(motor, self.moving.load);
        self.moving.load = load;
        let seen = self.laws.read(if self.encoder.end == End::Motor { motor } else { load });
        let unrounded = match &mut self.noise {
            None => seen,
            Some(random) => {
                let noise: f64 = StandardNormal.sample(random);
                self.encoder.read(seen, noise * self.encoder.noise_m)
            }
        };
        let position = rounded(unrounded, self.reading_step);
        let velocity = self.velocity_estimate.update(&mut self.moving.velocity, position, self.period_s);
        let Some(sensor) = &self.load_sensor else {
            return Reading { position, velocity, load_position: position, controlled: position };
        };
        let noise: f64 = self.noise.as_mut().map_or(0.0, |random| StandardNormal.sample(random));
        let shown = load + self.moving.load_zero;
        let load_position =
            if self.noise.is_some() { sensor.read(shown, noise * sensor.noise_m) } else { shown };
        let controlled = if sensor.closes_position_loop { load_position } else { position };
        Reading { position, velocity, load_position, controlled }
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

    /// Motor, guide and structure over one period; `thrust` takes the motor's place.
    fn travel(&mut self, applied_v: [f64; 2], thrust: Option<f64>) {
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
            let mean_force = impulse / step_s * piece.circuit.effort_constant();
            impulse = 0.0;
            // Position forces vary little over a step: their value halfway makes them second order.
            let halfway = self.plant.position() + 0.5 * step_s * velocity;
            let motor_force = thrust.unwrap_or_else(|| mean_force * self.laws.ripple(halfway));
            let push = self.laws.push(halfway, velocity);
            let held = hold(&self.laws, &mut self.moving, &mut self.plant, motor_force, push);
            self.plant.advance(motor_force, push + held);
            self.moving.forces = [motor_force, push + held];
        }
    }
}

/// What the sensors show at a sample.
struct Reading {
    position: f64,
    velocity: f64,
    load_position: f64,
    /// The position that the controller's position loop is closed on.
    controlled: f64,
}

/// Friction force of the guide, held over the coming step.
#[inline]
fn hold<P: Plant>(laws: &Laws, moving: &mut Moving, plant: &mut P, motor_force: f64, push: f64) -> f64 {
    let mut coast = plant.coast(motor_force + push);
    let mut bristles = 0.0;
    if let Some(bristle) = &laws.bristle {
        (bristles, moving.bristle) = bristle.step(moving.bristle, coast, plant.step_s());
        coast.free_velocity += coast.mobility * bristles;
    }
    let loaded = laws.loaded.as_ref().map_or(0.0, |(coefficient, model)| {
        let loads = plant.slider_loads().unwrap_or_else(|| model.loads(moving.forces));
        coefficient * loads.iter().map(|load| load.abs()).sum::<f64>()
    });
    if laws.resistances.is_empty() && loaded == 0.0 {
        return bristles;
    }
    bristles
        + friction(coast, |direction, speed| {
            loaded + laws.resistances.iter().map(|effect| effect.resistance(direction, speed)).sum::<f64>()
        })
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
