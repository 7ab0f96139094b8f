//! A wave over place: four harmonics of one pitch.

use crate::elementary::sin_cos_turns;

/// Four harmonics of one pitch.
///
/// # Model
/// `s₁·sin φ + c₁·cos φ + s₂·sin 2φ + c₂·cos 2φ + A·(s₃·sin 3φ + c₃·cos 3φ + s₄·sin 4φ + c₄·cos 4φ)` with `φ = 2π·x/p` and
/// `A = √(s₁² + c₁²)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// p in m, or rad for a revolute axis; more than zero.
    pub period: f64,
    /// s₁, c₁, s₂ and c₂.
    pub own: [f64; 4],
    /// s₃, c₃, s₄ and c₄, as shares of A.
    pub higher: [f64; 4],
}

impl Wave {
    /// Its value at a position.
    #[inline]
    pub fn at(&self, position: f64) -> f64 {
        if self.higher == [0.0; 4] {
            return self.harmonics(position)[0];
        }
        self.at_each(position)
    }

    /// The same without a branch: several axes go through it together.
    #[inline(always)]
    pub fn at_each(&self, position: f64) -> f64 {
        let [law, rest] = self.harmonics(position);
        law + rest
    }

    /// The first two harmonics, and the third and fourth.
    #[inline(always)]
    fn harmonics(&self, position: f64) -> [f64; 2] {
        let [sine, cosine, sine_2, cosine_2] = self.own;
        let [sine_3, cosine_3, sine_4, cosine_4] = self.higher;
        let [s, c] = sin_cos_turns(position / self.period);
        let (double_s, double_c) = (2.0 * s * c, 1.0 - 2.0 * s * s);
        let law = sine * s + cosine * c + sine_2 * double_s + cosine_2 * double_c;
        let third = sine_3 * (double_s * c + double_c * s) + cosine_3 * (double_c * c - double_s * s);
        let fourth = sine_4 * 2.0 * double_s * double_c + cosine_4 * (1.0 - 2.0 * double_s * double_s);
        [law, (sine * sine + cosine * cosine).sqrt() * (third + fourth)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The sum of the harmonics, each by its own sine and cosine.
    #[test]
    fn exact_harmonics_are_sines_of_whole_multiples() {
        let wave = Wave { period: 0.03, own: [3.0, -4.0, 0.7, 0.2], higher: [0.03, -0.05, 0.02, 0.01] };
        for k in 0..50 {
            let x = 0.0017 * f64::from(k) - 0.04;
            let at = |order: f64, [sine, cosine]: [f64; 2]| {
                let (s, c) = (order * TAU * x / wave.period).sin_cos();
                sine * s + cosine * c
            };
            let [s3, c3, s4, c4] = wave.higher.map(|share| 5.0 * share);
            let first_two = at(1.0, [3.0, -4.0]) + at(2.0, [0.7, 0.2]);
            let sum = first_two + at(3.0, [s3, c3]) + at(4.0, [s4, c4]);
            assert!((wave.at(x) - sum).abs() < 1e-12);
            assert_eq!(wave.at_each(x), wave.at(x));
            let two = Wave { higher: [0.0; 4], ..wave };
            assert!((two.at(x) - first_two).abs() < 1e-12);
            assert_eq!(two.at_each(x), two.at(x));
        }
    }
}
