//! Diagnoses of recordings that lack signals: hidden effects are still named, and what cannot be told is said.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use crate::support::{self, needs};
use slideway::diagnose::evidence::Score;
use slideway::diagnose::experiment::Experiment;
use slideway::diagnose::noise::Floor;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::plant::Plant as _;
use slideway::plant::axis::Axis;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::recording::recorded;
use slideway::replay::{Motion, PlantChoice, Stroke, Traces, simulate};
use slideway::twin::{Command, Sensing, Twin};
use std::path::Path;

const GRINDER: &str = "models/grinder";

/// Effects that may be named: enough rivals at every site, few enough for a test.
const CATALOGUE: [EffectId; 11] = [
    EffectId::PositionGain,
    EffectId::VelocityGain,
    EffectId::IntegralGain,
    EffectId::VelocityFeedforward,
    EffectId::LoopDelay,
    EffectId::ForceConstant,
    EffectId::ViscousFriction,
    EffectId::CoulombFriction,
    EffectId::ConstantForce,
    EffectId::Payload,
    EffectId::VelocityFilter,
];

/// Stroke (m), feed (m/min) and role of each run.
const CELLS: [(f64, f64, Role); 3] =
    [(0.04, 16.0, Role::Training), (0.05, 12.0, Role::Training), (0.03, 16.0, Role::HeldOut)];

/// Hidden effects of the tests: name, parameter, value, and the fraction of it within which it must be found (position
/// and current noise over three runs leave less than half of that).
const HIDDEN: [(&str, &str, f64, f64); 3] = [
    ("coulomb_friction", "force_n", 15.0, 0.05),
    ("payload", "mass_kg", 7.0, 0.05),
    ("viscous_friction", "viscous_n_s_per_m", 500.0, 0.03),
];

const ALL: [&str; 3] = [HIDDEN[0].0, HIDDEN[1].0, HIDDEN[2].0];

/// What is known of a case: whether the controller is stated, and which signals were logged.
struct Known {
    name: &'static str,
    controller: bool,
    signals: &'static [Signal],
}

use Signal::{ControlEffort, Current, LoadPosition, Position, PositionReference, Thrust, Velocity};

const CURRENT_MISSING: Known = Known {
    name: "current missing",
    controller: true,
    signals: &[PositionReference, ControlEffort, Position, Velocity],
};
const EFFORT_MISSING: Known = Known {
    name: "effort missing",
    controller: true,
    signals: &[PositionReference, Current, Thrust, Position],
};
const POSITION_ONLY: Known =
    Known { name: "position only", controller: true, signals: &[PositionReference, Position] };
const CONTROLLER_UNKNOWN: Known = Known {
    name: "controller unknown",
    controller: false,
    signals: &[PositionReference, ControlEffort, Current, Position, Velocity],
};
const THRUST_ONLY: Known = Known {
    name: "controller unknown, thrust",
    controller: false,
    signals: &[PositionReference, Thrust, Position],
};
const CURRENT_ONLY: Known = Known {
    name: "controller unknown, current",
    controller: false,
    signals: &[PositionReference, Current, Position],
};
const REFERENCE_MISSING: Known =
    Known { name: "reference missing", controller: true, signals: &[ControlEffort, Current, Position] };

