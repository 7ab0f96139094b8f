//! A moving mass or inertia off its stated value.

use super::law::infinite;
use super::{Constants, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Mass carried beside the solid model's: a workpiece, a fixture, coolant, or a model that weighs wrong.
///
/// # Model
/// `m = m_solid + Δm`, rigidly fixed to the moving part at its centre of mass.
///
/// # Validity
/// Δm > −m_solid. Positive and negative alike; where the load attaches flexibly, it is a mode instead.
///
/// # Source
/// Newton's second law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Δm in kg, or added inertia about the joint's axis in kg·m².
    #[serde(alias = "inertia_kg_m2")]
    pub mass_kg: f64,
}

impl Law for Payload {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a moving mass off its stated value";
    const CUMULATIVE: bool = true;
    const PARAMETERS: &'static [Parameter] =
        &[Parameter::differing("mass_kg", "inertia_kg_m2", "kg", "kg·m²")];

    fn fault(&self) -> Option<String> {
        infinite("mass_kg", self.mass_kg)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.moving_mass += self.mass_kg;
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // The missing force contains −Δm·a.
        let mass = screen.moving_mass();
        let change = screen.four_coefficients().map_or(0.0, |[acceleration, ..]| -acceleration);
        vec![vec![change.clamp(-0.8 * mass, 20.0 * mass)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let mass = screen.moving_mass();
        vec![(-0.9 * mass, 30.0 * mass)]
    }
}
