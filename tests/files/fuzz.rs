//! Mutated inputs of every format that is read: each is read or refused in one plain sentence; none ends in a panic.
//!
//! A short run of always the same mutations stands in the suite (`.cargo/config.toml` fixes the seed). A long one draws others:
//! `PROPTEST_RNG_SEED=2 SLIDEWAY_FUZZ_CASES=100000 cargo test --release --test files fuzz::`; what it finds becomes a test.
//!
//! Fuzz targets that are led by coverage stand in `tests/fuzz`, a crate of its own; the files of their corpus are read here too,
//! among them everything that a target ever found.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;

use nalgebra::Vector3;
use proptest::prelude::*;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use slideway::error::Result;
use slideway::machine::Machine;
use slideway::recording::{Existing, Format, Recording, Run, Signal, TableLayout};
use slideway::solid::Mesh;
use slideway::units::Motion;

#[path = "../fuzz/targets.rs"]
mod targets;

/// Cases of each format in the suite.
const CASES: u32 = 150;

/// Pieces that break readers.
const PIECES: [&[u8]; 24] = [
    b"\0",
    b"\xFF\xFE",
    b"\"",
    b"'",
    b"[[",
    b"]]",
    b"= ",
    b"\n",
    b",",
    b"nan",
    b"inf",
    b"-",
    b"1e300",
    b"1e-300",
    b"1e999",
    b"99999999999999999999",
    b"<a>",
    b"</link>",
    b"&x;",
    b"<!--",
    b"\x1b[31m",
    b"../../etc/passwd",
    b"0",
    b"PAR1",
];

fn cases() -> u32 {
    std::env::var("SLIDEWAY_FUZZ_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(CASES)
}

/// A few bytes changed, pieces put in, doubled, moved or cut out.
fn mutated(seed: u64, sound: &[u8]) -> Vec<u8> {
    let mut draw = StdRng::seed_from_u64(seed);
    let mut bytes = sound.to_vec();
    for _ in 0..draw.random_range(1..6) {
        let len = bytes.len();
        if len == 0 {
            break;
        }
        let from = draw.random_range(0..len);
        let to = (from + draw.random_range(1..40_usize)).min(len);
        match draw.random_range(0..7) {
            0 => bytes[from] ^= 1 << draw.random_range(0..8),
            1 => bytes[from] = draw.random_range(0..=255),
            2 => drop(bytes.drain(from..to)),
            3 => bytes.truncate(from),
            4 => {
                let piece = bytes[from..to].to_vec();
                let at = draw.random_range(0..len);
                bytes.splice(at..at, piece);
            }
            5 => {
                let piece = PIECES[draw.random_range(0..PIECES.len())];
                bytes.splice(from..from, piece.iter().copied());
            }
            // A word replaced: a number by another one, a key by a piece.
            _ => {
                let is_word = |b: &u8| b.is_ascii_alphanumeric() || b".-_+".contains(b);
                let start = bytes[..from].iter().rposition(|b| !is_word(b)).map_or(0, |at| at + 1);
                let end = bytes[from..].iter().position(|b| !is_word(b)).map_or(len, |at| from + at);
                let piece = PIECES[draw.random_range(0..PIECES.len())];
                bytes.splice(start..end.max(start), piece.iter().copied());
            }
        }
    }
    bytes
}

/// Reads every mutation of a file in a folder of sound files.
fn fuzz<T>(name: &str, sound: &[u8], folder: &Path, read: impl Fn(&Path) -> Result<T>) {
    let path = folder.join(name);
    std::fs::write(&path, sound).unwrap();
    if let Err(error) = read(folder) {
        panic!("the sound file is refused: {error}");
    }
    let config = ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() };
    proptest!(config, |(seed in any::<u64>())| {
        std::fs::write(&path, mutated(seed, sound)).unwrap();
        if let Err(error) = read(folder) {
            let text = error.to_string();
            prop_assert!(!text.is_empty() && text.len() < 4000, "{text}");
            prop_assert!(!text.chars().any(char::is_control), "{text:?}");
        }
    });
}

fn shipped(file: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file)).unwrap()
}

/// A folder with a machine, its solid model, and a recording of it.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for file in ["machine.toml", "machine.urdf"] {
        std::fs::write(folder.path().join(file), shipped(&format!("emps/{file}"))).unwrap();
    }
    folder
}

fn recorded(format: Format) -> tempfile::TempDir {
    let run = |name: &str, stroke: f64| {
        let position: Vec<f64> = (0..200).map(|k| stroke * f64::from(k) / 199.0).collect();
        let effort = position.iter().map(|x| 1.0 + x.sin()).collect();
        let signals = [(Signal::Position, position), (Signal::ControlEffort, effort)].into_iter().collect();
        Run::new(name, Motion::Prismatic, 1e-3, signals).unwrap()
    };
    let folder = tempfile::tempdir().unwrap();
    let recording = Recording::new(vec![run("a", 0.02), run("b", 0.03)]).unwrap();
    recording.write(folder.path().join("log"), format, Existing::Refuse).unwrap();
    folder
}

