//! The limit of the commanded effort and the integral part behind it, in the loop.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;

use slideway::controller::regression::gain_regression;
use slideway::controller::regressor::Unknown;
use slideway::error::ErrorKind;
use slideway::identify::excitation::Outcome;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::replay::recording::recorded;
use slideway::replay::{Traces, controller_run, follow, run};
use slideway::twin::{Batch, Driven, LinearLoop, Sample, Sensing, Twin};

const PERIOD_S: f64 = 2e-3;

fn servo(settings: &[(&str, toml::Value)]) -> Machine {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo");
    let machine = Machine::read(&place).unwrap();
    machine.with_settings(settings.iter().map(|(key, value)| (*key, value.clone()))).unwrap()
}

fn kind(text: &str) -> toml::Value {
    let table: toml::Table = format!("a = {text}").parse().unwrap();
    table["a"].clone()
}

const KINDS: [&str; 3] = [
    r#"{ kind = "none" }"#,
    r#"{ kind = "clamping" }"#,
    r#"{ kind = "back_calculation", tracking_time_s = 0.02 }"#,
];

fn limited(limit_v: f64, anti_windup: &str) -> Machine {
    servo(&[("controller.effort_limit_v", limit_v.into()), ("controller.anti_windup", kind(anti_windup))])
}

/// A quick move of 5 rad and a sine after it.
fn reference() -> Vec<f64> {
    let at = |k: usize| {
        let t = k as f64 * PERIOD_S;
        5.0 * (t / 0.05).min(1.0) + if t > 1.5 { 3.0 * (10.0 * (t - 1.5)).sin() } else { 0.0 }
    };
    (0..1500).map(at).collect()
}

fn replayed(machine: &Machine) -> Traces {
    let twin = &mut Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    run(twin, follow(&reference(), PERIOD_S), |_| ())
}

/// The limit of 0.04 A is reached in every law, and a batch of them is to the bit what each is alone.
#[test]
fn exact_batch_is_its_twins_under_a_limit() {
    let machines: Vec<Machine> = KINDS.iter().map(|kind| limited(0.04, kind)).collect();
    let alone: Vec<Traces> = machines.iter().map(replayed).collect();
    for traces in &alone {
        let clipped = traces.effort_v.iter().filter(|u| u.abs() == 0.04).count();
        assert!(clipped > 20, "{clipped}");
    }
    assert!(alone[0].position != alone[1].position && alone[1].position != alone[2].position);
    let twin = |machine: &Machine| Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let mut batch = Batch::of(machines.iter().map(twin).collect(), Driven::ByControllers).unwrap();
    let mut together = vec![Traces::default(); machines.len()];
    for command in follow(&reference(), PERIOD_S) {
        batch.step(|_| command, |lane: usize, sample: Sample| together[lane].push(sample));
    }
    for (alone, together) in alone.iter().zip(&together) {
        assert_eq!(alone.position, together.position);
        assert_eq!(alone.effort_v, together.effort_v);
        assert_eq!(alone.current, together.current);
    }
}

/// A law whose limit is not reached is to the bit the law without one, in a batch with it too.
#[test]
fn exact_limit_out_of_reach_changes_nothing() {
    let free = {
        let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo");
        let text = std::fs::read_to_string(place.join("machine.toml")).unwrap();
        let kept: Vec<&str> = text
            .lines()
            .filter(|l| !l.starts_with("effort_limit_v") && !l.starts_with("anti_windup"))
            .collect();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("machine.toml"), kept.join("\n")).unwrap();
        std::fs::copy(place.join("machine.urdf"), folder.path().join("machine.urdf")).unwrap();
        std::fs::create_dir(folder.path().join("meshes")).unwrap();
        for file in std::fs::read_dir(place.join("meshes")).unwrap() {
            let file = file.unwrap();
            std::fs::copy(file.path(), folder.path().join("meshes").join(file.file_name())).unwrap();
        }
        Machine::read(folder.path()).unwrap()
    };
    assert!(free.constants().controller.unwrap().limit().is_none());
    let without = replayed(&free);
    for kind in KINDS {
        assert_eq!(replayed(&limited(1e6, kind)), without);
    }
}

/// The overshoot of a move whose effort is clipped for long is that of the wound-up integral part.
#[test]
fn exact_anti_windup_takes_the_overshoot_away() {
    let overshoot = |anti_windup: &str| {
        let traces = replayed(&limited(0.1, anti_windup));
        traces.position[..750].iter().fold(0.0, |most: f64, q| most.max(q - 5.0))
    };
    let [none, clamping, tracking] = KINDS.map(overshoot);
    // The linear loop does not overshoot; wound up, it does by a third of the move.
    assert!(none > 1.0 && clamping.max(tracking) < 1e-3, "{none} {clamping} {tracking}");
}

#[test]
fn exact_linear_loop_is_without_the_limit() {
    let tight = LinearLoop::of(&limited(0.01, KINDS[1])).unwrap();
    let wide = LinearLoop::of(&limited(1e6, KINDS[0])).unwrap();
    assert_eq!(tight.gains(), wide.gains());
    assert_eq!(tight.margins(), wide.margins());
    assert!(tight.is_stable());
    let margin = tight.margins().phase.unwrap().margin_deg;
    assert!((40.0..75.0).contains(&margin), "{margin}");
}

/// Gains are found from what is not clipped, whatever the integral part did meanwhile.
#[test]
fn exact_gains_are_found_from_a_clipped_run() {
    for kind in KINDS {
        let machine = limited(0.15, kind);
        let logged = recorded("run", &machine, &reference(), replayed(&machine)).unwrap();
        let found =
            gain_regression(&[controller_run(&machine, &logged).unwrap()], Unknown::BothLoops).unwrap();
        let Outcome::Identified(found) = found else { panic!("not excited") };
        assert!(found.clipped > 10, "{}", found.clipped);
        for gain in found.gains.iter().filter(|gain| gain.stated != 0.0) {
            assert!((gain.estimate.value / gain.stated - 1.0).abs() < 1e-6, "{kind}: {gain:?}");
        }
    }
}

#[test]
fn exact_settings_that_cannot_be_are_refused() {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo");
    let machine = Machine::read(&place).unwrap();
    let refused = |settings: &[(&str, toml::Value)]| {
        machine.with_settings(settings.iter().map(|(key, value)| (*key, value.clone()))).unwrap_err()
    };
    let error = refused(&[("controller.effort_limit_v", 0.0.into())]);
    assert_eq!(error.kind(), ErrorKind::OutOfRange);
    let short = kind(r#"{ kind = "back_calculation", tracking_time_s = 0.001 }"#);
    let error = refused(&[("controller.anti_windup", short)]);
    assert!(error.to_string().contains("tracking_time_s"), "{error}");
    let unknown = kind(r#"{ kind = "conditional" }"#);
    assert_eq!(refused(&[("controller.anti_windup", unknown)]).kind(), ErrorKind::UnknownKey);
    // A law that asks for anti-windup states what it is against.
    let emps = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps")).unwrap();
    let error = emps.with_settings([("controller.anti_windup", kind(KINDS[1]))]).unwrap_err();
    assert!(error.to_string().contains("effort_limit_v"), "{error}");
}
