//! Features of dry friction in pairs, with each other and with what acts beside friction: all named, nothing else, with their sizes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::Role;
use std::collections::BTreeSet;
use std::path::Path;

/// Stroke (m), feed (m/min) and role of each run.
const CELLS: [Cell; 4] = [
    (0.04, 16.0, Role::Training),
    (0.05, 4.0, Role::Training),
    (0.04, 8.0, Role::HeldOut),
    (0.05, 16.0, Role::HeldOut),
];

/// An effect by its keys; the first one is that by which its size is checked.
type Hidden = (&'static str, &'static [(&'static str, f64)]);

const COULOMB: Hidden = ("coulomb_friction", &[("force_n", 15.0)]);
/// Features that modify it or stand beside it.
const FEATURES: [Hidden; 5] = [
    ("asymmetric_friction", &[("viscous_asymmetry", -0.15), ("coulomb_asymmetry", 0.3)]),
    ("stribeck_friction", &[("peak_ratio", 1.6), ("stribeck_velocity_m_per_s", 0.01)]),
    ("presliding", &[("stiffness_n_per_m", 2e6), ("damping_n_s_per_m", 800.0)]),
    ("local_friction", &[("force_n", 8.0), ("centre_m", 0.02), ("width_m", 0.015)]),
    ("friction_drift", &[("rate_per_s", 0.05)]),
];
/// What else acts.
const OTHERS: [Hidden; 4] = [
    ("payload", &[("mass_kg", 6.0)]),
    ("amplifier_offset", &[("offset_v", 0.1)]),
    ("loop_delay", &[("delay_s", 4e-4)]),
    ("cogging", &[("sine_n", 8.0), ("period_m", 0.012), ("cosine_n", 0.0)]),
];

/// Friction with its features, what else is hidden, and what could stand for one of them; the whole catalogue takes several times
/// as long.
const CATALOGUE: [EffectId; 14] = [
    EffectId::CoulombFriction,
    EffectId::ViscousFriction,
    EffectId::AsymmetricFriction,
    EffectId::StribeckFriction,
    EffectId::Presliding,
    EffectId::LocalFriction,
    EffectId::FrictionDrift,
    EffectId::ConstantForce,
    EffectId::CableSpring,
    EffectId::Payload,
    EffectId::AmplifierOffset,
    EffectId::LoopDelay,
    EffectId::DeadZone,
    EffectId::Cogging,
];

/// Sizes are found within this share.
const WITHIN: f64 = 0.05;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

fn run_diagnosis(hidden: &[Hidden], cells: &[Cell], seed: u64) -> Diagnosis {
    let settings: Vec<(String, toml::Value)> = hidden
        .iter()
        .flat_map(|(effect, keys)| {
            keys.iter().map(move |(key, value)| (format!("effect.{effect}.{key}"), (*value).into()))
        })
        .collect();
    let stated = machine();
    let real =
        stated.with_settings(settings.iter().map(|(key, value)| (key.as_str(), value.clone()))).unwrap();
    let recording = Strokes::both_ways(&stated, &real, seed).recording(cells);
    diagnose(&stated, &recording, &Options { catalogue: &CATALOGUE, ..Options::default() }).unwrap()
}

/// What is wrong with the answer, if anything.
fn fault(pair: [Hidden; 2], seed: u64) -> Option<String> {
    let hidden = [COULOMB, pair[0], pair[1]];
    let d = run_diagnosis(&hidden, &CELLS, seed);
    let named: BTreeSet<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    println!(
        "{} + {}: {:?} {named:?} G {:.1} -> {:.2}",
        pair[0].0, pair[1].0, d.verdict, d.gap.before, d.gap.after
    );
    let asked: BTreeSet<&str> = hidden.iter().map(|(effect, _)| *effect).collect();
    if named != asked || d.verdict != Verdict::Cause {
        return Some(format!("{} + {}: {:?} {named:?}", pair[0].0, pair[1].0, d.verdict));
    }
    hidden.iter().find_map(|(effect, keys)| {
        let (key, value) = keys[0];
        let cause = d.causes.iter().find(|cause| cause.effect == *effect)?;
        // A phase far from the zero of position hangs on the pitch: of what repeats, the amplitude counts.
        let found = match cause.amplitudes.get(&key.replace("sine", "amplitude")) {
            Some(amplitude) => amplitude.value,
            None => cause.parameters[key].value,
        };
        let off = (found / value - 1.0).abs();
        (off > WITHIN).then(|| format!("{} + {}: {effect}.{key} = {found}", pair[0].0, pair[1].0))
    })
}

fn faults(pairs: &[[Hidden; 2]]) -> Vec<String> {
    pairs.iter().zip(0..).filter_map(|(pair, seed)| fault(*pair, seed)).collect()
}

/// Each feature in one pair at least; all thirty pairs, twelve minutes of one core, where `SLIDEWAY_PAIRS` is `all`.
#[test]
fn ref_features_of_friction_are_named_in_pairs() {
    let [asymmetry, stribeck, presliding, local, drift] = FEATURES;
    let [_, _, delay, _] = OTHERS;
    let few = vec![[asymmetry, stribeck], [local, drift], [presliding, delay]];
    let own =
        (0..FEATURES.len()).flat_map(|a| (a + 1..FEATURES.len()).map(move |b| [FEATURES[a], FEATURES[b]]));
    let others = FEATURES.iter().flat_map(|feature| OTHERS.iter().map(|other| [*feature, *other]));
    let wants_all = std::env::var("SLIDEWAY_PAIRS").is_ok_and(|pairs| pairs == "all");
    let pairs = if wants_all { own.chain(others).collect() } else { few };
    let faults = faults(&pairs);
    assert!(faults.is_empty(), "{faults:#?}");
}

/// A pitch that most strokes do not reach twice: 5 N of cogging every 37 mm on strokes of 20 to 50 mm.
#[test]
fn ref_cogging_of_a_long_pitch_is_named_with_amplitude_and_pitch() {
    const LONG: [Cell; 5] = [
        (0.02, 4.0, Role::Training),
        (0.05, 8.0, Role::Training),
        (0.035, 16.0, Role::Training),
        (0.03, 8.0, Role::HeldOut),
        (0.045, 12.0, Role::HeldOut),
    ];
    let cogging: Hidden = ("cogging", &[("sine_n", 4.0), ("cosine_n", 3.0), ("period_m", 0.037)]);
    let d = run_diagnosis(&[COULOMB, FEATURES[2], cogging], &LONG, 200);
    let named: BTreeSet<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    println!("long pitch: {:?} {named:?} G {:.1} -> {:.2}", d.verdict, d.gap.before, d.gap.after);
    assert_eq!(named, BTreeSet::from(["coulomb_friction", "presliding", "cogging"]));
    let cause = d.causes.iter().find(|cause| cause.effect == "cogging").unwrap();
    let (pitch, amplitude) = (cause.parameters["period_m"].value, cause.amplitudes["amplitude_n"].value);
    assert!(
        (pitch / 0.037 - 1.0).abs() < 0.02 && (amplitude / 5.0 - 1.0).abs() < 0.05,
        "{pitch} m, {amplitude} N"
    );
}
