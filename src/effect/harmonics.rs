//! Two harmonics of a pitch: what cogging and force ripple have in common.

use std::f64::consts::TAU;

/// `s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ` with `φ = 2π·x/p`.
#[inline]
pub(super) fn wave(period: f64, [sine, cosine, sine_2, cosine_2]: [f64; 4], position: f64) -> f64 {
    let (s, c) = (TAU * position / period).sin_cos();
    sine * s + cosine * c + 2.0 * sine_2 * s * c + cosine_2 * (1.0 - 2.0 * s * s)
}
