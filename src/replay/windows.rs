//! Open-loop replay in windows: the twin is driven with what was measured and set anew, from time to time, to the
//! measured state.

mod drive;

use super::start::{ENABLED, Start};
use super::{Traces, run_together};
use crate::effect::Door;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::Plant;
use crate::plant::axis::Axis;
use crate::recording::{Run, Signal};
use crate::sensor::End;
use crate::twin::{Command, Driven, Sample, Sensing, Twin, load_positions};
use drive::Drive;
use std::ops::Range;

/// The measured signal that drives the replay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// Voltage commanded to the amplifier.
    Effort,
    /// Current of the motor's winding.
    Current,
    /// Force or torque of the motor.
    Thrust,
}

impl Input {
    /// The signal.
    pub fn signal(self) -> Signal {
        match self {
            Self::Effort => Signal::ControlEffort,
            Self::Current => Signal::Current,
            Self::Thrust => Signal::Thrust,
        }
    }
}

/// A measured state at which a window begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Restart {
    /// First sample of the window.
    pub sample: usize,
    /// Position there, m or rad.
    pub position: f64,
    /// Velocity there, m/s or rad/s.
    pub velocity: f64,
}

/// A recorded run, driven with one of its signals in windows.
///
/// # Model
/// At the beginning of each window position and velocity of the moving part are set to the measured ones; base,
/// current, voltages under way and friction go on as they are. The measured state is uncertain and an open loop does
/// not forget it, so the initial state is no part of what is compared: each window's prediction is moved by
/// `δx + δv·s(t)`, with s(t) the twin's own response to a change of the initial velocity and δx, δv from least squares
/// against the measured position. δv is held towards zero by the information that the measured velocity rests on,
/// which decides only where the response has died out (an axis held by friction).
///
/// Behind a winding, a measured current or thrust moves between two samples as it does under a constant voltage, and
/// its mean over the period drives the twin; behind a motor without a winding it is held.
#[derive(Debug, Clone)]
pub struct Windowed {
    run: Run,
    input: Input,
    start: Start,
    restarts: Vec<Restart>,
    /// Change of the initial velocities from which the response is taken.
    nudge: f64,
    /// Σ t² of the samples that a measured velocity rests on, in s².
    known_s2: f64,
    /// What was fed forward beside the effort, in V.
    feedforward_v: Vec<f64>,
}

impl Windowed {
    /// A run with the states at which its windows begin, the first at its first sample; each velocity is the slope
    /// over `2·half_width + 1` positions.
    ///
    /// # Errors
    /// A run without position or without the input.
    pub fn new(
        run: &Run,
        input: Input,
        start: Start,
        restarts: Vec<Restart>,
        half_width: usize,
    ) -> Result<Self> {
        run.require(Signal::Position)?;
        run.require(input.signal())?;
        let fastest = restarts.iter().fold(0.0, |most: f64, r| most.max(r.velocity.abs()));
        let period = run.sample_period_s();
        let known_s2 = 2.0 * (1..=half_width).map(|j| (j as f64 * period).powi(2)).sum::<f64>();
        let nudge = if fastest > 0.0 { NUDGE * fastest } else { LEAST_NUDGE };
        Ok(Self { run: run.clone(), input, start, restarts, nudge, known_s2, feedforward_v: Vec::new() })
    }

    /// The same with voltages that came beside a recorded effort, a number a sample.
    #[must_use]
    pub fn fed_forward(mut self, commands: &[Command]) -> Self {
        self.feedforward_v = commands.iter().map(|command| command.feedforward_v).collect();
        self
    }

    /// The signal that drives the replay.
    pub fn input(&self) -> Input {
        self.input
    }

    /// The windows, as ranges of samples.
    pub fn windows(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let ends = self.restarts.iter().skip(1).map(|r| r.sample).chain([self.run.len()]);
        self.restarts.iter().zip(ends).map(|(r, end)| r.sample..end)
    }

    /// What the machine's twin predicts, each window from the initial state that suits it best.
    pub fn replay<P: Plant + Clone>(&self, machine: &Machine, plant: P, sensing: Sensing) -> Traces {
        let drive = Drive::of(self, machine, sensing);
        let plain = self.walk(machine, plant.clone(), Sensing::Perfect, &drive, Some(0.0));
        let nudged = self.walk(machine, plant.clone(), Sensing::Perfect, &drive, Some(self.nudge));
        let (response, clean) = self.settled(machine, &plain, &nudged);
        let mut traces = match sensing {
            Sensing::Perfect => clean,
            noisy @ Sensing::AsStated { .. } => {
                let mut traces = self.walk(machine, plant, noisy, &drive, Some(0.0)).traces;
                let pairs = traces.load_position.iter().zip(&plain.traces.load_position);
                let noise: Vec<f64> = pairs.map(|(noisy, plain)| noisy - plain).collect();
                self.settle(&response, &mut traces);
                let load = clean.load_position.iter().zip(noise);
                traces.load_position = load.map(|(clean, noise)| clean + noise).collect();
                traces
            }
        };
        drive.complete(&mut traces, self.input);
        self.settle_load(&mut traces);
        traces
    }

