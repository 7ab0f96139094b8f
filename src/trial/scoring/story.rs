//! A case in words.

use crate::diagnose::verdict::Cause;
use crate::trial::truth::{HiddenEffect, TrueCase};
use crate::trial::verdict::Said;

/// Probable effects that a story tells.
const PROBABLE: usize = 3;

/// What was hidden and what was said.
pub(super) fn story(hidden: &[&HiddenEffect], truth: &TrueCase, said: &Said) -> String {
    format!(
        "hidden {}{}{}; said {}: {}; G {:.1} → {:.2}{}",
        effects(hidden),
        before(truth),
        missing(truth),
        said.name(),
        causes(said),
        said.gap()[0],
        said.gap()[1],
        probable(said)
    )
}

fn effects(hidden: &[&HiddenEffect]) -> String {
    let (planned, along): (Vec<&HiddenEffect>, Vec<&HiddenEffect>) = hidden.iter().partition(|h| h.planned);
    let all: Vec<String> = planned.into_iter().chain(along).map(one).collect();
    if all.is_empty() { "nothing".to_owned() } else { all.join(" and ") }
}

/// An effect with its gap; the parameters of what comes along tell little.
fn one(hidden: &HiddenEffect) -> String {
    let name = hidden.effect.name();
    if !hidden.planned {
        return format!("{name} ({:.1} σ, comes along)", hidden.gap);
    }
    let number = |(key, value): (&String, &f64)| format!("{key} {}", short(*value));
    let numbers: Vec<String> = hidden.parameters.iter().map(number).collect();
    let numbers = if numbers.is_empty() { String::new() } else { format!(": {}", numbers.join(", ")) };
    let equals: Vec<&str> = hidden.equals.iter().map(|equal| equal.name()).collect();
    let equals = if equals.is_empty() { String::new() } else { format!("; equal to {}", equals.join(", ")) };
    format!("{name} ({:.1} σ{numbers}{equals})", hidden.gap)
}

fn before(truth: &TrueCase) -> String {
    if truth.before.is_empty() {
        return String::new();
    }
    let one = |hidden: &HiddenEffect| format!("{} ({:.1} σ)", hidden.effect.name(), hidden.gap);
    let all: Vec<String> = truth.before.iter().map(one).collect();
    format!(", before and after alike {}", all.join(" and "))
}

fn missing(truth: &TrueCase) -> String {
    if truth.missing.is_empty() { String::new() } else { format!(", without {}", truth.missing.join(", ")) }
}

fn causes(said: &Said) -> String {
    let named = |cause: &Cause| match &cause.confusable_with[..] {
        [] => format!("{} {:.2}", cause.effect, cause.probability),
        others => format!("{} {:.2} or {}", cause.effect, cause.probability, others.join(", ")),
    };
    let causes: Vec<String> = said.causes().iter().map(named).collect();
    if causes.is_empty() { "no cause".to_owned() } else { causes.join(" + ") }
}

fn probable(said: &Said) -> String {
    let first = said.effects().iter().take(PROBABLE);
    let first: Vec<String> = first.map(|e| format!("{} {:.2}", e.effect, e.probability)).collect();
    if first.is_empty() { String::new() } else { format!("; most probable: {}", first.join(", ")) }
}

/// Four digits, with an exponent where that is shorter.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-2..1e4).contains(&size) { format!("{value:.4}") } else { format!("{value:.3e}") }
}
