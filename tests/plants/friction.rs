//! Friction and acceleration time from recordings: found again, with intervals that hold, and refused where they cannot be.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::{Run, Signal};
use slideway::replay::friction::{Friction, held, identify};
use slideway::replay::recording::recorded;
use slideway::replay::{Cell, Motion, PlantChoice, Stroke, simulate};
use slideway::twin::Sensing;

/// What was asked of the estimator on the rigid-body scene: within 2 %.
const RECOVERY: f64 = 0.02;
/// Seeds of the coverage test.
const SEEDS: u64 = 48;
/// Of 48 intervals that hold with 95 % each, fewer than 41 hold in 0.4 % of all cases (binomial).
const LEAST_HELD: usize = 41;

fn grinder() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

/// What the machine of a recording has that its twin does not know.
#[derive(Clone, Copy)]
struct Truth {
    friction_n: f64,
    ramp_s: f64,
}

/// A run of a cell there and back, or one way.
fn run(plant: PlantChoice, truth: Truth, cell: &str, is_both_ways: bool, seed: u64) -> Run {
    let machine = grinder();
    let real = [("effect.coulomb_friction.force_n", truth.friction_n.into())];
    let real = machine.with_settings(real).unwrap();
    let cell: Cell = cell.parse().unwrap();
    let stroke = cell.stroke(machine.motion()).unwrap();
    let back = is_both_ways.then_some(Stroke { stroke: -stroke.stroke, ..stroke });
    let strokes = [stroke].into_iter().chain(back).collect();
    let motion = Motion { strokes, lead_s: 0.1, dwell_s: 0.4, ramp_s: truth.ramp_s };
    let reference = motion.reference(machine.description().sample_period_s);
    let traces = simulate(&real, plant, Sensing::AsStated { seed }, &reference, |_| ()).unwrap();
    let name = format!("{}_{seed}", cell.name(machine.motion()));
    let mut run = recorded(&name, &machine, &reference, traces).unwrap();
    run.metadata = cell.metadata(machine.motion());
    run
}

/// The run with some signals only.
fn keeping(run: &Run, keep: impl Fn(Signal) -> bool) -> Run {
    let signals: BTreeMap<Signal, Vec<f64>> =
        run.signals().iter().filter(|(s, _)| keep(**s)).map(|(s, x)| (*s, x.clone())).collect();
    let mut kept = Run::new(run.name(), run.motion(), run.sample_period_s(), signals).unwrap();
    kept.metadata.clone_from(&run.metadata);
    kept
}

fn is_no_reference(signal: Signal) -> bool {
    !matches!(signal, Signal::PositionReference | Signal::VelocityReference)
}

fn found(runs: &[Run], with_viscous: bool) -> Friction {
    identify(&runs.iter().collect::<Vec<_>>(), &grinder(), with_viscous).unwrap()
}

#[track_caller]
fn assert_recovered(found: &Friction, truth: Truth) {
    let ramp = found.acceleration_time_s.unwrap();
    assert!((found.coulomb.value / truth.friction_n - 1.0).abs() < RECOVERY, "{:?}", found.coulomb);
    assert!((ramp.value / truth.ramp_s - 1.0).abs() < RECOVERY, "{ramp:?}");
    assert!(found.coulomb.covers(truth.friction_n), "{:?}", found.coulomb);
    assert!(ramp.covers(truth.ramp_s), "{ramp:?}");
}

#[test]
fn exact_friction_and_ramp_of_the_rigid_body_scene_are_found_again() {
    let truth = Truth { friction_n: 12.0, ramp_s: 0.025 };
    let runs = ["0.02@8", "0.03@16"].map(|cell| run(PlantChoice::Rapier, truth, cell, true, 3));
    let logged = found(&runs, false);
    assert_recovered(&logged, truth);
    for run in &logged.runs {
        assert!((run.reference_acceleration_time_s.unwrap() - truth.ramp_s).abs() < 1e-9);
        assert_eq!(run.starts_s.len(), 2);
    }
    let unlogged = found(&runs.map(|run| keeping(&run, is_no_reference)), false);
    assert_recovered(&unlogged, truth);
    assert!(unlogged.runs.iter().all(|run| run.reference_acceleration_time_s.is_none()));
    // Start and base cost information.
    let width = |f: &Friction| f.acceleration_time_s.unwrap().standard_error;
    assert!(width(&unlogged) > width(&logged));
}

