//! Replays as recordings, and the identification of the moving part from the solid model.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::Path;

use crate::support::{self, needs};
use slideway::drive::printed::{self, Variant};
use slideway::identify::arx::{ArxModel, Orders, arx};
use slideway::identify::decimation;
use slideway::identify::excitation::Outcome;
use slideway::identify::first_order::FirstOrder;
use slideway::identify::transfer::TransferFunction;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::recording::{Existing, Format, Recording, Run, Signal};
use slideway::replay::excitation::Excitation;
use slideway::replay::recording::{SLIDER_COLUMNS, recorded};
use slideway::replay::{Cell, Figures, Motion, PlantChoice, Recorded, follow, run, run_seed, simulate};
use slideway::solid::GRAVITY_M_PER_S2;
use slideway::twin::{Sensing, Twin};
use slideway::units;
use tempfile::TempDir;

const FIRST_ORDER: Orders = Orders { na: 1, nb: 1, delay: 1 };
/// W(z) is published with two digits; the machine's mass and drag were derived from exactly these.
const PUBLISHED_TOLERANCE: f64 = 0.005;
/// The published W(z) = 0.45/(z − 0.85), mm/s per N at 25 ms.
const PUBLISHED_GAIN: f64 = 0.45;
const PUBLISHED_POLE: f64 = 0.85;
/// Scene and exact solution differ by rounding, accumulated over 400 000 steps.
const ROUNDING: f64 = 1e-6;
/// Figures of Fig. 6 are read to one decimal of a per cent.
const FIGURE_TOLERANCE: f64 = 0.0007;
/// 1.8 m/min: an excitation below the machine's slowest published feed (4 m/min) by half would show friction only.
const LEAST_SPEED_M_PER_S: f64 = 0.03;

fn grinder() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

fn identified(plant: PlantChoice, period_s: f64) -> ArxModel {
    let excited = Excitation { period_s, samples: 1000, seed: 7 }.run(&grinder(), plant).unwrap();
    let velocity: Vec<f64> = excited.velocity.iter().map(|v| 1000.0 * v).collect();
    let Outcome::Identified(model) = arx(&excited.force, &velocity, period_s, FIRST_ORDER).unwrap() else {
        panic!("random levels must excite");
    };
    model
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "found {found}, expected {expected}");
}

#[test]
fn ref_worktable_transfer_function_comes_out_of_the_rigid_body_scene() {
    let model = identified(PlantChoice::Rapier, 0.025);
    assert_near(-model.a[0].value, PUBLISHED_POLE, PUBLISHED_TOLERANCE);
    assert_near(model.b[0].value, PUBLISHED_GAIN, PUBLISHED_TOLERANCE);
    let lag = FirstOrder::of(&model, 1000.0).unwrap();
    assert_near(lag.inertia.value, 51.28, PUBLISHED_TOLERANCE);
    assert_near(lag.viscous_coefficient.value, 333.3, PUBLISHED_TOLERANCE);
}

#[test]
fn exact_identified_lag_is_the_held_force_solution_at_both_periods_on_both_plants() {
    let constants = grinder().constants();
    let (m, c) = (constants.moving_mass, constants.viscous);
    for period_s in [0.025, 250e-6] {
        let pole = (-c * period_s / m).exp();
        for plant in [PlantChoice::Rapier, PlantChoice::Axis] {
            let model = identified(plant, period_s);
            assert_near(-model.a[0].value, pole, ROUNDING);
            assert_near(model.b[0].value, 1000.0 * -(-c * period_s / m).exp_m1() / c, ROUNDING);
        }
    }
}

#[test]
fn exact_excitation_stays_within_the_limits_of_the_joint() {
    let machine = grinder();
    let joint = &machine.solid().joint;
    for seed in 0..5 {
        let excited =
            Excitation { period_s: 0.025, samples: 1000, seed }.run(&machine, PlantChoice::Axis).unwrap();
        let (mut place, mut before) = (0.0, 0.0);
        for velocity in &excited.velocity {
            place += 0.5 * 0.025 * (before + velocity);
            before = *velocity;
            assert!(velocity.abs() <= joint.velocity && (joint.lower..=joint.upper).contains(&place));
        }
        assert!(excited.force.iter().all(|force| force.abs() <= joint.effort));
        // Drift along the travel, not speed, is what limits it; still feeds as in the machine's own strokes.
        let fastest = excited.velocity.iter().fold(0.0_f64, |fastest, v| fastest.max(v.abs()));
        assert!(fastest > LEAST_SPEED_M_PER_S, "seed {seed}: {fastest} m/s");
    }
}

