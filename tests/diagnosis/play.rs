//! A play in which the drive train stands anywhere where a run begins.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::experiment::Experiment;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run};

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

/// A worn drive train: its place in the play is told by a motion that depends on it by more than to second order.
const WORN_M: f64 = 3e-4;

fn played(stated: &Machine, width_m: f64) -> Machine {
    with(stated, &[("effect.backlash.width_m", width_m)])
}

/// Each run from where its motor stood, which the recording does not tell.
fn recording(stated: &Machine, width_m: f64) -> Recording {
    let run = |(cell, begins): &(Cell, f64)| {
        let real = with(&played(stated, width_m), &[("effect.backlash.initial_share", *begins)]);
        Strokes::both_ways(stated, &real, 11).recording(&[*cell]).runs()[0].clone()
    };
    Recording::new(RUNS.iter().map(run).collect()).unwrap()
}

fn told(twin: &Machine, recording: &Recording) -> Diagnosis {
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(twin, recording, &options).unwrap();
    show(&d);
    d
}

#[track_caller]
fn assert_play(d: &Diagnosis) {
    assert_eq!((d.verdict, names(d)), (Verdict::Cause, vec!["backlash"]));
    let width = &d.causes[0].parameters["width_m"];
    let is_inside = width.ci95[0] < WIDTH_M && width.ci95[1] > WIDTH_M;
    assert!((width.value / WIDTH_M - 1.0).abs() < 0.01 && is_inside, "{width:?}");
    assert!(d.gap.after < 1.25, "{:?}", d.gap);
}

/// From the middle of the play the twin begins up to 10 µm from where the machine does: its first acceleration is early or late. Its width is told by
/// all of the motion, and each run tells where it began.
#[test]
fn exact_a_run_begins_anywhere_in_its_play() {
    let twin = model("grinder");
    assert_play(&told(&twin, &recording(&twin, WIDTH_M)));
}

/// A run that states where it begins is taken at its word, and read by a twin that has no play.
#[test]
fn exact_a_run_may_state_where_it_begins() {
    let twin = model("grinder");
    let mut run = recording(&twin, WIDTH_M).runs()[0].clone();
    let begins = |run: &Run| {
        let experiment = Experiment::new(run, &twin).unwrap();
        assert!(experiment.machine(&twin).unwrap().description().effect.backlash.is_none());
        let set = experiment.machine(&played(&twin, WIDTH_M)).unwrap();
        set.description().effect.backlash.as_ref().unwrap().initial_share
    };
    // What noise moves before the motion is found with it: here a tenth of the play at most.
    assert!((begins(&run) - RUNS[0].1).abs() < 0.2, "{}", begins(&run));
    run.settings.insert("effect.backlash.initial_share".to_owned(), (-0.25).into());
    assert_eq!(begins(&run), -0.25);
}

/// A twin that has the play lacks nothing, wherever in it a run begins, however wide it is.
#[test]
fn exact_a_twin_with_the_play_has_no_gap() {
    for width in [WIDTH_M, WORN_M] {
        let twin = played(&model("grinder"), width);
        let d = told(&twin, &recording(&model("grinder"), width));
        assert_eq!((d.verdict, names(&d)), (Verdict::NoGap, vec![]), "{width}");
    }
}
