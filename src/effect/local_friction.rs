//! Friction of one place of the travel.

use super::law::{infinite, not_positive};
use super::prior::{Machinery, Prior};
use super::{Constants, EffectId, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch, Unlike};
use crate::guide::Local;
use crate::units::Motion;
use serde::{Deserialize, Serialize};

/// Local friction: a worn, dirty or tight spot of the guide, or one that runs easier than the rest.
///
/// # Model
/// The level of dry friction has a bump along the travel:
/// ```text
///   local(x) = F_l·½·(1 + cos(2π·(x − x_l)/w))   for |x − x_l| < w/2, else 0
/// ```
/// F_l above zero brakes more there, below zero less; no level falls below zero. It stands by itself or beside the other
/// features of [`DryFriction`](crate::guide::DryFriction).
///
/// # Validity
/// One spot, the same in both directions. The bump is taken in the middle of each step.
///
/// # Prior
/// F_l of 0.2 to 20 % of the rated force, log-uniform; with probability one quarter, where the machine has Coulomb friction, a
/// place that runs easier: 10 to 90 % of that friction less, uniform. x_l anywhere on the travel, uniform. w of 5 to 150 mm,
/// log-uniform: a dent to the length of a slider; on a revolute axis 0.05 to 1.5 rad, a pitch of balls to a quarter of a turn. A
/// diagnosis takes w to be normal in its logarithm, with 95 % there: what is wider is friction of the whole travel.
/// Altintas et al. (2011), *Machine tool feed drives*; dimensions in catalogues of linear guides and rolling bearings.
///
/// # Source
/// Position-dependent friction of ball-screw and linear guides: Altintas, Verl, Brecher, Uriarte, Pritschow (2011), *Machine
/// tool feed drives*, CIRP Annals 60/2.
///
/// ```
/// use slideway::guide::Local;
/// let spot = Local { force: 8.0, centre: 0.05, width: 0.02 };
/// assert_eq!((spot.at(0.05), spot.at(0.06), spot.at(0.04)), (8.0, 0.0, 0.0));
/// assert!((spot.at(0.055) - 4.0).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LocalFriction {
    /// F_l in N, or N·m for a revolute axis.
    #[serde(alias = "torque_nm")]
    pub force_n: f64,
    /// x_l in m, or rad.
    #[serde(alias = "centre_rad")]
    pub centre_m: f64,
    /// w in m, or rad; more than zero.
    #[serde(alias = "width_rad")]
    pub width_m: f64,
}

/// Widths that places of a guide have, in m.
const WIDTHS_M: (f64, f64) = (0.005, 0.150);
/// The same in rad, for a revolute axis.
const WIDTHS_RAD: (f64, f64) = (0.05, 1.5);

impl Law for LocalFriction {
    const SITE: Site = Site::Guide;
    const PHRASE: &'static str = "friction of one place of the travel";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::effort("force_n", "torque_nm"),
        Parameter::length("centre_m", "centre_rad"),
        Parameter::length("width_m", "width_rad").positive().usually_between(WIDTHS_M, WIDTHS_RAD),
    ];

    fn fault(&self) -> Option<String> {
        infinite("force_n", self.force_n)
            .or_else(|| infinite("centre_m", self.centre_m))
            .or_else(|| not_positive("width_m", self.width_m))
    }

    fn alter(&self, constants: &mut Constants) {
        constants.friction.local =
            Some(Local { force: self.force_n, centre: self.centre_m, width: self.width_m });
    }

    fn neutral(constants: &Constants) -> Vec<f64> {
        match constants.friction.local {
            Some(Local { force, centre, width }) => vec![force, centre, width],
            None => vec![0.0, f64::NAN, f64::NAN],
        }
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(_constants: &Constants) -> Option<Lack> {
        None
    }

    const EQUATION: &'static str = "local(x) = F_l·½·(1 + cos(2π·(x − x_l)/w))   for |x − x_l| < w/2, else 0";
    const SYMBOLS: &'static [&'static str] = &["F_l", "x_l", "w"];
    const SOURCE: &'static str =
        "Altintas, Verl, Brecher, Uriarte, Pritschow (2011), Machine tool feed drives, CIRP Annals 60/2";
    const SHOWN_BY: &'static str = "Force that changes sign with direction at one place of the travel only: slow strokes both ways over all of it.";
    const EXAMPLE: &'static [f64] = &[8.0, 0.05, 0.02];
    const CONFUSABLE: &'static [Likeness] =
        &[Likeness::similar(EffectId::Cogging, "where the axis moves one way only")];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let easier = machine.coulomb > 0.0 && prior.chance(0.25);
        let force = if easier {
            -prior.uniform(0.1, 0.9) * machine.coulomb
        } else {
            prior.log_uniform(0.002, 0.20) * machine.rated_force
        };
        let centre = machine.travel * prior.uniform(0.0, 1.0);
        let width = match machine.motion {
            Motion::Prismatic => prior.log_uniform(WIDTHS_M.0, WIDTHS_M.1),
            Motion::Revolute => prior.log_uniform(WIDTHS_RAD.0, WIDTHS_RAD.1),
        };
        vec![force, centre, width]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Bristles
    }

    const NOMINAL: Option<Nominal> = None;
}
