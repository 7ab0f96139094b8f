//! Runs beside what the twin as it is makes of them.

use crate::diagnose::experiment::Experiment;
use crate::error::Result;
use crate::machine::Machine;
use crate::replay::Traces;
use crate::twin::Sensing;
use rayon::prelude::*;

/// One run, and the twin as it is in its place.
#[derive(Debug)]
pub struct Stated<'a> {
    /// The run.
    pub experiment: &'a Experiment,
    /// The twin as it was set in the run.
    pub machine: Machine,
    /// The run as that twin would have logged it, noise as stated.
    pub imagined: Experiment,
    /// What it predicts.
    pub predicted: Traces,
}

/// These runs, replayed in closed loop by the twin as it is, side by side; none where one of them is replayed in windows: there is no closed loop to compare
/// its stretches with.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub fn stated<'a>(machine: &Machine, experiments: &'a [Experiment]) -> Result<Vec<Stated<'a>>> {
    if experiments.iter().any(|experiment| experiment.input().is_some()) {
        return Ok(Vec::new());
    }
    let of_run = |(seed, experiment): (usize, &'a Experiment)| {
        Ok(Stated {
            experiment,
            machine: experiment.machine(machine)?,
            imagined: experiment.imagined(machine, seed as u64)?,
            predicted: experiment.predict(machine, Sensing::Perfect)?,
        })
    };
    experiments.par_iter().enumerate().map(of_run).collect()
}
