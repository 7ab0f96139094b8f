//! A periodic error of a position: what lead errors and encoder errors have in common.

use super::Screen;
use super::periodogram::{Moment, pitches};
use std::f64::consts::TAU;

/// `s·sin φ + c·cos φ` with `φ = 2π·x/p`.
#[inline]
pub(super) fn error(period: f64, sine: f64, cosine: f64, position: f64) -> f64 {
    let (s, c) = (TAU * position / period).sin_cos();
    sine * s + cosine * c
}

/// The two columns of the error at `rate = 2π/p`.
pub(super) fn columns(rate: f64, moment: Moment) -> [f64; 2] {
    let (s, c) = (rate * moment.position).sin_cos();
    [s, c]
}

/// Starting values (pitch, s, c) from the missing force.
///
/// # Model
/// A reading `x + e(x)` makes the inverse dynamics `m·a + c·v` wrong by `m·(e″·v² + e′·a) + c·e′·v`.
pub(super) fn inverse(screen: &Screen) -> Vec<Vec<f64>> {
    let (mass, viscous) = (screen.moving_mass(), screen.viscous());
    let force = |rate: f64, m: Moment| {
        let (s, c) = (rate * m.position).sin_cos();
        let of = |slope: f64, curvature: f64| {
            mass * (curvature * m.velocity * m.velocity + slope * m.acceleration)
                + viscous * slope * m.velocity
        };
        vec![of(rate * c, -rate * rate * s), of(-rate * s, -rate * rate * c)]
    };
    let found = pitches(screen, &screen.missing_force, force, 4);
    let most = 0.05 * screen.travel();
    found
        .into_iter()
        .map(|pitch| {
            let sizes = pitch.coefficients.into_iter().map(|size| size.clamp(-most, most));
            std::iter::once(pitch.period).chain(sizes).collect()
        })
        .collect()
}