#[test]
fn exact_mutated_recording_files_do_not_panic() {
    let folder = recorded(Format::Csv);
    let log = folder.path().join("log");
    let mut sound = std::fs::read(log.join("recording.toml")).unwrap();
    sound.extend(b"[columns]\nposition_m = { unit = \"m\", scale = 1.0, offset = 0.0 }\n");
    fuzz("recording.toml", &sound, &log, |folder| Recording::read(folder));
}

#[test]
fn exact_mutated_csv_files_do_not_panic() {
    let folder = recorded(Format::Csv);
    let log = folder.path().join("log");
    fuzz("a.csv", &std::fs::read(log.join("a.csv")).unwrap(), &log, |folder| Recording::read(folder));
}

#[test]
fn exact_mutated_parquet_files_do_not_panic() {
    let folder = recorded(Format::Parquet);
    let log = folder.path().join("log");
    fuzz("a.parquet", &std::fs::read(log.join("a.parquet")).unwrap(), &log, |folder| Recording::read(folder));
}

/// Logs of other programs, as they ship with the tests.
fn fuzz_log(name: &str, mapped: &str) {
    let folder = tempfile::tempdir().unwrap();
    let manifest = format!("[[run]]\nfile = \"{name}\"\n[columns]\n{mapped}");
    std::fs::write(folder.path().join("recording.toml"), manifest).unwrap();
    let sound =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats").join(name)).unwrap();
    fuzz(name, &sound, folder.path(), |folder| {
        let looked = TableLayout::of(folder.join(name));
        Recording::read(folder).and_then(|recording| looked.map(|_| recording))
    });
}

#[test]
fn exact_mutated_mcap_files_do_not_panic() {
    let folder = recorded(Format::Mcap);
    let log = folder.path().join("log");
    fuzz("a.mcap", &std::fs::read(log.join("a.mcap")).unwrap(), &log, |folder| Recording::read(folder));
    let columns = "position_m = \"/joint_states/slide/position\"\ncurrent_a = { column = \"/current/data\", unit = \"mA\" }\n";
    fuzz_log("ros2.mcap", columns);
}

#[test]
fn exact_mutated_mat_files_do_not_panic() {
    let columns = "time_s = \"t\"\nposition_m = \"pos\"\ncurrent_a = { column = \"cur\", unit = \"mA\" }\n";
    for name in ["scipy_v5.mat", "scipy_v7.mat", "matlab_v73.mat"] {
        fuzz_log(name, columns);
    }
}

#[test]
fn exact_mutated_scope_exports_do_not_panic() {
    fuzz_log("twincat_scope.csv", "position_m = { column = \"func_freesample\", unit = \"mm\" }\n");
}

#[test]
fn exact_mutated_machine_files_do_not_panic() {
    let folder = folder();
    let mut sound = shipped("emps/machine.toml");
    sound.extend(b"[effect.coulomb_friction]\nforce_n = 5.0\n[[base.mode]]\nfrequency_hz = 60.0\nmass_kg = 900.0\ndamping_ratio = 0.02\n");
    fuzz("machine.toml", &sound, folder.path(), Machine::read);
}

#[test]
fn exact_mutated_solid_models_do_not_panic() {
    let folder = folder();
    fuzz("machine.urdf", &shipped("emps/machine.urdf"), folder.path(), Machine::read);
}

#[test]
fn exact_mutated_meshes_do_not_panic() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &'static str| {
        move |folder: &Path| {
            let mesh = Mesh::read(&folder.join(name), Vector3::repeat(1.0))?;
            mesh.check_size().and_then(|()| mesh.check_closed())
        }
    };
    let obj = b"# a part\nmtllib a.mtl\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    fuzz("a.obj", obj, folder.path(), read("a.obj"));
    let corners: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut stl = [vec![0_u8; 80], 4_u32.to_le_bytes().to_vec()].concat();
    let mut text = "solid x\n".to_owned();
    for face in faces {
        stl.extend([0_u8; 12]);
        text += "facet normal 0 0 0\nouter loop\n";
        for corner in face {
            let [x, y, z] = corners[corner];
            stl.extend([x, y, z].iter().flat_map(|x| x.to_le_bytes()));
            text += &format!("vertex {x} {y} {z}\n");
        }
        stl.extend([0_u8; 2]);
        text += "endloop\nendfacet\n";
    }
    fuzz("a.stl", &stl, folder.path(), read("a.stl"));
    fuzz("a.stl", format!("{text}endsolid x\n").as_bytes(), folder.path(), read("a.stl"));
}

#[test]
fn exact_the_corpus_of_every_fuzz_target_is_read_or_refused() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus");
    for (target, name) in targets::ALL {
        let folder = tempfile::tempdir().unwrap();
        targets::prepare(target, folder.path());
        let files: Vec<_> =
            std::fs::read_dir(corpus.join(name)).unwrap().map(|entry| entry.unwrap().path()).collect();
        let mut sound = 0;
        for file in &files {
            sound += usize::from(targets::checked(target, folder.path(), &std::fs::read(file).unwrap()));
        }
        // A target that refuses whatever it is given would find nothing.
        assert!(sound > 0, "{name}: {sound} of {} files are sound", files.len());
    }
}
