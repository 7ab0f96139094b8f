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

/// The worktable with a mode that its twin does not list, read with this noise.
fn with_mode(frequency_hz: f64, mass_kg: f64, seed: u64) -> Diagnosis {
    let machine = model("grinder");
    let hidden = [
        ("effect.flexible_mode.frequency_hz", frequency_hz),
        ("effect.flexible_mode.mass_kg", mass_kg),
        ("effect.flexible_mode.damping_ratio", 0.02),
    ];
    let real = with(&machine, &hidden);
    let recording = Strokes::both_ways(&machine, &real, seed).recording(&CELLS);
    diagnose(&machine, &recording, &Options::default()).unwrap()
}

/// A gap of 1.7 × noise, and a frequency at which the smoothing of the missing force leaves little: by that alone it is a base mode at a third of its
/// frequency.
#[test]
fn ref_a_quick_mode_is_found_at_its_frequency() {
    let d = with_mode(62.0, 2000.0, 1);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["flexible_mode"]));
    let frequency = &d.causes[0].parameters["frequency_hz"];
    assert!((frequency.value / 62.0 - 1.0).abs() < 0.02, "{frequency:?}");
    assert!((d.causes[0].parameters["mass_kg"].value / 2000.0 - 1.0).abs() < 0.05, "{:?}", d.causes);
}

/// A mode far below the noise makes no gap, though some other law would follow the course of the residuals better.
#[test]
fn ref_a_mode_below_the_noise_is_no_gap() {
    for seed in 0..2 {
        let d = with_mode(217.0, 800.0, seed);
        assert_eq!((d.verdict, names(&d)), (Verdict::NoGap, vec![]), "{:?}", d.gap);
    }
}