#[test]
fn exact_constant_excitation_is_refused() {
    let machine = grinder();
    let excited =
        Excitation { period_s: 0.025, samples: 200, seed: 1 }.run(&machine, PlantChoice::Axis).unwrap();
    let constant = vec![100.0; excited.force.len()];
    let Outcome::NotExcited(why) = arx(&constant, &excited.velocity, 0.025, FIRST_ORDER).unwrap() else {
        panic!("a constant force excites nothing");
    };
    assert!(why.remedy.contains("keeps changing"));
}

#[test]
fn exact_period_that_is_none_is_refused() {
    for period_s in [0.0, -1.0, f64::NAN] {
        let excitation = Excitation { period_s, samples: 10, seed: 1 };
        let error = excitation.run(&grinder(), PlantChoice::Axis).unwrap_err();
        assert_eq!(error.key_name(), Some("period"));
    }
}

#[test]
fn ref_printed_plant_comes_out_of_the_published_numbers() {
    // Eq. (11) of the paper and the same with the sign of R·T put right.
    let expected =
        [(Variant::AsPrinted, 1.218, -1.892, 0.886), (Variant::Corrected, 1.1230, -1.8110, 0.8168)];
    let worktable = TransferFunction::new(vec![0.0, 0.45], vec![1.0, -0.85], 250e-6).unwrap();
    for (variant, gain, a1, a2) in expected {
        let plant = printed::plant(variant, &worktable, 1.3, 8e-3, 83.1).unwrap();
        assert!((plant.numerator()[1] - gain).abs() < 5e-4, "{plant}");
        assert!((plant.denominator()[1] - a1).abs() < 5e-4, "{plant}");
        assert!((plant.denominator()[2] - a2).abs() < 5e-4, "{plant}");
    }
}

#[test]
fn exact_lag_survives_decimation_of_a_held_input() {
    let lag = TransferFunction::new(vec![0.0, 0.2], vec![1.0, -0.98], 1e-3).unwrap();
    let input: Vec<f64> = (0..4000).map(|k| f64::from((k / 10) * (k / 10) % 17)).collect();
    let output = lag.simulate(&input);
    let (input, output) = decimation::decimate(&input, &output, decimation::factor(1e-3, 0.01).unwrap());
    let Outcome::Identified(model) = arx(&input, &output, 0.01, FIRST_ORDER).unwrap() else { panic!() };
    assert_near(-model.a[0].value, 0.98f64.powi(10), 1e-9);
    assert_near(model.b[0].value, 10.0 * (1.0 - 0.98f64.powi(10)), 1e-9);
}

#[test]
fn exact_decimation_to_no_whole_multiple_is_refused() {
    for period_s in [0.0015, 0.0004, 0.0, f64::NAN] {
        assert!(decimation::factor(1e-3, period_s).is_err(), "{period_s}");
    }
}

fn motion_of(machine: &Machine, cell: &str) -> Motion {
    let stroke = cell.parse::<Cell>().unwrap().stroke(machine.motion()).unwrap();
    Motion {
        strokes: vec![stroke],
        lead_s: 0.05,
        dwell_s: 0.6,
        ramp_s: machine.description().reference.acceleration_time_s,
    }
}

fn replayed(machine: &Machine, plant: PlantChoice, cell: &str, name: &str) -> (Run, Figures) {
    let motion = motion_of(machine, cell);
    let period_s = machine.description().sample_period_s;
    let reference = motion.reference(period_s);
    let sensing = Sensing::AsStated { seed: run_seed(1, name) };
    let traces = simulate(machine, plant, sensing, &reference, |_| ()).unwrap();
    let figures = Figures::of(&motion, period_s, &traces);
    (recorded(name, machine, &reference, traces).unwrap(), figures)
}

#[test]
fn ref_figure_6_overshoots_and_its_cure_on_the_rigid_body_scene() {
    let machine = grinder();
    let motion = motion_of(&machine, "0.02@8");
    let period_s = machine.description().sample_period_s;
    let figures = |machine: &Machine| {
        let reference = motion.reference(period_s);
        let traces = simulate(machine, PlantChoice::Rapier, Sensing::Perfect, &reference, |_| ()).unwrap();
        Figures::of(&motion, period_s, &traces)
    };
    let stated = figures(&machine);
    assert!((stated.overshoot - 0.0409).abs() < FIGURE_TOLERANCE, "{stated:?}");
    assert!((stated.peak_velocity - 0.0076).abs() < FIGURE_TOLERANCE, "{stated:?}");
    assert!((stated.most_negative_velocity + 0.0315).abs() < FIGURE_TOLERANCE, "{stated:?}");
    let settings = [
        ("controller.integral", toml::Value::Integer(22)),
        ("controller.proportional", toml::Value::Integer(220)),
    ];
    let cured = figures(&machine.with_settings(settings).unwrap());
    assert!(cured.overshoot < FIGURE_TOLERANCE, "{cured:?}");
    assert!(cured.most_negative_velocity > -FIGURE_TOLERANCE, "{cured:?}");
}

