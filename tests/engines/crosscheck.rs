//! `slideway crosscheck`: the plants held against each other, and what happens where they are apart.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use nalgebra::Complex;
use slideway::base::{Mode, Modes};
use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::plant::mujoco;
use slideway::replay::crosscheck::{Crosscheck, Outcome, Quantity, cells_of};
use slideway::replay::{Cell, PlantChoice};
use tempfile::TempDir;

const MACHINES: [&str; 4] = ["delta_a3", "emps", "grinder", "grinder_yaxis"];
/// The paper's cells: six of its Table 1, then those of Figs. 6 and 7.
const PAPER: [&str; 8] = ["0.02@4", "0.03@4", "0.03@8", "0.04@8", "0.04@16", "0.05@16", "0.02@8", "0.03@16"];
/// Axis and scene on the paper's cells: a hundredth of the encoder's noise.
const PARITY_M: f64 = 0.3e-9;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

fn shipped(name: &str) -> Machine {
    Machine::read(&models().join(name)).unwrap()
}

fn with(machine: &Machine, key: &str, value: f64) -> Machine {
    machine.with_settings([(key, toml::Value::Float(value))]).unwrap()
}

fn checked(machine: &Machine) -> Outcome {
    Crosscheck::of(machine, &cells_of(machine).unwrap()).unwrap().run(|_| ()).unwrap()
}

/// A machine of one's own from the shipped screw axis.
fn edited(change: impl FnOnce(String) -> String) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::copy(models().join("emps/machine.urdf"), folder.path().join("machine.urdf")).unwrap();
    let text = fs::read_to_string(models().join("emps/machine.toml")).unwrap();
    fs::write(folder.path().join("machine.toml"), change(text)).unwrap();
    folder
}

#[test]
fn ref_all_shipped_machines_are_within_their_bounds() {
    for name in MACHINES {
        let outcome = checked(&shipped(name));
        assert_eq!(outcome.exceeded(), [""; 0], "{name}");
        assert_eq!(outcome.plants.len(), if mujoco::IS_BUILT_IN { 3 } else { 2 });
        assert!(outcome.is_closed_loop);
        for stroke in &outcome.strokes {
            assert!(stroke.peak_velocity > 0.0 && stroke.peak_thrust > 0.0, "{name}: {}", stroke.cell);
            for difference in stroke.differences.iter().filter(|d| d.quantity == Quantity::Position) {
                assert!(
                    difference.bound.limit <= 1e-7 && difference.rms <= PARITY_M,
                    "{name}: {}",
                    stroke.cell
                );
            }
        }
    }
}

#[test]
fn exact_the_papers_cells_are_in_the_machine_file() {
    let cells: Vec<String> = cells_of(&shipped("grinder")).unwrap().iter().map(Cell::to_string).collect();
    assert_eq!(cells, PAPER);
}

/// 10 and 40 % of 0.35 m at 20 and 80 % of 1 m/s; of a turn in a second where nothing is limited.
#[test]
fn exact_strokes_without_a_plan_have_the_axis_own_size() {
    let cells = |name: &str| -> Vec<String> {
        cells_of(&shipped(name)).unwrap().iter().map(Cell::to_string).collect()
    };
    assert_eq!(cells("emps"), ["0.035@12", "0.14@12", "0.035@48", "0.14@48"]);
    assert_eq!(cells("delta_a3"), ["0.62@1.2", "2.5@1.2", "0.62@5", "2.5@5"]);
}

