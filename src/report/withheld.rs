//! Why a verdict is withheld: it stands above everything else.

use super::Style;
use super::findings::sentences;
use super::layout::{Ink, paragraph};
use super::number::percent;
use super::words::{baseline, listed, placed, times_noise};
use crate::diagnose::check::Severity;
use crate::diagnose::grounds::{Veto, Withheld};
use crate::diagnose::verdict::Diagnosis;

/// Findings that are told above; the checks list them all.
const MOST: usize = 3;

/// The section; empty where the verdict is that of the evidence.
pub(super) fn section(diagnosis: &Diagnosis, style: Style) -> String {
    let Some(withheld) = &diagnosis.withheld else { return String::new() };
    let title = style.ink(Ink::Bad, &title(withheld.by).to_uppercase());
    let text: String = reasons(diagnosis, withheld).iter().map(|text| paragraph(text, style)).collect();
    format!("{title}\n{text}\n")
}

/// Every reason in a sentence or two; of the data, every fatal finding with its runs.
pub(super) fn reasons(diagnosis: &Diagnosis, withheld: &Withheld) -> Vec<String> {
    match withheld.by {
        Veto::Data => sentences(diagnosis)
            .into_iter()
            .filter(|sentence| sentence.severity == Severity::Fatal)
            .take(MOST)
            .map(|sentence| sentence.text())
            .collect(),
        Veto::Reference | Veto::Unidentified | Veto::Stretch | Veto::RigidBody => {
            vec![withheld.reason.clone()]
        }
    }
}

/// What forbids the verdict, in a few words.
pub(super) fn title(by: Veto) -> &'static str {
    match by {
        Veto::Data => "Fault in the data",
        Veto::Reference => "Reference not explained",
        Veto::Unidentified => "Explanation not identified",
        Veto::Stretch => "Contradicted by the log",
        Veto::RigidBody => "Not confirmed in the rigid-body scene",
    }
}

/// What can be said all the same, as a sentence or two.
pub(super) fn rest(diagnosis: &Diagnosis) -> String {
    let gap = times_noise(diagnosis.gap.before);
    let mut text = format!("No cause is named. The {} leaves a gap of {gap}", baseline(diagnosis));
    let nearest: Vec<String> = diagnosis.causes.iter().map(placed).collect();
    if !nearest.is_empty() {
        let closed = percent(diagnosis.gap.closed);
        text += &format!("; what comes nearest is {}, with {closed} of it closed", listed(&nearest));
    }
    text + "."
}

/// All of it, for pictures that have no room above.
pub(super) fn sentence(diagnosis: &Diagnosis, withheld: &Withheld) -> String {
    format!("{} {}", withheld.reason, rest(diagnosis))
}

/// What to do about it.
pub(super) fn what_to_do(by: Veto) -> &'static str {
    match by {
        Veto::Data => "Correct what is wrong with the data, and diagnose again.",
        Veto::Reference => {
            "Diagnose the reference by itself first, give the twin what is known of what it lacks (measured, or from a data sheet), or take a reference that the twin explains."
        }
        Veto::Unidentified => {
            "Put nothing into machine.toml: look at the machine where the gap is largest, or record longer or wider motions."
        }
        Veto::Stretch => {
            "Put nothing into machine.toml: compare what it states of that stretch with what runs there. A controller may have feed-forward terms, filters or a delay of the \
             reference; a drive may add a voltage behind the logged effort."
        }
        Veto::RigidBody => {
            "Put nothing into machine.toml: look at what the rigid-body scene has beyond the reduced axis (attitude, loads of the sliders), \
             and at the machine where the gap is largest."
        }
    }
}
