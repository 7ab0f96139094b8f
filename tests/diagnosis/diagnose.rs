//! Diagnoses with known truth: effects hidden in the rigid-body scene, and the real axis whose parameters are
//! published.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use slideway::diagnose::verdict::Parameter;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::error::ErrorKind;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::PlantChoice;
use std::path::Path;

const GRINDER: &str = "models/grinder";

fn machine(path: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// Stroke (m), feed (m/min) and role of each run: four to fit, two never identified on.
const CELLS: [(f64, f64, Role); 6] = [
    (0.03, 4.0, Role::Training),
    (0.03, 8.0, Role::Training),
    (0.04, 16.0, Role::Training),
    (0.05, 16.0, Role::Training),
    (0.02, 8.0, Role::HeldOut),
    (0.03, 16.0, Role::HeldOut),
];

/// Two to fit and two held out, without the slow stroke: what holds of any recording shows on these as well.
const FEW: [(f64, f64, Role); 4] = [CELLS[1], CELLS[2], CELLS[4], CELLS[5]];

fn float(value: f64) -> toml::Value {
    toml::Value::Float(value)
}

/// A recording made in the rigid-body scene with `hidden` settings and the stated noise; `legs` are fractions of
/// each cell's stroke, one after the other.
fn recording_of(hidden: &[(&str, f64)], seed: u64, legs: &[f64]) -> Recording {
    recording_at(&FEW, hidden, seed, legs)
}

fn recording_at(cells: &[(f64, f64, Role)], hidden: &[(&str, f64)], seed: u64, legs: &[f64]) -> Recording {
    let stated = machine(GRINDER);
    let real = stated.with_settings(hidden.iter().map(|(key, value)| (*key, float(*value)))).unwrap();
    let strokes = Strokes {
        plant: PlantChoice::Rapier,
        legs,
        dwell_s: 0.4,
        ..Strokes::both_ways(&stated, &real, seed)
    };
    strokes.recording(cells)
}

/// Strokes there and back.
fn recording(hidden: &[(&str, f64)], seed: u64) -> Recording {
    recording_of(hidden, seed, &[1.0, -1.0])
}

fn report(name: &str, d: &Diagnosis) {
    println!(
        "== {name}: {:?}, G {:.2} -> {:.3}, closed {:.4} [{:.4}, {:.4}], predicted {:.4}",
        d.verdict,
        d.gap.before,
        d.gap.after,
        d.gap.closed,
        d.gap.closed_ci95[0],
        d.gap.closed_ci95[1],
        d.gap.predicted_closed
    );
    for cause in &d.causes {
        println!(
            "   {} p={:.4} closes {:.3} confusable {:?}",
            cause.effect, cause.probability, cause.closes, cause.confusable_with
        );
        for (name, p) in &cause.parameters {
            println!(
                "      {name} = {:.5} [{:.5}, {:.5}] {} (twin {})",
                p.value, p.ci95[0], p.ci95[1], p.unit, p.twin
            );
        }
    }
    for c in &d.calibration {
        println!(
            "   calibration {} = {:.5} ± {:.5}{}",
            c.path,
            c.parameter.value,
            c.parameter.ci95[1] - c.parameter.value,
            if c.at_tolerance { " AT EDGE" } else { "" }
        );
    }
    for r in d.ranking.iter().take(8) {
        println!("   {:?} p={:.4} G={:.3}", r.effects, r.probability, r.held_out_gap);
    }
    for s in &d.gap.signals {
        println!(
            "   {} rms {:.3e} -> {:.3e}, noise {:.3e} {:?}",
            s.signal, s.rms_before, s.rms_after, s.noise, s.noise_source
        );
    }
}

fn run_diagnosis(machine: &Machine, recording: &Recording) -> Diagnosis {
    diagnose(machine, recording, &Options::default()).unwrap()
}

fn named(d: &Diagnosis) -> Vec<&str> {
    d.causes.iter().map(|cause| cause.effect.as_str()).collect()
}

#[test]
fn ref_coulomb_friction_hidden_in_the_rigid_body_scene_is_named() {
    let hidden = [("effect.coulomb_friction.force_n", 15.0)];
    let d = run_diagnosis(&machine(GRINDER), &recording_at(&CELLS, &hidden, 1, &[1.0, -1.0]));
    report("coulomb 15", &d);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["coulomb_friction"]));
    let force = &d.causes[0].parameters["force_n"];
    assert!((force.value / 15.0 - 1.0).abs() < 0.03, "{force:?}");
    assert!(d.gap.closed >= 0.95);
}

