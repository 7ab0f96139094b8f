//! `slideway diagnose --write-machine`: the improved machine reads back, says where its values come from, and leaves
//! no gap when it is diagnosed again.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{slideway as run, text};
use serde_json::Value;
use slideway::machine::Machine;
use slideway::machine::provenance::Reason;
use slideway::recording::Existing;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const DONE: Option<i32> = Some(0);
const BAD_INPUT: Option<i32> = Some(2);
const HIDDEN_N: f64 = 15.0;
/// Two short strokes at micrometre noise tell 15 N within a few tenths.
const FORCE_TOLERANCE_N: f64 = 0.5;
/// The scene and the reduced axis agree far below the noise: what closes in one closes in the other.
const CLOSED_TOLERANCE: f64 = 0.02;

fn grinder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")
}

/// A folder with a recording from the rigid-body scene in which `hidden` acts.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new(hidden: &[&str]) -> Self {
        let desk = Self { folder: TempDir::new().unwrap() };
        let (machine, out) = (grinder().display().to_string(), desk.at("recording"));
        let mut arguments = vec!["replay", "--machine", &machine, "--out", &out, "--return"];
        for setting in hidden {
            arguments.extend(["--hide", setting]);
        }
        arguments.extend(["--cell", "0.02@4", "0.03@8", "0.04@16", "--held-out", "0.03@8"]);
        let output = run(&arguments);
        assert_eq!(output.status.code(), DONE, "{}", text(&output.stderr));
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn at(&self, name: &str) -> String {
        self.path(name).display().to_string()
    }

    /// Diagnoses with a machine and returns the verdict.
    fn diagnose(&self, machine: &Path, more: &[&str]) -> Value {
        let (recording, json) = (self.at("recording"), self.at("verdict.json"));
        let machine = machine.display().to_string();
        let fixed = ["diagnose", &recording, "--machine", &machine, "--json", &json];
        let output = run(&[&fixed[..], more].concat());
        assert_eq!(output.status.code(), DONE, "{}", text(&output.stderr));
        serde_json::from_str(&fs::read_to_string(json).unwrap()).unwrap()
    }
}

/// Effects of the small catalogue that these diagnoses choose from, for speed.
fn only(kept: &[&str]) -> Vec<String> {
    let all = slideway::effect::EffectId::ALL.iter().map(|effect| effect.name());
    let struck = all.filter(|name| !kept.contains(name));
    struck.flat_map(|name| ["--without".to_owned(), name.to_owned()]).collect()
}

fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn ref_hidden_friction_written_into_the_machine_leaves_no_gap() {
    let desk = Desk::new(&["effect.coulomb_friction.force_n=15"]);
    let written = desk.path("improved");
    let only = only(&["coulomb_friction", "viscous_friction", "payload", "loop_delay"]);
    let mut more: Vec<&str> = only.iter().map(String::as_str).collect();
    let place = written.display().to_string();
    more.extend(["--write-machine", &place]);
    let first = desk.diagnose(&grinder(), &more);
    assert_eq!(first["verdict"], "cause");
    assert_eq!(first["causes"][0]["effect"], "coulomb_friction");

    // The shrink repeats in the rigid-body scene.
    let (gap, scene) = (&first["gap"], &first["gap"]["rigid_body"]);
    let difference = gap["closed"].as_f64().unwrap() - scene["closed"].as_f64().unwrap();
    assert!(difference.abs() < CLOSED_TOLERANCE, "{scene}");
    let on_axis = scene["closed_on_axis"].as_f64().unwrap() - gap["closed"].as_f64().unwrap();
    assert!(on_axis.abs() < 1e-9, "{scene}");
    assert_eq!(scene["runs"], first["data"]["held_out"]);

    // A machine folder like any other, with the fitted values and where they come from.
    assert_eq!(files(&written), ["README.md", "machine.toml", "machine.urdf", "meshes", "written.sha256"]);
    let stated = fs::read_to_string(grinder().join("machine.toml")).unwrap();
    let text = fs::read_to_string(written.join("machine.toml")).unwrap();
    // The line that names the schema holds for its own folder only.
    let (schema, stated) = stated.split_once('\n').unwrap();
    assert!(schema.starts_with("#:schema "), "{schema}");
    assert!(text.starts_with(stated.trim()), "the machine file as it stood comes first, comments and all");
    let machine = Machine::read(&written).unwrap();
    let force = machine.number("effect.coulomb_friction.force_n").unwrap();
    assert!((force - HIDDEN_N).abs() < FORCE_TOLERANCE_N, "{force}");
    let [provenance] = &machine.description().provenance[..] else { panic!("one entry") };
    assert_eq!(provenance.recording_sha256, first["data"]["sha256"]);
    let cause = provenance.value.iter().find(|value| value.reason == Reason::Cause).unwrap();
    assert_eq!((cause.path.as_str(), cause.value), ("effect.coulomb_friction.force_n", force));
    assert!(cause.ci95[0] < force && force < cause.ci95[1]);
    for value in &provenance.value {
        assert_eq!(machine.number(&value.path), Some(value.value), "{}", value.path);
    }

    // Diagnosing again: nothing is left.
    let second = desk.diagnose(&written, &[]);
    assert_eq!((&second["verdict"], second["causes"].as_array().unwrap().len()), (&"no_gap".into(), 0));
    assert!(second["gap"]["rigid_body"].is_null());
}

