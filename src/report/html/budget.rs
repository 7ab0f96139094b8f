//! The gap budget: each cause, calibration, what stays open, noise.

use super::page::Part;
use crate::diagnose::{Diagnosis, Verdict};
use crate::report::figure::{Budget, Figure, Ink, Panel, budget::Part as Piece};
use crate::report::material::Material;
use crate::report::number::percent;
use crate::report::words::phrase;

/// A calibration that closes less is not set apart from its cause.
const NOTABLE: f64 = 0.005;
const INKS: [Ink; 5] = [Ink::Law, Ink::Second, Ink::Third, Ink::After, Ink::Before];

/// The section.
pub(super) fn part(diagnosis: &Diagnosis, material: &Material) -> Part {
    let mut part = Part::default();
    if diagnosis.verdict == Verdict::NoGap {
        part.paragraph("There is nothing to share out: what the twin misses on unseen runs is noise.");
        return part;
    }
    let pieces = pieces(diagnosis, material.calibration_closes);
    let caption = "The mean square of what the twin misses on unseen runs, and what it is made of.";
    part.figure(Figure::new("budget", caption, vec![Panel::Budget(Budget { parts: pieces })]));
    if set_apart(diagnosis, material.calibration_closes) > 0.0 && !diagnosis.causes.is_empty() {
        part.remark(
            "Calibration moves stated constants inside their tolerances. The verdict counts it with the causes that it \
             goes with; here it stands apart.",
        );
    }
    part
}

fn set_apart(diagnosis: &Diagnosis, calibration: f64) -> f64 {
    let closed = diagnosis.gap.closed.clamp(0.0, 1.0);
    let calibration = if diagnosis.causes.is_empty() { closed } else { calibration };
    if calibration < NOTABLE { 0.0 } else { calibration.min(closed) }
}

fn pieces(diagnosis: &Diagnosis, calibration: f64) -> Vec<Piece> {
    let gap = &diagnosis.gap;
    let total = (gap.before * gap.before).max(1.0);
    // Shares are of the gap, the bar is of the residual: gap and noise.
    let excess = (total - 1.0) / total;
    let calibration = set_apart(diagnosis, calibration);
    let causes: f64 = diagnosis.causes.iter().map(|cause| cause.closes.max(0.0)).sum();
    let kept = if causes > 0.0 { ((causes - calibration) / causes).max(0.0) } else { 0.0 };
    let mut pieces: Vec<Piece> = diagnosis
        .causes
        .iter()
        .enumerate()
        .map(|(k, cause)| {
            let share = cause.closes.max(0.0) * kept;
            Piece {
                ink: INKS[k % INKS.len()],
                label: format!("{} ({})", phrase(&cause.effect), cause.site),
                share: share * excess,
                text: percent(share),
            }
        })
        .collect();
    let mut push = |ink, label: &str, share: f64, text: String| {
        pieces.push(Piece { ink, label: label.to_owned(), share, text });
    };
    let text = if calibration > 0.0 { percent(calibration) } else { "< 0.5 %".to_owned() };
    push(
        Ink::Calibration,
        "calibration of stated constants inside their tolerances",
        calibration * excess,
        text,
    );
    let open = diagnosis.unexplained.clamp(0.0, 1.0);
    push(Ink::Unexplained, "unexplained", open * excess, percent(open));
    let noise = 1.0 / total;
    push(Ink::Noise, "noise, as a share of the whole residual", noise, percent(noise));
    pieces
}
