//! Friction that differs between the two directions.

use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// The guide's Coulomb and viscous friction differ between the two directions.
///
/// # Model
/// ```text
///   v > 0:  F = −(F_c·(1 + a) + c·(1 + b)·v)
///   v < 0:  F = +(F_c·(1 − a) + c·(1 − b)·|v|)
///   v = 0:  F = whatever holds the axis, −F_c·(1 + a) ≤ F ≤ F_c·(1 − a)
/// ```
/// with F_c that of Coulomb friction and c the guide's viscous coefficient, which it modifies. Positive force acts along positive
/// position.
///
/// # Validity
/// As Coulomb and viscous friction. With b = 0 and no bristles, the law is *exactly* Coulomb friction with a constant force
/// −a·F_c: no data can tell the two apart.
///
/// # Prior
/// a and b of 0.03 to 0.4 each, log-uniform, either sign, independent of each other. That friction differs between directions:
/// Armstrong-Hélouvry, Dupont, Canudas de Wit (1994); Janot, Gautier, Brunot (2019), whose worn screw lies inside. The bounds are
/// an engineering estimate.
///
/// # Source
/// Janot, Gautier, Brunot (2019), section 4 (asymmetric friction of a worn screw).
///
/// ```
/// use slideway::guide::DryFriction;
/// let guide = DryFriction { coulomb: 21.0, asymmetry: -1.0 / 21.0, viscous_asymmetry: -0.2, ..DryFriction::default() };
/// // The mean coefficient, 200 N·s/m, is in the linear dynamics; the rest resists.
/// assert!((guide.resistance(1.0, 0.1, 200.0) - (20.0 - 4.0)).abs() < 1e-12);
/// assert!((guide.resistance(-1.0, 0.1, 200.0) - (22.0 + 4.0)).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AsymmetricFriction {
    /// a, from −1 to 1.
    #[serde(default)]
    pub coulomb_asymmetry: f64,
    /// b, from −1 to 1.
    #[serde(default)]
    pub viscous_asymmetry: f64,
}

impl Law for AsymmetricFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "asymmetric friction";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::same("coulomb_asymmetry", "1").within(-1.0, 1.0),
        Parameter::same("viscous_asymmetry", "1").within(-1.0, 1.0),
    ];
    const MODIFIES: &'static [EffectId] = &[EffectId::CoulombFriction, EffectId::ViscousFriction];

    fn fault(&self) -> Option<String> {
        let outside = |name: &str, value: f64| {
            (!(-1.0..=1.0).contains(&value)).then(|| format!("{name} = {value}, expected −1 to 1"))
        };
        outside("coulomb_asymmetry", self.coulomb_asymmetry)
            .or_else(|| outside("viscous_asymmetry", self.viscous_asymmetry))
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.asymmetry = self.coulomb_asymmetry;
        constants.friction.viscous_asymmetry = self.viscous_asymmetry;
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.friction.asymmetry, constants.friction.viscous_asymmetry]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str =
        "v > 0:  F = −(F_c·(1 + a) + c·(1 + b)·v)\nv < 0:  F = +(F_c·(1 − a) + c·(1 − b)·|v|)";
    const SYMBOLS: &'static [&'static str] = &["a", "b"];
    const SOURCE: &'static str = "Janot, Gautier, Brunot (2019), section 4";
    const SHOWN_BY: &'static str =
        "Drag that differs between the directions: the same strokes both ways, at several feeds.";
    const EXAMPLE: &'static [f64] = &[-0.33, -0.17];
    const CONFUSABLE: &'static [Likeness] = &[Likeness::similar(
        EffectId::ConstantForce,
        "where only the Coulomb part differs between the directions",
    )];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let mut lean = || prior.sign() * prior.log_uniform(0.03, 0.4);
        vec![lean(), lean()]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}
