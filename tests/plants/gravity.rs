//! Weight along the joint: closed forms of falling, swinging and sticking, and the plants against each other.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;
use std::path::Path;

use super::batch::assert_same;
use crate::support::{self, strokes::Strokes};
use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use slideway::diagnose::{Options, Verdict, diagnose};
use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::Plant;
use slideway::plant::axis::Axis;
#[cfg(feature = "mujoco")]
use slideway::plant::mujoco::MujocoRig;
use slideway::plant::rapier::Rig;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::excitation::Excitation;
use slideway::replay::recording::recorded;
use slideway::replay::{Motion, PlantChoice, Recorded, Stroke, follow, simulate};
use slideway::solid::{GRAVITY_M_PER_S2, Solid};
use slideway::twin::{Command, Driven, Sensing, Twin};
use tempfile::TempDir;

/// Rounding of some 10⁴ additions of numbers around 1.
const ROUNDING: f64 = 1e-11;

// ---- machines ------------------------------------------------------------------------------------

/// A body of `mass` with its centre at `centre` on a joint, both as URDF text.
fn urdf(joint: &str, [mass, ixx, iyy, izz]: [f64; 4], centre: &str) -> String {
    let bed = r#"<inertial><mass value="50"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    format!(
        r#"<robot name="axis"><link name="bed">{bed}</link><link name="body"><inertial><origin xyz="{centre}"/>
        <mass value="{mass}"/><inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="axis" {joint}</joint></robot>"#
    )
}

const LINKS: &str = r#"<parent link="bed"/><child link="body"/>"#;
const TABLE: [f64; 4] = [20.0, 0.5, 0.5, 0.5];
/// Mass, distance of the centre from the axis, moment of inertia about the axis.
const ARM: [f64; 3] = [2.0, 0.15, 0.06];

/// A table whose positive direction points uphill by `slope` rad.
fn slide(slope: f64) -> String {
    let joint = format!(
        r#"type="prismatic">{LINKS}<origin xyz="0 0 0.1" rpy="0 {} 0"/><axis xyz="1 0 0"/>
        <limit lower="-100" upper="100" effort="1000" velocity="100"/>"#,
        -slope
    );
    urdf(&joint, TABLE, "0.02 0.01 0.03")
}

/// An arm that hangs at q = 0 and turns about a level axis.
fn pendulum() -> String {
    let [mass, length, inertia] = ARM;
    let about_centre = inertia - mass * length * length;
    let joint = format!(r#"type="continuous">{LINKS}<origin xyz="0.1 0 0.5"/><axis xyz="0 1 0"/>"#);
    urdf(&joint, [mass, about_centre, about_centre, about_centre], &format!("0 0.04 {}", -length))
}

const DIRECT: &str = "sample_period_s = 250e-6\n[motor]\nkind = \"direct\"\nforce_n_per_v = 10.0\n\
    [encoder]\nresolution_m = 0.0\nnoise_m = 0.0\nvelocity = { kind = \"taps\", taps = [1.0, -1.0] }\n";

fn read(urdf: &str, parts: &str) -> Machine {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("machine.urdf"), urdf).unwrap();
    let toml = format!("name = \"axis\"\nurdf = \"machine.urdf\"\njoint = \"axis\"\n{parts}");
    let toml = support::keys_for(urdf, &toml);
    fs::write(folder.path().join("machine.toml"), toml).unwrap();
    Machine::read(folder.path()).unwrap()
}

fn with(machine: &Machine, settings: &[(&str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, v)| (*key, toml::Value::Float(*v)))).unwrap()
}

/// The worktable with its drive, controller and base on a joint that is tilted by `slope`.
fn tilted_worktable(slope: f64) -> Machine {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let text = fs::read_to_string(from.join("machine.urdf")).unwrap();
    let level = r#"<origin xyz="0 0 0.04" rpy="0 0 0"/>"#;
    assert_eq!(text.matches(level).count(), 1);
    let tilted = format!(r#"<origin xyz="0 0 0.04" rpy="0 {} 0"/>"#, -slope);
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("machine.urdf"), text.replace(level, &tilted)).unwrap();
    fs::copy(from.join("machine.toml"), folder.path().join("machine.toml")).unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    for entry in fs::read_dir(from.join("meshes")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.path().join("meshes").join(path.file_name().unwrap())).unwrap();
    }
    Machine::read(folder.path()).unwrap()
}

// ---- twins ---------------------------------------------------------------------------------------

fn axis(machine: &Machine) -> Twin<Axis> {
    Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect)
}

fn rapier(machine: &Machine) -> Twin<Rig> {
    Twin::new(machine, Rig::new(machine).unwrap(), Sensing::Perfect)
}

