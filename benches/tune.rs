//! A map of 60 × 60 integers over eight strokes; budget 10 s on two cores.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

use slideway::machine::Machine;
use slideway::replay::crosscheck::cells_of;
use slideway::tune::{Bench, Knob};
use std::path::Path;

fn main() {
    divan::main();
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn map_60_by_60_over_8_strokes(bencher: divan::Bencher) {
    let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let knob = |key: &str, range: [f64; 2], step: f64| Knob::new(&machine, key, range, Some(step)).unwrap();
    let knobs =
        [knob("controller.integral", [6.0, 65.0], 1.0), knob("controller.proportional", [100.0, 395.0], 5.0)];
    let cells = cells_of(&machine).unwrap();
    assert_eq!(cells.len(), 8);
    let values = |k: usize| (0..60).map(move |j| [6.0, 100.0][k] + f64::from(j) * [1.0, 5.0][k]);
    let settings: Vec<Vec<f64>> = values(0).flat_map(|a| values(1).map(move |b| vec![a, b])).collect();
    let bench = Bench::new(&machine, &knobs, &cells, 0.6).unwrap();
    bencher.bench(|| bench.measure(&settings, &|_| ()).unwrap().len());
}
