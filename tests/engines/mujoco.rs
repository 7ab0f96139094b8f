//! The plant in MuJoCo against closed forms and against the other two plants. Needs the feature `mujoco` and its library.
#![cfg(feature = "mujoco")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use slideway::error::{Error, ErrorKind};
use slideway::guide::StepForce;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::plant::mujoco::{Integrator, MujocoRig};
use slideway::plant::rapier::Rig;
use slideway::plant::{Drive, Plant};
use slideway::recording::Recording;
use slideway::replay::excitation::Excitation;
use slideway::replay::{Motion, PlantChoice, Stroke, Traces, follow, run};
use slideway::trial::{Engine, Trial};
use slideway::twin::{Sensing, Twin};
use tempfile::TempDir;

const STEP_S: f64 = 62.5e-6;
/// Steps of one second.
const SECOND: usize = 16_000;
/// Rounding of some 16 000 additions of numbers up to 2.
const MOTION_ROUNDING: f64 = 1e-12;
/// Rounding of sums over ten links and of a turn to principal axes and back.
const IMPORT_ROUNDING: f64 = 1e-12;
const MACHINES: [&str; 4] = ["delta_a3", "emps", "grinder", "grinder_yaxis"];
const BOTH: [Integrator; 2] = [Integrator::RungeKutta, Integrator::Euler];

// ---- machines ------------------------------------------------------------------------------------

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

fn shipped(name: &str) -> Machine {
    Machine::read(&models().join(name)).unwrap()
}

/// The worktable without drag.
fn without_drag() -> Machine {
    shipped("grinder").with_settings([("guide.viscous_n_s_per_m", toml::Value::Float(0.0))]).unwrap()
}

/// A machine of one's own: the folder lives as long as this.
struct Own {
    folder: TempDir,
}

impl Own {
    fn new(urdf: &str, parts: &str) -> Self {
        let own = Self { folder: TempDir::new().unwrap() };
        own.write("machine.urdf", urdf.as_bytes());
        let toml = format!(
            "name = \"axis\"\nurdf = \"machine.urdf\"\njoint = \"axis\"\nsample_period_s = 250e-6\n\
             [motor]\nkind = \"direct\"\nforce_n_per_v = 1.0\n\
             [encoder]\nresolution_m = 0.0\nnoise_m = 0.0\nvelocity = {{ kind = \"taps\", taps = [1.0, -1.0] }}\n{parts}"
        );
        let toml = support::keys_for(urdf, &toml);
        own.write("machine.toml", toml.as_bytes());
        own
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: &[u8]) {
        fs::write(self.path(name), content).unwrap();
    }

    fn machine(&self) -> Machine {
        Machine::read(self.folder.path()).unwrap()
    }
}

const MODES: &str = "[[base.mode]]\nfrequency_hz = 86.1\nmass_kg = 1500.0\ndamping_ratio = 0.01\n\
                     [[base.mode]]\nfrequency_hz = 162.86\nmass_kg = 3000.0\ndamping_ratio = 0.01\n";

/// A body whose centre of mass and tensor are not aligned with a joint that is not aligned with anything.
fn skewed(joint: &str, centre: &str) -> String {
    let body = |origin: &str| {
        format!(
            r#"<inertial><origin xyz="{origin}" rpy="0.4 0.1 -0.2"/><mass value="10"/>
            <inertia ixx="1" iyy="1.2" izz="1.5" ixy="0.1" ixz="0.2" iyz="0.05"/></inertial>"#
        )
    };
    format!(
        r#"<robot name="axis"><link name="bed">{}</link><link name="body">{}</link>
        <joint name="axis" type="{joint}"><parent link="bed"/><child link="body"/>
        <origin xyz="0.3 -0.2 0.1" rpy="0.3 -0.4 0.5"/><axis xyz="1 2 -2"/></joint></robot>"#,
        body("0 0 0"),
        body(centre)
    )
}

/// A table with a mesh, on a joint along x.
fn with_mesh(name: &str, joint: &str) -> String {
    let body =
        r#"<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    format!(
        r#"<?xml version="1.0"?><!-- <robot> --><robot name="axis"><link name="bed">{body}</link><link name="body">{body}
        <visual><geometry><mesh filename="{name}" scale="0.001 0.001 0.001"/></geometry></visual></link>
        <joint name="axis" type="prismatic"><parent link="bed"/><child link="body"/><axis xyz="1 0 0"/>{joint}</joint></robot>"#
    )
}

