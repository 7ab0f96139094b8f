//! Harmonics of a pitch: what cogging and force ripple have in common.

use super::law::{FormNumber, Parameter};
use crate::elementary::sin_cos_turns;

/// A third or fourth harmonic is this share of the first one at most, inside the tolerance: two standard deviations. Finite-element and measured spectra
/// of linear motors have a few per cent.
const TOLERANCE: f64 = 0.1;

/// The third and the fourth harmonic, as shares of the first one's amplitude.
pub(super) const HIGHER: &[FormNumber] =
    &[share("sine_3"), share("cosine_3"), share("sine_4"), share("cosine_4")];

const fn share(name: &'static str) -> FormNumber {
    FormNumber { parameter: Parameter::same(name, "1").within(-1.0, 1.0), usual: 0.0, tolerance: TOLERANCE }
}

/// `s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ + A·(s₃·sin 3φ + c₃·cos 3φ + s₄·sin 4φ + c₄·cos 4φ)` with `φ = 2π·x/p` and
/// `A = √(s₁² + c₁²)`.
#[inline]
pub(super) fn wave(
    period: f64,
    [sine, cosine, sine_2, cosine_2]: [f64; 4],
    higher: [f64; 4],
    position: f64,
) -> f64 {
    let [s, c] = sin_cos_turns(position / period);
    let (double_s, double_c) = (2.0 * s * c, 1.0 - 2.0 * s * s);
    let law = sine * s + cosine * c + sine_2 * double_s + cosine_2 * double_c;
    if higher == [0.0; 4] {
        return law;
    }
    let [sine_3, cosine_3, sine_4, cosine_4] = higher;
    let third = sine_3 * (double_s * c + double_c * s) + cosine_3 * (double_c * c - double_s * s);
    let fourth = sine_4 * 2.0 * double_s * double_c + cosine_4 * (1.0 - 2.0 * double_s * double_s);
    law + (sine * sine + cosine * cosine).sqrt() * (third + fourth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The sum of the harmonics, each by its own sine and cosine.
    #[test]
    fn exact_harmonics_are_sines_of_whole_multiples() {
        let (period, own, higher) = (0.03, [3.0, -4.0, 0.7, 0.2], [0.03, -0.05, 0.02, 0.01]);
        for k in 0..50 {
            let x = 0.0017 * f64::from(k) - 0.04;
            let at = |order: f64, [sine, cosine]: [f64; 2]| {
                let (s, c) = (order * TAU * x / period).sin_cos();
                sine * s + cosine * c
            };
            let [s3, c3, s4, c4] = higher.map(|share| 5.0 * share);
            let sum = at(1.0, [3.0, -4.0]) + at(2.0, [0.7, 0.2]) + at(3.0, [s3, c3]) + at(4.0, [s4, c4]);
            assert!((wave(period, own, higher, x) - sum).abs() < 1e-12);
        }
    }
}
