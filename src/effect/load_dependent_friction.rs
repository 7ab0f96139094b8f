//! Friction in proportion to what the sliders carry.

use super::law::negative;
use super::{Constants, Door, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Dry friction proportional to the loads of the four bearing sliders.
///
/// # Model
/// `F = −μ·Σ|N_i|·sgn(v)` over the sliders A–D, sticking below that at rest. The loads N_i are those of the rigid-body
/// scene: weight, and the couple of motor force and friction at their lines of action.
///
/// # Validity
/// While every slider stays pressed down and the carried mass does not change, Σ|N_i| is the weight: it is then exactly
/// Coulomb friction. They part when a slider lifts under acceleration, or between runs with different payload.
///
/// # Source
/// Amontons' law on each slider; loads from [`Supports`](crate::plant::rapier::Supports).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadDependentFriction {
    /// μ; not negative.
    pub coefficient: f64,
}

impl Law for LoadDependentFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "friction in proportion to the sliders' loads";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("coefficient", "1")];
    // Where the loads do not change it is Coulomb friction, which says the same with less.
    const RARITY: f64 = 3.0;
    const DOORS: &'static [Door] = &[Door::Load];

    fn applies(constants: &Constants) -> bool {
        constants.has_slider_loads
    }

    fn fault(&self) -> Option<String> {
        negative("coefficient", self.coefficient)
    }

    fn load_coefficient(&self) -> f64 {
        self.coefficient
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let force = screen.four_coefficients().map_or(0.05 * screen.largest_force, |[_, _, sign, _]| -sign);
        vec![vec![(force / weight(screen)).max(0.0)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, screen.largest_force / weight(screen))]
    }
}

/// Weight of the moving part in N, to start a fit from.
fn weight(screen: &Screen) -> f64 {
    9.81 * screen.moving_mass()
}
