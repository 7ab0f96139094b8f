//! NOT TESTED: what an unknown cause may be beyond what the runs did.

use super::Style;
use super::layout::labelled;
use super::words::{listed, phrase};
use crate::diagnose::untested::Untested;
use crate::diagnose::verdict::Diagnosis;
use crate::units::engineering;

/// Width of the labels.
const LABEL: usize = 20;

/// The section; empty where nothing is left untested, or the cause is not asked for.
pub(super) fn section(diagnosis: &Diagnosis, style: Style) -> String {
    if diagnosis.untested.is_empty() {
        return String::new();
    }
    let mut out = style.heading("NOT TESTED", "what may act beyond what these runs did");
    for untested in &diagnosis.untested {
        out += &labelled(&limit(untested), LABEL, &words(untested), style);
    }
    out
}

/// "pitch above 17.0 mm".
pub(super) fn limit(untested: &Untested) -> String {
    format!("{} {}", untested.beyond, engineering(untested.limit, &untested.unit))
}

/// The effects and the motion that would test them.
pub(super) fn words(untested: &Untested) -> String {
    let effects: Vec<String> = untested.effects.iter().map(|effect| phrase(effect)).collect();
    format!("{}. {}", listed(&effects), untested.motion)
}
