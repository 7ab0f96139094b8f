//! How uncertain the numbers of an explanation are: what a verdict is decided by is what the report states.

use super::experiment::Training;
use super::fit::Fit;
use super::folds::Folds;
use super::linearised::Linearised;
use super::noise::Floor;
use super::{discrepancy, integration_error, modal_masses, sensor_bias};
use crate::error::Result;
use crate::machine::Machine;

/// An explanation whose standard errors know all that leaves its numbers uncertain.
pub struct Uncertainty {
    /// The fit, its standard errors and covariance widened by how far the training runs disagree, by what it does not describe, and by what the sensors
    /// and the steps of the plant put into its numbers.
    pub fit: Fit,
    /// The fits without each training run.
    pub folds: Folds,
}

impl Uncertainty {
    /// That of a fit; see [`Folds::widened`], [`discrepancy::covariance`], [`sensor_bias::covariance`] and [`integration_error::covariance`].
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn of(machine: &Machine, fit: &Fit, training: &Training, floor: &Floor) -> Result<Self> {
        let folds = Folds::of(machine, fit, training, floor)?;
        let mut wide = fit.clone();
        wide.standard_errors = folds.widened(fit);
        if !fit.values.is_empty() {
            let fitted = fit.machine(machine)?;
            let linear = Linearised::of(machine, fit, training.runs(), floor)?;
            let added = [
                discrepancy::covariance(&linear, &fitted)?,
                sensor_bias::covariance(&linear, &fitted)?,
                Some(integration_error::covariance(&linear, &fitted)?),
            ];
            added.iter().flatten().for_each(|covariance| wide.widen(covariance));
        }
        Ok(Self { fit: wide, folds })
    }

    /// With what the tolerance of the base's modal masses adds; see [`modal_masses::covariance`]. It makes all forces uncertain by one share, which is no question
    /// of whether an effect acts.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn beside_modal_masses(
        mut self,
        machine: &Machine,
        training: &Training,
        floor: &Floor,
    ) -> Result<Self> {
        let added = modal_masses::covariance(machine, &self.fit, training.runs(), floor)?;
        added.iter().for_each(|covariance| self.fit.widen(covariance));
        Ok(self)
    }
}