/// Corners of the outward triangles of a cube of 100 mm.
fn cube() -> Vec<[[f32; 3]; 3]> {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 100.0 } else { 0.0 });
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|t| t.map(corner))).collect()
}

fn stl_binary() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((cube().len() as u32).to_le_bytes());
    for triangle in cube() {
        let numbers = [0.0; 3].into_iter().chain(triangle.into_iter().flatten());
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

fn stl_text() -> String {
    let mut text = "solid cube\n".to_owned();
    for triangle in cube() {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid cube\n"
}

// ---- motion --------------------------------------------------------------------------------------

fn rig(machine: &Machine, integrator: Integrator) -> MujocoRig {
    MujocoRig::with_step(machine, STEP_S, integrator).unwrap()
}

fn push(plant: &mut impl Plant, force: f64, steps: usize) {
    for _ in 0..steps {
        plant.coast(Drive::Force(force));
        plant.advance(StepForce::ZERO, StepForce::ZERO);
    }
}

fn reference(machine: &Machine, stroke: Stroke) -> Vec<f64> {
    let ramp_s = machine.description().reference.acceleration_time_s;
    let motion = Motion { strokes: vec![stroke], lead_s: 0.02, dwell_s: 0.6, ramp_s };
    motion.reference(machine.description().sample_period_s)
}

fn on(machine: &Machine, plant: impl Plant, reference: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, plant, Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>() / a.len() as f64).sqrt()
}

fn refused(machine: &Machine) -> Error {
    MujocoRig::new(machine).err().expect("a refusal")
}

// ---- what MuJoCo reads ---------------------------------------------------------------------------

fn assert_imported(machine: &Machine) {
    let (rig, solid) = (MujocoRig::new(machine).unwrap(), machine.solid());
    let (imported, ours) = (rig.imported(), &solid.moving.mass);
    let near = |found: f64, expected: f64, scale: f64| {
        assert!((found - expected).abs() <= IMPORT_ROUNDING * scale, "{}: {found} {expected}", solid.name);
    };
    near(imported.total_mass_kg, solid.total_mass_kg(), solid.total_mass_kg());
    near(imported.moving.mass_kg, ours.mass_kg, ours.mass_kg);
    near((imported.moving.centre_m - ours.centre_m).norm(), 0.0, 1.0);
    near((imported.moving.inertia_kg_m2 - ours.inertia_kg_m2).norm(), 0.0, ours.inertia_kg_m2.trace());
    let moving = machine.constants().moving_mass;
    near(rig.moving_inertia(), moving, moving);
}

#[test]
fn exact_mass_properties_are_those_of_our_importer() {
    for name in MACHINES {
        assert_imported(&shipped(name));
    }
    for joint in ["prismatic", "continuous"] {
        assert_imported(&Own::new(&skewed(joint, "0.2 0.1 -0.05"), MODES).machine());
    }
    let heavier = [("effect.payload.mass_kg", toml::Value::Float(7.5))];
    assert_imported(&shipped("grinder").with_settings(heavier).unwrap());
    let inertia = [("effect.payload.mass_kg", toml::Value::Float(-0.4))];
    assert_imported(
        &Own::new(&skewed("continuous", "0.2 0.1 -0.05"), "").machine().with_settings(inertia).unwrap(),
    );
}

#[test]
fn exact_the_worktables_five_meshes_are_read_once_each() {
    let machine = shipped("grinder");
    let files = machine.solid().mesh_files().unwrap();
    assert_eq!(MujocoRig::new(&machine).unwrap().imported().meshes, files.len());
}

/// Names of meshes that only ROS resolves, MuJoCo's own element, friction and limits: none of it changes the motion.
#[test]
fn exact_the_urdf_stays_as_it_is_and_its_dynamics_have_no_effect() {
    let dynamics = "<limit lower=\"-0.1\" upper=\"0.1\" effort=\"1\" velocity=\"1\"/>\
                    <dynamics damping=\"50\" friction=\"20\"/>";
    let travelled = |urdf: &str| {
        let own = Own::new(urdf, "");
        own.write("part.stl", &stl_binary());
        let mut rig = MujocoRig::new(&own.machine()).unwrap();
        push(&mut rig, 3.0, SECOND);
        assert_eq!(fs::read_to_string(own.path("machine.urdf")).unwrap(), urdf);
        assert_eq!(rig.imported().meshes, 1);
        rig.position()
    };
    let plain = travelled(&with_mesh("part.stl", ""));
    assert!((plain - 0.75).abs() < MOTION_ROUNDING, "{plain}");
    let own_element = with_mesh("part.stl", "").replace(
        "</robot>",
        "<mujoco><compiler meshdir=\"nowhere\" inertiafromgeom=\"true\"/></mujoco></robot>",
    );
    for other in [with_mesh("package://axis/part.stl", ""), with_mesh("part.stl", dynamics), own_element] {
        assert_eq!(travelled(&other), plain);
    }
}

/// A second movable joint stands still, as in our importer.
#[test]
fn exact_joints_that_are_not_driven_are_held() {
    let body =
        r#"<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"#;
    let urdf = format!(
        r#"<robot name="axis"><link name="bed">{body}</link><link name="body">{body}</link><link name="arm">{body}</link>
        <joint name="axis" type="prismatic"><parent link="bed"/><child link="body"/><axis xyz="1 0 0"/></joint>
        <joint type='revolute' name='arm'><parent link="body"/><child link="arm"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#
    );
    let own = Own::new(&urdf, "");
    let stated = fs::read_to_string(own.path("machine.toml")).unwrap();
    own.write("machine.toml", format!("held_joints = [\"arm\"]\n{stated}").as_bytes());
    assert_imported(&own.machine());
    let mut rig = MujocoRig::new(&own.machine()).unwrap();
    push(&mut rig, 8.0, SECOND);
    assert!((rig.position() - 1.0).abs() < MOTION_ROUNDING, "{}", rig.position());
}

#[test]
fn exact_what_mujoco_refuses_is_refused_with_file_and_remedy() {
    // Our importer reads text STL, MuJoCo does not.
    let own = Own::new(&with_mesh("part.stl", ""), "");
    own.write("part.stl", stl_text().as_bytes());
    let machine = own.machine();
    let error = refused(&machine);
    assert_eq!(error.path().unwrap().file_name().unwrap(), "part.stl", "{error}");
    assert!(
        error.to_string().contains("MuJoCo") && error.remedy_text().unwrap().contains("binary STL"),
        "{error}"
    );
    // A mesh that breaks off, and one that is gone since the machine was read.
    own.write("part.stl", &stl_binary()[..300]);
    assert_eq!(refused(&machine).path().unwrap().file_name().unwrap(), "part.stl");
    fs::remove_file(own.path("part.stl")).unwrap();
    assert_eq!(refused(&machine).path().unwrap().file_name().unwrap(), "part.stl");
    fs::remove_file(own.path("machine.urdf")).unwrap();
    assert_eq!(refused(&machine).kind(), ErrorKind::Io);
}

/// Our importer forgives printed digits of a thin plate's moments, MuJoCo does not.
#[test]
fn exact_moments_beyond_the_triangle_are_refused_with_the_link() {
    let urdf = with_mesh("part.stl", "").replacen("izz=\"1\"", "izz=\"2.000001\"", 2);
    let own = Own::new(&urdf, "");
    own.write("part.stl", &stl_binary());
    let error = refused(&own.machine());
    assert_eq!(error.path().unwrap().file_name().unwrap(), "machine.urdf", "{error}");
    assert!(error.key_name().is_some_and(|link| link == "bed" || link == "body"), "{error}");
}

#[test]
fn exact_a_step_that_is_none_is_refused() {
    for step in [0.0, -1e-4, f64::NAN] {
        let error = MujocoRig::with_step(&shipped("emps"), step, Integrator::RungeKutta).err().unwrap();
        assert_eq!(error.kind(), ErrorKind::OutOfRange);
    }
}

// ---- motion along the joint ----------------------------------------------------------------------

#[test]
fn exact_constant_force_gives_half_a_t_squared() {
    for integrator in BOTH {
        let machine = without_drag();
        let mut constants = machine.constants();
        constants.modes = slideway::base::Modes::default();
        let mut rig = MujocoRig::with_constants(&machine, &constants, STEP_S, integrator).unwrap();
        push(&mut rig, 150.0, SECOND);
        let expected = 150.0 / (2.0 * constants.moving_mass);
        assert!(
            (rig.position() - expected).abs() < MOTION_ROUNDING,
            "{integrator:?} {:e}",
            rig.position() - expected
        );
        assert!((rig.velocity() - 2.0 * expected).abs() < MOTION_ROUNDING, "{integrator:?}");
    }
}

#[test]
fn exact_constant_torque_turns_a_motor() {
    for integrator in BOTH {
        let machine = shipped("delta_a3");
        let inertia = machine.constants().moving_mass;
        let mut rig = rig(&machine, integrator);
        push(&mut rig, 1e-3, SECOND);
        let expected = 1e-3 / (2.0 * inertia);
        assert!(
            (rig.position() / expected - 1.0).abs() < MOTION_ROUNDING,
            "{integrator:?} {}",
            rig.position()
        );
    }
}

/// Drag on a rigid base: velocity approaches F/c by e^(−c·t/m).
#[test]
fn ref_drag_follows_its_exponential() {
    let machine = shipped("grinder");
    let mut constants = machine.constants();
    constants.modes = slideway::base::Modes::default();
    let mut rig = MujocoRig::with_constants(&machine, &constants, STEP_S, Integrator::RungeKutta).unwrap();
    push(&mut rig, 100.0, SECOND);
    let (m, c) = (constants.moving_mass, constants.viscous);
    let expected = 100.0 / c * -(-c / m).exp_m1();
    assert!((rig.velocity() / expected - 1.0).abs() < 1e-12, "{:e}", rig.velocity() / expected - 1.0);
}

/// Frequency and damping ratio of a decaying oscillation, from `y[k+1] = a·y[k] + b·y[k−1]`, which it obeys exactly.
fn decay(samples: &[f64], period_s: f64) -> (f64, f64) {
    let mut normal = nalgebra::Matrix2::zeros();
    let mut right = nalgebra::Vector2::zeros();
    for w in samples.windows(3) {
        let row = nalgebra::Vector2::new(w[1], w[0]);
        normal += row * row.transpose();
        right += row * w[2];
    }
    let ab = normal.lu().solve(&right).unwrap();
    let fall = (-ab[1]).sqrt();
    let angle = (0.5 * ab[0] / fall).acos();
    let (re, im) = (fall.ln() / period_s, angle / period_s);
    (re.hypot(im) / TAU, -re / re.hypot(im))
}

/// One mode, struck and left to itself.
#[test]
fn ref_a_mode_rings_at_its_frequency_and_damping() {
    for (frequency, ratio) in [(86.1, 0.01), (162.86, 0.02)] {
        let mode =
            format!("[[base.mode]]\nfrequency_hz = {frequency}\nmass_kg = 1500.0\ndamping_ratio = {ratio}\n");
        for joint in ["prismatic", "continuous"] {
            // Level: weight would shift where the mode rings about.
            let level = skewed(joint, "0 0 0").replace("0.3 -0.4 0.5", "0 0 0.5").replace("1 2 -2", "1 2 0");
            let own = Own::new(&level, &mode);
            let mut rig = MujocoRig::new(&own.machine()).unwrap();
            push(&mut rig, 1000.0, 16);
            let mut samples = Vec::new();
            for _ in 0..300 {
                push(&mut rig, 0.0, 16);
                samples.push(rig.base_displacement());
            }
            let (found, damping) = decay(&samples, 16.0 * STEP_S);
            assert!((found / frequency - 1.0).abs() < 1e-5, "{joint} {found}");
            assert!((damping / ratio - 1.0).abs() < 1e-4, "{joint} {damping}");
        }
    }
}

/// Without drag nothing couples the modes: the assembled system has the stated ones.
#[test]
fn exact_resonances_without_drag_are_the_stated_modes() {
    let machine = without_drag();
    let found = rig(&machine, Integrator::RungeKutta).resonances();
    let modes = machine.constants().modes;
    assert_eq!(found.len(), modes.len());
    for (found, mode) in found.iter().zip(modes.as_slice()) {
        assert!((found.frequency_hz / mode.frequency_hz() - 1.0).abs() < 1e-11, "{found:?}");
        assert!((found.damping_ratio / mode.damping_ratio() - 1.0).abs() < 1e-9, "{found:?}");
    }
    let dragged = rig(&shipped("grinder"), Integrator::RungeKutta).resonances();
    assert_eq!(dragged.len(), modes.len());
    assert!(dragged[0].damping_ratio > modes.as_slice()[0].damping_ratio());
}

/// Weight pulls at the table of an inclined axis, not at the base's modes; they relax from what they held of it.
#[test]
fn exact_an_inclined_axis_falls_and_its_base_springs_back() {
    let own = Own::new(&skewed("prismatic", "0 0 0"), MODES);
    let machine = own.machine();
    let joint = &machine.solid().joint;
    let downhill = -9.806_65 * (joint.origin.rotation * joint.axis.into_inner()).z;
    let mut rig = MujocoRig::new(&machine).unwrap();
    push(&mut rig, 0.0, SECOND);
    let (base, time, weight) =
        (rig.base_displacement(), 1.0_f64, downhill * machine.solid().moving_mass_kg());
    assert!(((rig.position() + base) / (0.5 * downhill) - 1.0).abs() < MOTION_ROUNDING, "{}", rig.position());
    let constants = machine.constants();
    let modes = constants.modes.as_slice().iter();
    let relaxed: f64 = modes
        .map(|mode| {
            let (omega, zeta) = (mode.angular_frequency_rad_per_s(), mode.damping_ratio());
            let rung = omega * (1.0 - zeta * zeta).sqrt();
            let swing = (rung * time).cos() + zeta * omega / rung * (rung * time).sin();
            -weight / mode.stiffness_n_per_m() * (1.0 - (-zeta * omega * time).exp() * swing)
        })
        .sum();
    // Runge and Kutta's phase is off by 1e-6 of some 10³ rad.
    assert!((base / relaxed - 1.0).abs() < 1e-4, "{base:e} {relaxed:e}");
}

/// What a step is said to end in, it ends in: motor, motor and guide, guide alone; mean and rise.
#[test]
fn exact_a_step_ends_where_its_coast_says() {
    for integrator in BOTH {
        for machine in [shipped("grinder"), Own::new(&skewed("continuous", "0 0 0"), MODES).machine()] {
            let mut rig = rig(&machine, integrator);
            for k in 0..400 {
                let motor = StepForce { mean: f64::from(k % 7) - 3.0, rise: f64::from(k % 5) - 2.0 };
                let guide = StepForce { mean: f64::from(k % 3) - 1.0, rise: f64::from(k % 2) };
                let (motor, guide) = match k % 4 {
                    0 => (motor, guide),
                    1 => (StepForce::ZERO, guide),
                    2 => (StepForce::ZERO, StepForce { mean: 0.0, ..guide }),
                    _ => (StepForce::ZERO, StepForce::ZERO),
                };
                let before = rig.position();
                let coast = rig.coast(Drive::voltage(5.0));
                assert_eq!((coast.velocity, before), (rig.velocity(), rig.position()));
                rig.advance(motor, guide);
                let (v, x) =
                    (coast.velocity_under(motor + guide), before + coast.travel_under(motor + guide));
                assert!((rig.velocity() - v).abs() < 1e-13, "{integrator:?} {k}: {:e}", rig.velocity() - v);
                assert!((rig.position() - x).abs() < 1e-14, "{integrator:?} {k}: {:e}", rig.position() - x);
            }
        }
    }
}

#[test]
fn exact_placed_and_relocated_axes_are_where_they_should_be() {
    for integrator in BOTH {
        let mut rig = rig(&shipped("grinder"), integrator);
        rig.place(0.1, 0.2);
        assert_eq!((rig.position(), rig.velocity(), rig.base_displacement()), (0.1, 0.2, 0.0));
        for _ in 0..200 {
            rig.coast(Drive::voltage(8.0));
            rig.advance(StepForce::ZERO, StepForce::ZERO);
        }
        let (base, current) = (rig.base_displacement(), rig.current());
        assert!(base != 0.0 && current > 0.1);
        rig.relocate(-0.05, 0.01);
        assert!((rig.position() + 0.05).abs() < 1e-15 && (rig.velocity() - 0.01).abs() < 1e-15);
        assert!((rig.base_displacement() - base).abs() < 1e-15 && rig.current() == current);
    }
}

// ---- beside the other plants ---------------------------------------------------------------------

/// The plant's step is its own: the axis is exact at any. What is left is Runge and Kutta's error.
const TO_AXIS_M: f64 = 1e-12;
/// Of MuJoCo's own Euler: drag and springs to first order in the step.
const EULER_M: f64 = 0.3e-6;
/// Of the rigid-body scene, whose base and table meet once a step.
const TO_RAPIER_M: f64 = 0.3e-9;

#[test]
fn ref_strokes_are_those_of_the_axis() {
    let machine = shipped("grinder");
    for (stroke, feed) in [(0.02, 4.0), (0.03, 8.0), (0.05, 16.0), (0.03, 16.0)] {
        let reference = reference(&machine, Stroke::metres_at_metres_per_minute(stroke, feed).unwrap());
        let ours = on(&machine, MujocoRig::new(&machine).unwrap(), &reference);
        let euler = on(&machine, rig(&machine, Integrator::Euler), &reference);
        let axis = on(&machine, Axis::of(&machine.constants()), &reference);
        let rapier = on(&machine, Rig::new(&machine).unwrap(), &reference);
        let [to_axis, to_rapier] = [&axis, &rapier].map(|t| rms(&ours.position, &t.position));
        let to_euler = rms(&ours.position, &euler.position);
        println!(
            "{stroke} m @ {feed} m/min: axis {to_axis:.1e} m, rapier {to_rapier:.1e} m, Euler {to_euler:.1e} m"
        );
        assert!(to_axis <= TO_AXIS_M && to_rapier <= TO_RAPIER_M, "{to_axis:e} {to_rapier:e}");
        assert!(to_euler <= EULER_M, "{to_euler:e}");
        assert!(rms(&ours.thrust, &axis.thrust) < 1e-6 && rms(&ours.velocity, &axis.velocity) < 1e-10);
    }
}

/// With laws of the guide that bend within a step, both plants at the same step: settings and how far the two may be apart.
#[test]
fn ref_strokes_with_friction_are_those_of_the_axis() {
    let stated = [
        (vec![("coulomb_friction.force_n", 15.0), ("payload.mass_kg", 9.0)], 1e-12),
        (vec![("cogging.period_m", 0.02), ("cogging.sine_n", 5.0), ("cogging.cosine_n", 0.0)], 1e-12),
        // Beside an engine the winding sees an extrapolated velocity.
        (vec![("back_emf.back_emf_v_s_per_m", 50.0), ("loop_delay.delay_s", 3.3e-4)], 1e-9),
        (vec![("coulomb_friction.force_n", 15.0), ("presliding.stiffness_n_per_m", 2e6)], 1e-11),
    ];
    for (settings, within_m) in stated {
        let keys: Vec<String> = settings.iter().map(|(key, _)| format!("effect.{key}")).collect();
        let values = settings.iter().map(|(_, value)| toml::Value::Float(*value));
        let machine = shipped("grinder").with_settings(keys.iter().map(String::as_str).zip(values)).unwrap();
        let reference = reference(&machine, Stroke::metres_at_metres_per_minute(0.03, 16.0).unwrap());
        let ours = on(&machine, MujocoRig::new(&machine).unwrap(), &reference);
        let axis = on(&machine, Axis::new(&machine.constants(), STEP_S), &reference);
        let position = rms(&ours.position, &axis.position);
        println!("{keys:?}: {position:.1e} m");
        assert!(position <= within_m, "{keys:?} {position:e}");
    }
}

/// A revolute axis with modes of its base.
#[test]
fn ref_a_revolute_axis_moves_as_the_reduced_one() {
    let own =
        Own::new(&skewed("continuous", "0 0 0"), &format!("{MODES}[guide]\nviscous_nm_s_per_rad = 8.0\n"));
    let machine = own.machine();
    let mut ours = MujocoRig::new(&machine).unwrap();
    let mut axis = Axis::new(&machine.constants(), STEP_S);
    for k in 0..SECOND {
        let drive = Drive::Force(20.0 * (k as f64 * 0.01).sin());
        let guide = StepForce { mean: (k as f64 * 0.02).cos(), rise: 0.02 };
        let step = |plant: &mut dyn Plant| {
            plant.coast(drive);
            plant.advance(StepForce::ZERO, guide);
            (plant.position(), plant.velocity())
        };
        let (a, b) = (step(&mut ours), step(&mut axis));
        assert!((a.0 - b.0).abs() < 1e-11 && (a.1 - b.1).abs() < 1e-10, "{k}: {a:?} {b:?}");
    }
}

#[test]
fn exact_excitation_follows_the_exponential_of_mass_and_drag() {
    let machine = shipped("grinder");
    let excitation = Excitation { period_s: 0.025, samples: 200, seed: 4 };
    let ours = excitation.run(&machine, PlantChoice::Mujoco).unwrap();
    let axis = excitation.run(&machine, PlantChoice::Axis).unwrap();
    assert_eq!(ours.force, axis.force);
    let largest = axis.velocity.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    assert!(rms(&ours.velocity, &axis.velocity) < 1e-12 * largest);
}

/// From the command line: replay with slider loads, and a trial forged and judged.
#[test]
fn exact_replays_and_trials_run_on_mujoco() {
    let folder = TempDir::new().unwrap();
    let grinder = models().join("grinder");
    let slideway = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_slideway")).args(arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    let [machine, replay, trial] = [grinder, folder.path().join("replay"), folder.path().join("trial")]
        .map(|path| path.to_str().unwrap().to_owned());
    let on = ["--plant", "mujoco", "--out"];
    slideway(&[&["replay", "--machine", &machine, "--cell", "0.02@8"][..], &on, &[&replay]].concat());
    let recording = Recording::read(&replay).unwrap();
    assert_eq!(recording.runs()[0].extra_columns().len(), 4);
    let forge = ["trial", "forge", "--machine", &machine, "--seed", "7", "--tier", "null", "--cases", "1"];
    slideway(&[&forge[..], &on, &[&trial]].concat());
    let forged = Trial::read(Path::new(&trial)).unwrap();
    assert_eq!(forged.announcement.engine, Engine::Mujoco);
    slideway(&["trial", "run", &trial]);
}

// ---- loads of the sliders ------------------------------------------------------------------------

fn assert_loads(ours: Option<[f64; 4]>, rapier: Option<[f64; 4]>, within_n: f64) {
    let (ours, rapier) = (ours.unwrap(), rapier.unwrap());
    for (a, b) in ours.iter().zip(rapier) {
        assert!((a - b).abs() < within_n, "{ours:?} {rapier:?}");
    }
}

#[test]
fn ref_slider_loads_at_rest_and_under_thrust_are_the_scenes() {
    let heavier = [("effect.payload.mass_kg", toml::Value::Float(9.0))];
    for machine in [shipped("grinder"), shipped("grinder").with_settings(heavier).unwrap()] {
        for integrator in BOTH {
            let (mut ours, mut rapier) = (rig(&machine, integrator), Rig::new(&machine).unwrap());
            for plant in [&mut ours as &mut dyn Plant, &mut rapier] {
                plant.place(0.05, 0.0);
            }
            let weight = machine.constants().moving_mass * 9.806_65;
            assert_loads(ours.slider_loads(), rapier.slider_loads(), 1e-9);
            assert!((ours.slider_loads().unwrap().iter().sum::<f64>() - weight).abs() < 1e-9);
            for _ in 0..2000 {
                for plant in [&mut ours as &mut dyn Plant, &mut rapier] {
                    plant.coast(Drive::Force(700.0));
                    plant.advance(StepForce::ZERO, StepForce::held(-40.0));
                }
            }
            // Euler's velocity is off by 1.5e-4 m/s after this push, and so is its drag.
            let within_n = if integrator == Integrator::Euler { 1e-2 } else { 1e-3 };
            assert_loads(ours.slider_loads(), rapier.slider_loads(), within_n);
            let tilt = ours.slider_loads().unwrap();
            assert!((tilt[0] - tilt[1]).abs() > 2.0, "{tilt:?}");
        }
    }
    assert_eq!(MujocoRig::new(&shipped("emps")).unwrap().slider_loads(), None);
}

/// Force and moment of a body out of balance, at rest, against the rigid-body scene's closed form.
#[test]
fn exact_the_reaction_of_a_turning_body_balances_weight_and_spin() {
    let own = Own::new(&skewed("continuous", "0.2 0.1 -0.05"), "");
    let machine = own.machine();
    let (solid, speed) = (machine.solid(), 3.0);
    let mut rig = MujocoRig::new(&machine).unwrap();
    rig.place(0.0, speed);
    let reaction = rig.reaction();
    let (body, axis) = (&solid.moving.mass, solid.joint.axis.into_inner());
    let down = solid.joint.origin.rotation.inverse() * nalgebra::Vector3::new(0.0, 0.0, -9.806_65);
    let turning = axis.dot(&body.centre_m.cross(&(down * body.mass_kg)));
    let alpha = axis * turning / machine.constants().moving_mass;
    let omega = axis * speed;
    let acceleration = alpha.cross(&body.centre_m) + omega.cross(&omega.cross(&body.centre_m));
    let force = (acceleration - down) * body.mass_kg;
    let about_centre = body.inertia_kg_m2 * alpha + omega.cross(&(body.inertia_kg_m2 * omega));
    assert!((reaction.force_n - force).norm() < 1e-10, "{:?} {force:?}", reaction.force_n);
    assert!(
        (reaction.moment_n_m - about_centre).norm() < 1e-10,
        "{:?} {about_centre:?}",
        reaction.moment_n_m
    );
}

// ---- state ---------------------------------------------------------------------------------------

/// A motion with motor, ripple and friction; what it shows, bit by bit.
fn wander(rig: &mut MujocoRig, from: u32, steps: u32) -> Vec<u64> {
    let mut shown = Vec::new();
    for k in from..from + steps {
        rig.coast(Drive::Voltage { earlier_v: 3.0, now_v: f64::from(k % 11) - 5.0, switch: 0.3 });
        let friction = StepForce { mean: -15.0 * rig.velocity().signum(), rise: f64::from(k % 3) };
        rig.advance(StepForce::held(f64::from(k % 2)), friction);
        shown.extend([rig.position(), rig.velocity(), rig.current()].map(f64::to_bits));
    }
    shown
}

#[test]
fn exact_restored_motion_goes_on_to_the_last_bit() {
    for integrator in BOTH {
        let mut rig = rig(&shipped("grinder"), integrator);
        wander(&mut rig, 0, 333);
        let (snapshot, loads) = (rig.snapshot(), rig.slider_loads());
        let first = wander(&mut rig, 333, 500);
        rig.restore(&snapshot);
        assert_eq!(rig.snapshot(), snapshot);
        assert_eq!(rig.slider_loads(), loads);
        // Looking at loads, and looking ahead without a step, leave no trace.
        rig.coast(Drive::voltage(100.0));
        assert_eq!(wander(&mut rig, 333, 500), first);
        let mut other = self::rig(&shipped("grinder"), integrator);
        other.restore(&snapshot);
        assert_eq!(wander(&mut other, 333, 500), first);
    }
}

#[test]
fn exact_same_run_same_bits_alone_and_beside_another() {
    let once = || wander(&mut MujocoRig::new(&shipped("grinder")).unwrap(), 0, 2000);
    let alone = once();
    let beside: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(once)).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(beside.iter().all(|run| *run == alone));
}

