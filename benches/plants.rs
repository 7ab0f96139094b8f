//! What simulation costs: axis, rapier and MuJoCo on the same machine in one run, as one table.
//!
//! `cargo bench --bench plants`, with `--features mujoco` for MuJoCo's rows. Ratios of one run hold on a noisy machine, single
//! times do not.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout, missing_docs)]

use nalgebra::Vector3;
use rayon::prelude::*;
use slideway::guide::StepForce;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::plant::mujoco::{IS_BUILT_IN, Integrator, MujocoRig};
use slideway::plant::rapier::{Reaction, Rig, Supports};
use slideway::plant::{Drive, Plant};
use slideway::replay::{Motion, Stroke, follow, run};
use slideway::solid::Solid;
use slideway::twin::{Sensing, Twin};
use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

/// Step of the plants in the first table, s: a quarter of the control period.
const STEP_S: f64 = 62.5e-6;
/// Repetitions of which the median counts.
const REPEATS: usize = 9;

fn machine() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let coulomb = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    Machine::read(&folder).unwrap().with_settings(coulomb).unwrap()
}

/// Median seconds of a piece of work.
fn seconds(mut work: impl FnMut()) -> f64 {
    work();
    let mut times: Vec<f64> = (0..REPEATS)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPEATS / 2]
}

/// Makes a plant anew.
type Make = Box<dyn Fn() -> Box<dyn Plant>>;

/// The plants by name; MuJoCo's where this build has it.
fn plants(machine: &Machine) -> Vec<(&'static str, Make)> {
    let (axis, rapier) = (machine.clone(), machine.clone());
    let mut all: Vec<(&'static str, Make)> = vec![
        ("axis", Box::new(move || Box::new(Axis::new(&axis.constants(), STEP_S)))),
        ("rapier", Box::new(move || Box::new(Rig::with_step(&rapier, STEP_S).unwrap()))),
    ];
    if IS_BUILT_IN {
        for (name, integrator) in
            [("MuJoCo Euler", Integrator::Euler), ("MuJoCo RK4", Integrator::RungeKutta)]
        {
            let machine = machine.clone();
            let plant = move || -> Box<dyn Plant> {
                Box::new(MujocoRig::with_step(&machine, STEP_S, integrator).unwrap())
            };
            all.push((name, Box::new(plant)));
        }
    }
    all
}

/// One step of the plant, drag, base and motor in it, driven by a voltage.
fn steps(machine: &Machine) {
    const STEPS: usize = 4000;
    println!("\nOne step of {} µs: winding, moving part, drag, five base modes\n", 1e6 * STEP_S);
    println!("| plant | ns a step | times real time | ratio to MuJoCo RK4 |");
    println!("|---|---|---|---|");
    let rows: Vec<(&str, f64)> = plants(machine)
        .into_iter()
        .map(|(name, make)| {
            let mut plant = make();
            let mut volt = 1.0;
            let time = seconds(|| {
                for k in 0..STEPS {
                    volt = if k % 500 == 0 { -volt } else { volt };
                    black_box(plant.coast(Drive::voltage(volt)));
                    plant.advance(StepForce::ZERO, StepForce::ZERO);
                }
            });
            (name, time / STEPS as f64)
        })
        .collect();
    let reference = rows.iter().find(|(name, _)| *name == "MuJoCo RK4").map(|(_, time)| *time);
    for (name, time) in rows {
        let ratio = reference.map_or("–".to_owned(), |r| format!("{:.3}", time / r));
        println!("| {name} | {:.0} | {:.0} | {ratio} |", 1e9 * time, STEP_S / time);
    }
}

fn reference(machine: &Machine, feed: f64) -> Vec<f64> {
    let there = Stroke::metres_at_metres_per_minute(0.03, feed).unwrap();
    let ramp_s = machine.description().reference.acceleration_time_s;
    let motion = Motion { strokes: vec![there], lead_s: 0.02, dwell_s: 0.3, ramp_s };
    motion.reference(machine.description().sample_period_s)
}

/// Whole strokes in closed loop, the axis at its own step of a control period.
fn strokes(machine: &Machine) {
    println!("\nOne stroke of 0.03 m in closed loop with 15 N of Coulomb friction: ms (times real time)\n");
    println!("| plant | 4 m/min | 8 m/min | 16 m/min |");
    println!("|---|---|---|---|");
    let period = machine.description().sample_period_s;
    let row = |name: &str, walk: &dyn Fn(&[f64])| {
        let mut cells = String::new();
        for feed in [4.0, 8.0, 16.0] {
            let reference = reference(machine, feed);
            let time = seconds(|| walk(&reference));
            let real = reference.len() as f64 * period;
            write!(cells, " {:.2} ({:.0}) |", 1e3 * time, real / time).unwrap();
        }
        println!("| {name} |{cells}");
    };
    row("axis, 250 µs", &|r| drop(walk(machine, Axis::of(&machine.constants()), r)));
    row("rapier, 62.5 µs", &|r| drop(walk(machine, Rig::new(machine).unwrap(), r)));
    if IS_BUILT_IN {
        row("MuJoCo RK4, 62.5 µs", &|r| drop(walk_on_mujoco(machine, r)));
    }
}

fn walk<P: Plant>(machine: &Machine, plant: P, reference: &[f64]) -> Vec<f64> {
    let mut twin = Twin::new(machine, plant, Sensing::Perfect);
    run(&mut twin, follow(reference, machine.description().sample_period_s), |_| ()).position
}

