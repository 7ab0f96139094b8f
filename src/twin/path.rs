//! The signal path around a plant: sensors, controller, amplifier, and the laws that act beside them.

use super::acting::{Acting, Begun};
use super::current::CurrentWithin;
use super::front::{Entry, Numbers};
use super::laws::{Here, InitialForces, Laws, MOST_INVERSIONS, Resistance};
use super::slides::SlidingStep;
use super::{Command, Sample, Sensing};
use crate::controller::delay_line::DelayLine;
use crate::controller::{Controller, EffortLimit, Filters, Gains, Input, Memory, ReferenceDelay};
use crate::drive::amplifier::{Amplifier, SplitDelay};
use crate::drive::motor::Circuit;
use crate::effect::Wave;
use crate::guide::{Coast, GAUSS, StepForce};
use crate::machine::Machine;
use crate::plant::{Drive, Load, LoadFriction, Plant};
use crate::sensor::{
    CurrentSensor, Encoder, End, LoadSensor, LogScale, VelocityEstimate, VelocityMemory, rounded,
};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// Readings that change less with position than this do not tell it.
pub(super) const LEAST_SLOPE: f64 = 1e-3;

/// Everything of a twin but its plant.
#[derive(Debug)]
pub(super) struct Path {
    reference_delay: Option<ReferenceDelay>,
    controller: Option<Controller>,
    gains: Option<Gains>,
    effort_limit: Option<EffortLimit>,
    filters: Filters,
    amplifier: Amplifier,
    /// Voltages commanded, in V.
    commanded: DelayLine<f64>,
    /// Share of each step of a period in which the voltage of one period earlier is still applied.
    switches: Vec<f64>,
    laws: Laws,
    /// The motor's force at the [`GAUSS`] points of a step.
    within: [CurrentWithin; 2],
    encoder: Encoder,
    velocity_estimate: VelocityEstimate,
    reading_step: f64,
    log_scale: LogScale,
    load_sensor: Option<LoadSensor>,
    current_sensor: CurrentSensor,
    has_winding: bool,
    force_constant: f64,
    period_s: f64,
    step_s: f64,
    moving: Moving,
    noise: Option<StdRng>,
}

/// What moves beside the plant.
#[derive(Debug, Clone)]
struct Moving {
    memory: Memory,
    velocity: VelocityMemory,
    /// Friction force in the bristles.
    bristle: f64,
    /// The load's position behind the drive train.
    load: f64,
    /// That of the motor's end at the same sample.
    motor: f64,
    /// Reading of the second sensor less what it would be with the encoder's zero.
    load_zero: f64,
    /// Motor and guide force of the step before.
    forces: [f64; 2],
    /// Sum of all forces of the step before but that of the motor in proportion to its current, N or N·m.
    others: f64,
    /// Rise over the period of the force in the motor's place.
    thrust_rise: f64,
    /// Time of the session in s.
    clock_s: f64,
}

/// What the sensors show at a sample.
struct Reading {
    position: f64,
    velocity: f64,
    load_position: f64,
    /// The position that the controller's position loop is closed on.
    controlled: f64,
}

impl Path {
    /// The path of a machine around a plant, which gives the length of its steps and whether it has weight in itself.
    pub fn new(machine: &Machine, plant: &impl Plant, sensing: Sensing) -> Self {
        let step_s = plant.step_s();
        let description = machine.description();
        let constants = machine.constants();
        let delay = SplitDelay::new(constants.amplifier.delay_s, constants.sample_period_s);
        Self {
            reference_delay: ReferenceDelay::new(description.reference.delay_s, constants.sample_period_s),
            commanded: DelayLine::steady(delay.periods, 0.0),
            switches: switches(constants.sample_period_s, delay.fraction, step_s),
            laws: Laws::of(machine, plant.carries_weight()),
            within: GAUSS.map(|share| {
                CurrentWithin::of(&constants.circuit, share, step_s, plant.includes_other_forces())
            }),
            encoder: description.encoder.clone(),
            load_sensor: description.load_sensor.clone(),
            current_sensor: description.current_sensor.clone(),
            has_winding: matches!(constants.circuit, Circuit::Winding { .. }),
            force_constant: constants.force_constant(),
            gains: constants.controller.as_ref().map(|law| law.gains(constants.sample_period_s)),
            effort_limit: constants.controller.as_ref().and_then(Controller::limit),
            filters: Filters::new(
                constants.controller.as_ref().map_or(&[], Controller::filters),
                constants.sample_period_s,
            ),
            controller: constants.controller,
            amplifier: constants.amplifier,
            velocity_estimate: constants.velocity,
            reading_step: constants.reading_step,
            log_scale: constants.log_scale,
            period_s: constants.sample_period_s,
            step_s,
            moving: Moving {
                memory: Memory::default(),
                velocity: VelocityMemory::moving(0.0, 0.0, constants.sample_period_s),
                bristle: 0.0,
                load: 0.0,
                motor: 0.0,
                load_zero: 0.0,
                forces: [0.0; 2],
                others: 0.0,
                thrust_rise: 0.0,
                clock_s: 0.0,
            },
            noise: match sensing {
                Sensing::Perfect => None,
                Sensing::AsStated { seed } => Some(StdRng::seed_from_u64(seed)),
            },
        }
    }

