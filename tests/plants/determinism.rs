//! The same seed gives the same bytes on every plant, from one thread or from two at once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use rayon::prelude::*;
use slideway::machine::Machine;
use slideway::replay::{PlantChoice, Stroke, Traces, simulate};
use slideway::twin::Sensing;
use std::path::Path;

/// A noisy run of a machine with friction.
fn noisy(machine: &Machine, plant: PlantChoice, seed: u64) -> Traces {
    let there = Stroke::new(0.01, 0.1).unwrap();
    let motion = slideway::replay::Motion { strokes: vec![there], lead_s: 0.02, dwell_s: 0.1, ramp_s: 0.02 };
    let reference = motion.reference(machine.description().sample_period_s);
    simulate(machine, plant, Sensing::AsStated { seed }, &reference, |_| ()).unwrap()
}

fn machine() -> Machine {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let coulomb = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    Machine::read(&folder).unwrap().with_settings(coulomb).unwrap()
}

fn bits(traces: &Traces) -> Vec<u64> {
    let signals = [&traces.position, &traces.velocity, &traces.effort_v, &traces.current, &traces.thrust];
    signals.into_iter().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn exact_same_seed_same_bytes_on_one_thread_or_two() {
    let machine = machine();
    for plant in [PlantChoice::Axis, PlantChoice::Rapier] {
        let first = bits(&noisy(&machine, plant, 7));
        let pools = [1, 2].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
        for pool in pools {
            let all: Vec<Vec<u64>> =
                pool.install(|| (0..4).into_par_iter().map(|_| bits(&noisy(&machine, plant, 7))).collect());
            assert!(all.iter().all(|run| *run == first), "{plant}");
        }
        assert_ne!(first, bits(&noisy(&machine, plant, 8)), "{plant}: the seed is the noise");
    }
}
