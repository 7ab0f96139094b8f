//! From a log to a machine file: what the log tells is found, what it does not is asked for, and the diagnosis comes to its cause.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{self, needs};
use slideway::controller::{AntiWindup, Cascade, Controller, Input, Memory, Pd, Pdf};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::init::{Draft, Findings, Form, LawFound, Mark, Sheet, findings, write};
use slideway::machine::Machine;
use slideway::recording::{LogContext, MappedColumn, Recording, Run, Signal};
use slideway::sensor::{VelocityEstimate, VelocityMemory};
use slideway::units::Motion;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rivals of dry friction that a first diagnosis would look at.
const CATALOGUE: [EffectId; 5] = [
    EffectId::CoulombFriction,
    EffectId::ViscousFriction,
    EffectId::AsymmetricFriction,
    EffectId::Payload,
    EffectId::LoopDelay,
];
/// Samples of a quick diagnosis.
const SAMPLES: usize = 8_000;

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/hidden_coulomb")
}

fn value(draft: &Draft, table: &str, key: &str) -> f64 {
    let item = draft.items.iter().find(|item| item.table == table && item.key == key);
    let item = item.unwrap_or_else(|| panic!("{table}.{key} is not in the draft"));
    item.value.as_ref().unwrap_or_else(|| panic!("{table}.{key} is missing")).parse().unwrap()
}

fn near(found: f64, truth: f64, share: f64, what: &str) {
    assert!((found / truth - 1.0).abs() < share, "{what}: {found}, in truth {truth}");
}

fn quick(machine: &Machine, recording: &Recording) -> Diagnosis {
    let options = Options { catalogue: &CATALOGUE, most_samples: SAMPLES, ..Options::default() };
    diagnose(machine, recording, &options).unwrap()
}

/// The shipped recording without the channels that only a simulation knows.
fn as_logged(recording: &Recording) -> Recording {
    let logged = [Signal::PositionReference, Signal::Position, Signal::ControlEffort, Signal::Current];
    let of = |run: &Run| {
        let signals = run.signals().iter().filter(|(signal, _)| logged.contains(signal));
        run.with_signals(signals.map(|(signal, samples)| (*signal, samples.clone())).collect()).unwrap()
    };
    Recording::new(recording.runs().iter().map(of).collect()).unwrap()
}

/// The four numbers of the data sheets: the parts list weighs the table, the motor's sheet states the others.
fn sheet() -> Sheet {
    Sheet {
        mass: Some(51.28),
        force_constant: Some(83.1),
        resistance: Some(1.3),
        inductance: Some(8e-3),
        ..Sheet::default()
    }
}

#[test]
fn ref_the_shipped_recording_comes_to_its_cause_from_four_numbers() {
    let recording = Recording::read(shipped()).unwrap();
    let recording = as_logged(&recording);
    let found = findings(&recording, None).unwrap();
    let draft = Draft::of(&recording, &found, &sheet(), None);
    assert_eq!(draft.lacks, []);
    // Against models/grinder/machine.toml, which made the recording.
    near(
        value(&draft, "controller", "integral_gain_per_count"),
        19.0 * 6.942e-2 * 1000.0,
        1e-3,
        "integral gain",
    );
    near(
        value(&draft, "controller", "proportional_gain_per_count"),
        260.0 * 2.359e-4 * 1000.0,
        1e-3,
        "proportional",
    );
    near(value(&draft, "controller", "position_gain_per_s"), 6.5, 1e-3, "position gain");
    near(value(&draft, "controller", "velocity_feedforward"), 0.7, 1e-3, "feed-forward");
    near(value(&draft, "guide", "viscous_n_s_per_m"), 333.3, 1e-2, "viscous");
    near(value(&draft, "encoder", "resolution_m"), 1e-7, 1e-3, "resolution");
    near(value(&draft, "encoder", "noise_m"), 3e-8, 0.2, "noise");
    near(draft.coulomb.as_ref().unwrap().value.as_ref().unwrap().parse().unwrap(), 15.0, 1e-2, "Coulomb");
    let winding = found.winding.unwrap();
    near(winding.resistance.value, 1.3, 3e-3, "R");
    near(winding.inductance.value, 8e-3, 3e-3, "L");
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("machine");
    write(&draft, None, None, &place).unwrap();
    let diagnosis = quick(&Machine::read(&place).unwrap(), &recording);
    assert_eq!(diagnosis.verdict, Verdict::Cause);
    let names: Vec<&str> = diagnosis.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!(names, ["coulomb_friction"]);
    near(diagnosis.causes[0].parameters["force_n"].value, 15.0, 0.02, "Coulomb friction");
}

