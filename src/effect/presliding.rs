//! Presliding friction: bristles that deflect before they slide.

use super::law::not_positive;
use super::{Constants, Door, EffectId, Law, Parameter, Screen, Site};
use crate::guide::Bristle;
use serde::{Deserialize, Serialize};

/// Presliding: dry friction as bristles that deflect by micrometres before they slide, with hysteresis.
///
/// # Model
/// Dahl's law, see [`Bristle`]: `df/dx = −σ·(1 + sgn(v)·f/F_c)`. It takes the place of Coulomb friction, which is its
/// limit for σ → ∞. The bristles start undeflected.
///
/// # Validity
/// No stiction peak; motions after which the axis has travelled many times F_c/σ look like Coulomb friction.
///
/// # Source
/// Dahl (1968), *A solid friction model*.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Presliding {
    /// F_c in N, or N·m for a revolute axis; more than zero.
    #[serde(alias = "torque_nm")]
    pub force_n: f64,
    /// σ in N/m, or N·m/rad; more than zero.
    #[serde(alias = "stiffness_nm_per_rad")]
    pub stiffness_n_per_m: f64,
}

impl Law for Presliding {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "presliding friction";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::effort("force_n", "torque_nm"),
        Parameter::differing("stiffness_n_per_m", "stiffness_nm_per_rad", "N/m", "N·m/rad"),
    ];
    // Friction in proportion to the slider loads is Coulomb friction while these do not change.
    const SUPERSEDES: &'static [EffectId] = &[EffectId::CoulombFriction, EffectId::LoadDependentFriction];
    const DOORS: &'static [Door] = &[Door::Bristle];

    fn fault(&self) -> Option<String> {
        not_positive("force_n", self.force_n)
            .or_else(|| not_positive("stiffness_n_per_m", self.stiffness_n_per_m))
    }

    fn bristle(&self) -> Option<Bristle> {
        Some(Bristle { force: self.force_n, stiffness: self.stiffness_n_per_m })
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.coulomb, f64::NAN]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let own = screen.constants.as_ref().map_or(0.0, |c| c.coulomb);
        let found = screen.four_coefficients().map_or(0.05 * screen.largest_force, |[_, _, sign, _]| -sign);
        let force = (own + found).clamp(1e-4 * screen.largest_force, screen.largest_force);
        // Deflections from those of a stiff bearing, tenths of a micrometre in a decimetre, to a fifth of a motion.
        [3e-6, 3e-5, 2e-4, 1e-3, 5e-3, 0.03, 0.2]
            .iter()
            .map(|share| vec![force, force / (share * screen.travel())])
            .collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let force = screen.largest_force;
        let stiffness = force / screen.travel();
        vec![(1e-6 * force, force), (1e-3 * stiffness, 1e6 * stiffness)]
    }
}
