//! A spring between moving part and base.

use super::law::{infinite, negative};
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Door, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use serde::{Deserialize, Serialize};

/// A spring to a point: a cable chain, bellows, a counterbalance.
///
/// # Model
/// `F = −k·(x − x_0)` on the moving part, x the axis coordinate.
///
/// # Validity
/// Linear over the travel, no hysteresis. On a travel that is short against |x − x_0| it is a constant force.
///
/// # Prior
/// k takes 0.2 to 10 % of the rated force over the travel, log-uniform; x_0 anywhere on the travel, uniform. Resistances in
/// catalogues of bellows, way covers and energy chains; the bounds are an engineering estimate.
///
/// # Source
/// Hooke's law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableSpring {
    /// k in N/m, or N·m/rad for a revolute axis; not negative.
    #[serde(alias = "stiffness_nm_per_rad")]
    pub stiffness_n_per_m: f64,
    /// x_0 in m, or rad.
    #[serde(alias = "centre_rad")]
    pub centre_m: f64,
}

impl Law for CableSpring {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "a spring force (cable, hose)";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::differing("stiffness_n_per_m", "stiffness_nm_per_rad", "N/m", "N·m/rad").not_negative(),
        Parameter::length("centre_m", "centre_rad"),
    ];
    const DOORS: &'static [Door] = &[Door::Push];

    fn fault(&self) -> Option<String> {
        negative("stiffness_n_per_m", self.stiffness_n_per_m).or_else(|| infinite("centre_m", self.centre_m))
    }

    #[inline]
    fn push(&self, position: f64, _velocity: f64) -> f64 {
        -self.stiffness_n_per_m * (position - self.centre_m)
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0, f64::NAN]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "F = −k·(x − x_0)";
    const SYMBOLS: &'static [&'static str] = &["k", "x_0"];
    const SOURCE: &'static str = "Hooke's law";
    const SHOWN_BY: &'static str =
        "Motor force that changes in proportion to position: slow strokes over the whole travel, both ways.";
    const EXAMPLE: &'static [f64] = &[400.0, 0.02];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let force = prior.log_uniform(0.002, 0.10) * machine.rated_force;
        vec![force / machine.travel.abs(), machine.travel * prior.uniform(0.0, 1.0)]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
