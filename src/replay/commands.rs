//! What an axis is told, sample by sample, and a machine that is told it.

use std::collections::BTreeMap;

use super::compared::{DrivenBy, check, driven_by};
use super::start::ENABLED;
use super::travel::check_travel;
use super::{PlantChoice, Traces, run};
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::{Plant, axis::Axis, mujoco::MujocoRig, rapier::Rig};
use crate::recording::{FEEDFORWARD_KEY, Run, Signal};
use crate::twin::{Command, Sensing, Twin};

/// The axis has stood at the first reference for so long before a simulated run begins, in s: drives and integrators
/// have settled against whatever pushes, as on a real machine.
pub const STOOD_S: f64 = 2.0;

/// Commands of a run: a position reference for the closed loop, or efforts for the open one.
///
/// # Validity
/// In closed loop the axis has stood at the first reference before the first sample. In open loop it is at rest at the
/// first sample, without current and, where the friction has bristles, with these undeflected.
#[derive(Debug, Clone, PartialEq)]
pub struct Commands {
    /// One a sample.
    commands: Vec<Command>,
    /// Where the axis stands before.
    start: f64,
    /// When the run begins within the session, in s.
    begins_s: f64,
    /// What of the commands moves the axis.
    pub driven_by: DrivenBy,
}

impl Commands {
    /// Along a sampled position reference, from where the machine stands at 0.
    ///
    /// # Errors
    /// A machine without a controller, or a reference beyond the joint's limits.
    pub fn follow(machine: &Machine, reference: &[f64]) -> Result<Self> {
        if machine.description().controller.is_none() {
            return Err(machine
                .lacks_controller()
                .remedy("state the control law, or replay recorded efforts instead of strokes"));
        }
        check_travel(machine, reference)?;
        let commands = super::follow(reference, machine.description().sample_period_s).collect();
        Ok(Self { commands, start: 0.0, begins_s: 0.0, driven_by: DrivenBy::Reference })
    }

