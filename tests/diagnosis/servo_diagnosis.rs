//! What a diagnosis tells of the servo drive: stiction that the twin is not told of, and play in its coupling with and
//! without a sensor behind it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use std::collections::BTreeMap;
use std::path::Path;

use crate::support::random_input::random;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::recording::logged;
use slideway::replay::{Commands, PlantChoice};
use slideway::twin::Sensing;
use slideway::units::Motion;

const PERIOD_S: f64 = 2e-3;
/// Effects that may be named: frictions, and rivals at other sites.
const CATALOGUE: [EffectId; 12] = [
    EffectId::PositionGain,
    EffectId::VelocityGain,
    EffectId::IntegralGain,
    EffectId::VelocityFeedforward,
    EffectId::LoopDelay,
    EffectId::ForceConstant,
    EffectId::ViscousFriction,
    EffectId::CoulombFriction,
    EffectId::StribeckFriction,
    EffectId::Presliding,
    EffectId::Payload,
    EffectId::Backlash,
];

/// A machine file of the drive, edited as a text, in a folder of its own beside a copy of its solid model.
fn edited(file: &str, edit: impl Fn(&str) -> String) -> Machine {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo");
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(source.join(file)).unwrap();
    std::fs::write(folder.path().join("machine.toml"), edit(&text)).unwrap();
    std::fs::copy(source.join("machine.urdf"), folder.path().join("machine.urdf")).unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    for mesh in std::fs::read_dir(source.join("meshes")).unwrap().map(Result::unwrap) {
        std::fs::copy(mesh.path(), folder.path().join("meshes").join(mesh.file_name())).unwrap();
    }
    Machine::read(folder.path()).unwrap()
}

/// What a real machine makes of a command on the rigid-body scene, with noise, and what its drive logs of it.
fn recorded(real: &Machine, k: usize, command: (Signal, Vec<f64>), log: &[Signal]) -> Run {
    let role = if k == 2 { Role::HeldOut } else { Role::Training };
    // A run holds something measured; what moves the axis is the command in either case.
    let (signal, samples) = command;
    let blank = vec![0.0; samples.len()];
    let signals = BTreeMap::from([(Signal::ControlEffort, blank), (signal, samples)]);
    let told = Run::new(format!("random{}", k + 1), Motion::Revolute, PERIOD_S, signals).unwrap();
    let commands = Commands::of(&told, real).unwrap();
    let sensing = Sensing::AsStated { seed: 40 + k as u64 };
    let traces = commands.simulate(real, PlantChoice::Rapier, sensing, |_| ()).unwrap();
    let whole = logged(told.name(), real, commands.signals(PERIOD_S), traces).unwrap();
    let kept = whole.signals().iter().filter(|(signal, _)| log.contains(signal));
    let kept = kept.map(|(signal, samples)| (*signal, samples.clone())).collect();
    let mut run = Run::new(told.name(), Motion::Revolute, PERIOD_S, kept).unwrap();
    run.role = Some(role);
    run
}

fn told(title: &str, machine: &Machine, runs: Vec<Run>) -> Diagnosis {
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(machine, &Recording::new(runs).unwrap(), &options).unwrap();
    println!("{title}: {:?}, G {:.2} -> {:.2}", d.verdict, d.gap.before, d.gap.after);
    for cause in &d.causes {
        println!("   {} {:.3} {:?}", cause.effect, cause.probability, cause.parameters);
        println!("   confusable with {:?}: {:?}", cause.confusable_with, cause.confusable_reason);
    }
    for ranked in d.ranking.iter().take(5) {
        println!("   {ranked:?}");
    }
    println!("   not examined {:?}", d.not_examined);
    println!("   next {:?}", d.next_experiment.as_ref().map(|next| &next.sentence));
    d
}

