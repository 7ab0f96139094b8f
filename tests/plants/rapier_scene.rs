//! The rigid-body scene against closed forms: motion along the joint, reaction, slider loads, snapshots.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::{Matrix3, Point3, Vector3};
use proptest::prelude::*;
use slideway::error::ErrorKind;
use slideway::plant::rapier::{Reaction, STEP_S, Scene, SupportLoad, Supports};
use slideway::solid::Solid;

const GRAVITY: f64 = 9.81;
/// Steps of one second.
const SECOND: usize = 16_000;
/// Rounding of some 16 000 additions of numbers up to 1.
const MOTION_ROUNDING: f64 = 1e-12;
/// What the guide gives way (m, rad) in seconds under kN: rapier's joint is soft at 1 MHz.
const GUIDE_YIELD: f64 = 1e-11;
/// The reaction comes from a difference of velocities: 1e-16 m/s · 50 kg / 62.5 µs, and the guide's yield.
const LOAD_ROUNDING_N: f64 = 1e-7;
/// Share of a load that the engine's joint still lacks in the very step in which the load appears.
const FIRST_STEP: f64 = 1e-5;
/// Working face of the left motor's magnet plate in the table's frame.
const LEFT_MOTOR: [f64; 3] = [0.0, 0.031, -0.005];
const SLIDERS: [&str; 4] = ["slider_a", "slider_b", "slider_c", "slider_d"];
const HALF_WHEELBASE: f64 = 0.15;
const HALF_GAUGE: f64 = 0.09;

fn down() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -GRAVITY)
}

/// The shipped worktable on rails without end.
fn worktable() -> Solid {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder/machine.urdf");
    let mut solid = Solid::import(&path).unwrap();
    (solid.joint.lower, solid.joint.upper) = (f64::NEG_INFINITY, f64::INFINITY);
    solid
}

fn scene() -> Scene {
    Scene::new(&worktable(), STEP_S, down()).unwrap()
}

fn supports(solid: &Solid) -> Supports {
    Supports::new(solid, &SLIDERS, Vector3::z()).unwrap()
}

/// A body of 10 kg whose centre of mass and tensor are not aligned with the joint.
fn skewed(joint: &str, centre: &str) -> Solid {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("machine.urdf");
    let body = |origin: &str| {
        format!(
            r#"<inertial><origin xyz="{origin}"/><mass value="10"/>
            <inertia ixx="1" iyy="1.2" izz="1.5" ixy="0.1" ixz="0.2" iyz="0.05"/></inertial>"#
        )
    };
    let urdf = format!(
        r#"<robot name="axis"><link name="bed">{}</link><link name="body">{}</link>
        <joint name="axis" type="{joint}"><parent link="bed"/><child link="body"/>
        <origin xyz="0.3 -0.2 0.1" rpy="0.3 -0.4 0.5"/><axis xyz="1 2 -2"/></joint></robot>"#,
        body("0 0 0"),
        body(centre)
    );
    std::fs::write(&path, urdf).unwrap();
    Solid::import(&path).unwrap()
}

fn run(scene: &mut Scene, steps: usize, mut act: impl FnMut(&mut Scene, usize)) {
    for k in 0..steps {
        act(scene, k);
        scene.step();
    }
}

// ---- motion along the joint --------------------------------------------------------------------------

#[test]
fn exact_constant_force_for_one_second() {
    let mut scene = scene();
    run(&mut scene, SECOND, |s, _| s.apply(150.0, LEFT_MOTOR.into()));
    let mass = scene.inertia();
    assert_abs_diff_eq!(scene.velocity(), 150.0 / mass, epsilon = MOTION_ROUNDING);
    assert_abs_diff_eq!(scene.position(), 0.5 * 150.0 / mass, epsilon = MOTION_ROUNDING);
}

#[test]
fn exact_position_is_free_of_the_half_step_lead_at_any_step() {
    for dt in [STEP_S, 250e-6, 5e-3] {
        let mut scene = Scene::new(&worktable(), dt, down()).unwrap();
        scene.place(-0.2, 0.1);
        assert_abs_diff_eq!(scene.position(), -0.2, epsilon = MOTION_ROUNDING);
        let steps = (0.1 / dt).round() as usize;
        run(&mut scene, steps, |s, _| s.apply(40.0, LEFT_MOTOR.into()));
        let a = 40.0 / scene.inertia();
        let t = steps as f64 * dt;
        assert_abs_diff_eq!(scene.position(), -0.2 + 0.1 * t + 0.5 * a * t * t, epsilon = MOTION_ROUNDING);
        assert_abs_diff_eq!(scene.velocity(), 0.1 + a * t, epsilon = MOTION_ROUNDING);
    }
}

