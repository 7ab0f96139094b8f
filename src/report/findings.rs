//! What was noticed in the data: each finding told once, with the runs that it concerns.

use crate::diagnose::check::{Check, Finding, Severity};
use crate::diagnose::verdict::Diagnosis;

/// Runs that are named before the rest is only counted.
const RUNS: usize = 4;

/// A finding, told once for all runs that it concerns.
pub(super) struct Sentence<'a> {
    /// What it is about.
    pub(super) check: Check,
    /// How much it matters.
    pub(super) severity: Severity,
    /// The runs.
    pub(super) runs: Vec<&'a str>,
    message: &'a str,
    /// Number of all runs.
    count: usize,
}

impl Sentence<'_> {
    /// The sentence with its runs.
    pub(super) fn text(&self) -> String {
        match runs_text(&self.runs, self.count) {
            Some(runs) => format!("{} ({runs})", self.message),
            None => self.message.to_owned(),
        }
    }
}

/// What was noticed in the data, worst first.
pub(super) fn sentences(diagnosis: &Diagnosis) -> Vec<Sentence<'_>> {
    let count = diagnosis.data.training.len() + diagnosis.data.held_out.len();
    let mut sentences: Vec<Sentence> = Vec::new();
    for Finding { run, check, severity, message, .. } in &diagnosis.checks {
        let is_same = |first: &Sentence| first.message == message && first.severity == *severity;
        let place = sentences.iter().position(is_same).unwrap_or_else(|| {
            sentences.push(Sentence { check: *check, severity: *severity, runs: Vec::new(), message, count });
            sentences.len() - 1
        });
        if !run.is_empty() {
            sentences[place].runs.push(run);
        }
    }
    sentences.sort_by_key(|sentence| sentence.severity);
    sentences
}

/// Findings that make a verdict doubtful, whatever it is: a twin that is not stable, a column that is not what it is taken for, another control law.
const DOUBTS: [Check; 5] =
    [Check::UnstableLoop, Check::StuckChannel, Check::SwappedSign, Check::ImplausibleUnit, Check::ControlLaw];

pub(super) fn is_doubt(sentence: &Sentence) -> bool {
    sentence.severity == Severity::Warning && DOUBTS.contains(&sentence.check)
}

/// What makes the verdict doubtful, as sentences: it stands above the verdict.
pub(super) fn doubts(diagnosis: &Diagnosis) -> Vec<String> {
    sentences(diagnosis).iter().filter(|sentence| is_doubt(sentence)).map(Sentence::text).collect()
}

fn runs_text(runs: &[&str], count: usize) -> Option<String> {
    match runs.len() {
        0 => None,
        all if all >= count && count > 1 => Some("all runs".to_owned()),
        some if some <= RUNS => Some(runs.join(", ")),
        some => Some(format!("{} and {} more runs", runs[..RUNS].join(", "), some - RUNS)),
    }
}
