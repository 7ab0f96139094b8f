//! Why a verdict is withheld: above it, in the head of the page.

use crate::diagnose::Diagnosis;
use crate::report::figure::escape;
use crate::report::withheld::title;

/// A paragraph; empty where the verdict is that of the evidence.
pub(super) fn above(diagnosis: &Diagnosis) -> String {
    diagnosis.withheld.as_ref().map_or_else(String::new, |withheld| {
        let (title, reason) = (title(withheld.by), super::head::unbroken(&withheld.reason));
        format!("<p class=\"withheld\"><strong>{title}.</strong> {}</p>\n", escape(&reason))
    })
}
