//! How replays of recorded runs begin.
#![allow(clippy::unwrap_used, missing_docs)]

use crate::support::told::{model, with};
use slideway::diagnose::experiment::Experiment;
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal, SplitRule};
use slideway::replay::recording::recorded;
use slideway::replay::start::Start;
use slideway::replay::{Motion, PlantChoice, Stroke, run_seed, simulate};
use slideway::twin::Sensing;
use std::collections::BTreeMap;

/// A start at rest with an effort of 0.13 V and this current, and half the current's interval, in A.
fn resting(current: f64, current_interval: f64) -> Start {
    Start {
        position: 0.0,
        velocity: 0.0,
        acceleration: Some(0.0),
        effort_v: Some(0.13),
        resting_effort_v: Some(0.13),
        current: Some(current),
        current_interval,
        reading: None,
        load_position: None,
        feedforward_v: 0.0,
        supply_v: None,
    }
}

/// At rest the effort over the resistance is the current; in a transient a current beyond its interval from there counts, and so it does in motion.
#[test]
fn exact_a_resting_current_is_what_the_drive_makes_of_the_effort() {
    let grinder = with(&model("grinder"), &[("motor.resistance_ohm", 1.3)]);
    let constants = grinder.constants();
    let settled = 0.13 / 1.3;
    let current = |start: Start| start.current_a(&constants);
    assert!((current(resting(0.5, f64::INFINITY)) - settled).abs() < 1e-12);
    assert_eq!(current(resting(0.5, 0.01)), 0.5);
    assert!((current(resting(settled + 0.005, 0.01)) - settled).abs() < 1e-12);
    assert_eq!(current(Start { resting_effort_v: None, ..resting(0.5, 0.0) }), 0.5);
}

/// A resting run of 100 samples with these constant signals.
fn still(signals: &[(Signal, f64)]) -> Start {
    let constant = |&(signal, value): &(Signal, f64)| (signal, vec![value; 100]);
    let signals: BTreeMap<Signal, Vec<f64>> = signals.iter().map(constant).collect();
    let grinder = model("grinder");
    let run = Run::new("still", grinder.motion(), grinder.constants().sample_period_s, signals).unwrap();
    let position = run.signal(Signal::Position).unwrap();
    Start::of(&run, position, position)
}

/// With the drive off no effort reaches the winding; the supply that a duty cycle is multiplied by is the one that was logged.
#[test]
fn exact_a_drive_that_is_off_and_a_measured_supply_are_known_to_the_start() {
    let logged = [(Signal::Position, 0.0), (Signal::ControlEffort, 0.13), (Signal::Current, 0.0)];
    let off = still(&[&logged[..], &[(Signal::TorqueEnabled, 0.0)]].concat());
    assert_eq!((off.resting_effort_v, off.current), (None, Some(0.0)));
    let on = still(&[&logged[..], &[(Signal::TorqueEnabled, 1.0), (Signal::SupplyVoltage, 10.0)]].concat());
    assert!((on.resting_effort_v.unwrap() - 0.13).abs() < 1e-12);
    let mut constants = with(&model("grinder"), &[("motor.resistance_ohm", 1.3)]).constants();
    constants.amplifier.supply_v = Some(12.0);
    assert!((on.current_a(&constants) - 1.0).abs() < 1e-12, "{}", on.current_a(&constants));
}

/// Root mean square in rad or m of what a replay leaves of the position over the first half second.
fn left(log: &Experiment, machine: &Machine) -> f64 {
    let predicted = log.predict(machine, Sensing::Perfect).unwrap();
    let pairs = log.run().signal(Signal::Position).unwrap().iter().zip(&predicted.position);
    let count = ((0.5 / log.run().sample_period_s()).round() as usize).min(log.samples());
    (pairs.take(count).map(|(m, p)| (m - p).powi(2)).sum::<f64>() / count as f64).sqrt()
}

/// Logs that a torque drive with bristles and a noisy current sensor writes itself are predicted from the start read off them nearly as well as from the
/// start that they had: steps of the encoder alone part both.
#[test]
fn exact_bristles_do_not_give_way_to_the_noise_of_the_current() {
    let known = [
        ("effect.coulomb_friction.torque_nm", 4e-5),
        ("effect.presliding.stiffness_nm_per_rad", 0.04),
        ("effect.presliding.damping_nm_s_per_rad", 3e-4),
    ];
    let servo = with(&model("servo"), &known);
    let stroke = Stroke { stroke: 1.0, feed: 3.0 };
    let motion = Motion { strokes: vec![stroke], lead_s: 0.2, dwell_s: 0.4, ramp_s: 0.05 };
    let reference = motion.reference(servo.constants().sample_period_s);
    let sensing = Sensing::AsStated { seed: run_seed(1, "run") };
    let traces = simulate(&servo, PlantChoice::Axis, sensing, &reference, |_| ()).unwrap();
    let recording = Recording::new(vec![recorded("run", &servo, &reference, traces).unwrap()]).unwrap();
    let experiment = Experiment::new(&recording.runs()[0], &servo).unwrap();
    for seed in 0..6 {
        let log = experiment.imagined(&servo, seed).unwrap();
        let [known, read] = [left(&log, &servo), left(&log.begun_as_read(&servo).unwrap(), &servo)];
        assert!(read < 2.0 * known, "{seed}: {read} of {known} rad");
    }
}

/// A run under a vibration that is cut where replays begin while the axis still comes in: each piece is predicted to the noise of the encoder, but for the
/// first, which begins before the vibration has settled.
#[test]
fn exact_a_cut_run_under_vibration_goes_on_as_it_was() {
    let vibration =
        [("effect.external_vibration.force_n", 0.3), ("effect.external_vibration.frequency_hz", 28.67)];
    let shaken = with(&model("grinder"), &vibration);
    let stroke =
        |k: usize| Stroke { stroke: if k.is_multiple_of(2) { 8e-3 } else { -8e-3 }, feed: 4.0 / 60.0 };
    let strokes = (0..12).map(stroke).collect();
    let motion = Motion { strokes, lead_s: 0.2, dwell_s: 0.24, ramp_s: 0.05 };
    let reference = motion.reference(shaken.constants().sample_period_s);
    let sensing = Sensing::AsStated { seed: run_seed(1, "run") };
    let traces = simulate(&shaken, PlantChoice::Axis, sensing, &reference, |_| ()).unwrap();
    let recording = Recording::new(vec![recorded("run", &shaken, &reference, traces).unwrap()]).unwrap();
    let (training, held_out) = recording.split(SplitRule::default()).unwrap();
    let pieces: Vec<&Run> =
        training.runs().iter().chain(held_out.runs()).filter(|run| run.begins_s > 0.0).collect();
    assert!(!pieces.is_empty());
    for run in pieces {
        let experiment = Experiment::new(run, &shaken).unwrap();
        let noise = 42e-9;
        let left = left(&experiment, &shaken);
        assert!(left < 1.2 * noise, "{} from {} s: {left} m", run.name(), run.begins_s);
    }
}
