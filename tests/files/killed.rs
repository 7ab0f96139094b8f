//! Runs that are killed: what stood before stands still, or what was to come in its place.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use slideway::recording::{Existing, Format, Recording, Run, Signal};
use slideway::trial::folder::{Announcement, SCHEMA};
use slideway::trial::seal::Ledger;
use slideway::trial::{Engine, Tier, Trial};
use slideway::units::Motion;

const KILLS: u32 = 50;

fn replay(out: &Path, seed: u32) -> Command {
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps");
    let mut command = Command::new(env!("CARGO_BIN_EXE_slideway"));
    command.args(["replay", "--plant", "axis", "--cell", "0.02@8", "0.03@8", "-q"]);
    command.args(["--noise", &seed.to_string()]).arg("--machine").arg(machine).arg("--out").arg(out);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn replacing(out: &Path, seed: u32) -> Command {
    let mut command = replay(out, seed);
    command.arg("--replace");
    command
}

fn hidden(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap().flatten();
    let names = entries.map(|entry| entry.file_name().into_string().unwrap());
    names.filter(|name| name.starts_with('.')).collect()
}

#[test]
fn exact_a_recording_that_is_replaced_survives_every_kill() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("log");
    assert!(replay(&out, 0).status().unwrap().success());
    let mut draw = StdRng::seed_from_u64(7);
    let mut before = Recording::read(&out).unwrap().sha256();
    let (mut kept, mut replaced) = (0, 0);
    for kill in 0..KILLS {
        let left = hidden(folder.path());
        let mut child = replacing(&out, 2 + kill).spawn().unwrap();
        // Half of the moments are anywhere, half lie while files are written and folders change places.
        if kill % 2 == 1 {
            while hidden(folder.path()) == left && child.try_wait().unwrap().is_none() {
                std::thread::yield_now();
            }
        }
        let longest_s = if kill % 2 == 1 { 0.008 } else { 0.08 };
        std::thread::sleep(Duration::from_secs_f64(draw.random_range(0.0..longest_s)));
        child.kill().unwrap();
        child.wait().unwrap();
        let read = Recording::read(&out).unwrap_or_else(|error| panic!("after kill {kill}: {error}"));
        assert_eq!(read.runs().len(), 2, "after kill {kill}");
        let now = read.sha256();
        *(if now == before { &mut kept } else { &mut replaced }) += 1;
        before = now;
    }
    assert!(kept > 0, "no kill came before the end: {kept} kept, {replaced} replaced");
    // The next run that ends takes away what the killed ones left.
    assert!(replacing(&out, 1).status().unwrap().success());
    assert_eq!(hidden(folder.path()), Vec::<String>::new());
}

/// A trial of recordings that are too short to be diagnosed: each gets its verdict, that it was refused, at once.
fn short_trial(folder: &Path, cases: usize) -> Trial {
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps");
    let position: Vec<f64> = (0..60).map(|k| 1e-4 * f64::from(k)).collect();
    let signals = [(Signal::Position, position.clone()), (Signal::ControlEffort, position)].into();
    let run = Run::new("a", Motion::Prismatic, 1e-3, signals).unwrap();
    let mut recording = Recording::new(vec![run]).unwrap();
    recording.machine = Some(machine);
    let announcement = Announcement {
        schema: SCHEMA.to_owned(),
        version: String::new(),
        seed: 7,
        purpose: "development".to_owned(),
        tiers: vec![Tier::Null],
        cases,
        machine: String::new(),
        machine_sha256: String::new(),
        engine: Engine::Axis,
        truth_sha256: "0".repeat(64),
        skipped: Vec::new(),
    };
    let trial = Trial::announce(folder, announcement).unwrap();
    for case in trial.cases() {
        recording.write(trial.case_folder(case), Format::Csv, Existing::Refuse).unwrap();
        std::fs::write(folder.join(format!("cases/{case:03}.case.toml")), "without = []\n").unwrap();
    }
    trial
}

fn trial_run(trial: &Trial) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slideway"));
    command.args(["trial", "run", "-q"]).arg(&trial.folder);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// The committed verdicts: their number and hash by case.
fn committed(trial: &Trial) -> serde_json::Map<String, serde_json::Value> {
    let Ok(text) = std::fs::read_to_string(trial.verdicts().join("committed.json")) else {
        return serde_json::Map::new();
    };
    let ledger: serde_json::Value = serde_json::from_str(&text).unwrap();
    ledger["verdicts"].as_object().unwrap().clone()
}

#[test]
fn exact_verdicts_that_were_committed_survive_every_kill() {
    const CASES: usize = 300;
    let folder = tempfile::tempdir().unwrap();
    let trial = short_trial(folder.path(), CASES);
    let mut draw = StdRng::seed_from_u64(8);
    let mut before = committed(&trial);
    let mut grew = 0;
    for kill in 0..KILLS {
        let mut child = trial_run(&trial).spawn().unwrap();
        // From the first commitment of this run on, so that most kills come while something is written.
        while kill % 2 == 1 && committed(&trial).len() == before.len() && child.try_wait().unwrap().is_none()
        {
            std::thread::yield_now();
        }
        std::thread::sleep(Duration::from_secs_f64(draw.random_range(0.0..0.01)));
        child.kill().unwrap();
        child.wait().unwrap();
        let now = committed(&trial);
        for (case, entry) in &before {
            assert_eq!(now.get(case), Some(entry), "after kill {kill}: the verdict of case {case} is lost");
        }
        Ledger::read(&trial).unwrap_or_else(|error| panic!("after kill {kill}: {error}"));
        grew += usize::from(now.len() > before.len());
        before = now;
    }
    assert!(grew > 2 && before.len() < CASES, "{grew} runs committed anything, {} in all", before.len());
    assert!(trial_run(&trial).status().unwrap().success());
    let all = committed(&trial);
    assert_eq!(all.len(), CASES);
    assert!(before.iter().all(|(case, entry)| all[case] == *entry));
}

#[test]
fn exact_two_runs_into_one_folder_do_not_overwrite_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("log");
    let mut both = [1, 2].map(|seed| replay(&out, seed).spawn().unwrap());
    let mut ended = both.each_mut().map(|child| child.wait().unwrap().code());
    ended.sort_unstable();
    assert_eq!(ended, [Some(0), Some(2)], "one writes, one is refused");
    assert_eq!(hidden(folder.path()), Vec::<String>::new());
}