#[test]
fn exact_coasting_loses_nothing() {
    let mut scene = scene();
    scene.place(-0.15, 0.3);
    run(&mut scene, SECOND, |_, _| {});
    assert_abs_diff_eq!(scene.velocity(), 0.3, epsilon = MOTION_ROUNDING);
    assert_abs_diff_eq!(scene.position(), 0.15, epsilon = MOTION_ROUNDING);
}

#[test]
fn exact_creep_under_one_newton_is_not_put_to_sleep() {
    let (force, drag) = (1.0, 20_000.0);
    let mut scene = scene();
    run(&mut scene, 3 * SECOND, |s, _| s.drive(force, drag));
    assert_relative_eq!(scene.velocity(), force / drag, max_relative = 1e-9);
    // x = F/c·(t − m/c) once the start has died away; the trapezoid errs by (h·c/m)²/12 of F/c·m/c.
    let lag = scene.inertia() / drag;
    assert_relative_eq!(scene.position(), force / drag * (3.0 - lag), max_relative = 1e-6);
}

#[test]
fn exact_drag_follows_the_exponential_at_any_step() {
    let (drag, force) = (333.3, 120.0);
    for dt in [STEP_S, 250e-6, 0.02] {
        let mut scene = Scene::new(&worktable(), dt, down()).unwrap();
        scene.place(0.0, -0.2);
        let rate = drag / scene.inertia();
        let steps = (0.4 / dt).round() as usize;
        for k in 1..=steps {
            scene.drag(drag, [0.0, 0.09, -0.026].into());
            scene.apply(force, LEFT_MOTOR.into());
            scene.step();
            let decay = (-rate * k as f64 * dt).exp();
            let exact = force / drag + (-0.2 - force / drag) * decay;
            assert_abs_diff_eq!(scene.velocity(), exact, epsilon = MOTION_ROUNDING);
        }
        // Position is the trapezoidal integral of the exact velocity: off by (h·rate)²/12 of the decay's part.
        let t = steps as f64 * dt;
        let exact = force / drag * t + (-0.2 - force / drag) / rate * -(-rate * t).exp_m1();
        let bound = (dt * rate).powi(2) / 12.0 * 0.56 / rate;
        assert_abs_diff_eq!(scene.position(), exact, epsilon = 1.01 * bound + MOTION_ROUNDING);
    }
}

#[test]
fn exact_drag_counts_gravity_along_the_joint() {
    let upright = Vector3::new(-GRAVITY, 0.0, 0.0);
    let mut scene = Scene::new(&worktable(), 0.01, upright).unwrap();
    assert_abs_diff_eq!(scene.reaction().force_n, Vector3::zeros(), epsilon = LOAD_ROUNDING_N);
    let (drag, mass) = (500.0, scene.inertia());
    run(&mut scene, 100, |s, _| s.drive(200.0, drag));
    let settled = (200.0 - mass * GRAVITY) / drag;
    assert_abs_diff_eq!(scene.velocity(), settled * -(-drag / mass).exp_m1(), epsilon = MOTION_ROUNDING);
}

#[test]
fn exact_drag_in_parts_is_drag_at_once() {
    let (mut whole, mut parts) = (scene(), scene());
    run(&mut whole, 500, |s, _| {
        s.apply(90.0, LEFT_MOTOR.into());
        s.drag(300.0, [0.0, 0.03, -0.026].into());
    });
    run(&mut parts, 500, |s, _| {
        s.drag(200.0, [0.0, 0.09, -0.026].into());
        s.drag(100.0, [0.0, -0.09, -0.026].into());
        s.apply(90.0, LEFT_MOTOR.into());
    });
    assert_abs_diff_eq!(whole.velocity(), parts.velocity(), epsilon = MOTION_ROUNDING);
    assert_abs_diff_eq!(whole.reaction().moment_n_m, parts.reaction().moment_n_m, epsilon = LOAD_ROUNDING_N);
}

