//! A spring between moving part and base.

use super::law::{infinite, negative};
use super::sizing::{Absorbed, Drawn, Scale, Sizes, Unlike};
use super::{Constants, Door, Law, Likeness, Nominal, Parameter, Screen, Site, Stretch};
use serde::{Deserialize, Serialize};

/// A spring to a point: a cable chain, bellows, a counterbalance.
///
/// # Model
/// `F = −k·(x − x_0)` on the moving part, x the axis coordinate.
///
/// # Validity
/// Linear over the travel, no hysteresis. On a travel that is short against |x − x_0| it is a constant force.
///
/// # Source
/// Hooke's law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    const PHRASE: &'static str = "a spring to a point";
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

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let (middle, travel) = (screen.middle(), screen.travel());
        let ones = vec![1.0; screen.missing_force.len()];
        let columns = [
            screen.acceleration.clone(),
            screen.velocity.clone(),
            screen.directions(),
            screen.position.clone(),
            ones,
        ];
        let guess = match screen.regress(&columns).as_deref() {
            Some([.., slope, constant]) if *slope < 0.0 => {
                let centre = (-constant / slope).clamp(middle - 20.0 * travel, middle + 20.0 * travel);
                vec![-slope, centre]
            }
            _ => vec![0.01 * screen.largest_force / travel, middle],
        };
        vec![guess]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let (middle, travel) = (screen.middle(), screen.travel());
        vec![(0.0, 10.0 * screen.largest_force / travel), (middle - 30.0 * travel, middle + 30.0 * travel)]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<&'static str> {
        None
    }

    const EQUATION: &'static str = "F = −k·(x − x_0)";
    const SYMBOLS: &'static [&'static str] = &["k", "x_0"];
    const SOURCE: &'static str = "Hooke's law";
    const SHOWN_BY: &'static str =
        "Motor force that changes in proportion to position: slow strokes over the whole travel, both ways.";
    const EXAMPLE: &'static [f64] = &[400.0, 0.02];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn sizes(scale: &Scale, _absorbed: &Absorbed, drawn: Drawn) -> Sizes {
        let (force, stroke) = (scale.force, scale.stroke);
        let centre = stroke * drawn.share[0];
        Sizes::new((1e-6, 0.5), move |s| vec![s * force / stroke.abs(), centre])
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
