//! Friction that fades or grows over the session.

use super::law::infinite;
use super::prior::{Machinery, Prior};
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch, Unlike};
use serde::{Deserialize, Serialize};

/// Friction drift: dry friction fades while lubricant warms and spreads, or grows while a guide runs dry.
///
/// # Model
/// ```text
///   g(t) = g·(1 + r·t)
/// ```
/// g is the level of dry friction at the beginning of the session, that in proportion to load included, t the time since then;
/// g(t) never falls below zero. Friction of one place does not drift.
///
/// # Validity
/// Sessions short against the time in which friction settles: the first-order part of `1 + d·(1 − e^(−t/τ))` with r = d/τ.
/// When each run begins within the session, [`Recording::new`](crate::recording::Recording::new) says.
///
/// # Prior
/// r = d/τ: friction settles 5 to 30 % lower or higher, uniform and either sign, over a time τ of 2 to 30 min, log-uniform. It
/// fades while grease warms, and grows while a guide runs dry. Bittencourt, Gunnarsson (2012); thermal time constants of guides
/// and screws: Altintas et al. (2011), *Machine tool feed drives*.
///
/// # Source
/// First-order part of an exponential warm-up; Bittencourt, Gunnarsson (2012), *Static friction in a robot joint: modeling and
/// identification of load and temperature effects*.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionDrift {
    /// r in 1/s; below zero where friction fades.
    pub rate_per_s: f64,
}

impl Law for FrictionDrift {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "friction that drifts over the session";
    const PARAMETERS: &'static [Parameter] = &[Parameter::same("rate_per_s", "1/s")];
    const MODIFIES: &'static [EffectId] = &[EffectId::CoulombFriction, EffectId::LoadDependentFriction];

    fn fault(&self) -> Option<String> {
        infinite("rate_per_s", self.rate_per_s)
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.drift_per_s = self.rate_per_s;
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        vec![constants.friction.drift_per_s]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "g(t) = g·(1 + r·t)";
    const SYMBOLS: &'static [&'static str] = &["r"];
    const SOURCE: &'static str = "Bittencourt, Gunnarsson (2012), Static friction in a robot joint: modeling and identification of load and temperature effects";
    const SHOWN_BY: &'static str = "Friction that differs between the first and the last runs of a session: the same strokes at its beginning and end.";
    const EXAMPLE: &'static [f64] = &[0.002];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(_machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        vec![prior.sign() * prior.uniform(0.05, 0.30) / prior.log_uniform(120.0, 1800.0)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}
