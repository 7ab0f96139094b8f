//! Runs that are killed: what stood before stands still, or what was to come in its place.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use slideway::recording::Recording;

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
