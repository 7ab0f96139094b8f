//! Two position sensors, at the motor and at the load: what stands between them.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::Role;
use slideway::twin::load_positions;
use std::f64::consts::TAU;
use std::path::Path;

const CATALOGUE: [EffectId; 10] = [
    EffectId::PositionGain,
    EffectId::VelocityGain,
    EffectId::IntegralGain,
    EffectId::VelocityFeedforward,
    EffectId::CoulombFriction,
    EffectId::Payload,
    EffectId::Backlash,
    EffectId::ScrewError,
    EffectId::EncoderScale,
    EffectId::EncoderPeriodicError,
];
const PLAY_M: f64 = 40e-6;
const PERIOD_M: f64 = 10e-3;
const SINE_M: f64 = 9e-6;
const COSINE_M: f64 = -4e-6;
/// Each run goes there and back twice.
const TWICE: [f64; 4] = [1.0, -1.0, 1.0, -1.0];

/// The grinder's axis with its encoder at the motor and a linear scale at the table, and these settings.
fn axis(settings: &[(&str, f64)]) -> Machine {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(source.join("machine.toml")).unwrap();
    let encoder = text.replace("[encoder]\n", "[encoder]\nend = \"motor\"\n");
    assert_ne!(encoder, text);
    let text = format!("{encoder}\n[load_sensor]\nresolution_m = 1e-7\n");
    std::fs::write(folder.path().join("machine.toml"), text).unwrap();
    std::fs::copy(source.join("machine.urdf"), folder.path().join("machine.urdf")).unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    for mesh in std::fs::read_dir(source.join("meshes")).unwrap().map(Result::unwrap) {
        std::fs::copy(mesh.path(), folder.path().join("meshes").join(mesh.file_name())).unwrap();
    }
    let machine = Machine::read(folder.path()).unwrap();
    machine.with_settings(settings.iter().map(|(key, value)| (*key, (*value).into()))).unwrap()
}

fn play_and_lead(flank: f64) -> [(&'static str, f64); 5] {
    [
        ("effect.backlash.width_m", PLAY_M),
        ("effect.screw_error.period_m", PERIOD_M),
        ("effect.screw_error.sine_m", SINE_M),
        ("effect.screw_error.cosine_m", COSINE_M),
        ("effect.screw_error.flank", flank),
    ]
}

fn diagnosis(hidden: &[(&str, f64)], seed: u64) -> Diagnosis {
    let cells = [(0.06, 8.0, Role::Training), (0.05, 12.0, Role::Training), (0.055, 10.0, Role::HeldOut)];
    let real = axis(hidden);
    let stated = axis(&[]);
    let strokes = Strokes { legs: &TWICE, ..Strokes::both_ways(&stated, &real, seed) };
    let options = Options { catalogue: &CATALOGUE, ..Options::default() };
    let d = diagnose(&stated, &strokes.recording(&cells), &options).unwrap();
    println!("{hidden:?}: {:?}, G {:.2} -> {:.2}", d.verdict, d.gap.before, d.gap.after);
    for cause in &d.causes {
        println!("   {} {:.3} {:?}", cause.effect, cause.probability, cause.parameters);
    }
    d
}

fn named(d: &Diagnosis) -> Vec<&str> {
    let mut names: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    names.sort_unstable();
    names
}

/// Forward the load hangs on the stop behind it, backward on the one before it, and each has its flank's lead error.
#[test]
fn exact_each_flank_of_a_screw_has_its_own_lead_error() {
    let there: Vec<f64> = (0..4000).map(|k| 1e-5 * f64::from(k)).collect();
    let path: Vec<f64> = there.iter().chain(there.iter().rev()).copied().collect();
    let error = |q: f64| SINE_M * (TAU * q / PERIOD_M).sin() + COSINE_M * (TAU * q / PERIOD_M).cos();
    for (flank, [forward, backward]) in
        [(0.0, [1.0, 1.0]), (1.0, [1.0, 0.0]), (-1.0, [0.0, 1.0]), (0.25, [1.0, 0.75])]
    {
        let load = load_positions(&axis(&play_and_lead(flank)), &path);
        for (k, (&motor, &load)) in path.iter().zip(&load).enumerate() {
            // The play itself takes a few steps of each way.
            let [rear, front] = [motor - 0.5 * PLAY_M, motor + 0.5 * PLAY_M];
            let expected = match k {
                100..4000 => rear + forward * error(rear),
                4100.. => front + backward * error(front),
                _ => continue,
            };
            assert!((load - expected).abs() < 1e-15, "flank {flank}, sample {k}: {load}, {expected}");
        }
    }
}

/// Without play both flanks bear: the load has the mean of their errors, and no memory.
#[test]
fn exact_without_play_the_mean_of_both_flanks_counts() {
    let settings = play_and_lead(1.0);
    let [first, last] = [
        load_positions(&axis(&settings[1..]), &[0.0, 0.0025]),
        load_positions(&axis(&settings[1..]), &[0.0025]),
    ]
    .map(|load| load[load.len() - 1]);
    assert!((first - (0.0025 + 0.5 * SINE_M)).abs() < 1e-15);
    assert_eq!(first, last);
}

#[test]
fn exact_a_flank_beyond_one_is_refused() {
    let error =
        axis(&[]).with_settings(play_and_lead(1.5).map(|(key, value)| (key, value.into()))).unwrap_err();
    assert!(error.to_string().contains("flank"), "{error}");
}

/// Lost motion and a lead error that only one direction has are told apart from one that both have.
#[test]
fn ref_play_and_the_lead_error_of_one_flank_are_named() {
    for (flank, seed) in [(1.0, 1), (-1.0, 2), (0.0, 3)] {
        let d = diagnosis(&play_and_lead(flank), seed);
        assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["backlash", "screw_error"]));
        let of = |effect: &str, key: &str| {
            d.causes.iter().find(|cause| cause.effect == effect).unwrap().parameters[key].value
        };
        assert_eq!(of("screw_error", "flank"), flank);
        assert!((of("backlash", "width_m") / PLAY_M - 1.0).abs() < 0.05);
        assert!((of("screw_error", "period_m") / PERIOD_M - 1.0).abs() < 0.01);
        let amplitude = of("screw_error", "sine_m").hypot(of("screw_error", "cosine_m"));
        assert!((amplitude / SINE_M.hypot(COSINE_M) - 1.0).abs() < 0.1, "{amplitude}");
    }
}

/// What is left between two sensors that agree is no cause.
#[test]
fn ref_friction_alone_is_neither_play_nor_a_lead_error() {
    let d = diagnosis(&[("effect.coulomb_friction.force_n", 15.0)], 4);
    assert_eq!((d.verdict, named(&d)), (Verdict::Cause, vec!["coulomb_friction"]));
}
