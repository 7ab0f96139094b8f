//! Gain of the position loop other than stated.

use super::law::not_positive;
use super::{Constants, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Gain of the position loop other than stated, retuned after the machine file was written.
///
/// # Model
/// The gain is its stated value times a factor. Where it is an integer register n, the register in
/// force is the integer nearest to n times the factor.
///
/// # Validity
/// The law itself is the one stated, and states this gain other than zero.
///
/// # Source
/// [`Controller`](crate::controller::Controller).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionGain {
    /// Factor of the stated gain; more than zero.
    pub factor: f64,
}

impl Law for PositionGain {
    const SITE: Site = Site::Controller;
    const PHRASE: &'static str = "a position gain other than stated";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("factor", "1")];
    const GROUP: Option<&'static str> = Some(super::CONTROLLER_GAIN);

    fn applies(constants: &Constants) -> bool {
        constants.controller.as_ref().is_some_and(|law| law.with_gains(2.0, 1.0, 1.0) != *law)
    }

    fn fault(&self) -> Option<String> {
        not_positive("factor", self.factor)
    }

    fn alter(&self, constants: &mut Constants) {
        if let Some(law) = &mut constants.controller {
            *law = law.with_gains(self.factor, 1.0, 1.0);
        }
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![1.0]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        screen.constants.as_ref().map(Self::neutral).into_iter().collect()
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.05, 20.0)]
    }
}
