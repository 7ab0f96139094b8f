//! The program as a user runs it: what it writes, what it refuses, how it ends.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{slideway as run, text};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use slideway::recording::{Recording, Role};
use tempfile::TempDir;

const SLIDEWAY: &str = env!("CARGO_BIN_EXE_slideway");
const BAD_INPUT: Option<i32> = Some(2);

#[track_caller]
fn succeeded(arguments: &[&str]) -> String {
    let output = run(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "nothing on standard error");
    text(&output.stdout)
}

/// Runs, and expects exit code 2, the words on standard error and nothing on standard output.
#[track_caller]
fn refused(arguments: &[&str], words: &[&str]) {
    let output = run(arguments);
    let told = text(&output.stderr);
    assert_eq!(output.status.code(), BAD_INPUT, "{told}");
    assert_eq!(text(&output.stdout), "");
    assert!(!told.contains('\u{1b}'), "colours although standard error is no terminal: {told:?}");
    for word in words {
        assert!(told.contains(word), "`{word}` is not in: {told}");
    }
}

fn grinder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")
}

/// A copy of the machine to spoil, and a place for a recording.
struct Workshop {
    folder: TempDir,
}

impl Workshop {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let to = folder.path().join("machine");
        fs::create_dir_all(to.join("meshes")).unwrap();
        for file in ["machine.toml", "machine.urdf"] {
            fs::copy(grinder().join(file), to.join(file)).unwrap();
        }
        for entry in fs::read_dir(grinder().join("meshes")).unwrap() {
            let entry = entry.unwrap();
            fs::copy(entry.path(), to.join("meshes").join(entry.file_name())).unwrap();
        }
        Self { folder }
    }

    fn machine(&self) -> String {
        self.folder.path().join("machine").display().to_string()
    }

    fn out(&self) -> String {
        self.folder.path().join("recording").display().to_string()
    }

    /// Rewrites one file of the machine.
    fn edit(&self, file: &str, change: impl FnOnce(String) -> String) {
        let path = self.folder.path().join("machine").join(file);
        let before = fs::read_to_string(&path).unwrap();
        let after = change(before.clone());
        assert_ne!(before, after, "the edit must change {file}");
        fs::write(path, after).unwrap();
    }

    /// A replay that must be refused and leave nothing behind.
    #[track_caller]
    fn replay_refused(&self, more: &[&str], words: &[&str]) {
        let (machine, out) = (self.machine(), self.out());
        let start = ["replay", "--machine", &machine, "--out", &out];
        refused(&[&start[..], more].concat(), words);
        let left: Vec<_> =
            fs::read_dir(self.folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left, ["machine"], "something was left behind");
    }
}

#[test]
fn ref_replay_shows_figure_6_and_its_cure() {
    let shop = Workshop::new();
    let (machine, out) = (shop.machine(), shop.out());
    let start = ["replay", "--machine", &machine, "--cell", "0.02@8", "--out", &out];
    let figures = |shown: &str| -> Vec<f64> {
        let line = shown.lines().find(|line| line.trim_start().starts_with("stroke020_feed08")).unwrap();
        line.split_whitespace().skip(2).map(|word| word.parse().unwrap()).collect()
    };
    let stated = figures(&succeeded(&start));
    assert_eq!(stated[0], 4.1, "overshoot in %");
    // −3.15 % rounds either way with the sensor's noise on it.
    assert!((stated[2] + 3.15).abs() < 0.06, "lowest speed in %: {}", stated[2]);
    let more = ["--replace", "--set", "controller.integral=22", "--set", "controller.proportional=220"];
    let cured = figures(&succeeded(&[&start[..], &more].concat()));
    assert_eq!((cured[0], cured[2]), (0.0, 0.0), "gone");
    let read = Recording::read(&out).unwrap();
    assert_eq!(read.runs()[0].settings["controller.integral"], toml::Value::Integer(22));
}

