//! What a controller saw and commanded, from a recorded run.

use super::follow;
use crate::controller::regression::ControllerRun;
use crate::controller::{Input, ReferenceDelay};
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::sensor::VelocityMemory;

/// A recorded effort this near to the limit of controller or amplifier may have been clipped.
const AT_LIMIT: f64 = 1.0 - 1e-6;
/// Sample periods of recording and machine agree to this fraction.
const PERIOD_AGREEMENT: f64 = 1e-3;
/// Samples after which an estimate of velocity has forgotten how it was started, in its time constants.
const FORGOTTEN: f64 = 12.0;

/// The inputs and the effort of the machine's controller in a recorded run, with the run's settings in force.
///
/// The velocity is the logged one, else the machine's own estimate from the logged position. The velocity reference is
/// the difference of the position reference. An injected disturbance is taken off the effort.
///
/// # Errors
/// A machine without a controller; a run without position reference, position (that of the load, where the loop is
/// closed on it) or control effort; a setting that the machine does not have.
pub fn controller_run(machine: &Machine, run: &Run) -> Result<ControllerRun> {
    let settings = run.settings.iter().map(|(path, value)| (path.as_str(), value.clone()));
    let machine = machine.with_settings(settings)?;
    let constants = machine.constants();
    let limit_v = constants.effort_limit_v().map(|limit| AT_LIMIT * limit);
    let Some(law) = constants.controller else {
        return Err(Error::new(ErrorKind::Missing)
            .file(machine.file())
            .key("controller")
            .found("a machine without a control law")
            .expected("the table [controller]")
            .remedy("state the law that the drive runs, with any gains: these are what is identified"));
    };
    check_period(&machine, run)?;
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
    let inputs = follow(reference, period_s).enumerate().map(|(k, command)| {
        let stated = [command.position_reference, command.velocity_reference];
        let [position_reference, velocity_reference] = match &mut delay {
            Some(delay) => delay.pass(stated[0], stated[1]),
            None => stated,
        };
        Input { position_reference, velocity_reference, position: controlled[k], velocity: velocity[k] }
    });
    // The velocity reference of the first sample has no sample before it.
    let first = unusable.max(1);
    Ok(ControllerRun {
        law,
        period_s,
        inputs: inputs.skip(first).collect(),
        effort_v: (first..effort.len()).map(|k| effort[k] - disturbance.map_or(0.0, |d| d[k])).collect(),
        limit_v,
    })
}

/// Refuses a run that was not sampled at the controller's period: its law then is another one.
fn check_period(machine: &Machine, run: &Run) -> Result<()> {
    let stated = machine.description().sample_period_s;
    if (run.sample_period_s() / stated - 1.0).abs() <= PERIOD_AGREEMENT {
        return Ok(());
    }
    let error = Error::new(ErrorKind::Inconsistent)
        .key(format!("{}.sample_period_s", run.name()))
        .found(format!("{} s in the recording and {stated} s in the machine", run.sample_period_s()))
        .expected("the controller's sample period in both")
        .remedy("correct sample_period_s of machine.toml, or record at the controller's rate");
    Err(if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) })
}
