//! The probabilities that a verdict states, and whether what they are of is true.

use crate::trial::truth::HiddenEffect;
use crate::trial::verdict::Said;
use serde::Serialize;
use std::collections::BTreeMap;

/// Least probability of an effect that counts as a statement where it is not named.
const STATED: f64 = 0.05;

/// A probability that a verdict stated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Statement {
    /// The effect; of effects that nobody could tell apart, the hidden one.
    pub effect: String,
    /// Its stated probability.
    pub probability: f64,
    /// Whether it is hidden.
    pub is_true: bool,
}

/// The statements of a verdict.
///
/// # Model
/// Every named cause and every effect with a probability of at least 0.05 is a statement. It is true where the effect is hidden, at
/// any size, or is the equal of a hidden one. A hidden effect and its equals are one statement, with the sum of their
/// probabilities: how it is shared among them, nobody could know. In the tier of changes, what is hidden before and after alike
/// is no statement.
pub(super) fn statements(hidden: &[&HiddenEffect], before: &[HiddenEffect], said: &Said) -> Vec<Statement> {
    let own = |name: &str| hidden.iter().find(|h| h.effect.name() == name);
    let equal = |name: &str| hidden.iter().find(|h| h.is_called(name));
    let mut stated: BTreeMap<String, (f64, bool, bool)> = BTreeMap::new();
    for (name, probability, is_cause) in spoken(said) {
        let truth = own(name).or_else(|| equal(name)).map(|h| h.effect.name());
        if truth.is_none() && before.iter().any(|h| h.is_called(name)) {
            continue;
        }
        let entry = stated.entry(truth.unwrap_or(name).to_owned()).or_insert((0.0, false, truth.is_some()));
        *entry = (entry.0 + probability, entry.1 || is_cause, entry.2);
    }
    stated
        .into_iter()
        .filter(|(_, (probability, is_cause, _))| *is_cause || *probability >= STATED)
        .map(|(effect, (sum, _, is_true))| Statement { effect, probability: sum.clamp(0.0, 1.0), is_true })
        .collect()
}

/// Every effect that has a probability, once: a cause's own counts.
fn spoken(said: &Said) -> impl Iterator<Item = (&str, f64, bool)> {
    let causes = said.causes().iter().map(|cause| (cause.effect.as_str(), cause.probability, true));
    let is_cause = |name: &str| said.causes().iter().any(|cause| cause.effect == name);
    let rest = said.effects().iter().filter(move |e| !is_cause(&e.effect));
    causes.chain(rest.map(|e| (e.effect.as_str(), e.probability, false)))
}