/// Under a random current, loops off, with the twin of T(s): Coulomb friction with stiction, with their three numbers.
#[test]
fn ref_stiction_withheld_is_named_from_a_random_current() {
    let real =
        Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo/stiction.toml")).unwrap();
    let stated = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo")).unwrap();
    let log = [Signal::ControlEffort, Signal::Current, Signal::Position];
    let run = |k: usize| {
        recorded(&real, k, (Signal::ControlEffort, random(1 + k as u64, [1.2, PERIOD_S], 2.0, 0.04)), &log)
    };
    let d = told("stiction", &stated, (0..3).map(run).collect());
    assert_eq!(d.verdict, Verdict::Cause);
    let mut names: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["coulomb_friction", "stribeck_friction"]);
    for cause in &d.causes {
        assert_eq!(cause.site, "guide");
        assert!(cause.confusable_with.is_empty() && cause.probability > 0.99, "{cause:?}");
    }
    let numbers = [
        ("coulomb_friction", "torque_nm", 0.010),
        ("stribeck_friction", "peak_ratio", 1.5),
        ("stribeck_friction", "stribeck_velocity_rad_per_s", 2.0),
    ];
    for (effect, key, truth) in numbers {
        let found = d.causes.iter().find(|cause| cause.effect == effect).unwrap().parameters[key].value;
        assert!((found / truth - 1.0).abs() < 0.02, "{key}: {found}");
    }
    assert!(d.gap.closed > 0.99, "{:?}", d.gap);
}

const PLAY_RAD: f64 = 2e-3;
const SENSOR: &str = "[load_sensor]\nresolution_rad = 5.992112452678286e-6\nnoise_rad = 3e-6\n";

/// The drive with stiction, its encoder at the motor, with this sensor behind the coupling.
fn coupled(sensor: &str) -> Machine {
    edited("stiction.toml", |text| {
        let at_motor = text.replace("[encoder]\n", "[encoder]\nend = \"motor\"\n");
        assert_ne!(at_motor, text);
        format!("{at_motor}\n{sensor}")
    })
}

fn with_play(machine: &Machine) -> Machine {
    machine.with_settings([("effect.backlash.width_rad", PLAY_RAD.into())]).unwrap()
}

/// A random position reference, loops on.
fn in_closed_loop(real: &Machine, log: &[Signal]) -> Vec<Run> {
    let run = |k: usize| {
        let reference = random(11 + k as u64, [1.5, PERIOD_S], 1.0, 1.0);
        recorded(real, k, (Signal::PositionReference, reference), log)
    };
    (0..3).map(run).collect()
}

const LOG: [Signal; 5] = [
    Signal::PositionReference,
    Signal::ControlEffort,
    Signal::Current,
    Signal::Position,
    Signal::LoadPosition,
];

#[test]
fn ref_play_in_the_coupling_is_named_with_a_sensor_behind_it() {
    let stated = coupled(SENSOR);
    let d = told("play, both ends", &stated, in_closed_loop(&with_play(&stated), &LOG));
    assert_eq!(d.verdict, Verdict::Cause);
    let names: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!(names, ["backlash"]);
    let width = &d.causes[0].parameters["width_rad"];
    assert!((width.value / PLAY_RAD - 1.0).abs() < 0.02, "{width:?}");
    assert_eq!(d.causes[0].site, "structure");
}

/// The same recording without what that sensor read.
#[test]
fn ref_play_is_not_told_without_a_sensor_behind_it() {
    let runs = in_closed_loop(&with_play(&coupled(SENSOR)), &LOG[..4]);
    let d = told("play, motor only", &coupled(""), runs);
    assert_eq!((d.verdict, d.causes.len()), (Verdict::NoGap, 0));
    let unseen = d.not_examined.iter().find(|unseen| unseen.effect == "backlash").unwrap();
    assert!(unseen.reason.contains("load_position_rad"), "{unseen:?}");
}

/// One sensor, at the load: the loop is closed through the play, which then shows in all that it does.
#[test]
fn ref_play_inside_the_loop_is_named() {
    let stated = edited("stiction.toml", str::to_owned);
    let d = told("play, load only", &stated, in_closed_loop(&with_play(&stated), &LOG[..4]));
    let names: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!((d.verdict, names), (Verdict::Cause, vec!["backlash"]));
    let width = &d.causes[0].parameters["width_rad"];
    assert!((width.value / PLAY_RAD - 1.0).abs() < 0.02, "{width:?}");
}