#[test]
fn ref_a_measured_axis_comes_to_coulomb_friction_from_four_numbers() {
    let log = needs!(support::data("emps/emps_estimation.csv")).join("emps/emps_estimation.csv");
    let maps: Vec<MappedColumn> =
        ["drive_cmd_V=control_effort_v:V"].iter().map(|map| map.parse().unwrap()).collect();
    let context = LogContext { maps: &maps, motion: Motion::Prismatic, sample_period_s: 1e-3 };
    let recording = Recording::read_logs(&[log], &context).unwrap();
    // Four numbers: what a volt makes, where the drive clips, both ends of the travel.
    // Published: the first is the gain of drive, motor and screw together.
    let sheet = Sheet {
        force_per_volt: Some(35.150_651_882_485_47),
        voltage_limit: Some(10.0),
        stroke: Some([-0.05, 0.35]),
        ..Sheet::default()
    };
    let found = findings(&recording, sheet.voltage_limit).unwrap();
    let draft = Draft::of(&recording, &found, &sheet, None);
    assert_eq!(draft.lacks, []);
    near(value(&draft, "axis.urdf", "mass"), 95.1089, 0.01, "mass");
    near(value(&draft, "guide", "viscous_n_s_per_m"), 203.5, 0.05, "viscous");
    near(draft.coulomb.as_ref().unwrap().value.as_ref().unwrap().parse().unwrap(), 20.39, 0.06, "Coulomb");
    near(value(&draft, "controller", "position_gain_per_s"), 160.18, 0.01, "position gain");
    near(value(&draft, "controller", "velocity_gain_v_s_per_m"), 243.45, 0.01, "velocity gain");
    near(value(&draft, "encoder", "resolution_m"), 5e-8, 1e-3, "resolution");
    let LawFound::Law(law) = &found.law else { panic!("{:?}", found.law) };
    assert_eq!(law.form, Form::Level);
    assert_eq!(law.velocity, VelocityEstimate::Taps { taps: vec![0.5, 0.0, -0.5], time_constant_s: 0.0 });
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("machine");
    write(&draft, None, None, &place).unwrap();
    let diagnosis = quick(&Machine::read(&place).unwrap(), &recording);
    assert_eq!(diagnosis.causes.first().map(|cause| cause.effect.as_str()), Some("coulomb_friction"));
}

#[test]
fn exact_mass_and_force_constant_are_one_number_without_a_sheet() {
    let recording = as_logged(&Recording::read(shipped()).unwrap());
    let found = findings(&recording, None).unwrap();
    let draft = Draft::of(&recording, &found, &Sheet::default(), None);
    let flags: Vec<&str> = draft.lacks.iter().map(|lack| lack.flag).collect();
    assert_eq!(flags, ["--force-constant"]);
    assert!(
        draft.lacks[0].why.contains("only their ratio, 0.617") && draft.lacks[0].why.contains("--mass kg")
    );
    let folder = tempfile::tempdir().unwrap();
    assert!(write(&draft, None, None, &folder.path().join("machine")).is_err());
    assert!(!folder.path().join("machine").exists());
    // Either of them tells the other.
    for (sheet, of) in [
        (Sheet { mass: Some(51.28), ..Sheet::default() }, ("motor", "force_constant_n_per_a", 83.1)),
        (Sheet { force_constant: Some(83.1), ..Sheet::default() }, ("axis.urdf", "mass", 51.28)),
    ] {
        let draft = Draft::of(&recording, &found, &sheet, None);
        assert_eq!(draft.lacks, []);
        near(value(&draft, of.0, of.1), of.2, 2e-3, of.1);
        let item = draft.items.iter().find(|item| (item.table, item.key) == (of.0, of.1)).unwrap();
        assert_eq!(item.mark, Mark::Measured);
    }
}

