//! A wave of which the second harmonic alone shows: one of half the pitch.

use super::hypothesis::{Freedom, Hypothesis};
use super::wald::shows;
use nalgebra::DMatrix;

/// The values of a fit with half the pitch for each wave whose first harmonic does not show while its second one does; none where there is no
/// such wave.
///
/// # Model
/// ```text
///   a₂·sin(2·2πx/λ) + b₂·cos(2·2πx/λ) = a₂·sin(2πx/(λ/2)) + b₂·cos(2πx/(λ/2))
/// ```
/// exactly, so that a pitch whose first harmonic is nothing is told twice as long as it is. The second harmonic of the half pitch begins at zero.
pub(super) fn halved(hypothesis: &Hypothesis, fitted: &[f64], covariance: &DMatrix<f64>) -> Option<Vec<f64>> {
    let free = &hypothesis.free;
    let shows = |numbers: [usize; 2]| shows(numbers.to_vec(), free, fitted, covariance, 1.0);
    let mut values = fitted.to_vec();
    for (k, period) in free.iter().enumerate() {
        let own = |name: &str| {
            free.iter().position(|other| {
                let is_own = other.effect == period.effect && other.freedom == Freedom::Cause;
                is_own && other.name.trim_end_matches("_nm").trim_end_matches("_n") == name
            })
        };
        let [Some(sine), Some(cosine), Some(sine_2), Some(cosine_2)] =
            ["sine", "cosine", "sine_2", "cosine_2"].map(own)
        else {
            continue;
        };
        let is_pitch = period.freedom == Freedom::Cause && period.name.starts_with("period_");
        let half = 0.5 * fitted[k];
        let is_second_alone = !shows([sine, cosine]) && shows([sine_2, cosine_2]);
        if is_pitch && half >= period.range.0 && is_second_alone {
            values[k] = half;
            for (first, second) in [(sine, sine_2), (cosine, cosine_2)] {
                (values[first], values[second]) = (fitted[second], 0.0);
            }
        }
    }
    (values != fitted).then_some(values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::{EffectSet, Free};
    use crate::effect::EffectId;

    /// [`halved`] of a cogging whose amplitudes have a standard error of one.
    fn of(values: [f64; 5]) -> Option<Vec<f64>> {
        let number = |name: &'static str| Free {
            effect: EffectId::Cogging,
            name,
            unit: "N",
            path: format!("effect.cogging.{name}"),
            freedom: Freedom::Cause,
            neutral: if name == "period_m" { f64::NAN } else { 0.0 },
            range: if name == "period_m" { (0.01, 0.06) } else { (-50.0, 50.0) },
            scale: 1.0,
            held: false,
            log_sd: None,
        };
        let hypothesis = Hypothesis {
            effects: EffectSet::from([EffectId::Cogging]),
            free: ["period_m", "sine_n", "cosine_n", "sine_2_n", "cosine_2_n"].map(number).to_vec(),
            starts: vec![],
            building: 0,
            inherited: 0,
            elsewhere: EffectSet::new(),
        };
        halved(&hypothesis, &values, &DMatrix::identity(5, 5))
    }

    /// Without a first harmonic the pitch is half; with one, or without a second, or below the shortest pitch, it is what it is.
    #[test]
    fn exact_a_second_harmonic_alone_is_half_the_pitch() {
        assert_eq!(of([0.044, 0.5, -1.0, 3.0, -24.0]), Some(vec![0.022, 3.0, -24.0, 0.0, 0.0]));
        assert_eq!(of([0.044, 5.0, -1.0, 3.0, -24.0]), None);
        assert_eq!(of([0.044, 0.5, -1.0, 0.5, 0.5]), None);
        assert_eq!(of([0.018, 0.5, -1.0, 3.0, -24.0]), None);
    }
}
