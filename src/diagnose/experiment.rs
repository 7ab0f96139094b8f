//! The runs of a diagnosis, ready to be replayed and compared.

use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::axis::Axis;
use crate::recording::{Run, Signal};
use crate::replay::{Recorded, Traces};
use crate::twin::Sensing;

/// Signals that a replay predicts and that are compared where they were logged, in signal-path order.
pub const COMPARED: [Signal; 6] = [
    Signal::ControlEffort,
    Signal::Current,
    Signal::Thrust,
    Signal::Position,
    Signal::Velocity,
    Signal::LoadPosition,
];

/// Shorter runs say nothing that noise does not.
const LEAST_SAMPLES: usize = 50;
/// Positions may lie so far outside the joint's limits, in shares of its range: limits are round numbers.
const TRAVEL_MARGIN: f64 = 0.25;

/// Refuses positions and references that the joint cannot reach: a unit is wrong, or the machine.
fn check_travel(run: &Run, machine: &Machine) -> Result<()> {
    let joint = &machine.solid().joint;
    let margin = TRAVEL_MARGIN * (joint.upper - joint.lower);
    for signal in [Signal::PositionReference, Signal::Position] {
        let samples = run.signal(signal).unwrap_or_default();
        let outside = |x: &f64| *x < joint.lower - margin || *x > joint.upper + margin;
        if let Some(sample) = samples.iter().position(outside) {
            let unit = signal.si_unit(run.motion());
            return Err(Error::new(ErrorKind::Unit)
                .file(&run.file)
                .key(signal.key(run.motion()))
                .found(format!("{} {unit} at sample {sample}", samples[sample]))
                .expected(format!("positions from {} to {} {unit}, the limits of joint `{}`", joint.lower, joint.upper, joint.name))
                .remedy("give the column's unit in [columns], for instance unit = \"mm\", or correct the limits in the URDF"));
        }
    }
    Ok(())
}

/// One run: what was recorded and how to replay it.
#[derive(Debug, Clone)]
pub struct Experiment {
    run: Run,
    recorded: Recorded,
    signals: Vec<Signal>,
}

impl Experiment {
    /// Makes a run ready.
    ///
    /// # Errors
    /// A run without position reference or position, a run too short to tell anything, positions that the joint
    /// cannot reach, a sample period that is not the machine's, or a machine whose controller is not stated.
    pub fn new(run: &Run, machine: &Machine) -> Result<Self> {
        let description = machine.description();
        if description.controller.is_none() {
            return Err(Error::new(ErrorKind::Missing)
                .file(machine.file())
                .key("controller")
                .found("a machine without a controller")
                .expected("the control law that ran when the run was recorded")
                .remedy("state it under [controller], as law = \"pdf\" or law = \"cascade\""));
        }
        let period = description.sample_period_s;
        if (run.sample_period_s() / period - 1.0).abs() > 1e-6 {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&run.file)
                .key("sample_period_s")
                .found(format!("{} s in the recording and {period} s in the machine", run.sample_period_s()))
                .expected("the controller's sample period in both")
                .remedy("correct sample_period_s of machine.toml, or record at the controller's rate"));
        }
        if run.len() < LEAST_SAMPLES {
            return Err(Error::new(ErrorKind::TooLittleData)
                .file(&run.file)
                .key(run.name())
                .found(format!("{} samples", run.len()))
                .expected(format!("at least {LEAST_SAMPLES}"))
                .remedy("take the run out of the recording, or record a longer one"));
        }
        check_travel(run, machine)?;
        let has_scale = description.load_sensor.is_some();
        let modelled = |signal| signal != Signal::LoadPosition || has_scale;
        let signals =
            COMPARED.into_iter().filter(|&s| run.signal(s).is_some() && modelled(s)).collect();
        Ok(Self { run: run.clone(), recorded: Recorded::of(run)?, signals })
    }

    /// The run.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// The run's commands and start.
    pub fn recorded(&self) -> &Recorded {
        &self.recorded
    }

    /// The signals that are compared, in signal-path order.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.run.len()
    }

    /// The machine as it was set in this run.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn machine(&self, machine: &Machine) -> Result<Machine> {
        if self.run.settings.is_empty() {
            return Ok(machine.clone());
        }
        machine.with_settings(self.run.settings.iter().map(|(key, value)| (key.as_str(), value.clone())))
    }

    /// What the machine's twin predicts for this run, on the axis plant.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn predict(&self, machine: &Machine, sensing: Sensing) -> Result<Traces> {
        let machine = self.machine(machine)?;
        let mut traces = self.recorded.replay(&machine, Axis::of(&machine.constants()), sensing);
        self.share_zero(&machine, &mut traces);
        Ok(traces)
    }

    /// Of two position sensors, the one that does not close the position loop has a zero that means nothing, and where
    /// in its play a drive train stood at the start is not known: its prediction is moved to the recorded mean.
    fn share_zero(&self, machine: &Machine, traces: &mut Traces) {
        let Some(sensor) = &machine.description().load_sensor else { return };
        let [position, load] = [Signal::Position, Signal::LoadPosition].map(|s| self.run.signal(s));
        let (Some(position), Some(load)) = (position, load) else { return };
        let (recorded, predicted) = match sensor.closes_position_loop {
            true => (position, &mut traces.position),
            false => (load, &mut traces.load_position),
        };
        let sum: f64 = recorded.iter().zip(predicted.iter()).map(|(r, p)| r - p).sum();
        let zero = sum / recorded.len() as f64;
        predicted.iter_mut().filter(|_| zero.is_finite()).for_each(|p| *p += zero);
    }
}

/// The predicted signal.
pub fn trace(traces: &Traces, signal: Signal) -> &[f64] {
    match signal {
        Signal::ControlEffort => &traces.effort_v,
        Signal::Current => &traces.current,
        Signal::Thrust => &traces.thrust,
        Signal::Velocity => &traces.velocity,
        Signal::LoadPosition => &traces.load_position,
        _ => &traces.position,
    }
}