#[cfg(feature = "mujoco")]
fn mujoco(machine: &Machine) -> Twin<MujocoRig> {
    Twin::new(machine, MujocoRig::new(machine).unwrap(), Sensing::Perfect)
}

const NO_FORCE: Command = Command { thrust: Some(0.0), ..Command::follow(0.0, 0.0) };

/// Positions and velocities at the samples, motor without force, from a position with a velocity.
fn left_alone<P: Plant>(twin: &mut Twin<P>, [position, velocity]: [f64; 2], seconds: f64) -> Vec<[f64; 2]> {
    twin.start(position, velocity, 0.0);
    let samples = (seconds / twin.period_s()).round() as usize;
    let mut states = vec![twin.state()];
    for _ in 0..samples {
        twin.step(NO_FORCE);
        states.push(twin.state());
    }
    states
}

// ---- the law -------------------------------------------------------------------------------------

#[test]
fn exact_level_and_balanced_machines_have_no_weight_along_the_joint() {
    for name in ["delta_a3", "emps", "grinder", "grinder_yaxis"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name);
        assert_eq!(Machine::read(&path).unwrap().weight(), None, "{name}");
    }
    // A pendulum about an upright axis swings level.
    let upright = pendulum().replace(r#"<axis xyz="0 1 0"/>"#, r#"<axis xyz="0 0 1"/>"#);
    assert_eq!(read(&upright.replace("0 0.04 -0.15", "0.2 0.1 0.3"), DIRECT).weight(), None);
    assert!(read(&pendulum(), DIRECT).weight().is_some());
}

#[test]
fn exact_weight_of_a_slope_and_of_a_pendulum() {
    let slope = read(&slide(0.3), DIRECT);
    let weight = slope.weight().unwrap();
    assert!((weight.effort(0.7) + 20.0 * GRAVITY_M_PER_S2 * 0.3_f64.sin()).abs() < ROUNDING);
    assert!(weight.is_constant() && weight.hanging_rad().is_none());
    // The payload of a prismatic axis weighs too.
    let loaded = with(&slope, &[("effect.payload.mass_kg", 5.0)]).weight().unwrap();
    assert!((loaded.effort(0.0) / weight.effort(0.0) - 1.25).abs() < ROUNDING);
    let weight = read(&pendulum(), DIRECT).weight().unwrap();
    let [mass, length, _] = ARM;
    for angle in [-3.0, -1.0, 0.0, 0.2, 2.0, 40.0_f64] {
        let restoring = -mass * GRAVITY_M_PER_S2 * length * angle.sin();
        assert!((weight.effort(angle) - restoring).abs() < ROUNDING, "{angle}");
    }
    assert!(weight.hanging_rad().unwrap().abs() < ROUNDING);
    assert!((weight.largest() - mass * GRAVITY_M_PER_S2 * length).abs() < ROUNDING);
}

/// Height of the centre of mass in the base's frame at a position of the joint.
fn height(solid: &Solid, position: f64) -> f64 {
    let joint = &solid.joint;
    let turned = UnitQuaternion::from_axis_angle(&joint.axis, position);
    (joint.origin.rotation * (turned * solid.moving.mass.centre_m)).z
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// W = −d(m·g·z)/dq for any axis, any centre, any place of the joint, and it is zero where the centre hangs lowest.
    #[test]
    fn exact_weight_is_the_slope_of_potential_energy(
        centre in [-0.3..0.3, -0.3..0.3, -0.3..0.3f64],
        turned in [-3.0..3.0, -1.5..1.5, -3.0..3.0f64],
        along in [-1.0..1.0, -1.0..1.0, 0.2..1.0f64],
        angle in -6.0..6.0f64,
    ) {
        let joint = format!(
            r#"type="continuous">{LINKS}<origin xyz="0.1 0.2 0.3" rpy="{} {} {}"/><axis xyz="{} {} {}"/>"#,
            turned[0], turned[1], turned[2], along[0], along[1], along[2]
        );
        let machine = read(&urdf(&joint, [3.0, 0.2, 0.3, 0.4], &format!("{} {} {}", centre[0], centre[1], centre[2])), DIRECT);
        let (solid, weight) = (machine.solid(), machine.weight().unwrap());
        let step = 1e-5;
        let slope = (height(solid, angle + step) - height(solid, angle - step)) / (2.0 * step);
        // Rounding of the difference, and its error of second order.
        prop_assert!((weight.effort(angle) + 3.0 * GRAVITY_M_PER_S2 * slope).abs() < 1e-8);
        let hanging = weight.hanging_rad().unwrap();
        for other in [0.5, 2.0, 4.0] {
            prop_assert!(height(solid, hanging) <= height(solid, hanging + other));
        }
        prop_assert!(weight.effort(hanging).abs() < 1e-12);
    }
}