#[test]
fn exact_the_coefficient_is_friction_over_weight() {
    let truth = Truth { friction_n: 12.0, ramp_s: 0.02 };
    let found = found(&[run(PlantChoice::Axis, truth, "0.02@8", false, 1)], false);
    let weight = grinder().constants().moving_mass * 9.806_65;
    assert!((found.normal_force_n.unwrap() / weight - 1.0).abs() < 1e-6);
    let coefficient = found.coefficient.unwrap();
    assert!((coefficient.value * weight / found.coulomb.value - 1.0).abs() < 1e-6);
    assert!(coefficient.covers(12.0 / weight));
}

#[test]
fn exact_no_friction_lies_in_its_interval() {
    let truth = Truth { friction_n: 0.0, ramp_s: 0.025 };
    for plant in [PlantChoice::Rapier, PlantChoice::Axis] {
        let runs = ["0.02@8", "0.03@16"].map(|cell| run(plant, truth, cell, true, 4));
        let found = found(&runs, false);
        assert!(found.coulomb.covers(0.0), "{:?}", found.coulomb);
        assert!(found.coulomb.value >= 0.0 && found.coulomb.ci95[1] < 0.1, "{:?}", found.coulomb);
        assert!(found.acceleration_time_s.unwrap().covers(truth.ramp_s));
    }
}

#[test]
fn exact_viscous_drag_is_told_from_friction_by_two_feeds() {
    let truth = Truth { friction_n: 8.0, ramp_s: 0.02 };
    let runs = ["0.02@4", "0.03@16"].map(|cell| run(PlantChoice::Axis, truth, cell, true, 5));
    let found = found(&runs, true);
    assert_recovered(&found, truth);
    let viscous = found.viscous.unwrap();
    assert!(viscous.covers(333.3) && (viscous.value / 333.3 - 1.0).abs() < RECOVERY, "{viscous:?}");
}

/// Reference not logged, one stroke, the current instead of the thrust: its sensor has noise.
#[test]
fn exact_intervals_hold_as_often_as_they_say() {
    let truth = Truth { friction_n: 12.0, ramp_s: 0.025 };
    let measured = |signal: Signal| is_no_reference(signal) && signal != Signal::Thrust;
    let estimates: Vec<Friction> = (1..=SEEDS)
        .into_par_iter()
        .map(|seed| {
            let run = run(PlantChoice::Axis, truth, "0.02@8", false, 1000 + seed);
            found(&[keeping(&run, measured)], false)
        })
        .collect();
    let friction: Vec<_> = estimates.iter().map(|f| f.coulomb).collect();
    let ramp: Vec<_> = estimates.iter().map(|f| f.acceleration_time_s.unwrap()).collect();
    for (word, list, truth) in [("friction", friction, truth.friction_n), ("ramp", ramp, truth.ramp_s)] {
        let held = list.iter().filter(|estimate| estimate.covers(truth)).count();
        let count = list.len() as f64;
        let scatter = (list.iter().map(|e| (e.value - truth).powi(2)).sum::<f64>() / count).sqrt();
        let stated = list.iter().map(|e| e.standard_error).sum::<f64>() / count;
        assert!(held >= LEAST_HELD, "{word}: {held} of {SEEDS} intervals hold");
        // Wide intervals would hold always: they are not wider than the scatter asks for by more than a half.
        assert!(stated < 1.5 * scatter, "{word}: scatter {scatter}, stated {stated}");
    }
}

/// A sine has no acceleration time; friction shows all the same along the logged reference.
#[test]
fn exact_friction_along_any_logged_reference() {
    let machine = grinder();
    let real = machine.with_settings([("effect.coulomb_friction.force_n", 9.0.into())]).unwrap();
    let sine =
        |k: u32| if k < 400 { 0.0 } else { 0.005 * (1.0 - (12.0 * 250e-6 * f64::from(k - 400)).cos()) };
    let reference: Vec<f64> = (0..6000).map(sine).collect();
    let sensing = Sensing::AsStated { seed: 5 };
    let traces = simulate(&real, PlantChoice::Axis, sensing, &reference, |_| ()).unwrap();
    let found = found(&[recorded("sine", &machine, &reference, traces).unwrap()], false);
    assert!(
        found.coulomb.covers(9.0) && (found.coulomb.value / 9.0 - 1.0).abs() < RECOVERY,
        "{:?}",
        found.coulomb
    );
    assert!(found.acceleration_time_s.is_none() && found.runs[0].starts_s.is_empty());
}

fn refusal(run: &Run, machine: &Machine) -> Error {
    let error = identify(&[run], machine, false).unwrap_err();
    assert!(error.remedy_text().is_some(), "{error}");
    error
}

