//! The real ball-screw axis whose parameters are published (Janot, Gautier, Brunot 2019), diagnosed from its logs:
//! the estimation file trains, the pulse file is held out.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{self, needs};
use slideway::diagnose::verdict::Cause;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::Recording;
use std::path::Path;

/// One of the measured files, which come together.
const DATA: &str = "emps/emps_estimation.csv";

/// Published estimates carry this much of their own: they come from another criterion on the same data.
const PUBLISHED_WITHIN: f64 = 0.02;
/// N/V of the drive.
const FORCE_PER_VOLT: f64 = 35.150_651_88;
/// RMS of the force residual that a replay with the published symmetric parameters leaves on the pulse file, N.
const PUBLISHED_FORCE_RESIDUAL_N: f64 = 3.17;

/// What a log of effort and position shows of such an axis, and friction of one place, which wider than the travel looks like Coulomb friction. The
/// whole catalogue gives the same in minutes (README.md).
const CATALOGUE: [EffectId; 9] = [
    EffectId::PositionGain,
    EffectId::VelocityGain,
    EffectId::ForceConstant,
    EffectId::ViscousFriction,
    EffectId::CoulombFriction,
    EffectId::AsymmetricFriction,
    EffectId::Presliding,
    EffectId::ConstantForce,
    EffectId::LocalFriction,
];

fn diagnosis(machine: &str) -> Diagnosis {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let recording = Recording::read(root.join("models/emps/recording.toml")).unwrap();
    let machine = Machine::read(&root.join(machine)).unwrap();
    diagnose(&machine, &recording, &Options { catalogue: &CATALOGUE, ..Options::default() }).unwrap()
}

fn cause<'a>(diagnosis: &'a Diagnosis, effect: &str) -> &'a Cause {
    diagnosis.causes.iter().find(|cause| cause.effect == effect).unwrap()
}

fn assert_published(cause: &Cause, parameter: &str, published: f64) {
    let value = cause.parameters[parameter].value;
    let off = value / published - 1.0;
    assert!(off.abs() < PUBLISHED_WITHIN, "{}.{parameter} = {value}, published {published}", cause.effect);
}

fn effort_residual_n(diagnosis: &Diagnosis) -> (f64, f64) {
    let effort = diagnosis.gap.signals.iter().find(|s| s.signal == "control_effort_v").unwrap();
    (FORCE_PER_VOLT * effort.rms_before, FORCE_PER_VOLT * effort.rms_after)
}

#[test]
fn ref_a_twin_of_mass_alone_lacks_friction_that_differs_by_direction_and_nothing_else() {
    needs!(support::data(DATA));
    let d = diagnosis("models/emps");
    let mut named: Vec<&str> = d.causes.iter().map(|c| c.effect.as_str()).collect();
    named.sort_unstable();
    assert_eq!(d.verdict, Verdict::Cause);
    assert_eq!(named, ["asymmetric_friction", "coulomb_friction", "viscous_friction"]);
    assert_published(cause(&d, "coulomb_friction"), "force_n", 20.3858);
    assert_published(cause(&d, "viscous_friction"), "viscous_n_s_per_m", 203.5649);
    assert_published(cause(&d, "asymmetric_friction"), "viscous_asymmetry", -0.18108);
    let (before, after) = effort_residual_n(&d);
    assert!(before > 10.0 * after, "{before} N to {after} N");
    assert!(after <= PUBLISHED_FORCE_RESIDUAL_N, "{after} N");
}

#[test]
fn ref_a_twin_with_symmetric_friction_lacks_the_asymmetry() {
    needs!(support::data(DATA));
    let d = diagnosis("models/emps/symmetric.toml");
    let named: Vec<&str> = d.causes.iter().map(|c| c.effect.as_str()).collect();
    // Asymmetry is part of the answer: what it leaves repeats from lap to lap and is no noise.
    assert_eq!((d.verdict, named), (Verdict::Unknown, vec!["asymmetric_friction"]));
    assert!(d.left.is_some());
    let friction = cause(&d, "asymmetric_friction");
    assert_published(friction, "viscous_asymmetry", -0.18108);
    let (before, after) = effort_residual_n(&d);
    assert!(before <= PUBLISHED_FORCE_RESIDUAL_N && after < before, "{before} N to {after} N");
}