// ---- falling and swinging ------------------------------------------------------------------------

fn assert_falls<P: Plant>(mut twin: Twin<P>, slope: f64, name: &str) {
    let acceleration = -GRAVITY_M_PER_S2 * slope.sin();
    let states = left_alone(&mut twin, [0.5, 1.0], 1.0);
    let worst = states.iter().enumerate().fold(0.0, |worst: f64, (k, [position, velocity])| {
        let time = k as f64 * 250e-6;
        let way = 0.5 + time + 0.5 * acceleration * time * time;
        worst.max((position - way).abs()).max((velocity - 1.0 - acceleration * time).abs())
    });
    println!("{name}: {worst:.1e}");
    assert!(worst < ROUNDING, "{name}: {worst:e}");
}

/// s = v·t − ½·g·sin α·t², with a payload that falls no faster.
#[test]
fn exact_a_tilted_table_falls_by_the_sine_of_its_slope() {
    for slope in [0.1, -0.7, FRAC_PI_2] {
        let machine = with(&read(&slide(slope), DIRECT), &[("effect.payload.mass_kg", 7.0)]);
        assert_falls(axis(&machine), slope, "axis");
        assert_falls(rapier(&machine), slope, "rapier");
        #[cfg(feature = "mujoco")]
        assert_falls(mujoco(&machine), slope, "MuJoCo");
    }
}

/// Period of a physical pendulum that swings to `amplitude`: 2π·√(J/(m·g·l))/agm(1, cos ½θ₀), Gauss' form of the complete
/// elliptic integral of the first kind.
fn period(amplitude: f64) -> f64 {
    let [mass, length, inertia] = ARM;
    period_of(amplitude, inertia, mass * GRAVITY_M_PER_S2 * length)
}

