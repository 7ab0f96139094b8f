//! The published inputs of the servo drive: machine beside twin, the commands that made the recording, what is refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use slideway::machine::Machine;
use slideway::recording::{Existing, Format, Recording, Run, Signal};
use slideway::replay::compared::{Agreement, DrivenBy};
use slideway::replay::{Commands, Compared, PlantChoice, Published};
use slideway::twin::Sensing;
use slideway::units::Motion;
use tempfile::TempDir;

/// Time in which the machine is stuck under the random current, in s.
const STUCK_S: f64 = 2.0;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn inputs() -> PathBuf {
    root().join("assets/servo_inputs")
}

fn linear() -> Machine {
    Machine::read(&root().join("models/servo")).unwrap()
}

fn with_stiction() -> Machine {
    Machine::read(&root().join("models/servo/stiction.toml")).unwrap()
}

fn run(name: &str) -> Run {
    Recording::read(inputs()).unwrap().run(name).unwrap().clone()
}

fn of(compared: &Compared, signal: Signal) -> Agreement {
    *compared.of_signal(signal).unwrap()
}

/// Table 1: MAE at or below the published one and R² not below it, to its four digits, on each row.
#[test]
fn ref_table_1_is_reached_on_every_row() {
    let (recording, twin) = (Recording::read(inputs()).unwrap(), with_stiction());
    let mut rows = 0;
    for run in recording.runs() {
        let published = Published::of(run).unwrap();
        let Some(Published { signal, unit, mae: Some(mae), r2: Some(r2) }) = published.first().cloned()
        else {
            continue;
        };
        let compared = Compared::of(run, &twin, PlantChoice::Axis).unwrap();
        assert_eq!(
            (compared.driven_by, signal, unit.symbol()),
            (DrivenBy::Reference, Signal::Position, "deg")
        );
        let own = of(&compared, signal);
        assert!(
            unit.from_si(own.mae) <= mae,
            "{}: {} deg, published {mae}",
            run.name(),
            unit.from_si(own.mae)
        );
        assert!((own.r2.unwrap() * 1e4).round() / 1e4 >= r2, "{}: {:?}, published {r2}", run.name(), own.r2);
        // Another plant and another friction law: there is something to compare.
        assert!(own.mae > 2e-5, "{}: {:?}", run.name(), own);
        rows += 1;
    }
    assert_eq!(rows, 7);
}

/// Fig. 4: "In the first few seconds, because of the static friction, the motor could not initiate its motion."
#[test]
fn ref_static_friction_holds_the_shaft_in_the_first_seconds() {
    let run = run("fig4");
    let stuck = (STUCK_S / run.sample_period_s()) as usize;
    let travel = |position: &[f64]| {
        let ends = position[..stuck].iter().fold([f64::MAX, f64::MIN], |[a, b], x| [a.min(*x), b.max(*x)]);
        ends[1] - ends[0]
    };
    let replayed = |machine: &Machine| Compared::of(&run, machine, PlantChoice::Axis).unwrap();
    let (linear, stiction) = (replayed(&linear()), replayed(&with_stiction()));
    assert_eq!(linear.driven_by, DrivenBy::Effort);
    assert!(travel(run.signal(Signal::Position).unwrap()) < 1e-3);
    assert!(travel(&stiction.twin.position) < 1e-3);
    assert!(travel(&linear.twin.position) > 1.0);
    // Later it turns, and the twin with stiction with it.
    let [before, after] = [&linear, &stiction].map(|compared| of(compared, Signal::Velocity));
    assert!(after.mae < 0.2 * before.mae, "{before:?} {after:?}");
    assert!(after.r2.unwrap() > 0.95 && before.r2.unwrap() < 0.5, "{before:?} {after:?}");
}

/// Fig. 5: "the DT of the actual servo motor system produces similar results with the actual system".
#[test]
fn ref_random_reference_is_followed_alike() {
    let compared = Compared::of(&run("fig5"), &with_stiction(), PlantChoice::Axis).unwrap();
    let position = of(&compared, Signal::Position);
    assert!(position.r2.unwrap() > 0.9999 && position.mae.to_degrees() < 0.3, "{position:?}");
}

fn slideway(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_slideway"))
        .args(arguments)
        .current_dir(root())
        .env_remove("SLIDEWAY_DATA")
        .output()
        .unwrap()
}

