//! Factors of what a machine file states.

use super::{Estimate, Screen};
use crate::effect::{EncoderScale, ForceConstant, SensorScale};

impl Estimate for ForceConstant {
    fn start(_screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![1.0]]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.2, 5.0)]
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