fn machine(path: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// A machine, edited as a text, in a folder of its own beside a copy of its solid model.
fn edited(path: &str, edit: impl Fn(&str) -> String) -> Machine {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(source.join("machine.toml")).unwrap();
    std::fs::write(folder.path().join("machine.toml"), edit(&text)).unwrap();
    std::fs::copy(source.join("machine.urdf"), folder.path().join("machine.urdf")).unwrap();
    if let Ok(meshes) = std::fs::read_dir(source.join("meshes")) {
        std::fs::create_dir(folder.path().join("meshes")).unwrap();
        for mesh in meshes.map(Result::unwrap) {
            std::fs::copy(mesh.path(), folder.path().join("meshes").join(mesh.file_name())).unwrap();
        }
    }
    Machine::read(folder.path()).unwrap()
}

/// A machine file without its control law.
fn unstated(text: &str) -> String {
    let (before, rest) = text.split_once("[controller]").unwrap();
    format!("{before}[{}", rest.split_once("\n[").unwrap().1)
}

fn without_controller() -> Machine {
    edited(GRINDER, unstated)
}

/// A machine file with the encoder at the motor and a scale at the load.
fn two_sensors(text: &str) -> String {
    let motor = text.replace("[encoder]", "[encoder]\nend = \"motor\"");
    format!("{motor}\n[load_sensor]\nresolution_m = 1e-7\nnoise_m = 3e-8\n")
}

/// What a machine with hidden settings logs, all signals.
fn recording(stated: &Machine, hidden: &[(&str, f64)], seed: u64) -> Recording {
    let settings = hidden.iter().map(|(key, value)| (*key, toml::Value::Float(*value)));
    let real = stated.with_settings(settings).unwrap();
    Strokes { dwell_s: 0.4, ..Strokes::both_ways(stated, &real, seed) }.recording(&CELLS)
}

/// The recording with only these signals.
fn keeping(recording: &Recording, signals: &[Signal]) -> Recording {
    let kept = |run: &Run| {
        let all = run.signals().iter().filter(|(signal, _)| signals.contains(signal));
        let all = all.map(|(signal, samples)| (*signal, samples.clone())).collect();
        let mut kept = Run::new(run.name(), run.motion(), run.sample_period_s(), all).unwrap();
        kept.role = run.role;
        kept
    };
    Recording::new(recording.runs().iter().map(kept).collect()).unwrap()
}

fn diagnosis(known: &Known, hidden: &[(&str, f64)], seed: u64) -> Result<Diagnosis, Error> {
    let stated = machine(GRINDER);
    let recording = keeping(&recording(&stated, hidden, seed), known.signals);
    let machine = if known.controller { stated } else { without_controller() };
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    diagnose(&machine, &recording, &options)
}

fn named(d: &Diagnosis) -> Vec<&str> {
    d.causes.iter().map(|cause| cause.effect.as_str()).collect()
}

fn not_examined(d: &Diagnosis) -> Vec<&str> {
    d.not_examined.iter().map(|n| n.effect.as_str()).collect()
}

fn report(name: &str, d: &Diagnosis) {
    println!(
        "== {name}: {:?} {:?}, G {:.3} -> {:.3}, closed {:.4}, segments {:?}",
        d.verdict,
        d.causes.iter().map(|c| (&c.effect, c.probability, &c.parameters)).collect::<Vec<_>>(),
        d.gap.before,
        d.gap.after,
        d.gap.closed,
        d.place.segment.iter().map(|s| format!("{} {:.4}", s.name, s.share)).collect::<Vec<_>>()
    );
    for c in &d.calibration {
        println!("   calibration {} = {:.5} {:?}", c.path, c.parameter.value, c.parameter.ci95);
    }
    for r in d.ranking.iter().take(3) {
        println!("   {:?} p={:.4} G={:.3}", r.effects, r.probability, r.held_out_gap);
    }
    for s in &d.gap.signals {
        println!(
            "   {} {:.2e} -> {:.2e}, noise {:.2e} {:?}",
            s.signal, s.rms_before, s.rms_after, s.noise, s.noise_source
        );
    }
}

/// Every hidden effect is named alone, with its size, and nothing hidden is no gap.
fn assert_told(known: &Known, effects: &[&str]) {
    let mut faults = Vec::new();
    let hidden = HIDDEN.into_iter().enumerate().filter(|(_, hidden)| effects.contains(&hidden.0));
    for (seed, (effect, parameter, value, within)) in hidden {
        let key = format!("effect.{effect}.{parameter}");
        let d = diagnosis(known, &[(key.as_str(), value)], 10 + seed as u64).unwrap();
        report(&format!("{}, {effect}", known.name), &d);
        if (d.verdict, named(&d)) != (Verdict::Cause, vec![effect]) {
            faults.push(format!("{effect}: {:?} {:?}", d.verdict, named(&d)));
            continue;
        }
        let found = d.causes[0].parameters[parameter].value;
        if (found / value - 1.0).abs() > within {
            faults.push(format!("{effect}: {found} instead of {value}"));
        }
        let mechanics = d.place.segment.iter().find(|s| s.name.contains("guide")).unwrap();
        if mechanics.share < 0.9 {
            faults.push(format!("{effect}: segments {:?}", d.place.segment));
        }
    }
    let d = diagnosis(known, &[], 20).unwrap();
    report(&format!("{}, nothing", known.name), &d);
    if (d.verdict, named(&d)) != (Verdict::NoGap, vec![]) {
        faults.push(format!("nothing: {:?} {:?}", d.verdict, named(&d)));
    }
    assert!(faults.is_empty(), "{}: {faults:#?}", known.name);
}

fn segments(d: &Diagnosis) -> Vec<&str> {
    d.place.segment.iter().map(|s| s.name.as_str()).collect()
}

#[test]
fn ref_effects_are_named_with_current_missing() {
    assert_told(&CURRENT_MISSING, &ALL);
}

#[test]
fn ref_effects_are_named_with_effort_missing() {
    assert_told(&EFFORT_MISSING, &ALL);
}

/// Where the effort is not seen, viscous friction and the velocity gain of the controller brake alike.
#[test]
fn ref_effects_are_named_from_position_and_reference_alone_and_viscous_friction_looks_like_a_gain() {
    assert_told(&POSITION_ONLY, &["coulomb_friction", "payload"]);
    let d = diagnosis(&POSITION_ONLY, &[("effect.viscous_friction.viscous_n_s_per_m", 500.0)], 12).unwrap();
    report("position only, viscous_friction", &d);
    assert_ne!(d.verdict, Verdict::NoGap);
    let first = d.ranking.iter().take(2).flat_map(|r| &r.effects);
    assert!(first.clone().any(|effect| effect == "viscous_friction"), "{:?}", first.collect::<Vec<_>>());
}

#[test]
fn ref_effects_are_named_with_the_controller_unknown() {
    assert_told(&CONTROLLER_UNKNOWN, &ALL);
}

#[test]
fn ref_effects_are_named_with_controller_and_effort_unknown() {
    assert_told(&THRUST_ONLY, &ALL);
}

/// Under a measured current, mass, viscous coefficient and the inverse force constant only scale together: with the
/// viscous coefficient free inside its tolerance, a payload and another force constant predict the same.
#[test]
fn ref_friction_is_named_from_position_and_current_alone_and_a_payload_looks_like_a_force_constant() {
    for (effect, parameter, value, within) in HIDDEN.into_iter().filter(|hidden| hidden.0 != "payload") {
        let key = format!("effect.{effect}.{parameter}");
        let d = diagnosis(&CURRENT_ONLY, &[(key.as_str(), value)], 12).unwrap();
        report(&format!("{}, {effect}", CURRENT_ONLY.name), &d);
        assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec![effect]));
        assert!((d.causes[0].parameters[parameter].value / value - 1.0).abs() < within);
    }
    let d = diagnosis(&CURRENT_ONLY, &[("effect.payload.mass_kg", 7.0)], 11).unwrap();
    report(&format!("{}, payload", CURRENT_ONLY.name), &d);
    assert!(matches!(d.verdict, Verdict::Undecided | Verdict::Unknown), "{:?}", d.verdict);
    let mut first: Vec<&str> =
        d.ranking.iter().take(2).flat_map(|r| &r.effects).map(String::as_str).collect();
    first.sort_unstable();
    assert_eq!(first, ["force_constant", "payload"]);
    assert!(d.ranking.iter().take(2).map(|r| r.probability).sum::<f64>() > 0.9);
    let d = diagnosis(&CURRENT_ONLY, &[], 20).unwrap();
    report(&format!("{}, nothing", CURRENT_ONLY.name), &d);
    assert_eq!((d.verdict, named(&d)), (Verdict::NoGap, vec![]));
}

