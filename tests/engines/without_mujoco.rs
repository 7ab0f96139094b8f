//! A build without MuJoCo knows its name and says how to have it.
#![cfg(not(feature = "mujoco"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::{Path, PathBuf};
use std::process::Command;

use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::mujoco::MujocoRig;
use tempfile::TempDir;

fn grinder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")
}

#[test]
fn exact_the_plant_is_refused_with_how_to_build_it() {
    let error = MujocoRig::new(&Machine::read(&grinder()).unwrap()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert!(error.remedy_text().unwrap().contains("--features mujoco"), "{error}");
}

#[test]
fn exact_commands_that_name_it_end_with_bad_input_and_write_nothing() {
    let folder = TempDir::new().unwrap();
    let (machine, out) = (grinder(), folder.path().join("out"));
    let (machine, out) = (machine.to_str().unwrap(), out.to_str().unwrap());
    let on = ["--machine", machine, "--plant", "mujoco"];
    let commands: [&[&str]; 3] = [
        &["replay", "--cell", "0.02@8", "--out", out],
        &["identify"],
        &["trial", "forge", "--seed", "7", "--tier", "null", "--cases", "1", "--out", out],
    ];
    for command in commands {
        let program = Command::new(env!("CARGO_BIN_EXE_slideway")).args(command).args(on).output().unwrap();
        let told = String::from_utf8_lossy(&program.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(program.status.code(), Some(2), "{told}");
        assert!(told.contains("built without MuJoCo") && told.contains("--features mujoco"), "{told}");
        assert!(!Path::new(out).exists());
    }
}
