//! What the named causes leave open, and where that is largest.

use super::number::percent;
use super::place::{banded, named, top};
use super::words::{listed, times_noise};
use crate::diagnose::Verdict;
use crate::diagnose::verdict::Diagnosis;
use crate::units::Motion;

/// From this gap on, what remains behind the named causes is worth a sentence.
const REMAINS: f64 = 1.5;

/// What the causes leave open, as a sentence more.
pub(super) fn remains(diagnosis: &Diagnosis, motion: Motion) -> String {
    let left = times_noise(diagnosis.gap.after);
    match diagnosis.verdict {
        Verdict::Unknown => {
            format!(
                " A gap of {left} remains that no effect of the catalogue explains{}.",
                largest(diagnosis, motion)
            )
        }
        _ if diagnosis.gap.after > REMAINS => format!(" A gap of {left} remains unexplained."),
        _ => String::new(),
    }
}

/// "; it is largest in phase “reverse” (41 %)": where what is left lies; empty where nothing is known of that.
pub(super) fn largest(diagnosis: &Diagnosis, motion: Motion) -> String {
    let place = diagnosis.left.as_ref().map_or(&diagnosis.place, |left| &left.place);
    let position = if motion == Motion::Prismatic { "m" } else { "rad" };
    let largest = [
        ("in phase “", top(named(&place.phase)), "”"),
        ("at ", top(banded(&place.frequency_hz, "Hz")), ""),
        ("at positions ", top(banded(&place.position, position)), ""),
    ];
    let parts: Vec<String> = largest
        .into_iter()
        .filter_map(|(before, entries, after)| {
            entries.first().map(|(label, share)| format!("{before}{label}{after} ({})", percent(*share)))
        })
        .collect();
    if parts.is_empty() { String::new() } else { format!("; it is largest {}", listed(&parts)) }
}
