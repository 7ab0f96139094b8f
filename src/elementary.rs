//! Elementary functions for what a replay does millions of times.
//!
//! Straight-line arithmetic without a branch or a call: loops over several axes become vector instructions, and a number comes
//! out with the same bits whether it is one of eight or alone. Products and sums are rounded one by one, on every processor.
//!
//! # Validity
//! Absolute errors of a few units in the last place of 1 (of the angle, for a sine), relative ones of 10⁻¹³ of powers, checked against the library's
//! functions in the tests. What is not a number stays so; what is infinite gives the value at the end of the range.
//!
//! # Source
//! Reduction by a sum whose last place is 1: Muller (2016), *Elementary Functions*, 3rd ed., section 11.1, after Cody and Waite (1980). The series
//! are Taylor's, as long as their first term left out is below rounding.

use std::f64::consts::{LN_2, LOG2_E, SQRT_2, TAU};

/// A number of this size has a last place of 1: what is added to it is rounded to a whole number.
const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5·2⁵²
/// From where on e^(−a) is lost in the rounding of 1.
const NOTHING_BESIDE_ONE: f64 = 40.0;
/// ln 2 = LN_2_HIGH + LN_2_LOW; whole multiples of the first up to 2²⁰ are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Sine and cosine of an angle in turns.
///
/// ```
/// # use slideway::elementary::sin_cos_turns;
/// let [sine, cosine] = sin_cos_turns(1.0 / 12.0);
/// assert!((sine - 0.5).abs() < 1e-15 && (cosine - 0.75_f64.sqrt()).abs() < 1e-15);
/// ```
#[inline(always)]
pub fn sin_cos_turns(turns: f64) -> [f64; 2] {
    let shifted = 4.0 * turns + WHOLE;
    let quarter = shifted.to_bits() & 3;
    let x = TAU * (turns - 0.25 * (shifted - WHOLE));
    let y = x * x;
    let sine = x * series(y, &SINE);
    let cosine = series(y, &COSINE);
    let is_odd = quarter & 1 == 1;
    let (s, c) = if is_odd { (cosine, sine) } else { (sine, cosine) };
    [if quarter >= 2 { -s } else { s }, if quarter == 1 || quarter == 2 { -c } else { c }]
}

/// e^(−a) and 1 − e^(−a) for a ≥ 0. Beyond a = 40 both stay as they are there: the absolute error is below 10⁻¹⁷.
#[inline(always)]
pub fn decay(a: f64) -> [f64; 2] {
    // A number that is none stays one.
    let [scale, excess] = exponential(if a > NOTHING_BESIDE_ONE { -NOTHING_BESIDE_ONE } else { -a });
    [scale + scale * excess, (1.0 - scale) - scale * excess]
}

/// x^p for x ≥ 0 and p > 0, as far as e^(−x^p) depends on it: of at least 4·10⁻¹⁸, and at most e⁴.
#[inline(always)]
pub fn power(x: f64, p: f64) -> f64 {
    // e⁴ > 50.
    const HIGHEST: f64 = 4.0;
    let exponent = p * logarithm(x);
    let exponent = if exponent > HIGHEST { HIGHEST } else { exponent };
    let exponent = if exponent < -NOTHING_BESIDE_ONE { -NOTHING_BESIDE_ONE } else { exponent };
    let [scale, excess] = exponential(exponent);
    scale + scale * excess
}

/// e^x = s·(1 + q): s a power of two, q = e^r − 1 of what is left of x, |r| ≤ ½·ln 2.
#[inline(always)]
fn exponential(x: f64) -> [f64; 2] {
    let shifted = x * LOG2_E + WHOLE;
    let whole = shifted - WHOLE;
    let r = (x - whole * LN_2_HIGH) - whole * LN_2_LOW;
    // The whole number stands in the last places of the sum; it goes to the exponent's.
    let scale = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    [scale, r * series(r, &EXCESS)]
}

/// ln x for 0 < x < ∞, normal numbers.
#[inline(always)]
fn logarithm(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    // 2⁵², whose last places take the exponent.
    const EXPONENTS: f64 = 4_503_599_627_370_496.0;
    let bits = x.to_bits();
    let mantissa = f64::from_bits((bits & MANTISSA) | 1.0_f64.to_bits());
    let exponent = f64::from_bits(EXPONENTS.to_bits() | (bits >> 52)) - EXPONENTS - 1023.0;
    let is_large = mantissa > SQRT_2;
    let mantissa = if is_large { 0.5 * mantissa } else { mantissa };
    let exponent = if is_large { exponent + 1.0 } else { exponent };
    // 2·artanh((m − 1)/(m + 1)).
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    exponent * LN_2 + 2.0 * s * series(s * s, &ARTANH)
}