/// A motion with everything in it, and what a law commands along it.
fn commanded(law: &Controller, estimate: &VelocityEstimate) -> Recording {
    let period = 5e-4;
    let motion = |t: f64| 0.05 * (3.0 * t).sin() + 0.01 * (17.0 * t).sin() + 0.004 * (61.0 * t).cos();
    let lag = |t: f64| 2e-4 * (23.0 * t).sin() + 1e-4 * (97.0 * t).cos();
    let mut memory = Memory::default();
    let mut sensor = VelocityMemory::moving(motion(0.0) - lag(0.0), 0.0, period);
    let mut signals: BTreeMap<Signal, Vec<f64>> = BTreeMap::new();
    for k in 0..4000 {
        let t = f64::from(k) * period;
        let (reference, position) = (motion(t), motion(t) - lag(t));
        let input = Input {
            position_reference: reference,
            velocity_reference: (reference - motion(t - period)) / period,
            position,
            velocity: estimate.update(&mut sensor, position, period),
        };
        for (signal, sample) in [
            (Signal::PositionReference, reference),
            (Signal::Position, position),
            (Signal::ControlEffort, law.effort_v(&mut memory, input, period)),
        ] {
            signals.entry(signal).or_default().push(sample);
        }
    }
    Recording::new(vec![Run::new("a", Motion::Prismatic, period, signals).unwrap()]).unwrap()
}

#[test]
fn exact_the_law_is_told_from_its_effort() {
    let cascade = |integral: f64| {
        Controller::Cascade(Cascade {
            position_gain_per_s: 40.0,
            velocity_gain_v_s_per_m: 25.0,
            velocity_integral_per_s: integral,
            velocity_feedforward: 0.6,
            effort_limit_v: None,
            anti_windup: AntiWindup::None,
            filter: Vec::new(),
        })
    };
    let pdf = Controller::Pdf(Pdf {
        integral: 1.into(),
        proportional: 1.into(),
        integral_gain_per_count: 900.0,
        proportional_gain_per_count: 30.0,
        velocity_units_per_si: 1.0,
        position_gain_per_s: 12.0,
        velocity_feedforward: 0.7,
        filter: Vec::new(),
    });
    let p = Controller::Pd(Pd {
        position_gain_v_per_m: 300.0,
        derivative_gain_v_s_per_m: 0.0,
        velocity_feedforward: 0.0,
        filter: Vec::new(),
    });
    let smoothed = VelocityEstimate::SmoothedDifference { time_constant_s: 1.3e-3 };
    let taps = VelocityEstimate::Taps { taps: vec![0.3, 0.1, -0.1, -0.3], time_constant_s: 0.0 };
    for (law, estimate, form) in [
        (p, &taps, Form::P),
        (cascade(0.0), &smoothed, Form::Level),
        (pdf, &smoothed, Form::Pdf),
        (cascade(60.0), &taps, Form::Pi),
    ] {
        let Findings { law: LawFound::Law(found), .. } = findings(&commanded(&law, estimate), None).unwrap()
        else {
            panic!("no law for {form:?}")
        };
        assert_eq!(found.form, form);
        let (told, truth) = (found.controller.gains(5e-4), law.gains(5e-4));
        for (told, truth) in [
            (told.position, truth.position),
            (told.feedforward, truth.feedforward),
            (told.integral, truth.integral),
            (told.error, truth.error),
            (told.velocity, truth.velocity),
        ] {
            assert!((told - truth).abs() < 1e-3 * truth.abs().max(1e-3), "{form:?}: {told} for {truth}");
        }
        if form != Form::P {
            near(
                found.velocity.time_constant_s() + 1.0,
                estimate.time_constant_s() + 1.0,
                1e-5,
                "time constant",
            );
        }
    }
}

