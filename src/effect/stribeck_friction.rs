//! Stiction that decays with speed.

use super::law::{negative, not_positive};
use super::{Constants, Door, EffectId, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Dry friction with stiction and Stribeck decay.
///
/// # Model
/// ```text
///   v ≠ 0:  F = −(F_c + (F_s − F_c)·exp(−(v/v_s)²))·sgn(v)
///   v = 0:  F = whatever holds the axis, up to |F| ≤ F_s
/// ```
/// It takes the place of Coulomb friction; F_s is not below F_c. Positive force acts along positive position.
///
/// # Validity
/// Static: no memory of how long the axis stood. At speeds well above v_s it is Coulomb friction.
///
/// # Source
/// Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), eq. 5, exponent 2.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StribeckFriction {
    /// F_c in N, or N·m for a revolute axis; not negative.
    #[serde(alias = "coulomb_nm")]
    pub coulomb_n: f64,
    /// F_s in N, or N·m; not negative.
    #[serde(alias = "stiction_nm")]
    pub stiction_n: f64,
    /// v_s in m/s, or rad/s; more than zero.
    #[serde(alias = "stribeck_velocity_rad_per_s")]
    pub stribeck_velocity_m_per_s: f64,
}

impl Law for StribeckFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "friction with stiction that decays with speed";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::effort("coulomb_n", "coulomb_nm"),
        Parameter::effort("stiction_n", "stiction_nm"),
        Parameter::differing("stribeck_velocity_m_per_s", "stribeck_velocity_rad_per_s", "m/s", "rad/s"),
    ];
    // Friction in proportion to the slider loads is Coulomb friction while these do not change.
    const SUPERSEDES: &'static [EffectId] = &[EffectId::CoulombFriction, EffectId::LoadDependentFriction];
    const DOORS: &'static [Door] = &[Door::Resistance];

    fn fault(&self) -> Option<String> {
        negative("coulomb_n", self.coulomb_n)
            .or_else(|| negative("stiction_n", self.stiction_n))
            .or_else(|| not_positive("stribeck_velocity_m_per_s", self.stribeck_velocity_m_per_s))
            .or_else(|| {
                (self.stiction_n < self.coulomb_n)
                    .then(|| format!("stiction_n = {} below coulomb_n = {}", self.stiction_n, self.coulomb_n))
            })
    }

    fn alter(&self, constants: &mut Constants) {
        constants.coulomb = self.coulomb_n;
    }

    #[inline]
    fn resistance(&self, _direction: f64, speed: f64) -> f64 {
        let ratio = speed / self.stribeck_velocity_m_per_s;
        self.coulomb_n + (self.stiction_n - self.coulomb_n) * (-ratio * ratio).exp()
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.coulomb, constants.coulomb, f64::NAN]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let direction = screen.directions();
        let own = screen.constants.as_ref().map_or(0.0, |c| c.coulomb);
        let fastest = screen.largest_speed();
        [0.01, 0.03, 0.1, 0.3]
            .into_iter()
            .map(|share| {
                let slow = share * fastest;
                let decay: Vec<f64> = screen
                    .velocity
                    .iter()
                    .zip(&direction)
                    .map(|(v, s)| s * (-(v / slow).powi(2)).exp())
                    .collect();
                let ones = vec![1.0; decay.len()];
                let columns =
                    [screen.acceleration.clone(), screen.velocity.clone(), direction.clone(), ones, decay];
                let (coulomb, excess) = match screen.regress(&columns).as_deref() {
                    Some([_, _, sign, _, extra]) => (own - sign, -extra),
                    _ => (own + 0.05 * screen.largest_force, 0.02 * screen.largest_force),
                };
                let coulomb = coulomb.clamp(0.0, screen.largest_force);
                let stiction = coulomb + excess.clamp(0.01 * coulomb, screen.largest_force);
                vec![coulomb, stiction, slow]
            })
            .collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let (force, speed) = (screen.largest_force, screen.largest_speed());
        vec![(0.0, force), (0.0, force), (1e-3 * speed, speed)]
    }
}
