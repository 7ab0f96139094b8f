//! The next experiment: what these data leave open, the proposed motion or signal settles.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use slideway::diagnose::experiment::Experiment;
use slideway::diagnose::hypothesis::{EffectSet, Hypothesis};
use slideway::diagnose::next_experiment::{NextExperiment, Plan};
use slideway::diagnose::noise::Floor;
use slideway::diagnose::objective::Objective;
use slideway::diagnose::proposals::Proposals;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::recording::recorded;
use slideway::replay::{PlantChoice, run_seed, simulate};
use slideway::twin::Sensing;
use std::collections::BTreeMap;
use std::path::Path;

const PAYLOAD: &str = "effect.payload.mass_kg";
/// Stroke (m), feed (m/min) and role of each run.
const CELLS: [(f64, f64, Role); 4] = [
    (0.03, 4.0, Role::Training),
    (0.04, 16.0, Role::Training),
    (0.02, 8.0, Role::HeldOut),
    (0.03, 16.0, Role::HeldOut),
];
/// Seed of the noise.
const SEED: u64 = 7;
/// Delay that the twin and the machine with a mode have.
const DELAY_S: f64 = 500e-6;
/// A parameter of an effect that is named is found within this share.
const PARAMETER: f64 = 0.05;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

fn with(machine: &Machine, settings: &[(&str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, value)| (*key, toml::Value::Float(*value)))).unwrap()
}

/// A run of the machine `real`, recorded by people who know the machine `stated` and the settings of this run.
fn record(
    stated: &Machine,
    real: &Machine,
    name: &str,
    reference: &[f64],
    known: &[(&str, f64)],
    role: Role,
) -> Run {
    let sensing = Sensing::AsStated { seed: run_seed(SEED, name) };
    let traces = simulate(&with(real, known), PlantChoice::Axis, sensing, reference, |_| ()).unwrap();
    let mut run = recorded(name, stated, reference, traces).unwrap();
    run.role = Some(role);
    run.settings = known.iter().map(|(key, value)| ((*key).to_owned(), toml::Value::Float(*value))).collect();
    run
}

fn runs(stated: &Machine, real: &Machine) -> Vec<Run> {
    Strokes::both_ways(stated, real, SEED).recording(&CELLS).runs().to_vec()
}

/// The runs that a plan asks for.
fn planned(plan: &Plan, stated: &Machine, real: &Machine) -> Vec<Run> {
    let known: Vec<(&str, f64)> = plan.added_mass.iter().map(|mass| (PAYLOAD, *mass)).collect();
    let roles = [Role::Training, Role::HeldOut];
    let references = plan.references(stated);
    let all = references.iter().zip(roles).enumerate();
    all.map(|(k, (reference, role))| record(stated, real, &format!("next{k}"), reference, &known, role))
        .collect()
}

fn without(runs: &[Run], signals: &[Signal]) -> Vec<Run> {
    runs.iter()
        .map(|run| {
            let kept: BTreeMap<Signal, Vec<f64>> = run
                .signals()
                .iter()
                .filter(|(s, _)| !signals.contains(s))
                .map(|(s, x)| (*s, x.clone()))
                .collect();
            let mut less = Run::new(run.name(), run.motion(), run.sample_period_s(), kept).unwrap();
            (less.role, less.settings) = (run.role, run.settings.clone());
            less
        })
        .collect()
}

fn diagnosis(stated: &Machine, runs: Vec<Run>, catalogue: &[EffectId]) -> Diagnosis {
    let options = Options { catalogue, ..Options::default() };
    let d = diagnose(stated, &Recording::new(runs).unwrap(), &options).unwrap();
    println!("{:?} {:?} G {:.2} -> {:.3}", d.verdict, named(&d), d.gap.before, d.gap.after);
    for r in d.ranking.iter().take(5) {
        println!("   {:?} p={:.4} G={:.3}", r.effects, r.probability, r.held_out_gap);
    }
    if let Some(next) = &d.next_experiment {
        println!("   {}\n   {}", next.sentence, next.command);
    }
    d
}