#[test]
fn exact_replay_keeps_what_it_was_told() {
    let shop = Workshop::new();
    let (machine, out) = (shop.machine(), shop.out());
    let hide = "effect.coulomb_friction.force_n=15";
    let shown = succeeded(&[
        "replay",
        "--machine",
        &machine,
        "--out",
        &out,
        "--cell",
        "0.02@4",
        "0.03@8",
        "--held-out",
        "0.02@8",
        "--hide",
        hide,
        "--set",
        "controller.integral=20",
        "--plant",
        "axis",
        "--format",
        "parquet",
        "--return",
        "--repeat",
        "2",
        "--noise",
        "9",
    ]);
    assert!(shown.contains("hidden: effect.coulomb_friction.force_n = 15"), "{shown}");
    let read = Recording::read(&out).unwrap();
    let roles: Vec<_> = read.runs().iter().map(|run| (run.name(), run.role.unwrap())).collect();
    assert_eq!(
        roles,
        [
            ("stroke020_feed04_run1", Role::Training),
            ("stroke020_feed04_run2", Role::Training),
            ("stroke030_feed08_run1", Role::Training),
            ("stroke030_feed08_run2", Role::Training),
            ("stroke020_feed08_run1", Role::HeldOut),
            ("stroke020_feed08_run2", Role::HeldOut),
        ]
    );
    let run = &read.runs()[0];
    assert_eq!(run.metadata["stroke_m"].as_float(), Some(0.02));
    assert_eq!(run.metadata["feed_m_per_min"].as_float(), Some(4.0));
    assert_eq!(run.settings.keys().collect::<Vec<_>>(), ["controller.integral"], "hidden stays hidden");
    assert_ne!(run.signals(), read.runs()[1].signals(), "each run has noise of its own");
    let note = read.note.clone().unwrap();
    for word in ["simulated", "reduced axis", "seed 9", "hidden: effect.coulomb_friction.force_n = 15"] {
        assert!(note.contains(word), "`{word}` is not in: {note}");
    }
    assert_eq!(read.machine.unwrap().canonicalize().unwrap(), Path::new(&machine).canonicalize().unwrap());
    let toml = fs::read_to_string(Path::new(&out).join("recording.toml")).unwrap();
    assert!(toml.contains("machine = \"../machine\""), "{toml}");
}

#[test]
fn exact_same_command_writes_the_same_recording() {
    let shop = Workshop::new();
    let (machine, out) = (shop.machine(), shop.out());
    let arguments = ["replay", "--machine", &machine, "--cell", "0.02@8", "--out", &out, "--replace"];
    succeeded(&arguments);
    let first = Recording::read(&out).unwrap().sha256();
    succeeded(&arguments);
    assert_eq!(Recording::read(&out).unwrap().sha256(), first);
}

#[test]
fn ref_identify_regenerates_the_published_transfer_function() {
    let shown = succeeded(&["identify", "--machine", &grinder().display().to_string()]);
    let line = shown.lines().skip_while(|line| *line != "W(z) at 25 ms").nth(1).unwrap();
    let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    // 0.45 z^-1 / (1 - 0.85 z^-1) to the two digits that are published.
    assert_eq!(format!("{:.2}", numbers[0]), "0.45");
    assert_eq!(format!("{:.2}", numbers[1]), "0.85");
    assert!(shown.contains("W(z) at 250 µs"));
    // Eq. (11) as printed, and put right.
    assert!(shown.contains("1.218 z^-1 / (1 - 1.892 z^-1 + 0.886 z^-2)"), "{shown}");
    assert!(shown.contains("1.123 z^-1 / (1 - 1.811 z^-1 + 0.817 z^-2)"), "{shown}");
}

#[test]
fn exact_identify_finds_the_machine_in_its_recording() {
    let shop = Workshop::new();
    let (machine, out) = (shop.machine(), shop.out());
    succeeded(&["replay", "--machine", &machine, "--cell", "0.03@16", "--perfect", "--out", &out]);
    let signals = ["--input", "thrust_n", "--output", "velocity_m_per_s"];
    let shown = succeeded(&[&["identify", &out, "--period", "0.005"], &signals[..]].concat());
    let mass = shown.lines().find(|line| line.contains("moving mass")).unwrap();
    let mass: f64 = mass.split_whitespace().nth(3).unwrap().parse().unwrap();
    // The velocity filter and the base are not in the model: a few per cent.
    assert!((mass / 51.28 - 1.0).abs() < 0.03, "{mass} kg");
    refused(
        &[&["identify", &out, "--period", "0.0003"], &signals[..]].concat(),
        &["`period`", "whole multiple"],
    );
    refused(
        &["identify", &out, "--input", "thrust_nm", "--output", "velocity_m_per_s"],
        &["thrust_nm", "slider_a_n"],
    );
    refused(&[&["identify", &out, "--run", "other"], &signals[..]].concat(), &["other", "stroke030_feed16"]);
}

#[test]
fn exact_identify_refuses_constant_excitation() {
    let folder = TempDir::new().unwrap();
    let rows: String =
        (0..200).map(|k| format!("{},100,{}\n", f64::from(k) * 1e-3, f64::from(k) * 1e-4)).collect();
    fs::write(folder.path().join("log.csv"), format!("time_s,thrust_n,velocity_m_per_s\n{rows}")).unwrap();
    fs::write(folder.path().join("recording.toml"), "[[run]]\nfile = \"log.csv\"\n").unwrap();
    let recording = folder.path().display().to_string();
    let signals = ["--input", "thrust_n", "--output", "velocity_m_per_s"];
    refused(
        &[&["identify", &recording], &signals[..]].concat(),
        &["do not excite", "condition", "drive the axis with an input that keeps changing"],
    );
}

