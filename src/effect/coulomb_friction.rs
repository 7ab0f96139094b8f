//! Coulomb friction of the guide.

use super::law::negative;
use super::{Constants, Door, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Coulomb (dry) friction of the guide.
///
/// # Model
/// ```text
///   v ≠ 0:  F = −F_c·sgn(v)
///   v = 0:  F = whatever holds the axis, up to |F| ≤ F_c
/// ```
/// Positive force acts along positive position.
///
/// # Validity
/// Gross sliding and ideal sticking; no stiction peak, no presliding motion, no dependence on load,
/// position or direction.
///
/// # Source
/// Coulomb (1785); Janot, Gautier, Brunot (2019), eq. 2, term `Fc·sign(q̇)`.
///
/// ```
/// use slideway::effect::{CoulombFriction, Law};
/// let law = CoulombFriction { force_n: 15.0 };
/// assert_eq!(law.resistance(1.0, 0.3), law.resistance(-1.0, 0.0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoulombFriction {
    /// F_c in N, or N·m for a revolute axis; not negative.
    #[serde(alias = "torque_nm")]
    pub force_n: f64,
}

impl Law for CoulombFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "Coulomb friction";
    const PARAMETERS: &'static [Parameter] = &[Parameter::effort("force_n", "torque_nm")];
    const RESISTANCE_VARIES: bool = false;
    const DOORS: &'static [Door] = &[Door::Resistance];

    fn fault(&self) -> Option<String> {
        negative("force_n", self.force_n)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.coulomb = self.force_n;
    }

    fn resistance(&self, _direction: f64, _speed: f64) -> f64 {
        self.force_n
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.coulomb]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let own = screen.constants.as_ref().map_or(0.0, |c| c.coulomb);
        let found = screen.four_coefficients().map_or(0.05 * screen.largest_force, |[_, _, sign, _]| -sign);
        vec![vec![(own + found).max(0.0)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, screen.largest_force)]
    }
}
