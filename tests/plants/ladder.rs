//! The ladder of a feed-forward: closed forms, and what is refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::recording::{Existing, Format, Recording, Run, Signal};
use slideway::replay::ladder::MOVING;
use slideway::replay::recording::recorded;
use slideway::replay::{Feedforward, Ladder, Motion, Recorded, Stroke};
use slideway::report::{Style, ladder};
use slideway::twin::Sensing;
use std::collections::BTreeMap;
use std::fs;
use std::process::Command;
use tempfile::TempDir;

type Signals = BTreeMap<Signal, Vec<f64>>;

/// Inertia, drag, Coulomb friction and torque per volt.
const J: f64 = 2e-3;
const C: f64 = 0.01;
const F: f64 = 0.05;
const NM_PER_V: f64 = 0.5;

/// A disc on a direct drive, whose centre lies `lever` below its level axis.
fn disc(folder: &TempDir, lever: f64) -> Machine {
    let across = J - 0.4 * lever * lever;
    let urdf = format!(
        r#"<robot name="disc"><link name="bed"><inertial><mass value="5"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <link name="body"><inertial><origin xyz="0 0 {}"/><mass value="0.4"/><inertia ixx="{across}" iyy="{across}" izz="{across}" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <joint name="axis" type="continuous"><parent link="bed"/><child link="body"/><axis xyz="0 1 0"/></joint></robot>"#,
        -lever
    );
    let toml = format!(
        "name = \"disc\"\nurdf = \"machine.urdf\"\njoint = \"axis\"\nsample_period_s = 1e-3\n\
        [controller]\nlaw = \"cascade\"\nposition_gain_per_s = 50.0\nvelocity_gain_v_s_per_rad = 0.8\nvelocity_feedforward = 1.0\n\
        [motor]\nkind = \"direct\"\ntorque_nm_per_v = {NM_PER_V}\n[guide]\nviscous_nm_s_per_rad = {C}\n\
        [effect.coulomb_friction]\ntorque_nm = {F}\n\
        [encoder]\nresolution_rad = 0.0\nnoise_rad = 0.0\nvelocity = {{ kind = \"taps\", taps = [1.0, -1.0] }}\n"
    );
    fs::write(folder.path().join("machine.urdf"), urdf).unwrap();
    fs::write(folder.path().join("machine.toml"), toml).unwrap();
    Machine::read(folder.path()).unwrap()
}

/// There and back, made by the machine with a feed-forward of its own, as a drive logs it.
fn made(machine: &Machine, name: &str, stated: &str) -> Run {
    let there = Stroke { stroke: 4.0, feed: 8.0 };
    let strokes = vec![there, Stroke { stroke: -4.0, ..there }];
    let motion = Motion { strokes, lead_s: 0.2, dwell_s: 0.3, ramp_s: 0.2 };
    let reference = motion.reference(1e-3);
    let still = BTreeMap::from([
        (Signal::PositionReference, reference.clone()),
        (Signal::Position, vec![0.0; reference.len()]),
    ]);
    let still = Run::new(name, machine.motion(), 1e-3, still).unwrap();
    let metadata: toml::Table = stated.parse().unwrap();
    let mut planned = still.clone();
    planned.metadata = metadata.clone();
    let forward = Feedforward::of(&planned).unwrap();
    let axis = Axis::of(&machine.constants());
    let traces =
        forward.replay(&Recorded::of(&still, machine).unwrap(), machine, axis, Sensing::Perfect).traces;
    let mut run = recorded(name, machine, &reference, traces).unwrap();
    run.metadata = metadata;
    run
}

/// Root mean square of the whole torque that the reference takes at the moving samples, with some of the terms left out, V.
fn needed(run: &Run, terms: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let x = run.signal(Signal::PositionReference).unwrap();
    let speed = |k: usize| (x[k] - x[k - 1]) / 1e-3;
    let top = (1..x.len()).map(|k| speed(k).abs()).fold(0.0, f64::max);
    let moving: Vec<usize> = (1..x.len() - 1).filter(|k| speed(*k).abs() > MOVING * top).collect();
    let square = |k: &usize| {
        let acceleration = (speed(k + 1) - speed(*k)) / 1e-3;
        (terms(x[*k], speed(*k), acceleration) / NM_PER_V).powi(2)
    };
    (moving.iter().map(square).sum::<f64>() / moving.len() as f64).sqrt()
}

