//! What a period, a step and a stroke cost.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use divan::{Bencher, black_box};
use nalgebra::{Point3, Vector3};
use slideway::guide::StepForce;
use slideway::machine::Machine;
use slideway::plant::axis::{Axis, LANES};
use slideway::plant::rapier::{Rig, STEP_S, Scene};
use slideway::plant::{Drive, Plant};
use slideway::replay::{Motion, Stroke, Traces, follow, run};
use slideway::solid::GRAVITY_M_PER_S2;
use slideway::twin::{Batch, Command, Driven, Sensing, Twin};
use std::path::Path;

fn main() {
    divan::main();
}

/// The worktable axis with PDF control, motor circuit, five base modes and Coulomb friction.
fn machine() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let coulomb = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    Machine::read(&folder).unwrap().with_settings(coulomb).unwrap()
}

/// One stroke there (and back, so that it can be repeated without end).
fn reference(machine: &Machine, to_and_fro: bool) -> Vec<f64> {
    let there = Stroke::metres_at_metres_per_minute(0.03, 16.0).unwrap();
    let back = Stroke { stroke: -there.stroke, ..there };
    let description = machine.description();
    let strokes = if to_and_fro { vec![there, back] } else { vec![there] };
    let motion =
        Motion { strokes, lead_s: 0.02, dwell_s: 0.3, ramp_s: description.reference.acceleration_time_s };
    motion.reference(description.sample_period_s)
}

/// One control period after another, strokes to and fro without end.
fn periods<P: Plant>(bencher: Bencher, machine: &Machine, plant: P, sensing: Sensing) {
    let mut twin = Twin::new(machine, plant, sensing);
    let reference = reference(machine, true);
    let commands: Vec<Command> = follow(&reference, twin.period_s()).collect();
    let mut next = 0;
    bencher.bench_local(|| {
        next = if next + 1 < commands.len() { next + 1 } else { 0 };
        twin.step(black_box(commands[next]))
    });
}

#[divan::bench(sample_count = 100, sample_size = 10_000)]
fn period_on_axis(bencher: Bencher) {
    let machine = machine();
    periods(bencher, &machine, Axis::of(&machine.constants()), Sensing::Perfect);
}

#[divan::bench(sample_count = 100, sample_size = 10_000)]
fn period_on_axis_with_noise(bencher: Bencher) {
    let machine = machine();
    periods(bencher, &machine, Axis::of(&machine.constants()), Sensing::AsStated { seed: 1 });
}

/// Eight parameter sets in one pass: the time of all of them.
#[divan::bench(sample_count = 100, sample_size = 10_000)]
fn period_of_batch_of_eight(bencher: Bencher) {
    let stated = machine();
    let twins: Vec<_> = (0..LANES)
        .map(|k| {
            let viscous = toml::Value::Float(330.0 + k as f64);
            let machine = stated.with_settings([("guide.viscous_n_s_per_m", viscous)]).unwrap();
            let axis = Axis::of(&machine.constants());
            Twin::new(&machine, axis, Sensing::Perfect)
        })
        .collect();
    let mut batch = Batch::of(twins, Driven::ByControllers).unwrap();
    let reference = reference(&stated, true);
    let commands: Vec<Command> = follow(&reference, stated.description().sample_period_s).collect();
    let (mut next, mut sum) = (0, 0.0);
    bencher.bench_local(|| {
        next = if next + 1 < commands.len() { next + 1 } else { 0 };
        let command = black_box(commands[next]);
        batch.step(|_| command, |_, sample| sum += sample.position + sample.thrust);
        black_box(sum)
    });
}

/// Four steps of the rigid-body plant.
#[divan::bench(sample_count = 100, sample_size = 1000)]
fn period_on_rapier(bencher: Bencher) {
    let machine = machine();
    periods(bencher, &machine, Rig::new(&machine).unwrap(), Sensing::Perfect);
}

/// Stiffness of the spring that keeps the moving part near zero in the step benchmarks, N/m.
const SPRING_N_PER_M: f64 = 2e4;

/// The whole rigid-body plant: drag, base modes, lines of action.
#[divan::bench(sample_count = 100, sample_size = 1000)]
fn step_of_rapier_plant(bencher: Bencher) {
    let mut rig = Rig::new(&machine()).unwrap();
    rig.place(0.01, 0.0);
    bencher.bench_local(|| {
        let force = black_box(-SPRING_N_PER_M) * rig.position();
        let coast = rig.coast(Drive::Force(force));
        rig.advance(StepForce::ZERO, StepForce::ZERO);
        coast
    });
}

/// The rigid bodies and their joint alone.
#[divan::bench(sample_count = 100, sample_size = 1000)]
fn step_of_rapier_scene(bencher: Bencher) {
    let machine = machine();
    let gravity = Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2);
    let mut scene = Scene::new(machine.solid(), STEP_S, gravity).unwrap();
    let centre = Point3::from(machine.solid().moving.mass.centre_m);
    scene.place(0.01, 0.0);
    bencher.bench_local(|| {
        scene.apply(black_box(-SPRING_N_PER_M) * scene.position(), centre);
        scene.step();
    });
}

fn stroke<P: Plant>(machine: &Machine, plant: P, reference: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, plant, Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

/// Twin made and one stroke of 0.03 m at 16 m/min replayed.
#[divan::bench]
fn stroke_on_axis(bencher: Bencher) {
    let machine = machine();
    let reference = reference(&machine, false);
    bencher
        .counter(divan::counter::ItemsCount::new(reference.len()))
        .bench_local(|| stroke(&machine, Axis::of(&machine.constants()), &reference));
}

/// The same on the rigid-body scene.
#[divan::bench]
fn stroke_on_rapier(bencher: Bencher) {
    let machine = machine();
    let reference = reference(&machine, false);
    bencher
        .counter(divan::counter::ItemsCount::new(reference.len()))
        .bench_local(|| stroke(&machine, Rig::new(&machine).unwrap(), &reference));
}
