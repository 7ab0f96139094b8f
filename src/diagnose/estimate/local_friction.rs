//! Friction of one place of the travel.

use super::{Estimate, Screen};
use crate::effect::LocalFriction;
use crate::guide::Local;

/// Centres and widths tried along the travel, the widths as shares of it: a run may see no more than the top of a spot, or a flank.
const CENTRES: usize = 25;
const WIDTHS: [f64; 6] = [0.1, 0.2, 0.4, 0.7, 1.4, 3.0];
/// Starts of a fit.
const STARTS: usize = 3;
/// A spot that explains less than this share of what drag, friction and mass leave of the missing force is none to start from.
const LEAST_SHARE: f64 = 0.02;
/// Narrower than this share of the travel no fit looks.
const NARROWEST: f64 = 5e-3;
/// Wider than so many times the travel no fit looks beside other dry friction: over the travel a bump in its middle changes by sin²(π/20) then, 2.5 % of itself, and
/// is Coulomb friction.
const WIDEST: f64 = 10.0;
/// The same where the guide has no other dry friction: a bump in the middle of the travel falls to half of itself at its ends then. What is wider is friction
/// of the whole guide, which that of one place comes on top of.
const WIDEST_ALONE: f64 = 2.0;

impl Estimate for LocalFriction {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let Some(beside) = screen.beside_base() else { return Vec::new() };
        let (direction, travel) = (screen.directions(), screen.travel());
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        for width in WIDTHS.map(|share| share * travel) {
            let span = travel + 0.5 * width;
            for k in 0..CENTRES {
                let centre = screen.middle() + ((k as f64 + 0.5) / CENTRES as f64 - 0.5) * span;
                let column = |k: usize| -direction[k] * Local::shape((screen.position[k] - centre) / width);
                found.extend(beside.explain(column).map(|(force, gain)| (gain, vec![force, centre, width])));
            }
        }
        found.retain(|(gain, _)| *gain > LEAST_SHARE * beside.left());
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut starts: Vec<Vec<f64>> = Vec::new();
        for (_, start) in found {
            // One start a place: neighbours lead to the same minimum.
            if starts.iter().all(|other| (other[1] - start[1]).abs() > 0.25 * (other[2] + start[2])) {
                starts.push(start);
            }
            if starts.len() == STARTS {
                break;
            }
        }
        starts
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let (force, travel) = (screen.largest_force, screen.travel());
        let (low, high) = screen.ends();
        let widest = if screen.has_dry_friction { WIDEST } else { WIDEST_ALONE };
        // With a centre farther off the level changes about linearly along the travel: centre and width are not told apart.
        vec![(-force, force), (low - travel, high + travel), (NARROWEST * travel, widest * travel)]
    }
}
