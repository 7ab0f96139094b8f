//! A recording beside the machine's twin: the published figures, errors that are known, what is refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::slideway;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::recording::{Existing, Format, Recording, Run, Signal};
use slideway::replay::compared::DrivenBy;
use slideway::replay::recording::recorded;
use slideway::replay::{Cell, Compared, Feedforward, Motion, PlantChoice, Recorded, simulate};
use slideway::twin::Sensing;
use tempfile::TempDir;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn grinder() -> Machine {
    Machine::read(&root().join("models/grinder")).unwrap()
}

fn published() -> PathBuf {
    root().join("assets/published_strokes")
}

/// The three published runs beside the twin on the rigid-body scene, by name.
fn figures() -> BTreeMap<String, Compared> {
    let (recording, machine) = (Recording::read(published()).unwrap(), grinder());
    let of = |run: &Run| (run.name().to_owned(), Compared::of(run, &machine, PlantChoice::Rapier).unwrap());
    recording.runs().iter().map(of).collect()
}

/// "The position and velocity responses of the actual machine and the simulation were very close, with only slight
/// differences appearing in the thrust response" (Fig. 6); "again very close" (Fig. 7); Fig. 8 has no overshoot.
#[test]
fn ref_figures_6_to_8_agree_as_the_paper_states() {
    let all = figures();
    for (name, compared) in &all {
        assert_eq!(compared.driven_by, DrivenBy::Reference);
        let r2 = |signal| compared.of_signal(signal).unwrap().r2.unwrap();
        assert!(r2(Signal::Position) > 0.9999 && r2(Signal::Velocity) > 0.999, "{name}");
        // The hidden friction of 6 N: in the thrust, and there only slight.
        let thrust = compared.of_signal(Signal::Thrust).unwrap();
        assert!((0.95..0.999).contains(&r2(Signal::Thrust)), "{name}: {thrust:?}");
        assert!(thrust.mae > 3.0 && thrust.mae < 6.0, "{name}: {thrust:?}");
    }
    for (name, has_overshoot) in [("fig6", true), ("fig8", false)] {
        for f in all[name].figures.unwrap() {
            assert_eq!(f.peak_velocity > 0.0, has_overshoot, "{name}: velocity overshoot");
            assert_eq!(f.overshoot > 0.01, has_overshoot, "{name}: position overshoot");
            assert_eq!(
                f.most_negative_velocity < -0.01,
                has_overshoot,
                "{name}: negative velocity at the end"
            );
        }
    }
    for f in all["fig7"].figures.unwrap() {
        assert!(f.overshoot > 0.01 && f.most_negative_velocity < -0.01);
    }
}

#[test]
fn frozen_errors_of_figure_6() {
    let all = figures();
    let compared = &all["fig6"];
    let near = |signal, mae: f64| {
        let found = compared.of_signal(signal).unwrap().mae;
        assert!((found / mae - 1.0).abs() < 0.01, "{signal}: {found}");
    };
    near(Signal::Position, 45.6e-6);
    near(Signal::Velocity, 476e-6);
    near(Signal::Thrust, 5.58);
}

/// A run that the twin itself made, there and back.
fn own(plant: PlantChoice, sensing: Sensing) -> Run {
    let machine = grinder();
    let cell: Cell = "0.02@8".parse().unwrap();
    let stroke = cell.stroke(machine.motion()).unwrap();
    let motion = Motion { strokes: vec![stroke], lead_s: 0.1, dwell_s: 0.3, ramp_s: 0.02 };
    let reference = motion.reference(machine.description().sample_period_s);
    let traces = simulate(&machine, plant, sensing, &reference, |_| ()).unwrap();
    let mut run = recorded("own", &machine, &reference, traces).unwrap();
    run.metadata = cell.metadata(machine.motion());
    run
}

