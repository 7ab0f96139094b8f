//! Where a report comes from: data, machine, version, command.

use super::page::{Part, command as unbroken};
use crate::diagnose::Diagnosis;
use crate::diagnose::decide::Limits;
use crate::diagnose::thresholds::{ADEQUATE_GAP, LARGELY, STATED_NOISE};
use crate::report::figure::escape;
use crate::report::stretches;

/// The section.
pub(super) fn part(diagnosis: &Diagnosis, command: &str) -> Part {
    let data = &diagnosis.data;
    let mut rows = vec![
        ("machine", data.machine.clone()),
        ("training runs", data.training.join(", ")),
        ("unseen (held-out) runs", data.held_out.join(", ")),
        ("SHA-256 of the recording", data.sha256.clone()),
    ];
    let texts = stretches::sentences(data);
    rows.extend(texts.into_iter().map(|text| ("stretches", text)));
    if let Some(reference) = &diagnosis.reference {
        rows.push(("SHA-256 of the reference", reference.data.sha256.clone()));
    }
    rows.push(("decided by", limits(&diagnosis.limits)));
    rows.push(("slideway", diagnosis.version.clone()));
    rows.push(("schema", diagnosis.schema.clone()));
    list(&rows, command)
}

/// What a cause needs, in words.
fn limits(limits: &Limits) -> String {
    format!(
        "a cause needs a probability of {} or more; what it leaves is at most {ADEQUATE_GAP} × noise, {} × noise of a gap that is closed by {} %, \
         or {} % of the gap's power ({} % where the noise is only stated)",
        limits.probability,
        limits.small_gap,
        number(100.0 * LARGELY),
        number(100.0 * limits.open_share),
        number(100.0 * STATED_NOISE * limits.open_share),
    )
}

/// A round number without the digits that a product adds.
fn number(value: f64) -> String {
    format!("{}", (1e6 * value).round() / 1e6)
}

/// Rows of words, then the command.
pub(super) fn list(rows: &[(&str, String)], command: &str) -> Part {
    let mut part = Part::default();
    let items: String = rows
        .iter()
        .filter(|(_, text)| !text.is_empty())
        .map(|(word, text)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(word), escape(text)))
        .collect();
    part.raw(&format!("<dl>\n{items}</dl>\n<pre class=\"command\">{}</pre>\n", unbroken(command)));
    part
}
