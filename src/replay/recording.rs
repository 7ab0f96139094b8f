//! From replayed traces to a run as a recording holds it.

use std::collections::BTreeMap;

use super::Traces;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};

/// Names of the extra columns that hold the vertical loads of the bearing sliders A–D, in N.
pub const SLIDER_COLUMNS: [&str; 4] = ["slider_a_n", "slider_b_n", "slider_c_n", "slider_d_n"];

/// The run that a data logger would have made of a replay: references, position, velocity, effort, thrust;
/// current where the motor has one; slider loads as extra columns where the plant knows them.
///
/// # Validity
/// Position, velocity and current are what the twin's sensors say. Thrust and slider loads are the
/// simulation's own: no sensor stands between.
///
/// # Errors
/// A name that cannot name a file, traces of another length than the reference, no samples, or numbers that
/// are not finite.
pub fn recorded(name: &str, machine: &Machine, reference: &[f64], traces: Traces) -> Result<Run> {
    let period_s = machine.description().sample_period_s;
    let velocity_reference = super::follow(reference, period_s).map(|c| c.velocity_reference).collect();
    let told = BTreeMap::from([
        (Signal::PositionReference, reference.to_vec()),
        (Signal::VelocityReference, velocity_reference),
    ]);
    logged(name, machine, told, traces)
}

/// The same beside whatever the axis was told.
///
/// # Errors
/// See [`recorded`].
pub fn logged(
    name: &str,
    machine: &Machine,
    told: BTreeMap<Signal, Vec<f64>>,
    traces: Traces,
) -> Result<Run> {
    let period_s = machine.description().sample_period_s;
    let mut signals = told;
    signals.extend([
        (Signal::ControlEffort, traces.effort_v),
        (Signal::Thrust, traces.thrust),
        (Signal::Position, traces.position),
        (Signal::Velocity, traces.velocity),
    ]);
    if machine.description().motor.has_current() {
        signals.insert(Signal::Current, traces.current);
    }
    if machine.description().load_sensor.is_some() {
        signals.insert(Signal::LoadPosition, traces.load_position);
    }
    let run = Run::new(name, machine.motion(), period_s, signals)?;
    if traces.slider_loads.is_empty() {
        return Ok(run);
    }
    let column = |slider: usize| traces.slider_loads.iter().map(|loads| loads[slider]).collect();
    run.with_extra_columns((0..4).map(|slider| (SLIDER_COLUMNS[slider].to_owned(), column(slider))).collect())
}
