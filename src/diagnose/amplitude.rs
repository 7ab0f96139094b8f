//! Amplitudes of what repeats along the axis.

use super::fit::Fit;
use super::folds::{Folds, Uncertain};
use super::parameter::{NORMAL_975, Parameter};
use crate::effect::EffectId;
use std::collections::BTreeMap;

/// Amplitudes of an effect's waves, by the names of their sines: `amplitude_n` beside `sine_n` and `cosine_n`.
pub fn amplitudes(fit: &Fit, folds: &Folds, effect: EffectId) -> BTreeMap<String, Parameter> {
    let own = fit.hypothesis.free.iter().filter(|free| free.effect == effect);
    let suffixes = own.filter_map(|free| free.name.strip_prefix("sine"));
    let amplitude = |suffix: &str| {
        let wave = Wave { effect: effect.name(), suffix };
        Some((format!("amplitude{suffix}"), amplitude_of_sum(fit, folds, &[wave])?))
    };
    suffixes.filter_map(amplitude).collect()
}

/// One wave of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave<'a> {
    /// Name of the effect.
    pub effect: &'a str,
    /// What the names of its sine, cosine and amplitude have after these words: order and unit.
    pub suffix: &'a str,
}

/// Amplitude of the sum of waves of one period; none where that is zero or one of them is missing.
///
/// # Model
/// A = √(s² + c²) of the sums s of sines and c of cosines, with the standard error of A to first order from their covariance, or
/// from its own scatter over the training runs where that is larger. Far from the zero of position the phase hangs on the period:
/// sine and cosine by themselves are uncertain then, and the amplitude is not.
pub fn amplitude_of_sum(fit: &Fit, folds: &Folds, waves: &[Wave]) -> Option<Parameter> {
    let free = &fit.hypothesis.free;
    let places = |part: &str| -> Option<Vec<usize>> {
        let place = |wave: &Wave| fit.hypothesis.place(wave.effect, &format!("{part}{}", wave.suffix));
        waves.iter().map(place).collect()
    };
    let (sines, cosines) = (places("sine")?, places("cosine")?);
    let of = |fit: &Fit| {
        let sum = |places: &[usize]| places.iter().map(|&k| fit.values[k]).sum::<f64>();
        let (sine, cosine) = (sum(&sines), sum(&cosines));
        let value = sine.hypot(cosine);
        let slope = |part: f64| if value > 0.0 { part / value } else { 0.0 };
        let gradient = sines.iter().map(|&k| (k, slope(sine)));
        let gradient: Vec<_> = gradient.chain(cosines.iter().map(|&k| (k, slope(cosine)))).collect();
        Uncertain { value, standard_error: fit.standard_error(&gradient) }
    };
    let whole = of(fit);
    let value = whole.value;
    let half = NORMAL_975 * whole.standard_error.max(folds.scatter(whole, &of).unwrap_or(0.0));
    let neutral = |places: &[usize]| places.iter().map(|&k| free[k].neutral).sum::<f64>();
    let twin = neutral(&sines).hypot(neutral(&cosines));
    let unit = free[*sines.first()?].unit.to_string();
    (value != 0.0).then(|| Parameter { value, ci95: [(value - half).max(0.0), value + half], unit, twin })
}
