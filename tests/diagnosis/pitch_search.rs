//! A pitch that is longer than the travel, small beside friction.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use slideway::diagnose::decide::Verdict;
use slideway::diagnose::{Options, diagnose};
use slideway::machine::Machine;
use slideway::recording::Role;
use std::path::Path;

const CELLS: [Cell; 5] = [
    (0.043, 8.0, Role::Training),
    (0.040, 4.0, Role::Training),
    (0.036, 12.0, Role::Training),
    (0.041, 6.0, Role::HeldOut),
    (0.034, 8.0, Role::HeldOut),
];

/// Cogging of a thousandth of the friction, with a pitch of 51 mm on strokes of 34 to 43 mm, beside an offset of the amplifier: what the replays leave tells
/// both, and neither is taken for friction that differs between the directions.
#[test]
fn ref_a_small_wave_longer_than_the_travel_is_found_beside_friction() {
    let grinder = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let with = |machine: &Machine, settings: &[(&str, f64)]| {
        machine.with_settings(settings.iter().map(|&(path, value)| (path, value.into()))).unwrap()
    };
    let friction = [
        ("effect.coulomb_friction.force_n", 28.0),
        ("effect.presliding.stiffness_n_per_m", 2.2e6),
        ("effect.presliding.damping_n_s_per_m", 2000.0),
    ];
    let stated = with(&grinder, &friction);
    let hidden = [
        ("effect.amplifier_offset.offset_v", 1.8e-3),
        ("effect.cogging.period_m", 0.051),
        ("effect.cogging.sine_n", 0.03),
        ("effect.cogging.cosine_n", -0.002),
        ("effect.cogging.cosine_2_n", -0.007),
    ];
    let real = with(&stated, &hidden);
    let recording = Strokes::both_ways(&stated, &real, 3).recording(&CELLS);
    let d = diagnose(&stated, &recording, &Options::default()).unwrap();
    let named: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    println!("{:?} {named:?} G {:.2} -> {:.2}", d.verdict, d.gap.before, d.gap.after);
    assert_eq!(d.verdict, Verdict::Cause);
    assert!(
        named.len() == 2 && named.contains(&"amplifier_offset") && named.contains(&"cogging"),
        "{named:?}"
    );
    let cogging = d.causes.iter().find(|cause| cause.effect == "cogging").unwrap();
    let period = &cogging.parameters["period_m"];
    println!("{period:?}");
    assert!(period.ci95[0] <= 0.051 && 0.051 <= period.ci95[1], "{period:?}");
}
