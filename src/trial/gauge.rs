//! What hidden effects make on the runs of a case, in standard deviations of the noise.

use super::engine::sketch;
use super::laws::Otherwise;
use super::runs::{TrialRun, shared_out};
use crate::diagnose::evidence::residuals;
use crate::diagnose::experiment::Experiment;
use crate::diagnose::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::replay::Traces;
use crate::replay::recording::recorded;
use nalgebra::DVector;
use rayon::prelude::*;
use std::ops::Range;

/// Measures changes of a machine on the runs of a case.
///
/// # Model
/// The case's machine and a changed one are replayed with perfect sensors on the reduced axis, with the laws of forged machines around
/// it. Their difference, signal by signal and sample by sample over the standard deviation of the noise, is the change. The noise is what
/// the sensors are stated to have, carried through the loop.
///
/// What is foreign to every law acts on the case's machine only: what it makes is the change to the same machine.
pub struct Gauge<'a> {
    /// What replays do otherwise: nothing that is foreign to every law.
    otherwise: Otherwise,
    runs: &'a [TrialRun],
    /// Training and held-out runs, as a diagnosis shares them out, by their places; a single run by itself.
    roles: Vec<Vec<usize>>,
    experiments: Vec<Experiment>,
    floor: Floor,
    parts: Vec<Part>,
}

/// The samples of one signal of one run within a change.
struct Part {
    run: usize,
    /// Place of the channel among those of its run.
    channel: usize,
    range: Range<usize>,
}

/// A change beyond this, RMS in standard deviations of the noise, is a machine that does not work.
const BROKEN: f64 = 1e5;

impl<'a> Gauge<'a> {
    /// The gauge of a machine on its runs; `quiet` is the machine without anything hidden, by whose standstill noise is judged.
    ///
    /// # Errors
    /// Whatever a replay refuses: the machine does not work on these runs.
    pub fn new(
        [real, quiet]: [&Machine; 2],
        otherwise: &Otherwise,
        runs: &'a [TrialRun],
        logged: &[Signal],
    ) -> Result<Self> {
        let plain = Otherwise { foreign: None, ..otherwise.clone() };
        let of = |machine: &Machine, otherwise: &Otherwise| -> Result<Vec<Experiment>> {
            let one = |run: &TrialRun| {
                let reference = run.reference(machine);
                let traces = sketch(machine, otherwise, &reference, run.begins_s)?;
                let run = otherwise.logged(as_logged(run, machine, &reference, traces, logged)?, machine)?;
                Experiment::new(&run, machine)
            };
            runs.iter().map(one).collect()
        };
        let floor = Floor::estimate(quiet, &of(quiet, &plain)?.iter().collect::<Vec<_>>())?;
        let experiments = of(real, otherwise)?;
        let groups =
            shared_out(runs, experiments.iter().map(|experiment| experiment.run().clone()).collect())?;
        let place = |run: &&TrialRun| runs.iter().position(|one| std::ptr::eq(one, *run));
        let roles = groups.iter().map(|group| group.iter().filter_map(place).collect()).collect();
        let mut gauge = Self { otherwise: plain, runs, roles, experiments, floor, parts: Vec::new() };
        gauge.parts = gauge.parts(real)?;
        Ok(gauge)
    }

    /// Where each run's channels lie within a change.
    fn parts(&self, real: &Machine) -> Result<Vec<Part>> {
        let mut parts: Vec<Part> = Vec::new();
        for (run, experiment) in self.experiments.iter().enumerate() {
            let traces = self.replay(real, run)?;
            for (channel, residual) in residuals(experiment, &traces, &self.floor).iter().enumerate() {
                let from = parts.last().map_or(0, |part| part.range.end);
                parts.push(Part { run, channel, range: from..from + residual.len() });
            }
        }
        Ok(parts)
    }

    fn replay(&self, machine: &Machine, run: usize) -> Result<Traces> {
        let told = &self.runs[run];
        sketch(machine, &self.otherwise, &told.reference(machine), told.begins_s)
    }

    /// What the case's machine does more than another one; none where that one does not work on these runs.
    pub fn change(&self, machine: &Machine) -> Option<DVector<f64>> {
        let of_run = |(run, experiment): (usize, &Experiment)| {
            let traces = self.replay(machine, run).ok()?;
            Some(residuals(experiment, &traces, &self.floor).concat())
        };
        let runs: Vec<Vec<f64>> =
            self.experiments.par_iter().enumerate().map(of_run).collect::<Option<_>>()?;
        let change = DVector::from_vec(runs.concat());
        let is_whole = self.parts.last().is_none_or(|last| last.range.end == change.len());
        (is_whole && self.size(&change) < BROKEN).then_some(change)
    }

    /// The size of a change: RMS over signals, each weighing the same, and samples; of training or held-out runs, whichever show less.
    pub fn size(&self, change: &DVector<f64>) -> f64 {
        let of = |group: &Vec<usize>| self.mean_square(change, |run| group.contains(&run));
        self.roles.iter().filter_map(of).fold(f64::INFINITY, f64::min).sqrt()
    }

    /// Mean square over the chosen runs, every signal weighing the same; none without any.
    fn mean_square(&self, change: &DVector<f64>, chosen: impl Fn(usize) -> bool) -> Option<f64> {
        let channels = self.parts.iter().map(|part| part.channel + 1).max().unwrap_or(0);
        let level = |channel: usize| {
            let own = self.parts.iter().filter(|part| part.channel == channel && chosen(part.run));
            let (squares, count) = own.fold((0.0, 0), |(squares, count), part| {
                let samples = change.rows(part.range.start, part.range.len());
                (squares + samples.norm_squared(), count + part.range.len())
            });
            (count > 0).then(|| squares / count as f64)
        };
        let levels: Vec<f64> = (0..channels).filter_map(level).collect();
        (!levels.is_empty()).then(|| levels.iter().sum::<f64>() / levels.len() as f64)
    }

    /// The longest run: its place.
    pub fn longest(&self) -> usize {
        (0..self.experiments.len()).max_by_key(|&run| self.experiments[run].samples()).unwrap_or(0)
    }

    /// The noise.
    pub fn floor(&self) -> &Floor {
        &self.floor
    }
}

/// The run that a logger would have made: measured signals as far as they are logged.
///
/// # Errors
/// Numbers that are not finite: the machine does not work.
pub fn as_logged(
    told: &TrialRun,
    machine: &Machine,
    reference: &[f64],
    traces: Traces,
    logged: &[Signal],
) -> Result<Run> {
    let whole = recorded(&told.name, machine, reference, traces)?;
    let signals = whole.signals().iter().filter(|(signal, _)| logged.contains(signal));
    let signals = signals.map(|(signal, samples)| (*signal, samples.clone())).collect();
    let mut run = Run::new(&told.name, whole.motion(), whole.sample_period_s(), signals)?;
    run.role = told.role;
    run.metadata = told.metadata(machine);
    run.begins_s = told.begins_s;
    Ok(run)
}