#[test]
fn exact_skewed_axis_moves_by_the_force_along_it() {
    let solid = skewed("prismatic", "0.1 0.2 0.3");
    let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
    let force = Vector3::new(30.0, -20.0, 10.0);
    run(&mut scene, 8_000, |s, _| s.apply_force(force, [0.5, 0.0, -0.3].into()));
    let axis = solid.joint.axis.into_inner();
    let weight_along = (solid.joint.origin.rotation * axis).dot(&down()) * 10.0;
    let a = (force.dot(&axis) + weight_along) / 10.0;
    // Some 1e-12 each second: the projection onto a skew axis rounds at every step.
    assert_abs_diff_eq!(scene.velocity(), 0.5 * a, epsilon = 1e-10);
    assert_abs_diff_eq!(scene.position(), 0.125 * a, epsilon = 1e-10);
}

#[test]
fn exact_payload_changes_the_acceleration() {
    for payload in [10.0, -20.0] {
        let mut scene = scene().with_payload(payload).unwrap();
        let mass = worktable().moving_mass_kg() + payload;
        assert_relative_eq!(scene.inertia(), mass);
        run(&mut scene, 1_000, |s, _| s.drive(100.0, 0.0));
        assert_relative_eq!(
            scene.velocity(),
            100.0 * 1_000.0 * STEP_S / mass,
            max_relative = MOTION_ROUNDING
        );
        assert_abs_diff_eq!(scene.reaction().force_n.z, mass * GRAVITY, epsilon = LOAD_ROUNDING_N);
    }
}

#[test]
fn exact_end_stop_holds_the_table() {
    let mut solid = worktable();
    (solid.joint.lower, solid.joint.upper) = (-0.35, 0.35);
    let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
    scene.place(0.34, 0.5);
    let mut furthest = f64::NEG_INFINITY;
    run(&mut scene, SECOND / 2, |s, _| {
        furthest = furthest.max(s.position());
        s.apply(100.0, LEFT_MOTOR.into());
    });
    assert!(furthest < 0.35 + 0.5 * STEP_S * 1.1, "passed the stop by {}", furthest - 0.35);
    assert_abs_diff_eq!(scene.position(), 0.35, epsilon = 1e-9);
    assert_abs_diff_eq!(scene.reaction().force_n.x, -100.0, epsilon = 1e-6);
}

#[test]
fn exact_guide_does_not_give_way() {
    let mut scene = scene();
    run(&mut scene, 2 * SECOND, |s, k| {
        let t = k as f64 * STEP_S;
        s.apply(1500.0 * (std::f64::consts::TAU * 5.0 * t).sin(), [0.0, 0.05, -0.1].into());
    });
    let pose = scene.pose();
    assert_abs_diff_eq!(pose.translation.y, 0.0, epsilon = GUIDE_YIELD);
    assert_abs_diff_eq!(pose.translation.z, 0.04, epsilon = GUIDE_YIELD);
    assert_abs_diff_eq!(pose.rotation.angle(), 0.0, epsilon = GUIDE_YIELD);
}

#[test]
fn exact_infinite_effort_is_seen_until_placed_again() {
    let mut scene = scene();
    scene.apply(f64::NAN, LEFT_MOTOR.into());
    scene.step();
    scene.step();
    assert!(scene.position().is_nan() && scene.velocity().is_nan());
    scene.place(0.1, 0.0);
    scene.step();
    assert_abs_diff_eq!(scene.position(), 0.1, epsilon = MOTION_ROUNDING);
}

// ---- revolute ----------------------------------------------------------------------------------------

/// A rotor whose centre of mass lies on the axis (1, 2, −2)/3, which is principal.
fn balanced_rotor() -> Solid {
    let mut solid = skewed("continuous", "0.1 0.2 -0.2");
    let axis = solid.joint.axis.into_inner();
    solid.moving.mass.inertia_kg_m2 = Matrix3::identity() * 1.2 + axis * axis.transpose() * 0.3;
    solid
}

#[test]
fn exact_balanced_rotor_turns_by_the_closed_form() {
    let solid = balanced_rotor();
    let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
    run(&mut scene, SECOND, |s, _| s.apply(20.0, Point3::origin()));
    let a = 20.0 / solid.moving_inertia_along_joint();
    assert!(scene.position() > std::f64::consts::TAU, "more than a turn");
    // The projection of the spin onto a skew axis rounds at every step.
    assert_abs_diff_eq!(scene.velocity(), a, epsilon = 1e-9);
    assert_abs_diff_eq!(scene.position(), 0.5 * a, epsilon = 1e-9);
}