#[test]
fn exact_return_stroke_counts_like_one_forth() {
    let machine = grinder();
    let (_, forth) = replayed(&machine, PlantChoice::Axis, "0.02@8", "forth");
    let (_, back) = replayed(&machine, PlantChoice::Axis, "-0.02@8", "back");
    // The machine is symmetric; sensor noise is not.
    assert!((forth.overshoot - back.overshoot).abs() < 1e-3, "{forth:?} {back:?}");
    assert!((forth.peak_thrust / back.peak_thrust - 1.0).abs() < 1e-2, "{forth:?} {back:?}");
    assert!(forth.settling_s.is_some() && back.settling_s.is_some());
}

#[test]
fn exact_replay_reads_back_equal_from_csv_and_parquet() {
    let machine = grinder();
    let folder = TempDir::new().unwrap();
    for (plant, format, file) in [
        (PlantChoice::Rapier, Format::Csv, "a"),
        (PlantChoice::Rapier, Format::Parquet, "b"),
        (PlantChoice::Axis, Format::Csv, "c"),
    ] {
        let (mut run, _) = replayed(&machine, plant, "0.03@16", "stroke030_feed16");
        run.settings.insert("controller.integral".to_owned(), toml::Value::Integer(22));
        let written = Recording::new(vec![run]).unwrap();
        let place = folder.path().join(file);
        written.write(&place, format, Existing::Refuse).unwrap();
        let read = Recording::read(&place).unwrap();
        let (before, after) = (&written.runs()[0], &read.runs()[0]);
        assert_eq!(before.signals(), after.signals());
        assert_eq!(before.extra_columns(), after.extra_columns());
        assert_eq!(before.settings, after.settings);
        assert_eq!(after.ignored_columns, Vec::<String>::new());
        assert_eq!(after.extra_columns().is_empty(), plant == PlantChoice::Axis);
        assert!(after.signal(Signal::Current).is_some());
    }
}

#[test]
fn exact_slider_loads_at_rest_sum_to_the_weight_in_the_written_file() {
    let machine = grinder();
    let folder = TempDir::new().unwrap();
    let (run, _) = replayed(&machine, PlantChoice::Rapier, "0.02@8", "stroke");
    let place = folder.path().join("recording");
    Recording::new(vec![run]).unwrap().write(&place, Format::Csv, Existing::Refuse).unwrap();
    let text = std::fs::read_to_string(place.join("stroke.csv")).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let weight = machine.constants().moving_mass * GRAVITY_M_PER_S2;
    let columns = SLIDER_COLUMNS.map(|name| header.iter().position(|head| *head == name).unwrap());
    let mut largest_shift = 0.0_f64;
    for line in lines {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let loads = columns.map(|column| cells[column]);
        // The sum is the weight in motion too: the table moves level.
        assert_near(loads.iter().sum(), weight, 1e-9);
        largest_shift = largest_shift.max((loads[0] - loads[1]).abs());
    }
    // Accelerating, the drive's force below the centre of mass shifts load between front and rear.
    assert!(largest_shift > 1.0, "{largest_shift} N");
}

#[test]
fn exact_noise_of_a_run_depends_on_its_name_and_the_seed_only() {
    assert_eq!(run_seed(1, "a"), run_seed(1, "a"));
    assert_ne!(run_seed(1, "a"), run_seed(1, "b"));
    assert_ne!(run_seed(1, "a"), run_seed(2, "a"));
}

#[test]
fn exact_stroke_beyond_the_joint_is_refused() {
    let machine = grinder();
    let reference = motion_of(&machine, "0.5@16").reference(machine.description().sample_period_s);
    let error =
        simulate(&machine, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).expect_err("0.5 m");
    assert_eq!(error.key_name(), Some("table_slide"));
    assert!(error.to_string().contains("shorten the stroke"), "{error}");
}

#[test]
fn exact_faulty_extra_columns_are_refused() {
    let machine = grinder();
    let (run, _) = replayed(&machine, PlantChoice::Axis, "0.02@8", "stroke");
    let length = run.len();
    for (name, samples) in [
        ("position_m", vec![0.0; length]),
        ("time_s", vec![0.0; length]),
        ("a,b", vec![0.0; length]),
        ("", vec![0.0; length]),
        ("load_n", vec![0.0; length - 1]),
        ("load_n", vec![f64::NAN; length]),
    ] {
        let extra = [(name.to_owned(), samples)].into();
        assert!(run.clone().with_extra_columns(extra).is_err(), "{name}");
    }
}