#[test]
fn ref_effects_are_named_with_the_reference_missing() {
    assert_told(&REFERENCE_MISSING, &ALL);
}

/// Segments merge where no signal cuts the path, and their names say so.
#[test]
fn exact_segments_merge_where_signals_are_missing() {
    let names = |known: &Known| {
        let d = diagnosis(known, &[("effect.coulomb_friction.force_n", 15.0)], 30).unwrap();
        segments(&d).join(" | ")
    };
    assert_eq!(names(&CURRENT_MISSING), "controller | amplifier+motor+guide+structure+sensor");
    assert_eq!(names(&EFFORT_MISSING), "controller+amplifier+motor | motor | guide+structure+sensor");
    assert_eq!(names(&POSITION_ONLY), "controller+amplifier+motor+guide+structure+sensor");
    assert_eq!(names(&CONTROLLER_UNKNOWN), "amplifier+motor | motor+guide+structure+sensor");
    assert_eq!(names(&THRUST_ONLY), "guide+structure+sensor");
    assert_eq!(names(&CURRENT_ONLY), "motor+guide+structure+sensor");
}

/// What lies before the first known signal, or acts through the loop alone, is said not to have been looked at.
/// The gains of the control law, in signal-path order.
const GAINS: &str = "position_gain velocity_gain integral_gain velocity_feedforward";

