//! Why a verdict is withheld: above it, in the head of the page.

use crate::diagnose::Diagnosis;
use crate::report::figure::escape;
use crate::report::withheld::{reasons, title};

/// A paragraph; empty where the verdict is that of the evidence.
pub(super) fn above(diagnosis: &Diagnosis) -> String {
    diagnosis.withheld.as_ref().map_or_else(String::new, |withheld| {
        let reasons = reasons(diagnosis, withheld);
        let list: Vec<String> = reasons.iter().map(|text| escape(&super::head::unbroken(text))).collect();
        let title = title(withheld.by);
        format!("<p class=\"withheld\"><strong>{title}.</strong> {}</p>\n", list.join("<br>"))
    })
}