    /// Starts anew where the encoder shows `position`; the position of the plant.
    pub fn start(&mut self, position: f64, velocity: f64, effort_v: f64) -> f64 {
        let motor = self.laws.position_at(position, self.encoder.end);
        self.commanded = DelayLine::steady(self.commanded.delay(), effort_v);
        let moving = &mut self.moving;
        moving.velocity = VelocityMemory::moving(position, velocity, self.period_s);
        moving.memory = Memory::default();
        moving.bristle = 0.0;
        (moving.load, moving.motor) = (self.laws.load_at_start(motor), motor);
        moving.load_zero = 0.0;
        (moving.forces, moving.others) = ([0.0; 2], 0.0);
        if let Some(delay) = &mut self.reference_delay {
            delay.clear();
        }
        motor
    }

    /// Goes on where the encoder shows `position` with a velocity; position and velocity of the plant, which has those
    /// given first.
    pub fn restart(&mut self, [now, speed]: [f64; 2], position: f64, velocity: f64) -> [f64; 2] {
        let end = self.encoder.end;
        let shown = |motor: f64| {
            let load = self.laws.transmit(motor, self.moving.load + motor - now, 0.0);
            self.laws.read(if end == End::Motor { motor } else { load })
        };
        let slope = shown(now + 1.0) - shown(now);
        let slope = if slope.abs() > LEAST_SLOPE { slope } else { 1.0 };
        let motor = (0..MOST_INVERSIONS).fold(now, |motor, _| motor + (position - shown(motor)) / slope);
        let travel = self.period_s * velocity;
        let local = (shown(motor + travel) - shown(motor)) / travel;
        let local = if local.abs() > LEAST_SLOPE { local } else { slope };
        let jump = [position - shown(now), velocity - speed * local];
        self.moving.velocity = self.moving.velocity.shifted(jump[0], jump[1], self.period_s);
        self.moving.load += motor - now;
        self.moving.motor += motor - now;
        [motor, velocity / local]
    }

    /// Sets the session's clock, in s.
    pub fn set_clock(&mut self, clock_s: f64) {
        self.moving.clock_s = clock_s;
    }

    /// Sets the bristles of the guide's friction; see [`Laws::initial_bristle_force`].
    pub fn initialise_friction(&mut self, state: [f64; 2], start: InitialForces) {
        self.moving.bristle = self.laws.initial_bristle_force(state, self.moving.clock_s, start);
    }