#[test]
fn exact_effects_without_a_trace_are_not_examined() {
    let unseen = |known: &Known| {
        let d = diagnosis(known, &[], 31).unwrap();
        assert!(d.not_examined.iter().all(|n| n.reason.ends_with('.')));
        assert!(d.effects.iter().all(|e| !not_examined(&d).contains(&e.effect.as_str())));
        not_examined(&d).join(" ")
    };
    assert_eq!(unseen(&POSITION_ONLY), "");
    assert_eq!(unseen(&CONTROLLER_UNKNOWN), GAINS);
    assert_eq!(unseen(&REFERENCE_MISSING), format!("{GAINS} velocity_filter"));
    assert_eq!(unseen(&CURRENT_ONLY), format!("{GAINS} loop_delay velocity_filter"));
    assert_eq!(unseen(&THRUST_ONLY), format!("{GAINS} loop_delay force_constant velocity_filter"));
}

/// A second sensor at the load cuts once more: lost motion shows behind the encoder, friction before it.
#[test]
fn ref_two_position_sensors_cut_the_drive_train_apart() {
    let both = edited(GRINDER, two_sensors);
    let catalogue = [&CATALOGUE[..], &[EffectId::Backlash]].concat();
    let options = Options { catalogue: &catalogue, ..Options::default() };
    let signals = [PositionReference, ControlEffort, Current, Thrust, Position, Velocity, LoadPosition];
    let path = ["controller", "amplifier+motor", "motor", "guide+structure", "structure+sensor"];
    let cases = [("coulomb_friction", "force_n", 15.0, 3), ("backlash", "width_m", 20e-6, 4)];
    for (effect, parameter, value, place) in cases {
        let key = format!("effect.{effect}.{parameter}");
        let recording = keeping(&recording(&both, &[(key.as_str(), value)], 40), &signals);
        let d = diagnose(&both, &recording, &options).unwrap();
        report(&format!("two sensors, {effect}"), &d);
        assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec![effect]));
        assert_eq!(segments(&d), path);
        assert!(d.place.segment[place].share > 0.95, "{:?}", d.place.segment);
        assert!((d.causes[0].parameters[parameter].value / value - 1.0).abs() < 0.05);
    }
}

/// Two sensors and an unknown controller: lost motion needs no loop.
#[test]
fn ref_lost_motion_is_named_with_the_controller_unknown() {
    let both = edited(GRINDER, two_sensors);
    let open = edited(GRINDER, |text| two_sensors(&unstated(text)));
    let catalogue = [&CATALOGUE[..], &[EffectId::Backlash]].concat();
    let options = Options { catalogue: &catalogue, ..Options::default() };
    let signals = [ControlEffort, Position, LoadPosition];
    let recording = keeping(&recording(&both, &[("effect.backlash.width_m", 20e-6)], 41), &signals);
    let d = diagnose(&open, &recording, &options).unwrap();
    report("two sensors, controller unknown, backlash", &d);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["backlash"]));
    assert_eq!(segments(&d), ["amplifier+motor+guide+structure", "structure+sensor"]);
    assert!(d.place.segment[1].share > 0.95, "{:?}", d.place.segment);
}