fn named(d: &Diagnosis) -> Vec<&str> {
    d.causes.iter().map(|cause| cause.effect.as_str()).collect()
}

fn separates(next: &NextExperiment, effects: [&str; 2]) -> bool {
    effects.iter().all(|effect| next.separates.iter().any(|set| *set == [(*effect).to_owned()]))
}

const FRICTION: [EffectId; 4] = [
    EffectId::CoulombFriction,
    EffectId::LoadDependentFriction,
    EffectId::ViscousFriction,
    EffectId::Payload,
];

/// At a constant payload, friction in proportion to the load is Coulomb friction: a known mass tells.
#[test]
fn ref_added_mass_tells_load_dependent_from_coulomb_friction() {
    let stated = machine();
    let truths = [("coulomb_friction", "force_n", 15.0), ("load_dependent_friction", "coefficient", 0.03)];
    for (effect, parameter, value) in truths {
        let real = with(&stated, &[(&format!("effect.{effect}.{parameter}"), value)]);
        let mut runs = runs(&stated, &real);
        let first = diagnosis(&stated, runs.clone(), &FRICTION);
        let next = first.next_experiment.as_ref().expect("the question is open");
        assert!(next.motion.added_mass.is_some_and(|mass| mass > 0.0), "{next:?}");
        assert!(separates(next, ["coulomb_friction", "load_dependent_friction"]), "{next:?}");
        assert!(next.predicted_separation > 10.0 && next.signal_to_add.is_none());
        assert!(next.command.contains(PAYLOAD) && next.sentence.contains("bolt"), "{next:?}");

        runs.extend(planned(&next.motion, &stated, &real));
        let second = diagnosis(&stated, runs, &FRICTION);
        assert_eq!((second.verdict, named(&second)), (Verdict::Cause, vec![effect]));
        let cause = &second.causes[0];
        assert!(cause.confusable_with.is_empty(), "{:?}", cause.confusable_with);
        let found = cause.parameters[parameter].value;
        assert!((found / value - 1.0).abs() < PARAMETER, "{effect}: {found}");
    }
}

/// A lead error before the only sensor is that sensor's error: a second one tells.
#[test]
fn ref_second_sensor_tells_a_lead_error_from_an_encoder_error() {
    let stated = with(&machine(), &[("encoder.noise_m", 3e-8)]);
    let effect = "effect.screw_error";
    let real = with(
        &stated,
        &[
            (&format!("{effect}.period_m"), 5e-3),
            (&format!("{effect}.sine_m"), 4e-6),
            (&format!("{effect}.cosine_m"), -2e-6),
        ],
    );
    let catalogue = [EffectId::ScrewError, EffectId::EncoderPeriodicError, EffectId::CoulombFriction];
    let first = diagnosis(&stated, runs(&stated, &real), &catalogue);
    assert_ne!(first.verdict, Verdict::NoGap);
    let next = first.next_experiment.as_ref().expect("the question is open");
    assert_eq!(next.signal_to_add.as_deref(), Some("load_position_m"), "{next:?}");
    assert!(separates(next, ["screw_error", "encoder_periodic_error"]), "{next:?}");
    assert!(next.sentence.contains("second position sensor"), "{}", next.sentence);
}

/// A weak motor and an encoder whose unit is too short are one and the same to everything but a force sensor or a
/// second position sensor.
#[test]
fn ref_thrust_tells_a_force_constant_from_an_encoder_scale() {
    let stated = machine();
    let real = with(&stated, &[("effect.force_constant.factor", 0.93)]);
    let catalogue = [EffectId::ForceConstant, EffectId::EncoderScale, EffectId::CoulombFriction];
    let all = runs(&stated, &real);
    let first = diagnosis(&stated, without(&all, &[Signal::Thrust]), &catalogue);
    let next = first.next_experiment.as_ref().expect("the question is open");
    assert!(
        first.causes.iter().all(|cause| !cause.confusable_with.is_empty()),
        "one group: {:?}",
        first.causes
    );
    assert_eq!(next.signal_to_add.as_deref(), Some("thrust_n"), "{next:?}");
    assert!(separates(next, ["force_constant", "encoder_scale"]), "{next:?}");
    let second = diagnosis(&stated, all, &catalogue);
    assert_eq!((second.verdict, named(&second)), (Verdict::Cause, vec!["force_constant"]));
    assert!(second.next_experiment.is_none());
}