#[test]
fn exact_the_twin_follows_its_own_recording() {
    for plant in [PlantChoice::Axis, PlantChoice::Rapier] {
        let compared = Compared::of(&own(plant, Sensing::Perfect), &grinder(), plant).unwrap();
        let peak = |signal| compared.of_signal(signal).unwrap().peak;
        assert!(peak(Signal::Position) < 1e-10 && peak(Signal::Thrust) < 1e-6, "{:?}", compared.agreement);
        let [recorded, twin] = compared.figures.unwrap();
        assert!((recorded.overshoot - twin.overshoot).abs() < 1e-9);
    }
}

/// With noise, what is left is the encoder's: 30 nm and rounding to 100 nm, √(30² + 100²/12) = 42 nm.
#[test]
fn exact_only_the_sensors_noise_is_left() {
    let run = own(PlantChoice::Axis, Sensing::AsStated { seed: 3 });
    let compared = Compared::of(&run, &grinder(), PlantChoice::Axis).unwrap();
    let rms = compared.of_signal(Signal::Position).unwrap().rms;
    assert!((rms / 41.6e-9 - 1.0).abs() < 0.1, "{rms}");
}

#[test]
fn exact_settings_of_a_run_are_in_force() {
    let mut run = own(PlantChoice::Axis, Sensing::Perfect);
    run.settings.insert("controller.integral".to_owned(), 22.into());
    let compared = Compared::of(&run, &grinder(), PlantChoice::Axis).unwrap();
    assert!(compared.of_signal(Signal::Position).unwrap().peak > 1e-4);
    run.settings.insert("controller.nonsense".to_owned(), 22.into());
    let error = Compared::of(&run, &grinder(), PlantChoice::Axis).unwrap_err();
    assert!(error.key_name().is_some_and(|key| key.starts_with("own.set")), "{error}");
}

fn without(run: &Run, gone: &[Signal]) -> Run {
    let kept = run.signals().iter().filter(|(signal, _)| !gone.contains(signal));
    let kept = kept.map(|(signal, samples)| (*signal, samples.clone())).collect();
    Run::new(run.name(), run.motion(), run.sample_period_s(), kept).unwrap()
}

#[test]
fn exact_a_run_without_reference_is_driven_by_its_effort() {
    let references = [Signal::PositionReference, Signal::VelocityReference];
    let run = without(&own(PlantChoice::Axis, Sensing::Perfect), &references);
    let compared = Compared::of(&run, &grinder(), PlantChoice::Axis).unwrap();
    assert_eq!(compared.driven_by, DrivenBy::Effort);
    assert!(compared.of_signal(Signal::Position).unwrap().peak < 1e-9, "{:?}", compared.agreement);
    assert!(compared.figures.is_none());

    let blind = without(&run, &[Signal::ControlEffort]);
    let error = Compared::of(&blind, &grinder(), PlantChoice::Axis).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert!(error.to_string().contains("own.position_reference_m"), "{error}");
}

