//! One diagnosis: eight runs of five thousand samples against the whole catalogue.
#![allow(clippy::unwrap_used, missing_docs)]

use divan::{Bencher, black_box};
use slideway::diagnose::{Options, diagnose};
use slideway::machine::Machine;
use slideway::recording::{Recording, Run};
use slideway::replay::recording::recorded;
use slideway::replay::{Motion, PlantChoice, Stroke, run_seed, simulate};
use slideway::twin::Sensing;
use std::path::Path;

fn main() {
    divan::main();
}

/// Samples of each run.
const SAMPLES: usize = 5000;

fn recording(machine: &Machine) -> Recording {
    let hidden = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    let real = machine.with_settings(hidden).unwrap();
    let period = machine.description().sample_period_s;
    let cells = [
        (0.02, 4.0),
        (0.03, 4.0),
        (0.03, 8.0),
        (0.04, 8.0),
        (0.04, 16.0),
        (0.05, 16.0),
        (0.02, 8.0),
        (0.03, 16.0),
    ];
    let runs: Vec<Run> = cells
        .iter()
        .enumerate()
        .map(|(k, &(stroke, feed))| {
            let stroke = Stroke::metres_at_metres_per_minute(stroke, feed).unwrap();
            let back = Stroke { stroke: -stroke.stroke, ..stroke };
            let motion = Motion { strokes: vec![stroke, back], lead_s: 0.1, dwell_s: 0.4, ramp_s: 0.02 };
            let mut reference = motion.reference(period);
            let last = *reference.last().unwrap();
            reference.resize(SAMPLES, last);
            let name = format!("run{k}");
            let sensing = Sensing::AsStated { seed: run_seed(1, &name) };
            let traces = simulate(&real, PlantChoice::Axis, sensing, &reference, |_| ()).unwrap();
            recorded(&name, machine, &reference, traces).unwrap()
        })
        .collect();
    Recording::new(runs).unwrap()
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn whole_catalogue_on_eight_runs(bencher: Bencher) {
    let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let recording = recording(&machine);
    bencher
        .bench_local(|| diagnose(black_box(&machine), black_box(&recording), &Options::default()).unwrap());
}
