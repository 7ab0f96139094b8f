//! A loop that differentiates coarse readings: what its steps make of the motion is noise, and tells of the steps all the same.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::{Cell, Strokes};
use crate::support::told::{model, names, show, with};
use slideway::diagnose::check::Check;
use slideway::diagnose::experiment::Experiment;
use slideway::diagnose::noise::Floor;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};

/// Far coarser than the encoder that the machine states.
const STEP_M: f64 = 7e-7;
const CELLS: [Cell; 5] = [
    (0.03, 0.7, Role::Training),
    (0.026, 1.3, Role::Training),
    (0.05, 2.4, Role::Training),
    (0.04, 1.0, Role::HeldOut),
    (0.035, 2.0, Role::HeldOut),
];

/// A machine whose velocity is the difference of two readings, amplified.
fn machine() -> Machine {
    model("emps")
}

fn told(machine: &Machine, recording: &Recording) -> Diagnosis {
    diagnose(machine, recording, &Options::default()).unwrap()
}

/// The run as a log with few digits has it.
fn rounded(run: &Run) -> Run {
    let mut signals = run.signals().clone();
    let positions = signals.get_mut(&Signal::Position).unwrap();
    positions.iter_mut().for_each(|x| *x = STEP_M * (*x / STEP_M).round());
    let mut rounded = Run::new(run.name(), run.motion(), run.sample_period_s(), signals).unwrap();
    rounded.role = run.role;
    rounded
}

fn is_noted(diagnosis: &Diagnosis) -> bool {
    diagnosis.checks.iter().any(|finding| finding.check == Check::CoarseReadings)
}

/// The course that the steps make of the motion cannot be predicted, so the residuals do not shrink; the noise that they
/// must make accounts for them.
#[test]
fn exact_coarse_steps_in_the_loop_are_named_with_their_size() {
    let stated = machine();
    let settings = [("effect.encoder_resolution.resolution_m", STEP_M.into())];
    let real = stated.with_settings(settings).unwrap();
    let d = told(&stated, &Strokes::both_ways(&stated, &real, 3).recording(&CELLS));
    let named: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    assert_eq!((d.verdict, named), (Verdict::Cause, vec!["encoder_resolution"]));
    let step = d.causes[0].parameters["resolution_m"].value;
    assert!((step / STEP_M - 1.0).abs() < 1e-6, "{step}");
    assert!(d.gap.before > 3.0 && d.gap.after < 1.25 && d.gap.closed > 0.95, "{:?}", d.gap);
    assert!(d.gap.predicted_closed > 0.9 && is_noted(&d));
}

/// What could stand for steps of the encoder.
const LIKE_STEPS: [EffectId; 10] = [
    EffectId::EncoderResolution,
    EffectId::EncoderPeriodicError,
    EffectId::VelocityFilter,
    EffectId::LoopDelay,
    EffectId::DeadZone,
    EffectId::VelocityGain,
    EffectId::Cogging,
    EffectId::CoulombFriction,
    EffectId::StribeckFriction,
    EffectId::Presliding,
];

/// A log that was rounded after the loop had run leaves the effort as quiet as it was.
#[test]
fn exact_a_rounded_log_is_no_coarse_encoder() {
    let stated = machine();
    let fine = Strokes::both_ways(&stated, &stated, 3).recording(&CELLS);
    let rounded = Recording::new(fine.runs().iter().map(rounded).collect()).unwrap();
    let options = Options { catalogue: &LIKE_STEPS, ..Options::default() };
    let d = diagnose(&stated, &rounded, &options).unwrap();
    assert!(d.causes.iter().all(|cause| cause.effect != "encoder_resolution"), "{:?}", d.causes);
    assert!(!is_noted(&d));
}

/// Strokes that end between two steps of the encoder.
const BETWEEN_STEPS: [Cell; 5] = [
    (0.010953, 0.5811, Role::Training),
    (0.010287, 1.3158, Role::Training),
    (0.019412, 2.58, Role::Training),
    (0.013783, 2.3838, Role::HeldOut),
    (0.012419, 0.6137, Role::HeldOut),
];

/// At rest on soft bristles the loop hunts between two steps of the encoder, half a step to each side (σ of 25 nm); in motion the steps leave 1/√12 of
/// one (14.4 nm).
#[test]
fn exact_a_limit_cycle_at_rest_is_not_the_noise_of_the_motion() {
    let bristles = [
        ("effect.coulomb_friction.force_n", 0.4148),
        ("effect.presliding.stiffness_n_per_m", 7.05e4),
        ("effect.presliding.damping_n_s_per_m", 1487.0),
    ];
    let machine = with(&machine(), &bristles);
    let strokes = Strokes { dwell_s: 0.6, ..Strokes::both_ways(&machine, &machine, 3) };
    let recording = strokes.recording(&BETWEEN_STEPS);
    let experiments: Vec<Experiment> =
        recording.runs().iter().map(|run| Experiment::new(run, &machine).unwrap()).collect();
    let floor = Floor::estimate(&machine, &experiments.iter().collect::<Vec<_>>()).unwrap();
    let (sigma, step) = (floor.sigma(Signal::Position), 5e-8);
    assert!((sigma / (step / 12.0_f64.sqrt()) - 1.0).abs() < 0.1, "{sigma}");
}

/// Beside coarse steps on a guide that sticks the screening does not see another winding: its own fit without them does.
#[test]
fn ref_a_coarse_encoder_and_another_winding_are_both_named() {
    let friction = [
        ("effect.coulomb_friction.force_n", 15.0),
        ("effect.presliding.stiffness_n_per_m", 9.2e6),
        ("effect.presliding.damping_n_s_per_m", 1.35e4),
    ];
    let stated = with(&model("grinder"), &friction);
    let hidden = [
        ("effect.encoder_resolution.resolution_m", 1e-5),
        ("effect.winding_resistance.resistance_ohm", 1.44),
    ];
    let cells = [(0.01, 1.0, Role::Training), (0.012, 2.0, Role::HeldOut)];
    let recording = Strokes::both_ways(&stated, &with(&stated, &hidden), 7).recording(&cells);
    let catalogue = [
        EffectId::EncoderResolution,
        EffectId::WindingResistance,
        EffectId::BackEmf,
        EffectId::ForceConstant,
        EffectId::ViscousFriction,
        EffectId::CoulombFriction,
        EffectId::LoopDelay,
    ];
    let d = diagnose(&stated, &recording, &Options { catalogue: &catalogue, ..Options::default() }).unwrap();
    show(&d);
    assert_eq!((d.verdict, names(&d)), (Verdict::Cause, vec!["encoder_resolution", "winding_resistance"]));
    let winding = d.causes.iter().find(|cause| cause.effect == "winding_resistance").unwrap();
    let resistance = winding.parameters["resistance_ohm"].value;
    // A hundredth: strokes of a centimetre at 1 m/min take little current.
    assert!((resistance / 1.44 - 1.0).abs() < 0.01, "{resistance}");
}
