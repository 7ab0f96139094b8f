//! Stiction that decays with speed.

use super::law::not_positive;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::guide::Stribeck;
use serde::{Deserialize, Serialize};

/// Stiction with Stribeck decay: at rest and at low speed dry friction is higher, Coulomb friction and what is in proportion to
/// load alike.
///
/// # Model
/// ```text
///   v ≠ 0:  F = −(F_c + μ·N)·(1 + (p − 1)·exp(−(v/v_s)²))·sgn(v)
///   v = 0:  F = whatever holds the axis, up to |F| ≤ p·(F_c + μ·N)
/// ```
/// with F_c of Coulomb friction and μ·N of friction in proportion to load, which it modifies: contacts of one kind, lubricated by
/// one speed. p is the ratio of stiction to dry friction in motion. Positive force acts along positive position.
///
/// # Validity
/// Static: no memory of how long the axis stood. At speeds well above v_s it does nothing.
///
/// # Prior
/// p of 1.1 to 2, uniform; v_s of 1 to 30 mm/s, log-uniform, on a revolute axis at the bearing's or seal's radius of 10 to 50 mm:
/// 0.02 to 3 rad/s. Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), *A survey of models, analysis tools and compensation
/// methods for the control of machines with friction*; Canudas de Wit, Olsson, Åström, Lischinsky (1995).
///
/// # Source
/// Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), eq. 5, exponent 2. On the part of the load: Duclusaud et al., ICRA 2025, their
/// Stribeck models with load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StribeckFriction {
    /// p; at least 1.
    pub peak_ratio: f64,
    /// v_s in m/s, or rad/s; more than zero.
    #[serde(alias = "stribeck_velocity_rad_per_s")]
    pub stribeck_velocity_m_per_s: f64,
}

impl Law for StribeckFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "Stribeck friction (stiction that decays with speed)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::same("peak_ratio", "1").within(1.0, f64::INFINITY),
        Parameter::differing("stribeck_velocity_m_per_s", "stribeck_velocity_rad_per_s", "m/s", "rad/s")
            .positive(),
    ];
    const MODIFIES: &'static [EffectId] = &[EffectId::CoulombFriction, EffectId::LoadDependentFriction];

    fn fault(&self) -> Option<String> {
        let peak = self.peak_ratio;
        let low = !(peak.is_finite() && peak >= 1.0);
        low.then(|| {
            format!("peak_ratio = {peak}, expected at least 1: stiction is not below Coulomb friction")
        })
        .or_else(|| not_positive("stribeck_velocity_m_per_s", self.stribeck_velocity_m_per_s))
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.stribeck =
            Some(Stribeck { peak_ratio: self.peak_ratio, velocity: self.stribeck_velocity_m_per_s });
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.friction.stribeck {
            Some(Stribeck { peak_ratio, velocity }) => vec![peak_ratio, velocity],
            None => vec![1.0, f64::NAN],
        }
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "v ≠ 0:  F = −(F_c + μ·N)·(1 + (p − 1)·exp(−(v/v_s)²))·sgn(v)\nv = 0:  F = whatever holds the axis, up to |F| ≤ p·(F_c + μ·N)";
    const SYMBOLS: &'static [&'static str] = &["p", "v_s"];
    const SOURCE: &'static str =
        "Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), eq. 5, exponent 2; Duclusaud et al., ICRA 2025";
    const SHOWN_BY: &'static str =
        "Friction that falls as speed rises from rest: creep, slow reversals, starts after a dwell.";
    const EXAMPLE: &'static [f64] = &[1.6, 0.01];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::Presliding, "where the axis passes standstill quickly")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let peak = prior.uniform(1.1, 2.0);
        let surface = prior.log_uniform(1e-3, 30e-3);
        vec![peak, prior.at_surface(surface, machine)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}
