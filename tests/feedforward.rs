//! Feed-forward beside the controller: what it takes over, the feedback need not command.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::recording::{Run, Signal};
use slideway::replay::feedforward::Direction;
use slideway::replay::{Feedforward, Recorded};
use slideway::twin::Sensing;
use std::collections::BTreeMap;
use std::path::Path;

/// A loop that has settled agrees with the steady state to rounding; the slowest pole has had 100 time constants.
const SETTLED: f64 = 1e-8;

fn machine(file: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file)).unwrap()
}

/// A run from rest with constant acceleration for `accelerated` samples, then constant velocity.
fn run_up(machine: &Machine, acceleration: f64, accelerated: usize, samples: usize) -> Run {
    let period = machine.description().sample_period_s;
    let (mut position, mut velocity) = (0.0, 0.0);
    let reference: Vec<f64> = (0..samples)
        .map(|k| {
            let at = position;
            velocity += if k < accelerated { acceleration * period } else { 0.0 };
            position += velocity * period;
            at
        })
        .collect();
    let still = vec![0.0; samples];
    let signals = BTreeMap::from([(Signal::PositionReference, reference), (Signal::Position, still)]);
    Run::new("run-up", machine.motion(), period, signals).unwrap()
}

/// Last sample's feedback in V, whole effort in V and velocity.
fn settled(machine: &Machine, run: &Run, feedforward: &Feedforward) -> (f64, f64, f64) {
    let recorded = Recorded::of(run).unwrap();
    let axis = Axis::of(&machine.constants());
    let replayed = feedforward.replay(&recorded, machine, axis, Sensing::Perfect);
    let last = |samples: &[f64]| *samples.last().unwrap();
    (last(&replayed.feedback_v()), last(&replayed.traces.effort_v), last(&replayed.traces.velocity))
}

fn stating(table: &str) -> Run {
    let mut run = run_up(&machine("emps"), 1.0, 20, 50);
    run.metadata = table.parse().unwrap();
    run
}

#[test]
fn exact_without_feed_forward_it_is_the_plain_replay() {
    let machine = machine("emps/symmetric.toml");
    let recorded = Recorded::of(&run_up(&machine, 1.0, 100, 500)).unwrap();
    let axis = || Axis::of(&machine.constants());
    let plain = recorded.replay(&machine, axis(), Sensing::Perfect);
    let none = Feedforward::default().replay(&recorded, &machine, axis(), Sensing::Perfect);
    assert_eq!(none.traces, plain);
    assert_eq!(none.feedback_v(), plain.effort_v);
}

/// At constant velocity the whole effort is the published friction; what is fed forward of it, feedback is spared.
#[test]
fn exact_steady_feedback_is_the_friction_that_is_not_fed_forward() {
    let machine = machine("emps/symmetric.toml");
    let (viscous, coulomb, offset, force_per_volt) = (203.5034, 20.3935, -3.1648, 35.15065188248547);
    let run = run_up(&machine, 1.0, 100, 2500);
    let plain = Feedforward::default();
    let half = Feedforward { viscous_n_s_per_m: 0.5 * viscous, ..plain };
    let all = Feedforward { mass_kg: 95.0, viscous_n_s_per_m: viscous, coulomb_n: coulomb, ..plain };
    let measured = Feedforward { direction: Direction::Measured, ..all };
    for (feedforward, left) in [
        (plain, viscous * 0.1 + coulomb + offset),
        (half, 0.5 * viscous * 0.1 + coulomb + offset),
        (all, offset),
        (measured, offset),
    ] {
        let (feedback, whole, velocity) = settled(&machine, &run, &feedforward);
        assert!((velocity - 0.1).abs() < SETTLED, "{velocity}");
        assert!((force_per_volt * feedback - left).abs() < 1e3 * SETTLED, "{feedback} V");
        assert!(
            (force_per_volt * whole - (viscous * 0.1 + coulomb + offset)).abs() < 1e3 * SETTLED,
            "{whole} V"
        );
    }
}

/// At constant acceleration without friction the whole effort is m·a.
#[test]
fn exact_inertia_fed_forward_leaves_the_feedback_nothing() {
    let machine = machine("emps");
    let mass = machine.constants().moving_mass;
    let run = run_up(&machine, 0.1, 1500, 1500);
    let feedforward = Feedforward { mass_kg: mass, ..Feedforward::default() };
    let (feedback, whole, _) = settled(&machine, &run, &feedforward);
    assert!((whole * 35.15065188248547 - mass * 0.1).abs() < 1e3 * SETTLED, "{whole} V");
    assert!(feedback.abs() < 1e3 * SETTLED, "{feedback} V");
}

/// A winding needs the voltage of its steady current and of its back-EMF.
#[test]
fn exact_winding_is_fed_its_steady_voltage() {
    let machine = machine("grinder").with_settings([("motor.back_emf_v_s_per_m", 20.0.into())]).unwrap();
    let drag = machine.constants().viscous;
    let run = run_up(&machine, 1.0, 400, 800);
    let feedforward = Feedforward { viscous_n_s_per_m: drag, ..Feedforward::default() };
    let (feedback, whole, velocity) = settled(&machine, &run, &feedforward);
    let velocity_reference = Recorded::of(&run).unwrap().commands()[799].velocity_reference;
    let fed = 1.3 * drag * velocity_reference / 83.1 + 20.0 * velocity_reference;
    assert!(
        (whole - feedback - fed).abs() < SETTLED,
        "{whole} − {feedback} V at {velocity} m/s, expected {fed}"
    );
}

#[test]
fn exact_coulomb_part_follows_the_sign_and_is_zero_at_rest() {
    let friction =
        Feedforward { coulomb_n: 3.0, viscous_n_s_per_m: 2.0, mass_kg: 5.0, ..Feedforward::default() };
    assert_eq!(friction.force(0.5, -1.0, -0.1), 2.5 - 2.0 - 3.0);
    assert_eq!(friction.force(0.0, 0.0, 0.0), 0.0);
    assert_eq!(friction.force(0.0, 0.0, -0.0), 0.0);
}

#[test]
fn exact_stated_feed_forward_is_read_under_either_kind_of_name() {
    let read = |table| Feedforward::of(&stating(table)).unwrap();
    assert_eq!(read("stroke_m = 0.02"), Feedforward::default());
    let turning = read("feedforward = { inertia_kg_m2 = 1.5, coulomb_nm = 0.25, direction = \"measured\" }");
    let sliding =
        Feedforward { mass_kg: 1.5, coulomb_n: 0.25, direction: Direction::Measured, viscous_n_s_per_m: 0.0 };
    assert_eq!(turning, sliding);
}

#[test]
fn exact_wrong_feed_forward_is_refused() {
    for (table, kind, words) in [
        ("feedforward = { mass_g = 3.0 }", ErrorKind::UnknownKey, "mass_g"),
        ("feedforward = 3.0", ErrorKind::Syntax, "3"),
        ("feedforward = { mass_kg = nan }", ErrorKind::NotFinite, "NaN"),
    ] {
        let error = Feedforward::of(&stating(table)).unwrap_err();
        assert_eq!(error.kind(), kind, "{error}");
        assert_eq!(error.key_name(), Some("run-up.feedforward"));
        assert!(error.to_string().contains(words) && error.remedy_text().is_some(), "{error}");
    }
}
