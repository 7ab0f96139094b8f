//! Two recordings of one machine with known truth: what changed between them is named, and nothing else.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use slideway::diagnose::grounds::Veto;
use slideway::diagnose::{Diagnosis, Options, Verdict, compare, improved};
use slideway::effect::EffectId;
use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role};
use slideway::report::{Style, terminal};
use slideway::units::Motion;
use std::path::Path;

const COULOMB: &str = "effect.coulomb_friction.force_n";
/// Enough to go wrong with: friction, mass, delay and their rivals, a dead zone among them, which is as good as friction.
const CATALOGUE: [EffectId; 7] = [
    EffectId::LoopDelay,
    EffectId::DeadZone,
    EffectId::ViscousFriction,
    EffectId::CoulombFriction,
    EffectId::AsymmetricFriction,
    EffectId::ConstantForce,
    EffectId::Payload,
];
/// Noise of a small recording leaves the parameters about so uncertain.
const WITHIN: f64 = 0.03;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

/// Strokes there and back with these settings hidden; the seed makes the noise of another day.
fn recording(hidden: &[(&str, f64)], seed: u64) -> Recording {
    let cells = [(0.03, 4.0, Role::Training), (0.04, 16.0, Role::Training), (0.03, 8.0, Role::HeldOut)];
    let stated = machine();
    let real =
        stated.with_settings(hidden.iter().map(|(key, value)| (*key, toml::Value::Float(*value)))).unwrap();
    Strokes::both_ways(&stated, &real, seed).recording(&cells)
}

fn comparison(before: &[(&str, f64)], after: &[(&str, f64)], seed: u64) -> Diagnosis {
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = compare(&machine(), &recording(before, seed), &recording(after, seed + 1), &options).unwrap();
    println!("{before:?} -> {after:?}: {:?}, G {:.2} -> {:.2}", d.verdict, d.gap.before, d.gap.after);
    for cause in d.reference.iter().flat_map(|r| &r.causes).chain(&d.causes) {
        println!("   {} {:?}", cause.effect, cause.parameters);
    }
    // The reference is an ordinary diagnosis of its own.
    let reference = d.reference.as_ref().unwrap();
    let had: Vec<&str> = reference.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!((reference.verdict, had), (Verdict::Cause, vec!["coulomb_friction"]));
    assert_near(reference.causes[0].parameters["force_n"].value, 15.0);
    assert_eq!(reference.causes[0].parameters["force_n"].twin, 0.0);
    assert!(reference.gap_after < 1.25 && reference.gap_before > reference.gap_after);
    d
}

fn named(d: &Diagnosis) -> Vec<&str> {
    d.causes.iter().map(|cause| cause.effect.as_str()).collect()
}

#[track_caller]
fn assert_near(value: f64, expected: f64) {
    assert!((value / expected - 1.0).abs() < WITHIN, "{value}, expected {expected}");
}

#[test]
fn ref_what_came_on_top_is_named_and_what_was_there_is_not() {
    let d = comparison(&[(COULOMB, 15.0)], &[(COULOMB, 15.0), ("effect.payload.mass_kg", 7.0)], 10);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["payload"]));
    let mass = &d.causes[0].parameters["mass_kg"];
    assert_near(mass.value, 7.0);
    assert!(mass.twin.abs() < 0.5, "before: {} kg", mass.twin);
}

/// An effect of the baseline itself, smaller or larger than before.
#[test]
fn ref_a_changed_effect_is_named_with_before_and_after() {
    for (after, seed) in [(9.0, 20), (24.0, 22)] {
        let d = comparison(&[(COULOMB, 15.0)], &[(COULOMB, after)], seed);
        assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["coulomb_friction"]));
        let force = &d.causes[0].parameters["force_n"];
        assert_near(force.twin, 15.0);
        assert_near(force.value, after);
    }
}

#[test]
fn ref_nothing_changed_is_no_gap() {
    let d = comparison(&[(COULOMB, 15.0)], &[(COULOMB, 15.0)], 30);
    assert_eq!((d.verdict, named(&d)), (Verdict::NoGap, vec![]));
}

/// Inside `tolerance.effect` of the value before, a change is calibration.
#[test]
fn ref_a_change_inside_tolerance_is_no_cause() {
    let d = comparison(&[(COULOMB, 15.0)], &[(COULOMB, 15.8)], 40);
    assert_eq!((d.verdict, named(&d)), (Verdict::NoGap, vec![]));
    let moved = d.calibration.iter().find(|c| c.path == COULOMB).unwrap();
    assert_near(moved.parameter.value, 15.8);
    assert_near(moved.parameter.twin, 15.0);
}

/// Friction that the catalogue does not hold: what it leaves of the reference could be taken for noise, and a payload for nothing.
#[test]
fn exact_a_reference_without_an_explanation_withholds_the_comparison() {
    let options = Options { catalogue: &[EffectId::LoopDelay, EffectId::Payload], ..Options::default() };
    let after = [(COULOMB, 15.0), ("effect.payload.mass_kg", 7.0)];
    for (hidden, seed) in [(&after[..1], 70), (&after[..], 72)] {
        let (before, after) = (recording(&[(COULOMB, 15.0)], seed), recording(hidden, seed + 1));
        let d = compare(&machine(), &before, &after, &options).unwrap();
        let reference = d.reference.as_ref().unwrap();
        assert_eq!((reference.verdict, d.verdict), (Verdict::Unknown, Verdict::Unknown));
        assert_eq!(d.withheld.as_ref().unwrap().by, Veto::Reference);
        assert!(d.next_experiment.is_none() && !d.is_found_in_part());
        assert!(improved(&d, &machine()).unwrap().is_none());
        let text = terminal(&d, Motion::Prismatic, Style::default());
        assert!(text.starts_with("REFERENCE NOT EXPLAINED\n"), "{text}");
    }
}

/// What the machine's file states is not found in the reference, but held against both.
#[test]
fn exact_improved_machine_has_causes_and_calibration() {
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let recording = recording(&[(COULOMB, 15.0), ("effect.payload.mass_kg", 0.6)], 50);
    let d = slideway::diagnose::diagnose(&machine(), &recording, &options).unwrap();
    let improved = d.improved(&machine()).unwrap();
    assert_eq!(improved.number(COULOMB), Some(d.causes[0].parameters["force_n"].value));
    for c in &d.calibration {
        assert_eq!(improved.number(&c.path), Some(c.parameter.value), "{}", c.path);
    }
    assert!(d.calibration.iter().any(|c| c.path == "effect.payload.mass_kg"));
}

#[test]
fn exact_reference_of_runs_for_training_alone_is_refused() {
    let whole = recording(&[(COULOMB, 15.0)], 60);
    let mut run = whole.runs()[0].clone();
    run.role = Some(Role::Training);
    let single = Recording::new(vec![run]).unwrap();
    let error = compare(&machine(), &single, &whole, &Options::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::TooLittleData);
}
