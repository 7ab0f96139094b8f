//! Effects that nobody can tell apart on these signals, beside a pitch whose length depends on which of them acts.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::recording::{Recording, Role, Run, Signal};

const CELLS: [Cell; 4] = [
    (0.018, 1.16, Role::Training),
    (0.013, 0.61, Role::Training),
    (0.019, 1.9, Role::Training),
    (0.017, 0.9, Role::HeldOut),
];

const CATALOGUE: [EffectId; 9] = [
    EffectId::LoopDelay,
    EffectId::AmplifierOffset,
    EffectId::ForceConstant,
    EffectId::Cogging,
    EffectId::ViscousFriction,
    EffectId::CoulombFriction,
    EffectId::CableSpring,
    EffectId::Payload,
    EffectId::EncoderScale,
];

/// Moving mass of the twin, and what is put on it.
const MASS_KG: f64 = 95.1089;
const ADDED_KG: f64 = 82.0;

const HIDDEN: [(&str, f64); 6] = [
    ("effect.payload.mass_kg", ADDED_KG),
    ("effect.cogging.period_m", 0.01186),
    ("effect.cogging.sine_n", -0.139),
    ("effect.cogging.cosine_n", -0.005),
    ("effect.cogging.cosine_2_n", -0.018),
    ("effect.amplifier_offset.offset_v", 2.55e-3),
];

/// An axis of which position, velocity and effort are logged, and what is told of it.
fn told(hidden: &[(&str, f64)], kept: &[Signal]) -> Diagnosis {
    let stated = model("emps");
    let real = with(&stated, hidden);
    let whole = Strokes::both_ways(&stated, &real, 17).recording(&CELLS);
    let thinned = |run: &Run| {
        let signals = run.signals().iter().filter(|(signal, _)| kept.contains(signal));
        run.with_signals(signals.map(|(signal, samples)| (*signal, samples.clone())).collect()).unwrap()
    };
    let recording = Recording::new(whole.runs().iter().map(thinned).collect()).unwrap();
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(&stated, &recording, &options).unwrap();
    show(&d);
    d
}

const DRIVE: [Signal; 4] =
    [Signal::PositionReference, Signal::Position, Signal::Velocity, Signal::ControlEffort];

/// Without current and thrust a payload, a force constant and the scale of the only encoder are equals (f·Kt·i = m·a), and a cogging beside them has
/// another pitch for each: the scale of the encoder is no certain answer to a payload.
#[test]
fn ref_equals_are_told_beside_a_pitch_that_depends_on_them() {
    let d = told(&HIDDEN, &DRIVE);
    assert_eq!(d.verdict, Verdict::Undecided);
    let covers = |name: &str| d.causes.iter().any(|cause| cause.covers(name));
    assert!(["payload", "encoder_scale", "force_constant", "cogging"].iter().all(|name| covers(name)));
    let probability = |name: &str| d.effects.iter().find(|e| e.effect == name).unwrap().probability;
    for equal in ["payload", "encoder_scale"] {
        assert!(probability(equal) > 0.2, "{equal}: {}", probability(equal));
    }
    // Of force constants 95 % are within √3: this one is as much rarer as a normal variable that is z standard deviations off.
    let z = (1.0 + ADDED_KG / MASS_KG).ln() / (0.5 * 3.0_f64.sqrt().ln());
    let odds = probability("force_constant") / probability("payload");
    assert!((odds / (-0.5 * z * z).exp()).ln().abs() < 0.5, "{odds}, {z} standard deviations");
    assert!(d.gap.after < 1.25, "{:?}", d.gap);
}

/// Where nothing can do what an effect does, continuation leads nowhere: a delay and a spring are named. On a travel of 19 mm a spring may be a part of a
/// longer wave, and says so.
#[test]
fn ref_effects_without_equals_stay_alone() {
    let hidden = [
        ("effect.loop_delay.delay_s", 1.5e-3),
        ("effect.cable_spring.stiffness_n_per_m", 800.0),
        ("effect.cable_spring.centre_m", 5e-3),
    ];
    let d = told(&hidden, &DRIVE);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["cable_spring", "loop_delay"]));
    for cause in &d.causes {
        let equals: &[&str] = if cause.effect == "cable_spring" { &["cogging"] } else { &[] };
        assert_eq!(cause.confusable_with, equals, "{cause:?}");
        let reason = cause.confusable_reason.as_deref().unwrap_or_default();
        assert!(equals.is_empty() || reason.contains("pitch above"), "{reason}");
    }
}
