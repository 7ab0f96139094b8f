//! `slideway diagnose` as a user runs it: the JSON contract, exit codes, and refusals that leave nothing behind.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{slideway as run, text};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

const SLIDEWAY: &str = env!("CARGO_BIN_EXE_slideway");
const DONE: Option<i32> = Some(0);
const GAP_FOUND: Option<i32> = Some(1);
const BAD_INPUT: Option<i32> = Some(2);
const EFFECT: &str = "coulomb_friction";

fn grinder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")
}

/// A folder with a small recording in which Coulomb friction is hidden, one cell held out.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new(cells: &[&str]) -> Self {
        let desk = Self { folder: TempDir::new().unwrap() };
        let (machine, out) = (grinder().display().to_string(), desk.recording());
        let start = ["replay", "--machine", &machine, "--out", &out, "--return", "--plant", "axis"];
        let hide = ["--hide", "effect.coulomb_friction.force_n=15"];
        let output = run(&[&start[..], &hide, &["--cell"], cells].concat());
        assert_eq!(output.status.code(), DONE, "{}", text(&output.stderr));
        desk
    }

    fn two_cells() -> Self {
        Self::new(&["0.02@8", "0.03@8", "--held-out", "0.02@8"])
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn recording(&self) -> String {
        self.path("recording").display().to_string()
    }

    /// Rewrites one file of the recording.
    fn edit(&self, file: &str, change: impl FnOnce(String) -> String) {
        let path = self.path("recording").join(file);
        let before = fs::read_to_string(&path).unwrap();
        let after = change(before.clone());
        assert_ne!(before, after, "the edit must change {file}");
        fs::write(path, after).unwrap();
    }

    /// A diagnosis that must be refused with exit code 2 and these words, and leave nothing behind.
    #[track_caller]
    fn refused(&self, more: &[&str], words: &[&str]) {
        let (recording, json) = (self.recording(), self.path("verdict.json").display().to_string());
        let output = run(&[&["diagnose", &recording, "--json", &json], more].concat());
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), BAD_INPUT, "{told}");
        assert_eq!(text(&output.stdout), "");
        for word in words {
            assert!(told.contains(word), "`{word}` is not in: {told}");
        }
        let left: Vec<_> =
            fs::read_dir(self.folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left, ["recording"], "something was left behind");
    }
}

/// One diagnosis with everything written, for all tests that only look at it.
struct Finished {
    output: Output,
    json: String,
    left: Vec<String>,
}

fn finished() -> &'static Finished {
    static FINISHED: OnceLock<Finished> = OnceLock::new();
    FINISHED.get_or_init(|| {
        let desk = Desk::two_cells();
        let json = desk.path("verdict.json");
        let output =
            run(&["diagnose", &desk.recording(), "--json", &json.display().to_string(), "--exit-code"]);
        let mut left: Vec<String> = fs::read_dir(desk.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        Finished { output, json: fs::read_to_string(json).unwrap_or_default(), left }
    })
}

fn verdict() -> Value {
    serde_json::from_str(&finished().json).unwrap()
}

#[track_caller]
fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("`{key}` is no number in {value}"))
}

#[track_caller]
fn share(value: &Value, key: &str) {
    let share = number(value, key);
    assert!((0.0..=1.0).contains(&share), "`{key}` = {share}");
}

#[track_caller]
fn word<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("`{key}` is no text in {value}"))
}

#[track_caller]
fn list<'a>(value: &'a Value, key: &str) -> &'a Vec<Value> {
    value[key].as_array().unwrap_or_else(|| panic!("`{key}` is no list in {value}"))
}

#[track_caller]
fn words(value: &Value, key: &str) -> Vec<String> {
    list(value, key).iter().map(|word| word.as_str().unwrap().to_owned()).collect()
}

#[test]
fn exact_gap_found_ends_with_its_exit_code_and_one_file() {
    let done = finished();
    assert_eq!(done.output.status.code(), GAP_FOUND, "{}", text(&done.output.stderr));
    assert_eq!(text(&done.output.stderr), "");
    assert_eq!(done.left, ["recording", "verdict.json"]);
}

#[test]
fn exact_report_names_the_data_and_what_is_wrong() {
    let report = text(&finished().output.stdout);
    let flat = report.split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "simulated, not measured",
        "hidden: effect.coulomb_friction.force_n = 15",
        "training stroke030_feed08",
    ] {
        assert!(flat.contains(words), "`{words}` is not in:\n{report}");
    }
    for words in ["WHERE", "WHICH", "HOW FAR", "NEXT", "Coulomb friction"] {
        assert!(report.contains(words), "`{words}` is not in:\n{report}");
    }
    assert!(!report.contains('\u{1b}'), "colours although standard output is no terminal");
    assert!(!report.contains("NaN"), "{report}");
}