    /// Sets the zero of the second sensor by what it shows while the plant stands at `motor`.
    pub fn set_load_reading(&mut self, motor: f64, reading: f64) {
        let load = self.laws.transmit(motor, self.moving.load, 0.0);
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

    /// The sample period in s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Steps of the plant in one period.
    pub fn steps(&self) -> usize {
        self.switches.len()
    }

    /// What the path brings into a [`Front`](super::front::Front), where it fits into one.
    pub fn front(&self) -> Option<Entry> {
        let plain = self.laws.shows_position() && self.noise.is_none() && self.reading_step == 0.0;
        let direct = self.load_sensor.is_none()
            && self.log_scale == LogScale::default()
            && self.reference_delay.is_none()
            && self.effort_limit.is_none()
            && self.filters.is_empty();
        let VelocityEstimate::SmoothedDifference { time_constant_s } = self.velocity_estimate else {
            return None;
        };
        let gains = self.gains.filter(|_| plain && direct)?;
        let numbers = Numbers {
            rate: 1.0 / self.period_s,
            share: self.period_s / (self.period_s + time_constant_s),
            position: gains.position,
            feedforward: gains.feedforward,
            integral: gains.integral,
            error: gains.error,
            velocity: gains.velocity,
            dead_zone_v: self.amplifier.dead_zone_v,
            offset_v: self.amplifier.offset_v,
            limit_v: self.amplifier.voltage_limit_v.unwrap_or(f64::INFINITY),
            supply_v: self.amplifier.gain(),
            force_constant: self.force_constant,
        };
        Some(Entry {
            numbers,
            previous: self.moving.velocity.newest_reading(),
            estimate: self.moving.velocity.estimate(),
            integral_v: self.moving.memory.integral_v,
            commanded: self.commanded.newest_first().collect(),
            is_split: self.switches[0] > 0.0,
            has_supply: self.amplifier.supply_v.is_some(),
            has_winding: self.has_winding,
        })
    }

    /// See [`Laws::constant_friction`].
    pub fn constant_friction(&self) -> Option<[f64; 2]> {
        self.laws.constant_friction()
    }

    /// Share of a step of the period in which the voltage of one period earlier is still applied.
    pub fn switch(&self, step: usize) -> f64 {
        self.switches[step]
    }

    /// One sample: senses, controls, records. What is recorded, and the voltages applied until the next sample: the new
    /// one and the one that the delay still lets through before it.
    #[inline(always)]
    pub fn sample(&mut self, command: Command, motor: f64, current_a: f64) -> (Sample, [f64; 2]) {
        let Reading { position, velocity, load_position, controlled } = self.sense(motor);
        let [position_reference, velocity_reference] = match &mut self.reference_delay {
            Some(delay) => delay.pass(command.position_reference, command.velocity_reference),
            None => [command.position_reference, command.velocity_reference],
        };
        let effort_v = match (command.effort_v, &self.gains) {
            _ if !command.is_enabled => {
                self.moving.memory = Memory::default();
                0.0
            }
            (Some(effort_v), _) => effort_v,
            (None, Some(gains)) => {
                let input = Input { position_reference, velocity_reference, position: controlled, velocity };
                let memory = &mut self.moving.memory;
                let controlled_v = match &self.effort_limit {
                    None => gains.effort_v(memory, input),
                    Some(limit) => limit.effort_v(gains, memory, input, self.period_s),
                };
                let filtered_v = if self.filters.is_empty() {
                    controlled_v
                } else {
                    self.filters.pass(&mut memory.filters, controlled_v)
                };
                filtered_v + command.disturbance_v
            }
            (None, None) => 0.0,
        };
        let fed_v = if command.is_enabled { command.feedforward_v } else { 0.0 };
        let [now_v, earlier_v] = self.commanded.pass(effort_v + fed_v);
        let gain = self.amplifier.gain_under(command.supply_v);
        let now_v = gain * self.amplifier.output_v(now_v);
        let is_split = self.switches[0] > 0.0;
        let applied_v = [now_v, if is_split { gain * self.amplifier.output_v(earlier_v) } else { now_v }];
        // A direct motor follows its voltage at once.
        let current = if self.has_winding { current_a } else { applied_v[usize::from(is_split)] };
        self.moving.thrust_rise = command.thrust_rise;
        let proportional = current * self.force_constant;
        let own_thrust = proportional * self.laws.motor_factor(motor, proportional);
        let sample = Sample {
            position,
            velocity,
            effort_v: self.log_scale.effort * effort_v,
            current: self.log_scale.current * current + self.current_noise(),
            thrust: command.thrust.unwrap_or(own_thrust),
            load_position,
        };
        (sample, applied_v)
    }

    /// What drives a step of the period; `thrust` takes the motor's place.
    #[inline(always)]
    pub fn drive(&self, step: usize, [now_v, earlier_v]: [f64; 2], thrust: Option<f64>) -> Drive {
        match thrust {
            Some(thrust) => {
                let middle = (step as f64 + 0.5) / self.steps() as f64;
                Drive::Force(thrust + self.moving.thrust_rise * (middle - 0.5))
            }
            None => Drive::Voltage { earlier_v, now_v, switch: self.switches[step] },
        }
    }

    /// What acts at the motor beside its own force, and what acts at the guide, over the step that was looked at.
    #[inline(always)]
    pub fn forces(
        &mut self,
        drive: Drive,
        coast: Coast,
        position: f64,
        loads: impl FnMut() -> Option<[f64; 4]>,
    ) -> [StepForce; 2] {
        let (acting, resistance) = self.act(drive, coast, position, loads);
        self.end(&acting, resistance.resolved(self.moving.bristle))
    }

    /// What acts over the step that was looked at, and the dry friction, that of bristles still to be found.
    #[inline(always)]
    pub fn act(
        &mut self,
        drive: Drive,
        coast: Coast,
        position: f64,
        loads: impl FnMut() -> Option<[f64; 4]>,
    ) -> (Acting, Resistance) {
        let begun = self.begin(drive, coast, position, None, loads);
        self.resist(&begun)
    }

    /// What acts over the step that was looked at but for weight and dry friction; `waves` as in [`Laws::push_over`].
    #[inline(always)]
    pub fn begin(
        &mut self,
        drive: Drive,
        coast: Coast,
        position: f64,
        waves: Option<[f64; 2]>,
        mut loads: impl FnMut() -> Option<[f64; 4]>,
    ) -> Begun {
        let [begin_n, end_n] = coast.motor_force;
        let here = Here { position, step_s: self.step_s, clock_s: self.moving.clock_s };
        self.moving.clock_s += self.step_s;
        let push = self.laws.push_over(coast, here, waves);
        let (before, others) = (self.moving.forces, self.moving.others);
        let change = match drive {
            Drive::Voltage { .. } => self.laws.motor_change_over(coast, here, others, &self.within),
            // A force in the motor's place was measured as it came out, changes included: its rise is left to add.
            Drive::Force(_) => {
                StepForce { mean: 0.0, rise: self.moving.thrust_rise / self.switches.len() as f64 }
            }
        };
        let motor = 0.5 * (begin_n + end_n) + change.mean;
        let levels = |of: &LoadFriction| match of.load() {
            Load::Sliders(_) => of.levels(loads(), before, position),
            Load::Transmitted(_) => of.levels(None, [motor, before[1]], position),
        };
        let loaded = self.laws.loaded(levels);
        let acting = Acting { push, change, motor, weight: StepForce::ZERO };
        Begun { acting, coast: coast.under(change + push), here, loaded }
    }

    /// The step with its weight, and its dry friction; that of bristles is still to be found.
    #[inline(always)]
    pub fn resist(&self, begun: &Begun) -> (Acting, Resistance) {
        let Begun { coast, here, loaded, .. } = *begun;
        let (weight, resistance) = self.laws.weight_and_friction(coast, here, self.moving.bristle, loaded);
        (begun.under(weight), resistance)
    }

    /// See [`Laws::waves`].
    pub fn waves(&self) -> &[Wave] {
        self.laws.waves()
    }

    /// See [`Laws::may_slide`].
    pub fn may_slide(&self) -> bool {
        self.laws.may_slide()
    }

    /// See [`Laws::sliding`].
    #[inline(always)]
    pub fn sliding(&self, begun: &Begun) -> SlidingStep {
        self.laws.sliding(begun.coast, begun.here, begun.loaded)
    }

    /// The forces of [`forces`](Self::forces), once the friction is found and the bristles' force at the end.
    #[inline(always)]
    pub fn end(&mut self, acting: &Acting, (friction, bristle_force): (StepForce, f64)) -> [StepForce; 2] {
        let guide = acting.push + friction;
        self.moving.bristle = bristle_force;
        self.moving.forces = [acting.motor, guide.mean];
        let guide = guide + acting.weight;
        self.moving.others = acting.change.mean + guide.mean;
        [acting.change, guide]
    }

    /// Force in the bristles, N or N·m.
    #[inline(always)]
    pub fn bristle_force(&self) -> f64 {
        self.moving.bristle
    }

    #[inline(always)]
    fn sense(&mut self, motor: f64) -> Reading {
        let load = self.laws.transmit(motor, self.moving.load, motor - self.moving.motor);
        (self.moving.load, self.moving.motor) = (load, motor);
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

    #[inline]
    fn current_noise(&mut self) -> f64 {
        match &mut self.noise {
            None => 0.0,
            Some(random) => {
                let noise: f64 = StandardNormal.sample(random);
                noise * self.current_sensor.noise_a
            }
        }
    }
}

/// Share of each plant step of a period in which the voltage of one period earlier is still applied, with a delay of
/// `fraction` of a period beyond whole ones.
fn switches(period_s: f64, fraction: f64, step_s: f64) -> Vec<f64> {
    let steps = (period_s / step_s).round().max(1.0) as usize;
    let change = fraction * period_s / step_s;
    let share = |step: usize| {
        let share = change - step as f64;
        // Rounding must not leave a sliver of the other voltage.
        if share < 1e-9 {
            0.0
        } else if share > 1.0 - 1e-9 {
            1.0
        } else {
            share
        }
    };
    (0..steps).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_steps_of_a_period_share_the_earlier_voltage() {
        assert_eq!(switches(1e-3, 0.0, 250e-6), [0.0; 4]);
        let shares = switches(1e-3, 0.4, 250e-6);
        assert!(shares[0] == 1.0 && (shares[1] - 0.6).abs() < 1e-12 && shares[2..] == [0.0, 0.0]);
        assert_eq!(switches(1e-3, 0.5, 250e-6), [1.0, 1.0, 0.0, 0.0]);
    }
}
