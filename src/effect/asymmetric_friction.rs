//! Friction that differs between the two directions.

use super::law::negative;
use super::{Constants, Door, EffectId, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Friction with its own Coulomb force and viscous coefficient in each direction.
///
/// # Model
/// ```text
///   v > 0:  F = −(F₊ + c₊·v)
///   v < 0:  F = +(F₋ + c₋·|v|)
///   v = 0:  F = whatever holds the axis, −F₊ ≤ F ≤ F₋
/// ```
/// It takes the place of the guide's stated viscous coefficient and of any symmetric Coulomb friction.
/// Positive force acts along positive position.
///
/// # Validity
/// As Coulomb and viscous friction. While F₊ ≠ F₋ alone differ and c₊ = c₋, the law is *exactly* Coulomb
/// friction `(F₊+F₋)/2` with a constant force `−(F₊−F₋)/2`: no data can tell the two apart.
///
/// # Source
/// Janot, Gautier, Brunot (2019), section 4 (asymmetric friction of a worn screw).
///
/// ```
/// use slideway::effect::{AsymmetricFriction, Law, Constants};
/// let law = AsymmetricFriction {
///     coulomb_positive_n: 20.0, coulomb_negative_n: 22.0,
///     viscous_positive_n_s_per_m: 160.0, viscous_negative_n_s_per_m: 240.0,
/// };
/// // The mean coefficient, 200 N·s/m, is in the linear dynamics; the rest resists.
/// assert_eq!(law.resistance(1.0, 0.1), 20.0 - 4.0);
/// assert_eq!(law.resistance(-1.0, 0.1), 22.0 + 4.0);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AsymmetricFriction {
    /// F₊ in N, or N·m for a revolute axis; not negative.
    #[serde(alias = "coulomb_positive_nm")]
    pub coulomb_positive_n: f64,
    /// F₋ in N, or N·m; not negative.
    #[serde(alias = "coulomb_negative_nm")]
    pub coulomb_negative_n: f64,
    /// c₊ in N·s/m, or N·m·s/rad; not negative.
    #[serde(alias = "viscous_positive_nm_s_per_rad")]
    pub viscous_positive_n_s_per_m: f64,
    /// c₋ in N·s/m, or N·m·s/rad; not negative.
    #[serde(alias = "viscous_negative_nm_s_per_rad")]
    pub viscous_negative_n_s_per_m: f64,
}

impl AsymmetricFriction {
    fn mean_viscous(&self) -> f64 {
        0.5 * (self.viscous_positive_n_s_per_m + self.viscous_negative_n_s_per_m)
    }
}

impl Law for AsymmetricFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "friction that differs between the two directions";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::effort("coulomb_positive_n", "coulomb_positive_nm"),
        Parameter::effort("coulomb_negative_n", "coulomb_negative_nm"),
        Parameter::viscous("viscous_positive_n_s_per_m", "viscous_positive_nm_s_per_rad"),
        Parameter::viscous("viscous_negative_n_s_per_m", "viscous_negative_nm_s_per_rad"),
    ];
    const SUPERSEDES: &'static [EffectId] = &[EffectId::ViscousFriction, EffectId::CoulombFriction];
    // Coulomb forces that differ are a constant force as well.
    const STANDS_FOR: &'static [EffectId] =
        &[EffectId::ViscousFriction, EffectId::CoulombFriction, EffectId::ConstantForce];
    const DOORS: &'static [Door] = &[Door::Resistance];

    fn fault(&self) -> Option<String> {
        negative("coulomb_positive_n", self.coulomb_positive_n)
            .or_else(|| negative("coulomb_negative_n", self.coulomb_negative_n))
            .or_else(|| negative("viscous_positive_n_s_per_m", self.viscous_positive_n_s_per_m))
            .or_else(|| negative("viscous_negative_n_s_per_m", self.viscous_negative_n_s_per_m))
    }

    fn alter(&self, constants: &mut Constants) {
        constants.viscous = self.mean_viscous();
    }

    fn resistance(&self, direction: f64, speed: f64) -> f64 {
        let (coulomb, viscous) = if direction > 0.0 {
            (self.coulomb_positive_n, self.viscous_positive_n_s_per_m)
        } else {
            (self.coulomb_negative_n, self.viscous_negative_n_s_per_m)
        };
        coulomb + (viscous - self.mean_viscous()) * speed
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.coulomb, constants.coulomb, constants.viscous, constants.viscous]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let direction = screen.directions();
        let half = |wanted: f64, column: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..direction.len()).map(|k| if direction[k] == wanted { column(k) } else { 0.0 }).collect()
        };
        let columns = [
            screen.acceleration.clone(),
            half(1.0, &|_| -1.0),
            half(-1.0, &|_| 1.0),
            half(1.0, &|k| -screen.velocity[k]),
            half(-1.0, &|k| -screen.velocity[k]),
        ];
        let stated = screen.viscous();
        let coulomb = screen.constants.as_ref().map_or(0.0, |c| c.coulomb);
        let guess = match screen.regress(&columns).as_deref() {
            Some([_, plus, minus, c_plus, c_minus]) => {
                vec![coulomb + plus, coulomb + minus, stated + c_plus, stated + c_minus]
            }
            _ => vec![0.05 * screen.largest_force, 0.05 * screen.largest_force, stated, stated],
        };
        vec![guess.into_iter().map(|value| value.max(0.0)).collect()]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let viscous = screen.viscous() + 3.0 * screen.largest_force / screen.largest_speed().max(1e-9);
        let force = screen.largest_force;
        vec![(0.0, force), (0.0, force), (0.0, viscous), (0.0, viscous)]
    }
}