#[test]
fn exact_unbalanced_rotor_loses_nothing_and_pulls_outwards() {
    let mut solid = balanced_rotor();
    let arm = solid.joint.axis.cross(&Vector3::z()).normalize() * 0.1;
    solid.moving.mass.centre_m = arm;
    let mut scene = Scene::new(&solid, STEP_S, Vector3::zeros()).unwrap();
    let speed = 5.0;
    scene.place(0.0, speed);
    run(&mut scene, SECOND, |_, _| {});
    // Rounding of the projection at every step, as for the balanced rotor.
    assert_abs_diff_eq!(scene.velocity(), speed, epsilon = 1e-9);
    assert_abs_diff_eq!(scene.position(), speed, epsilon = 1e-9);
    let inward = -scene.reaction().force_n.dot(&arm.normalize());
    assert_relative_eq!(inward, 10.0 * 0.1 * speed * speed, max_relative = 1e-2);
}

#[test]
fn exact_rotary_drag_follows_the_exponential() {
    let solid = balanced_rotor();
    let mut scene = Scene::new(&solid, 1e-3, down()).unwrap().with_payload(0.5).unwrap();
    assert_relative_eq!(scene.inertia(), solid.moving_inertia_along_joint() + 0.5);
    run(&mut scene, 1_000, |s, _| s.drive(8.0, 4.0));
    let exact = 2.0 * -(-4.0 / scene.inertia()).exp_m1();
    assert_abs_diff_eq!(scene.velocity(), exact, epsilon = 1e-9);
}

// ---- reaction and slider loads -----------------------------------------------------------------------

#[test]
fn exact_sliders_at_rest_carry_the_weight_by_their_lever_arms() {
    let mut solid = worktable();
    let (x, y) = (0.03, -0.02);
    solid.moving.mass.centre_m += Vector3::new(x, y, 0.0);
    let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
    let weight = solid.moving_mass_kg() * GRAVITY;
    let supports = supports(&solid);
    let expected = |p: &Point3<f64>| {
        weight / 4.0 * (1.0 + x * p.x / HALF_WHEELBASE.powi(2) + y * p.y / HALF_GAUGE.powi(2))
    };
    for (steps, tolerance) in
        [(0, LOAD_ROUNDING_N), (1, FIRST_STEP * weight), (1, LOAD_ROUNDING_N), (100, LOAD_ROUNDING_N)]
    {
        run(&mut scene, steps, |_, _| {});
        let loads = supports.distribute(&scene.reaction());
        let sum: f64 = loads.iter().map(|l| l.vertical_n).sum();
        assert_abs_diff_eq!(sum, weight, epsilon = tolerance);
        for (load, point) in loads.iter().zip(supports.points()) {
            assert_abs_diff_eq!(load.vertical_n, expected(point), epsilon = tolerance);
            assert_abs_diff_eq!(load.lateral_n, 0.0, epsilon = tolerance);
        }
    }
    assert_eq!(supports.names(), SLIDERS);
}

#[test]
fn exact_acceleration_moves_load_from_the_front_to_the_back_sliders() {
    let (mut scene, solid) = (scene(), worktable());
    let thrust = 400.0;
    let [right_motor, left_motor] =
        [-1.0, 1.0].map(|side| Point3::new(0.0, side * LEFT_MOTOR[1], LEFT_MOTOR[2]));
    run(&mut scene, 200, |s, _| {
        s.apply(thrust / 2.0, left_motor);
        s.apply(thrust / 2.0, right_motor);
    });
    let acceleration = thrust / solid.moving_mass_kg();
    let height = solid.moving.mass.centre_m.z - LEFT_MOTOR[2];
    assert!(height > 0.02, "the motors pull below the centre of mass");
    // m·a·h over the wheelbase leaves the front pair; half of it a slider.
    let shift = solid.moving_mass_kg() * acceleration * height / (2.0 * HALF_WHEELBASE) / 2.0;
    let quarter = solid.moving_mass_kg() * GRAVITY / 4.0;
    let [a, b, c, d]: [SupportLoad; 4] = supports(&solid).distribute(&scene.reaction()).try_into().unwrap();
    for (load, expected) in
        [(a, quarter - shift), (b, quarter + shift), (c, quarter - shift), (d, quarter + shift)]
    {
        assert_abs_diff_eq!(load.vertical_n, expected, epsilon = LOAD_ROUNDING_N);
        assert_abs_diff_eq!(load.lateral_n, 0.0, epsilon = LOAD_ROUNDING_N);
    }
}