#[test]
fn exact_extra_column_that_is_not_there_is_refused() {
    let folder = TempDir::new().unwrap();
    let toml = "[[run]]\nfile = \"log.csv\"\nextra_columns = [\"load_n\"]\n";
    std::fs::write(folder.path().join("recording.toml"), toml).unwrap();
    std::fs::write(folder.path().join("log.csv"), "time_s,position_m\n0,0.1\n0.001,0.2\n").unwrap();
    let error = Recording::read(folder.path()).unwrap_err();
    assert_eq!(error.key_name(), Some("load_n"));
    std::fs::write(folder.path().join("recording.toml"), toml.replace("[\"load_n\"]", "7")).unwrap();
    let error = Recording::read(folder.path()).unwrap_err();
    assert_eq!((error.row_number(), error.key_name()), (Some(3), Some("run.1.extra_columns")));
}

/// Reads both formats with pandas and prints shape, and the largest difference between them.
const PANDAS: &str = "
import sys, pandas
csv, parquet = pandas.read_csv(sys.argv[1]), pandas.read_parquet(sys.argv[2])
assert list(csv.columns) == list(parquet.columns)
assert (csv.dtypes == 'float64').all() and (parquet.dtypes == 'float64').all()
print(csv.shape[0], csv.shape[1], float((csv - parquet).abs().to_numpy().max()))
";

#[test]
fn ref_pandas_reads_what_replay_writes() {
    let mut python = needs!(support::python("pandas, pyarrow"));
    let folder = TempDir::new().unwrap();
    let (run, _) = replayed(&grinder(), PlantChoice::Rapier, "0.02@8", "stroke");
    let (rows, columns) = (run.len(), 1 + run.signals().len() + run.extra_columns().len());
    let recording = Recording::new(vec![run]).unwrap();
    recording.write(folder.path().join("csv"), Format::Csv, Existing::Refuse).unwrap();
    recording.write(folder.path().join("parquet"), Format::Parquet, Existing::Refuse).unwrap();
    let output = python
        .args(["-c", PANDAS])
        .arg(folder.path().join("csv/stroke.csv"))
        .arg(folder.path().join("parquet/stroke.parquet"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().unwrap()).collect();
    assert_eq!(numbers[..2], [rows as f64, columns as f64]);
    // pandas' own decimal reader may be one unit in the last place off.
    assert!(numbers[2] < 1e-12, "{text}");
}

/// Bristles hold the axis against the motor: a log that is cut at a standstill, or where the axis creeps back, is replayed from its
/// first sample on, once the base has come to rest. Undeflected bristles would let it jump by the motor's force over their stiffness.
#[test]
fn exact_a_log_begins_with_the_friction_that_holds_the_axis() {
    const STIFFNESS: f64 = 5e5;
    let keys =
        [("effect.coulomb_friction.force_n", 20.0), ("effect.presliding.stiffness_n_per_m", STIFFNESS)];
    let machine = grinder().with_settings(keys.map(|(key, value)| (key, toml::Value::Float(value)))).unwrap();
    let period_s = machine.constants().sample_period_s;
    let at = |k: u32| {
        (0.04 * f64::from(k) * period_s).min(0.02) + (0.04 * (f64::from(k) * period_s - 1.5)).max(0.0)
    };
    let reference: Vec<f64> = (0..7200).map(at).collect();
    let mut twin = Twin::new(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let whole = run(&mut twin, follow(&reference, period_s), |_| ());
    for from_s in [0.8, 1.0, 1.2] {
        let from = (from_s / period_s) as usize;
        let signals = [
            (Signal::PositionReference, &reference),
            (Signal::Position, &whole.position),
            (Signal::Velocity, &whole.velocity),
            (Signal::ControlEffort, &whole.effort_v),
            (Signal::Current, &whole.current),
        ];
        let signals =
            signals.map(|(signal, samples)| (signal, samples[from..].to_vec())).into_iter().collect();
        let cut = Run::new("cut", units::Motion::Prismatic, period_s, signals).unwrap();
        let recorded = Recorded::of(&cut, &machine).unwrap();
        let replayed = recorded.replay(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
        let jump = whole.thrust[from].abs() / STIFFNESS;
        let off = replayed.position.iter().zip(&whole.position[from..]).map(|(a, b)| (a - b).abs());
        let worst = off.fold(0.0, f64::max);
        assert!(jump > 1e-5 && worst < 2e-2 * jump, "{from_s} s: {worst} m off, without {jump} m");
    }
}