#[track_caller]
fn refused(arguments: &[&str], words: &[&str]) {
    let output = slideway(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(output.stdout.is_empty());
    for word in words {
        assert!(told.contains(word), "`{word}` is not in: {told}");
    }
}

#[test]
fn exact_one_command_draws_the_three_figures() {
    let folder = TempDir::new().unwrap();
    let [figures, page] = ["figures", "page.html"].map(|name| folder.path().join(name));
    let published = published();
    let [recording, figures_text, page_text] = [&published, &figures, &page].map(|p| p.to_str().unwrap());
    let output =
        slideway(&["replay", "--recording", recording, "--figures", figures_text, "--html", page_text]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let told = String::from_utf8(output.stdout).unwrap();
    for word in ["fig6", "fig7", "fig8", "controller.integral = 22", "overshoot", "R²", "thrust"] {
        assert!(told.contains(word), "`{word}` is not in: {told}");
    }
    for name in ["fig6", "fig7", "fig8"] {
        let svg = fs::read_to_string(figures.join(format!("{name}.svg"))).unwrap();
        for word in ["<svg", "Position", "Velocity", "Thrust", "reference", "recording", "twin", "time in s"]
        {
            assert!(svg.contains(word), "{name}: {word}");
        }
        // Position and velocity with their references, thrust without.
        let curves = |class: &str| svg.matches(&format!("class=\"l {class}")).count();
        assert_eq!([curves("reference"), curves("measured"), curves("before")], [2, 3, 3], "{name}");
    }
    assert!(fs::read_to_string(&page).unwrap().contains("recording beside twin"));
}

#[test]
fn exact_the_twins_runs_can_be_written() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("twin");
    let published = published();
    let [recording, out_text] = [&published, &out].map(|p| p.to_str().unwrap());
    let arguments =
        ["replay", "--recording", recording, "--plant", "axis", "--run", "fig8", "--out", out_text];
    assert_eq!(slideway(&arguments).status.code(), Some(0));
    let written = Recording::read(&out).unwrap();
    assert_eq!(written.runs().len(), 1);
    // What was written is what the twin makes of it again: from its own start, without noise.
    let again = Compared::of(&written.runs()[0], &grinder(), PlantChoice::Axis).unwrap();
    assert!(again.of_signal(Signal::Position).unwrap().peak < 1e-7, "{:?}", again.agreement);
}

#[test]
fn exact_strokes_and_recordings_are_not_mixed() {
    let published = published();
    let recording = published.to_str().unwrap();
    refused(&["replay", "--recording", recording, "--cell", "0.02@8"], &["--cell", "--recording"]);
    refused(&["replay", "--recording", recording, "--hide", "effect.payload.mass_kg=1"], &["--hide"]);
    refused(
        &["replay", "--run", "fig6", "--machine", "models/grinder", "--cell", "0.02@8"],
        &["--recording"],
    );
    refused(&["replay", "--machine", "models/grinder", "--cell", "0.02@8"], &["--out"]);
    refused(&["replay", "--recording", recording, "--run", "fig9"], &["fig9", "fig6, fig7, fig8"]);
    refused(&["replay", "--recording", "/nowhere"], &["/nowhere"]);
}

#[test]
fn exact_a_run_that_cannot_be_replayed_is_named() {
    let folder = TempDir::new().unwrap();
    let run = own(PlantChoice::Axis, Sensing::Perfect);
    let gone = [Signal::PositionReference, Signal::VelocityReference, Signal::ControlEffort];
    let mut recording = Recording::new(vec![without(&run, &gone)]).unwrap();
    recording.machine = Some(root().join("models/grinder"));
    let place = folder.path().join("log");
    recording.write(&place, Format::Csv, Existing::Refuse).unwrap();
    refused(
        &["replay", "--recording", place.to_str().unwrap()],
        &["own.csv", "own.position_reference_m", "control_effort_v"],
    );
}

/// A run that states what was fed forward is replayed with it; its effort is the feedback's share.
#[test]
fn exact_stated_feedforward_is_replayed() {
    let machine = grinder();
    let recording = Recording::read(published()).unwrap();
    let run = &recording.runs()[0];
    let reference = run.signal(Signal::PositionReference).unwrap();
    let forward = Feedforward { mass_kg: 51.0, viscous_n_s_per_m: 300.0, ..Feedforward::default() };
    let along = Recorded::along(run, reference, &machine).unwrap();
    let real = forward.replay(&along, &machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let mut told = recorded("forward", &machine, reference, real.traces).unwrap();
    let plain = Compared::of(&told, &machine, PlantChoice::Axis).unwrap();
    assert!(plain.of_signal(Signal::Position).unwrap().rms > 1e-4, "{:?}", plain.agreement);
    told.metadata.insert("feedforward".to_owned(), toml::Value::try_from(forward).unwrap());
    let with = Compared::of(&told, &machine, PlantChoice::Axis).unwrap();
    assert!(with.of_signal(Signal::Position).unwrap().rms < 1e-8, "{:?}", with.agreement);
    assert!(with.of_signal(Signal::ControlEffort).unwrap().rms < 1e-4, "{:?}", with.agreement);
}