    /// Samples at which the drive is not enabled; empty where that was not recorded.
    fn disabled(&self) -> Vec<bool> {
        let enabled = self.run.signal(Signal::TorqueEnabled).unwrap_or_default();
        enabled.iter().map(|enabled| *enabled < ENABLED).collect()
    }

    /// The same for several machines with perfect sensors, on the reduced axis in steps of at most `longest_step_s` and in one pass.
    pub fn replay_together(&self, machines: &[Machine], longest_step_s: f64) -> Vec<Traces> {
        let axis = |machine: &Machine| Axis::within(&machine.constants(), longest_step_s);
        let drives: Vec<Drive> = machines.iter().map(|m| Drive::of(self, m, Sensing::Perfect)).collect();
        let begun = |faster: f64| {
            let twin = |m| self.twin(m, axis(m), Sensing::Perfect, faster);
            self.walk_together(machines.iter().map(twin).collect(), &drives, faster)
        };
        let (plain, nudged) = (begun(0.0), begun(self.nudge));
        let walks = plain.iter().zip(&nudged).zip(machines.iter().zip(&drives));
        walks
            .map(|((plain, nudged), (machine, drive))| {
                let (_, mut traces) = self.settled(machine, plain, nudged);
                drive.complete(&mut traces, self.input);
                self.settle_load(&mut traces);
                traces
            })
            .collect()
    }

    /// The twins' response to a change of the initial velocities, and what they predict from those that suit best.
    fn settled(&self, machine: &Machine, plain: &Walk, nudged: &Walk) -> (Response, Traces) {
        let response = Response::between(plain, nudged, self.nudge);
        let mut clean = plain.traces.clone();
        self.settle(&response, &mut clean);
        if let Some(load) = self.load(machine, &clean.position) {
            clean.load_position = load;
        }
        (response, clean)
    }

    fn settle(&self, response: &Response, traces: &mut Traces) {
        let measured = self.run.signal(Signal::Position).unwrap_or_default();
        for window in self.windows() {
            response.settle(traces, measured, window, self.known_s2);
        }
    }

    /// Positions of the load behind a drive train whose motor moves as settled: a play remembers where the motor turned,
    /// which a window that begins a little off does not tell. None where nothing stands between the sensors.
    fn load(&self, machine: &Machine, motor: &[f64]) -> Option<Vec<f64>> {
        let between = machine.description().encoder.end == End::Motor
            && self.run.signal(Signal::LoadPosition).is_some()
            && machine.effects().iter().any(|effect| effect.acts_through(Door::Transmission));
        between.then(|| load_positions(machine, motor))
    }

    /// What the twin does under the measured input when it is left alone after the run's start.
    pub fn free_run<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing) -> Traces {
        let drive = Drive::of(self, machine, sensing);
        let mut traces = self.walk(machine, plant, sensing, &drive, None).traces;
        drive.complete(&mut traces, self.input);
        traces
    }

    /// Walks through the run; `faster` is added to the velocity with which each window begins, none leaves the
    /// windows out.
    fn walk<P: Plant>(
        &self,
        machine: &Machine,
        plant: P,
        sensing: Sensing,
        drive: &Drive,
        faster: Option<f64>,
    ) -> Walk {
        let mut twin = self.twin(machine, plant, sensing, faster.unwrap_or(0.0));
        let mut walk = Walk::with_capacity(self.run.len());
        let mut restarts = self.restarts.iter().skip(1).peekable();
        for k in 0..self.run.len() {
            if let (Some(faster), Some(restart)) = (faster, restarts.next_if(|r| r.sample == k)) {
                twin.restart(restart.position, restart.velocity + faster);
            }
            let state = twin.state();
            walk.push(state, twin.step(drive.command(k, self.input)));
        }
        walk
    }

    /// Walks of several twins, each window begun faster by so much.
    fn walk_together(&self, twins: Vec<Twin<Axis>>, drives: &[Drive], faster: f64) -> Vec<Walk> {
        let mut walks: Vec<Walk> = twins.iter().map(|_| Walk::with_capacity(self.run.len())).collect();
        let later = &self.restarts[1.min(self.restarts.len())..];
        let restart = |k: usize| {
            let found = later.binary_search_by_key(&k, |restart| restart.sample).ok()?;
            Some([later[found].position, later[found].velocity + faster])
        };
        run_together(
            twins,
            if self.input == Input::Effort { Driven::ByEffort } else { Driven::ByForce },
            self.run.len(),
            |twin, k| drives[twin].command(k, self.input),
            restart,
            |twin, state, sample| walks[twin].push(state, sample),
        );
        walks
    }

    /// The machine's twin at the start of the run, faster by so much.
    fn twin<P: Plant>(&self, machine: &Machine, plant: P, sensing: Sensing, faster: f64) -> Twin<P> {
        let mut twin = Twin::new(machine, plant, sensing);
        let constants = machine.constants();
        let (first, start) = (self.restarts.first(), self.start.unscaled(constants.log_scale));
        let (position, velocity) =
            first.map_or((start.position, start.velocity), |r| (r.position, r.velocity));
        // The bristles are where the measured state left them, whatever is added to its velocity.
        twin.start(position, velocity, start.commanded_v().unwrap_or(0.0));
        if let Some(shown) = start.load_position {
            twin.set_load_reading(shown);
        }
        start.initialise(&mut twin, machine, self.run.begins_s);
        if faster != 0.0 {
            twin.restart(position, velocity + faster);
        }
        twin
    }

    /// The zero of the second sensor is its own: the mean difference over the run means nothing.
    fn settle_load(&self, traces: &mut Traces) {
        let Some(measured) = self.run.signal(Signal::LoadPosition) else { return };
        let residual: f64 = measured.iter().zip(&traces.load_position).map(|(m, p)| m - p).sum();
        let zero = residual / measured.len() as f64;
        traces.load_position.iter_mut().for_each(|load| *load += zero);
    }
}