    /// Those of a run: its position reference where the machine has a controller for it, else its effort. The axis
    /// stands where the reference, or in open loop the position, begins; at 0 where neither is there.
    ///
    /// # Errors
    /// A run with neither; another sample period or kind of motion than the machine's; a reference beyond the joint's
    /// limits; a run that states a feed-forward, which is not played.
    pub fn of(run: &Run, machine: &Machine) -> Result<Self> {
        check(run, machine)?;
        let driven_by = driven_by(run, machine)?;
        if run.metadata.contains_key(FEEDFORWARD_KEY) && driven_by == DrivenBy::Reference {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key(format!("{}.{FEEDFORWARD_KEY}", run.name()))
                .found("a feed-forward")
                .expected("commands that the machine's own controller follows")
                .remedy("take the run out, or its feed-forward"));
        }
        let mut told = match (driven_by, run.signal(Signal::PositionReference)) {
            (DrivenBy::Reference, Some(reference)) => {
                let mut told = Self::follow(machine, reference)?;
                told.start = reference.first().copied().unwrap_or_default();
                told
            }
            _ => Self::efforts(run)?,
        };
        told.begins_s = run.begins_s;
        let (supply, enabled) = (run.signal(Signal::SupplyVoltage), run.signal(Signal::TorqueEnabled));
        for (k, command) in told.commands.iter_mut().enumerate() {
            command.supply_v = supply.map(|supply| supply[k]);
            command.is_enabled = enabled.is_none_or(|enabled| enabled[k] >= ENABLED);
        }
        // An effort that was logged has it in already.
        if let (DrivenBy::Reference, Some(disturbance)) = (driven_by, run.signal(Signal::DisturbanceVoltage))
        {
            for (command, volts) in told.commands.iter_mut().zip(disturbance) {
                command.disturbance_v = *volts;
            }
        }
        Ok(told)
    }

    fn efforts(run: &Run) -> Result<Self> {
        let efforts = run.require(Signal::ControlEffort)?;
        let start = run.signal(Signal::Position).and_then(|position| position.first().copied());
        let start = start.unwrap_or_default();
        let command = |effort: &f64| Command { effort_v: Some(*effort), ..Command::follow(start, 0.0) };
        let commands = efforts.iter().map(command).collect();
        Ok(Self { commands, start, begins_s: run.begins_s, driven_by: DrivenBy::Effort })
    }

    /// The same where the machine stands at the first reference before, instead of at 0.
    #[must_use]
    pub fn from_first(self) -> Self {
        let start = self.commands.first().map_or(self.start, |first| first.position_reference);
        Self { start, ..self }
    }

    /// The same at a time of the session, in s.
    #[must_use]
    pub fn beginning(self, begins_s: f64) -> Self {
        Self { begins_s, ..self }
    }

    /// When the run begins within the session, in s.
    pub fn begins_s(&self) -> f64 {
        self.begins_s
    }

    /// For how long the axis stands before the first sample, of what is asked for, in s: not in open loop.
    pub fn stood_s(&self, asked_s: f64) -> f64 {
        if self.driven_by == DrivenBy::Reference { asked_s } else { 0.0 }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.commands.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.commands.is_empty()
    }

    /// What a logger keeps of the commands beside what it measures.
    pub fn signals(&self, period_s: f64) -> BTreeMap<Signal, Vec<f64>> {
        let of = |f: fn(&Command) -> f64| self.commands.iter().map(f).collect::<Vec<f64>>();
        let mut signals = BTreeMap::new();
        if self.driven_by == DrivenBy::Reference {
            let reference = of(|c| c.position_reference);
            let velocity = super::follow(&reference, period_s).map(|c| c.velocity_reference).collect();
            signals.insert(Signal::VelocityReference, velocity);
            signals.insert(Signal::PositionReference, reference);
            let disturbance = of(|c| c.disturbance_v);
            if disturbance.iter().any(|volts| *volts != 0.0) {
                signals.insert(Signal::DisturbanceVoltage, disturbance);
            }
        }
        signals
    }

    /// Tells them to the machine on a plant; `each` is told after every sample how many are done.
    ///
    /// # Errors
    /// What the scene refuses; a joint with end stops that efforts drive beyond them.
    pub fn simulate(
        &self,
        machine: &Machine,
        plant: PlantChoice,
        sensing: Sensing,
        each: impl FnMut(usize),
    ) -> Result<Traces> {
        let traces = match plant {
            PlantChoice::Rapier => self.walk(machine, Rig::new(machine)?, sensing, STOOD_S, each),
            PlantChoice::Axis => self.walk(machine, Axis::of(&machine.constants()), sensing, STOOD_S, each),
            PlantChoice::Mujoco => self.walk(machine, MujocoRig::new(machine)?, sensing, STOOD_S, each),
        }?;
        traces.check_finite(machine)?;
        Ok(traces)
    }

    /// The same on a plant of the caller's, after so long a standstill in closed loop.
    ///
    /// # Errors
    /// A joint with end stops that efforts drive beyond them.
    pub fn walk<P: Plant>(
        &self,
        machine: &Machine,
        plant: P,
        sensing: Sensing,
        stood_s: f64,
        each: impl FnMut(usize),
    ) -> Result<Traces> {
        let mut twin = Twin::new(machine, plant, sensing);
        twin.start(self.start, 0.0, 0.0);
        twin.set_clock(self.begins_s - self.stood_s(stood_s));
        if self.driven_by == DrivenBy::Reference {
            let first = self.commands.first().map_or(self.start, |c| c.position_reference);
            let periods = (stood_s / machine.description().sample_period_s).round() as usize;
            run(&mut twin, (0..periods).map(|_| Command::follow(first, 0.0)), |_| ());
        }
        let traces = run(&mut twin, self.commands.iter().copied(), each);
        if self.driven_by == DrivenBy::Effort {
            check_travel(machine, &traces.position)?;
        }
        Ok(traces)
    }
}
