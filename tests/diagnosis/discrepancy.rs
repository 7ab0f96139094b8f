//! What a diagnosis leaves undescribed goes into its numbers: their intervals hold the truth nevertheless.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use slideway::diagnose::{Options, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::Role;
use std::f64::consts::TAU;
use std::path::Path;

const CELLS: [Cell; 3] =
    [(0.04, 16.0, Role::Training), (0.05, 8.0, Role::Training), (0.04, 8.0, Role::HeldOut)];
const OFFSET_V: f64 = 0.02;

/// Error of the offset of an amplifier beside cogging with this amplitude in N and phase in rad that cannot be named, and half its 95 % interval.
fn error_and_half(force_n: f64, phase_rad: f64, seed: u64) -> [f64; 2] {
    let stated = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let (sine, cosine) = phase_rad.sin_cos();
    let settings = [
        ("effect.amplifier_offset.offset_v", OFFSET_V),
        ("effect.cogging.period_m", 0.034),
        ("effect.cogging.sine_n", force_n * cosine),
        ("effect.cogging.cosine_n", force_n * sine),
    ];
    let real = stated.with_settings(settings.map(|(path, value)| (path, value.into()))).unwrap();
    let recording = Strokes::both_ways(&stated, &real, seed).recording(&CELLS);
    let options = Options { catalogue: &[EffectId::AmplifierOffset], ..Options::default() };
    let d = diagnose(&stated, &recording, &options).unwrap();
    assert_eq!(d.causes.len(), 1, "{:?} {:?}", d.verdict, d.gap);
    let offset = &d.causes[0].parameters["offset_v"];
    let [from, to] = offset.ci95;
    println!(
        "{force_n} N {phase_rad:.1} rad: G {:.2} -> {:.2}, {:.6} ± {:.6}",
        d.gap.before,
        d.gap.after,
        offset.value,
        0.5 * (to - from)
    );
    [offset.value - OFFSET_V, 0.5 * (to - from)]
}

/// Cogging shifts the offset that strokes between two places tell. Its interval knows: it holds the truth whatever the phase, and it is narrow
/// where nothing is left undescribed.
#[test]
fn exact_intervals_hold_the_truth_beside_what_cannot_be_named() {
    let phases = (0..8).map(|k| TAU * k as f64 / 8.0);
    let (mut held, mut widest) = (0, 0.0f64);
    for (seed, phase) in phases.enumerate() {
        let [error, half] = error_and_half(0.5, phase, seed as u64);
        held += usize::from(error.abs() <= half);
        widest = widest.max(half);
    }
    assert!(held >= 7, "{held} of 8");
    let [error, half] = error_and_half(0.0, 0.0, 9);
    assert!(error.abs() < 2.0 * half && half < 0.01 * widest, "{error} {half} {widest}");
}

/// Short strokes, so that what follows the start is much of them.
const SHORT: [Cell; 3] =
    [(0.012, 8.0, Role::Training), (0.010, 12.0, Role::Training), (0.011, 6.0, Role::HeldOut)];

/// Strokes behind dry friction that the twin knows, read in steps: the axis rests beside the reference, and where it begins is read off a few samples.
/// Errors of an amplifier's offset in standard errors.
fn offset_behind_friction(seed: u64) -> f64 {
    let file = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let with = |machine: &Machine, list: &[(&str, f64)]| {
        machine.with_settings(list.iter().map(|&(path, value)| (path, value.into()))).unwrap()
    };
    let known = [
        ("encoder.resolution_m", 1e-6),
        ("encoder.noise_m", 2e-7),
        ("effect.coulomb_friction.force_n", 20.0),
        ("effect.presliding.stiffness_n_per_m", 3e6),
        ("effect.presliding.damping_n_s_per_m", 2e3),
    ];
    let stated = with(&file, &known);
    let real = with(&stated, &[("effect.amplifier_offset.offset_v", 0.3)]);
    let recording = Strokes::both_ways(&stated, &real, seed).recording(&SHORT);
    let options = Options { catalogue: &[EffectId::AmplifierOffset], ..Options::default() };
    let d = diagnose(&stated, &recording, &options).unwrap();
    assert_eq!(d.causes.len(), 1, "{:?} {:?}", d.verdict, d.gap);
    let offset = &d.causes[0].parameters["offset_v"];
    let [from, to] = offset.ci95;
    println!("G {:.2} -> {:.2}, {:.6} ± {:.6}", d.gap.before, d.gap.after, offset.value, 0.5 * (to - from));
    (offset.value - 0.3) / (0.5 * (to - from))
}

/// What the sensors' steps and the unknown start put into a number is in its interval.
#[test]
fn exact_intervals_hold_the_truth_behind_friction_and_steps_of_the_reading() {
    let errors: Vec<f64> = (0..6).map(offset_behind_friction).collect();
    let held = errors.iter().filter(|error| error.abs() <= 1.0).count();
    assert!(held >= 5, "{errors:?}");
}
