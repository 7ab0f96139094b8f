//! The real ball-screw axis of a grinding machine, healthy and with a destroyed screw side, recorded with motor encoder and
//! linear scale: diagnosed, and compared as before and after.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stderr)]

use crate::support::{self, needs};
use slideway::diagnose::compare::Baseline;
use slideway::diagnose::verdict::{Cause, Parameter};
use slideway::diagnose::{Diagnosis, Options, Verdict};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Signal};
use slideway::report::{Style, terminal};
use slideway::units::Motion;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

/// One of the measured files, which come together.
const DATA: &str = "grinder_yaxis/normal_1.parquet";

/// N/A by which the machine file turns current into force (README.md of the model); only the current is known.
const FORCE_PER_AMPERE: f64 = 265.0;
/// 1 m/min.
const SPEED_M_PER_S: f64 = 1.0 / 60.0;
/// Friction of the healthy axis over its eight runs, read off cruise: 3.43 to 3.89 A.
const HEALTHY_A: Range<f64> = 3.4..3.9;
/// The broken one: 0.51 to 0.78 A forward, 0.69 to 1.14 A backward.
const BROKEN_A: Range<f64> = 0.5..1.15;
/// Lost motion that the encoder less the scale shows in runs 4, 6 and 7 (0.309, 0.322, 0.312 mm) and 8 (0.293 mm), a tenth either way.
const LATE_M: Range<f64> = 0.26e-3..0.36e-3;
/// 20 mm period, five of them in the travel; 18 to 87 µm forward over the broken runs, 5 to 18 µm backward (README.md of the model).
const LEAD_PERIOD_M: Range<f64> = 17e-3..23e-3;
const LEAD_M: Range<f64> = 18e-6..87e-6;
/// The full catalogue takes minutes a comparison: what can act on such an axis, the true changes and their rivals.
const MECHANICS: [EffectId; 13] = [
    EffectId::PositionGain,
    EffectId::VelocityGain,
    EffectId::IntegralGain,
    EffectId::VelocityFeedforward,
    EffectId::LoopDelay,
    EffectId::ForceConstant,
    EffectId::CoulombFriction,
    EffectId::AsymmetricFriction,
    EffectId::ConstantForce,
    EffectId::Payload,
    EffectId::Backlash,
    EffectId::ScrewError,
    EffectId::EncoderScale,
];

/// A screw, and a drive that may have been set otherwise.
const SCREW_AND_GAINS: [EffectId; 5] = [
    EffectId::PositionGain,
    EffectId::VelocityFeedforward,
    EffectId::CoulombFriction,
    EffectId::Backlash,
    EffectId::ScrewError,
];

fn model() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder_yaxis")
}

/// A recording of the model, other runs in the place of some of its own.
fn recording(file: &str, others: &[(&str, &str)]) -> Recording {
    if others.is_empty() {
        return Recording::read(model().join(file)).unwrap();
    }
    let place = TempDir::new().unwrap();
    let text = std::fs::read_to_string(model().join(file)).unwrap();
    let text = others.iter().fold(text, |text, (own, other)| text.replace(own, other));
    let data = support::data(DATA).unwrap().canonicalize().unwrap();
    let text = text.replace("../../../shared/data", &data.display().to_string());
    std::fs::write(place.path().join("recording.toml"), text).unwrap();
    Recording::read(place.path()).unwrap()
}

/// The healthy axis, its friction found: what every recording here is compared with.
static HEALTHY: LazyLock<Baseline> = LazyLock::new(|| {
    let machine = Machine::read(&model()).unwrap();
    let options = Options { catalogue: &MECHANICS, ..Options::default() };
    Baseline::of(&machine, &recording("normal.toml", &[]), &options).unwrap()
});

fn comparison(after: &Recording) -> Diagnosis {
    comparison_among(after, &MECHANICS)
}

fn comparison_among(after: &Recording, catalogue: &'static [EffectId]) -> Diagnosis {
    let d = HEALTHY.change(after, &Options { catalogue, ..Options::default() }).unwrap();
    eprintln!("{}", terminal(&d, Motion::Prismatic, Style { colour: false, width: 100 }));
    d
}

fn cause<'a>(d: &'a Diagnosis, effect: &str) -> &'a Cause {
    let named: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    d.causes
        .iter()
        .find(|cause| cause.effect == effect)
        .unwrap_or_else(|| panic!("{effect} is not among {named:?}"))
}

#[track_caller]
fn assert_within(what: &str, value: f64, range: Range<f64>) {
    assert!(range.contains(&value), "{what}: {value}, expected {range:?}");
}

/// Friction at the one speed of the test before and after, in A: Coulomb friction, and what the twin of the healthy axis has of
/// viscous friction.
fn friction_a(d: &Diagnosis) -> [f64; 2] {
    let force = &cause(d, "coulomb_friction").parameters["force_n"];
    let viscous = d.calibration.iter().find(|c| c.path == "effect.viscous_friction.viscous_n_s_per_m");
    let drag = |value: fn(&Parameter) -> f64| viscous.map_or(0.0, |c| SPEED_M_PER_S * value(&c.parameter));
    let before = force.twin + drag(|p| p.twin);
    let after = force.value + drag(|p| p.value);
    [before / FORCE_PER_AMPERE, after / FORCE_PER_AMPERE]
}

