//! Whiteness of the residuals that the twin with its causes leaves.

use super::experiment::Experiment;
use super::noise::Floor;
use crate::error::Result;
use crate::identify::whiteness::Whiteness;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Lags that are looked at: 12.5 ms of a drive's 250 µs, one period of a base mode at 80 Hz.
const LAGS: usize = 50;

/// Residual of one signal on the held-out runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResidualWhiteness {
    /// Canonical name.
    pub signal: String,
    /// From one lag to the next, in s.
    pub lag_s: f64,
    /// Autocorrelation of the residual in units of its noise, and the Ljung–Box test.
    #[serde(flatten)]
    pub whiteness: Whiteness,
}

/// Tests the residual of each signal of the held-out runs.
///
/// # Validity
/// Runs of one sample period; of several, the first one's is given and lags count samples.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub fn residual_whiteness(
    machine: &Machine,
    held_out: &[Experiment],
    floor: &Floor,
) -> Result<Vec<ResidualWhiteness>> {
    let mut residuals: BTreeMap<Signal, Vec<Vec<f64>>> = BTreeMap::new();
    for experiment in held_out {
        let predicted = experiment.predict(machine, Sensing::Perfect)?;
        for &signal in experiment.signals() {
            let mut residual = floor.normalised(experiment, signal, &predicted);
            residual.retain(|x| x.is_finite());
            residuals.entry(signal).or_default().push(residual);
        }
    }
    let lag_s = held_out.first().map_or(0.0, |first| first.run().sample_period_s());
    let of = |(signal, runs): (Signal, Vec<Vec<f64>>)| {
        let runs: Vec<&[f64]> = runs.iter().map(Vec::as_slice).collect();
        let whiteness = Whiteness::over(&runs, LAGS);
        ResidualWhiteness { signal: signal.key(machine.motion()).to_owned(), lag_s, whiteness }
    };
    Ok(residuals.into_iter().filter(|(_, runs)| runs.iter().any(|run| run.len() > 1)).map(of).collect())
}