/// Eigenvalues against the characteristic polynomial of a table with drag on one mode, and against the modes themselves.
#[test]
fn exact_oscillations_of_the_assembled_axis() {
    let mut constants = shipped("grinder").constants();
    let mode = Mode::new(86.1, 1500.0, 0.02).unwrap();
    constants.modes = Modes::new(vec![mode]);
    let (m, c, modal, omega) = (constants.moving_mass, constants.viscous, 1500.0, TAU * 86.1);
    let found = Axis::of(&constants).resonances();
    assert_eq!(found.len(), 1);
    let (size, zeta) = (TAU * found[0].frequency_hz, found[0].damping_ratio);
    let s = Complex::new(-zeta * size, size * (1.0 - zeta * zeta).sqrt());
    let of_base = s * s * modal + s * (2.0 * 0.02 * omega * modal + c) + modal * omega * omega;
    let rest = (s * m + c) * of_base - s * c * c;
    assert!(rest.norm() < 1e-12 * (m * modal * size * size * size), "{rest}");
    constants.viscous = 0.0;
    let free = Axis::of(&constants).resonances();
    assert!((free[0].frequency_hz / 86.1 - 1.0).abs() < 1e-13);
    assert!((free[0].damping_ratio / 0.02 - 1.0).abs() < 1e-12);
    constants.modes = Modes::default();
    assert!(Axis::of(&constants).resonances().is_empty());
}

#[test]
fn exact_a_plant_of_another_mass_exceeds_the_bounds() {
    let machine = shipped("grinder");
    let cells = ["0.03@8".parse().unwrap()];
    let heavier = with(&machine, "effect.payload.mass_kg", 1e-3 * machine.constants().moving_mass);
    for plant in [PlantChoice::Rapier, PlantChoice::Mujoco] {
        if plant == PlantChoice::Mujoco && !mujoco::IS_BUILT_IN {
            continue;
        }
        let outcome = Crosscheck::of(&machine, &cells).unwrap().with(plant, &heavier).run(|_| ()).unwrap();
        assert!(!outcome.is_within());
        let exceeded = outcome.exceeded().join("\n");
        for what in ["moving mass", "load at rest, slider A", "position of", "thrust of"] {
            assert!(exceeded.contains(what), "{plant}: `{what}` is not in\n{exceeded}");
        }
        let mass = outcome.statics.iter().find(|row| row.quantity == "moving mass").unwrap();
        assert!((mass.difference().unwrap() - 1e-3).abs() < 1e-9);
    }
}

#[test]
fn ref_a_machine_without_a_controller_is_pushed() {
    let folder = edited(|text| {
        let (before, rest) = text.split_once("[controller]").unwrap();
        format!("{before}{}", &rest[rest.find("[amplifier]").unwrap()..])
    });
    let machine = Machine::read(folder.path()).unwrap();
    let outcome = checked(&machine);
    assert!(!outcome.is_closed_loop);
    assert_eq!(outcome.exceeded(), [""; 0]);
    let stroke = &outcome.strokes[1];
    // 0.14 m at 0.2 m/s by the force that it needs.
    assert!((stroke.peak_velocity - 0.2).abs() < 0.01, "{}", stroke.peak_velocity);
}

#[test]
fn exact_laws_that_bend_have_the_wider_bound() {
    let rubbing = with(&shipped("grinder"), "effect.coulomb_friction.force_n", 15.0);
    let outcome = Crosscheck::of(&rubbing, &["0.05@16".parse().unwrap()]).unwrap().run(|_| ()).unwrap();
    assert_eq!(outcome.exceeded(), [""; 0]);
    assert_eq!(outcome.strokes[0].differences[0].bound.limit, 1e-7);
}

// ---- the command ---------------------------------------------------------------------------------

