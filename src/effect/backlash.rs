//! Lost motion between motor and load.

use super::law::negative;
use super::prior::{Machinery, Prior};
use super::unlike::Unlike;
use super::{Constants, Door, Lack, Law, Likeness, Nominal, Parameter, Site, Stretch};
use crate::units::Motion;
use serde::{Deserialize, Serialize};

/// A minute of arc in rad.
const ARCMIN: f64 = std::f64::consts::TAU / 21600.0;

/// Backlash (lost motion): after a reversal the motor travels the gap before the load follows.
///
/// # Model
/// Kinematic play of width b between the motor's end of the drive train q and the load x:
/// ```text
///   x stays while |q − x| < b/2, else x = q ∓ b/2
///   dx = κ·dq inside the gap, where the play drags
/// ```
/// A run begins where the motor stands anywhere in the gap, β·b/2 ahead of its middle (−1 ≤ β ≤ 1); a diagnosis finds β for each run that does not
/// state it. A play drags with grease, a seal or a preloaded ball: the load is then carried along by a
/// share κ of the motor's travel while the gap is crossed.
///
/// # Validity
/// The load is held by its own friction while the gap is crossed, and its inertia is small against the motor's: reversal
/// error as ISO 230-2 measures it, not rattling. κ is looked for where both ends of the drive train have their own sensor.
///
/// # Prior
/// b of 1 to 300 µm, log-uniform: from a preloaded ball screw to a worn trapezoidal one or a rack; on a revolute axis 1 to 10
/// arcmin (0.29 to 2.9 mrad), log-uniform: gearboxes. κ = 0. Catalogues of ball screws and of planetary gearboxes; ISO 230-2
/// measures it.
///
/// # Source
/// ISO 230-2; play operator, Krasnosel'skii, Pokrovskii (1989).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// b in m, or rad for a revolute axis; not negative.
    #[serde(alias = "width_rad")]
    pub width_m: f64,
    /// κ, from 0 (the load stays) to 1 (it follows as if there were no play).
    #[serde(default)]
    pub carried_share: f64,
    /// β, where a run begins, from −1 (the load lies at the stop that pushes it backward) to 1 (at the one that pushes it forward).
    #[serde(default)]
    pub initial_share: f64,
}

impl Law for Backlash {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "backlash between motor and load";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::length("width_m", "width_rad").not_negative(),
        Parameter::same("carried_share", "1").within(0.0, 1.0),
    ];
    const DOORS: &'static [Door] = &[Door::Transmission];

    fn fault(&self) -> Option<String> {
        let (share, begin) = (self.carried_share, self.initial_share);
        negative("width_m", self.width_m)
            .or_else(|| {
                let outside = !(0.0..=1.0).contains(&share);
                outside.then(|| format!("carried_share = {share}, expected 0 to 1"))
            })
            .or_else(|| {
                let outside = !(-1.0..=1.0).contains(&begin);
                outside.then(|| format!("initial_share = {begin}, expected -1 to 1"))
            })
    }

    #[inline]
    fn stops(&self, [rear, front]: [f64; 2]) -> [f64; 2] {
        [rear - 0.5 * self.width_m, front + 0.5 * self.width_m]
    }

    #[inline]
    fn carried(&self) -> f64 {
        self.carried_share
    }

    fn initial_share(&self) -> f64 {
        self.initial_share
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![0.0, 0.0]
    }

    const STRETCH: Stretch = Stretch::Mechanics;

    fn lacks(constants: &Constants) -> Option<Lack> {
        (!constants.sees_load).then_some(Lack::LoadUnseen)
    }

    const EQUATION: &'static str =
        "x stays while |q − x| < b/2, else x = q ∓ b/2\ndx = κ·dq inside the gap, where the play drags";
    const SYMBOLS: &'static [&'static str] = &["b", "κ"];
    const SOURCE: &'static str = "ISO 230-2; play operator, Krasnosel'skii, Pokrovskii (1989)";
    const SHOWN_BY: &'static str = "Load position that stands still after a reversal while the motor moves on: reversals at several places.";
    const EXAMPLE: &'static [f64] = &[2e-5, 0.0];
    const CONFUSABLE: &'static [Likeness] = &[];

    fn draw(machine: &Machinery, prior: &mut Prior) -> Vec<f64> {
        let width = match machine.motion {
            Motion::Prismatic => prior.log_uniform(1e-6, 300e-6),
            Motion::Revolute => prior.log_uniform(1.0, 10.0) * ARCMIN,
        };
        vec![width, 0.0]
    }

    fn unlike(&self) -> Unlike {
        Unlike::Nothing
    }

    const NOMINAL: Option<Nominal> = None;
}
