//! The velocity estimates that a drive may compute, along logged positions.

use crate::sensor::{VelocityEstimate, VelocityMemory};

/// Time constants that are tried, in sample periods, before the best of them is refined.
const TIME_CONSTANTS: [f64; 7] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Time constants after which an estimate has forgotten how it began.
const FORGOTTEN: f64 = 12.0;

/// The estimates that are tried first.
pub fn candidates(period_s: f64) -> Vec<VelocityEstimate> {
    let taps = |taps: &[f64]| VelocityEstimate::Taps { taps: taps.to_vec(), time_constant_s: 0.0 };
    let mut all = vec![
        VelocityEstimate::SmoothedDifference { time_constant_s: 0.0 },
        taps(&[0.5, 0.0, -0.5]),
        taps(&[0.3, 0.1, -0.1, -0.3]),
    ];
    let smoothed =
        |periods: &f64| VelocityEstimate::SmoothedDifference { time_constant_s: periods * period_s };
    all.extend(TIME_CONSTANTS.iter().map(smoothed));
    all
}

/// The smoothing near a first one at which the cost is least, by golden section over its logarithm.
pub fn refined(
    first: &VelocityEstimate,
    steps: usize,
    cost: impl Fn(&VelocityEstimate) -> f64,
) -> VelocityEstimate {
    let VelocityEstimate::SmoothedDifference { time_constant_s } = first else { return first.clone() };
    if *time_constant_s <= 0.0 {
        return first.clone();
    }
    let at = |log: f64| VelocityEstimate::SmoothedDifference { time_constant_s: time_constant_s * log.exp() };
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (-std::f64::consts::LN_2, std::f64::consts::LN_2);
    let [mut a, mut b] = [high - golden * (high - low), low + golden * (high - low)];
    let [mut cost_a, mut cost_b] = [cost(&at(a)), cost(&at(b))];
    for _ in 0..steps {
        if cost_a < cost_b {
            (high, b, cost_b) = (b, a, cost_a);
            a = high - golden * (high - low);
            cost_a = cost(&at(a));
        } else {
            (low, a, cost_a) = (a, b, cost_b);
            b = low + golden * (high - low);
            cost_b = cost(&at(b));
        }
    }
    at(0.5 * (low + high))
}

/// The estimate along positions.
pub fn along(estimate: &VelocityEstimate, position: &[f64], period_s: f64) -> Vec<f64> {
    let first = position.first().copied().unwrap_or_default();
    let mut memory = VelocityMemory::moving(first, 0.0, period_s);
    position.iter().map(|x| estimate.update(&mut memory, *x, period_s)).collect()
}

/// Samples after which it no longer shows how it was begun.
pub fn forgets(estimate: &VelocityEstimate, period_s: f64) -> usize {
    (FORGOTTEN * (1.0 + estimate.time_constant_s() / period_s)).ceil() as usize
}
