//! What a page shows beyond the numbers of a diagnosis: traces, residual forces, spectra, loads, the machine's shape.
//!
//! Computed in a pass of its own, by replaying the runs with the machine as it is and with its causes: a diagnosis
//! without a page is no slower.

pub mod events;
pub mod force;
mod next;
pub mod partial;
pub mod response;
pub mod shape;
pub mod spectrum;
pub mod traces;

pub use events::Event;
pub use force::Force;
pub use next::Predicted;
pub use partial::Partial;
pub use response::Response;
pub use shape::MachineShape;
pub use spectrum::Spectrum;
pub use traces::{RunTraces, Trace};

use crate::diagnose::Diagnosis;
use crate::diagnose::evidence::Score;
use crate::diagnose::experiment::{Experiment, HeldOut};
use crate::diagnose::noise::Floor;
use crate::diagnose::verdict::Cause;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Recording, Run, Signal, SplitRule};
use crate::units::Motion;
use rayon::prelude::*;

/// Everything that is drawn of a diagnosis.
#[derive(Debug, Clone)]
pub struct Material {
    /// Kind of axis.
    pub motion: Motion,
    /// What the predictions before are of: the twin as it is, or in a comparison the reference's.
    pub baseline: &'static str,
    /// The runs, held-out ones first.
    pub runs: Vec<RunTraces>,
    /// The force that the twin lacks, over all runs; none where no signal tells the motor's force.
    pub force: Option<Force>,
    /// What each cause takes up by itself.
    pub partials: Vec<Partial>,
    /// Spectra of the held-out residuals, one a signal.
    pub spectra: Vec<Spectrum>,
    /// Frequency response of machine and twin, where the signals for one were logged.
    pub response: Option<Response>,
    /// Share of the gap that calibration closes once the causes are in the twin.
    pub calibration_closes: f64,
    /// Residuals on the training runs, RMS before and after, one a signal.
    pub training: Vec<(Signal, [f64; 2])>,
    /// What the next experiment should show, where one is proposed.
    pub next: Option<Predicted>,
    /// The machine.
    pub shape: MachineShape,
}

/// The machine as it is in this diagnosis and with what was found, with the causes alone, with the calibration alone.
struct Machines {
    stated: Machine,
    improved: Machine,
    uncalibrated: Machine,
    calibrated: Machine,
}

impl Machines {
    fn of(machine: &Machine, diagnosis: &Diagnosis) -> Result<Self> {
        let stated = baseline(machine, diagnosis)?;
        let causes = diagnosis.causes.iter().flat_map(Cause::settings);
        let causes: Vec<(String, f64)> = causes.map(|(path, parameter)| (path, parameter.value)).collect();
        let uncalibrated =
            stated.with_settings(causes.iter().map(|(path, value)| (path.as_str(), (*value).into())))?;
        let improved = diagnosis.improved(&stated)?;
        let constants = diagnosis.calibration.iter().map(|c| (c.path.as_str(), c.parameter.value.into()));
        let calibrated = stated.with_settings(constants)?;
        Ok(Self { stated, improved, uncalibrated, calibrated })
    }
}

/// The twin that a diagnosis starts from: the machine's file, or in a comparison what the reference found.
fn baseline(machine: &Machine, diagnosis: &Diagnosis) -> Result<Machine> {
    let Some(reference) = &diagnosis.reference else { return Ok(machine.clone()) };
    let known = reference.causes.iter().flat_map(Cause::settings);
    let known = known.map(|(path, parameter)| (path, parameter.value));
    // What the comparison calls the twin's value is the reference's.
    let had = diagnosis.calibration.iter().map(|c| (c.path.clone(), c.parameter.twin));
    let settings: Vec<(String, f64)> = known.chain(had).filter(|(_, value)| value.is_finite()).collect();
    machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), (*value).into())))
}

impl Material {
    /// Replays the recording with the machine as it is and with the causes of its diagnosis.
    ///
    /// # Errors
    /// What the diagnosis refuses: a machine or a recording that is not the diagnosed one.
    pub fn of(machine: &Machine, recording: &Recording, diagnosis: &Diagnosis) -> Result<Self> {
        let machines = Machines::of(machine, diagnosis)?;
        let split = recording.split_within(SplitRule::default(), diagnosis.data.samples.most)?;
        let ready = |run: &Run| Experiment::new(run, &machines.stated);
        let (training, held_out) = (split.training.prepare(ready)?, split.held_out.prepare(ready)?);
        let judged = held_out.runs().iter().map(|e| (e, true));
        let fitted = training.runs().iter().map(|e| (e, false));
        let both: Vec<(&Experiment, bool)> = judged.chain(fitted).collect();
        let pair = [&machines.stated, &machines.improved];
        let runs: Result<Vec<RunTraces>> = both
            .par_iter()
            .map(|(experiment, is_held_out)| RunTraces::of(experiment, *is_held_out, pair))
            .collect();
        let runs = runs?;
        let all: Vec<&Experiment> = both.iter().map(|(e, _)| *e).collect();
        let floor = Floor::estimate(&machines.improved, &all)?;
        let motion = machine.motion();
        let force = Force::of(&all, pair)?;
        Ok(Self {
            motion,
            baseline: super::words::baseline(diagnosis),
            partials: partial::partials(&machines, diagnosis, &all, force.as_ref(), &floor)?,
            force,
            spectra: spectrum::of(&runs, motion),
            response: Response::of(&runs),
            calibration_closes: calibration_closes(&machines, &held_out, &floor)?,
            training: training_residuals(&runs),
            next: Predicted::of(&machines, diagnosis, &training, &floor),
            shape: MachineShape::of(machine),
            runs,
        })
    }
}

/// Share of the gap that calibration closes whether it comes first or last.
///
/// Causes that were fitted together with it may say nothing without it: what both take to close counts with them.
fn calibration_closes(machines: &Machines, held_out: &HeldOut, floor: &Floor) -> Result<f64> {
    let score = |machine: &Machine| Score::of(machine, held_out, floor).map(|score| score.mean_square());
    let (before, after) = (score(&machines.stated)?, score(&machines.improved)?);
    let (without, alone) = (score(&machines.uncalibrated)?, score(&machines.calibrated)?);
    let excess = before - 1.0;
    let closes = (without - after).min(before - alone);
    Ok(if excess > 0.0 { (closes / excess).clamp(0.0, 1.0) } else { 0.0 })
}

fn training_residuals(runs: &[RunTraces]) -> Vec<(Signal, [f64; 2])> {
    let signals: Vec<Signal> = runs.iter().flat_map(|run| &run.traces).map(|trace| trace.signal).collect();
    let mut list: Vec<(Signal, [f64; 2])> = Vec::new();
    for signal in signals {
        if list.iter().any(|(known, _)| *known == signal) {
            continue;
        }
        let of = runs.iter().filter(|run| !run.is_held_out);
        let traces: Vec<&Trace> = of.filter_map(|run| run.trace(signal)).collect();
        let square = |predicted: fn(&Trace) -> &[f64]| -> f64 {
            let pairs = traces.iter().flat_map(|t| t.measured.iter().zip(predicted(t)));
            let (sum, count) = pairs.fold((0.0, 0.0), |(sum, n), (m, p)| (sum + (m - p) * (m - p), n + 1.0));
            if count > 0.0 { f64::sqrt(sum / count) } else { f64::NAN }
        };
        list.push((signal, [square(|t| &t.before), square(|t| &t.after)]));
    }
    list
}