/// Without noise, windows give back the run that their twin has made: their error stays, RMS, a tenth of the
/// encoder's noise of 30 nm.
#[test]
fn exact_windows_give_back_a_run_without_noise() {
    const ERROR_M: f64 = 3e-9;
    let stated = machine(GRINDER);
    let hidden = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    let real = stated.with_settings(hidden.clone()).unwrap();
    let there = Stroke::metres_at_metres_per_minute(0.04, 16.0).unwrap();
    let strokes = vec![there, Stroke { stroke: -there.stroke, ..there }];
    let motion = Motion { strokes, lead_s: 0.1, dwell_s: 0.4, ramp_s: 0.02 };
    let reference = motion.reference(real.description().sample_period_s);
    let traces = simulate(&real, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).unwrap();
    let run = recorded("clean", &stated, &reference, traces).unwrap();
    let blind = without_controller().with_settings(hidden).unwrap();
    for input in [ControlEffort, Current, Thrust] {
        let kept = keeping(&Recording::new(vec![run.clone()]).unwrap(), &[input, Position]);
        let experiment = Experiment::new(&kept.runs()[0], &blind).unwrap();
        assert_eq!(experiment.input().unwrap().signal(), input);
        let predicted = experiment.predict(&blind, Sensing::Perfect).unwrap().position;
        let measured = run.signal(Position).unwrap();
        let squares: f64 = measured.iter().zip(&predicted).map(|(m, p)| (m - p) * (m - p)).sum();
        let error = (squares / measured.len() as f64).sqrt();
        println!("{input:?}: {error:.2e} m");
        assert!(error < ERROR_M, "{input:?}: {error} m");
    }
}

/// Setting a twin to the state that it is in changes nothing, whatever stands between motor and encoder.
#[test]
fn exact_a_restart_in_its_own_state_changes_nothing() {
    // Rounding of positions of 10 mm over some thousand steps.
    const ROUNDING_M: f64 = 1e-12;
    for settings in [vec![], vec![("effect.backlash.width_m", 20e-6), ("effect.encoder_scale.factor", 1.05)]]
    {
        let set = settings.iter().map(|(key, value)| (*key, toml::Value::Float(*value)));
        let machine = edited(GRINDER, two_sensors).with_settings(set).unwrap();
        let axis = || Axis::of(&machine.constants());
        let mut twins = [(); 2].map(|()| Twin::new(&machine, axis(), Sensing::Perfect));
        for k in 0..2000 {
            let effort_v = (f64::from(k) * 5e-3).sin();
            let command = Command { effort_v: Some(effort_v), ..Command::follow(0.0, 0.0) };
            let [left, set] = &mut twins;
            if k % 300 == 200 {
                let factor = settings.last().map_or(1.0, |(_, factor)| *factor);
                let state = [set.plant().position(), set.plant().velocity()].map(|x| factor * x);
                set.restart(state[0], state[1]);
            }
            let (a, b) = (left.step(command), set.step(command));
            assert!((a.position - b.position).abs() < ROUNDING_M, "{k}: {a:?} {b:?}");
            assert!((a.load_position - b.load_position).abs() < ROUNDING_M, "{k}: {a:?} {b:?}");
            assert!((a.velocity - b.velocity).abs() < 1e-8, "{k}: {a:?} {b:?}");
        }
    }
}

/// Noise is seen where the axis stands still and where a stroke is repeated; of a single stroke that begins and ends in motion
/// it is only stated.
#[test]
fn exact_noise_is_measured_at_standstill_and_in_repeats() {
    let machine = machine(GRINDER);
    let is_measured = |runs: &[Run]| {
        let all: Vec<Experiment> = runs.iter().map(|run| Experiment::new(run, &machine).unwrap()).collect();
        Floor::estimate(&machine, &all.iter().collect::<Vec<_>>()).unwrap().is_measured()
    };
    let strokes = |seed: u64| Strokes { dwell_s: 0.0, ..Strokes::both_ways(&machine, &machine, seed) };
    let standing = Strokes::both_ways(&machine, &machine, 1).recording(&CELLS[..1]);
    assert!(is_measured(standing.runs()));
    let moving: Vec<Run> = [1, 2]
        .iter()
        .flat_map(|seed| strokes(*seed).recording(&CELLS[..1]).runs().to_vec())
        .map(in_motion)
        .collect();
    assert!(!is_measured(&moving[..1]));
    assert!(is_measured(&moving));
}

/// A run without what comes before its reference starts and after it stops.
fn in_motion(run: Run) -> Run {
    let reference = run.signal(PositionReference).unwrap();
    let moves: Vec<usize> = (1..run.len()).filter(|&k| reference[k] != reference[k - 1]).collect();
    let (from, to) = (moves[0] - 1, moves[moves.len() - 1]);
    let cut = run.signals().iter().map(|(signal, samples)| (*signal, samples[from..to].to_vec())).collect();
    Run::new(run.name(), run.motion(), run.sample_period_s(), cut).unwrap()
}

