//! The runs of a diagnosis, ready to be replayed and compared.

use super::beginnings::{Beginnings, has_own_beginnings};
use super::run_setting::RunSettings;
use super::{measured, phase, play};
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::axis::{Axis, LANES, LONGEST_STEP_S};
use crate::recording::{HeldOutRuns, Run, Signal, TrainingRuns};
use crate::replay::recorded::shakes;
use crate::replay::windows::{Input, Windowed};
use crate::replay::{Recorded, Traces};
use crate::twin::Sensing;
use rayon::prelude::*;

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
    mode: Mode,
    /// Of two position sensors, the one whose zero is its own.
    second_sensor: Option<Signal>,
    settings: RunSettings,
    beginnings: Beginnings,
}

/// Runs that fits see.
pub type Training = TrainingRuns<Experiment>;

/// Runs that only judge.
pub type HeldOut = HeldOutRuns<Experiment>;

/// How a run is replayed.
#[derive(Debug, Clone)]
enum Mode {
    /// From the reference, the loop closed by the controller.
    ClosedLoop,
    /// From a measured signal, in windows that begin in the measured state.
    Windows(Box<Windowed>),
}

/// The signal that drives a run whose loop cannot be closed.
fn input(run: &Run, machine: &Machine) -> Result<Input> {
    let has_current = machine.description().motor.has_current();
    let there = |input: &Input| run.signal(input.signal()).is_some();
    let inputs = [Input::Effort, Input::Thrust, Input::Current];
    let usable = inputs.into_iter().find(|i| there(i) && (has_current || *i != Input::Current));
    usable.ok_or_else(|| {
        let logged: Vec<_> = run.signals().keys().map(|signal| signal.key(run.motion())).collect();
        let stated = machine.description().controller.is_some();
        let (key, loop_state) = if stated {
            (Signal::PositionReference.key(run.motion()), "a stated controller")
        } else {
            ("controller", "no stated controller")
        };
        let force = Signal::Thrust.key(run.motion());
        Error::new(ErrorKind::Missing)
            .file(if run.file.as_os_str().is_empty() { machine.file() } else { &run.file })
            .key(key)
            .found(format!("run `{}` with {} and {loop_state}", run.name(), logged.join(", ")))
            .expected("what moved the axis: a stated controller and its position reference, or a measured effort")
            .remedy(format!(
                "log control_effort_v, {force} or, for a winding, current_a; or state [controller] and log the position reference"
            ))
    })
}

impl Experiment {
    /// Makes a run ready.
    ///
    /// # Errors
    /// A run without position, a run too short to tell anything, positions that the joint cannot reach, a sample
    /// period that is not the machine's; a run that tells neither what its controller was told (or whose controller
    /// is not stated) nor voltage, current or force of the motor.
    pub fn new(run: &Run, machine: &Machine) -> Result<Self> {
        let description = machine.description();
        let period = description.sample_period_s;
        if run.instants_s().is_none() && (run.sample_period_s() / period - 1.0).abs() > 1e-6 {
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
        // Windows need the controller's clock: what drives them is known between two time stamps by interpolation only.
        let resampled;
        let run = if run.instants_s().is_some() && !closes_loop(run, machine) {
            resampled = run.resampled(period)?;
            &resampled
        } else {
            run
        };
        let settings = RunSettings::of(run, machine);
        let (recorded, mode) = replayed(run, machine, &settings.machine(machine)?)?;
        let compared = |signal: &Signal| match &mode {
            Mode::ClosedLoop => true,
            Mode::Windows(windowed) => follows(*signal, windowed.input()),
        };
        let signals = COMPARED
            .into_iter()
            .filter(|s| run.signal(*s).is_some() && modelled(*s) && compared(s))
            .collect();
        let second_sensor = second_sensor(run, machine).filter(|_| matches!(mode, Mode::ClosedLoop));
        let beginnings = Beginnings::default();
        Ok(Self { run: run.clone(), recorded, signals, mode, second_sensor, settings, beginnings })
    }

    /// The signal that drives the replay; none where it follows the reference in closed loop.
    pub fn input(&self) -> Option<Input> {
        match &self.mode {
            Mode::ClosedLoop => None,
            Mode::Windows(windowed) => Some(windowed.input()),
        }
    }

    /// The run as the machine's twin would have logged it, noise included, without setting it anew to measured states.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn imagined(&self, machine: &Machine, seed: u64) -> Result<Self> {
        let set = self.machine(machine)?;
        let (axis, sensing) = (Axis::of(&set.constants()), Sensing::AsStated { seed });
        let traces = match &self.mode {
            Mode::ClosedLoop => self.recorded.replay(&set, axis, sensing),
            Mode::Windows(windowed) => windowed.free_run(&set, axis, sensing),
        };
        self.logging(&traces)
    }