#[test]
fn exact_json_holds_verdict_and_causes() {
    let d = verdict();
    assert_eq!(word(&d, "schema"), "slideway-diagnosis/1");
    assert!(["cause", "undecided", "unknown", "no_gap"].contains(&word(&d, "verdict")));
    assert_eq!(word(&d, "version"), env!("CARGO_PKG_VERSION"));
    let mut suspects = Vec::new();
    for cause in list(&d, "causes") {
        suspects.push(word(cause, "effect").to_owned());
        suspects.extend(words(cause, "confusable_with"));
        let sites = ["controller", "amplifier", "motor", "guide", "structure", "sensor"];
        assert!(sites.contains(&word(cause, "site")), "{cause}");
        share(cause, "probability");
        number(cause, "closes");
        let parameters = cause["parameters"].as_object().unwrap();
        assert!(!parameters.is_empty(), "{cause}");
        for parameter in parameters.values() {
            let (value, ci95) = (number(parameter, "value"), list(parameter, "ci95"));
            let (from, to) = (ci95[0].as_f64().unwrap(), ci95[1].as_f64().unwrap());
            assert!(from <= value && value <= to, "{parameter}");
            assert!(!word(parameter, "unit").is_empty());
        }
    }
    assert!(suspects.iter().any(|name| name == EFFECT), "{suspects:?}");
}

#[test]
fn exact_json_holds_effects_and_ranking() {
    let d = verdict();
    let effects = list(&d, "effects");
    assert!(effects.iter().any(|effect| word(effect, "effect") == EFFECT));
    effects.iter().for_each(|effect| share(effect, "probability"));
    let ranking = list(&d, "ranking");
    for ranked in ranking {
        words(ranked, "effects");
        share(ranked, "probability");
        assert!(number(ranked, "held_out_gap") > 0.0);
    }
    assert!(ranking.iter().any(|ranked| words(ranked, "effects").is_empty()), "the twin as it is competes");
}

#[test]
fn exact_json_holds_the_gap() {
    let d = verdict();
    let gap = &d["gap"];
    for key in ["before", "after", "floor", "closed", "predicted_closed"] {
        number(gap, key);
    }
    assert!(number(gap, "before") > number(gap, "after"), "{gap}");
    assert_eq!(list(gap, "closed_ci95").len(), 2);
    let signals = list(gap, "signals");
    assert!(signals.iter().any(|signal| word(signal, "signal") == "position_m"));
    for signal in signals {
        for key in ["rms_before", "rms_after", "noise", "mae_before", "mae_after", "r2_before", "r2_after"] {
            number(signal, key);
        }
        word(signal, "noise_source");
    }
    share(&d, "unexplained");
    let next = &d["next_experiment"];
    if !next.is_null() {
        word(next, "sentence");
        word(next, "command");
        number(next, "predicted_separation");
        number(&next["motion"], "dwell_s");
    }
}

#[test]
fn exact_json_says_where() {
    let d = verdict();
    let place = &d["where"];
    for key in ["site", "phase"] {
        assert!(!list(place, key).is_empty(), "{key}");
        for entry in list(place, key) {
            word(entry, key);
            share(entry, "share");
        }
    }
    for key in ["frequency_hz", "position"] {
        assert!(!list(place, key).is_empty(), "{key}");
        for band in list(place, key) {
            assert!(number(band, "from") < number(band, "to"), "{band}");
            share(band, "share");
        }
    }
}

#[test]
fn exact_json_says_what_it_stands_on() {
    let d = verdict();
    let data = &d["data"];
    assert!(!word(data, "machine").is_empty());
    assert_eq!(words(data, "training"), ["stroke030_feed08"]);
    assert_eq!(words(data, "held_out"), ["stroke020_feed08"]);
    let sha256 = word(data, "sha256");
    assert!(sha256.len() == 64 && sha256.chars().all(|digit| digit.is_ascii_hexdigit()), "{sha256}");
    assert!(word(data, "note").contains("hidden"));
}

#[test]
fn exact_json_on_standard_output_stands_alone() {
    let desk = Desk::two_cells();
    let machine = grinder().display().to_string();
    let without = ["--without", "loop_delay", "--without", "asymmetric_friction", "--without", "payload"];
    let start = ["diagnose", &desk.recording(), "--machine", &machine, "--json", "-"];
    let output = run(&[&start[..], &without].concat());
    assert_eq!(
        output.status.code(),
        DONE,
        "without --exit-code a gap is no failure: {}",
        text(&output.stderr)
    );
    let d: Value = serde_json::from_slice(&output.stdout).unwrap();
    let effects: Vec<&str> = list(&d, "effects").iter().map(|effect| word(effect, "effect")).collect();
    assert!(effects.contains(&EFFECT) && !effects.contains(&"payload"), "{effects:?}");
    let ranked = list(&d, "ranking").iter().flat_map(|ranked| words(ranked, "effects"));
    assert!(!ranked.into_iter().any(|effect| effect == "loop_delay"), "struck effects are not fitted");
    let left: Vec<_> = fs::read_dir(desk.folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["recording"]);
}

