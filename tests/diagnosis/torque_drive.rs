//! A torque-controlled drive whose current is logged with more noise than its command tells of the force.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::recording::{Role, Signal};

/// Stroke in rad, feed in rad/min.
const CELLS: [Cell; 5] = [
    (1.3, 290.0, Role::Training),
    (2.1, 140.0, Role::Training),
    (1.7, 560.0, Role::Training),
    (1.9, 260.0, Role::HeldOut),
    (1.1, 480.0, Role::HeldOut),
];

/// Strokes at feeds whose acceleration takes less torque.
const SLOW: [Cell; 5] = [
    (1.3, 60.0, Role::Training),
    (2.1, 90.0, Role::Training),
    (1.7, 120.0, Role::Training),
    (1.9, 75.0, Role::HeldOut),
    (1.1, 100.0, Role::HeldOut),
];

/// One stroke that passes a whole period of an error of 3.1 rad, the others less.
const LONG: [Cell; 5] = [
    (4.2, 140.0, Role::Training),
    (1.2, 330.0, Role::Training),
    (2.7, 620.0, Role::Training),
    (1.0, 530.0, Role::HeldOut),
    (2.6, 170.0, Role::HeldOut),
];

const CATALOGUE: [EffectId; 15] = [
    EffectId::EncoderPeriodicError,
    EffectId::LoopDelay,
    EffectId::DeadZone,
    EffectId::AmplifierOffset,
    EffectId::ForceConstant,
    EffectId::Cogging,
    EffectId::SecondCogging,
    EffectId::ThirdCogging,
    EffectId::ViscousFriction,
    EffectId::CoulombFriction,
    EffectId::AsymmetricFriction,
    EffectId::LocalFriction,
    EffectId::CableSpring,
    EffectId::Payload,
    EffectId::SensorScale,
];

/// Dry friction behind bristles that the twin knows.
const KNOWN: [(&str, f64); 3] = [
    ("effect.coulomb_friction.torque_nm", 2.1e-3),
    ("effect.presliding.stiffness_nm_per_rad", 2.4),
    ("effect.presliding.damping_nm_s_per_rad", 5e-3),
];

fn told(cells: &[Cell], known: &[(&str, f64)], hidden: &[(&str, f64)]) -> Diagnosis {
    let stated = with(&model("servo"), known);
    let real = with(&stated, hidden);
    let recording = Strokes::both_ways(&stated, &real, 23).recording(cells);
    assert!(recording.runs().iter().all(|run| run.signal(Signal::Current).is_some()));
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(&stated, &recording, &options).unwrap();
    show(&d);
    d
}

/// Friction of one place that makes less torque than the noise of the current.
#[test]
fn ref_local_friction_below_the_noise_of_the_current_is_named() {
    let hidden = [
        ("effect.local_friction.torque_nm", 9e-5),
        ("effect.local_friction.centre_rad", 0.7),
        ("effect.local_friction.width_rad", 0.2),
    ];
    let d = told(&SLOW, &[], &hidden);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["local_friction"]));
    let centre = &d.causes[0].parameters["centre_rad"];
    assert!((centre.value - 0.7).abs() < 0.01, "{centre:?}");
}

/// Three pitches of which none explains anything beyond chance while the others are missing.
#[test]
fn ref_three_pitches_are_found_behind_bristles() {
    let wave = |effect: &str, number: &str| format!("effect.{effect}.{number}");
    let pitches =
        [("cogging", 0.273, 8e-5), ("second_cogging", 1.257, 1e-4), ("third_cogging", 0.1065, 8e-5)];
    let numbers = pitches.iter().flat_map(|(effect, period, torque)| {
        [
            (wave(effect, "period_rad"), *period),
            (wave(effect, "cosine_nm"), *torque),
            (wave(effect, "sine_nm"), 2e-5),
        ]
    });
    let numbers: Vec<(String, f64)> = numbers.collect();
    let hidden: Vec<(&str, f64)> = numbers.iter().map(|(path, value)| (path.as_str(), *value)).collect();
    let d = told(&CELLS, &KNOWN, &hidden);
    assert_eq!(names(&d), ["cogging", "second_cogging", "third_cogging"]);
    let mut periods: Vec<f64> = d.causes.iter().map(|cause| cause.parameters["period_rad"].value).collect();
    periods.sort_by(f64::total_cmp);
    for (found, hidden) in periods.iter().zip([0.1065, 0.273, 1.257]) {
        assert!((found / hidden - 1.0).abs() < 0.01, "{found} {hidden}");
    }
}

/// An error of the encoder that the loop follows: what shows of 0.8 mrad is 13 µrad of the position and little force.
#[test]
fn ref_a_long_error_of_the_encoder_is_named() {
    let hidden = [
        ("effect.encoder_periodic_error.period_rad", 3.1),
        ("effect.encoder_periodic_error.sine_rad", 4.7e-4),
        ("effect.encoder_periodic_error.cosine_rad", 6.8e-4),
    ];
    let d = told(&LONG, &[], &hidden);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["encoder_periodic_error"]));
    let period = &d.causes[0].parameters["period_rad"];
    assert!((period.value / 3.1 - 1.0).abs() < 0.01, "{period:?}");
}

/// An offset that is a fifth of the noise of each sample of the current, beside cogging that makes most of the gap: only the mean of many shows that
/// the drive is not as stated.
#[test]
fn ref_an_offset_below_the_noise_of_the_current_is_no_force() {
    let hidden = [
        ("effect.amplifier_offset.offset_v", 4e-5),
        ("effect.cogging.period_rad", 1.257),
        ("effect.cogging.sine_nm", 1e-3),
        ("effect.cogging.cosine_nm", 0.0),
    ];
    let d = told(&CELLS, &KNOWN, &hidden);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["amplifier_offset", "cogging"]));
    let offset = d.causes.iter().find(|cause| cause.effect == "amplifier_offset").unwrap();
    let offset = &offset.parameters["offset_v"];
    assert!((offset.value / 4e-5 - 1.0).abs() < 0.05, "{offset:?}");
}

/// Nothing hidden, nothing named.
#[test]
fn ref_a_drive_without_a_gap_has_none() {
    for known in [&KNOWN[..], &[]] {
        let d = told(&CELLS, known, &[]);
        assert_eq!((d.verdict, names(&d)), (Verdict::NoGap, vec![]));
    }
}
