//! Friction of a place that is wider than the motion: runs see no more of it than its top.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::{Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::recording::Role;

/// A spot that runs easier, 200 mm wide.
const FORCE: (&str, f64) = ("effect.local_friction.force_n", -20.0);
const CENTRE: (&str, f64) = ("effect.local_friction.centre_m", 0.01);
const WIDTH: (&str, f64) = ("effect.local_friction.width_m", 0.2);
const STATED: [(&str, f64); 1] = [("effect.coulomb_friction.force_n", 60.0)];
/// Strokes of 50 mm at most, a quarter of the width.
const CELLS: [Cell; 4] = [
    (0.03, 4.0, Role::Training),
    (0.05, 12.0, Role::Training),
    (0.04, 16.0, Role::Training),
    (0.045, 8.0, Role::HeldOut),
];
const CATALOGUE: [EffectId; 8] = [
    EffectId::LocalFriction,
    EffectId::CoulombFriction,
    EffectId::ViscousFriction,
    EffectId::AsymmetricFriction,
    EffectId::ConstantForce,
    EffectId::CableSpring,
    EffectId::Cogging,
    EffectId::EncoderScale,
];

#[test]
fn ref_a_spot_wider_than_the_motion_is_named() {
    let stated = with(&model("grinder"), &STATED);
    let real = with(&stated, &[FORCE, CENTRE, WIDTH]);
    let recording = Strokes::both_ways(&stated, &real, 5).recording(&CELLS);
    let d = diagnose(&stated, &recording, &Options { catalogue: &CATALOGUE, ..Options::default() }).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["local_friction"]));
    for (path, truth) in [FORCE, CENTRE, WIDTH] {
        let found = &d.causes[0].parameters[path.rsplit('.').next().unwrap()];
        assert!((found.value / truth - 1.0).abs() < 0.05, "{path}: {found:?}, hidden {truth}");
    }
}

/// Friction of the whole guide and 28 % more of it in the middle of the travel, N; the guide of the twin has none.
fn uneven(coulomb: f64) -> [(&'static str, f64); 4] {
    [
        ("effect.coulomb_friction.force_n", coulomb),
        ("effect.local_friction.force_n", 0.28 * coulomb),
        ("effect.local_friction.centre_m", 0.01),
        ("effect.local_friction.width_m", 0.08),
    ]
}

/// Two effects with their sizes, and not one spot that is wider still.
#[test]
fn ref_friction_of_the_whole_guide_is_no_wide_spot() {
    let stated = model("grinder");
    let hidden = uneven(18.0);
    let recording = Strokes::both_ways(&stated, &with(&stated, &hidden), 5).recording(&CELLS);
    let d = diagnose(&stated, &recording, &Options { catalogue: &CATALOGUE, ..Options::default() }).unwrap();
    show(&d);
    let mut named = names(&d);
    named.sort_unstable();
    assert_eq!((d.verdict, named), (Verdict::Cause, vec!["coulomb_friction", "local_friction"]));
    for (path, truth) in hidden {
        let (effect, key) = path.strip_prefix("effect.").and_then(|p| p.split_once('.')).unwrap();
        let cause = d.causes.iter().find(|cause| cause.effect == effect).unwrap();
        let found = cause.parameters[key].value;
        assert!((found / truth - 1.0).abs() < 0.05, "{path}: {found}, hidden {truth}");
    }
}

/// On one short training run a drift could do what the friction does that it modifies; without that there is no drift.
#[test]
fn ref_a_drift_does_not_take_the_place_of_its_friction() {
    let stated = model("grinder");
    let recording =
        Strokes::both_ways(&stated, &with(&stated, &uneven(6.0)), 5).recording(&[CELLS[0], CELLS[3]]);
    let d = diagnose(&stated, &recording, &Options::default()).unwrap();
    show(&d);
    let has = |effects: &[String], name: &str| effects.iter().any(|effect| effect == name);
    let friction = ["coulomb_friction", "load_dependent_friction"];
    assert!(
        d.ranking
            .iter()
            .all(|r| !has(&r.effects, "friction_drift") || friction.iter().any(|f| has(&r.effects, f)))
    );
    assert!(names(&d).contains(&"coulomb_friction"));
}
