//! Replay of a recorded run: the twin follows the recorded reference from the recorded start.

use super::feedforward::steady_command;
use super::grid::Grid;
use super::start::{ENABLED, START_SAMPLES, Start};
use super::{Feedforward, Traces, run, run_together};
use crate::controller::Input;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::Plant;
use crate::plant::axis::Axis;
use crate::recording::{FEEDFORWARD_KEY, Run, Signal};
use crate::twin::{Command, Driven, Sensing, Twin};
use std::sync::Arc;

/// A vibration has shaken the axis for so long before a run that begins at rest, in s.
const SHAKEN_S: f64 = 1.0;

/// Whether the machine has a vibration that exerts anything.
pub fn shakes(machine: &Machine) -> bool {
    machine.description().effect.external_vibration.as_ref().is_some_and(|law| law.force_n != 0.0)
}

/// A recorded run made ready for replays: its commands and its start.
#[derive(Debug, Clone)]
pub struct Recorded {
    commands: Vec<Command>,
    start: Start,
    /// When the run begins within the session, in s.
    begins_s: f64,
    /// Whether it is the lead of another one: it begins wherever the axis was then.
    is_lead: bool,
    /// The controller's samples, where the log was read at others.
    grid: Option<Arc<Grid>>,
    /// What a replay in closed loop begins with: the samples before a run that was cut out of a longer one.
    lead: Option<Arc<Self>>,
}

impl Recorded {
    /// Commands and start of a run that has a position reference and a position, with the feed-forward that it states;
    /// the machine is as it was set in the run.
    ///
    /// # Errors
    /// A run without position reference or position; a stated feed-forward that cannot be told, see [`Feedforward`].
    pub fn of(run: &Run, machine: &Machine) -> Result<Self> {
        Self::along(run, run.require(Signal::PositionReference)?, machine)
    }

    /// Commands and start of a run along a position reference of its length, logged or not.
    ///
    /// # Errors
    /// A run without position; a stated feed-forward that cannot be told, because it is malformed or because an effort but no
    /// reference was logged.
    pub fn along(run: &Run, reference: &[f64], machine: &Machine) -> Result<Self> {
        let start = Start::of(run, reference, run.require(Signal::Position)?);
        let is_stated = run.metadata.contains_key(FEEDFORWARD_KEY);
        if is_stated && run.signal(Signal::PositionReference).is_none() {
            Feedforward::of(run)?;
            // Current and force are what they are, whatever was fed forward; an effort is not the whole one.
            if run.signal(Signal::ControlEffort).is_some() {
                run.require(Signal::PositionReference)?;
            }
            return Ok(Self::without_feedforward(run, reference, start));
        }
        let recorded = Self::from(run, reference, start, machine)?;
        let lead = run.lead().filter(|lead| lead.signal(Signal::PositionReference).is_some());
        match lead.filter(|_| run.signal(Signal::PositionReference).is_some()) {
            Some(lead) => Ok(recorded.after(Self::of(lead, machine)?, run.sample_period_s())),
            None => Ok(recorded),
        }
    }

    /// The same after the samples of a lead.
    fn after(mut self, lead: Self, period_s: f64) -> Self {
        if let (Some(last), Some(first)) = (lead.commands.last(), self.commands.first_mut()) {
            first.velocity_reference = (first.position_reference - last.position_reference) / period_s;
        }
        self.lead = Some(Arc::new(Self { is_lead: true, ..lead }));
        self
    }

    /// Commands of a run along a position reference of its length, from a start that is known.
    pub(super) fn from(run: &Run, reference: &[f64], start: Start, machine: &Machine) -> Result<Self> {
        let mut recorded = Self::without_feedforward(run, reference, start);
        if let Some(fed_v) = Feedforward::recorded_v(run, &recorded.commands, machine)? {
            recorded.start.feedforward_v = fed_v.first().copied().unwrap_or(0.0);
            for (command, feedforward_v) in recorded.commands.iter_mut().zip(fed_v) {
                command.feedforward_v = feedforward_v;
            }
        }
        Ok(recorded)
    }

