//! Lost motion between motor and load.

use super::{Estimate, Screen};
use crate::effect::Backlash;

impl Estimate for Backlash {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        if let Some(gap) = screen.lost_motion() {
            return vec![vec![gap.max(1e-6 * screen.travel()), 0.0]];
        }
        [1e-4, 1e-3, 5e-3, 0.03].iter().map(|share| vec![share * screen.travel(), 0.0]).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        // One sensor alone does not tell a play that drags from bristles.
        let sees_both_ends = screen.constants.as_ref().is_some_and(|c| c.sees_both_ends);
        vec![(0.0, 0.3 * screen.travel()), (0.0, if sees_both_ends { 1.0 } else { 0.0 })]
    }
}
