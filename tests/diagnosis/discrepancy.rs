//! What a diagnosis leaves undescribed goes into its numbers: their intervals hold the truth nevertheless.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, show, with};
use slideway::diagnose::{Options, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::Role;
use std::f64::consts::TAU;

const CELLS: [Cell; 3] =
    [(0.04, 16.0, Role::Training), (0.05, 8.0, Role::Training), (0.04, 8.0, Role::HeldOut)];

/// A number of the only effect that may be named, as it really is.
struct Asked {
    effect: EffectId,
    key: &'static str,
    value: f64,
}

impl Asked {
    fn offset(value: f64) -> Self {
        Self { effect: EffectId::AmplifierOffset, key: "offset_v", value }
    }
}

/// Error of the number, and half its 95 % interval.
fn error_and_half(
    stated: &Machine,
    hidden: &[(&str, f64)],
    asked: &Asked,
    cells: &[Cell],
    seed: u64,
) -> [f64; 2] {
    let Asked { effect, key, value } = asked;
    let path = format!("effect.{}.{key}", effect.name());
    let real = with(stated, &[hidden, &[(path.as_str(), *value)]].concat());
    let recording = Strokes::both_ways(stated, &real, seed).recording(cells);
    let options = Options { catalogue: &[*effect], ..Options::default() };
    let d = diagnose(stated, &recording, &options).unwrap();
    show(&d);
    assert_eq!(d.causes.len(), 1, "{:?} {:?}", d.verdict, d.gap);
    let number = &d.causes[0].parameters[*key];
    let [from, to] = number.ci95;
    [number.value - value, 0.5 * (to - from)]
}

/// The same of an offset of 20 mV beside cogging with this amplitude in N and phase in rad.
fn beside_cogging(force_n: f64, phase_rad: f64, seed: u64) -> [f64; 2] {
    let (sine, cosine) = phase_rad.sin_cos();
    let cogging = [
        ("effect.cogging.period_m", 0.034),
        ("effect.cogging.sine_n", force_n * cosine),
        ("effect.cogging.cosine_n", force_n * sine),
    ];
    error_and_half(&model("grinder"), &cogging, &Asked::offset(0.02), &CELLS, seed)
}

/// Cogging shifts the offset that strokes between two places tell. Its interval knows: it holds the truth whatever the phase, and it is narrow
/// where nothing is left undescribed.
#[test]
fn exact_intervals_hold_the_truth_beside_what_cannot_be_named() {
    let phases = (0..8).map(|k| TAU * k as f64 / 8.0);
    let (mut held, mut widest) = (0, 0.0f64);
    for (seed, phase) in phases.enumerate() {
        let [error, half] = beside_cogging(0.5, phase, seed as u64);
        held += usize::from(error.abs() <= half);
        widest = widest.max(half);
    }
    assert!(held >= 7, "{held} of 8");
    let [error, half] = beside_cogging(0.0, 0.0, 9);
    assert!(error.abs() < 2.0 * half && half < 0.01 * widest, "{error} {half} {widest}");
}

/// Short strokes, so that what follows the start is much of them.
const SHORT: [Cell; 3] =
    [(0.012, 8.0, Role::Training), (0.010, 12.0, Role::Training), (0.011, 6.0, Role::HeldOut)];

/// The same of an offset of 0.3 V behind dry friction that the twin knows, read in steps: the axis rests beside the reference, and where it begins is
/// read off a few samples.
fn behind_friction(seed: u64) -> [f64; 2] {
    let known = [
        ("encoder.resolution_m", 1e-6),
        ("encoder.noise_m", 2e-7),
        ("effect.coulomb_friction.force_n", 20.0),
        ("effect.presliding.stiffness_n_per_m", 3e6),
        ("effect.presliding.damping_n_s_per_m", 2e3),
    ];
    error_and_half(&with(&model("grinder"), &known), &[], &Asked::offset(0.3), &SHORT, seed)
}

/// What the sensors' steps and the unknown start put into a number is in its interval.
#[test]
fn exact_intervals_hold_the_truth_behind_friction_and_steps_of_the_reading() {
    let found: Vec<[f64; 2]> = (0..6).map(behind_friction).collect();
    let held = found.iter().filter(|[error, half]| error.abs() <= *half).count();
    assert!(held >= 5, "{found:?}");
}

/// The same of an asymmetry of friction that the twin knows, beside an offset of the amplifier: while the axis moves the two are one force.
fn beside_offset(offset_v: f64, seed: u64) -> [f64; 2] {
    let known = [
        ("effect.coulomb_friction.force_n", 20.0),
        ("effect.presliding.stiffness_n_per_m", 3e6),
        ("effect.presliding.damping_n_s_per_m", 2e3),
    ];
    let hidden = [("effect.amplifier_offset.offset_v", offset_v)];
    let asked = Asked { effect: EffectId::AsymmetricFriction, key: "coulomb_asymmetry", value: -0.2 };
    error_and_half(&with(&model("grinder"), &known), &hidden, &asked, &CELLS, seed)
}

/// An offset that is too small to be named shifts the asymmetry. Its interval knows: it holds the truth, and it is narrow without an offset.
#[test]
fn exact_intervals_hold_the_truth_beside_an_offset_that_is_not_named() {
    let offsets = [0.8e-3, -0.8e-3, 1.5e-3, -1.5e-3];
    let found: Vec<[f64; 2]> =
        offsets.iter().zip(0..).map(|(offset, seed)| beside_offset(*offset, seed)).collect();
    assert!(found.iter().all(|[error, half]| error.abs() <= *half), "{found:?}");
    let narrowest = found.iter().map(|[_, half]| *half).fold(f64::INFINITY, f64::min);
    let [error, half] = beside_offset(0.0, 4);
    assert!(error.abs() < 2.0 * half && half < 0.5 * narrowest, "{error} {half} {narrowest}");
}