#[track_caller]
fn told(arguments: &[&str]) -> String {
    let output = slideway(arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[track_caller]
fn refused(arguments: &[&str], words: &[&str]) {
    let output = slideway(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    for word in words {
        assert!(told.contains(word), "`{word}` is not in: {told}");
    }
}

#[test]
fn ref_one_command_makes_figures_and_table() {
    let folder = TempDir::new().unwrap();
    let [figures, page] = ["figures", "page.html"].map(|name| folder.path().join(name));
    let text = told(&[
        "replay",
        "--recording",
        "assets/servo_inputs",
        "--beside",
        "models/servo",
        "--plant",
        "axis",
        "--figures",
        figures.to_str().unwrap(),
        "--html",
        page.to_str().unwrap(),
    ]);
    for word in ["fig4", "fig5", "4 sin t", "0.3002 deg", "MAE beside", "7 of 7 rows", "Beside it:"] {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
    let svg = fs::read_to_string(figures.join("fig4.svg")).unwrap();
    let curves = |class: &str| svg.matches(&format!("class=\"l {class}")).count();
    // Position, velocity and current of recording, twin and the machine beside it; no reference in open loop.
    assert_eq!([curves("measured"), curves("before"), curves("after"), curves("reference")], [3, 3, 3, 0]);
    assert!(svg.contains("beside: ") && figures.join("fig5.svg").is_file());
    let page = fs::read_to_string(page).unwrap();
    for word in ["Beside what is published", "0.3002", "machine file beside it"] {
        assert!(page.contains(word), "{word}");
    }
}

/// The twin under the commands of its own recording makes that recording again, in open and in closed loop.
#[test]
fn exact_commands_make_the_recording_again() {
    let machine = with_stiction();
    for name in ["fig4", "3 sin 10t"] {
        let commands = Commands::of(&run(name), &machine).unwrap();
        let traces = commands.simulate(&machine, PlantChoice::Axis, Sensing::Perfect, |_| ()).unwrap();
        let told = commands.signals(machine.description().sample_period_s);
        let own = slideway::replay::recording::logged("own", &machine, told, traces).unwrap();
        let again = Compared::of(&own, &machine, PlantChoice::Axis).unwrap();
        assert_eq!(again.driven_by, commands.driven_by);
        assert!(of(&again, Signal::Position).peak < 1e-6, "{name}: {:?}", again.agreement);
    }
}

/// A folder with a run of these signals, 0.2 s long.
fn commands(signals: &[(Signal, f64)], extra: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let keys: Vec<&str> = signals.iter().map(|(signal, _)| signal.key(Motion::Revolute)).collect();
    let mut csv = format!("time_s,{}\n", keys.join(","));
    for k in 0..100 {
        let t = f64::from(k) * 2e-3;
        let row: Vec<String> =
            signals.iter().map(|(_, size)| format!("{}", size * (20.0 * t).sin())).collect();
        csv += &format!("{t},{}\n", row.join(","));
    }
    fs::write(folder.path().join("told.csv"), csv).unwrap();
    let toml = format!("motion = \"revolute\"\n\n[[run]]\nfile = \"told.csv\"\n{extra}");
    fs::write(folder.path().join("recording.toml"), toml).unwrap();
    folder
}

#[test]
fn exact_commands_need_nothing_measured() {
    let folder = commands(&[(Signal::PositionReference, 0.1)], "feed = 3\n");
    let place = folder.path().to_str().unwrap();
    let out = folder.path().join("out");
    let base = ["replay", "--commands", place, "--machine", "models/servo/stiction.toml"];
    let rest = ["--bristles", "2e-4", "--log", "position_rad,current_a", "--out"];
    let text = told(&[&base[..], &rest, &[out.to_str().unwrap()]].concat());
    assert!(text.contains("reference") && text.contains("bristles"), "{text}");
    let made = Recording::read(&out).unwrap();
    let run = &made.runs()[0];
    let logged: Vec<Signal> = run.signals().keys().copied().collect();
    assert_eq!(logged, [Signal::PositionReference, Signal::Current, Signal::Position]);
    assert_eq!(run.metadata["feed"].as_integer(), Some(3));
    // As a recording to compare with, it tells nothing.
    refused(&["replay", "--recording", place, "--machine", "models/servo"], &["without any measured signal"]);
}

/// Bristles hold the shaft with a small deflection where the twin's law holds it without: 20 mA of 30.
#[test]
fn exact_bristles_deflect_before_they_slide() {
    let folder = commands(&[(Signal::ControlEffort, 0.02)], "");
    let place = folder.path().to_str().unwrap();
    let travel = |more: &[&str]| {
        let out = folder.path().join("out");
        let base = ["replay", "--commands", place, "--machine", "models/servo/stiction.toml", "--perfect"];
        told(&[&base[..], more, &["--replace", "--out", out.to_str().unwrap()]].concat());
        let made = Recording::read(&out).unwrap();
        made.runs()[0].signal(Signal::Position).unwrap().iter().fold(0.0, |far: f64, x| far.max(x.abs()))
    };
    assert!(travel(&["--plant", "axis"]) < 1e-12);
    // 10 mN·m of 15 on bristles that slide after 0.2 mrad.
    let deflected = travel(&["--plant", "axis", "--bristles", "2e-4"]);
    assert!((1.2e-4..4e-4).contains(&deflected), "{deflected}");
}

#[test]
fn exact_what_cannot_be_is_refused_by_name() {
    let inputs = "assets/servo_inputs";
    refused(
        &["replay", "--beside", "models/servo", "--machine", "models/servo", "--cell", "1@1"],
        &["--recording"],
    );
    refused(&["replay", "--recording", inputs, "--beside", "/nowhere"], &["/nowhere"]);
    refused(&["replay", "--recording", inputs, "--beside", "models/grinder"], &["revolute", "prismatic"]);
    refused(&["replay", "--recording", inputs, "--bristles", "1e-4"], &["--bristles"]);
    refused(&["replay", "--commands", inputs, "--cell", "1@1"], &["--cell", "--commands"]);
    refused(&["replay", "--commands", inputs], &["--out"]);
    let out = TempDir::new().unwrap();
    let out = out.path().to_str().unwrap();
    refused(&["replay", "--commands", inputs, "--out", out, "--bristles", "-1"], &["--bristles", "1e-12"]);
    let log = ["--plant", "axis", "--run", "fig4", "--log", "position_m"];
    refused(
        &[&["replay", "--commands", inputs, "--out", out], &log[..]].concat(),
        &["--log", "position_m", "position_rad"],
    );
    // Neither a reference nor an effort.
    let folder = commands(&[(Signal::Position, 1.0)], "");
    let place = folder.path().to_str().unwrap();
    refused(
        &["replay", "--commands", place, "--machine", "models/servo", "--out", out],
        &["told.position_reference_rad", "control_effort_v"],
    );
    let folder = commands(&[(Signal::PositionReference, 1.0)], "feedforward = { mass_kg = 1.0 }\n");
    let place = folder.path().to_str().unwrap();
    refused(
        &["replay", "--commands", place, "--machine", "models/servo", "--out", out],
        &["told.feedforward"],
    );
}

#[test]
fn exact_published_figures_that_are_none_are_refused_by_name() {
    let refusal = |published: &str| {
        let signals =
            BTreeMap::from([(Signal::Position, vec![0.0; 100]), (Signal::ControlEffort, vec![0.0; 100])]);
        let mut run = Run::new("one", Motion::Revolute, 2e-3, signals).unwrap();
        run.metadata = format!("published = {published}").parse().unwrap();
        Compared::of(&run, &linear(), PlantChoice::Axis).unwrap_err().to_string()
    };
    for (published, words) in [
        ("3", ["one.published", "position_rad"]),
        ("{ position_m = { mae = 1 } }", ["one.published.position_m", "position_rad"]),
        ("{ position_rad = { mae = 1, unit = \"mm\" } }", ["one.published.position_rad.unit", "mm"]),
        ("{ position_rad = { mse = 1 } }", ["mse", "unit, mae, r2"]),
        ("{ position_rad = { mae = \"small\" } }", ["one.published.position_rad.mae", "a finite number"]),
    ] {
        let told = refusal(published);
        assert!(words.iter().all(|word| told.contains(word)), "{published}: {told}");
    }
}

/// What was written stays the same when it is read: the recording of a run with published figures.
#[test]
fn exact_published_figures_survive_writing() {
    let folder = TempDir::new().unwrap();
    let run = run("4 sin t");
    let out = folder.path().join("out");
    Recording::new(vec![run.clone()]).unwrap().write(&out, Format::Csv, Existing::Refuse).unwrap();
    let read = Recording::read(&out).unwrap();
    assert_eq!(Published::of(&read.runs()[0]).unwrap(), Published::of(&run).unwrap());
}