/// Replays of the machine that made the recording leave what noise leaves, whatever drives them: 1 in units of the floor.
/// Encoder noise is white and its level known within some per cent; that of a current adds up along the windows, of
/// which a run has few.
#[test]
fn exact_the_true_twin_stands_at_the_floor_whatever_drives_it() {
    let modes = [
        (&CONTROLLER_UNKNOWN, 0.9..1.1),
        (&REFERENCE_MISSING, 0.9..1.1),
        (&THRUST_ONLY, 0.9..1.1),
        (&CURRENT_ONLY, 0.6..1.6),
    ];
    let hidden =
        [vec![], vec![("effect.payload.mass_kg", 7.0)], vec![("effect.coulomb_friction.force_n", 15.0)]];
    for (known, range) in modes {
        for (hidden, seed) in hidden.iter().flat_map(|hidden| [(hidden, 100), (hidden, 101)]) {
            let recording = keeping(&recording(&machine(GRINDER), hidden, seed), known.signals);
            let settings = hidden.iter().map(|(key, value)| (*key, toml::Value::Float(*value)));
            let real = without_controller().with_settings(settings).unwrap();
            let runs: Vec<Experiment> =
                recording.runs().iter().map(|run| Experiment::new(run, &real).unwrap()).collect();
            let floor = Floor::estimate(&real, &runs.iter().collect::<Vec<_>>()).unwrap();
            let replay = |run: &Experiment| run.predict(&real, Sensing::Perfect).unwrap();
            let traces: Vec<Traces> = runs.iter().map(replay).collect();
            let gap = Score::of_traces(&runs, &traces, &floor).gap();
            println!("{}, {hidden:?}: G {gap:.3}", known.name);
            assert!(range.contains(&gap), "{}, {hidden:?}: {gap}", known.name);
        }
    }
}

/// Published friction of the real ball-screw axis (Janot, Gautier, Brunot 2019), from its logs with the reference taken
/// away and the controller not stated.
#[test]
fn ref_published_friction_is_named_with_the_controller_unknown() {
    needs!(support::data("emps/emps_estimation.csv"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let logged = Recording::read(root.join("models/emps/recording.toml")).unwrap();
    let recording = keeping(&logged, &[ControlEffort, Position]);
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(&edited("models/emps", unstated), &recording, &options).unwrap();
    report("published axis", &d);
    let mut names = named(&d);
    names.sort_unstable();
    assert_eq!(
        (d.verdict, names),
        (Verdict::Cause, vec!["constant_force", "coulomb_friction", "viscous_friction"])
    );
    // Another criterion on the same data: the open loop weighs slow forces more than the published regression.
    let published =
        [("coulomb_friction", "force_n", 20.3935), ("viscous_friction", "viscous_n_s_per_m", 203.5034)];
    for (effect, parameter, value) in published {
        let cause = d.causes.iter().find(|cause| cause.effect == effect).unwrap();
        assert!((cause.parameters[parameter].value / value - 1.0).abs() < 0.05, "{cause:?}");
    }
}

#[test]
fn exact_a_recording_without_position_is_refused() {
    let known = Known {
        name: "no position",
        controller: false,
        signals: &[PositionReference, ControlEffort, Velocity],
    };
    let error = diagnosis(&known, &[], 50).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Missing, Some("position_m")));
    assert!(error.remedy_text().unwrap().contains("log it"));
}

#[test]
fn exact_a_recording_without_any_input_is_refused() {
    let known =
        Known { name: "no input", controller: false, signals: &[PositionReference, Position, Velocity] };
    let error = diagnosis(&known, &[], 51).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Missing, Some("controller")));
    let remedy = error.remedy_text().unwrap();
    for word in ["control_effort_v", "thrust_n", "current_a", "[controller]"] {
        assert!(remedy.contains(word), "{remedy}");
    }
    let known = Known { name: "no reference", controller: true, signals: &[Position, Velocity] };
    let error = diagnosis(&known, &[], 52).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Missing, Some("position_reference_m")));
}
