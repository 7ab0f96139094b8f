//! Training runs with something that no held-out run has.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::recording::Role;

/// A dry spot of 12 mm about 40 mm.
const SPOT: [(&str, f64); 3] = [
    ("effect.local_friction.force_n", 30.0),
    ("effect.local_friction.centre_m", 0.04),
    ("effect.local_friction.width_m", 0.012),
];
const CATALOGUE: [EffectId; 4] =
    [EffectId::LocalFriction, EffectId::CoulombFriction, EffectId::ViscousFriction, EffectId::ConstantForce];

/// Strokes of 20 and 55 mm, judged by one of so many metres.
fn diagnosed(held_out_m: f64, catalogue: &[EffectId]) -> Diagnosis {
    let cells: [Cell; 3] =
        [(0.02, 8.0, Role::Training), (0.055, 8.0, Role::Training), (held_out_m, 6.0, Role::HeldOut)];
    let stated = with(&model("grinder"), &[("effect.coulomb_friction.force_n", 60.0)]);
    let recording = Strokes::both_ways(&stated, &with(&stated, &SPOT), 3).recording(&cells);
    let d = diagnose(&stated, &recording, &Options { catalogue, ..Options::default() }).unwrap();
    show(&d);
    d
}

/// A held-out stroke of 18 mm does not reach the spot: it is predicted as well as noise allows, and the verdict is no `no_gap`. The stretch is told, and the
/// effect by which it would be explained, where it is in the catalogue.
#[test]
fn ref_a_spot_that_only_a_training_run_reaches_withholds_the_verdict() {
    for (catalogue, by) in [(&CATALOGUE[..], vec![vec!["local_friction"]]), (&CATALOGUE[1..], vec![])] {
        let d = diagnosed(0.018, catalogue);
        let training = &d.gap.training;
        assert_eq!((d.verdict, names(&d)), (Verdict::Unknown, vec![]));
        assert!(d.gap.before < 1.25 && training.gap > 3.0 && training.is_only_here, "{training:?}");
        assert_eq!(training.explained_by, by);
        let worst = training.worst.as_ref().unwrap();
        assert!(worst.run == "stroke55_feed8" && worst.gap > training.gap, "{worst:?}");
    }
}

/// Where the held-out stroke goes over it, it is named.
#[test]
fn ref_a_spot_that_the_held_out_run_reaches_is_named() {
    let d = diagnosed(0.05, &CATALOGUE);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["local_friction"]));
    assert!(!d.gap.training.is_only_here && d.gap.training.gap < 1.25, "{:?}", d.gap.training);
}
