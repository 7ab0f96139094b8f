//! A constant force, and a spring to a point.

use super::{Estimate, Screen};
use crate::effect::{CableSpring, ConstantForce};

impl Estimate for ConstantForce {
    const CUMULATIVE: bool = true;

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![screen.four_coefficients().map_or(0.0, |[.., constant]| -constant)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(-screen.largest_force, screen.largest_force)]
    }
}

impl Estimate for CableSpring {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let (middle, travel) = (screen.middle(), screen.travel());
        let ones = vec![1.0; screen.missing_force.len()];
        let columns = [
            screen.acceleration.clone(),
            screen.velocity.clone(),
            screen.directions(),
            screen.position.clone(),
            ones,
        ];
        let guess = match screen.regress(&columns).as_deref() {
            Some([.., slope, constant]) if *slope < 0.0 => {
                let centre = (-constant / slope).clamp(middle - 20.0 * travel, middle + 20.0 * travel);
                vec![-slope, centre]
            }
            _ => vec![0.01 * screen.largest_force / travel, middle],
        };
        vec![guess]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let (middle, travel) = (screen.middle(), screen.travel());
        vec![(0.0, 10.0 * screen.largest_force / travel), (middle - 30.0 * travel, middle + 30.0 * travel)]
    }
}