    fn without_feedforward(run: &Run, reference: &[f64], start: Start) -> Self {
        let step_s = |k: usize| run.time_s(k) - run.time_s(k - 1);
        let disturbance = run.signal(Signal::DisturbanceVoltage);
        let (supply, enabled) = (run.signal(Signal::SupplyVoltage), run.signal(Signal::TorqueEnabled));
        let commands = (0..reference.len())
            .map(|k| {
                let velocity_reference = match k {
                    // Nothing stands before the first sample: a run that begins at rest begins with none.
                    0 if start.velocity == 0.0 || reference.len() < 2 => 0.0,
                    0 => (reference[1] - reference[0]) / step_s(1),
                    _ => (reference[k] - reference[k - 1]) / step_s(k),
                };
                Command {
                    position_reference: reference[k],
                    velocity_reference,
                    disturbance_v: disturbance.map_or(0.0, |d| d[k]),
                    feedforward_v: 0.0,
                    effort_v: None,
                    supply_v: supply.map(|supply| supply[k]),
                    is_enabled: enabled.is_none_or(|enabled| enabled[k] >= ENABLED),
                    thrust: None,
                    thrust_rise: 0.0,
                }
            })
            .collect();
        Self { commands, start, begins_s: run.begins_s, is_lead: false, grid: None, lead: None }
    }

    /// The same for a controller that samples at `period_s`: a run whose time stamps are uneven is then replayed at the
    /// controller's samples and read at its time stamps. No difference for an evenly sampled run.
    #[must_use]
    pub fn on_controller_clock(mut self, run: &Run, period_s: f64) -> Self {
        self.grid = Grid::of(run, &self.commands, period_s).map(Arc::new);
        // Between the samples of two clocks a lead would end where the run does not begin.
        self.lead = self.lead.filter(|_| self.grid.is_none());
        self
    }

    /// The commands that the controller samples.
    fn sampled(&self) -> &[Command] {
        self.grid.as_ref().map_or(&self.commands, |grid| grid.commands())
    }

    /// What the log holds of a replay.
    fn logged(&self, traces: Traces, sensing: Sensing) -> Traces {
        match &self.grid {
            Some(grid) => grid.read(&traces, sensing),
            None => traces,
        }
    }

    /// The same with the run's efforts, in V, in the place of the controller's: open loop.
    #[must_use]
    pub fn driven_by(mut self, effort_v: &[f64]) -> Self {
        for (command, effort) in self.commands.iter_mut().zip(effort_v) {
            command.effort_v = Some(*effort);
        }
        self.lead = None;
        self
    }

    /// How the run begins.
    pub fn start(&self) -> Start {
        self.start
    }

    /// The commands, one a sample.
    pub fn commands(&self) -> &[Command] {
        &self.commands
    }

    /// Efforts of the run as the amplifier got them: with what was fed forward beside them, in V.
    pub fn commanded_v(&self, effort_v: &[f64]) -> Vec<f64> {
        effort_v.iter().zip(&self.commands).map(|(effort, command)| effort + command.feedforward_v).collect()
    }