#[test]
fn exact_recordings_that_tell_nothing_are_refused() {
    let machine = grinder();
    let truth = Truth { friction_n: 6.0, ramp_s: 0.02 };
    let good = run(PlantChoice::Axis, truth, "0.02@8", false, 1);

    let standing = simulate(&machine, PlantChoice::Axis, Sensing::AsStated { seed: 1 }, &[0.0; 2000], |_| ());
    let mut standing = recorded("standing", &machine, &[0.0; 2000], standing.unwrap()).unwrap();
    assert_eq!(refusal(&standing, &machine).kind(), ErrorKind::Undetermined);
    standing.metadata.clone_from(&good.metadata);
    let told = refusal(&standing, &machine).to_string();
    assert!(told.contains("standstill") && told.contains("standing"), "{told}");

    // The middle of the stroke alone: one speed.
    let part = |run: &Run, range: std::ops::Range<usize>| {
        let signals = run.signals().iter().map(|(s, x)| (*s, x[range.clone()].to_vec())).collect();
        let mut cut = Run::new("cut", run.motion(), run.sample_period_s(), signals).unwrap();
        cut.metadata.clone_from(&run.metadata);
        cut
    };
    let cruise = refusal(&part(&good, 520..1000), &machine);
    assert_eq!(cruise.kind(), ErrorKind::Undetermined);
    assert!(cruise.to_string().contains("not separable at one speed"), "{cruise}");
    let mut unstated = part(&good, 520..960);
    unstated.metadata.clear();
    assert!(refusal(&unstated, &machine).to_string().contains("one speed"));

    let mut unknown = keeping(&good, is_no_reference);
    unknown.metadata.clear();
    let told = refusal(&unknown, &machine).to_string();
    assert!(told.contains("stroke_m") && told.contains("position_reference_m"), "{told}");

    let mut half = good.clone();
    half.metadata.remove("feed_m_per_min");
    assert_eq!(refusal(&half, &machine).kind(), ErrorKind::Missing);

    let mut other = good.clone();
    other.metadata.insert("stroke_m".to_owned(), 0.03.into());
    assert_eq!(refusal(&other, &machine).kind(), ErrorKind::Inconsistent);

    let position_only = keeping(&good, |signal| signal == Signal::Position);
    assert!(refusal(&position_only, &machine).to_string().contains("control_effort_v"));
}

#[test]
fn exact_a_machine_without_controller_is_refused() {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let folder = tempfile::TempDir::new().unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    std::fs::copy(from.join("machine.urdf"), folder.path().join("machine.urdf")).unwrap();
    for mesh in std::fs::read_dir(from.join("meshes")).unwrap() {
        let mesh = mesh.unwrap();
        std::fs::copy(mesh.path(), folder.path().join("meshes").join(mesh.file_name())).unwrap();
    }
    let text = std::fs::read_to_string(from.join("machine.toml")).unwrap();
    let (before, rest) = text.split_once("[controller]").unwrap();
    let (_, after) = rest.split_once("[motor]").unwrap();
    std::fs::write(folder.path().join("machine.toml"), format!("{before}[motor]{after}")).unwrap();
    let machine = Machine::read(folder.path()).unwrap();
    let truth = Truth { friction_n: 6.0, ramp_s: 0.02 };
    let error = refusal(&run(PlantChoice::Axis, truth, "0.02@8", false, 1), &machine);
    assert_eq!(error.kind(), ErrorKind::Missing);
    assert!(error.to_string().contains("controller"), "{error}");
}

/// The table of held constants against a fit with a machine that is heavier by its tolerance.
#[test]
fn exact_held_constants_move_friction_as_a_fit_with_them_does() {
    let truth = Truth { friction_n: 12.0, ramp_s: 0.02 };
    let runs = [run(PlantChoice::Axis, truth, "0.02@8", true, 6)];
    let (machine, runs) = (grinder(), runs.iter().collect::<Vec<_>>());
    let stated = identify(&runs, &machine, false).unwrap();
    let held = held(&runs, &machine, &stated).unwrap();
    assert_eq!(held.len(), 4, "{held:?}");
    let mass = held.iter().find(|held| held.constant == "moving mass").unwrap();
    let heavier = mass.tolerance * machine.constants().moving_mass;
    let heavier = machine.with_settings([("effect.payload.mass_kg", heavier.into())]).unwrap();
    let moved = identify(&runs, &heavier, false).unwrap();
    assert!((mass.coulomb - (moved.coulomb.value - stated.coulomb.value)).abs() < 1e-9, "{mass:?}");
    // Far more than the interval, which is of noise.
    assert!(mass.coulomb.abs() > 10.0 * stated.coulomb.standard_error, "{mass:?}");
}