/// Neither a voltage without value nor one beyond reason makes the engine warn (it would write a file) or stop.
#[test]
fn exact_a_drive_that_is_not_finite_shows_until_the_axis_is_placed() {
    let mut rig = MujocoRig::new(&shipped("grinder")).unwrap();
    for drive in [Drive::voltage(f64::NAN), Drive::Force(f64::INFINITY), Drive::Force(1e300)] {
        for _ in 0..3 {
            rig.coast(drive);
            rig.advance(StepForce::ZERO, StepForce::ZERO);
        }
        assert!(rig.position().is_nan() && rig.velocity().is_nan());
        assert!(rig.slider_loads().unwrap().iter().all(|load| load.is_nan()));
        rig.place(0.01, 0.0);
        push(&mut rig, 10.0, 10);
        assert!(rig.position() > 0.01 && rig.slider_loads().unwrap().iter().all(|load| *load > 0.0));
    }
    assert!(!Path::new("MUJOCO_LOG.TXT").exists());
}

/// Every feature of dry friction at once, against steps eight times finer: a tenth of the encoder's noise.
#[test]
fn exact_friction_converges_in_the_step() {
    let features = [
        ("coulomb_friction.force_n", 12.0),
        ("load_dependent_friction.coefficient", 0.005),
        ("asymmetric_friction.coulomb_asymmetry", 0.2),
        ("asymmetric_friction.viscous_asymmetry", -0.2),
        ("stribeck_friction.peak_ratio", 1.8),
        ("stribeck_friction.stribeck_velocity_m_per_s", 4e-3),
        ("presliding.stiffness_n_per_m", 2e6),
        ("presliding.damping_n_s_per_m", 600.0),
        ("local_friction.force_n", 6.0),
        ("local_friction.centre_m", 0.012),
        ("local_friction.width_m", 0.01),
        ("friction_drift.rate_per_s", 0.1),
    ];
    let keys: Vec<(String, toml::Value)> =
        features.iter().map(|(key, value)| (format!("effect.{key}"), (*value).into())).collect();
    let machine = shipped("grinder")
        .with_settings(keys.iter().map(|(key, value)| (key.as_str(), value.clone())))
        .unwrap();
    let reference = reference(&machine, Stroke::metres_at_metres_per_minute(0.02, 4.0).unwrap());
    let [coarse, fine] = [1.0, 8.0].map(|division| {
        let rig = MujocoRig::with_step(&machine, STEP_S / division, Integrator::RungeKutta).unwrap();
        on(&machine, rig, &reference)
    });
    let error = rms(&coarse.position, &fine.position);
    assert!(error < 3e-9, "{error:e} m");
}
