//! Presliding friction: bristles that deflect before they slide.

use super::law::{beyond, is_zero, negative, not_positive, outside};
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, EffectId, FormNumber, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::guide::{Bristle, GAUSSIAN};
use serde::{Deserialize, Serialize};

/// Presliding: the dry friction of the guide stands on bristles that deflect by micrometres before they slide, with hysteresis.
///
/// # Model
/// LuGre's bristles, see [`Bristle`]: `df/dx = −σ₀·(1 + sgn(v)·f/g)` with the level g of the other dry friction, and the
/// damping `(σ₁(v)/σ₀)·df/dt`. Dry friction by itself is its limit for σ₀ → ∞. The bristles start undeflected.
///
/// The damping fades with speed, `σ₁(v) = σ₁·exp(−(v/v_d)^p)`, `v_d = e^(−λ)·g/σ₁`, with p = 2 in Olsson (1996). Which v_d and p a guide
/// has is hardly ever known; in what is published they are choices of the model. λ is free within ±ln 4 and p from 1 (exponential) to
/// 3 where bristles are stated or found, never a cause.
///
/// # Validity
/// Motions after which the axis has travelled many times g/σ₀ look as without it. Without dry friction it does nothing.
///
/// # Prior
/// The axis breaks away over 1 to 50 µm, log-uniform, on a revolute axis at the bearing's radius of 10 to 50 mm: 2e-5 to 5e-3
/// rad. σ₀ is the Coulomb friction that it modifies over that distance, σ₁ that of a damping ratio of 0.05 to 1 of the moving
/// mass on σ₀, log-uniform. Without Coulomb friction, 2 % of the rated force stands for it. Armstrong-Hélouvry, Dupont, Canudas
/// de Wit (1994), on breakaway distances; Canudas de Wit, Olsson, Åström, Lischinsky (1995), on the damping.
///
/// # Source
/// Canudas de Wit, Olsson, Åström, Lischinsky (1995), *A new model for control of systems with friction*; damping that fades with
/// speed: Olsson (1996), *Control systems with friction*.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Presliding {
    /// σ₀ in N/m, or N·m/rad; more than zero.
    #[serde(alias = "stiffness_nm_per_rad")]
    pub stiffness_n_per_m: f64,
    /// σ₁ in N·s/m, or N·m·s/rad; not negative.
    #[serde(default, alias = "damping_nm_s_per_rad")]
    pub damping_n_s_per_m: f64,
    /// λ, by which the damping fades at the velocity e^(−λ)·g/σ₁; 0 where it is not stated.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub damping_fading: f64,
    /// p, how steeply the damping fades; 2 where it is not stated.
    #[serde(default = "gaussian", skip_serializing_if = "is_gaussian")]
    pub fading_exponent: f64,
}

fn gaussian() -> f64 {
    GAUSSIAN
}

fn is_gaussian(exponent: &f64) -> bool {
    *exponent == GAUSSIAN
}

/// |λ| at most: the damping then fades before the axis moves or not at all.
const LARGEST_FADING: f64 = 10.0;
/// p from an exponential to what lets go nearly at once.
const LEAST_EXPONENT: f64 = 1.0;
const LARGEST_EXPONENT: f64 = 3.0;
/// λ at which the damping fades four times sooner or later: the tolerance.
const FOURFOLD: f64 = 2.0 * std::f64::consts::LN_2;

impl Law for Presliding {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "presliding friction";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::differing("stiffness_n_per_m", "stiffness_nm_per_rad", "N/m", "N·m/rad").positive(),
        Parameter::viscous("damping_n_s_per_m", "damping_nm_s_per_rad").not_negative(),
    ];
    const FORM: &'static [FormNumber] = &[
        FormNumber {
            parameter: Parameter::same("damping_fading", "").within(-LARGEST_FADING, LARGEST_FADING),
            usual: 0.0,
            tolerance: FOURFOLD,
        },
        FormNumber {
            parameter: Parameter::same("fading_exponent", "").within(LEAST_EXPONENT, LARGEST_EXPONENT),
            usual: GAUSSIAN,
            tolerance: GAUSSIAN - LEAST_EXPONENT,
        },
    ];
    const MODIFIES: &'static [EffectId] = &[EffectId::CoulombFriction, EffectId::LoadDependentFriction];

    fn fault(&self) -> Option<String> {
        not_positive("stiffness_n_per_m", self.stiffness_n_per_m)
            .or_else(|| negative("damping_n_s_per_m", self.damping_n_s_per_m))
            .or_else(|| beyond("damping_fading", self.damping_fading, LARGEST_FADING))
            .or_else(|| outside("fading_exponent", self.fading_exponent, LEAST_EXPONENT..=LARGEST_EXPONENT))
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.bristle = Some(Bristle {
            stiffness: self.stiffness_n_per_m,
            damping: self.damping_n_s_per_m,
            fading_factor: self.damping_fading.exp(),
            fading_exponent: self.fading_exponent,
        });
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.friction.bristle {
            Some(Bristle { stiffness, damping, .. }) => vec![stiffness, damping],
            None => vec![f64::INFINITY, 0.0],
        }
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "df/dx = −σ₀·(1 + sgn(v)·f/g)\ndamping (σ₁(v)/σ₀)·df/dt\nσ₁(v) = σ₁·exp(−(v/v_d)^p)\nv_d = e^(−λ)·g/σ₁";
    const SYMBOLS: &'static [&'static str] = &["σ₀", "σ₁", "λ", "p"];
    const SOURCE: &'static str = "Canudas de Wit, Olsson, Åström, Lischinsky (1995); Olsson (1996)";
    const SHOWN_BY: &'static str = "Force over the first micrometres after a reversal or a start: small moves, and settling after a stop.";
    const EXAMPLE: &'static [f64] = &[5e5, 600.0];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let surface = prior.log_uniform(1e-6, 50e-6);
        let stiffness = machine.friction() / prior.at_surface(surface, machine);
        let ratio = prior.log_uniform(0.05, 1.0);
        vec![stiffness, 2.0 * ratio * (stiffness * machine.constants.moving_mass).sqrt()]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_fading_beyond_its_limits_is_refused() {
        let fault = |damping_fading: f64, fading_exponent: f64| {
            let (stiffness_n_per_m, damping_n_s_per_m) = (1e6, 600.0);
            Presliding { stiffness_n_per_m, damping_n_s_per_m, damping_fading, fading_exponent }.fault()
        };
        assert_eq!([fault(10.0, 2.0), fault(-10.0, 1.0), fault(0.0, 3.0)], [None, None, None]);
        for value in [10.1, -1000.0, f64::NAN] {
            assert!(fault(value, 2.0).is_some_and(|fault| fault.contains("damping_fading")), "{value}");
        }
        for value in [0.9, 3.1, f64::NAN] {
            assert!(fault(0.0, value).is_some_and(|fault| fault.contains("fading_exponent")), "{value}");
        }
    }
}