    /// The same run with other samples of the signals that are compared.
    fn logging(&self, traces: &Traces) -> Result<Self> {
        let mut signals = self.run.signals().clone();
        for (signal, samples) in &mut signals {
            if let Some(trace) = traces.signal(*signal).filter(|_| self.signals.contains(signal)) {
                trace.clone_into(samples);
            }
        }
        let run = self.run.with_signals(signals)?;
        Ok(Self { run, ..self.clone() })
    }

    /// The same run with the start, and the states in which its windows begin, read off its samples again. That of a run which was cut out of a
    /// longer one stays: the samples before the cut tell it.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn begun_as_read(&self, machine: &Machine) -> Result<Self> {
        if self.run.entry().is_some() {
            return Ok(self.clone());
        }
        let (recorded, mode) = replayed(&self.run, machine, &self.settings.machine(machine)?)?;
        Ok(Self { recorded, mode, ..self.clone() })
    }

    /// What the machine's twin predicts of the run, had it been logged with these samples, from the start that they show; none where more than the
    /// samples of the run tells the start, or windows begin anew.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn foreseen(&self, machine: &Machine, logged: &Traces) -> Result<Option<Traces>> {
        if self.run.entry().is_some() || matches!(self.mode, Mode::Windows(_)) {
            return Ok(None);
        }
        self.logging(logged)?.begun_as_read(machine)?.predict(machine, Sensing::Perfect).map(Some)
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

    /// The machine, stated or fitted, as it was set in this run: known numbers of effects on top of fitted ones, and a
    /// vibration with the phase that suits the run.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn machine(&self, machine: &Machine) -> Result<Machine> {
        Ok(self.machines(std::slice::from_ref(machine), LONGEST_STEP_S)?.remove(0))
    }

    fn machines(&self, machines: &[Machine], longest_step_s: f64) -> Result<Vec<Machine>> {
        let set: Vec<Machine> = machines.iter().map(|m| self.settings.machine(m)).collect::<Result<_>>()?;
        if !set.iter().any(has_own_beginnings) {
            return Ok(set);
        }
        let replay = |machines: &[Machine], samples: usize| {
            let pass = |pass: &[Machine]| self.replay_first(pass, longest_step_s, samples);
            machines.par_chunks(LANES).flat_map_iter(pass).collect()
        };
        let whole = |machines: &[Machine]| self.replay_together(machines, longest_step_s);
        self.beginnings.of(set, longest_step_s, |set| {
            let set = play::suited(&self.run, &self.signals, set, replay)?;
            phase::suited(&self.run, &self.signals, set, whole)
        })
    }

    /// Replays of machines as they were set in this run, passes side by side. Which machines share a pass does not depend on the number of threads.
    fn replay_together(&self, machines: &[Machine], longest_step_s: f64) -> Vec<Traces> {
        let pass = |pass: &[Machine]| self.replay_first(pass, longest_step_s, self.samples());
        machines.par_chunks(LANES).flat_map_iter(pass).collect()
    }

    /// Replays of machines in one pass, in closed loop of the first `samples` of the run.
    fn replay_first(&self, machines: &[Machine], longest_step_s: f64, samples: usize) -> Vec<Traces> {
        match &self.mode {
            Mode::ClosedLoop => {
                let mut all = self.recorded.replay_first(machines, longest_step_s, samples);
                // Of a part that is its end: where the axis begins in its play goes into the mean of a short part.
                let is_whole = |traces: &Traces| traces.position.len() >= self.samples();
                let from =
                    |traces: &Traces| if is_whole(traces) { 0 } else { play::last_quarter(samples).start };
                all.iter_mut().for_each(|traces| self.share_zero(traces, from(traces)));
                all
            }
            Mode::Windows(windowed) => windowed.replay_together(machines, longest_step_s),
        }
    }

    /// What the machine's twin predicts for this run, on the axis plant.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub fn predict(&self, machine: &Machine, sensing: Sensing) -> Result<Traces> {
        let machine = self.machine(machine)?;
        let axis = Axis::of(&machine.constants());
        Ok(match &self.mode {
            Mode::ClosedLoop => {
                let mut traces = self.recorded.replay(&machine, axis, sensing);
                self.share_zero(&mut traces, 0);
                traces
            }
            Mode::Windows(windowed) => windowed.replay(&machine, axis, sensing),
        })
    }

    /// The same for several machines in one pass, sensors perfect, in steps of the plant of at most `longest_step_s`.
    ///
    /// # Errors
    /// A setting of the run that one of the machines does not have.
    pub fn predict_together(&self, machines: &[Machine], longest_step_s: f64) -> Result<Vec<Traces>> {
        Ok(self.replay_together(&self.machines(machines, longest_step_s)?, longest_step_s))
    }

    /// Replays near a machine with a vibration or a play in one pass, sensors perfect: each machine with the phase, or the beginning in the play,
    /// that suits `near`, advanced by so many rad, or by such a share, where the run does not state it.
    ///
    /// # Errors
    /// A setting of the run that one of the machines does not have.
    pub fn predict_near(
        &self,
        near: &Machine,
        machines: &[(&Machine, f64)],
        longest_step_s: f64,
    ) -> Result<Vec<Traces>> {
        let near = self.machines(std::slice::from_ref(near), longest_step_s)?.remove(0);
        // Of a machine that has both the phase is advanced.
        let by_phase = shakes(&near);
        let set = |(machine, advance): &(&Machine, f64)| {
            let [phase, share] = if by_phase { [*advance, 0.0] } else { [0.0, *advance] };
            let machine = self.settings.machine(machine)?;
            let begun = play::advanced(&self.run, &near, machine, share)?;
            phase::advanced(&self.run, &near, begun, phase)
        };
        let machines: Result<Vec<Machine>> = machines.iter().map(set).collect();
        Ok(self.replay_together(&machines?, longest_step_s))
    }

    /// Of two position sensors in a closed loop, the one that does not close the position loop. Its mean over a run means
    /// nothing: its zero is its own, and where in its play a drive train stood at the start is not known.
    pub fn second_sensor(&self) -> Option<Signal> {
        self.second_sensor
    }

    /// Moves the prediction of the second sensor to the recorded mean from this sample on.
    fn share_zero(&self, traces: &mut Traces, from: usize) {
        let Some(signal) = self.second_sensor else { return };
        let Some(recorded) = self.run.signal(signal) else { return };
        let predicted = match signal {
            Signal::LoadPosition => &mut traces.load_position,
            _ => &mut traces.position,
        };
        let pairs = recorded.iter().zip(predicted.iter()).skip(from);
        let sum: f64 = pairs.clone().map(|(r, p)| r - p).sum();
        let zero = sum / pairs.len() as f64;
        predicted.iter_mut().filter(|_| zero.is_finite()).for_each(|p| *p += zero);
    }
}

