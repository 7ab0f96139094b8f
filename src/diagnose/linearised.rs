//! A fit near its minimum, to first order: what its numbers take up of a change of the residuals.

use super::experiment::Experiment;
use super::fit::Fit;
use super::noise::Floor;
use super::objective::Objective;
use super::sandwich::inverted;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};

/// The residuals of a fit on its runs, with what a linear least-squares step needs.
pub struct Linearised<'a> {
    /// What the fit minimises.
    pub objective: Objective<'a>,
    /// The normalised residuals r.
    pub residuals: DVector<f64>,
    /// Their weights W.
    pub weights: DVector<f64>,
    /// Their derivatives J by the numbers in units of the numbers' scales.
    pub jacobian: DMatrix<f64>,
    /// (JᵀWJ + P)⁻¹, with P the precision of the priors.
    inverse: DMatrix<f64>,
}

impl<'a> Linearised<'a> {
    /// Of a fit on the runs that it was fitted to.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn of(
        machine: &'a Machine,
        fit: &'a Fit,
        experiments: &'a [Experiment],
        floor: &'a Floor,
    ) -> Result<Self> {
        let objective = Objective::new(machine, &fit.hypothesis, experiments, floor);
        let residuals = objective.residuals(&fit.values)?;
        let jacobian = objective.jacobian(&fit.values, &residuals, None)?;
        let weights = objective.weights(&residuals);
        let (normal, _) = objective.normal(&jacobian, &residuals, &weights, &fit.values);
        Ok(Self { inverse: inverted(&normal), objective, residuals, weights, jacobian })
    }

    /// How far the numbers go where the residuals change by `change`, in units of their scales: `−(JᵀWJ + P)⁻¹·JᵀW·change`.
    pub fn step(&self, change: &DVector<f64>) -> DVector<f64> {
        -&self.inverse * self.jacobian.tr_mul(&change.component_mul(&self.weights))
    }
}
