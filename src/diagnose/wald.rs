//! Wald's test: whether an effect's parameters differ from the twin's beyond chance.

use super::free::Free;
use super::parameter::{NORMAL_975, Parameter};
use super::thresholds::SIGNIFICANCE;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Whether an effect's parameters, at these places, differ from the twin's beyond chance, one of them or all together (Wald's test);
/// `covariance` is in units of their scales.
///
/// # Model
/// W = dᵀC⁻¹d is χ² distributed where the effect is not there, and its tail is compared with [`SIGNIFICANCE`]. A parameter that exists
/// with the effect only (a period, a frequency) was searched: the largest W of `frequencies` trials is what is seen, and the level
/// is divided by that number (Bonferroni). Half of the samples is the number of independent frequencies that a record has.
///
/// # Source
/// R. B. Davies (1987), *Hypothesis testing when a nuisance parameter is present only under the alternative*, Biometrika 74:33.
pub(super) fn shows(
    mut numbers: Vec<usize>,
    free: &[Free],
    values: &[f64],
    covariance: &DMatrix<f64>,
    frequencies: f64,
) -> bool {
    // Some have no neutral value: a period by itself changes nothing.
    let has_neutral = |k: &usize| !free[*k].neutral.is_nan();
    let trials = if numbers.iter().all(has_neutral) { 1.0 } else { frequencies.max(1.0) };
    // A number that only starts set has no interval: it tells where there is no other.
    if numbers.iter().any(|&k| !free[k].held) {
        numbers.retain(|&k| !free[k].held);
    }
    numbers.retain(has_neutral);
    let exceeds = |wald: f64, count: usize| exceeds(wald, count, trials);
    let away = |k: usize| (values[k] - free[k].neutral) / free[k].scale;
    let beyond = |k: &usize| {
        let (away, variance) = (away(*k), covariance[(*k, *k)].max(0.0));
        away != 0.0 && (variance == 0.0 || exceeds(away * away / variance, 1))
    };
    let count = numbers.len();
    if numbers.iter().any(beyond) || count < 2 {
        return numbers.iter().any(beyond);
    }
    let part = DMatrix::from_fn(count, count, |i, j| covariance[(numbers[i], numbers[j])]);
    let deviation = DVector::from_fn(count, |i, _| away(numbers[i]));
    part.cholesky().is_some_and(|factor| exceeds(deviation.dot(&factor.solve(&deviation)), count))
}

/// Whether one of the amplitudes of a wave, sine and cosine of a period that was searched among so many `frequencies`, differs from the twin's beyond chance by its stated
/// interval; see [`shows`].
pub(super) fn amplitude_shows(Parameter { value, ci95, twin, .. }: &Parameter, frequencies: f64) -> bool {
    let error = (ci95[1] - value) / NORMAL_975;
    exceeds(((value - twin) / error).powi(2), 2, frequencies.max(1.0))
}

/// The number of independent frequencies that a record of so many samples has.
pub(super) fn independent_frequencies(samples: usize) -> f64 {
    samples as f64 / 2.0
}

/// Whether χ² of so many numbers is beyond chance, where it is the largest of so many trials.
fn exceeds(wald: f64, count: usize, trials: f64) -> bool {
    ChiSquared::new(count as f64).is_ok_and(|chi| chi.sf(wald) * trials < SIGNIFICANCE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::free;
    use crate::effect::EffectId;

    fn number(name: &'static str, neutral: f64, held: bool) -> Free {
        Free { neutral, held, ..free::tests::number(EffectId::Cogging, name) }
    }

    fn all(free: &[Free]) -> Vec<usize> {
        (0..free.len()).collect()
    }

    /// Sine and cosine of a wave whose phase is unknown: neither is certain, the amplitude is. Two numbers that are uncertain
    /// by themselves and together do not show.
    #[test]
    fn exact_a_wave_shows_whose_phase_is_uncertain() {
        let free = [
            number("period_m", f64::NAN, false),
            number("sine_n", 0.0, false),
            number("cosine_n", 0.0, false),
        ];
        let shown = |trials: f64, values: [f64; 3], covariance: [f64; 9]| {
            shows(all(&free), &free, &values, &DMatrix::from_row_slice(3, 3, &covariance), trials)
        };
        // A tangent step from (3, 4) is free, a radial one known to 0.1: variances 16·0.64 and 16·0.36 across the radius.
        let turned = [1e-12, 0.0, 0.0, 0.0, 10.24, -7.68, 0.0, -7.68, 5.77];
        assert!(shown(1e4, [0.01, 3.0, 4.0], turned));
        let vague = [1e-12, 0.0, 0.0, 0.0, 10.24, 0.0, 0.0, 0.0, 5.77];
        assert!(!shown(1.0, [0.01, 3.0, 4.0], vague));
        // (3, 4) with variances 1 and 5.77: W = 11.8, seen by chance once in 360 times and surely among 10⁴ frequencies.
        let clear = [1e-12, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 5.77];
        assert!(shown(1.0, [0.01, 3.0, 4.0], clear) && !shown(1e4, [0.01, 3.0, 4.0], clear));
    }

    /// A limit that is not stated is infinitely far away; a number that only starts set says nothing beside others.
    #[test]
    fn exact_an_unstated_limit_shows_and_a_held_number_does_not() {
        let certain = DMatrix::from_diagonal_element(1, 1, 0.0);
        let limit = [number("limit_v", f64::INFINITY, false)];
        assert!(shows(all(&limit), &limit, &[3.0], &certain, 1e4));
        let held = [number("sine_n", 0.0, false), number("mode", 0.0, true)];
        let vague = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 0.0]));
        assert!(!shows(all(&held), &held, &[3.0, 1.0], &vague, 1e4));
        assert!(shows(all(&held[1..]), &held[1..], &[1.0], &DMatrix::from_element(1, 1, 0.0), 1e4));
    }

    /// One amplitude shows beyond 2.45 standard errors, √(2·ln(1/0.05)), and the largest of 10⁴ frequencies beyond 4.94.
    #[test]
    fn exact_the_largest_amplitude_of_many_frequencies_is_chance() {
        let shows = |value: f64, frequencies: f64| {
            let ci95 = [value - NORMAL_975, value + NORMAL_975];
            let amplitude = Parameter { value, ci95, unit: "N".into(), twin: 0.0 };
            amplitude_shows(&amplitude, frequencies)
        };
        assert!(!shows(2.4, 1.0) && shows(2.5, 1.0));
        // sf = exp(−W/2) of two numbers: W = 2·ln(10⁴/0.05) = 24.4.
        assert!(!shows(4.9, 1e4) && shows(5.0, 1e4));
    }
}