#[test]
fn exact_one_motor_alone_yaws_the_table_against_the_rails() {
    let (mut scene, solid) = (scene(), worktable());
    run(&mut scene, 200, |s, _| s.apply(100.0, LEFT_MOTOR.into()));
    // Thrust left of the centre of mass turns the table to the right; the rails push the front to the left.
    let lateral = 100.0 * LEFT_MOTOR[1] / (4.0 * HALF_WHEELBASE);
    let loads = supports(&solid).distribute(&scene.reaction());
    for (load, sign) in loads.iter().zip([1.0, -1.0, 1.0, -1.0]) {
        assert_abs_diff_eq!(load.lateral_n, sign * lateral, epsilon = LOAD_ROUNDING_N);
    }
}

#[test]
fn exact_side_force_rolls_the_table_onto_one_rail() {
    let (mut scene, solid) = (scene(), worktable());
    let (force, height) = (80.0, 0.06);
    run(&mut scene, 50, |s, _| s.apply_force(Vector3::new(0.0, force, 0.0), [0.0, 0.0, height].into()));
    // The force acts above the sliders by 60 + 26 mm and presses the left pair (A, B) down.
    let roll = force * (height + 0.026) / (4.0 * HALF_GAUGE);
    let quarter = solid.moving_mass_kg() * GRAVITY / 4.0;
    let loads = supports(&solid).distribute(&scene.reaction());
    for (load, sign) in loads.iter().zip([1.0, 1.0, -1.0, -1.0]) {
        assert_abs_diff_eq!(load.vertical_n, quarter + sign * roll, epsilon = LOAD_ROUNDING_N);
        assert_abs_diff_eq!(load.lateral_n, -force / 4.0, epsilon = LOAD_ROUNDING_N);
    }
}

#[test]
fn ref_reaction_force_agrees_with_the_engines_own_impulses() {
    let solid = skewed("prismatic", "0.1 0.2 0.3");
    let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
    run(&mut scene, 100, |s, _| s.apply(50.0, [0.4, 0.03, -0.02].into()));
    let axis = solid.joint.axis.into_inner();
    let frame = nalgebra::UnitQuaternion::rotation_between(&Vector3::x(), &axis).unwrap();
    let [x, y, z, ..] = scene.row_impulses().map(|i| -i / STEP_S);
    assert_abs_diff_eq!(frame * Vector3::new(x, y, z), scene.reaction().force_n, epsilon = 1e-6);
}

#[test]
fn exact_reaction_balances_a_skewed_body() {
    let solid = skewed("prismatic", "0.1 0.2 0.3");
    let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
    let at = Point3::new(0.4, 0.03, -0.02);
    run(&mut scene, 100, |s, _| s.apply(50.0, at));
    let axis = solid.joint.axis.into_inner();
    let weight = solid.joint.origin.rotation.inverse() * down() * 10.0;
    let across = axis * axis.dot(&weight) - weight;
    let moment = -(at.coords - solid.moving.mass.centre_m).cross(&(axis * 50.0));
    assert_abs_diff_eq!(scene.reaction().force_n, across, epsilon = 1e-6);
    assert_abs_diff_eq!(scene.reaction().moment_n_m, moment, epsilon = 1e-6);
}

// ---- snapshots -----------------------------------------------------------------------------------------

fn stir(scene: &mut Scene) -> Vec<f64> {
    run(scene, 2_000, |s, k| {
        s.apply(300.0 * (0.01 * k as f64).sin(), LEFT_MOTOR.into());
        s.drag(333.3, [0.0, 0.0, -0.026].into());
    });
    scene.snapshot()
}

#[test]
fn exact_restored_scene_goes_on_to_the_last_bit() {
    for solid in [worktable(), skewed("prismatic", "0.1 0.2 0.3"), skewed("continuous", "0.1 0 0.3")] {
        let mut scene = Scene::new(&solid, STEP_S, down()).unwrap();
        scene.place(0.1, 0.2);
        stir(&mut scene);
        let middle = scene.snapshot();
        let (position, reaction) = (scene.position(), scene.reaction());
        let end = stir(&mut scene);
        scene.restore(&middle).unwrap();
        assert_eq!((scene.position(), scene.reaction()), (position, reaction));
        assert_eq!(stir(&mut scene), end);
        let mut other = Scene::new(&solid, STEP_S, down()).unwrap();
        other.restore(&middle).unwrap();
        assert_eq!(stir(&mut other), end);
    }
}

