//! A wave of which the second harmonic alone shows: one of half the pitch.

use super::free::Free;
use super::hypothesis::Hypothesis;
use super::thresholds::LARGELY;
use super::wald::shows;
use crate::effect::EffectId;
use nalgebra::DMatrix;

/// The values of a fit with half the pitch for each wave whose first harmonic does not show while its second one does; none where there is no
/// such wave.
///
/// # Model
/// ```text
///   a₂·sin(2·2πx/λ) + b₂·cos(2·2πx/λ) = a₂·sin(2πx/(λ/2)) + b₂·cos(2πx/(λ/2))
/// ```
/// exactly, so that a pitch whose first harmonic is nothing is told twice as long as it is. The second harmonic of the half pitch begins at zero.
///
/// # Validity
/// What shows differs from zero, whatever the twin has of the wave already.
pub(super) fn halved(hypothesis: &Hypothesis, fitted: &[f64], covariance: &DMatrix<f64>) -> Option<Vec<f64>> {
    let from_zero: Vec<Free> =
        hypothesis.free.iter().map(|free| Free { neutral: 0.0, ..free.clone() }).collect();
    let shows = |numbers: [usize; 2]| shows(numbers.to_vec(), &from_zero, fitted, covariance, 1.0);
    halved_where(hypothesis, fitted, |first, second| !shows(first) && shows(second))
}

/// The values with half the pitch for each wave whose first harmonic has less than a tenth of the power of its second one; none where there is no such wave.
///
/// A wave of twice the pitch fits as well, and its first harmonic takes up whatever else a fit leaves: it is told as the wave that it nearly is.
pub(super) fn halved_by_power(hypothesis: &Hypothesis, values: &[f64]) -> Option<Vec<f64>> {
    let power = |numbers: [usize; 2]| numbers.map(|k| values[k] * values[k]).iter().sum::<f64>();
    halved_where(hypothesis, values, |first, second| power(first) < (1.0 - LARGELY) * power(second))
}

/// The values with half the pitch for each wave of which `is_second`, given the places of both harmonics, tells that it is the second one of what is told.
fn halved_where(
    hypothesis: &Hypothesis,
    values: &[f64],
    is_second: impl Fn([usize; 2], [usize; 2]) -> bool,
) -> Option<Vec<f64>> {
    let mut halved = values.to_vec();
    for (k, period) in hypothesis.free.iter().enumerate().filter(|(_, free)| free.is_line()) {
        let Some([first, second]) = harmonics(hypothesis, period.effect) else { continue };
        let half = 0.5 * values[k];
        if half >= period.range.0 && is_second(first, second) {
            halved[k] = half;
            for (first, second) in first.into_iter().zip(second) {
                (halved[first], halved[second]) = (values[second], 0.0);
            }
        }
    }
    (halved != values).then_some(halved)
}

/// Places of sine and cosine of an effect's first and second harmonic; none of an effect without a second one.
fn harmonics(hypothesis: &Hypothesis, effect: EffectId) -> Option<[[usize; 2]; 2]> {
    let unit = hypothesis
        .free
        .iter()
        .find_map(|free| free.name.strip_prefix("sine").filter(|_| free.effect == effect))?;
    let place = |part: &str, order: &str| hypothesis.place(effect.name(), &format!("{part}{order}{unit}"));
    let of = |order: &str| Some([place("sine", order)?, place("cosine", order)?]);
    Some([of("")?, of("_2")?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::tests::hypothesis;

    /// [`halved`] of a cogging whose amplitudes have a standard error of one, where the twin has this much of the sine already.
    fn of(values: [f64; 5], stated: f64) -> Option<Vec<f64>> {
        let names = ["period_m", "sine_n", "cosine_n", "sine_2_n", "cosine_2_n"];
        let mut free = names.map(|name| number(EffectId::Cogging, name));
        (free[0].range, free[0].neutral, free[1].neutral) = ((0.01, 0.06), f64::NAN, stated);
        halved(&hypothesis(free.to_vec()), &values, &DMatrix::identity(5, 5))
    }

    /// Without a first harmonic the pitch is half; with one, or without a second, or below the shortest pitch, it is what it is.
    #[test]
    fn exact_a_second_harmonic_alone_is_half_the_pitch() {
        assert_eq!(of([0.044, 0.5, -1.0, 3.0, -24.0], 0.0), Some(vec![0.022, 3.0, -24.0, 0.0, 0.0]));
        assert_eq!(of([0.044, 5.0, -1.0, 3.0, -24.0], 0.0), None);
        assert_eq!(of([0.044, 0.5, -1.0, 0.5, 0.5], 0.0), None);
        assert_eq!(of([0.018, 0.5, -1.0, 3.0, -24.0], 0.0), None);
    }

    /// By power a first harmonic of less than a tenth is none, though it shows.
    #[test]
    fn exact_a_small_first_harmonic_is_half_the_pitch_by_power() {
        let by_power = |sine: f64| {
            let names = ["period_m", "sine_n", "cosine_n", "sine_2_n", "cosine_2_n"];
            let mut free = names.map(|name| number(EffectId::Cogging, name));
            (free[0].range, free[0].neutral) = ((0.01, 0.06), f64::NAN);
            halved_by_power(&hypothesis(free.to_vec()), &[0.044, sine, 0.0, 6.0, -8.0])
        };
        assert_eq!(by_power(3.1), Some(vec![0.022, 6.0, -8.0, 0.0, 0.0]));
        assert_eq!(by_power(3.2), None);
    }

    /// A first harmonic that the twin has already is one, though nothing of it has changed.
    #[test]
    fn exact_a_stated_first_harmonic_keeps_its_pitch() {
        assert_eq!(of([0.044, 5.0, -1.0, 3.0, -24.0], 5.0), None);
    }
}