/// With one of two effects struck from the catalogue, the written machine has the first; the next diagnosis names the
/// other, and a machine written there in turn keeps the history.
#[test]
fn ref_second_diagnosis_names_the_next_effect() {
    let desk = Desk::new(&["effect.coulomb_friction.force_n=15", "effect.constant_force.force_n=40"]);
    let written = desk.at("improved");
    let first_only = only(&["constant_force", "viscous_friction"]);
    let mut more: Vec<&str> = first_only.iter().map(String::as_str).collect();
    more.extend(["--write-machine", &written]);
    let first = desk.diagnose(&grinder(), &more);
    let named = |d: &Value| -> Vec<String> {
        let causes = d["causes"].as_array().unwrap().iter();
        causes.map(|cause| cause["effect"].as_str().unwrap().to_owned()).collect()
    };
    assert!(named(&first).contains(&"constant_force".to_owned()), "{:?}", named(&first));
    let second_only = only(&["constant_force", "coulomb_friction", "viscous_friction"]);
    let mut more: Vec<&str> = second_only.iter().map(String::as_str).collect();
    // Written by a diagnosis: may be replaced.
    more.extend(["--write-machine", &written]);
    let second = desk.diagnose(Path::new(&written), &more);
    assert!(named(&second).contains(&"coulomb_friction".to_owned()), "{:?}", named(&second));
    let machine = Machine::read(Path::new(&written)).unwrap();
    assert_eq!(machine.description().provenance.len(), 2);
    let text = fs::read_to_string(Path::new(&written).join("machine.toml")).unwrap();
    assert!(text.contains("# Every number's source is in README.md"), "{text}");
}

#[test]
fn exact_nothing_is_written_where_nothing_is_missing() {
    let desk = Desk::new(&[]);
    let written = desk.at("improved");
    let (recording, machine) = (desk.at("recording"), grinder().display().to_string());
    let output = run(&["diagnose", &recording, "--machine", &machine, "--write-machine", &written]);
    assert_eq!(output.status.code(), DONE, "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("No machine written"));
    assert_eq!(files(desk.folder.path()), ["recording"]);
}

/// Folders that hold anything but a machine that a diagnosis wrote are refused before the work begins, and left alone.
#[test]
fn exact_folder_that_is_not_ours_is_refused() {
    let desk = Desk::new(&[]);
    let (recording, machine) = (desk.at("recording"), grinder().display().to_string());
    let refused = |place: &str, word: &str| {
        let output = run(&["diagnose", &recording, "--machine", &machine, "--write-machine", place]);
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), BAD_INPUT, "{told}");
        assert!(told.contains(word), "`{word}` is not in: {told}");
    };
    let foreign = desk.path("foreign");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("notes.txt"), "mine").unwrap();
    refused(&foreign.display().to_string(), "not a machine");
    assert_eq!(files(&foreign), ["notes.txt"]);
    refused(&foreign.join("notes.txt").display().to_string(), "a file");
    refused(&machine, "without [[provenance]]");

    // One of ours, with a file that replacing would delete.
    let own = desk.path("own");
    let stated = Machine::read(&grinder()).unwrap();
    let entry = slideway::machine::Provenance {
        recording_sha256: "0".to_owned(),
        training: Vec::new(),
        held_out: Vec::new(),
        gap_before: 2.0,
        gap_after: 1.0,
        closed: 1.0,
        closed_ci95: [0.9, 1.0],
        version: "0".to_owned(),
        value: Vec::new(),
    };
    stated.write(&own, entry.clone(), Existing::Refuse).unwrap();
    stated.write(&own, entry.clone(), Existing::Refuse).unwrap();

    // Edits by hand are overwritten only where that is asked for.
    let file = own.join("machine.toml");
    let edited = fs::read_to_string(&file).unwrap() + "# measured again\n";
    fs::write(&file, &edited).unwrap();
    refused(&own.display().to_string(), "`machine.toml`, which was changed since it was written");
    assert_eq!(fs::read_to_string(&file).unwrap(), edited);
    stated.write(&own, entry, Existing::Replace).unwrap();
    assert!(!fs::read_to_string(&file).unwrap().contains("measured again"));
    fs::write(own.join("notes.txt"), "mine").unwrap();
    refused(&own.display().to_string(), "notes.txt");
    assert!(own.join("notes.txt").is_file());
    let left = files(desk.folder.path());
    assert_eq!(left, ["foreign", "own", "recording"], "nothing half-written is left");
}
