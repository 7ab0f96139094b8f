//! What was checked in the data, and what was noticed.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::check::Severity;
use crate::report::figure::escape;
use crate::report::findings::{Sentence, sentences};

/// What every recording is checked for.
const CHECKED: &str = "Checked: even sampling and missing samples, clipping, channels that are stuck, held or late, signs and \
                       units, reversals and excitation, zeros of two sensors, and what was not logged.";

/// The section.
pub(super) fn part(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let items: String = sentences(diagnosis).iter().map(item).collect();
    if items.is_empty() {
        part.paragraph("Nothing was noticed in the data.");
    } else {
        part.raw(&format!("<ul class=\"findings\">\n{items}</ul>\n"));
    }
    part.remark(CHECKED);
    part
}

fn item(sentence: &Sentence) -> String {
    let (class, word) = match sentence.severity {
        Severity::Fatal => ("warning", "Fault: "),
        Severity::Warning => ("warning", "Warning: "),
        Severity::Note => ("", ""),
    };
    format!("<li class=\"{class}\">{word}{}</li>\n", escape(&sentence.text()))
}