/// Drag that the twin does not have: without it the twin does not fit, with it both numbers are found.
#[test]
fn exact_drag_that_is_not_stated_shows_as_a_misfit() {
    let truth = Truth { friction_n: 8.0, ramp_s: 0.02 };
    let runs = ["0.02@4", "0.03@16"].map(|cell| run(PlantChoice::Axis, truth, cell, true, 5));
    let all: Vec<&Run> = runs.iter().collect();
    let machine = grinder().with_settings([("guide.viscous_n_s_per_m", 0.0.into())]).unwrap();
    let without = identify(&all, &machine, false).unwrap();
    assert!(without.is_misfit() && !without.coulomb.covers(8.0), "{without:?}");
    let with = identify(&all, &machine, true).unwrap();
    assert!(!with.is_misfit() && with.coulomb.covers(8.0), "{with:?}");
    assert!(with.other_ramps(250e-6).is_empty());
}

#[test]
fn exact_a_logged_ramp_that_the_signals_do_not_show_is_told() {
    let truth = Truth { friction_n: 12.0, ramp_s: 0.025 };
    let made = run(PlantChoice::Axis, truth, "0.02@8", false, 7);
    let other = run(PlantChoice::Axis, Truth { ramp_s: 0.03, ..truth }, "0.02@8", false, 7);
    let logged = other.signal(Signal::PositionReference).unwrap();
    let mut signals = keeping(&made, is_no_reference).signals().clone();
    signals.insert(Signal::PositionReference, logged[..made.len()].to_vec());
    let mut mixed = Run::new(made.name(), made.motion(), made.sample_period_s(), signals).unwrap();
    mixed.metadata.clone_from(&made.metadata);
    let found = found(&[mixed], false);
    let told: Vec<&str> = found.other_ramps(250e-6).iter().map(|run| run.name.as_str()).collect();
    assert_eq!(told, [made.name()], "{found:?}");
}

/// The command on a machine that states no drag estimates it, and says so.
#[test]
fn exact_the_command_estimates_drag_where_none_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let machine = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder").display().to_string();
    let mut head = format!("machine = {machine:?}\nsample_period_s = 250e-6\n");
    let truth = Truth { friction_n: 8.0, ramp_s: 0.02 };
    for (name, cell, [stroke, feed]) in [("slow", "0.02@4", [0.02, 4.0]), ("fast", "0.03@16", [0.03, 16.0])] {
        let run = run(PlantChoice::Axis, truth, cell, true, 5);
        let logged = [Signal::PositionReference, Signal::Position, Signal::Thrust];
        let columns = logged.map(|signal| run.signal(signal).unwrap());
        let mut log = "time_s,position_reference_m,position_m,thrust_n\n".to_owned();
        for (k, ((r, x), f)) in columns[0].iter().zip(columns[1]).zip(columns[2]).enumerate() {
            log += &format!("{},{r:e},{x:e},{f:e}\n", k as f64 * 250e-6);
        }
        std::fs::write(folder.path().join(format!("{name}.csv")), log).unwrap();
        head +=
            &format!("[[run]]\nfile = \"{name}.csv\"\nstroke_m = {stroke:?}\nfeed_m_per_min = {feed:?}\n");
    }
    std::fs::write(folder.path().join("recording.toml"), head).unwrap();
    let shown = |more: &[&str]| {
        let place = folder.path().display().to_string();
        let arguments = [&["identify", "friction", &place][..], more].concat();
        let output =
            std::process::Command::new(env!("CARGO_BIN_EXE_slideway")).args(arguments).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), told.as_str()), (Some(0), ""));
        String::from_utf8(output.stdout).unwrap()
    };
    let without = shown(&["--set", "guide.viscous_n_s_per_m=0.0"]);
    assert!(
        without.contains("states no viscous drag") && without.contains("viscous coefficient"),
        "{without}"
    );
    assert!(!without.contains("DOES NOT FIT") && !without.contains("+0.000"), "{without}");
    let stated = shown(&[]);
    assert!(
        !stated.contains("states no viscous drag") && !stated.contains("viscous coefficient"),
        "{stated}"
    );
    // Half the drag that there is.
    let wrong = shown(&["--set", "guide.viscous_n_s_per_m=160.0"]);
    assert!(wrong.starts_with("THE TWIN DOES NOT FIT"), "{wrong}");
}
