//! Controller gains that are not those stated.

use super::law::{infinite, negative, not_positive};
use super::{Constants, Law, Parameter, Screen, Site};
use crate::controller::Controller;
use serde::{Deserialize, Serialize};

/// Gains that the controller runs with, as multiples of those stated: a register that was retuned after the machine
/// file was written.
///
/// # Model
/// Position, velocity (or proportional, or derivative) and integral gain are each their stated value times a factor. Where the gain is
/// an integer register n, the register in force is the integer nearest to n times the factor. The feed-forward of the
/// reference velocity is the share itself, since it is often stated as zero.
///
/// # Validity
/// The law itself is the one stated. A factor of a gain that is stated as zero says nothing.
///
/// # Source
/// [`Controller`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerGain {
    /// Factor of the position loop's gain; more than zero.
    pub position_factor: f64,
    /// Factor of the velocity loop's (proportional) gain; more than zero.
    pub velocity_factor: f64,
    /// Factor of the integral gain; zero where the integral part is switched off.
    pub integral_factor: f64,
    /// Share of the reference velocity that is fed forward, in the place of the stated one.
    pub velocity_feedforward: f64,
}

impl Law for ControllerGain {
    const SITE: Site = Site::Controller;
    const PHRASE: &'static str = "controller gains that are not those stated";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::same("position_factor", "1"),
        Parameter::same("velocity_factor", "1"),
        Parameter::same("integral_factor", "1"),
        Parameter::same("velocity_feedforward", "1"),
    ];

    fn applies(constants: &Constants) -> bool {
        constants.controller.is_some()
    }

    fn fault(&self) -> Option<String> {
        not_positive("position_factor", self.position_factor)
            .or_else(|| not_positive("velocity_factor", self.velocity_factor))
            .or_else(|| negative("integral_factor", self.integral_factor))
            .or_else(|| infinite("velocity_feedforward", self.velocity_feedforward))
    }

    fn alter(&self, constants: &mut Constants) {
        if let Some(controller) = &mut constants.controller {
            controller.scale_gains(self.position_factor, self.velocity_factor, self.integral_factor);
            controller.set_velocity_feedforward(self.velocity_feedforward);
        }
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        let stated = constants.controller.as_ref().map_or(0.0, Controller::velocity_feedforward);
        vec![1.0, 1.0, 1.0, stated]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        screen.constants.as_ref().map(Self::neutral).into_iter().collect()
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.05, 20.0), (0.05, 20.0), (0.0, 20.0), (-0.5, 1.5)]
    }
}
