//! What reading a long recording costs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use divan::Bencher;
use slideway::recording::Recording;
use std::fmt::Write;

fn main() {
    divan::main();
}

const ROWS: u32 = 1_000_000;

/// A folder with one run of six columns, written as a drive's logger writes: ten significant digits.
fn folder() -> tempfile::TempDir {
    let mut text =
        String::from("time_s,position_reference_m,position_m,velocity_m_per_s,control_effort_v,current_a\n");
    for k in 0..ROWS {
        let time = f64::from(k) * 250e-6;
        let position = 0.01 * (3.0 * time).sin();
        let velocity = 0.03 * (3.0 * time).cos();
        writeln!(
            text,
            "{time:.6},{position:.9},{:.9},{velocity:.9},{:.9},{:.9}",
            position - 1e-5 * velocity,
            2.0 * velocity,
            1.5 * velocity
        )
        .unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("run.csv"), text).unwrap();
    let manifest = "sample_period_s = 250e-6\n[[run]]\nfile = \"run.csv\"\n";
    std::fs::write(folder.path().join("recording.toml"), manifest).unwrap();
    folder
}

/// One million rows of six columns, header to checked signals in SI, SHA-256 included.
#[divan::bench(sample_count = 8, sample_size = 1)]
fn read_csv(bencher: Bencher) {
    let folder = folder();
    bencher
        .counter(divan::counter::ItemsCount::new(ROWS))
        .bench_local(|| Recording::read(folder.path()).unwrap());
}