/// Of two position sensors that were both logged, the one that does not close the position loop.
fn second_sensor(run: &Run, machine: &Machine) -> Option<Signal> {
    let sensor = machine.description().load_sensor.as_ref()?;
    let both = [Signal::Position, Signal::LoadPosition].iter().all(|s| run.signal(*s).is_some());
    both.then_some(if sensor.closes_position_loop { Signal::Position } else { Signal::LoadPosition })
}

/// Whether the replay can follow the reference in closed loop.
fn closes_loop(run: &Run, machine: &Machine) -> bool {
    run.signal(Signal::PositionReference).is_some() && machine.description().controller.is_some()
}

/// Commands, start and mode of a run on a machine, as stated and as set in the run.
fn replayed(run: &Run, machine: &Machine, set: &Machine) -> Result<(Recorded, Mode)> {
    let reference = run.signal(Signal::PositionReference);
    if closes_loop(run, machine) {
        let period_s = machine.description().sample_period_s;
        return Ok((Recorded::of(run, set)?.on_controller_clock(run, period_s), Mode::ClosedLoop));
    }
    let (position, period) = (run.require(Signal::Position)?, run.sample_period_s());
    let input = input(run, machine)?;
    let recorded = match reference {
        Some(reference) => Recorded::along(run, reference, set)?,
        None => Recorded::along(run, &measured::reference(position, period), set)?,
    };
    let mut restarts = measured::restarts(position, input, period);
    let start = recorded.start();
    if let (Some(first), true) = (restarts.first_mut(), start.velocity == 0.0) {
        // A run that begins at rest: its mean tells the place better than its first parabola.
        (first.position, first.velocity) = (start.position, 0.0);
    }
    let windowed = Windowed::new(run, input, start, restarts, measured::half_width(period))?;
    let windowed = windowed.fed_forward(recorded.commands());
    Ok((recorded, Mode::Windows(Box::new(windowed))))
}

/// Whether a signal follows from a replay's input.
fn follows(signal: Signal, input: Input) -> bool {
    match signal {
        Signal::Position | Signal::Velocity | Signal::LoadPosition => true,
        Signal::Current => input != Input::Current,
        Signal::Thrust => input == Input::Effort,
        _ => false,
    }
}
