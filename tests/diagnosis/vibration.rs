//! A vibration that stands out of what the twin's replays leave, and not of the missing force.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, with};
use slideway::diagnose::{Options, Verdict, diagnose};
use slideway::recording::Role;

const CELLS: [Cell; 5] = [
    (0.011, 0.58, Role::Training),
    (0.010, 1.32, Role::Training),
    (0.019, 2.58, Role::Training),
    (0.014, 2.38, Role::HeldOut),
    (0.012, 0.61, Role::HeldOut),
];

/// A third of a newton at 20.26 Hz on a moving part of 95 kg.
#[test]
fn ref_a_small_vibration_is_named() {
    let machine = model("emps");
    let hidden =
        [("effect.external_vibration.force_n", 0.338), ("effect.external_vibration.frequency_hz", 20.26)];
    let real = with(&machine, &hidden);
    let d =
        diagnose(&machine, &Strokes::both_ways(&machine, &real, 3).recording(&CELLS), &Options::default())
            .unwrap();
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["external_vibration"]));
    let numbers = &d.causes[0].parameters;
    let holds = |key: &str, truth: f64| numbers[key].ci95[0] <= truth && truth <= numbers[key].ci95[1];
    assert!(holds("force_n", 0.338) && holds("frequency_hz", 20.26), "{numbers:?}");
}
