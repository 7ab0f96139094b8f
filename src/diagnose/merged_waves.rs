//! Waves whose pitches are not told apart: one wave whose amplitude changes along the travel.

use super::fit::Fit;
use super::free::{Free, Freedom};
use super::parameter::NORMAL_975;
use super::proposals::members;
use super::thresholds::LARGELY;
use crate::effect::{Degree, EffectId};

/// Two effects of a fit that are waves of one kind with pitches that are not told apart; none where there are none.
///
/// # Model
/// With λ₁ − λ₂ → 0 and amplitudes that grow as its inverse, two waves become one whose amplitude is linear in position:
/// ```text
///   A·sin(2πx/λ₁) − A·sin(2πx/λ₂) → −2πA·(λ₁ − λ₂)/λ²·x·cos(2πx/λ)
/// ```
/// so that a fit of two pitches follows a wave that grows along the axis. Where the 95 % interval of λ₁ − λ₂ holds zero, nothing says that there are two.
///
/// # Validity
/// Waves of one kind: of one law, or of laws that are equal on some signals. A cogging and a force ripple may well have one pitch. Pitches that differ by more than a tenth
/// are two: the interval of a difference that is as large as a pitch is no linear one.
pub(super) fn merged(fit: &Fit) -> Option<[EffectId; 2]> {
    let free = &fit.hypothesis.free;
    let is_pitch = |free: &Free| free.freedom == Freedom::Cause && free.is_period();
    let pitches: Vec<usize> = (0..free.len()).filter(|&k| is_pitch(&free[k])).collect();
    let pairs = pitches.iter().enumerate().flat_map(|(n, &a)| pitches[n + 1..].iter().map(move |&b| (a, b)));
    let apart = |&(a, b): &(usize, usize)| {
        let part = |i: usize, j: usize| free[i].scale * free[j].scale * fit.covariance[(i, j)];
        let variance = part(a, a) + part(b, b) - 2.0 * part(a, b);
        let difference = (fit.values[a] - fit.values[b]).abs();
        difference > NORMAL_975 * variance.max(0.0).sqrt()
            || difference > (1.0 - LARGELY) * fit.values[a].abs()
    };
    let mut merged =
        pairs.filter(|&(a, b)| is_one_kind(free[a].effect, free[b].effect)).filter(|pair| !apart(pair));
    merged.next().map(|(a, b)| [free[a].effect, free[b].effect])
}

/// Whether two effects are one law, or laws that are equal on some signals.
fn is_one_kind(a: EffectId, b: EffectId) -> bool {
    let is_equal = |likeness: &crate::effect::Likeness| {
        likeness.other == b && matches!(likeness.degree, Degree::Equal(_) | Degree::StandIn(_))
    };
    members(a)[0] == members(b)[0] || a.likenesses().iter().any(is_equal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::EffectSet;
    use crate::diagnose::hypothesis::tests::hypothesis;
    use nalgebra::DMatrix;

    /// Pitches of which each has a standard error of 10 µm and their difference one of 1.41 µm.
    fn fit(effects: [EffectId; 2], pitches: [f64; 2]) -> Fit {
        let free =
            effects.map(|effect| Free { neutral: f64::NAN, scale: 1e-5, ..number(effect, "period_m") });
        Fit {
            hypothesis: hypothesis(free.to_vec()),
            values: pitches.to_vec(),
            size: 0.0,
            mean_square: 0.0,
            standard_errors: vec![1e-5; 2],
            covariance: DMatrix::from_row_slice(2, 2, &[1.0, 0.99, 0.99, 1.0]),
            shown: EffectSet::new(),
        }
    }

    /// 1.96 standard errors of the difference are 2.77 µm.
    #[test]
    fn exact_pitches_are_apart_beyond_the_interval_of_their_difference() {
        let two = [EffectId::Cogging, EffectId::SecondCogging];
        let of = |difference: f64| merged(&fit(two, [0.03, 0.03 + difference]));
        assert_eq!([of(2.7e-6), of(-2.7e-6), of(2.9e-6)], [Some(two), Some(two), None]);
        let wide = |difference: f64| {
            let fit = fit(two, [0.03, 0.03 + difference]);
            merged(&Fit { covariance: 1e8 * fit.covariance.clone(), ..fit })
        };
        assert_eq!([wide(2.9e-3), wide(3.1e-3)], [Some(two), None]);
    }

    /// An error of the screw and one of the encoder are one kind; a cogging and a ripple are not.
    #[test]
    fn exact_only_waves_of_one_kind_are_merged() {
        let screw = [EffectId::ScrewError, EffectId::EncoderPeriodicError];
        assert_eq!(merged(&fit(screw, [0.002; 2])), Some(screw));
        assert_eq!(merged(&fit([EffectId::Cogging, EffectId::ForceRipple], [0.03; 2])), None);
    }
}
