//! Bounds of the numbers in a machine file: what is refused as beyond any machine.

use crate::error::{Error, ErrorKind, Result};
use crate::units::{SMALLEST, largest};

/// What to do about a number out of its bounds.
pub(super) const CORRECT: &str = "correct the value; every key is in SI units as its name says";

/// Refuses what is not finite, or beyond any machine.
pub(super) fn finite(key: &str, value: f64) -> Result<()> {
    within(key, value, f64::NEG_INFINITY, largest(key))
}

/// Refuses what is not finite and more than zero, or beyond any machine.
pub(super) fn positive(key: &str, value: f64) -> Result<()> {
    within(key, value, SMALLEST, largest(key))
}

/// Refuses what is not finite and zero or more, or beyond any machine.
pub(super) fn zero_or_more(key: &str, value: f64) -> Result<()> {
    within(key, value, 0.0, largest(key))
}

/// Refuses what is not finite, or smaller or larger in magnitude than said.
pub(super) fn within(key: &str, value: f64, least: f64, largest: f64) -> Result<()> {
    if value >= least && value.abs() <= largest {
        return Ok(());
    }
    let low = match least {
        l if l > 0.0 => "more than zero",
        0.0 => "zero or more",
        _ => "a finite number",
    };
    Err(range(key, value, &format!("{low}, at most {largest:e}")))
}

/// The refusal of a number: not finite, or out of the range that is expected.
pub(super) fn range(key: &str, value: f64, expected: &str) -> Error {
    let kind = if value.is_finite() { ErrorKind::OutOfRange } else { ErrorKind::NotFinite };
    Error::new(kind).key(key).found(value.to_string()).expected(expected).remedy(CORRECT)
}
