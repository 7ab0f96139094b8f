//! What delays or smooths, in periods of the sampling.

use super::{Estimate, Screen};
use crate::effect::{CurrentLoop, LoopDelay, VelocityFilter};

impl Estimate for LoopDelay {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // The sum of squares over a delay may have several minima: start on either side of a few periods.
        let period = screen.sample_period_s();
        vec![vec![0.5 * period], vec![3.5 * period]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, 30.0 * screen.sample_period_s())]
    }
}

/// Bandwidths from which a fit starts, as shares of the sample rate.
const BANDWIDTH_STARTS: [f64; 4] = [0.01, 0.03, 0.1, 0.3];
/// Bandwidths that a fit may come to, as shares of the sample rate.
const BANDWIDTH_RANGE: (f64, f64) = (1e-4, 10.0);

impl Estimate for CurrentLoop {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        BANDWIDTH_STARTS.map(|share| vec![share / screen.sample_period_s()]).to_vec()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let rate = 1.0 / screen.sample_period_s();
        vec![(BANDWIDTH_RANGE.0 * rate, BANDWIDTH_RANGE.1 * rate)]
    }
}

impl Estimate for VelocityFilter {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let period = screen.sample_period_s();
        let own = screen.constants.as_ref().map_or(0.0, |c| c.velocity.time_constant_s());
        vec![vec![own], vec![own + 2.0 * period], vec![own + 8.0 * period]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, 200.0 * screen.sample_period_s())]
    }
}