#[test]
fn ref_nothing_hidden_is_no_gap() {
    for seed in 2..4 {
        let d = run_diagnosis(&machine(GRINDER), &recording_at(&CELLS, &[], seed, &[1.0, -1.0]));
        report("null", &d);
        assert_eq!((d.verdict, named(&d)), (Verdict::NoGap, vec![]));
        // The plants agree so well that no constant has their difference to explain.
        for constant in &d.calibration {
            let (value, stated) = (constant.parameter.value, constant.parameter.twin);
            let scale = if stated == 0.0 { SOLID_MASS_KG } else { stated };
            assert!(((value - stated) / scale).abs() < CALIBRATED, "{}: {value}", constant.path);
        }
    }
}

/// A machine whose stated bristles fade at half the speed that the twin has by itself, or as an exponential: that is calibrated, not a
/// cause.
#[test]
fn ref_bristles_that_fade_otherwise_are_calibrated() {
    let stated = [
        ("effect.coulomb_friction.force_n", 15.0),
        ("effect.presliding.stiffness_n_per_m", 2e6),
        ("effect.presliding.damping_n_s_per_m", 6e3),
    ];
    let twin = machine(GRINDER).with_settings(stated.map(|(key, value)| (key, value.into()))).unwrap();
    let forms = [("damping_fading", std::f64::consts::LN_2), ("fading_exponent", 1.0)];
    for (name, hidden) in forms {
        let path = format!("effect.presliding.{name}");
        let all: Vec<(&str, f64)> = stated.iter().copied().chain([(path.as_str(), hidden)]).collect();
        let d = run_diagnosis(&twin, &recording_at(&CELLS, &all, 5, &[1.0, -1.0]));
        report(name, &d);
        assert_eq!((d.verdict, named(&d)), (Verdict::NoGap, vec![]), "{name}");
        assert!(d.gap.before > 2.0, "{name}: nothing was there to calibrate: {}", d.gap.before);
        let found = d.calibration.iter().find(|c| c.path == path).unwrap();
        assert!((found.parameter.value - hidden).abs() < 0.05, "{found:?}");
    }
}

/// Moving mass of the table in kg.
const SOLID_MASS_KG: f64 = 51.28;
/// How far constants that are right may be moved, relative: some standard errors of the least certain, the winding's.
const CALIBRATED: f64 = 5e-4;

/// The effects named, their hidden parameters, and the fraction of their size within which they must be found.
type Case = (&'static [&'static str], &'static [(&'static str, f64)], f64);

