//! The level of friction.

use super::{Estimate, Screen};
use crate::effect::load_dependent_friction::HIGHEST;
use crate::effect::{CoulombFriction, LoadDependentFriction, ViscousFriction};

impl Estimate for ViscousFriction {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // The missing force contains −(c − c_stated)·v.
        let change = screen.four_coefficients().map_or(0.0, |[_, velocity, ..]| -velocity);
        vec![vec![(screen.viscous() + change).max(0.0)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, screen.viscous() + 3.0 * screen.largest_force / screen.largest_speed().max(1e-9))]
    }
}

impl Estimate for CoulombFriction {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        vec![vec![screen.coulomb().max(0.0)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, screen.largest_force)]
    }
}

/// Losses from those of a good spur gear to those of a small many-staged one that is hardly driven back, to start a fit from.
const TRANSMISSION_STARTS: [f64; 3] = [0.05, 0.2, 0.6];

impl Estimate for LoadDependentFriction {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        if !is_of_sliders(screen) {
            return TRANSMISSION_STARTS.map(|coefficient| vec![coefficient]).to_vec();
        }
        let force = screen.four_coefficients().map_or(0.05 * screen.largest_force, |[_, _, sign, _]| -sign);
        vec![vec![(force / weight(screen)).max(0.0)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let most = if is_of_sliders(screen) { screen.largest_force / weight(screen) } else { HIGHEST };
        vec![(0.0, most.min(HIGHEST))]
    }
}

fn is_of_sliders(screen: &Screen) -> bool {
    screen.constants.as_ref().is_none_or(|constants| constants.has_slider_loads)
}

/// Weight of the moving part in N, to start a fit from.
fn weight(screen: &Screen) -> f64 {
    9.81 * screen.moving_mass()
}
