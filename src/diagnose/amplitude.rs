//! Amplitudes of what repeats along the axis.

use super::fit::Fit;
use super::folds::Folds;
use super::hypothesis::Freedom;
use super::parameter::{NORMAL_975, Parameter};
use crate::effect::EffectId;
use std::collections::BTreeMap;

/// Amplitudes of an effect's waves, by the names of their sines: `amplitude_n` beside `sine_n` and `cosine_n`.
///
/// # Model
/// A = √(s² + c²), with the standard error of A to first order from the covariance of s and c, or from its own scatter over the
/// training runs where that is larger. Far from the zero of position the phase hangs on the period: sine and cosine by
/// themselves are uncertain then, and the amplitude is not.
pub fn amplitudes(fit: &Fit, folds: &Folds, effect: EffectId) -> BTreeMap<String, Parameter> {
    let free = &fit.hypothesis.free;
    let own = |k: &usize| free[*k].effect == effect && free[*k].freedom == Freedom::Cause;
    let sines = (0..free.len()).filter(own).filter_map(|k| Some((k, free[k].name.strip_prefix("sine")?)));
    let amplitude = |(s, rest): (usize, &str)| {
        let is_partner = |k: &usize| free[*k].name.strip_prefix("cosine") == Some(rest);
        let c = (0..free.len()).filter(own).find(is_partner)?;
        let of = |values: &[f64]| values[s].hypot(values[c]);
        let value = of(&fit.values);
        if value == 0.0 {
            return None;
        }
        let gradient = [(s, fit.values[s] / value), (c, fit.values[c] / value)];
        let half = NORMAL_975 * fit.standard_error(&gradient).max(folds.scatter(&of).unwrap_or(0.0));
        let ci95 = [(value - half).max(0.0), value + half];
        let twin = free[s].neutral.hypot(free[c].neutral);
        Some((format!("amplitude{rest}"), Parameter { value, ci95, unit: free[s].unit.to_string(), twin }))
    };
    sines.filter_map(amplitude).collect()
}
