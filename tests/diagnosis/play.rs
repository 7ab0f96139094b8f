//! A play in which the drive train stands anywhere where a run begins.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role};

/// Strokes, and where in the play the motor stands before each, as a share of half its width.
const RUNS: [(Cell, f64); 5] = [
    ((0.04, 16.0, Role::Training), 0.9),
    ((0.05, 8.0, Role::Training), -0.7),
    ((0.045, 4.0, Role::Training), 0.3),
    ((0.04, 8.0, Role::HeldOut), -1.0),
    ((0.05, 16.0, Role::HeldOut), 0.6),
];
const WIDTH_M: f64 = 2e-5;
const CATALOGUE: [EffectId; 6] = [
    EffectId::LoopDelay,
    EffectId::CoulombFriction,
    EffectId::ConstantForce,
    EffectId::Payload,
    EffectId::Backlash,
    EffectId::EncoderPeriodicError,
];

fn played(stated: &Machine) -> Machine {
    with(stated, &[("effect.backlash.width_m", WIDTH_M)])
}

/// Each run from where its motor stood, none of which the recording tells.
fn recording(stated: &Machine) -> Recording {
    let run = |(cell, begins): &(Cell, f64)| {
        let real = with(&played(stated), &[("effect.backlash.begin_share", *begins)]);
        Strokes::both_ways(stated, &real, 11).recording(&[*cell]).runs()[0].clone()
    };
    Recording::new(RUNS.iter().map(run).collect()).unwrap()
}

fn told(twin: &Machine) -> Diagnosis {
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(twin, &recording(&model("grinder")), &options).unwrap();
    show(&d);
    d
}

/// From the middle of the play the twin begins up to 10 µm from where the machine does: its first acceleration is early or late. Its width is told by
/// all of the motion, and each run tells where it began.
#[test]
fn exact_a_run_begins_anywhere_in_its_play() {
    let d = told(&model("grinder"));
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["backlash"]));
    let width = &d.causes[0].parameters["width_m"];
    assert!(
        (width.value / WIDTH_M - 1.0).abs() < 0.01 && width.ci95[0] < WIDTH_M && width.ci95[1] > WIDTH_M,
        "{width:?}"
    );
    assert!(d.gap.after < 1.25, "{:?}", d.gap);
}

/// A twin that has the play lacks nothing, wherever in it a run begins.
#[test]
fn exact_a_twin_with_the_play_has_no_gap() {
    let d = told(&played(&model("grinder")));
    assert_eq!((d.verdict, names(&d)), (Verdict::NoGap, vec![]));
}
