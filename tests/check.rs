//! Checks of the data: each fault put into a recording is found and told, and clean recordings raise no warning.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stderr)]

use slideway::diagnose::check::{Check, Finding, Severity, check};
use slideway::diagnose::experiment::Experiment;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::recording::recorded;
use slideway::replay::{Motion, PlantChoice, Stroke, run_seed, simulate};
use slideway::twin::Sensing;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const GRINDER: &str = "models/grinder";
const EMPS: &str = "models/emps";

fn machine(path: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

fn set(machine: &Machine, settings: &[(&str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, value)| (*key, toml::Value::Float(*value)))).unwrap()
}

/// Stroke (m), feed (m/min) and role of each run.
const CELLS: [(f64, f64, Role); 3] =
    [(0.03, 8.0, Role::Training), (0.04, 16.0, Role::Training), (0.02, 8.0, Role::HeldOut)];

/// Runs of a machine with noise as stated; `legs` are shares of each stroke, one after the other.
fn runs_of(real: &Machine, cells: &[(f64, f64, Role)], legs: &[f64]) -> Vec<Run> {
    cells
        .iter()
        .map(|&(stroke, feed, role)| {
            let whole = Stroke::metres_at_metres_per_minute(stroke, feed).unwrap();
            let strokes = legs.iter().map(|share| Stroke { stroke: share * whole.stroke, ..whole }).collect();
            let motion = Motion { strokes, lead_s: 0.1, dwell_s: 0.3, ramp_s: 0.02 };
            let mut reference = motion.reference(real.description().sample_period_s);
            if legs.is_empty() {
                reference.resize(2000, 0.0);
            }
            let name = format!("stroke{:.0}_feed{feed:.0}", stroke * 1e3);
            let sensing = Sensing::AsStated { seed: run_seed(7, &name) };
            let traces = simulate(real, PlantChoice::Axis, sensing, &reference, |_| ()).unwrap();
            let mut run = recorded(&name, real, &reference, traces).unwrap();
            run.role = Some(role);
            run
        })
        .collect()
}

fn clean() -> Vec<Run> {
    runs_of(&machine(GRINDER), &CELLS, &[1.0, -1.0])
}

type Signals = BTreeMap<Signal, Vec<f64>>;

/// The runs with their signals changed.
fn changed(runs: &[Run], change: impl Fn(&mut Signals)) -> Vec<Run> {
    runs.iter()
        .map(|run| {
            let mut signals = run.signals().clone();
            change(&mut signals);
            let mut altered = Run::new(run.name(), run.motion(), run.sample_period_s(), signals).unwrap();
            altered.role = run.role;
            altered
        })
        .collect()
}

fn findings(machine: &Machine, runs: &[Run]) -> Vec<Finding> {
    let of = |role| -> Vec<Experiment> {
        let chosen = runs.iter().filter(|run| run.role == Some(role));
        chosen.map(|run| Experiment::new(run, machine).unwrap()).collect()
    };
    let found = check(machine, &of(Role::Training), &of(Role::HeldOut));
    for finding in &found {
        assert!(finding.message.ends_with('.') && !finding.message.contains("NaN"), "{}", finding.message);
    }
    found
}

fn warnings(found: &[Finding]) -> Vec<&Finding> {
    found.iter().filter(|finding| finding.severity == Severity::Warning).collect()
}

fn with(found: &[Finding], check: Check) -> Vec<&Finding> {
    found.iter().filter(|finding| finding.check == check).collect()
}

/// The signal as a channel that lies `samples` behind logs it.
fn delayed(signal: &[f64], samples: f64) -> Vec<f64> {
    let at = |k: isize| signal[k.clamp(0, signal.len() as isize - 1) as usize];
    let (whole, rest) = (samples.floor() as isize, samples.fract());
    (0..signal.len() as isize).map(|k| (1.0 - rest) * at(k - whole) + rest * at(k - whole - 1)).collect()
}

#[test]
fn scratch() {
    let m = machine(GRINDER);
    let show = |title: &str, found: &[Finding]| {
        eprintln!("== {title}");
        for f in found.iter().filter(|f| f.check != Check::MissingSignal) {
            eprintln!("   {:?} {:?} [{}] {}", f.severity, f.check, f.run, f.message);
        }
    };
    show("clean", &findings(&m, &clean()));
    for signal in [
        Signal::Current,
        Signal::Thrust,
        Signal::ControlEffort,
        Signal::Position,
        Signal::Velocity,
        Signal::PositionReference,
    ] {
        for d in [1.0, 2.0, 1.6] {
            let runs = changed(&clean(), |s| {
                let x = delayed(&s[&signal], d);
                s.insert(signal, x);
            });
            show(&format!("{signal} late {d}"), &findings(&m, &runs));
        }
    }
    for settings in [
        vec![("effect.loop_delay.delay_s", 400e-6)],
        vec![("effect.coulomb_friction.force_n", 60.0)],
        vec![("effect.payload.mass_kg", 8.0)],
        vec![("effect.constant_force.force_n", 40.0)],
        vec![("effect.viscous_friction.viscous_n_s_per_m", 900.0)],
        vec![("controller.integral", 25.0)],
        vec![("controller.position_gain_per_s", 10.0)],
        vec![("motor.inductance_h", 12e-3)],
        vec![("motor.force_constant_n_per_a", 60.0)],
        vec![("encoder.velocity.time_constant_s", 1.5e-3)],
    ] {
        let real = m
            .with_settings(settings.iter().map(|(k, v)| {
                (
                    *k,
                    if k.ends_with("integral") {
                        toml::Value::Integer(*v as i64)
                    } else {
                        toml::Value::Float(*v)
                    },
                )
            }))
            .unwrap();
        show(&format!("{settings:?}"), &findings(&m, &runs_of(&real, &CELLS, &[1.0, -1.0])));
    }
    for signal in [Signal::Current, Signal::Thrust, Signal::ControlEffort, Signal::Velocity, Signal::Position]
    {
        let runs = changed(&clean(), |s| {
            for x in s.get_mut(&signal).unwrap() {
                *x = -*x;
            }
        });
        show(&format!("{signal} swapped"), &findings(&m, &runs));
        let runs = changed(&clean(), |s| {
            for x in s.get_mut(&signal).unwrap() {
                *x *= 1e3;
            }
        });
        if signal != Signal::Position {
            show(&format!("{signal} x1000"), &findings(&m, &runs));
        }
    }
    let e = machine(EMPS);
    let rec =
        Recording::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps/recording.toml")).unwrap();
    show("emps", &findings(&e, rec.runs()));
    let runs = changed(rec.runs(), |s| {
        let x = delayed(&s[&Signal::ControlEffort], 2.0);
        s.insert(Signal::ControlEffort, x);
    });
    show("emps effort late 2", &findings(&e, &runs));
    let runs = changed(rec.runs(), |s| {
        let x = delayed(&s[&Signal::Position], 2.0);
        s.insert(Signal::Position, x);
    });
    show("emps pos late 2", &findings(&e, &runs));
}
