//! Coulomb friction of the guide.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
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
/// Gross sliding and ideal sticking. Stiction, presliding, load and direction are features that modify it, see
/// [`DryFriction`](crate::guide::DryFriction).
///
/// # Prior
/// F_c of 0.2 to 20 % of the rated force, log-uniform: from a linear guide without seals to a preloaded screw or a gearbox.
/// Friction in catalogues of linear guides and ball screws, such as those of THK, HIWIN and NSK.
///
/// # Source
/// Coulomb (1785); Janot, Gautier, Brunot (2019), eq. 2, term `Fc·sign(q̇)`.
///
/// ```
/// use slideway::guide::DryFriction;
/// let guide = DryFriction { coulomb: 15.0, ..DryFriction::default() };
/// assert_eq!(guide.level(1.0, 0.3), guide.level(-1.0, 0.0));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoulombFriction {
    /// F_c in N, or N·m for a revolute axis; not negative.
    #[serde(alias = "torque_nm")]
    pub force_n: f64,
}

impl Law for CoulombFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "Coulomb friction";
    const PARAMETERS: &'static [Parameter] = &[Parameter::effort("force_n", "torque_nm").not_negative()];

    fn fault(&self) -> Option<String> {
        negative("force_n", self.force_n)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.coulomb = self.force_n;
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.friction.coulomb]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str =
        "v ≠ 0:  F = −F_c·sgn(v)\nv = 0:  F = whatever holds the axis, up to |F| ≤ F_c";
    const SYMBOLS: &'static [&'static str] = &["F_c"];
    const SOURCE: &'static str = "Coulomb (1785); Janot, Gautier, Brunot (2019), eq. 2, term Fc·sign(q̇)";
    const SHOWN_BY: &'static str =
        "Force that changes sign with the direction of motion: reversals, strokes both ways.";
    const EXAMPLE: &'static [f64] = &[15.0];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.log_uniform(0.002, 0.20) * machine.rated_force]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}
