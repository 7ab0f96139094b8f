//! Vibration from outside.

use super::spectrum::lines;
use super::{Estimate, Screen};
use crate::effect::ExternalVibration;

/// Frequencies from which a fit starts at most.
pub const STARTS: usize = 3;
/// A fit looks for the frequency from so many periods over the longest run.
const LEAST_PERIODS: f64 = 2.0;
/// A fit looks for it up to this share of the sample rate.
pub const HIGHEST: f64 = 0.4;

impl Estimate for ExternalVibration {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let lines = lines(screen, STARTS);
        lines.into_iter().map(|line| vec![line.frequency_hz, line.amplitude]).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let longest_s = screen
            .runs
            .iter()
            .map(|run| run.velocity.len() as f64 * run.period_s)
            .fold(screen.sample_period_s(), f64::max);
        let frequency = (LEAST_PERIODS / longest_s, HIGHEST / screen.sample_period_s());
        vec![frequency, (0.0, screen.largest_force)]
    }
}
