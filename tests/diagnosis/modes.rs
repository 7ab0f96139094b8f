//! Modes that stand out of what the twin's replays leave, and not of the missing force.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, with};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::recording::Role;

const CELLS: [Cell; 4] = [
    (0.030, 8.0, Role::Training),
    (0.050, 16.0, Role::Training),
    (0.020, 8.0, Role::HeldOut),
    (0.030, 16.0, Role::HeldOut),
];

/// The worktable with a mode that its twin does not list.
fn with_mode(frequency_hz: f64, mass_kg: f64) -> Diagnosis {
    let machine = model("grinder");
    let hidden = [
        ("effect.flexible_mode.frequency_hz", frequency_hz),
        ("effect.flexible_mode.mass_kg", mass_kg),
        ("effect.flexible_mode.damping_ratio", 0.02),
    ];
    let real = with(&machine, &hidden);
    let recording = Strokes::both_ways(&machine, &real, 3).recording(&CELLS);
    diagnose(&machine, &recording, &Options::default()).unwrap()
}

/// A gap of 1.4 × noise, and a frequency at which the smoothing of the missing force leaves little.
#[test]
fn ref_a_quick_mode_is_found_at_its_frequency() {
    let d = with_mode(78.0, 1500.0);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["flexible_mode"]));
    let frequency = &d.causes[0].parameters["frequency_hz"];
    assert!((frequency.value / 78.0 - 1.0).abs() < 0.02, "{frequency:?}");
    assert!((d.causes[0].parameters["mass_kg"].value / 1500.0 - 1.0).abs() < 0.1, "{:?}", d.causes);
}

/// What makes no gap may not be named, and is not called something else for certain.
#[test]
fn ref_a_mode_below_the_noise_is_not_a_shifted_mode_for_certain() {
    let d = with_mode(217.0, 800.0);
    let is_wrong = d.verdict == Verdict::Cause && names(&d) != ["flexible_mode"];
    assert!(!is_wrong, "{:?} {:?}", d.verdict, names(&d));
}