#[test]
fn exact_two_scenes_agree_to_the_last_bit() {
    let (mut one, mut two) = (scene(), scene());
    assert_eq!(stir(&mut one), stir(&mut two));
}

#[test]
fn exact_scene_can_move_to_another_thread() {
    let mut here = scene();
    let mut there = scene();
    let elsewhere = std::thread::spawn(move || stir(&mut there)).join().unwrap();
    assert_eq!(elsewhere, stir(&mut here));
}

// ---- refusals -------------------------------------------------------------------------------------------

#[test]
fn exact_bad_step_gravity_payload_and_snapshot_are_refused() {
    let solid = worktable();
    for dt in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        let refused = Scene::new(&solid, dt, down()).err().unwrap();
        assert_eq!((refused.kind(), refused.key_name()), (ErrorKind::OutOfRange, Some("dt_s")));
    }
    let refused = Scene::new(&solid, STEP_S, Vector3::repeat(f64::NAN)).err().unwrap();
    assert_eq!(refused.key_name(), Some("gravity_m_per_s2"));
    for payload in [-51.3, f64::NAN] {
        let refused = scene().with_payload(payload).err().unwrap();
        assert_eq!((refused.kind(), refused.key_name()), (ErrorKind::OutOfRange, Some("payload")));
    }
    let refused = scene().restore(&[0.0; 3]).unwrap_err();
    assert!(refused.to_string().contains("3 numbers"), "{refused}");
}

#[test]
fn exact_supports_that_cannot_hold_the_body_are_refused() {
    let solid = worktable();
    for (links, up, kind) in [
        (&["slider_a", "slider_b"][..], Vector3::z(), ErrorKind::Undetermined),
        (&["slider_a", "slider_a", "slider_b"], Vector3::z(), ErrorKind::Undetermined),
        (&[], Vector3::z(), ErrorKind::Undetermined),
        (&SLIDERS, Vector3::x(), ErrorKind::OutOfRange),
        (&SLIDERS, Vector3::zeros(), ErrorKind::OutOfRange),
        (&["slider_a", "rail_left", "slider_c"], Vector3::z(), ErrorKind::Inconsistent),
        (&["slider_a", "slider_e", "slider_c"], Vector3::z(), ErrorKind::Missing),
    ] {
        let refused = Supports::new(&solid, links, up).err().unwrap();
        assert_eq!(refused.kind(), kind, "{refused}");
        assert!(refused.remedy_text().is_some() && refused.path().is_some(), "{refused}");
    }
}

// ---- invariants -----------------------------------------------------------------------------------------

fn triples() -> impl Strategy<Value = Vector3<f64>> {
    [-500.0..500.0, -500.0..500.0, -500.0..500.0].prop_map(Vector3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exact_slider_loads_balance_any_reaction_with_least_squares(force_n in triples(), moment_n_m in triples()) {
        let solid = worktable();
        let supports = supports(&solid);
        let loads = supports.distribute(&Reaction { force_n, moment_n_m });
        let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for (load, point) in loads.iter().zip(supports.points()) {
            let part = Vector3::new(0.0, load.lateral_n, load.vertical_n);
            force += part;
            moment += (point.coords - solid.moving.mass.centre_m).cross(&part);
        }
        let carried = Vector3::new(0.0, force_n.y, force_n.z);
        prop_assert!((force - carried).norm() < 1e-9);
        prop_assert!((moment - moment_n_m).norm() < 1e-9);
        // Least sum of squares: nothing of the patterns that load the sliders against each other.
        let twist: f64 = loads.iter().zip([1.0, -1.0, -1.0, 1.0]).map(|(l, s)| s * l.vertical_n).sum();
        prop_assert!(twist.abs() < 1e-8);
        prop_assert!((loads[0].lateral_n - loads[2].lateral_n).abs() < 1e-8);
        prop_assert!((loads[1].lateral_n - loads[3].lateral_n).abs() < 1e-8);
    }

    #[test]
    fn exact_position_and_velocity_are_where_the_body_was_placed(position in -0.3..0.3, velocity in -1.0..1.0) {
        let mut scene = scene();
        scene.place(position, velocity);
        prop_assert!((scene.position() - position).abs() < 1e-15);
        prop_assert!((scene.velocity() - velocity).abs() < 1e-15);
        scene.step();
        prop_assert!((scene.position() - position - velocity * STEP_S).abs() < 1e-15);
    }
}