/// Change of the initial velocity from which the response is taken, as a share of the fastest beginning: small beside
/// what friction reacts to, large beside rounding.
const NUDGE: f64 = 1e-4;
/// The same in m/s or rad/s where every window begins at rest.
const LEAST_NUDGE: f64 = 1e-6;

/// One walk: what the sensors show, and where the plant is.
struct Walk {
    traces: Traces,
    position: Vec<f64>,
    velocity: Vec<f64>,
}

impl Walk {
    fn with_capacity(samples: usize) -> Self {
        let room = || Vec::with_capacity(samples);
        Self { traces: Traces::with_capacity(samples), position: room(), velocity: room() }
    }

    fn push(&mut self, [position, velocity]: [f64; 2], sample: Sample) {
        self.position.push(position);
        self.velocity.push(velocity);
        self.traces.push(sample);
    }
}

/// Response of every trace to a change of the velocity with which a window begins, per unit of that change.
struct Response {
    position: Vec<f64>,
    velocity: Vec<f64>,
    current: Vec<f64>,
    thrust: Vec<f64>,
}

impl Response {
    fn between(plain: &Walk, nudged: &Walk, nudge: f64) -> Self {
        let per_unit = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (b - a) / nudge).collect();
        // Of positions and velocities those of the plant: readings may be rounded to steps beyond the nudge.
        Self {
            position: per_unit(&plain.position, &nudged.position),
            velocity: per_unit(&plain.velocity, &nudged.velocity),
            current: per_unit(&plain.traces.current, &nudged.traces.current),
            thrust: per_unit(&plain.traces.thrust, &nudged.traces.thrust),
        }
    }

    /// Moves a window's traces to the initial state that suits the measured position best.
    fn settle(&self, traces: &mut Traces, measured: &[f64], window: Range<usize>, known_s2: f64) {
        let count = window.len() as f64;
        let residual = |k: usize| measured[k] - traces.position[k];
        let mean_residual = window.clone().map(residual).sum::<f64>() / count;
        let mean_response = self.position[window.clone()].iter().sum::<f64>() / count;
        let (mut cross, mut spread) = (0.0, known_s2);
        for k in window.clone() {
            let away = self.position[k] - mean_response;
            cross += away * (residual(k) - mean_residual);
            spread += away * away;
        }
        let faster = cross / spread;
        let further = mean_residual - faster * mean_response;
        for k in window {
            traces.position[k] += further + faster * self.position[k];
            traces.load_position[k] += further + faster * self.position[k];
            traces.velocity[k] += faster * self.velocity[k];
            traces.current[k] += faster * self.current[k];
            traces.thrust[k] += faster * self.thrust[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_window_is_moved_onto_the_measured_line() {
        let time: Vec<f64> = (0..100).map(|k| f64::from(k) * 1e-3).collect();
        let measured: Vec<f64> = time.iter().map(|t| 0.2 + 0.03 * t).collect();
        let mut traces = Traces::default();
        for _ in &time {
            traces.push(Sample::default());
        }
        let ones = vec![1.0; time.len()];
        let zeros = vec![0.0; time.len()];
        let response =
            Response { position: time.clone(), velocity: ones, current: zeros.clone(), thrust: zeros };
        response.settle(&mut traces, &measured, 0..100, 0.0);
        for (k, x) in measured.iter().enumerate() {
            assert!((traces.position[k] - x).abs() < 1e-12 && (traces.velocity[k] - 0.03).abs() < 1e-12);
        }
    }

    /// A response that has died out leaves the initial velocity to what was measured.
    #[test]
    fn exact_a_window_without_response_is_only_shifted() {
        let mut traces = Traces::default();
        for _ in 0..50 {
            traces.push(Sample::default());
        }
        let zeros = vec![0.0; 50];
        let response = Response {
            position: zeros.clone(),
            velocity: zeros.clone(),
            current: zeros.clone(),
            thrust: zeros,
        };
        let measured: Vec<f64> = (0..50).map(f64::from).collect();
        response.settle(&mut traces, &measured, 0..50, 1e-4);
        assert!(traces.position.iter().all(|x| (x - 24.5).abs() < 1e-12));
        assert!(traces.velocity.iter().all(|v| *v == 0.0));
    }
}