fn walk_on_mujoco(machine: &Machine, reference: &[f64]) -> Vec<f64> {
    MujocoRig::new(machine).map_or_else(|error| panic!("{error}"), |plant| walk(machine, plant, reference))
}

/// Sixteen strokes on one and on two threads.
fn threads(machine: &Machine) {
    println!("\nSixteen strokes of 0.03 m at 8 m/min: ms\n");
    println!("| plant | one thread | two threads | speed-up |");
    println!("|---|---|---|---|");
    let reference = reference(machine, 8.0);
    let row = |name: &str, work: &(dyn Fn() + Sync)| {
        let [one, two] = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            seconds(|| pool.install(|| (0..16).into_par_iter().for_each(|_| work())))
        });
        println!("| {name} | {:.1} | {:.1} | {:.2} |", 1e3 * one, 1e3 * two, one / two);
    };
    row("axis", &|| drop(walk(machine, Axis::of(&machine.constants()), &reference)));
    row("rapier", &|| drop(walk(machine, Rig::new(machine).unwrap(), &reference)));
    if IS_BUILT_IN {
        row("MuJoCo RK4", &|| drop(walk_on_mujoco(machine, &reference)));
    }
}

/// A table on `count` sliders in two rows.
fn on_sliders(count: usize) -> Solid {
    let folder = tempfile::tempdir().unwrap();
    let inertial = |mass: f64| {
        let i = 0.1 * mass;
        format!(
            "<inertial><mass value=\"{mass}\"/><inertia ixx=\"{i}\" iyy=\"{i}\" izz=\"{i}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>"
        )
    };
    let mut urdf = format!(
        "<robot name=\"table\"><link name=\"bed\">{}</link><link name=\"table\">{}</link><joint name=\"slide\" \
         type=\"prismatic\"><parent link=\"bed\"/><child link=\"table\"/><axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\" \
         effort=\"1000\" velocity=\"1\"/></joint>",
        inertial(500.0),
        inertial(50.0)
    );
    for k in 0..count {
        let (x, y) = (0.1 * (k / 2) as f64, if k % 2 == 0 { 0.1 } else { -0.1 });
        write!(
            urdf,
            "<link name=\"s{k}\">{}</link><joint name=\"j{k}\" type=\"fixed\"><parent link=\"table\"/><child link=\"s{k}\"/>\
             <origin xyz=\"{x} {y} -0.05\"/></joint>",
            inertial(0.3)
        )
        .unwrap();
    }
    let file = folder.path().join("table.urdf");
    std::fs::write(&file, urdf + "</robot>").unwrap();
    Solid::import(&file).unwrap()
}

fn sliders() {
    const TIMES: usize = 20_000;
    println!("\nLoads of the bearing sliders from the joint's reaction\n");
    println!("| sliders | ns |");
    println!("|---|---|");
    for count in [4, 16, 64] {
        let solid = on_sliders(count);
        let names: Vec<String> = (0..count).map(|k| format!("s{k}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let supports = Supports::new(&solid, &names, Vector3::z()).unwrap();
        let reaction =
            Reaction { force_n: Vector3::new(0.0, 3.0, 500.0), moment_n_m: Vector3::new(1.0, 2.0, 3.0) };
        let time = seconds(|| {
            for _ in 0..TIMES {
                black_box(supports.distribute(black_box(&reaction)));
            }
        });
        println!("| {count} | {:.0} |", 1e9 * time / TIMES as f64);
    }
}

/// Largest resident memory of this process so far in MB, where the system tells.
fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// Twins of which the memory is told.
const TWINS: usize = 200;

/// Prints the largest resident memory in kB of a process that makes so many plants of this name.
fn memory_of(machine: &Machine, name: &str, count: usize) {
    let made: Vec<Box<dyn Plant>> = plants(machine)
        .iter()
        .filter(|(own, _)| *own == name)
        .flat_map(|(_, make)| (0..count).map(|_| make()).collect::<Vec<_>>())
        .collect();
    println!("{}", peak_memory_mb().map_or(f64::NAN, |mb| 1024.0 * mb));
    drop(black_box(made));
}

/// Memory of one plant, by processes of their own: what one freed is another one's otherwise.
fn memory(machine: &Machine) {
    println!("\nMemory of one plant, from {TWINS} of them at once\n");
    println!("| plant | kB |");
    println!("|---|---|");
    let peak = |name: &str, count: usize| -> f64 {
        let own = std::env::current_exe().unwrap();
        let told = std::process::Command::new(own).args([MEMORY, name, &count.to_string()]).output().unwrap();
        String::from_utf8_lossy(&told.stdout).trim().parse().unwrap_or(f64::NAN)
    };
    for (name, _) in plants(machine) {
        println!("| {name} | {:.0} |", (peak(name, TWINS + 1) - peak(name, 1)) / TWINS as f64);
    }
}

/// First argument of the processes whose memory is told.
const MEMORY: &str = "--memory-of";

fn main() {
    // `cargo test --benches` and `cargo bench -- --list` call this too.
    if std::env::args().any(|argument| argument == "--list" || argument == "--test") {
        return;
    }
    let machine = machine();
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, first, name, count] = arguments.as_slice()
        && first == MEMORY
    {
        return memory_of(&machine, name, count.parse().unwrap());
    }
    memory(&machine);
    steps(&machine);
    strokes(&machine);
    threads(&machine);
    sliders();
}