/// A log as a drive exports it: other names, other units.
fn exported(folder: &Path) -> PathBuf {
    let recording = Recording::read(shipped()).unwrap();
    let run = &recording.runs()[1];
    let mut text = "Time [ms],pos_set [mm],pos_act [mm],ControlEffort [V],Iq [A]\n".to_owned();
    let of = |signal: Signal, k: usize| run.signal(signal).unwrap()[k];
    for k in 0..run.len() {
        writeln!(
            text,
            "{},{},{},{},{}",
            0.25 * k as f64,
            1e3 * of(Signal::PositionReference, k),
            1e3 * of(Signal::Position, k),
            of(Signal::ControlEffort, k),
            of(Signal::Current, k)
        )
        .unwrap();
    }
    let path = folder.join("day1.csv");
    std::fs::write(&path, text).unwrap();
    path
}

fn slideway(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_slideway"))
        .args(arguments)
        .current_dir(folder)
        .env("COLUMNS", "80")
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat();
    (output.status.code(), text)
}

#[test]
fn exact_a_new_user_is_told_what_is_missing_and_gets_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    exported(folder.path());
    let (code, text) = slideway(folder.path(), &["init", "day1.csv"]);
    assert_eq!(code, Some(2), "{text}");
    for told in [
        "prismatic",
        "Nothing was written",
        "--force-constant N/A",
        "slideway init day1.csv --force-constant N/A",
    ] {
        assert!(text.contains(told), "{told} is not in\n{text}");
    }
    assert!(!folder.path().join("day1_axis").exists());
    let (code, text) = slideway(folder.path(), &["init", "day1.csv", "--force-constant", "83.1"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("slideway diagnose day1_axis"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    let recording = Recording::read(folder.path().join("day1_axis")).unwrap();
    assert_eq!(recording.runs().len(), 1);
    let machine = Machine::read(recording.machine.as_ref().unwrap()).unwrap();
    near(machine.constants().moving_mass, 51.28, 3e-3, "mass");
    let file = std::fs::read_to_string(folder.path().join("day1_axis/machine/machine.toml")).unwrap();
    let is_number = |line: &&str| line.contains(" = ") && !line.starts_with('#');
    for line in file.lines().filter(is_number) {
        assert!(line.contains("# measured") || line.contains("# assumed"), "no mark: {line}");
    }
    // What stands there stays.
    let (code, text) = slideway(folder.path(), &["init", "day1.csv", "--force-constant", "83.1"]);
    assert!(code == Some(2) && text.contains("--out"), "{text}");
}

#[test]
fn exact_of_several_joints_one_is_to_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    exported(folder.path());
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"5\"/>\
             <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>"
        )
    };
    let joint = |name: &str, kind: &str, parent: &str, child: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>\
             <axis xyz=\"1 0 0\"/></joint>"
        )
    };
    let links = ["a", "b", "c"].map(link).concat();
    let joints = joint("slide", "prismatic", "a", "b") + &joint("tool", "continuous", "b", "c");
    std::fs::write(folder.path().join("robot.urdf"), format!("<robot name=\"r\">{links}{joints}</robot>"))
        .unwrap();
    let arguments = ["init", "day1.csv", "--urdf", "robot.urdf"];
    let (code, text) = slideway(folder.path(), &arguments);
    assert_eq!(code, Some(2));
    for told in ["slide (prismatic)", "tool (continuous)", "--joint slide"] {
        assert!(text.contains(told), "{told} is not in\n{text}");
    }
    let (code, text) = slideway(folder.path(), &[&arguments[..], &["--joint", "slide"]].concat());
    assert_eq!(code, Some(0), "{text}");
    let machine = Machine::read(&folder.path().join("day1_axis/machine")).unwrap();
    assert_eq!(machine.description().held_joints, ["tool"]);
    assert!((machine.constants().moving_mass - 10.0).abs() < 1e-9);
    assert!(text.contains("where 10 kg is stated") || text.contains("force_constant_n_per_a"), "{text}");
}

#[test]
fn exact_faults_of_columns_are_told_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, "time_s,pos,u\n".to_owned() + &"0,1,2\n".repeat(200)).unwrap();
    let context = LogContext { maps: &[], motion: Motion::Prismatic, sample_period_s: 1e-3 };
    let error = Recording::read_logs(&[path], &context).unwrap_err();
    let text = format!("{} {}", error.statement(), error.remedy_text().unwrap());
    for told in ["2 columns", "'pos=position_m:m'", "'u=control_effort_v:V'"] {
        assert!(text.contains(told), "{told} is not in {text}");
    }
}