/// Where nothing else explains the runs, there is nothing to settle.
#[test]
fn exact_decided_question_asks_for_nothing() {
    let stated = machine();
    let real = with(&stated, &[("effect.loop_delay.delay_s", 400e-6)]);
    let catalogue = [EffectId::LoopDelay, EffectId::CoulombFriction, EffectId::Payload];
    let d = diagnosis(&stated, runs(&stated, &real), &catalogue);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["loop_delay"]));
    assert!(d.causes[0].confusable_with.is_empty() && d.next_experiment.is_none(), "{:?}", d.next_experiment);
}

/// The known failure of plain parameter fits: where a mode is missing, a fit of the delay makes it longer than it is and
/// the residual of the runs that it sees smaller. Held-out evidence still names the mode.
#[test]
fn ref_missing_flexible_mode_is_not_taken_for_a_delay() {
    let stated = with(&machine(), &[("amplifier.delay_s", DELAY_S)]);
    let mode = "effect.flexible_mode";
    let hidden = [("frequency_hz", 45.0), ("mass_kg", 150.0), ("damping_ratio", 0.03)];
    let keys: Vec<(String, f64)> = hidden.iter().map(|(name, x)| (format!("{mode}.{name}"), *x)).collect();
    let settings: Vec<(&str, f64)> = keys.iter().map(|(key, x)| (key.as_str(), *x)).collect();
    let runs = runs(&stated, &with(&stated, &settings));

    let experiments: Vec<Experiment> = runs
        .iter()
        .filter(|r| r.role == Some(Role::Training))
        .map(|r| Experiment::new(r, &stated).unwrap())
        .collect();
    let floor = Floor::estimate(&stated, &experiments.iter().collect::<Vec<_>>()).unwrap();
    let nothing = Hypothesis::new(&stated, &EffectSet::new(), &Proposals::default(), &[]).unwrap();
    let left = |delay_s: f64| {
        let twin = with(&stated, &[("amplifier.delay_s", delay_s)]);
        let objective = Objective::new(&twin, &nothing, &experiments, &floor);
        objective.residuals(&nothing.starts[0]).unwrap().norm()
    };
    // Least squares over the delay alone.
    let delays = (0..80).map(|k| f64::from(k) * 12.5e-6);
    let fitted = delays.min_by(|a, b| left(*a).total_cmp(&left(*b))).unwrap();
    let shrink = left(fitted) / left(DELAY_S);
    println!("training residual × {shrink:.3} with a delay of {fitted:.3e} s");
    assert!(shrink < 0.98 && fitted > DELAY_S + 25e-6, "a delay takes up some of it: {shrink}, {fitted}");

    let catalogue =
        [EffectId::LoopDelay, EffectId::FlexibleMode, EffectId::CoulombFriction, EffectId::Payload];
    let d = diagnosis(&stated, runs, &catalogue);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["flexible_mode"]));
    let alone =
        |effect: &str| d.ranking.iter().find(|r| r.effects == [effect.to_owned()]).expect("looked at");
    assert!(alone("loop_delay").held_out_gap > 2.0 * alone("flexible_mode").held_out_gap);
    assert!(alone("loop_delay").probability < 1e-3);
    let frequency = d.causes[0].parameters["frequency_hz"].value;
    assert!((frequency / 45.0 - 1.0).abs() < PARAMETER, "{frequency}");
}
