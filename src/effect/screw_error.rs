//! Lead error of the drive train, periodic in position.

use super::law::{infinite, not_positive};
use super::reading_error::{columns, error, inverse};
use super::{Constants, Door, Law, Parameter, Screen, Site};
use serde::{Deserialize, Serialize};

/// Periodic lead error: the load runs ahead of and behind the motor once a turn of the screw.
///
/// # Model
/// `x = q + s·sin(2πq/p) + c·cos(2πq/p)` with q the motor's end of the drive train and x the load.
///
/// # Validity
/// Kinematic: small slopes, no inertia of its own. With a single sensor at the load it is exactly a periodic error of
/// that sensor; a second sensor at the motor tells them apart.
///
/// # Source
/// ISO 3408-3, travel variation within one revolution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScrewError {
    /// p in m, or rad for a revolute axis; more than zero.
    #[serde(alias = "period_rad")]
    pub period_m: f64,
    /// s in m, or rad.
    #[serde(alias = "sine_rad")]
    pub sine_m: f64,
    /// c in m, or rad.
    #[serde(alias = "cosine_rad")]
    pub cosine_m: f64,
}

impl Law for ScrewError {
    const SITE: Site = Site::Structure;
    const PHRASE: &'static str = "a lead error that repeats along the axis";
    const PARAMETERS: &'static [Parameter] = &[
        Parameter::length("period_m", "period_rad"),
        Parameter::length("sine_m", "sine_rad"),
        Parameter::length("cosine_m", "cosine_rad"),
    ];
    const DOORS: &'static [Door] = &[Door::Transmission];

    fn applies(constants: &Constants) -> bool {
        constants.sees_load
    }

    fn fault(&self) -> Option<String> {
        not_positive("period_m", self.period_m)
            .or_else(|| infinite("sine_m", self.sine_m))
            .or_else(|| infinite("cosine_m", self.cosine_m))
    }

    #[inline]
    fn transmit(&self, position: f64, _memory: f64) -> f64 {
        position + error(self.period_m, self.sine_m, self.cosine_m, position)
    }

    fn neutral(_constants: &Constants) -> Vec<f64> {
        vec![f64::NAN, 0.0, 0.0]
    }

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        if screen.load_difference.is_empty() {
            return inverse(screen);
        }
        let found =
            super::periodogram::pitches(screen, &screen.load_difference, |r, m| columns(r, m).to_vec(), 3);
        found.into_iter().map(|pitch| [vec![pitch.period], pitch.coefficients].concat()).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let most = 0.05 * screen.travel();
        [vec![screen.period_range()], vec![(-most, most); 2]].concat()
    }
}