/// What a rung leaves is what the terms that are not fed forward take, but for the loop's own following error.
#[test]
fn exact_each_rung_leaves_what_it_lacks() {
    let folder = TempDir::new().unwrap();
    let machine = disc(&folder, 0.03);
    let plain = made(&machine, "plain", "");
    let found = Ladder::of(&[&plain], &machine).unwrap();
    let own = found.own;
    assert!((own.mass_kg / J - 1.0).abs() < 1e-12 && (own.viscous_n_s_per_m / C - 1.0).abs() < 1e-12);
    assert!((own.coulomb_n / F - 1.0).abs() < 1e-12 && own.weight);
    let hang = 0.4 * 9.80665 * 0.03;
    let left: [f64; 4] = [
        needed(&plain, |x, v, a| J * a + C * v + F * v.signum() + hang * x.sin()),
        needed(&plain, |x, v, _| C * v + F * v.signum() + hang * x.sin()),
        needed(&plain, |x, v, _| F * v.signum() + hang * x.sin()),
        needed(&plain, |x, _, _| hang * x.sin()),
    ];
    // The loop answers within 1/50 s, less at every rung: what it lags by is of the changes of what is left.
    for (rung, expected) in found.rungs.iter().zip(left) {
        assert!(
            (rung.predicted_v / expected - 1.0).abs() < 0.05,
            "{:?}: {} V, {expected}",
            rung.terms,
            rung.predicted_v
        );
    }
    // With every term exact, the loop has next to nothing left: starts of dry friction, half a sample of the velocity.
    let last = found.rungs.last().unwrap();
    assert!(last.terms == [true; 4] && last.predicted_v < 0.01 * found.rungs[0].predicted_v, "{last:?}");
    assert!(found.unexplained_v.unwrap() < 1e-9, "{:?}", found.unexplained_v);
}

/// Runs that state a feed-forward are measured beside their rung, or beside the ladder where they are none of it.
#[test]
fn exact_stated_stages_stand_beside_their_rungs() {
    let folder = TempDir::new().unwrap();
    let machine = disc(&folder, 0.0);
    let runs = [
        made(&machine, "none", ""),
        made(&machine, "inertia", "feedforward = { inertia_kg_m2 = 1.5e-3 }"),
        made(&machine, "again", "feedforward = { inertia_kg_m2 = 1.5e-3 }"),
        made(&machine, "coulomb", "feedforward = { coulomb_nm = 0.04 }"),
    ];
    let found = Ladder::of(&runs.iter().collect::<Vec<_>>(), &machine).unwrap();
    assert!(!found.has_weight);
    let [none, inertia, viscous, coulomb, other] = &found.rungs[..] else { panic!("{:?}", found.rungs) };
    assert_eq!(other.terms, [false, false, true, false]);
    assert!(viscous.measured.is_none() && coulomb.measured.is_none());
    for (rung, names) in [(none, vec!["none"]), (inertia, vec!["inertia", "again"]), (other, vec!["coulomb"])]
    {
        let measured = rung.measured.as_ref().unwrap();
        assert_eq!(measured.runs, names);
        // Made by the very twin that replays them.
        assert!((measured.effort_v / measured.as_stated_v - 1.0).abs() < 1e-9, "{measured:?}");
        assert!(rung.terms == none.terms || measured.effort_v < none.predicted_v);
    }
    let mut recording = Recording::new(runs.to_vec()).unwrap();
    recording.machine = Some(folder.path().to_owned());
    let text = ladder(&found, &machine, &recording, 4).text(Style { width: 100, ..Style::default() });
    for words in ["+ inertia", "+ viscous", "+ Coulomb", "mN·m"] {
        assert!(text.contains(words), "{text}");
    }
    let place = folder.path().join("log");
    recording.write(&place, Format::Csv, Existing::Refuse).unwrap();
    let slideway = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_slideway")).arg("ladder").args(arguments).output().unwrap()
    };
    let shown = slideway(&[place.to_str().unwrap()]);
    let out = String::from_utf8(shown.stdout).unwrap();
    assert!(shown.status.success() && out.contains("FEEDBACK, RMS") && out.contains("+ Coulomb"), "{out}");
    let refused = slideway(&[place.to_str().unwrap(), "--run", "nobody"]);
    let err = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(2) && err.contains("nobody"), "{err}");
}

#[test]
fn exact_what_makes_no_ladder_is_refused() {
    let folder = TempDir::new().unwrap();
    let machine = disc(&folder, 0.0);
    let run = made(&machine, "run", "");
    let refused = |run: &Run, machine: &Machine, kind: ErrorKind, key: &str| {
        let error = Ladder::of(&[run], machine).unwrap_err();
        assert_eq!((error.kind(), error.key_name()), (kind, Some(key)), "{error}");
        assert!(error.remedy_text().is_some(), "{error}");
    };
    let changed = |change: &dyn Fn(&mut Signals)| {
        let mut signals = run.signals().clone();
        change(&mut signals);
        Run::new("run", run.motion(), 1e-3, signals).unwrap()
    };
    let still = changed(&|signals| signals.get_mut(&Signal::PositionReference).unwrap().fill(0.5));
    refused(&still, &machine, ErrorKind::TooLittleData, "run.position_reference_rad");
    let without = changed(&|signals| drop(signals.remove(&Signal::PositionReference)));
    refused(&without, &machine, ErrorKind::Missing, "position_reference_rad");
    let text = fs::read_to_string(folder.path().join("machine.toml")).unwrap();
    let open: Vec<&str> = text.split("[controller]").collect();
    let open = format!("{}[motor]{}", open[0], open[1].split_once("[motor]").unwrap().1);
    fs::write(folder.path().join("machine.toml"), open).unwrap();
    refused(&run, &Machine::read(folder.path()).unwrap(), ErrorKind::Missing, "controller");
}