fn run(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_slideway");
    Command::new(program).arg("crosscheck").args(arguments).env_remove("COLUMNS").output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn grinder() -> String {
    models().join("grinder").display().to_string()
}

#[test]
fn exact_the_command_shows_tables_bounds_and_the_page() {
    let folder = TempDir::new().unwrap();
    let place = |name: &str| folder.path().join(name).display().to_string();
    let (html, figures) = (place("page.html"), place("figures"));
    let output = run(&[&grinder(), "--cell", "0.02@4", "0.03@16", "--html", &html, "--figures", &figures]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let told = text(&output.stdout);
    for words in [
        "STROKE 0.02@4 m@m/min",
        "STROKE 0.03@16",
        "rapier − axis",
        "≤ 1.00 nm",
        "damping ratio 5",
        "load at rest, slider D",
        "half a step",
    ] {
        assert!(told.contains(words), "`{words}` is not in\n{told}");
    }
    // The last words before the names of the files.
    assert!(told.lines().any(|line| line.starts_with("WITHIN BOUNDS: axis, rapier")), "{told}");
    assert_eq!(told.contains(".ci/mujoco .mujoco"), !mujoco::IS_BUILT_IN, "{told}");
    assert_eq!(told.contains("MuJoCo − axis"), mujoco::IS_BUILT_IN, "{told}");
    // What only one engine knows is not called checked.
    let total = told.lines().find(|line| line.trim_start().starts_with("total mass")).unwrap();
    assert!(total.ends_with(if mujoco::IS_BUILT_IN { "ok" } else { "–" }), "{total}");
    let page = fs::read_to_string(html).unwrap();
    for words in [
        "Within bounds",
        "id=\"fig-crosscheck\"",
        "0.03@16 m@m/min",
        "frequency 1",
        "<span>crosscheck</span>",
    ] {
        assert!(page.contains(words), "`{words}` is not in the page");
    }
    assert!(fs::read_to_string(Path::new(&figures).join("crosscheck.svg")).unwrap().starts_with("<svg"));
}

#[test]
fn exact_a_bound_that_is_exceeded_is_named_and_ends_with_1() {
    // So much drag that the scene, which meets the base's part of it step by step, is not exact any more.
    let drag = ["--set", "guide.viscous_n_s_per_m=5e4"];
    let output = run(&[&[grinder().as_str(), "--cell", "0.03@8"][..], &drag].concat());
    let told = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    let last = told.lines().last().unwrap();
    assert!(last.starts_with("EXCEEDED: position of rapier − axis on 0.03@8"), "{last}");
}

#[test]
fn exact_wrong_input_is_refused_and_nothing_is_written() {
    let folder = TempDir::new().unwrap();
    let html = folder.path().join("page.html").display().to_string();
    let gone = folder.path().join("gone").display().to_string();
    let cases: [(&[&str], &[&str]); 4] = [
        (&[&gone], &["gone", "machine.toml", "give a machine folder"]),
        (
            &[&grinder(), "--cell", "0.5@8"],
            &["machine.urdf", "table_slide", "0.5 m", "0.35", "shorten the stroke"],
        ),
        (&[&grinder(), "--cell", "0.02"], &["--cell", "`0.02`", "STROKE@FEED", "write for instance"]),
        (&[&grinder(), "--set", "guide.viscous=1"], &["machine.toml", "--set guide.viscous", "viscous"]),
    ];
    for (arguments, words) in cases {
        let output = run(&[arguments, &["--html", &html]].concat());
        let told = text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(output.stdout.is_empty() && fs::read_dir(folder.path()).unwrap().next().is_none());
        for word in words {
            assert!(told.contains(word), "`{word}` is not in: {told}");
        }
    }
}

#[test]
fn exact_cells_of_a_file_that_do_not_parse_are_refused() {
    for cells in ["[\"0.02\"]", "[\"0@4\"]", "[\"0.02@-4\"]", "[\"a@b\"]", "[]"] {
        let folder = edited(|text| format!("{text}\n[crosscheck]\ncells = {cells}\n"));
        let error = Machine::read(folder.path()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Syntax, "{cells}");
        assert_eq!(error.key_name(), Some("crosscheck.cells"));
        assert!(error.path().is_some() && error.remedy_text().is_some(), "{error}");
    }
    let folder = edited(|text| format!("{text}\n[crosscheck]\ncells = [\"0.02@4\"]\nramp = 1\n"));
    assert_eq!(Machine::read(folder.path()).unwrap_err().kind(), ErrorKind::UnknownKey);
}