/// The same strokes with more friction: the recording before and the one after, in either way of naming them.
#[test]
fn exact_comparison_tells_what_changed() {
    let desk = Desk::two_cells();
    let (before, after) = (desk.recording(), desk.path("after").display().to_string());
    let machine = grinder().display().to_string();
    let replay = ["replay", "--machine", &machine, "--out", &after, "--return", "--plant", "axis"];
    let hide = ["--hide", "effect.coulomb_friction.force_n=30", "--noise", "2"];
    let cells = ["--cell", "0.02@8", "0.03@8", "--held-out", "0.02@8"];
    let output = run(&[&replay[..], &hide, &cells].concat());
    assert_eq!(output.status.code(), DONE, "{}", text(&output.stderr));
    let json = desk.path("verdict.json");
    let options = ["--reference", &before, "--json", &json.display().to_string(), "--exit-code"];
    let output = run(&[&["diagnose", "--recording", &after], &options[..]].concat());
    assert_eq!(output.status.code(), GAP_FOUND, "{}", text(&output.stderr));
    let report = text(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    for words in [
        "WHAT CHANGED",
        "Changed since the reference: Coulomb friction on the guide, 1",
        "× 2.0",
        "stroke030_feed08; held out",
    ] {
        assert!(report.contains(words), "`{words}` is not in {report}");
    }
    let d: Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let force = |cause: &Value, key: &str| number(&cause["parameters"]["force_n"], key);
    let (change, had) = (&list(&d, "causes")[0], &list(&d["reference"], "causes")[0]);
    assert_eq!((word(change, "effect"), word(had, "effect")), (EFFECT, EFFECT));
    assert!((force(had, "value") - 15.0).abs() < 1.0 && force(had, "twin") == 0.0, "{had}");
    assert!((force(change, "value") - 30.0).abs() < 2.0, "{change}");
    assert!((force(change, "twin") / force(had, "value") - 1.0).abs() < 1e-9, "{change}");
    assert_eq!(word(&d["reference"], "verdict"), "cause");
    assert!(number(&d["reference"], "gap_before") > number(&d["reference"], "gap_after"));
    assert_ne!(word(&d["reference"]["data"], "sha256"), word(&d["data"], "sha256"));
    assert!(verdict()["reference"].is_null(), "a plain diagnosis has no reference");
}

#[test]
fn exact_reference_that_is_not_there_is_refused() {
    let desk = Desk::two_cells();
    desk.refused(&["--reference", "/nowhere/before"], &["/nowhere/before", "no such file"]);
    let twice = run(&["diagnose", &desk.recording(), "--recording", &desk.recording()]);
    let none = run(&["diagnose", "--reference", &desk.recording()]);
    for output in [twice, none] {
        assert_eq!(output.status.code(), BAD_INPUT);
        assert!(text(&output.stderr).contains("RECORDING"), "{}", text(&output.stderr));
    }
}

#[test]
fn exact_missing_column_is_refused() {
    let desk = Desk::two_cells();
    desk.edit("stroke020_feed08.csv", |text| text.replacen(",position_m", ",commanded", 1));
    desk.refused(&[], &["stroke020_feed08", "`position_m`"]);
}

#[test]
fn exact_nan_is_refused_with_its_row() {
    let desk = Desk::two_cells();
    desk.edit("stroke030_feed08.csv", |text| {
        let column = text.lines().next().unwrap().split(',').position(|name| name == "position_m").unwrap();
        let spoil = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            let spoilt = cells.iter().enumerate().map(|(k, cell)| if k == column { "nan" } else { cell });
            spoilt.collect::<Vec<_>>().join(",")
        };
        let lines = text.lines().enumerate();
        lines.map(|(k, line)| if k == 41 { spoil(line) } else { line.to_owned() } + "\n").collect()
    });
    desk.refused(&[], &["stroke030_feed08.csv", "row 42", "position_m", "nan"]);
}

#[test]
fn exact_swapped_unit_is_refused() {
    let desk = Desk::two_cells();
    desk.edit("recording.toml", |text| {
        format!("{text}\n[columns]\nposition_m = {{ column = \"position_m\", unit = \"mm\" }}\n")
    });
    desk.refused(&[], &["position_m", "mm", "unit"]);
}

