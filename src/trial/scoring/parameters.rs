//! Fitted parameters against those that were hidden.

use crate::diagnose::verdict::{Cause, Parameter};
use crate::effect::EffectId;
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

/// Compares the parameters of hidden effects with those of the causes that are called by their names.
pub(super) fn compared<'a>(hidden: &[&HiddenEffect], said: &'a Said) -> Vec<Option<Compared>> {
    let cause = |name: &str| said.causes().iter().find(|cause| cause.effect == name);
    let mut own: Vec<Option<&'a Cause>> = hidden.iter().map(|h| cause(h.effect.name())).collect();
    match_pitches(hidden, &mut own);
    hidden.iter().zip(own).map(|(hidden, cause)| one(hidden, cause?)).collect()
}

/// Gives the causes of one law with several pitches to the hidden effects of that law by their pitches, the closest pair first: which
/// pitch is called the first and which the second is a matter of names. Only those that are named change places.
fn match_pitches(hidden: &[&HiddenEffect], own: &mut [Option<&Cause>]) {
    let said = |cause: &Cause| cause.parameters.iter().map(|(key, n)| (key.clone(), n.value)).collect();
    let periods = |k: usize| Some((k, period(&hidden[k].parameters)?, own[k]?));
    let mut open: Vec<(usize, f64, &Cause)> = (0..hidden.len()).filter_map(periods).collect();
    let mut causes: Vec<(usize, f64, &Cause)> =
        open.iter().filter_map(|&(k, _, cause)| Some((k, period(&said(cause))?, cause))).collect();
    let law = |k: usize| first_pitch(hidden[k].effect);
    loop {
        let pairs = (0..open.len()).flat_map(|h| (0..causes.len()).map(move |c| (h, c)));
        let alike = pairs.filter(|&(h, c)| law(open[h].0) == law(causes[c].0));
        let apart = |&(h, c): &(usize, usize)| (open[h].1 / causes[c].1).ln().abs();
        let Some((h, c)) = alike.min_by(|a, b| apart(a).total_cmp(&apart(b))) else { break };
        own[open.remove(h).0] = Some(causes.remove(c).2);
    }
}

/// The pitch or period among the parameters of an effect.
fn period(parameters: &BTreeMap<String, f64>) -> Option<f64> {
    parameters.iter().find(|(key, _)| key.starts_with("period_")).map(|(_, value)| *value)
}

/// The effect whose law another one repeats with a pitch of its own; itself where there is none.
fn first_pitch(effect: EffectId) -> EffectId {
    let is_same = |of: &&EffectId| of.parameters() == effect.parameters();
    effect.modifies().iter().find(is_same).map_or(effect, |of| first_pitch(*of))
}

fn one(hidden: &HiddenEffect, cause: &Cause) -> Option<Compared> {
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
