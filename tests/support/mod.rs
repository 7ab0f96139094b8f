//! What a test needs and may not find: measured data, a browser, Python packages. A test that cannot run its subject
//! says so by its own name; `.ci/count` takes it off the tests that passed.
#![allow(dead_code, reason = "each suite needs a part of it")]
#![allow(unused_imports, unused_macros, reason = "each suite needs a part of it")]
#![allow(clippy::unwrap_used)]

pub mod random_input;
pub mod strokes;
pub mod told;

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

/// What was looked for, or why it is not there and what to do.
pub type Found<T> = Result<T, String>;

const BROWSERS: [&str; 5] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome-headless-shell"];

/// The value of a [`Found`]; where there is none, the test in which this stands is told as skipped and ends.
macro_rules! needs {
    ($found:expr) => {{
        // Its path holds suite and test: a test that is renamed is told by its new name.
        fn here() {}
        match $found {
            Ok(found) => found,
            Err(reason) => {
                let place = std::any::type_name_of_val(&here);
                return $crate::support::skipped(place.trim_end_matches("::here"), &reason);
            }
        }
    }};
}
pub(crate) use needs;

/// Tells that a test, `suite::name`, could not run its subject.
pub fn skipped(test: &str, reason: &str) {
    // Past the harness, which keeps what a passing test prints; in one piece, as other threads write too.
    let line = format!("\nSKIPPED {test}: {reason}\n");
    std::io::stderr().write_all(line.as_bytes()).unwrap();
}

/// The folder of the measured data, if this file is in it. Recordings anywhere may name its files.
pub fn data(file: &str) -> Found<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("SLIDEWAY_DATA").map_or(beside, PathBuf::from);
    if folder.join(file).is_file() {
        slideway::confine::allow(vec![folder.clone()]);
        return Ok(folder);
    }
    let place = folder.display();
    Err(format!("no measured data {file} in {place}; set SLIDEWAY_DATA to the folder that holds them"))
}

/// A machine file that is written for a sliding joint, with the keys that the joint of this URDF has.
pub fn keys_for(urdf: &str, toml: &str) -> String {
    if urdf.contains("prismatic") {
        return toml.to_owned();
    }
    let keys =
        [("force_n_per_v", "torque_nm_per_v"), ("resolution_m", "resolution_rad"), ("noise_m", "noise_rad")];
    keys.iter().fold(toml.to_owned(), |text, (sliding, turning)| text.replace(sliding, turning))
}

/// What the program says, as wide as where no terminal tells, and with no data but those that its arguments name.
pub fn slideway(arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_slideway"));
    program.args(arguments).env_remove("SLIDEWAY_DATA").env_remove("COLUMNS").output().unwrap()
}

/// What a program printed, or a file holds.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Python with these packages, as `import` lists them.
pub fn python(packages: &str) -> Found<Command> {
    let import = Command::new("python3").args(["-c", &format!("import {packages}")]).output();
    if import.is_ok_and(|output| output.status.success()) {
        return Ok(Command::new("python3"));
    }
    Err(format!("no python3 with {packages}; install them with python3 -m pip install"))
}

/// A Chromium that starts; SLIDEWAY_CHROMIUM names one of one's own.
pub fn chromium() -> Found<&'static OsString> {
    static FOUND: OnceLock<Option<OsString>> = OnceLock::new();
    let starts =
        |name: &OsString| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success());
    let search = || {
        let named = std::env::var_os("SLIDEWAY_CHROMIUM");
        named.into_iter().chain(BROWSERS.map(OsString::from)).find(starts)
    };
    let reason = || "no Chromium; apt-get install chromium, or set SLIDEWAY_CHROMIUM".to_owned();
    FOUND.get_or_init(search).as_ref().ok_or_else(reason)
}
