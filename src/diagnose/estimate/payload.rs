//! The moving mass, and where it hangs.

use super::{Estimate, Further, Screen};
use crate::effect::Payload;

/// A payload may weigh so many times the largest motor effort of the runs: it falls and swings too.
const HEAVIEST: f64 = 3.0;

impl Estimate for Payload {
    const CUMULATIVE: bool = true;

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let mass = screen.moving_mass();
        let [change, _] = missing(screen).unwrap_or_default();
        vec![vec![change.clamp(-0.8 * mass, 20.0 * mass)]]
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let mass = screen.moving_mass();
        vec![(-0.9 * mass, 30.0 * mass)]
    }

    fn further(screen: &Screen) -> Vec<Option<Further>> {
        let of = |most: f64| {
            let [_, moment] = missing(screen).unwrap_or_default();
            Further { start: moment.clamp(-most, most), range: (-most, most) }
        };
        let heaviest = screen.lever_weight.map(|weight| HEAVIEST * screen.largest_force / weight.largest());
        vec![heaviest.filter(|most| most.is_finite() && *most > 0.0).map(of)]
    }
}

/// Mass or inertia, and mass times lever, that the missing force shows: it contains −Δm·a and u·w(q).
fn missing(screen: &Screen) -> Option<[f64; 2]> {
    let with_weight = screen.lever_weight.and_then(|weight| {
        let weight = screen.position.iter().map(|q| weight.effort(*q)).collect();
        let ones = vec![1.0; screen.missing_force.len()];
        let columns =
            [screen.acceleration.clone(), screen.velocity.clone(), screen.directions(), ones, weight];
        let [acceleration, .., moment] = <[f64; 5]>::try_from(screen.regress(&columns)?).ok()?;
        Some([-acceleration, moment])
    });
    with_weight.or_else(|| screen.four_coefficients().map(|[acceleration, ..]| [-acceleration, 0.0]))
}
