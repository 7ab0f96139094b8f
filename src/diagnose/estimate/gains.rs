//! Gains of the controller.

use super::{Estimate, Screen};
use crate::effect::{IntegralGain, Law, PositionGain, VelocityFeedforward, VelocityGain};

/// Factors of gains, with the range in which a fit may look for each.
macro_rules! factors {
    ($($gain:ident: $range:expr),+ $(,)?) => {
        $(impl Estimate for $gain {
            fn start(_screen: &Screen) -> Vec<Vec<f64>> {
                vec![vec![1.0]]
            }

            fn range(_screen: &Screen) -> Vec<(f64, f64)> {
                vec![$range]
            }
        })+
    };
}

factors! {
    PositionGain: (0.05, 20.0),
    VelocityGain: (0.05, 20.0),
    IntegralGain: (0.0, 20.0),
}

impl Estimate for VelocityFeedforward {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        screen.constants.as_ref().map(Self::neutral).into_iter().collect()
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(-0.5, 1.5)]
    }
}
