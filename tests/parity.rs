//! The axis plant against the rigid-body scene, and both against the published behaviour.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::plant::rapier::Rig;
use slideway::replay::{Motion, Stroke, Traces, follow, run};
use slideway::twin::{Sensing, Twin};
use std::path::Path;

/// The eight cells of the paper: six of its Table 1, then the two of Figs. 6 and 7 (m, m/min).
const CELLS: [(f64, f64); 8] = [
    (0.02, 4.0),
    (0.03, 4.0),
    (0.03, 8.0),
    (0.04, 8.0),
    (0.04, 16.0),
    (0.05, 16.0),
    (0.02, 8.0),
    (0.03, 16.0),
];
/// The encoder's step: the plants must agree to better than what a sensor could see.
const ENCODER_STEP_M: f64 = 1e-7;

fn grinder() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

fn reference(machine: &Machine, (stroke, feed): (f64, f64)) -> Vec<f64> {
    let motion = Motion {
        strokes: vec![Stroke::metres_at_metres_per_minute(stroke, feed).unwrap()],
        lead_s: 0.02,
        dwell_s: 0.6,
        ramp_s: machine.description().reference.acceleration_time_s,
    };
    motion.reference(machine.description().sample_period_s)
}

fn on_axis(machine: &Machine, reference: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

fn on_rapier(machine: &Machine, reference: &[f64]) -> Traces {
    let mut twin = Twin::new(machine, Rig::new(machine).unwrap(), Sensing::Perfect);
    let period = twin.period_s();
    run(&mut twin, follow(reference, period), |_| ())
}

fn rms_difference(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>() / a.len() as f64).sqrt()
}

fn assert_parity(machine: &Machine, cells: &[(f64, f64)]) {
    for &cell in cells {
        let reference = reference(machine, cell);
        let (axis, rapier) = (on_axis(machine, &reference), on_rapier(machine, &reference));
        let position = rms_difference(&axis.position, &rapier.position);
        let velocity = rms_difference(&axis.velocity, &rapier.velocity);
        let thrust = rms_difference(&axis.thrust, &rapier.thrust);
        println!("{cell:?}: position {position:.2e} m, velocity {velocity:.2e} m/s, thrust {thrust:.2e} N");
        assert!(position <= ENCODER_STEP_M, "{cell:?}: {position:e} m");
    }
}

#[test]
fn ref_axis_and_rigid_body_scene_agree_on_all_cells() {
    assert_parity(&grinder(), &CELLS);
}

#[test]
fn ref_axis_and_rigid_body_scene_agree_with_friction() {
    let machine = grinder();
    let settings = [("effect.coulomb_friction.force_n", toml::Value::Float(15.0))];
    assert_parity(&machine.with_settings(settings).unwrap(), &CELLS);
    let asymmetric = [
        ("effect.asymmetric_friction.coulomb_positive_n", toml::Value::Float(8.0)),
        ("effect.asymmetric_friction.coulomb_negative_n", toml::Value::Float(14.0)),
        ("effect.asymmetric_friction.viscous_positive_n_s_per_m", toml::Value::Float(300.0)),
        ("effect.asymmetric_friction.viscous_negative_n_s_per_m", toml::Value::Float(420.0)),
        ("effect.payload.mass_kg", toml::Value::Float(9.0)),
        ("effect.constant_force.force_n", toml::Value::Float(5.0)),
        ("effect.loop_delay.delay_s", toml::Value::Float(400e-6)),
    ];
    assert_parity(&machine.with_settings(asymmetric).unwrap(), &CELLS[4..]);
}

/// Position overshoot, peak velocity over the feed and most negative velocity, in % of stroke and feed.
fn overshoots(machine: &Machine, cell: (f64, f64)) -> [f64; 3] {
    let traces = on_axis(machine, &reference(machine, cell));
    let feed = cell.1 / 60.0;
    let most = |values: &[f64]| values.iter().copied().fold(f64::MIN, f64::max);
    let least = |values: &[f64]| values.iter().copied().fold(f64::MAX, f64::min);
    [
        100.0 * (most(&traces.position) / cell.0 - 1.0).max(0.0),
        100.0 * (most(&traces.velocity) / feed - 1.0),
        100.0 * least(&traces.velocity) / feed,
    ]
}

/// One row of the physics sheet's table: cell, then overshoots with 19/260 and with 22/220.
type Row = ((f64, f64), [f64; 3], [f64; 3]);
const SHEET: [Row; 3] = [
    ((0.02, 8.0), [4.09, 0.76, -3.15], [0.0, -0.8, 0.0]),
    ((0.03, 16.0), [4.36, -7.1, -2.52], [0.0, -2.8, 0.0]),
    ((0.05, 16.0), [3.79, 3.98, -3.65], [0.0, -0.2, 0.0]),
];
/// Half a digit of the sheet's one-decimal figures, plus the base modes' stated 0.02.
const SHEET_TOLERANCE: f64 = 0.07;

#[test]
fn ref_published_overshoots_and_their_cure() {
    let stated = grinder();
    let retuned = stated
        .with_settings([
            ("controller.integral", toml::Value::Integer(22)),
            ("controller.proportional", toml::Value::Integer(220)),
        ])
        .unwrap();
    for (cell, before, after) in SHEET {
        for (machine, expected) in [(&stated, before), (&retuned, after)] {
            let found = overshoots(machine, cell);
            for (e, f) in expected.iter().zip(found) {
                assert!((e - f).abs() < SHEET_TOLERANCE, "{cell:?}: expected {expected:?}, found {found:?}");
            }
        }
    }
}