#[test]
fn ref_a_lighter_table_and_friction_of_one_direction_are_named_with_their_sizes() {
    let cases: [Case; 2] = [
        (&["payload"], &[("payload.mass_kg", -8.0)], 0.03),
        (
            &["asymmetric_friction", "coulomb_friction"],
            &[
                ("coulomb_friction.force_n", 12.0),
                ("asymmetric_friction.coulomb_asymmetry", -1.0 / 3.0),
                ("asymmetric_friction.viscous_asymmetry", -1.0 / 6.0),
            ],
            0.05,
        ),
    ];
    let mut faults = Vec::new();
    for (seed, (effects, parameters, within)) in cases.into_iter().enumerate() {
        let keys: Vec<(String, f64)> =
            parameters.iter().map(|(name, value)| (format!("effect.{name}"), *value)).collect();
        let hidden: Vec<(&str, f64)> = keys.iter().map(|(key, value)| (key.as_str(), *value)).collect();
        let d = run_diagnosis(&machine(GRINDER), &recording(&hidden, 40 + seed as u64));
        report(&format!("{parameters:?}"), &d);
        let mut names = named(&d);
        names.sort_unstable();
        if (d.verdict, &names[..]) != (Verdict::Cause, effects) {
            faults.push(format!("{effects:?}: {:?} {names:?}", d.verdict));
            continue;
        }
        for (key, value) in parameters {
            let (effect, name) = key.split_once('.').unwrap();
            let cause = d.causes.iter().find(|cause| cause.effect == effect).unwrap();
            let found = cause.parameters[name].value;
            if (found / value - 1.0).abs() > within {
                faults.push(format!("{key}: {found} instead of {value}"));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn ref_two_hidden_effects_are_both_named() {
    let hidden = [("effect.coulomb_friction.force_n", 12.0), ("effect.payload.mass_kg", 7.0)];
    let d = run_diagnosis(&machine(GRINDER), &recording(&hidden, 77));
    report("coulomb + payload", &d);
    let mut effects = named(&d);
    effects.sort_unstable();
    assert_eq!((d.verdict, effects), (Verdict::Cause, vec!["coulomb_friction", "payload"]));
}

/// Errors of the stated constants inside their tolerances are calibration, not causes.
#[test]
fn ref_small_errors_of_stated_constants_are_no_cause() {
    let hidden = [("effect.payload.mass_kg", 0.5), ("effect.viscous_friction.viscous_n_s_per_m", 320.0)];
    let d = run_diagnosis(&machine(GRINDER), &recording(&hidden, 78));
    report("inside tolerance", &d);
    assert_eq!((d.verdict, named(&d)), (Verdict::NoGap, vec![]));
}

/// Refusals: an effect that the data do not excite is not named. At standstill, friction, mass and delay leave no
/// trace; only what pushes does.
#[test]
fn ref_effects_that_standstill_does_not_excite_are_not_named() {
    let hidden = [
        ("effect.payload.mass_kg", 8.0),
        ("effect.loop_delay.delay_s", 250e-6),
        ("effect.asymmetric_friction.coulomb_asymmetry", 0.25),
    ];
    for (seed, one) in hidden.into_iter().enumerate() {
        let mut all = vec![one];
        if one.0.contains("asymmetric") {
            all.extend([
                ("effect.coulomb_friction.force_n", 12.0),
                ("effect.asymmetric_friction.viscous_asymmetry", -0.25),
            ]);
        }
        let d = run_diagnosis(&machine(GRINDER), &recording_of(&all, 300 + seed as u64, &[]));
        report(&format!("standstill, {}", one.0), &d);
        assert_eq!(named(&d), Vec::<&str>::new(), "{}", one.0);
        assert!(d.checks.iter().any(|finding| finding.message.contains("never moves")));
    }
}

/// Strokes in one direction only, with their settling: Coulomb friction still shows where the axis stops.
#[test]
fn ref_coulomb_friction_is_named_from_strokes_in_one_direction() {
    let hidden = [("effect.coulomb_friction.force_n", 15.0)];
    let d = run_diagnosis(&machine(GRINDER), &recording_of(&hidden, 400, &[1.0]));
    report("one direction", &d);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["coulomb_friction"]));
    assert!((d.causes[0].parameters["force_n"].value / 15.0 - 1.0).abs() < 0.03);
    assert!(d.checks.iter().any(|finding| finding.message.contains("one direction")));
}

/// The same recording with its runs in another order gives the same answer.
#[test]
fn exact_order_of_runs_does_not_matter() {
    let recording = recording_at(&FEW, &[("effect.payload.mass_kg", 5.0)], 500, &[1.0, -1.0]);
    let mut runs = recording.runs().to_vec();
    runs.reverse();
    let turned = Recording::new(runs).unwrap();
    let (a, b) = (run_diagnosis(&machine(GRINDER), &recording), run_diagnosis(&machine(GRINDER), &turned));
    assert_eq!(serde_json::to_string(&a.causes).unwrap(), serde_json::to_string(&b.causes).unwrap());
}

/// The same recording with the effects of the catalogue in another order gives the same answer.
#[test]
fn exact_order_of_effects_does_not_matter() {
    let hidden = [("effect.coulomb_friction.force_n", 9.0), ("effect.payload.mass_kg", 5.0)];
    let recording = recording_at(&FEW, &hidden, 510, &[1.0, -1.0]);
    let reversed: Vec<EffectId> = EffectId::ALL.iter().rev().copied().collect();
    let options = Options { catalogue: &reversed, ..Options::default() };
    let a = run_diagnosis(&machine(GRINDER), &recording);
    let b = diagnose(&machine(GRINDER), &recording, &options).unwrap();
    assert_eq!(serde_json::to_string(&a.causes).unwrap(), serde_json::to_string(&b.causes).unwrap());
    assert_eq!(serde_json::to_string(&a.gap).unwrap(), serde_json::to_string(&b.gap).unwrap());
}

/// Two recordings of one machine, with their own noise and their own strokes, give the same cause, and each number within the
/// two intervals.
#[test]
fn ref_two_recordings_of_one_machine_agree() {
    let hidden = [("effect.coulomb_friction.force_n", 15.0)];
    let [a, b] = [(520, [1.0, -1.0].as_slice()), (540, &[0.8, -0.8, 0.8, -0.8])]
        .map(|(seed, legs)| run_diagnosis(&machine(GRINDER), &recording_of(&hidden, seed, legs)));
    assert_eq!((named(&a), a.verdict), (named(&b), b.verdict));
    assert_eq!(a.causes.len(), 1);
    for (key, p) in &a.causes[0].parameters {
        let q = &b.causes[0].parameters[key];
        let half = |p: &Parameter| 0.5 * (p.ci95[1] - p.ci95[0]);
        // Two independent estimates differ by no more than the root of their squared half widths, 19 times of 20; one
        // and a half times that: 299 of 300.
        assert!((p.value - q.value).abs() <= 1.5 * half(p).hypot(half(q)), "{key}: {p:?} {q:?}");
    }
}

/// A twin with small errors in all of its stated constants (mass 1 %, viscous 4 %, resistance 1 %, force constant 0.5 %) is
/// no cause, and hides none.
#[test]
fn ref_poor_nominal_constants_give_no_wrong_cause() {
    let poor = [
        ("effect.payload.mass_kg", 0.3),
        ("effect.viscous_friction.viscous_n_s_per_m", 312.0),
        ("effect.winding_resistance.resistance_ohm", 1.313),
        ("effect.force_constant.factor", 0.995),
    ];
    let hidden: [Option<(&str, f64)>; 3] =
        [None, Some(("effect.coulomb_friction.force_n", 9.0)), Some(("effect.loop_delay.delay_s", 3e-4))];
    for (seed, cause) in hidden.into_iter().enumerate() {
        let all: Vec<(&str, f64)> = poor.iter().copied().chain(cause).collect();
        let d = run_diagnosis(&machine(GRINDER), &recording(&all, 560 + seed as u64));
        report(&format!("poor, {cause:?}"), &d);
        let expected: Vec<&str> = cause.iter().map(|(path, _)| path.split('.').nth(1).unwrap()).collect();
        assert_eq!(named(&d), expected);
        assert_eq!(d.verdict, if cause.is_some() { Verdict::Cause } else { Verdict::NoGap });
    }
}

/// An effect struck from the catalogue is not looked at by any way round.
#[test]
fn exact_struck_effects_stay_struck() {
    let catalogue: Vec<EffectId> =
        EffectId::ALL.iter().copied().filter(|e| *e != EffectId::CoulombFriction).collect();
    let recording = recording_at(&FEW, &[("effect.coulomb_friction.force_n", 15.0)], 600, &[1.0, -1.0]);
    let options = Options { catalogue: &catalogue, ..Options::default() };
    let d = diagnose(&machine(GRINDER), &recording, &options).unwrap();
    report("coulomb struck", &d);
    assert!(d.ranking.iter().all(|r| !r.effects.iter().any(|e| e == "coulomb_friction")));
    assert!(d.gap.closed <= 1.0 && d.causes.iter().all(|c| (0.0..=1.0).contains(&c.closes)));
}

/// A held-out run at standstill shows no gap. That explains nothing of training runs which show one: there is no verdict, and what would explain them is told.
#[test]
fn exact_quiet_held_out_runs_do_not_explain_the_training_runs() {
    let moving = recording(&[("effect.coulomb_friction.force_n", 15.0)], 601);
    let still = recording_of(&[], 602, &[]);
    let mut runs: Vec<Run> =
        moving.runs().iter().filter(|r| r.role == Some(Role::Training)).cloned().collect();
    runs.extend(still.runs().iter().filter(|r| r.role == Some(Role::HeldOut)).take(1).cloned());
    let d = run_diagnosis(&machine(GRINDER), &Recording::new(runs).unwrap());
    assert_eq!((d.verdict, named(&d)), (Verdict::Unknown, vec![]));
    assert!(d.gap.training.is_only_here && d.gap.before < 1.25, "{:?}", d.gap);
    // Guides that carry the same load everywhere rub alike: both laws are told.
    let mut told = d.gap.training.explained_by.concat();
    told.sort();
    assert_eq!(told, ["coulomb_friction", "load_dependent_friction"]);
}

/// Positions beyond the joint's limits are a wrong unit, and a handful of samples is no run.
#[test]
fn exact_unreachable_positions_and_stub_runs_are_refused() {
    let refused = |scale: f64, samples: usize| {
        let source = recording(&[], 603);
        let runs = source.runs().iter().map(|run| {
            let signals = [Signal::PositionReference, Signal::Position].map(|signal| {
                let all = run.signal(signal).unwrap();
                (signal, all[..samples.min(all.len())].iter().map(|x| x * scale).collect())
            });
            let mut short =
                Run::new(run.name(), run.motion(), run.sample_period_s(), signals.into_iter().collect())
                    .unwrap();
            short.role = run.role;
            short
        });
        let recording = Recording::new(runs.collect()).unwrap();
        diagnose(&machine(GRINDER), &recording, &Options::default()).unwrap_err()
    };
    assert_eq!(refused(1000.0, usize::MAX).kind(), ErrorKind::Unit);
    assert_eq!(refused(1.0, 5).kind(), ErrorKind::TooLittleData);
}