/// A polynomial, the coefficient of the lowest power first: Estrin's scheme in groups of four, Horner's from group to group, so that each product
/// waits for few others.
#[inline(always)]
fn series<const N: usize>(x: f64, coefficients: &[f64; N]) -> f64 {
    const TOGETHER: usize = 4;
    let square = x * x;
    let fourth = square * square;
    let four = |k: usize| {
        let of = |k: usize| if k < N { coefficients[k] } else { 0.0 };
        let low = if k + 1 < N { of(k) + of(k + 1) * x } else { of(k) };
        let high = if k + 3 < N { of(k + 2) + of(k + 3) * x } else { of(k + 2) };
        if k + 2 < N { low + high * square } else { low }
    };
    let mut k = (N - 1) / TOGETHER * TOGETHER;
    let mut sum = four(k);
    while k > 0 {
        k -= TOGETHER;
        sum = sum * fourth + four(k);
    }
    sum
}

/// 1/n!.
const fn over_factorial(n: u64) -> f64 {
    let mut product = 1_u64;
    let mut k = 2;
    while k <= n {
        product *= k;
        k += 1;
    }
    1.0 / product as f64
}

/// sin x/x by x², up to x¹⁷/17!.
const SINE: [f64; 9] = alternating(1);
/// cos x by x², up to x¹⁶/16!.
const COSINE: [f64; 9] = alternating(0);
/// (e^r − 1)/r, up to r¹³/13!.
const EXCESS: [f64; 13] = {
    let mut terms = [0.0; 13];
    let mut k = 0;
    while k < 13 {
        terms[k] = over_factorial(k as u64 + 1);
        k += 1;
    }
    terms
};
/// artanh s/s by s², up to s²⁰/21.
const ARTANH: [f64; 11] = {
    let mut terms = [0.0; 11];
    let mut k = 0;
    while k < 11 {
        terms[k] = 1.0 / (2 * k + 1) as f64;
        k += 1;
    }
    terms
};

/// (−1)^k/(2k + first)! for k = 0 … 8.
const fn alternating(first: u64) -> [f64; 9] {
    let mut terms = [0.0; 9];
    let mut k = 0;
    while k < 9 {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        terms[k] = sign * over_factorial(2 * k as u64 + first);
        k += 1;
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: f64 = f64::EPSILON;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Against the library's, of the angle itself: both round the product with 2π, hence the error that grows with the angle.
        #[test]
        fn exact_sine_and_cosine_are_those_of_the_angle(turns in -50.0..50.0_f64) {
            let [s, c] = sin_cos_turns(turns);
            let (sine, cosine) = (TAU * turns).sin_cos();
            let error = 2.0 * UNIT + UNIT * TAU * turns.abs();
            prop_assert!((s - sine).abs() < error && (c - cosine).abs() < error, "{s} {sine} {c} {cosine}");
        }

        #[test]
        fn exact_decay_is_that_of_the_library(exponent in -30.0..3.0_f64) {
            let a = 10.0_f64.powf(exponent);
            let [left, fallen] = decay(a);
            let is_near = (left / (-a).exp() - 1.0).abs() < 4.0 * UNIT;
            prop_assert!(if a > NOTHING_BESIDE_ONE { left < 1e-17 } else { is_near }, "{a}: {left}");
            prop_assert!((fallen / -(-a).exp_m1() - 1.0).abs() < 4.0 * UNIT, "{a}: {fallen}");
        }

        #[test]
        fn exact_powers_are_those_of_the_library(exponent in -12.0..6.0_f64, p in 0.2..6.0_f64) {
            let x = 10.0_f64.powf(exponent);
            let (own, expected) = (power(x, p), x.powf(p));
            let is_near = (own / expected - 1.0).abs() < 1e-13;
            prop_assert!(is_near || (expected > 50.0 && own > 50.0) || (expected < 1e-17 && own < 1e-17), "{x} {p}: {own}");
        }
    }

    /// At the places where one piece goes over into the next.
    #[test]
    fn exact_whole_quarters_and_the_ends_of_the_range() {
        for quarter in -9..9 {
            let [s, c] = sin_cos_turns(0.25 * f64::from(quarter));
            let (sine, cosine) = (0.25 * TAU * f64::from(quarter)).sin_cos();
            assert_eq!([s, c], [sine.round(), cosine.round()]);
            for beside in [-1e-9, 0.125, -0.125, 0.125 + 1e-12] {
                let turns = 0.25 * f64::from(quarter) + beside;
                let ([s, c], (sine, cosine)) = (sin_cos_turns(turns), (TAU * turns).sin_cos());
                assert!((s - sine).abs() < 1e-14 && (c - cosine).abs() < 1e-14, "{turns}");
            }
        }
        assert_eq!(decay(0.0), [1.0, 0.0]);
        let [left, fallen] = decay(f64::INFINITY);
        assert!(left < 1e-17 && fallen == 1.0);
        assert!(power(0.0, 2.0) < 1e-17 && power(f64::INFINITY, 0.5) > 50.0);
        assert!(decay(f64::NAN)[1].is_nan() && sin_cos_turns(f64::NAN)[0].is_nan());
    }
}
