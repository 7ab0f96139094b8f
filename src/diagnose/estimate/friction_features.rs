//! What modifies the level of friction.

use super::{Estimate, Screen};
use crate::effect::{AsymmetricFriction, FrictionDrift, Presliding, StribeckFriction};

/// A fit starts inside of where one direction would be free of friction.
const MOST_START: f64 = 0.9;

impl Estimate for AsymmetricFriction {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let direction = screen.directions();
        let half = |wanted: f64, column: &dyn Fn(usize) -> f64| -> Vec<f64> {
            (0..direction.len()).map(|k| if direction[k] == wanted { column(k) } else { 0.0 }).collect()
        };
        let columns = [
            screen.acceleration.clone(),
            half(1.0, &|_| -1.0),
            half(-1.0, &|_| 1.0),
            half(1.0, &|k| -screen.velocity[k]),
            half(-1.0, &|k| -screen.velocity[k]),
        ];
        let coulomb = screen.constants.as_ref().map_or(0.0, |c| c.friction.coulomb);
        let share = |difference: f64, mean: f64| {
            if mean > 0.0 { (0.5 * difference / mean).clamp(-MOST_START, MOST_START) } else { 0.0 }
        };
        let guess = match screen.regress(&columns).as_deref() {
            Some([_, plus, minus, c_plus, c_minus]) => vec![
                share(plus - minus, coulomb + 0.5 * (plus + minus)),
                share(c_plus - c_minus, screen.viscous() + 0.5 * (c_plus + c_minus)),
            ],
            _ => vec![0.0, 0.0],
        };
        vec![guess]
    }

    fn range(_screen: &Screen) -> Vec<(f64, f64)> {
        vec![(-1.0, 1.0), (-1.0, 1.0)]
    }
}

/// Stiction beyond Coulomb friction to start a fit from, as shares of it.
const LEAST_EXCESS: f64 = 0.05;
const MOST_EXCESS: f64 = 3.0;
/// Stiction above so many times Coulomb friction is a Coulomb friction near zero.
const HIGHEST_PEAK: f64 = 20.0;

impl Estimate for StribeckFriction {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let direction = screen.directions();
        let own = screen.constants.as_ref().map_or(0.0, |c| c.friction.coulomb);
        let fastest = screen.largest_speed();
        [0.01, 0.03, 0.1, 0.3]
            .into_iter()
            .map(|share| {
                let slow = share * fastest;
                let decay: Vec<f64> = screen
                    .velocity
                    .iter()
                    .zip(&direction)
                    .map(|(v, s)| s * (-(v / slow).powi(2)).exp())
                    .collect();
                let ones = vec![1.0; decay.len()];
                let columns =
                    [screen.acceleration.clone(), screen.velocity.clone(), direction.clone(), ones, decay];
                let (coulomb, excess) = match screen.regress(&columns).as_deref() {
                    Some([_, _, sign, _, extra]) => (own - sign, -extra),
                    _ => (own + 0.05 * screen.largest_force, 0.02 * screen.largest_force),
                };
                let coulomb = coulomb.clamp(1e-4 * screen.largest_force, screen.largest_force);
                vec![1.0 + (excess / coulomb).clamp(LEAST_EXCESS, MOST_EXCESS), slow]
            })
            .collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let speed = screen.largest_speed();
        vec![(1.0, HIGHEST_PEAK), (1e-3 * speed, speed)]
    }
}

/// Damping ratio of the moving part on its bristles, to start a fit from.
const DAMPING_RATIO: f64 = 0.2;
/// A fit looks for damping up to this ratio on the stiffest bristles.
const MOST_DAMPING_RATIO: f64 = 2.0;

impl Estimate for Presliding {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let force = screen.coulomb().clamp(1e-4 * screen.largest_force, screen.largest_force);
        // Deflections from those of a stiff bearing, tenths of a micrometre in a decimetre, to a fifth of a motion.
        [3e-6, 3e-5, 2e-4, 1e-3, 5e-3, 0.03, 0.2]
            .iter()
            .map(|share| {
                let stiffness = force / (share * screen.travel());
                vec![stiffness, 2.0 * DAMPING_RATIO * (stiffness * screen.moving_mass()).sqrt()]
            })
            .collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let stiffness = screen.largest_force / screen.travel();
        let (least, most) = (1e-3 * stiffness, 1e6 * stiffness);
        vec![(least, most), (0.0, 2.0 * MOST_DAMPING_RATIO * (most * screen.moving_mass()).sqrt())]
    }
}

/// Growth over a session at most, as a multiple of the level at its beginning.
const MOST_GROWTH: f64 = 10.0;

impl Estimate for FrictionDrift {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let direction = screen.directions();
        let drifting: Vec<f64> = direction.iter().zip(&screen.clock_s).map(|(s, t)| s * t).collect();
        let ones = vec![1.0; direction.len()];
        let columns = [screen.acceleration.clone(), screen.velocity.clone(), direction, ones, drifting];
        let (own, stated) =
            screen.constants.as_ref().map_or((0.0, 0.0), |c| (c.friction.coulomb, c.friction.drift_per_s));
        let rate = match screen.regress(&columns).as_deref() {
            Some([_, _, sign, _, growth]) if own - sign > 0.0 => (own * stated - growth) / (own - sign),
            _ => 0.0,
        };
        let length_s = length_s(screen);
        vec![vec![rate.clamp(-0.9 / length_s, MOST_GROWTH / length_s)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let length_s = length_s(screen);
        vec![(-1.0 / length_s, MOST_GROWTH / length_s)]
    }
}

/// The session's length in s.
fn length_s(screen: &Screen) -> f64 {
    screen.clock_s.iter().fold(f64::MIN_POSITIVE, |most, t| f64::max(most, *t))
}
