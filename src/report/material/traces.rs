//! Every signal of a run: recorded, predicted by the twin as it is, predicted with the causes.

use super::events::{Event, events};
use crate::diagnose::experiment::Experiment;
use crate::diagnose::smooth::smooth;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::LoadModel;
use crate::recording::{FEEDFORWARD_KEY, Role, Run, Signal};
use crate::replay::Traces;
use crate::twin::Sensing;

/// One signal of a run, in SI.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Which.
    pub signal: Signal,
    /// As recorded.
    pub measured: Vec<f64>,
    /// Predicted by the twin as it is; empty where there is no twin.
    pub before: Vec<f64>,
    /// Predicted by the twin with its causes; empty where there is no twin.
    pub after: Vec<f64>,
}

/// One run.
#[derive(Debug, Clone)]
pub struct RunTraces {
    /// Its name.
    pub name: String,
    /// Whether no parameter was fitted to it.
    pub is_held_out: bool,
    /// Its role in words.
    pub role: String,
    /// Time from sample to sample in s.
    pub period_s: f64,
    /// The position reference, logged or read off the motion; may be empty.
    pub reference: Vec<f64>,
    /// The signals, in signal-path order.
    pub traces: Vec<Trace>,
    /// Whether the effort is only what a feed-forward left to the feedback.
    pub is_fed_forward: bool,
    /// What the axis was told to do, and when.
    pub events: Vec<Event>,
    /// Loads of sliders A–D in N, where the machine has four.
    pub loads: Vec<[f64; 4]>,
}

/// Half width of the window in which an acceleration is read, in s.
const HALF_WIDTH_S: f64 = 6e-3;

impl RunTraces {
    /// Replays a run with the twin as it is and with its causes.
    ///
    /// # Errors
    /// What a replay refuses.
    pub fn of(experiment: &Experiment, is_held_out: bool, [stated, improved]: [&Machine; 2]) -> Result<Self> {
        let before = experiment.predict(stated, Sensing::Perfect)?;
        let after = experiment.predict(improved, Sensing::Perfect)?;
        let run = experiment.run();
        let traces = experiment.signals().iter().filter_map(|&signal| {
            Some(Trace {
                signal,
                measured: run.signal(signal)?.to_vec(),
                before: before.signal(signal)?.to_vec(),
                after: after.signal(signal)?.to_vec(),
            })
        });
        let reference: Vec<f64> =
            experiment.recorded().commands().iter().map(|command| command.position_reference).collect();
        Ok(Self {
            name: run.name().to_owned(),
            is_held_out,
            role: if is_held_out { "held out" } else { "training" }.to_owned(),
            period_s: run.sample_period_s(),
            events: events(&reference, run.sample_period_s()),
            traces: traces.collect(),
            is_fed_forward: run.metadata.contains_key(FEEDFORWARD_KEY),
            loads: loads(&experiment.machine(improved)?, &after, run.sample_period_s()),
            reference,
        })
    }

    /// A run as recorded, without a twin.
    pub fn recorded(run: &Run, machine: Option<&Machine>) -> Self {
        let reference = run.signal(Signal::PositionReference).unwrap_or_default().to_vec();
        let shown = |signal: &Signal| *signal != Signal::PositionReference;
        let traces = Signal::ALL.into_iter().filter(shown).filter_map(|signal| {
            let measured = run.signal(signal)?.to_vec();
            Some(Trace { signal, measured, before: Vec::new(), after: Vec::new() })
        });
        let role = match run.role {
            Some(Role::HeldOut) => "held out",
            Some(Role::Training) => "training",
            None => "",
        };
        let thrust = run.signal(Signal::Thrust).zip(run.signal(Signal::Position));
        let loads = machine.zip(thrust).map(|(machine, (thrust, position))| {
            let traces = Traces { thrust: thrust.to_vec(), position: position.to_vec(), ..Traces::default() };
            loads(machine, &traces, run.sample_period_s())
        });
        Self {
            name: run.name().to_owned(),
            is_held_out: run.role == Some(Role::HeldOut),
            role: role.to_owned(),
            period_s: run.sample_period_s(),
            events: events(&reference, run.sample_period_s()),
            traces: traces.collect(),
            is_fed_forward: run.metadata.contains_key(FEEDFORWARD_KEY),
            loads: loads.unwrap_or_default(),
            reference,
        }
    }

    /// A signal of the run.
    pub fn trace(&self, signal: Signal) -> Option<&Trace> {
        self.traces.iter().find(|trace| trace.signal == signal)
    }

    /// Time of a sample in s.
    pub fn time_s(&self, sample: usize) -> f64 {
        sample as f64 * self.period_s
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.traces.first().map_or(self.reference.len(), |trace| trace.measured.len())
    }
}

/// Loads of four sliders along a run: weight, and the couples of motor force and of what resists it.
fn loads(machine: &Machine, traces: &Traces, period_s: f64) -> Vec<[f64; 4]> {
    let Some(model) = LoadModel::of(machine) else { return Vec::new() };
    let half = ((HALF_WIDTH_S / period_s).round() as usize).max(3);
    let [.., acceleration] = smooth(&traces.position, half, period_s);
    let (mass, weight) = (machine.constants().moving_mass, machine.weight());
    let guide = |k: usize| {
        let weight = weight.map_or(0.0, |weight| weight.effort(traces.position[k]));
        mass * acceleration[k] - traces.thrust[k] - weight
    };
    (0..traces.thrust.len()).map(|k| model.loads([traces.thrust[k], guide(k)])).collect()
}