#[test]
fn exact_single_run_that_stands_is_refused() {
    let desk = Desk::new(&["0.02@8"]);
    desk.edit("recording.toml", |text| text.replace("[[run]]", "[[run]]\nto_s = 0.03"));
    desk.refused(&[], &["recording.toml", "`run`", "a single run", "record a longer run"]);
}

#[test]
fn exact_recording_without_machine_is_refused() {
    let desk = Desk::two_cells();
    desk.edit("recording.toml", |text| {
        text.lines().filter(|line| !line.starts_with("machine")).map(|line| format!("{line}\n")).collect()
    });
    desk.refused(&[], &["recording.toml", "`machine`", "--machine DIR"]);
    desk.refused(&["--machine", "/nowhere/at/all"], &["/nowhere/at/all", "machine folder"]);
}

#[test]
fn exact_machine_of_another_motion_is_refused() {
    let desk = Desk::two_cells();
    for file in ["stroke020_feed08.csv", "stroke030_feed08.csv"] {
        desk.edit(file, |text| {
            let (head, rest) = text.split_once('\n').unwrap();
            let head = head
                .replace("_m_per_s", "_rad_per_s")
                .replace("_m,", "_rad,")
                .replace("thrust_n", "torque_nm");
            format!("{head}\n{rest}")
        });
    }
    desk.edit("recording.toml", |text| text.replacen("motion = \"prismatic\"", "motion = \"revolute\"", 1));
    desk.refused(&[], &["recording.toml", "`motion`", "a revolute axis", "a prismatic one"]);
}

#[test]
fn exact_wrong_options_are_refused() {
    let desk = Desk::two_cells();
    desk.refused(
        &["--without", "colomb_friction"],
        &["--without", "colomb_friction", "coulomb_friction", "payload"],
    );
    desk.refused(&["--set", "controller.integrl=22"], &["--set controller.integrl = 22", "`integral`"]);
    desk.refused(
        &["--set", "effect.friction.force_n=1"],
        &["--set effect.friction.force_n", "coulomb_friction"],
    );
}

#[test]
fn exact_json_that_cannot_be_written_is_refused_before_the_work() {
    let desk = Desk::two_cells();
    let recording = desk.recording();
    let nowhere = desk.path("nowhere/verdict.json").display().to_string();
    for (json, words) in [(&nowhere, "folder that is not there"), (&recording, "a folder")] {
        let output = run(&["diagnose", &recording, "--json", json]);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), BAD_INPUT, "{told}");
        assert!(told.contains("--json") && told.contains(words), "{told}");
    }
    let left: Vec<_> = fs::read_dir(desk.folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["recording"]);
}

/// The program, to be stopped by an interrupt even where the tests ignore it: a shell starts `command &` so, and a
/// program inherits it.
#[cfg(unix)]
fn interruptible() -> Command {
    let default = ["--default-signal=INT"];
    // Not every `env` can do that.
    if !Command::new("env").args(default).arg("true").output().is_ok_and(|o| o.status.success()) {
        return Command::new(SLIDEWAY);
    }
    let mut command = Command::new("env");
    command.args(default).arg(SLIDEWAY);
    command
}

/// Ctrl-C in the middle of the work: whatever was to be written is whole or not there, and the recording is as it was.
#[cfg(unix)]
#[test]
fn exact_interrupted_diagnosis_leaves_nothing_half_written() {
    use std::os::unix::process::ExitStatusExt;
    const INTERRUPT: i32 = 2;
    // Slow strokes make long runs: work for seconds.
    let desk = Desk::new(&["0.04@1", "0.05@1", "0.05@2", "--held-out", "0.04@2"]);
    let out = desk.path("out");
    fs::create_dir(&out).unwrap();
    let entries = |path: &Path| -> Vec<PathBuf> {
        let mut all: Vec<PathBuf> = fs::read_dir(path).unwrap().map(|e| e.unwrap().path()).collect();
        all.sort();
        all
    };
    let recorded = entries(Path::new(&desk.recording()));
    let place = |name: &str| out.join(name).display().to_string();
    let mut child = interruptible()
        .args(["diagnose", &desk.recording(), "--machine", &grinder().display().to_string()])
        .args(["--json", &place("verdict.json"), "--html", &place("report.html")])
        .args(["--figures", &place("figures"), "--write-machine", &place("machine")])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let status = child.wait().unwrap();
    assert_eq!(status.signal(), Some(INTERRUPT), "{status:?}: it was to be interrupted at work");
    assert_eq!(entries(&out), Vec::<PathBuf>::new());
    assert_eq!(entries(Path::new(&desk.recording())), recorded);
}
