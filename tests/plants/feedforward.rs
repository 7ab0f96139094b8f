//! Feed-forward beside the controller: what it takes over, the feedback need not command.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::diagnose::{Options, diagnose};
use slideway::effect::EffectId;
use slideway::error::ErrorKind;
use slideway::identify::loop_response::{Part, measured};
use slideway::machine::Machine;
use slideway::plant::axis::{Axis, LONGEST_STEP_S};
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::feedforward::Direction;
use slideway::replay::recording::recorded;
use slideway::replay::windows::{Input, Restart, Windowed};
use slideway::replay::{Compared, Feedforward, Motion, PlantChoice, Recorded, Stroke};
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
    let recorded = Recorded::of(run, machine).unwrap();
    let axis = Axis::of(&machine.constants());
    let replayed = feedforward.replay(&recorded, machine, axis, Sensing::Perfect);
    let last = |samples: &[f64]| *samples.last().unwrap();
    (last(&replayed.traces.effort_v), last(&replayed.whole_v()), last(&replayed.traces.velocity))
}

fn stating(table: &str) -> Run {
    let mut run = run_up(&machine("emps"), 1.0, 20, 50);
    run.metadata = table.parse().unwrap();
    run
}

#[test]
fn exact_without_feed_forward_it_is_the_plain_replay() {
    let machine = machine("emps/symmetric.toml");
    let recorded = Recorded::of(&run_up(&machine, 1.0, 100, 500), &machine).unwrap();
    let axis = || Axis::of(&machine.constants());
    let plain = recorded.replay(&machine, axis(), Sensing::Perfect);
    let none = Feedforward::default().replay(&recorded, &machine, axis(), Sensing::Perfect);
    assert_eq!(none.traces, plain);
    assert_eq!(none.whole_v(), plain.effort_v);
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
    let velocity_reference = Recorded::of(&run, &machine).unwrap().commands()[799].velocity_reference;
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
    let sliding = Feedforward {
        mass_kg: 1.5,
        coulomb_n: 0.25,
        direction: Direction::Measured,
        ..Feedforward::default()
    };
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

// ---- a feed-forward that a run states -------------------------------------------------------------

/// A table of 20 kg whose positive direction points uphill by `slope` rad, with friction; `controller` as TOML.
fn slide(slope: f64, controller: &str) -> Machine {
    let body = r#"<mass value="20"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>"#;
    let urdf = format!(
        r#"<robot name="axis"><link name="bed"><inertial>{body}</inertial></link><link name="body"><inertial>{body}</inertial></link>
        <joint name="axis" type="prismatic"><parent link="bed"/><child link="body"/><origin xyz="0 0 0.1" rpy="0 {} 0"/>
        <axis xyz="1 0 0"/><limit lower="-10" upper="10" effort="1000" velocity="100"/></joint></robot>"#,
        -slope
    );
    let toml = format!(
        "name = \"axis\"\nurdf = \"machine.urdf\"\njoint = \"axis\"\nsample_period_s = 1e-3\n{controller}
        [motor]\nkind = \"winding\"\nresistance_ohm = 2.0\ninductance_h = 4e-3\nforce_constant_n_per_a = 50.0\n\
        back_emf_v_s_per_m = 30.0\n[guide]\nviscous_n_s_per_m = 80.0\n\
        [effect.coulomb_friction]\nforce_n = 6.0\n[encoder]\nresolution_m = 0.0\nnoise_m = 0.0\n\
        velocity = {{ kind = \"smoothed_difference\", time_constant_s = 2e-3 }}\n"
    );
    let folder = tempfile::TempDir::new().unwrap();
    std::fs::write(folder.path().join("machine.urdf"), urdf).unwrap();
    std::fs::write(folder.path().join("machine.toml"), toml).unwrap();
    Machine::read(folder.path()).unwrap()
}

const CASCADE: &str = "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 80.0\nvelocity_integral_per_s = 10.0\n";
const FED: &str =
    "feedforward = { mass_kg = 18.0, viscous_n_s_per_m = 60.0, coulomb_n = 4.0, weight = true }";

/// There and back with standstill before; what the drive logs is the feedback's share.
fn fed_run(machine: &Machine, stroke: f64) -> (Run, slideway::replay::Traces) {
    let there = Stroke { stroke, feed: 0.2 };
    let strokes = vec![there, Stroke { stroke: -stroke, ..there }];
    let motion = Motion { strokes, lead_s: 0.1, dwell_s: 0.1, ramp_s: 0.05 };
    let reference = motion.reference(machine.description().sample_period_s);
    let signals = BTreeMap::from([
        (Signal::PositionReference, reference.clone()),
        (Signal::Position, vec![0.0; reference.len()]),
    ]);
    let mut told = Run::new("fed", machine.motion(), 1e-3, signals).unwrap();
    told.metadata = FED.parse().unwrap();
    let forward = Feedforward::of(&told).unwrap();
    let planned = Recorded::of(&told, machine).unwrap();
    let made = forward.replay(&planned, machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let mut run = recorded("fed", machine, &reference, made.traces.clone()).unwrap();
    run.metadata = told.metadata;
    (run, made.traces)
}

fn furthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// Closed loop, open loop under the logged effort, and several machines in one pass all get what the run states.
#[test]
fn exact_a_stated_feed_forward_reaches_every_replay() {
    let machine = slide(0.0, CASCADE);
    let (run, made) = fed_run(&machine, 0.05);
    let recorded = Recorded::of(&run, &machine).unwrap();
    let again = recorded.replay(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
    assert!(
        furthest(&again.position, &made.position) < 1e-13
            && furthest(&again.effort_v, &made.effort_v) < 1e-10
    );

    let mut bare = run.clone();
    bare.metadata.remove("feedforward");
    let without = Recorded::of(&bare, &machine).unwrap();
    let without = without.replay(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
    assert!(furthest(&without.effort_v, &made.effort_v) > 0.1, "the feed-forward does nothing");

    let machines: Vec<Machine> = (0..5)
        .map(|k| {
            machine.with_settings([("guide.viscous_n_s_per_m", (70.0 + 5.0 * f64::from(k)).into())]).unwrap()
        })
        .collect();
    for (together, one) in recorded.replay_together(&machines, LONGEST_STEP_S).iter().zip(&machines) {
        let alone = recorded.replay(one, Axis::of(&one.constants()), Sensing::Perfect);
        assert_eq!(*together, alone);
    }

    let first = Restart { sample: 0, position: 0.0, velocity: 0.0 };
    let windowed = Windowed::new(&run, Input::Effort, recorded.start(), vec![first], 4).unwrap();
    let open =
        |windowed: &Windowed| windowed.free_run(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let fed = open(&windowed.clone().fed_forward(recorded.commands()));
    assert!(
        furthest(&fed.position, &made.position) < 1e-12
            && fed.effort_v == run.signal(Signal::ControlEffort).unwrap()
    );
    assert!(furthest(&open(&windowed).position, &made.position) > 1e-3);
}

/// What is hidden beside a feed-forward is found as without one, with and without a stated controller.
#[test]
fn exact_a_diagnosis_of_runs_with_feed_forward_names_what_is_hidden() {
    for controller in [CASCADE, ""] {
        let real = slide(0.0, CASCADE);
        let stated =
            slide(0.0, controller).with_settings([("effect.coulomb_friction.force_n", 0.0.into())]).unwrap();
        let options = Options {
            catalogue: &[EffectId::CoulombFriction, EffectId::ViscousFriction, EffectId::Payload],
            ..Options::default()
        };
        let made = |stroke, role| {
            let (run, _) = fed_run(&real, stroke);
            let name = format!("{stroke}");
            let mut named = Run::new(name, run.motion(), 1e-3, run.signals().clone()).unwrap();
            (named.metadata, named.role) = (run.metadata, Some(role));
            named
        };
        let runs = vec![made(0.05, Role::Training), made(0.03, Role::HeldOut)];
        let found = diagnose(&stated, &Recording::new(runs).unwrap(), &options).unwrap();
        let named: Vec<&str> = found.causes.iter().map(|cause| cause.effect.as_str()).collect();
        assert_eq!(named, ["coulomb_friction"], "{controller}");
        let force = found.causes[0].parameters["force_n"].value;
        assert!((force / 6.0 - 1.0).abs() < 0.01, "{force} N");
    }
}

/// Where the axis stands, a weight that is fed forward leaves the feedback nothing; one that is not, all of it.
#[test]
fn exact_a_weight_fed_forward_is_held_without_feedback() {
    let machine =
        slide(0.3, CASCADE).with_settings([("effect.coulomb_friction.force_n", 0.0.into())]).unwrap();
    let weight = -20.0 * 9.80665 * 0.3_f64.sin();
    let run = run_up(&machine, 0.0, 0, 3000);
    for (is_fed, volts) in [(true, 0.0), (false, -weight * 2.0 / 50.0)] {
        let forward = Feedforward { weight: is_fed, ..Feedforward::default() };
        let (feedback, whole, _) = settled(&machine, &run, &forward);
        assert!(
            (feedback - volts).abs() < SETTLED && (whole + weight * 2.0 / 50.0).abs() < SETTLED,
            "{feedback} V"
        );
    }
}

#[test]
fn exact_a_feed_forward_that_cannot_be_told_is_refused() {
    let machine = slide(0.0, CASCADE);
    let (run, _) = fed_run(&machine, 0.05);
    let without = |signal| {
        let signals =
            run.signals().iter().filter(|(s, _)| **s != signal).map(|(s, x)| (*s, x.clone())).collect();
        let mut less = Run::new("fed", run.motion(), 1e-3, signals).unwrap();
        less.metadata = FED.replace(" }", ", direction = \"measured\" }").parse().unwrap();
        less
    };
    let refused = |run: &Run, key: &str| {
        let error = Compared::of(run, &machine, PlantChoice::Axis).unwrap_err();
        assert_eq!((error.kind(), error.key_name()), (ErrorKind::Missing, Some(key)), "{error}");
    };
    refused(&without(Signal::Velocity), "velocity_m_per_s");
    refused(&without(Signal::PositionReference), "position_reference_m");

    let error = measured(&[&run], Part::Plant, None).unwrap_err();
    assert_eq!(
        (error.kind(), error.key_name()),
        (ErrorKind::Inconsistent, Some("fed.feedforward")),
        "{error}"
    );
}
