//! Why a verdict is withheld or doubtful: above it, in the head of the page.

use super::unbroken::unbroken;
use crate::diagnose::Diagnosis;
use crate::report::figure::escape;
use crate::report::findings::doubts;
use crate::report::withheld::{reasons, title};

/// Paragraphs; empty where the verdict is that of the evidence and nothing makes it doubtful.
pub(super) fn above(diagnosis: &Diagnosis) -> String {
    let doubts = paragraph("Doubtful data or model", &doubts(diagnosis));
    diagnosis
        .withheld
        .as_ref()
        .map_or(String::new(), |withheld| paragraph(title(withheld.by), &reasons(diagnosis, withheld)))
        + &doubts
}

fn paragraph(title: &str, reasons: &[String]) -> String {
    if reasons.is_empty() {
        return String::new();
    }
    let list: Vec<String> = reasons.iter().map(|text| escape(&unbroken(text))).collect();
    format!("<p class=\"withheld\"><strong>{title}.</strong> {}</p>\n", list.join("<br>"))
}
