//! Words for effects, signals and gaps, as every sentence and table of a report has them.

use super::number::{brief, brief_twin, plain};
use crate::diagnose::verdict::{Cause, Diagnosis, Parameter};
use crate::effect::EffectId;

/// The effect in a phrase, or its id where the catalogue does not know it.
pub(super) fn phrase(effect: &str) -> String {
    let known = EffectId::named(effect);
    known.map_or_else(|| effect.replace('_', " "), |id| id.phrase().to_owned())
}

/// Phrases of several effects together; none: the twin as it is.
pub(super) fn together(effects: &[String]) -> String {
    match effects {
        [] => "the twin as it is".to_owned(),
        effects => effects.iter().map(|effect| phrase(effect)).collect::<Vec<_>>().join(" with "),
    }
}

/// "multiples of noise".
pub(super) fn times_noise(gap: f64) -> String {
    format!("{} × noise", plain(gap))
}

/// What the twin is called that the causes are added to.
pub(super) fn baseline(diagnosis: &Diagnosis) -> &'static str {
    if diagnosis.reference.is_some() { "twin of the reference" } else { "twin as it is" }
}

/// A signal without its unit: "position", "control effort".
pub(super) fn name(key: &str) -> String {
    without_unit(key).replace('_', " ")
}

/// A key without the unit at its end.
fn without_unit(key: &str) -> &str {
    const UNITS: [&str; 21] = [
        "_nm_per_rad",
        "_n_s_per_m",
        "_nm_s_per_rad",
        "_m_per_s",
        "_rad_per_s",
        "_n_per_a",
        "_nm_per_a",
        "_n_per_m",
        "_kg_m2",
        "_kg_m",
        "_ohm",
        "_rad",
        "_nm",
        "_kg",
        "_hz",
        "_n",
        "_m",
        "_s",
        "_v",
        "_a",
        "_h",
    ];
    UNITS.iter().find_map(|unit| key.strip_suffix(unit)).filter(|rest| !rest.is_empty()).unwrap_or(key)
}

/// "Coulomb friction on the guide, 15.0 ± 0.3 N".
pub(super) fn described(cause: &Cause) -> String {
    let alone = cause.parameters.len() == 1;
    // What is nothing within its interval is left to the table, unless nothing else would be told.
    let tells = cause.told().any(|(_, parameter)| is_resolved(parameter));
    let parameters: Vec<String> = cause
        .told()
        .filter(|(_, parameter)| !tells || is_resolved(parameter))
        .map(|(key, parameter)| {
            let number = brief(parameter);
            let number = if alone { number } else { format!("{} {number}", name(key)) };
            if parameter.twin == 0.0 || !parameter.twin.is_finite() {
                number
            } else {
                format!("{number} instead of {}", brief_twin(parameter))
            }
        })
        .collect();
    let what = placed(cause);
    if parameters.is_empty() { what } else { format!("{what}, {}", parameters.join(", ")) }
}

/// "Coulomb friction on the guide"; the place is not said twice.
pub(super) fn placed(cause: &Cause) -> String {
    let (what, site) = (phrase(&cause.effect), &cause.site);
    if what.contains(site.as_str()) {
        return what;
    }
    let at = if site == "guide" { "on" } else { "in" };
    format!("{what} {at} the {site}")
}

/// Whether what the twin has lies outside the interval of what was found.
pub(super) fn is_resolved(parameter: &Parameter) -> bool {
    let [from, to] = parameter.ci95;
    !(from..=to).contains(&parameter.twin)
}

/// "a, b and c".
pub(super) fn listed(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
