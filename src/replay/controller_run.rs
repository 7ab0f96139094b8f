//! What a controller saw and commanded, from a recorded run.

use super::compared::{as_set, check};
use super::follow;
use crate::controller::filter::FilterMemory;
use crate::controller::regression::ControllerRun;
use crate::controller::{Filters, Input, ReferenceDelay};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::sensor::VelocityMemory;

/// A recorded effort this near to the limit of controller or amplifier may have been clipped.
const AT_LIMIT: f64 = 1.0 - 1e-6;
/// Samples after which an estimate of velocity has forgotten how it was started, in its time constants.
const FORGOTTEN: f64 = 12.0;

/// The inputs and the effort of the machine's controller in a recorded run, with the run's settings in force.
///
/// The velocity is the logged one, else the machine's own estimate from the logged position. The velocity reference is
/// the difference of the position reference. An injected disturbance is taken off the effort. Filters behind a law that is
/// linear may as well stand before it: the inputs are filtered, and the law is one without filters.
///
/// # Errors
/// A machine without a controller; a run without position reference, position (that of the load, where the loop is
/// closed on it) or control effort; another kind of axis or sample period than the machine's; a setting that the machine does not have.
pub fn controller_run(machine: &Machine, run: &Run) -> Result<ControllerRun> {
    check(run, machine)?;
    let machine = as_set(run, machine)?;
    let constants = machine.constants();
    let limit_v = constants.effort_limit_v().map(|limit| AT_LIMIT * limit);
    let Some(law) = constants.controller else {
        return Err(machine
            .lacks_controller()
            .remedy("state the law that the drive runs, with any gains: these are what is identified"));
    };
    let sensor = machine.description().load_sensor.as_ref();
    let closed_on =
        if sensor.is_some_and(|s| s.closes_position_loop) { Signal::LoadPosition } else { Signal::Position };
    let (reference, controlled) = (run.require(Signal::PositionReference)?, run.require(closed_on)?);
    let effort = run.require(Signal::ControlEffort)?;
    let disturbance = run.signal(Signal::DisturbanceVoltage);
    let period_s = run.sample_period_s();
    let (velocity, unusable) = match run.signal(Signal::Velocity) {
        Some(velocity) => (velocity.to_vec(), 0),
        None => {
            let position = run.require(Signal::Position)?;
            let mut memory = VelocityMemory::moving(position[0], 0.0, period_s);
            let estimate = &constants.velocity;
            let velocity = position.iter().map(|x| estimate.update(&mut memory, *x, period_s)).collect();
            let samples = FORGOTTEN * (1.0 + estimate.time_constant_s() / period_s);
            (velocity, samples.ceil() as usize)
        }
    };
    let mut delay = ReferenceDelay::new(machine.description().reference.delay_s, period_s);
    let mut filter = InputFilter::new(Filters::new(law.filters(), period_s));
    let inputs = follow(reference, period_s).enumerate().map(|(k, command)| {
        let stated = [command.position_reference, command.velocity_reference];
        let [position_reference, velocity_reference] = match &mut delay {
            Some(delay) => delay.pass(stated[0], stated[1]),
            None => stated,
        };
        filter.pass(Input {
            position_reference,
            velocity_reference,
            position: controlled[k],
            velocity: velocity[k],
        })
    });
    // The velocity reference of the first sample has no sample before it.
    let first = unusable.max(1);
    Ok(ControllerRun {
        law: law.unfiltered(),
        period_s,
        inputs: inputs.skip(first).collect(),
        effort_v: (first..effort.len()).map(|k| effort[k] - disturbance.map_or(0.0, |d| d[k])).collect(),
        limit_v,
    })
}

/// The law's filters, one set for each of its inputs.
struct InputFilter {
    filters: Filters,
    memories: Option<[FilterMemory; 4]>,
}

impl InputFilter {
    fn new(filters: Filters) -> Self {
        Self { filters, memories: None }
    }

    fn pass(&mut self, input: Input) -> Input {
        if self.filters.is_empty() {
            return input;
        }
        let Input { position_reference, velocity_reference, position, velocity } = input;
        let mut values = [position_reference, velocity_reference, position, velocity];
        let memories = self.memories.get_or_insert_with(|| values.map(|value| self.filters.steady(value)));
        for (value, memory) in values.iter_mut().zip(memories) {
            *value = self.filters.pass(memory, *value);
        }
        let [position_reference, velocity_reference, position, velocity] = values;
        Input { position_reference, velocity_reference, position, velocity }
    }
}
