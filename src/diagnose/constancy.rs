//! Whether an explanation's numbers are the same on runs that were not fitted.
//!
//! A law that is really there has the same constants in every run. One that stands for something else often needs
//! other constants where the motion is another: it predicts, but it is not the law.

use super::experiment::Experiment;
use super::fit::{Care, Fit, fit};
use super::hypothesis::Freedom;
use super::noise::Floor;
use crate::error::Result;
use crate::machine::Machine;

/// One number of an explanation, fitted on the training runs and again on the held-out runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Key path.
    pub path: String,
    /// From the training runs, with its standard error.
    pub training: (f64, f64),
    /// From the held-out runs, with its standard error.
    pub held_out: (f64, f64),
}

impl Constant {
    /// Difference in standard errors of the difference.
    pub fn deviation(&self) -> f64 {
        let spread = self.training.1.hypot(self.held_out.1);
        (self.training.0 - self.held_out.0).abs() / spread.max(f64::MIN_POSITIVE)
    }

    /// Difference as a share of the larger value.
    pub fn change(&self) -> f64 {
        let size = self.training.0.abs().max(self.held_out.0.abs());
        (self.training.0 - self.held_out.0).abs() / size.max(f64::MIN_POSITIVE)
    }
}

/// Fits an explanation's own numbers to the held-out runs too. This judges a finished explanation; nothing that is
/// chosen or reported as its parameters comes from it.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub fn constants(
    machine: &Machine,
    chosen: &Fit,
    held_out: &[Experiment],
    floor: &Floor,
) -> Result<Vec<Constant>> {
    let again = fit(machine, &chosen.hypothesis, held_out, floor, Some(&chosen.values), Care::Thorough)?;
    let numbers = chosen.hypothesis.free.iter().enumerate();
    Ok(numbers
        .filter(|(_, free)| free.freedom == Freedom::Cause && !free.held)
        .map(|(k, free)| Constant {
            path: free.path.clone(),
            training: (chosen.values[k], chosen.standard_errors[k]),
            held_out: (again.values[k], again.standard_errors[k]),
        })
        .collect())
}
