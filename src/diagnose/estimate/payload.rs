//! The moving mass.

use super::{Estimate, Screen};
use crate::effect::Payload;

impl Estimate for Payload {
    const CUMULATIVE: bool = true;

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // The missing force contains −Δm·a.
        let mass = screen.moving_mass();
        let change = screen.four_coefficients().map_or(0.0, |[acceleration, ..]| -acceleration);
        vec![vec![change.clamp(-0.8 * mass, 20.0 * mass)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let mass = screen.moving_mass();
        vec![(-0.9 * mass, 30.0 * mass)]
    }
}