    /// Replays the run in closed loop on a plant.
    pub fn replay<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing) -> Traces {
        let mut twin = self.begun().twin(machine, plant, sensing);
        run(&mut twin, self.lead_commands().iter().copied(), |_| ());
        let traces = run(&mut twin, self.sampled().iter().copied(), |_| ());
        self.logged(traces, sensing)
    }

    /// The same for several machines with perfect sensors, on the reduced axis in steps of at most `longest_step_s` and in one pass.
    pub fn replay_together(&self, machines: &[Machine], longest_step_s: f64) -> Vec<Traces> {
        self.replay_first(machines, longest_step_s, usize::MAX)
    }

    /// The same of the first `samples` alone where a replay can be cut off there: samples on a grid of their own are replayed to the end.
    pub fn replay_first(&self, machines: &[Machine], longest_step_s: f64, samples: usize) -> Vec<Traces> {
        let begun = self.begun();
        let axis = |machine: &Machine| Axis::within(&machine.constants(), longest_step_s);
        let twin = |machine: &Machine| begun.twin(machine, axis(machine), Sensing::Perfect);
        let (lead, commands) = (self.lead_commands(), self.sampled());
        let commands = if self.grid.is_some() { commands } else { &commands[..samples.min(commands.len())] };
        let room = || Traces::with_capacity(commands.len());
        let mut traces: Vec<Traces> = machines.iter().map(|_| room()).collect();
        let mut led = vec![0; machines.len()];
        run_together(
            machines.iter().map(twin).collect(),
            Driven::ByControllers,
            lead.len() + commands.len(),
            |_, k| if k < lead.len() { lead[k] } else { commands[k - lead.len()] },
            |_| None,
            |twin, _, sample| {
                if led[twin] < lead.len() {
                    led[twin] += 1;
                } else {
                    traces[twin].push(sample);
                }
            },
        );
        traces.into_iter().map(|traces| self.logged(traces, Sensing::Perfect)).collect()
    }

    /// What a replay in closed loop begins with.
    fn begun(&self) -> &Self {
        self.lead.as_deref().unwrap_or(self)
    }

    /// The commands before the run.
    fn lead_commands(&self) -> &[Command] {
        self.lead.as_ref().map_or(&[], |lead| &lead.commands)
    }

    /// The twin as the run finds it: moved to the start, its controller taken over.
    pub(super) fn twin<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing) -> Twin<P> {
        self.twin_fed(machine, plant, sensing, self.start.feedforward_v)
    }

    /// The same where another voltage is fed forward at first: the controller takes over the rest.
    pub(super) fn twin_fed<P: Plant>(
        &self,
        machine: &Machine,
        plant: P,
        sensing: Sensing,
        feedforward_v: f64,
    ) -> Twin<P> {
        let mut twin = Twin::new(machine, plant, sensing);
        let start = self.start_under_weight(machine);
        let Start { position, velocity, reading, load_position, .. } = start;
        let commanded_v = start.commanded_v();
        let on_load = machine.description().load_sensor.as_ref().is_some_and(|s| s.closes_position_loop);
        let mut seen = reading.unwrap_or((position, velocity));
        twin.start(position, velocity, commanded_v.unwrap_or(0.0));
        if let Some(shown) = load_position {
            twin.set_load_reading(shown);
            seen.0 = if on_load { shown } else { seen.0 };
        }
        if let (Some(commanded_v), Some(first)) = (commanded_v, self.commands.first()) {
            let input = Input {
                position_reference: first.position_reference,
                velocity_reference: first.velocity_reference,
                position: seen.0,
                velocity: seen.1,
            };
            twin.take_over(commanded_v - feedforward_v - first.disturbance_v, input);
        }
        start.initialise(&mut twin, machine, self.begins_s);
        if let Some(command) = self.resting().filter(|_| !self.is_lead && shakes(machine)) {
            // A vibration was there before the run began: base, drive and controller have settled into it. The reference of a lead may rest while the axis
            // comes in.
            twin.set_clock(self.begins_s - SHAKEN_S);
            let periods = (SHAKEN_S / twin.period_s()).round() as usize;
            for _ in 0..periods {
                twin.step(command);
            }
        }
        twin
    }

    /// The first command, where the reference rests at first.
    fn resting(&self) -> Option<Command> {
        let first = *self.commands.first()?;
        let rests = self
            .commands
            .iter()
            .take(START_SAMPLES)
            .all(|c| c.position_reference == first.position_reference);
        rests.then_some(Command { velocity_reference: 0.0, ..first })
    }

    /// The start, with the effort that holds the machine's weight where none was logged and the controller is to have it.
    fn start_under_weight(&self, machine: &Machine) -> Start {
        let is_controlled = self.commands.first().is_some_and(|c| c.effort_v.is_none() && c.thrust.is_none());
        let Some(weight) = machine.weight().filter(|_| is_controlled && self.start.effort_v.is_none()) else {
            return self.start.unscaled(machine.constants().log_scale);
        };
        let constants = machine.constants();
        let start = self.start.unscaled(constants.log_scale);
        let (gain, force) = (constants.amplifier.gain(), -weight.effort(start.position));
        let held_v = steady_command(&constants.circuit, gain, force, start.velocity);
        let live_v = held_v - constants.amplifier.offset_v;
        let commanded_v = live_v + live_v.signum() * constants.amplifier.dead_zone_v;
        Start { effort_v: Some(commanded_v - start.feedforward_v), ..start }
    }
}