/// The same of an inertia that hangs with a torque of `weight_nm` at right angles.
fn period_of(amplitude: f64, inertia: f64, weight_nm: f64) -> f64 {
    let (mut a, mut b) = (1.0, (0.5 * amplitude).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    TAU * (inertia / weight_nm).sqrt() / a
}

/// Times at which the arm passes its lowest place, by the parabola between two samples.
fn passes(states: &[[f64; 2]]) -> Vec<f64> {
    let step = 250e-6;
    let pairs = states.windows(2).enumerate().filter(|(_, w)| w[0][0] * w[1][0] < 0.0);
    pairs
        .map(|(k, w)| {
            // Velocity is stationary there: its mean over the step is that at the passage to third order.
            let speed = (w[1][0] - w[0][0]) / step;
            k as f64 * step - w[0][0] / speed
        })
        .collect()
}

fn energy([angle, speed]: [f64; 2]) -> f64 {
    let [mass, length, inertia] = ARM;
    0.5 * inertia * speed * speed + mass * GRAVITY_M_PER_S2 * length * (1.0 - angle.cos())
}

/// Swings for ten seconds: relative error of the period and of the energy.
fn swing<P: Plant>(mut twin: Twin<P>, amplitude: f64) -> [f64; 2] {
    let states = left_alone(&mut twin, [amplitude, 0.0], 10.0);
    let passed = passes(&states);
    let last = passed.len() - 1;
    assert!(last > 6);
    // From the release to the last passage: a quarter and `last` half periods.
    let found = passed[last] / (0.25 + 0.5 * last as f64);
    let begun = energy(states[0]);
    let lost = states.iter().fold(0.0, |worst: f64, s| worst.max((energy(*s) / begun - 1.0).abs()));
    [(found / period(amplitude) - 1.0).abs(), lost]
}

/// What a period may be off by.
///
/// The weight is taken at two points of a way known to third order in the step: with ω = 7 rad/s and h = 250 µs
/// (axis) a share (ω·h)⁴ = 1e-11 of the stiffness, and as much of the half step by which rapier's coordinate leads.
const PERIOD: f64 = 1e-9;
/// The same for the energy.
const ENERGY: f64 = 1e-9;

fn assert_swings<P: Plant>(make: impl Fn() -> Twin<P>, name: &str) {
    for amplitude in [1e-3, 0.5, 2.0, 3.0] {
        let [period, energy] = swing(make(), amplitude);
        println!("{name}, {amplitude} rad: period off by {period:.1e}, energy by {energy:.1e}");
        assert!(period < PERIOD, "{name}, {amplitude} rad: {period:e}");
        assert!(energy < ENERGY, "{name}, {amplitude} rad: {energy:e}");
    }
}

#[test]
fn exact_period_and_energy_of_a_pendulum_at_any_amplitude() {
    let machine = read(&pendulum(), DIRECT);
    assert_swings(|| axis(&machine), "axis");
    assert_swings(|| rapier(&machine), "rapier");
    #[cfg(feature = "mujoco")]
    assert_swings(|| mujoco(&machine), "MuJoCo");
}

// ---- payload at a lever ---------------------------------------------------------------------------

/// 0.5 kg at 0.3 m that hangs at a quarter turn, with 0.004 kg·m² about its own centre.
const LEVER: [(&str, f64); 4] = [
    ("effect.payload.inertia_kg_m2", 0.004),
    ("effect.payload.lever_mass_kg", 0.5),
    ("effect.payload.lever_m", 0.3),
    ("effect.payload.hangs_at_rad", FRAC_PI_2),
];

/// Inertia about the axis, weight at right angles and place of rest of the arm with that payload, by vectors.
fn loaded_arm() -> [f64; 3] {
    let [mass, length, inertia] = ARM;
    let [own, carried] = [mass * GRAVITY_M_PER_S2 * length, 0.5 * GRAVITY_M_PER_S2 * 0.3];
    [inertia + 0.004 + 0.5 * 0.3 * 0.3, own.hypot(carried), carried.atan2(own)]
}

#[test]
fn exact_a_payload_at_a_lever_weighs_where_it_hangs() {
    let bare = read(&pendulum(), DIRECT);
    let machine = with(&bare, &LEVER);
    let [inertia, most, rest] = loaded_arm();
    assert!((machine.constants().moving_mass / inertia - 1.0).abs() < ROUNDING);
    let weight = machine.weight().unwrap();
    assert!(
        (weight.hanging_rad().unwrap() - rest).abs() < ROUNDING
            && (weight.largest() / most - 1.0).abs() < ROUNDING
    );
    for position in [-2.0, 0.0, 0.7, 3.0] {
        assert!((weight.effort(position) - most * f64::sin(rest - position)).abs() < ROUNDING, "{position}");
    }
    // Without a place of its own it hangs where the arm does; without a mass at the lever nothing changes.
    let along = with(&bare, &LEVER[..3]).weight().unwrap();
    assert!(along.hanging_rad().unwrap().abs() < ROUNDING);
    assert!((along.largest() - (2.0 * 0.15 + 0.5 * 0.3) * GRAVITY_M_PER_S2).abs() < ROUNDING);
    assert_eq!(with(&bare, &LEVER[..1]).weight(), bare.weight());
}

fn assert_loaded_swings<P: Plant>(mut twin: Twin<P>, name: &str) {
    let [inertia, most, rest] = loaded_arm();
    let states: Vec<[f64; 2]> = left_alone(&mut twin, [rest + 2.0, 0.0], 5.0)
        .iter()
        .map(|[angle, speed]| [angle - rest, *speed])
        .collect();
    let passed = passes(&states);
    let last = passed.len() - 1;
    assert!(last > 4);
    let found = passed[last] / (0.25 + 0.5 * last as f64) / period_of(2.0, inertia, most) - 1.0;
    let energy = |[angle, speed]: &[f64; 2]| 0.5 * inertia * speed * speed + most * (1.0 - angle.cos());
    let lost = states.iter().map(|s| (energy(s) / energy(&states[0]) - 1.0).abs()).fold(0.0, f64::max);
    println!("{name} with payload: period off by {found:.1e}, energy by {lost:.1e}");
    assert!(found.abs() < PERIOD && lost < ENERGY, "{name}: {found:e}, {lost:e}");
}

/// Released two radians from where it rests, the loaded arm swings with the period of Gauss' form on either plant.
#[test]
fn exact_a_pendulum_swings_with_its_payload() {
    let machine = with(&read(&pendulum(), DIRECT), &LEVER);
    assert_loaded_swings(axis(&machine), "axis");
    assert_loaded_swings(rapier(&machine), "rapier");
}

#[test]
fn exact_a_lever_that_means_nothing_is_refused() {
    let refused = |machine: &Machine, settings: &[(&str, f64)], words: &str| {
        let settings = settings.iter().map(|(key, value)| (*key, toml::Value::Float(*value)));
        let error = machine.with_settings(settings).unwrap_err();
        let (text, key) = (error.to_string(), error.key_name().unwrap_or_default());
        assert!(key.starts_with("effect.payload") && text.contains(words), "{text}");
    };
    refused(&read(&slide(0.3), DIRECT), &LEVER, "slides");
    let balanced = read(&pendulum().replace("0 0.04 -0.15", "0 0.04 0"), DIRECT);
    assert_eq!(balanced.weight(), None);
    refused(&balanced, &LEVER[..3], "balanced");
    assert!((with(&balanced, &LEVER).weight().unwrap().hanging_rad().unwrap() - FRAC_PI_2).abs() < ROUNDING);
    let arm = read(&pendulum(), DIRECT);
    refused(&arm, &[LEVER[0], LEVER[2]], "lever_mass_kg");
    refused(&arm, &LEVER[..2], "lever_m");
    refused(&arm, &[LEVER[0], ("effect.payload.lever_mass_kg", -3.0), LEVER[2], LEVER[3]], "mass");
    #[cfg(feature = "mujoco")]
    assert_eq!(MujocoRig::new(&with(&arm, &LEVER)).err().unwrap().key_name(), Some("effect.payload.lever_m"));
}

// ---- sticking ------------------------------------------------------------------------------------

/// A table that rests on a slope of tan⁻¹ μ with friction μ·m·g·cos α: it stays just below, and slides just above with
/// g·(sin α − μ·cos α).
fn assert_sticks<P: Plant>(make: impl Fn(&Machine) -> Twin<P>, name: &str) {
    let friction = 0.2;
    let edge = f64::atan(friction);
    for (slope, slides) in
        [(edge - 1e-4, false), (edge + 1e-4, true), (-edge + 1e-4, false), (-edge - 1e-4, true)]
    {
        let normal = 20.0 * GRAVITY_M_PER_S2 * slope.cos();
        let machine =
            with(&read(&slide(slope), DIRECT), &[("effect.coulomb_friction.force_n", friction * normal)]);
        let end = left_alone(&mut make(&machine), [0.0, 0.0], 1.0).last().copied().unwrap();
        let driven = GRAVITY_M_PER_S2 * (slope.sin().abs() - friction * slope.cos()).max(0.0);
        let way = -slope.signum() * 0.5 * driven;
        println!("{name}, slope {slope:.4}: {:e} m, expected {way:e} m", end[0]);
        assert_eq!(slides, way != 0.0);
        assert!((end[0] - way).abs() < ROUNDING, "{name}, {slope}: {:e}", end[0]);
    }
}

#[test]
fn exact_a_table_sticks_below_the_angle_of_friction_and_slips_above() {
    assert_sticks(axis, "axis");
    assert_sticks(rapier, "rapier");
    #[cfg(feature = "mujoco")]
    assert_sticks(mujoco, "MuJoCo");
}

/// A pendulum with Coulomb friction rests where weight is below it, at any such angle, and falls from beyond.
fn assert_arm_rests<P: Plant>(make: impl Fn(&Machine) -> Twin<P>, name: &str) {
    let [mass, length, _] = ARM;
    let limit = mass * GRAVITY_M_PER_S2 * length * f64::sin(0.4);
    let machine = with(&read(&pendulum(), DIRECT), &[("effect.coulomb_friction.torque_nm", limit)]);
    for angle in [0.399, -0.399, PI - 0.399, 0.0] {
        let end = left_alone(&mut make(&machine), [angle, 0.0], 2.0).last().copied().unwrap();
        println!("{name}, {angle} rad: creeps {:e} rad", end[0] - angle);
        assert!((end[0] - angle).abs() < ROUNDING, "{name}, {angle}: {:e}", end[0] - angle);
    }
    let end = left_alone(&mut make(&machine), [0.41, 0.0], 2.0).last().copied().unwrap();
    assert!(end[0] < 0.4 && end[1].abs() < 1e-9, "{name}: {end:?}");
}

#[test]
fn exact_an_arm_with_friction_rests_where_its_weight_is_below_it() {
    assert_arm_rests(axis, "axis");
    assert_arm_rests(rapier, "rapier");
    #[cfg(feature = "mujoco")]
    assert_arm_rests(mujoco, "MuJoCo");
}

// ---- plants against each other -------------------------------------------------------------------

const CASCADE: &str = "sample_period_s = 1e-3\n[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\n\
    velocity_gain_v_s_per_rad = 0.4\n[motor]\nkind = \"direct\"\ntorque_nm_per_v = 3.0\n\
    [guide]\nviscous_nm_s_per_rad = 0.02\n\
    [encoder]\nresolution_rad = 0.0\nnoise_rad = 0.0\nvelocity = { kind = \"taps\", taps = [1.0, -1.0] }\n";

fn commands(machine: &Machine, stroke: f64, feed: f64) -> Vec<Command> {
    let there = Stroke::new(stroke, feed).unwrap();
    let strokes = vec![there, Stroke { stroke: -stroke, ..there }];
    let motion = Motion { strokes, lead_s: 0.02, dwell_s: 0.5, ramp_s: 0.02 };
    let period = machine.description().sample_period_s;
    follow(&motion.reference(period), period).collect()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

fn assert_parity(machine: &Machine, commands: &[Command], within: f64, name: &str) {
    let walk = |twin: &mut dyn FnMut(Command) -> f64| commands.iter().map(|c| twin(*c)).collect::<Vec<f64>>();
    let (mut ours, mut scene) = (axis(machine), rapier(machine));
    let ours = walk(&mut |command| ours.step(command).position);
    let scene = walk(&mut |command| scene.step(command).position);
    let moved = ours.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    assert!(moved > 0.01, "{name}: nothing moves");
    println!("{name}: axis and rapier {:.1e}", rms(&ours, &scene));
    assert!(rms(&ours, &scene) < within, "{name}: {:e}", rms(&ours, &scene));
    #[cfg(feature = "mujoco")]
    {
        let mut theirs = mujoco(machine);
        let theirs = walk(&mut |command| theirs.step(command).position);
        println!("{name}: axis and MuJoCo {:.1e}", rms(&ours, &theirs));
        assert!(rms(&ours, &theirs) < within, "{name}: {:e}", rms(&ours, &theirs));
    }
}

/// What the worktable's plants may differ by, as on the level (`tests/plants/parity.rs`): a hundredth of the encoder's noise.
const PARITY_M: f64 = 0.3e-9;

/// The same where weight throws the table into friction from rest: each plant resolves stops and starts to second order in its
/// own step, and they come to 0.35 nm.
const PARITY_STICKING_M: f64 = 1e-9;

/// Drive, delay-free loop, five base modes: the table sinks, is caught, strokes up and down; then with friction and payload.
#[test]
fn ref_plants_agree_on_a_tilted_table_under_its_controller() {
    let machine = tilted_worktable(0.35);
    let commands = commands(&machine, 0.03, 0.2667);
    assert_parity(&machine, &commands, PARITY_M, "tilted");
    let loaded =
        with(&machine, &[("effect.coulomb_friction.force_n", 15.0), ("effect.payload.mass_kg", 9.0)]);
    assert_parity(&loaded, &commands, PARITY_STICKING_M, "tilted, friction and payload");
}

/// What the pendulum's plants may differ by while a controller holds it: (ω·h)² = 3e-6 of a step's way, at most 1e-3 rad.
const PARITY_RAD: f64 = 1e-9;
/// The same left alone for 3 s, where nothing brings an error back. Rapier's step takes a changing torque as its mean; what drag
/// makes of the change is c/J·h²/12·ΔW/J = 0.33·3.3e-10·98 = 1e-8 rad/s at most.
const PARITY_ALONE_RAD: f64 = 3e-8;
/// The same with friction, along which rapier's rig does not take the weight: k/J·F_c/J·h²/6 = 49·8·6.5e-10 = 3e-7 rad/s² on
/// a loop of 400 s⁻², and stops to second order in the axis' step.
const PARITY_STICKING_RAD: f64 = 1e-8;

#[test]
fn ref_plants_agree_on_a_pendulum_under_its_controller() {
    let machine = read(&pendulum(), CASCADE);
    let commands = commands(&machine, 2.0, 4.0);
    assert_parity(&machine, &commands, PARITY_RAD, "pendulum");
    let falling = vec![NO_FORCE; 3000];
    let mut pushed = falling.clone();
    pushed.iter_mut().take(200).for_each(|command| command.thrust = Some(2.5));
    assert_parity(&machine, &pushed, PARITY_ALONE_RAD, "pendulum, pushed and left");
    let rubbing = with(&machine, &[("effect.coulomb_friction.torque_nm", 0.5)]);
    assert_parity(&rubbing, &commands, PARITY_STICKING_RAD, "pendulum with friction");
}

/// Base modes and all: what an axis does whose motor holds its weight from the start is nothing.
#[test]
fn exact_a_held_weight_does_not_set_the_base_ringing() {
    let machine = tilted_worktable(0.35);
    let hold = -machine.weight().unwrap().effort(0.0);
    fn worst<P: Plant>(mut twin: Twin<P>, hold: f64) -> f64 {
        let held = Command { thrust: Some(hold), ..NO_FORCE };
        (0..4000).fold(0.0, |worst, _| {
            twin.step(held);
            worst.max(twin.state()[0].abs())
        })
    }
    for (name, moved) in [("axis", worst(axis(&machine), hold)), ("rapier", worst(rapier(&machine), hold))] {
        println!("{name}: {moved:e} m");
        assert!(moved < ROUNDING, "{name}: {moved:e}");
    }
    #[cfg(feature = "mujoco")]
    assert!(worst(mujoco(&machine), hold) < ROUNDING);
}

/// Sliders carry the part of the weight across the guide, in the scene and in the model that stands for it.
#[test]
fn exact_sliders_of_a_tilted_table_carry_the_weight_across_the_guide() {
    let machine = tilted_worktable(0.35);
    let across = machine.constants().moving_mass * GRAVITY_M_PER_S2 * 0.35_f64.cos();
    let model = slideway::plant::LoadModel::of(&machine).unwrap().loads([0.0; 2]);
    let mut rig = Rig::new(&machine).unwrap();
    let scene = rig.slider_loads().unwrap();
    assert!((model.iter().sum::<f64>() - across).abs() < 1e-9, "{model:?}");
    for (ours, theirs) in model.iter().zip(scene) {
        assert!((ours - theirs).abs() < 1e-9, "{model:?} {scene:?}");
    }
}

// ---- several at once -----------------------------------------------------------------------------

#[test]
fn exact_a_batch_with_weight_is_its_twins_one_by_one() {
    for machine in [tilted_worktable(0.35), read(&pendulum(), CASCADE)] {
        let revolute = machine.motion() == slideway::units::Motion::Revolute;
        let [payload, coulomb] = if revolute {
            [("effect.payload.inertia_kg_m2", 0.01), ("effect.coulomb_friction.torque_nm", 0.3)]
        } else {
            [("effect.payload.mass_kg", 4.0), ("effect.coulomb_friction.force_n", 15.0)]
        };
        let machines = [
            machine.clone(),
            with(&machine, &[payload]),
            with(&machine, &[coulomb]),
            with(&machine, &[payload, coulomb]),
        ];
        let (stroke, feed) = if revolute { (2.0, 4.0) } else { (0.03, 0.2667) };
        let commands = commands(&machine, stroke, feed);
        assert_same(&machines, Driven::ByControllers, &commands, "controllers");
        let by_effort: Vec<Command> = (0..2000)
            .map(|k| Command { effort_v: Some((k as f64 * 0.01).sin()), ..Command::follow(0.0, 0.0) })
            .collect();
        assert_same(&machines, Driven::ByEffort, &by_effort, "effort");
        let by_force: Vec<Command> =
            by_effort.iter().map(|c| Command { thrust: c.effort_v, ..NO_FORCE }).collect();
        assert_same(&machines, Driven::ByForce, &by_force, "force");
    }
}

// ---- refusals ------------------------------------------------------------------------------------

#[test]
fn exact_an_axis_that_would_fall_is_refused_by_the_open_loop_experiment() {
    let excitation = Excitation { period_s: 0.025, samples: 20, seed: 1 };
    for plant in [PlantChoice::Axis, PlantChoice::Rapier] {
        let refused = excitation.run(&read(&slide(0.2), DIRECT), plant).unwrap_err();
        assert_eq!(
            (refused.kind(), refused.key_name()),
            (ErrorKind::Inconsistent, Some("axis")),
            "{refused}"
        );
        assert!(excitation.run(&read(&slide(0.0), DIRECT), plant).is_ok());
    }
}

/// A replayed stroke begins where the loop has caught the weight.
#[test]
fn exact_a_simulated_stroke_holds_the_weight_before_it_begins() {
    let machine = tilted_worktable(0.35);
    let period = machine.description().sample_period_s;
    let reference = vec![0.0; (0.05 / period) as usize];
    let traces = simulate(&machine, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).unwrap();
    let weight = machine.weight().unwrap().effort(0.0);
    for (position, thrust) in traces.position.iter().zip(&traces.thrust) {
        assert!(position.abs() < 1e-9 && (thrust / weight + 1.0).abs() < 1e-6, "{position:e} m, {thrust} N");
    }
}

// ---- diagnosis -----------------------------------------------------------------------------------

/// Weight is part of the solid model: a tilted table with nothing hidden has no gap, and hidden friction is named as such,
/// not as a spring or a constant force.
#[test]
fn exact_a_diagnosis_on_a_slope_is_undisturbed_by_weight() {
    let machine = tilted_worktable(0.03);
    for hidden in [0.0, 15.0] {
        let real = match hidden {
            0.0 => machine.clone(),
            force => with(&machine, &[("effect.coulomb_friction.force_n", force)]),
        };
        let strokes = Strokes { plant: PlantChoice::Rapier, ..Strokes::both_ways(&machine, &real, 5) };
        let cells = [
            (0.03, 8.0, Role::Training),
            (0.05, 16.0, Role::Training),
            (0.02, 8.0, Role::HeldOut),
            (0.03, 16.0, Role::HeldOut),
        ];
        let found = diagnose(&machine, &strokes.recording(&cells), &Options::default()).unwrap();
        let named: Vec<&str> = found.causes.iter().map(|cause| cause.effect.as_str()).collect();
        if hidden == 0.0 {
            assert_eq!((found.verdict, named), (Verdict::NoGap, vec![]));
        } else {
            assert_eq!((found.verdict, named), (Verdict::Cause, vec!["coulomb_friction"]));
            let force = found.causes[0].parameters["force_n"].value;
            assert!((force / hidden - 1.0).abs() < 0.01, "{force}");
        }
    }
}

/// A pendulum with an integrator, held out level at first: there, back, and down.
fn held_out(machine: &Machine, name: &str, [travel, lead_s]: [f64; 2], seed: u64, role: Role) -> Run {
    let there = Stroke::new(travel, 3.0).unwrap();
    let strokes = vec![there, Stroke { stroke: -travel, ..there }, Stroke { stroke: -0.5 * travel, ..there }];
    let motion = Motion { strokes, lead_s, dwell_s: 0.2, ramp_s: 0.1 };
    let period = machine.description().sample_period_s;
    let reference: Vec<f64> = motion.reference(period).iter().map(|x| 1.2 + x).collect();
    let traces =
        simulate(machine, PlantChoice::Axis, Sensing::AsStated { seed }, &reference, |_| ()).unwrap();
    let mut run = recorded(name, machine, &reference, traces).unwrap();
    run.role = Some(role);
    run
}

fn integrating(noise_rad: &str) -> Machine {
    let parts = CASCADE
        .replace("velocity_gain", "velocity_integral_per_s = 15.0\nvelocity_gain")
        .replace("noise_rad = 0.0", &format!("noise_rad = {noise_rad}"));
    read(&pendulum(), &parts)
}

/// A pendulum with Coulomb friction hidden: friction is named, and no spring in the place of its weight.
#[test]
fn exact_a_diagnosis_of_a_pendulum_is_undisturbed_by_its_weight() {
    let machine = integrating("2e-6");
    let real = with(&machine, &[("effect.coulomb_friction.torque_nm", 0.08)]);
    let runs = vec![
        held_out(&real, "short", [0.6, 0.1], 1, Role::Training),
        held_out(&real, "long", [1.5, 0.1], 2, Role::Training),
        held_out(&real, "other", [1.0, 0.1], 3, Role::HeldOut),
    ];
    let found = diagnose(&machine, &Recording::new(runs).unwrap(), &Options::default()).unwrap();
    let named: Vec<&str> = found.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!((found.verdict, named), (Verdict::Cause, vec!["coulomb_friction"]));
    let torque = found.causes[0].parameters["torque_nm"].value;
    assert!((torque / 0.08 - 1.0).abs() < 0.01, "{torque}");
}

/// A run that begins at rest under weight begins with what holds it, where only positions were logged too.
#[test]
fn exact_a_replay_begins_with_the_weight_held() {
    for parts in ["", "winding"] {
        let machine = match parts {
            "" => integrating("0.0"),
            _ => {
                let winding = "kind = \"winding\"\nresistance_ohm = 2.0\ninductance_h = 4e-3\ntorque_constant_nm_per_a = 6.0";
                let text = CASCADE
                    .replace("velocity_gain", "velocity_integral_per_s = 15.0\nvelocity_gain")
                    .replace("kind = \"direct\"\ntorque_nm_per_v = 3.0", winding);
                read(&pendulum(), &text)
            }
        };
        let long = held_out(&machine, "run", [0.4, 3.1], 1, Role::Training);
        // The loop has had 2 s and another 3 s to catch the weight from the step to 1.2 rad.
        let run_of = |kept: &[Signal]| {
            let signals = long.signals().iter().filter(|(signal, _)| kept.contains(signal));
            let signals = signals.map(|(signal, samples)| (*signal, samples[3000..].to_vec())).collect();
            Run::new("run", machine.motion(), long.sample_period_s(), signals).unwrap()
        };
        let whole = run_of(&Signal::ALL);
        let bare = run_of(&[Signal::PositionReference, Signal::Position]);
        let replay = |run: &Run| {
            let recorded = Recorded::of(run, &machine).unwrap();
            recorded.replay(&machine, Axis::of(&machine.constants()), Sensing::Perfect)
        };
        let [with, without] = [replay(&whole), replay(&bare)];
        let position = bare.signal(Signal::Position).unwrap();
        for (name, traces) in [("with", with), ("without", without)] {
            let off = traces.position.iter().zip(position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Without what holds it the arm would drop by some 0.01 rad.
            assert!(off < 1e-8, "{name} effort logged, {parts}: {off:e} rad");
        }
    }
}
