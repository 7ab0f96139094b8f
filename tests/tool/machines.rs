//! The machine folders that are shipped: they load, their constants are the published ones, and their
//! README gives the source of every number.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::drive::motor::Circuit;
use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::replay::{Motion, Stroke, follow, run};
use slideway::twin::{Sensing, Twin};
use std::path::{Path, PathBuf};

/// Constants are read as printed: the decimal in the file and the decimal here give the same number.
const EXACT: f64 = 0.0;
/// The moving mass is the sum over meshes whose free dimension is rounded to 0.01 mm: 1 g of 51.28 kg.
const MESH_MASS_KG: f64 = 1e-3;

fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models")
}

fn read(file: &str) -> Machine {
    Machine::read(&models().join(file)).unwrap()
}

fn assert_numbers(machine: &Machine, expected: &[(&str, f64)]) {
    for &(key, value) in expected {
        let found = machine.number(key).unwrap_or_else(|| panic!("{key} is not stated"));
        assert!((found - value).abs() <= EXACT, "{key}: expected {value}, found {found}");
    }
}

/// Physics sheet section 1 and Liu, Lai, Yen (2009).
#[test]
fn ref_published_numbers_of_the_worktable() {
    let machine = read("grinder");
    assert_numbers(
        &machine,
        &[
            ("sample_period_s", 250e-6),
            ("controller.integral", 19.0),
            ("controller.proportional", 260.0),
            ("controller.integral_gain_per_count", 6.942e-2),
            ("controller.proportional_gain_per_count", 2.359e-4),
            ("motor.resistance_ohm", 1.3),
            ("motor.inductance_h", 8e-3),
            ("motor.force_constant_n_per_a", 83.1),
            ("guide.viscous_n_s_per_m", 333.3),
        ],
    );
    let constants = machine.constants();
    assert!((constants.moving_mass - 51.28).abs() < MESH_MASS_KG, "{}", constants.moving_mass);
    let modes: Vec<f64> = constants.modes.as_slice().iter().map(|mode| mode.frequency_hz()).collect();
    assert_eq!(modes, [86.1, 88.69, 134.19, 140.92, 162.86]);
}

/// The worktable's gains are the means of the six cells of the paper's Table 1.
#[test]
fn ref_gains_are_the_means_of_the_published_cells() {
    let k1 = [6.858, 6.858, 6.937, 6.884, 7.037, 7.079].iter().sum::<f64>() / 6.0 * 1e-2;
    let k2 = [2.423, 2.346, 2.308, 2.269, 2.423, 2.385].iter().sum::<f64>() / 6.0 * 1e-4;
    let machine = read("grinder");
    // Printed with four digits: half a unit of the last one.
    assert!((machine.number("controller.integral_gain_per_count").unwrap() - k1).abs() < 0.5e-5);
    assert!((machine.number("controller.proportional_gain_per_count").unwrap() - k2).abs() < 0.5e-7);
}

/// W(z) = 0.45/(z − 0.85), read at 25 ms in mm/s per N, is the table of the machine file.
#[test]
fn exact_worktable_regenerates_the_published_transfer_function() {
    let constants = read("grinder").constants();
    let pole = (-constants.viscous / constants.moving_mass * 25e-3).exp();
    let gain = 1000.0 * (1.0 - pole) / constants.viscous;
    // Both numbers are printed with two decimals.
    assert!((pole - 0.85).abs() < 5e-3 && (gain - 0.45).abs() < 5e-3, "{gain}/(z − {pole})");
}

/// Janot, Gautier, Brunot (2019): drive gain, control law, mass and symmetric friction.
#[test]
fn ref_published_numbers_of_the_ball_screw_axis() {
    let (bare, symmetric) = (read("emps"), read("emps/symmetric.toml"));
    for machine in [&bare, &symmetric] {
        assert_numbers(
            machine,
            &[
                ("sample_period_s", 1e-3),
                ("controller.position_gain_per_s", 160.18),
                ("controller.velocity_gain_v_s_per_m", 243.45),
                ("amplifier.voltage_limit_v", 10.0),
                ("encoder.resolution_m", 5e-8),
            ],
        );
        let constants = machine.constants();
        assert_eq!(constants.moving_mass, 95.1089);
        assert_eq!(constants.circuit, Circuit::Direct { force_per_volt: 35.15065188248547 });
        assert!(constants.modes.is_empty());
    }
    assert_eq!(bare.constants().viscous, 0.0);
    assert!(bare.effects().is_empty());
    let friction = [
        ("guide.viscous_n_s_per_m", 203.5034),
        ("effect.coulomb_friction.force_n", 20.3935),
        ("effect.constant_force.force_n", -3.1648),
    ];
    assert_numbers(&symmetric, &friction);
    assert_eq!(symmetric.effects().len(), 2);
}

