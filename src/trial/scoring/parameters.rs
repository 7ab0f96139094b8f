//! Fitted parameters against those that were hidden.

use crate::diagnose::verdict::Parameter;
use crate::trial::truth::HiddenEffect;
use crate::trial::verdict::Said;
use std::collections::BTreeMap;

/// What the parameters of one hidden effect came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Compared {
    /// Largest error, as a share of the largest parameter of the same unit.
    pub(super) error: f64,
    /// Number of 95 % intervals that hold the truth.
    pub(super) covered: usize,
    /// Of how many.
    pub(super) of: usize,
}

impl Compared {
    /// Both together: the larger error, all intervals.
    pub(super) fn with(self, other: Self) -> Self {
        Self {
            error: self.error.max(other.error),
            covered: self.covered + other.covered,
            of: self.of + other.of,
        }
    }
}

/// Compares the parameters of a hidden effect; none where it is not named by its own name, or has none.
pub(super) fn compared(hidden: &HiddenEffect, said: &Said) -> Option<Compared> {
    let cause = said.causes().iter().find(|cause| cause.effect == hidden.effect.name())?;
    let largest = largest(hidden);
    let one = |(key, truth): (&String, &f64)| {
        let number = cause.parameters.get(key)?;
        let scale = largest.get(unit(hidden, key)).copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
        let error = (number.value - truth).abs() / scale;
        Some(Compared { error, covered: usize::from(holds(number, *truth)), of: 1 })
    };
    hidden.parameters.iter().filter_map(one).reduce(Compared::with)
}

/// Largest hidden number of each unit.
fn largest(hidden: &HiddenEffect) -> BTreeMap<&'static str, f64> {
    let mut largest: BTreeMap<&str, f64> = BTreeMap::new();
    for (key, value) in &hidden.parameters {
        let most = largest.entry(unit(hidden, key)).or_default();
        *most = most.max(value.abs());
    }
    largest
}

fn unit(hidden: &HiddenEffect, key: &str) -> &'static str {
    let parameter = hidden.effect.parameters().iter().find(|p| p.name == key || p.revolute_name == key);
    parameter.map_or("", |p| p.unit)
}

/// Whether an interval holds the truth. A number that only starts set, a resolution above all, has no width: it is right to the
/// last digits or not.
fn holds(number: &Parameter, truth: f64) -> bool {
    let rounding = 1e-9 * truth.abs();
    let [from, to] = number.ci95;
    from - rounding <= truth && truth <= to + rounding
}
