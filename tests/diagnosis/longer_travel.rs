//! Held-out runs that go farther than the training runs: what those leave uncertain the others may tell.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::{Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::recording::Role;

/// Ripple of 44 mm: strokes of 16.5 and 22 mm see three eighths and a half of it, the one that judges all but a sixth.
const PITCH_M: f64 = 0.044;
const CELLS: [Cell; 3] =
    [(0.0165, 6.0, Role::Training), (0.022, 10.0, Role::Training), (0.037, 8.0, Role::HeldOut)];
const CATALOGUE: [EffectId; 6] = [
    EffectId::ForceRipple,
    EffectId::Cogging,
    EffectId::CableSpring,
    EffectId::ConstantForce,
    EffectId::ForceConstant,
    EffectId::CoulombFriction,
];

/// The pitch that the training runs leave uncertain by millimetres is no fault of the effect: the interval holds it, and no other effect is named. One linear
/// step of the update leaves 8.4 × noise of 24.4 here, and no verdict.
#[test]
fn ref_a_pitch_longer_than_the_training_runs_is_named() {
    let stated = model("grinder");
    let hidden = [
        ("effect.force_ripple.period_m", PITCH_M),
        ("effect.force_ripple.cosine", -0.03),
        ("effect.force_ripple.sine", -0.01),
    ];
    let recording = Strokes::both_ways(&stated, &with(&stated, &hidden), 1).recording(&CELLS);
    let d = diagnose(&stated, &recording, &Options { catalogue: &CATALOGUE, ..Options::default() }).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["force_ripple"]));
    let [low, high] = d.causes[0].parameters["period_m"].ci95;
    assert!(low <= PITCH_M && PITCH_M <= high, "{low} to {high}");
    // As fitted it leaves more: the held-out run tells the pitch better.
    assert!(d.gap.after_predictive < 0.5 * d.gap.after, "{} of {}", d.gap.after_predictive, d.gap.after);
}