#[test]
fn exact_inspect_shows_recording_and_machine() {
    let shop = Workshop::new();
    let (machine, out) = (shop.machine(), shop.out());
    succeeded(&["replay", "--machine", &machine, "--cell", "0.02@8", "--out", &out]);
    let shown = succeeded(&["inspect", &out]);
    for word in
        ["simulated, not measured", "stroke020_feed08", "20.8 mm", "slider_d_n", "sha256", "250 µs", "m/min"]
    {
        assert!(shown.contains(word), "`{word}` is not in: {shown}");
    }
    let shown = succeeded(&["inspect", &machine]);
    for word in ["integral = 19", "worktable", "86.1 Hz", "equivalent chain", "502.89", "51.2803 kg"] {
        assert!(shown.contains(word), "`{word}` is not in: {shown}");
    }
    assert_eq!(succeeded(&["--quiet", "inspect", &machine]), "");
}

#[test]
fn exact_mesh_with_a_missing_triangle_is_refused() {
    let shop = Workshop::new();
    shop.edit("meshes/worktable.obj", |text| {
        let last = text.rfind("\nf ").unwrap();
        text[..=last].to_owned()
    });
    shop.replay_refused(&["--cell", "0.02@8"], &["worktable.obj", "closed"]);
    refused(&["inspect", &shop.machine()], &["worktable.obj"]);
    refused(&["identify", "--machine", &shop.machine()], &["worktable.obj"]);
}

#[test]
fn exact_link_without_inertia_is_refused() {
    let shop = Workshop::new();
    shop.edit("machine.urdf", |text| {
        let link = text.find("<link name=\"slider_b\">").unwrap();
        let from = link + text[link..].find("<inertial>").unwrap();
        let to = from + text[from..].find("</inertial>").unwrap() + "</inertial>".len();
        format!("{}{}", &text[..from], &text[to..])
    });
    shop.replay_refused(&["--cell", "0.02@8"], &["machine.urdf", "slider_b", "inertial"]);
}

#[test]
fn exact_unknown_key_is_refused_with_its_line() {
    for (known, unknown) in [("resistance_ohm", "resistence_ohm"), ("sample_period_s", "sample_period_ms")] {
        let shop = Workshop::new();
        shop.edit("machine.toml", |text| text.replacen(known, unknown, 1));
        let text = fs::read_to_string(shop.folder.path().join("machine/machine.toml")).unwrap();
        let row = 1 + text.lines().position(|line| line.starts_with(unknown)).unwrap();
        let source = text.lines().nth(row - 1).unwrap();
        let place = format!("machine.toml, row {row}, `{unknown}`");
        shop.replay_refused(&["--cell", "0.02@8"], &[&place, known, source, "correct or remove that line"]);
    }
}

#[test]
fn exact_wrong_settings_are_refused() {
    let shop = Workshop::new();
    let cell = ["--cell", "0.02@8"];
    for (setting, words) in [
        ("controller.integrl=22", &["--set controller.integrl = 22", "`integral`"][..]),
        ("contoller.integral=22", &["--set contoller.integral = 22", "`controller`"]),
        ("sample_period_s.x=22", &["sample_period_s.x"]),
        ("motor.resistance_ohm=-1", &["motor.resistance_ohm", "-1", "more than zero"]),
        ("controller.integral=fast", &["--set", "`fast` is not a TOML value", "in quotes"]),
        ("controller.integral", &["--set", "no `=`"]),
    ] {
        shop.replay_refused(&[&cell[..], &["--set", setting]].concat(), words);
    }
    // Among several, the one at fault is named.
    let several = ["--set", "controller.integral=22", "--set", "motor.kind_of=1"];
    shop.replay_refused(&[&cell[..], &several].concat(), &["--set motor.kind_of = 1"]);
    let hide = ["--hide", "effect.colomb_friction.force_n=15"];
    shop.replay_refused(&[&cell[..], &hide].concat(), &["--hide", "coulomb_friction"]);
}

