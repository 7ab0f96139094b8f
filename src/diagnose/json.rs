//! Numbers of a verdict as its JSON has them: JSON has no number that is not finite and says `null`.

use serde::{Deserialize, Deserializer};

/// A number; `null` is none.
pub fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// An interval; an end that is `null` is open.
pub fn interval<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    let [from, to]: [Option<f64>; 2] = Deserialize::deserialize(deserializer)?;
    Ok([from.unwrap_or(f64::NEG_INFINITY), to.unwrap_or(f64::INFINITY)])
}
