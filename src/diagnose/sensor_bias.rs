//! What the sensors put into the numbers of a fit beside scatter.

use super::experiment::Experiment;
use super::linearised::Linearised;
use super::objective::Objective;
use crate::error::Result;
use crate::machine::Machine;
use crate::replay::run_seed;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Draws of the sensors' noise at most and at least: the mean of eight is known to a third of what one draw scatters, which adds 6 % to a standard error.
const DRAWS: (usize, usize) = (8, 4);
/// So many samples are drawn anew, over all draws and training runs: a choice of cost.
const SAMPLES: usize = 400_000;

/// Covariance that the sensors add to that of a fit's numbers, in units of their scales, beside what their noise makes the numbers scatter; none where
/// they are perfect.
///
/// # Model
/// A fit compares a log with replays that read perfectly and begin in the state that the first samples show. Noise of mean zero only scatters its
/// numbers, which their standard errors know. Two more things do not scatter within a run:
///
/// - Steps of a reading behind dry friction have no mean zero. The axis rests where the reading shows the reference, up to half a step beside it, the
///   integrator holds against that, and effort and current stand off as long as the axis sticks, in every run on the side from which it came.
/// - The state in which a replay begins has the noise of a few samples. What it is off by acts on the whole transient after it.
///
/// Both follow from logs y that the fitted twin writes itself, read through its sensors as stated. With f its perfect replay from the true start, f' that
/// from the start as read off y, J the derivatives of the residuals, W their weights and P the precision of the priors:
/// ```text
///   Δ(n) = −(JᵀWJ + P)⁻¹·JᵀW·n,   b = Δ(mean(y − f)),   added covariance = b·bᵀ + mean(Δ(f − f')·Δ(f − f')ᵀ)
/// ```
///
/// # Validity
/// To first order in the change of the numbers, as far as encoder and current sensor are as the machine's file states them. The start of a run that was cut out of a longer one
/// counts as known.
///
/// # Source
/// Parametric bootstrap: B. Efron, R. J. Tibshirani (1993), *An Introduction to the Bootstrap*, ch. 6 and 10, with the linear step in the place of
/// a fit of each draw.
///
/// # Errors
/// Whatever a replay refuses.
pub fn covariance(linear: &Linearised, fitted: &Machine) -> Result<Option<DMatrix<f64>>> {
    if fitted.description().has_perfect_sensors() {
        return Ok(None);
    }
    let objective = &linear.objective;
    let samples: usize = objective.experiments.iter().map(Experiment::samples).sum();
    let draws = (SAMPLES / samples.max(1)).clamp(DRAWS.1, DRAWS.0);
    let drawn = |seed: usize| drawn(objective, fitted, seed as u64);
    let drawn: Vec<[DVector<f64>; 2]> = (0..draws).into_par_iter().map(drawn).collect::<Result<_>>()?;
    let count = linear.jacobian.ncols();
    let (mut bias, mut by_starts) = (DVector::zeros(count), DMatrix::zeros(count, count));
    for [known, read] in drawn {
        bias += linear.step(&known) / draws as f64;
        let by_start = linear.step(&(read - known));
        by_starts += &by_start * by_start.transpose() / draws as f64;
    }
    Ok(Some(by_starts + &bias * bias.transpose()))
}

/// Normalised residuals of the fitted twin's own noisy logs: against its replay from the start that they really had, and from that which is read off them.
fn drawn(objective: &Objective, fitted: &Machine, seed: u64) -> Result<[DVector<f64>; 2]> {
    let (mut known, mut read) = (Vec::new(), Vec::new());
    for experiment in objective.experiments {
        let log = experiment.imagined(fitted, run_seed(seed, experiment.run().name()))?;
        read.push(log.begun_as_read(objective.machine)?);
        known.push(log);
    }
    let left = |experiments: &[Experiment]| -> Result<DVector<f64>> {
        let of = Objective::new(objective.machine, objective.hypothesis, experiments, objective.floor);
        Ok(of.residuals_at(std::slice::from_ref(fitted))?.remove(0))
    };
    Ok([left(&known)?, left(&read)?])
}