/// With the published friction the axis, moved to and fro at a steady feed, needs the published thrusts:
/// Fv·v + Fc + offset one way, −Fv·v − Fc + offset the other.
#[test]
fn exact_steady_thrust_is_the_published_friction() {
    let machine = read("emps/symmetric.toml");
    let feed = 0.1;
    let there = Stroke::new(0.2, feed).unwrap();
    let back = Stroke::new(-0.2, feed).unwrap();
    let motion = Motion { strokes: vec![there, back], lead_s: 0.05, dwell_s: 0.5, ramp_s: 0.1 };
    let mut twin = Twin::new(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let period = twin.period_s();
    let traces = run(&mut twin, follow(&motion.reference(period), period), |_| ());
    // Middle of each stroke: the cascade has settled to a lag that does not change.
    let (forward, reverse) = (1050, 1050 + 2600);
    assert!((traces.velocity[forward] - feed).abs() < 1e-9, "{}", traces.velocity[forward]);
    assert!((traces.velocity[reverse] + feed).abs() < 1e-9, "{}", traces.velocity[reverse]);
    assert!(
        (traces.thrust[forward] - (20.35034 + 20.3935 - 3.1648)).abs() < 1e-6,
        "{}",
        traces.thrust[forward]
    );
    assert!(
        (traces.thrust[reverse] - (-20.35034 - 20.3935 - 3.1648)).abs() < 1e-6,
        "{}",
        traces.thrust[reverse]
    );
}

#[test]
fn exact_unknown_key_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(models().join("emps/machine.toml")).unwrap();
    let line = text.lines().position(|line| line.starts_with("voltage_limit_v")).unwrap() + 1;
    let file = folder.path().join("machine.toml");
    std::fs::write(&file, text.replace("voltage_limit_v", "voltage_limits_v")).unwrap();
    let error = Machine::read(folder.path()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::UnknownKey);
    assert_eq!(error.path(), Some(file.as_path()));
    assert_eq!(error.row_number(), Some(line as u64));
    assert!(error.to_string().contains("voltage_limits_v"), "{error}");
    assert!(error.remedy_text().is_some());
}

/// The key (last part of its path) of every number in a TOML value.
fn numbers(value: &toml::Value, key: &str, found: &mut Vec<String>) {
    match value {
        toml::Value::Table(table) => table.iter().for_each(|(key, value)| numbers(value, key, found)),
        toml::Value::Array(array) => array.iter().for_each(|value| numbers(value, key, found)),
        toml::Value::Float(_) | toml::Value::Integer(_) => found.push(key.to_owned()),
        _ => {}
    }
}

/// The row of a table that names `key` in backticks and ends in a mark.
fn has_row_with_mark(readme: &str, key: &str) -> bool {
    let quoted = format!("`{key}`");
    readme.lines().filter(|line| line.starts_with('|') && line.contains(&quoted)).any(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        cells.iter().any(|cell| ["P", "D", "A", "I"].contains(cell))
    })
}

#[test]
fn exact_readme_marks_the_source_of_every_number() {
    for file in [
        "grinder/machine.toml",
        "emps/machine.toml",
        "emps/symmetric.toml",
        "delta_a3/machine.toml",
        "servo/machine.toml",
        "servo/stiction.toml",
    ] {
        let path = models().join(file);
        let table: toml::Table = toml::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let readme = std::fs::read_to_string(path.with_file_name("README.md")).unwrap();
        let mut stated = Vec::new();
        numbers(&toml::Value::Table(table), "", &mut stated);
        assert!(stated.len() > 5, "{file}: {stated:?}");
        for key in stated {
            assert!(has_row_with_mark(&readme, &key), "{file}: `{key}` has no row with a mark in README.md");
        }
    }
}

#[test]
fn exact_row_without_mark_is_caught() {
    let table = "| key | value | mark |\n|---|---|---|\n| `mass_kg` | 3 | P |\n| `force_n` | 4 | ? |\n";
    assert!(has_row_with_mark(table, "mass_kg"));
    assert!(!has_row_with_mark(table, "force_n"));
    assert!(!has_row_with_mark(table, "delay_s"));
}