#[test]
fn exact_wrong_cells_and_options_are_refused() {
    let shop = Workshop::new();
    for cell in ["0.02", "0.02@", "@8", "0@8", "0.02@0", "0.02@-8", "a@b", "nan@8"] {
        shop.replay_refused(&["--cell", cell], &["--cell", "@"]);
    }
    shop.replay_refused(&["--cell", "0.5@8"], &["table_slide", "0.5 m", "shorten the stroke"]);
    shop.replay_refused(&["--cell", "0.02@8", "0.02@8"], &["twice", "--repeat"]);
    shop.replay_refused(&["--cell", "0.02@8", "--dwell", "-1"], &["--dwell"]);
    shop.replay_refused(&["--cell", "0.02@8", "--plant", "granite"], &["--plant", "rapier"]);
    shop.replay_refused(&["--cell", "0.02@8", "--perfect", "--repeat", "2"], &["--perfect", "--repeat"]);
    shop.replay_refused(&[], &["--cell"]);
    refused(&["identify"], &["--machine"]);
    refused(&["inspect", "/nowhere/at/all"], &["/nowhere/at/all", "no such file or folder"]);
}

#[test]
fn exact_existing_folders_are_left_alone() {
    let shop = Workshop::new();
    let (machine, out) = (shop.machine(), shop.out());
    let start = ["replay", "--machine", &machine, "--out", &out, "--cell", "0.02@8", "--plant", "axis"];
    succeeded(&start);
    let before = Recording::read(&out).unwrap().sha256();
    refused(&start, &[&out, "--replace"]);
    assert_eq!(Recording::read(&out).unwrap().sha256(), before);
    // A folder that is no recording is not replaced either.
    let other = shop.folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("thesis.txt"), "years of work").unwrap();
    let place = other.display().to_string();
    let start = ["replay", "--machine", &machine, "--out", &place, "--cell", "0.02@8", "--plant", "axis"];
    refused(&[&start[..], &["--replace"]].concat(), &[&place, "not a recording"]);
    assert_eq!(fs::read_dir(&other).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn exact_broken_pipe_is_no_error() {
    use std::process::Stdio;
    let mut child = Command::new(SLIDEWAY)
        .args(["inspect", &grinder().display().to_string()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Nobody reads: the pipe is closed before the first line.
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}

#[test]
fn exact_gains_of_the_shipped_recording_are_those_stated() {
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/hidden_coulomb").display().to_string();
    let told = succeeded(&["identify", "gains", &recording, "--position-loop"]);
    for row in ["integral_gain_per_count", "0.069420", "2.3590e-4", "6.5000", "0.70000"] {
        assert!(told.contains(row), "{row} is not in {told}");
    }
    refused(&["identify", "gains", &recording, "--run", "nix"], &["--run", "stroke020_feed08"]);
    refused(&["identify", "gains", &recording, "--table", "x.toml"], &["--table"]);
    refused(&["identify", "gains"], &["RECORDING"]);
    let machine = grinder().join("machine.toml").display().to_string();
    refused(&["identify", "gains", "--table", &machine], &["machine.toml", "unknown field"]);
    refused(&["identify", "gains", "--table", "/nowhere/table.toml"], &["/nowhere/table.toml"]);
}

#[test]
fn exact_tuning_says_what_it_chose_and_refuses_wrong_questions() {
    let machine = grinder().display().to_string();
    let place = TempDir::new().unwrap();
    let page = place.path().join("tune.html").display().to_string();
    let few = [
        "tune",
        &machine,
        "--vary",
        "controller.integral=18..24:2",
        "--vary",
        "controller.proportional=200..260:20",
    ];
    let told = succeeded(&[&few[..], &["--mark", "22,220", "--cell", "0.02@8", "--html", &page]].concat());
    assert!(told.contains("marked 22/220") && told.contains("chosen"), "{told}");
    assert!(fs::read_to_string(&page).unwrap().contains("<svg"));
    let wrong = |more: &[&str], words: &[&str]| refused(&[&["tune", &machine], more].concat(), words);
    wrong(&["--vary", "controller.integral=24..18"], &["controller.integral", "24..18"]);
    wrong(&["--vary", "motor.resistance_ohm=1..2"], &["motor.resistance_ohm", "[controller]"]);
    wrong(&["--vary", "controller.integral"], &["KEY=FROM..TO"]);
    wrong(&["--mark", "22"], &["--mark", "expected 2"]);
    wrong(&["--limit", "overshoot=1"], &["position_overshoot_percent"]);
    wrong(&["--cell", "5@8"], &["0.35"]);
    wrong(&["--cell", "1e300@8"], &["1e300"]);
    wrong(&["--mark", "22.5,220"], &["controller.integral", "whole number"]);
    wrong(&["--friction", "-3"], &["--friction"]);
    wrong(&["--dwell", "0"], &["--dwell"]);
    refused(&["tune", "/nowhere"], &["/nowhere"]);
}
