//! Factors of what a machine file states.

use super::{Estimate, Screen};
use crate::effect::{EncoderScale, EncoderZero, ForceConstant, ForceSaturation, SensorScale};

impl Estimate for ForceConstant {
    fn start(_screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![1.0]]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.2, 5.0)]
    }
}

/// Shares of the largest force that are lost, to start a fit from: over the range of the law's prior.
const LOST: [f64; 3] = [0.02, 0.1, 0.3];
/// Share of the largest force that a fit may come to lose: more than twice the most of the law's prior.
const MOST_LOST: f64 = 0.9;

/// Saturation at which this share of the largest force in proportion to current is lost.
fn saturation(screen: &Screen, lost: f64) -> f64 {
    lost / (1.0 - lost) / screen.largest_force.max(f64::MIN_POSITIVE)
}

impl Estimate for ForceSaturation {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        LOST.iter().map(|&lost| vec![saturation(screen, lost)]).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, saturation(screen, MOST_LOST))]
    }
}

impl Estimate for SensorScale {
    fn start(_screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![1.0, 1.0]]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(1e-3, 1e3); 2]
    }
}

impl Estimate for EncoderScale {
    fn start(_screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![1.0]]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.2, 5.0)]
    }
}

impl Estimate for EncoderZero {
    const CUMULATIVE: bool = true;

    fn start(_screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(-MOST_TURNED_RAD, MOST_TURNED_RAD)]
    }
}

/// Largest error of a zero that a fit may come to: more than two teeth of the coarsest spline of the law's prior.
const MOST_TURNED_RAD: f64 = 1.0;
