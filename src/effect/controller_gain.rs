//! Controller gains that are not those stated.

use super::law::not_positive;
use super::{Constants, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Gains that the controller runs with, as multiples of those stated: a register that was retuned after the machine
/// file was written.
///
/// # Model
/// Position, velocity (or proportional) and integral gain are each their stated value times a factor. Where the gain is
/// an integer register n, the register in force is the integer nearest to n times the factor.
///
/// # Validity
/// The law itself is the one stated. A factor of a gain that is stated as zero says nothing.
///
/// # Source
/// [`Controller`](crate::controller::Controller).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerGain {
    /// Factor of the position loop's gain; more than zero.
    pub position_factor: f64,
    /// Factor of the velocity loop's (proportional) gain; more than zero.
    pub velocity_factor: f64,
    /// Factor of the integral gain; more than zero.
    pub integral_factor: f64,
}

impl Law for ControllerGain {
    const SITE: Site = Site::Controller;
    const PHRASE: &'static str = "controller gains that are not those stated";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::same("position_factor", "1"),
        Parameter::same("velocity_factor", "1"),
        Parameter::same("integral_factor", "1"),
    ];

    fn applies(constants: &Constants) -> bool {
        constants.controller.is_some()
    }

    fn fault(&self) -> Option<String> {
        not_positive("position_factor", self.position_factor)
            .or_else(|| not_positive("velocity_factor", self.velocity_factor))
            .or_else(|| not_positive("integral_factor", self.integral_factor))
    }

    fn alter(&self, constants: &mut Constants) {
        if let Some(controller) = &mut constants.controller {
            controller.scale_gains(self.position_factor, self.velocity_factor, self.integral_factor);
        }
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![1.0; 3]
    }

    fn start(_screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![1.0; 3]]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.05, 20.0); 3]
    }
}
