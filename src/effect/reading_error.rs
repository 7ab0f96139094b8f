//! A periodic error of a position: what lead errors and encoder errors have in common.

use crate::elementary::sin_cos_turns;

/// `s·sin φ + c·cos φ` with `φ = 2π·x/p`.
#[inline]
pub(super) fn error(period: f64, sine: f64, cosine: f64, position: f64) -> f64 {
    let [s, c] = sin_cos_turns(position / period);
    sine * s + cosine * c
}
