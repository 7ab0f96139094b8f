//! What was checked in the data, and what was noticed.

use super::page::Part;
use crate::diagnose::Diagnosis;
use crate::diagnose::check::Severity;
use crate::report::figure::escape;
use crate::report::follow_up::runs_text;

/// What every recording is checked for.
const CHECKED: &str = "Checked: even sampling and missing samples, clipping, channels that are stuck, held or late, signs and \
                       units, reversals and excitation, zeros of two sensors, and what was not logged.";

/// The section.
pub(super) fn part(diagnosis: &Diagnosis) -> Part {
    let mut part = Part::default();
    let mut findings: Vec<(&str, Severity, Vec<&str>)> = Vec::new();
    for finding in &diagnosis.checks {
        let place =
            findings.iter().position(|(message, ..)| *message == finding.message).unwrap_or_else(|| {
                findings.push((&finding.message, finding.severity, Vec::new()));
                findings.len() - 1
            });
        if !finding.run.is_empty() {
            findings[place].2.push(&finding.run);
        }
    }
    findings.sort_by_key(|(_, severity, _)| *severity);
    if findings.is_empty() {
        part.paragraph("Nothing was noticed in the data.");
    } else {
        let count = diagnosis.data.training.len() + diagnosis.data.held_out.len();
        let items: String =
            findings.iter().map(|(message, severity, runs)| item(message, *severity, runs, count)).collect();
        part.raw(&format!("<ul class=\"findings\">\n{items}</ul>\n"));
    }
    part.remark(CHECKED);
    part
}

fn item(message: &str, severity: Severity, runs: &[&str], count: usize) -> String {
    let (class, word) = match severity {
        Severity::Warning => ("warning", "Warning: "),
        Severity::Note => ("", ""),
    };
    let runs = runs_text(runs, count).map_or(String::new(), |runs| format!(" ({runs})"));
    format!("<li class=\"{class}\">{word}{}{}</li>\n", escape(message), escape(&runs))
}
