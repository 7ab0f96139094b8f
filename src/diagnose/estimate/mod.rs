//! Where a fit of each effect begins and how far it looks: starting values and ranges, from one look at the motion.
//!
//! What an effect does is its law's to say, in [`effect`]; what the training runs tell of its size is said here.
//! Every law of the catalogue has an [`Estimate`], in a file with those that it shares something with. [`start`], [`range`] and
//! [`is_cumulative`] come from the lines of the catalogue, so that a law without an estimate does not compile.

mod backlash;
mod forces;
mod friction;
mod friction_features;
mod gains;
mod local_friction;
mod modes;
mod orthonormal;
mod payload;
mod periodic;
pub mod periodogram;
mod pitch_set;
pub mod reading;
pub mod relax;
pub mod resonance;
mod scales;
pub mod screening;
mod spectrum;
mod timing;
pub mod vibration;
mod voltage;
mod winding;

pub use screening::Screen;

use crate::effect::{self, EffectId, Law};

/// How the numbers of a law are estimated before a fit.
pub trait Estimate: Law {
    /// Whether the first parameter found by screening comes on top of what the twin states already.
    const CUMULATIVE: bool = false;

    /// Starting values of a fit, one set or several, from what screening found; in the order of [`Law::PARAMETERS`].
    fn start(screen: &Screen) -> Vec<Vec<f64>>;

    /// The range in which a fit may look for each parameter, in the same order.
    fn range(screen: &Screen) -> Vec<(f64, f64)>;

    /// Starting values of what it modifies, of what that modifies in turn, and last of itself, all together: from the motion of a
    /// twin that has none of them. None where each is found by itself.
    fn together(_screen: &Screen) -> Vec<Vec<Vec<f64>>> {
        Vec::new()
    }

    /// Start and range of each of [`Law::FURTHER`]; none of one that the recording does not tell. A start counts from what the
    /// twin states already.
    fn further(_screen: &Screen) -> Vec<Option<Further>> {
        Vec::new()
    }
}

/// Where a fit of a number beside an effect's parameters begins and how far it looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Further {
    /// Starting value.
    pub start: f64,
    /// Range of the fit.
    pub range: (f64, f64),
}

/// From the lines of the catalogue makes the functions that ask each law's [`Estimate`].
macro_rules! of_every_law {
    ($($id:ident : $law:ident),+ $(,)?) => {
        /// Starting values of a fit of an effect; see [`Estimate::start`].
        pub fn start(effect: EffectId, screen: &Screen) -> Vec<Vec<f64>> {
            match effect { $(EffectId::$law => <effect::$law as Estimate>::start(screen),)+ }
        }

        /// The ranges in which a fit of an effect may look; see [`Estimate::range`].
        pub fn range(effect: EffectId, screen: &Screen) -> Vec<(f64, f64)> {
            match effect { $(EffectId::$law => <effect::$law as Estimate>::range(screen),)+ }
        }

        /// Starts and ranges of the numbers beside an effect's parameters; see [`Estimate::further`].
        pub fn further(effect: EffectId, screen: &Screen) -> Vec<Option<Further>> {
            match effect { $(EffectId::$law => <effect::$law as Estimate>::further(screen),)+ }
        }

        /// Starting values of an effect together with what it modifies; see [`Estimate::together`].
        pub fn together(effect: EffectId, screen: &Screen) -> Vec<Vec<Vec<f64>>> {
            match effect { $(EffectId::$law => <effect::$law as Estimate>::together(screen),)+ }
        }

        /// See [`Estimate::CUMULATIVE`].
        pub fn is_cumulative(effect: EffectId) -> bool {
            match effect { $(EffectId::$law => <effect::$law as Estimate>::CUMULATIVE,)+ }
        }
    };
}

effect::every_law!(of_every_law);