fn assert_healthy_reference(d: &Diagnosis) {
    let reference = d.reference.as_ref().unwrap();
    assert_eq!(reference.verdict, Verdict::Cause);
    assert_eq!(reference.causes[0].effect, "coulomb_friction");
    assert!(
        reference.gap_after < 0.15 * reference.gap_before,
        "{} {}",
        reference.gap_before,
        reference.gap_after
    );
}

/// Friction of a ball screw whose nut has lost its preload.
fn assert_friction_fell(d: &Diagnosis) {
    let [before, after] = friction_a(d);
    assert_within("before, A", before, HEALTHY_A);
    assert_within("after, A", after, BROKEN_A);
}

fn assert_lost_motion(d: &Diagnosis, width_m: Range<f64>) {
    let width = &cause(d, "backlash").parameters["width_m"];
    assert_within("lost motion, m", width.value, width_m);
    // What there was before, 2.7 µm, is no more than what healthy runs differ by.
    assert_within("lost motion before, m", width.twin, 0.0..5e-6);
}

/// Friction of the healthy axis is found, then what the broken one has instead.
#[test]
fn ref_broken_screw_and_retuned_drive_are_what_changed() {
    needs!(support::data(DATA));
    let d = comparison(&recording("mechanical.toml", &[]));
    assert_healthy_reference(&d);
    assert_eq!(d.verdict, Verdict::Cause);
    assert_friction_fell(&d);
    assert_lost_motion(&d, LATE_M);
    // The feed-forward was switched off; the gain of 88.6 1/s that would give the same cruise error is not what it was before.
    let feedforward = cause(&d, "velocity_feedforward");
    assert_eq!(feedforward.group.as_deref(), Some("controller_gain"));
    assert_within("feed-forward", feedforward.parameters["share"].value, -0.1..0.15);
    let position = d.causes.iter().find(|cause| cause.effect == "position_gain");
    assert_within("position gain", position.map_or(1.0, |gain| gain.parameters["factor"].value), 0.8..1.25);
    assert!(d.gap.closed > 0.99 && d.gap.after < 0.05 * d.gap.before, "{:?}", d.gap);
}

/// The one broken run whose drive was set as on the healthy axis: the screw changed, the drive did not.
#[test]
fn ref_broken_screw_alone_is_not_a_retuned_drive() {
    needs!(support::data(DATA));
    let d = comparison_among(&recording("mechanical_8.toml", &[]), &SCREW_AND_GAINS);
    assert_friction_fell(&d);
    assert_lost_motion(&d, LATE_M);
    let gain = d.causes.iter().find(|cause| cause.effect == "velocity_feedforward");
    let feedforward = gain.map_or(0.98, |cause| cause.parameters["share"].value);
    assert_within("feed-forward", feedforward, 0.9..1.05);
    // The lead error is there while the nut pushes forward, and hardly on the way back.
    let lead = &cause(&d, "screw_error").parameters;
    assert_within("period of the lead error, m", lead["period_m"].value, LEAD_PERIOD_M);
    assert_within("its amplitude, m", lead["sine_m"].value.hypot(lead["cosine_m"].value), LEAD_M);
    assert_eq!(lead["flank"].value, 1.0);
}

/// Two other days of the healthy axis: friction differs by a few per cent, as it does from run to run.
#[test]
fn ref_healthy_axis_on_other_days_has_not_changed() {
    needs!(support::data(DATA));
    let mut runs =
        recording("normal.toml", &[("normal_2", "normal_7"), ("normal_3", "normal_8")]).runs().to_vec();
    runs.retain(|run| ["normal_7", "normal_8"].contains(&run.name()));
    let d = comparison(&Recording::new(runs).unwrap());
    assert_eq!((d.verdict, d.causes), (Verdict::NoGap, vec![]));
}

/// The data as they are described: what the broken axis does to encoder and scale needs no model.
#[test]
fn ref_encoder_less_scale_shows_the_lost_motion() {
    needs!(support::data(DATA));
    for (file, width) in
        [("normal.toml", 0.0..6e-6), ("mechanical.toml", LATE_M), ("mechanical_8.toml", LATE_M)]
    {
        for run in recording(file, &[]).runs() {
            let signal = |s| run.signal(s).unwrap();
            let (reference, motor) = (signal(Signal::PositionReference), signal(Signal::Position));
            let scale = signal(Signal::LoadPosition);
            let mean = |forward: bool| {
                let moves =
                    |k: &usize| (reference[*k] - reference[k - 1]) * if forward { 1.0 } else { -1.0 } > 1e-6;
                let all: Vec<f64> = (1..run.len()).filter(moves).map(|k| motor[k] - scale[k]).collect();
                all.iter().sum::<f64>() / all.len() as f64
            };
            assert_within(run.name(), mean(true) - mean(false), width.clone());
        }
    }
}
