//! The servo drive as a machine, its current loop, and the sweep that finds its transfer function.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::{Command as Process, Output};

use nalgebra::Complex;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use slideway::drive::motor::Circuit;
use slideway::effect::EffectId;
use slideway::error::ErrorKind;
use slideway::identify::continuous::{
    Compared, ContinuousTransfer, Delay, Structure, TransferFit, Weights, fit,
};
use slideway::identify::excitation::Outcome;
use slideway::identify::frequency_response::Point;
use slideway::identify::stepped_sine::{FREQUENCY_KEY, Gain, Sine, settled, sines};
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::plant::rapier::Rig;
use slideway::recording::{Existing, Format, Recording, Run, Signal};
use slideway::replay::sine_sweep::SineSweep;
use slideway::replay::{PlantChoice, run};
use slideway::twin::{Command, Sensing, Twin};
use slideway::units::Motion;

/// What the published numbers are held to.
const HALF_A_PERCENT: f64 = 5e-3;

const FIRST_ORDER: Structure = Structure {
    zeros: 0,
    poles: 1,
    delay: Delay::Free,
    compared: Compared::GainAndPhase,
    weights: Weights::Equal,
};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models/servo")
}

fn servo() -> Machine {
    Machine::read(&folder()).unwrap()
}

fn identified(outcome: Outcome<TransferFit>) -> TransferFit {
    match outcome {
        Outcome::Identified(fit) => fit,
        Outcome::NotExcited(why) => panic!("{why}"),
    }
}

fn points(sines: &[Sine]) -> Vec<Point> {
    sines.iter().map(|sine| sine.point).collect()
}

fn near(found: f64, expected: f64, relative: f64) {
    assert!((found / expected - 1.0).abs() < relative, "{found} for {expected}");
}

// ---- the machine ---------------------------------------------------------------------------------

/// T(s) = 9975/(s + 1.6) in (rad/s)/A with 0.5 N·m/A.
#[test]
fn exact_inertia_and_drag_are_those_of_the_published_transfer_function() {
    let constants = servo().constants();
    let Circuit::Winding { resistance_ohm, inductance_h, force_constant, back_emf } = constants.circuit
    else {
        panic!("a current loop has the equation of a winding");
    };
    near(force_constant / constants.moving_mass, 9975.0, 1e-9);
    near(constants.viscous / constants.moving_mass, 1.6, 1e-9);
    assert_eq!((resistance_ohm, inductance_h, back_emf), (1.0, 1e-4, 0.0));
    assert_eq!(constants.effort_limit_v(), Some(9.0));
    assert_eq!(constants.sample_period_s, 2e-3);
}

#[test]
fn exact_what_is_known_of_a_winding_does_not_apply_to_a_current_loop() {
    let constants = servo().constants();
    for id in [EffectId::WindingResistance, EffectId::WindingInductance, EffectId::BackEmf] {
        assert!(!id.applies(&constants), "{}", id.name());
    }
    assert!(EffectId::ForceConstant.applies(&constants) && EffectId::LoopDelay.applies(&constants));
    let error = servo().with_settings([("effect.back_emf.back_emf_v_s_per_rad", 0.5.into())]).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Inconsistent);
    assert!(error.to_string().contains("effect.back_emf"), "{error}");
    for (key, value) in [("motor.time_constant_s", 0.0), ("motor.current_limit_a", -1.0)] {
        let error = servo().with_settings([(key, value.into())]).unwrap_err();
        assert!(error.to_string().contains(key), "{error}");
    }
}

/// A step of 1 A from standstill: i = 1 − e^(−t/τ), and v and q behind it in closed form.
#[test]
fn exact_current_step_on_axis_and_scene() {
    let machine = servo().with_settings([("motor.time_constant_s", 5e-3.into())]).unwrap();
    let commands = || (0..200).map(|_| Command { effort_v: Some(1.0), ..Command::follow(0.0, 0.0) });
    let axis = Axis::of(&machine.constants());
    let on_axis = run(&mut Twin::new(&machine, axis, Sensing::Perfect), commands(), |_| ());
    let rig = Rig::new(&machine).unwrap();
    let on_scene = run(&mut Twin::new(&machine, rig, Sensing::Perfect), commands(), |_| ());
    let (a, b, rate) = (9975.0, 1.6, 200.0);
    for k in 0..200 {
        let t = k as f64 * 2e-3;
        let current = 1.0 - (-rate * t).exp();
        assert!((on_axis.current[k] - current).abs() < 1e-12, "{k}");
        assert!((on_scene.current[k] - current).abs() < 1e-12, "{k}");
        let exact = double_integral(a, b, rate, t);
        assert!((on_axis.position[k] - exact).abs() < 1e-9 * (1.0 + exact), "{k}: {}", on_axis.position[k]);
        assert!((on_scene.position[k] - exact).abs() < 1e-5 * (1.0 + exact), "{k}: {}", on_scene.position[k]);
    }
}

/// Position at t of v' = a·i − b·v, q' = v from rest with i = 1 − e^(−rt).
fn double_integral(a: f64, b: f64, r: f64, t: f64) -> f64 {
    // v = a·(1 − e^(−bt))/b − a·(e^(−rt) − e^(−bt))/(b − r)
    let (fast, slow) = ((1.0 - (-r * t).exp()) / r, (1.0 - (-b * t).exp()) / b);
    a * ((t - slow) / b - (fast - slow) / (b - r))
}

/// A command beyond the limit reaches the limit and no further.
#[test]
fn exact_current_is_limited() {
    let machine = servo().with_settings([("motor.current_limit_a", 0.3.into())]).unwrap();
    let commands = (0..50).map(|_| Command { effort_v: Some(4.0), ..Command::follow(0.0, 0.0) });
    let traces =
        run(&mut Twin::new(&machine, Axis::of(&machine.constants()), Sensing::Perfect), commands, |_| ());
    assert!((traces.current[49] - 0.3).abs() < 1e-12, "{}", traces.current[49]);
    assert_eq!(traces.effort_v[49], 4.0);
}

/// Below the stiction the shaft does not turn, above it does; once it turns, Coulomb friction is left.
#[test]
fn exact_stiction_holds_the_shaft() {
    let machine = Machine::read(&folder().join("stiction.toml")).unwrap();
    let turned = |current_a: f64, after_a: f64| {
        let axis = Axis::of(&machine.constants());
        let mut twin = Twin::new(&machine, axis, Sensing::Perfect);
        let held = |effort_v| Command { effort_v: Some(effort_v), ..Command::follow(0.0, 0.0) };
        for _ in 0..500 {
            twin.step(held(current_a));
        }
        for _ in 0..20_000 {
            twin.step(held(after_a));
        }
        twin.state()
    };
    // 0.5 N·m/A: 15 mN·m are 30 mA, 10 mN·m are 20 mA.
    // While the current rises within the first step friction holds its mean, not its every moment: below 1e-8 rad.
    let [stayed, speed] = turned(0.0299, 0.0299);
    assert!(stayed.abs() < 1e-8 && speed.abs() < 1e-12, "{stayed} {speed}");
    let [_, speed] = turned(0.0301, 0.025);
    // Steady speed: (25 mA − 20 mA)·0.5 N·m/A over the drag.
    near(speed, 0.005 * 0.5 / machine.constants().viscous, 1e-3);
}

/// Its friction apart, whose feature goes with it.
#[test]
fn exact_variant_with_stiction_is_the_machine_otherwise() {
    let variant = Machine::read(&folder().join("stiction.toml")).unwrap();
    assert_eq!(variant.without_effect(EffectId::CoulombFriction).unwrap().constants(), servo().constants());
}

// ---- the sweep -----------------------------------------------------------------------------------

/// Sines of 0.2 A peak to peak from 0.2 to 60 rad/s, loops off, gain from settled peaks: T(s) = 9975/(s + 1.6).
#[test]
fn ref_sweep_finds_the_published_transfer_function() {
    let machine = servo();
    let sweep = SineSweep::logarithmic([0.2 / TAU, 60.0 / TAU], 30, 0.1).unwrap();
    let runs = sweep.runs(&machine, PlantChoice::Axis, |_| ()).unwrap();
    let runs: Vec<&Run> = runs.iter().collect();
    for input in [Signal::Current, Signal::ControlEffort] {
        let sines = sines(&runs, input, Signal::Velocity, Gain::Peaks).unwrap();
        near(sines[0].input_amplitude, 0.1, 2e-3);
        for structure in
            [FIRST_ORDER, Structure { delay: Delay::Known(0.0), compared: Compared::Gain, ..FIRST_ORDER }]
        {
            let found = identified(fit(&points(&sines), structure).unwrap());
            near(found.transfer.numerator[0], 9975.0, HALF_A_PERCENT);
            near(found.transfer.denominator[0], 1.6, HALF_A_PERCENT);
            let decibels = 20.0 * found.transfer.static_gain().log10();
            assert!((decibels - 75.8959).abs() < 0.05, "{decibels} dB");
        }
    }
}

/// The rigid-body scene under the same sines.
#[test]
fn exact_scene_and_axis_agree_on_the_sweep() {
    let machine = servo();
    let sweep = SineSweep::logarithmic([4.0 / TAU, 40.0 / TAU], 4, 0.1).unwrap();
    let found: Vec<Vec<Complex<f64>>> = [PlantChoice::Axis, PlantChoice::Rapier]
        .into_iter()
        .map(|plant| {
            let runs = sweep.runs(&machine, plant, |_| ()).unwrap();
            let runs: Vec<&Run> = runs.iter().collect();
            let sines = sines(&runs, Signal::ControlEffort, Signal::Velocity, Gain::Fundamental).unwrap();
            sines.iter().map(|sine| sine.point.response()).collect()
        })
        .collect();
    for (axis, scene) in found[0].iter().zip(&found[1]) {
        assert!((axis / scene - 1.0).norm() < 1e-3, "{axis} {scene}");
    }
}

/// What a recording holds is what was simulated, its frequencies stated or found.
#[test]
fn exact_sweep_works_on_a_recording() {
    let sweep = SineSweep::logarithmic([3.0 / TAU, 40.0 / TAU], 8, 0.1).unwrap();
    let mut runs = sweep.runs(&servo(), PlantChoice::Axis, |_| ()).unwrap();
    let place = tempfile::tempdir().unwrap();
    let mut stated = Vec::new();
    for is_stated in [true, false] {
        if !is_stated {
            runs.iter_mut().for_each(|run| drop(run.metadata.remove(FREQUENCY_KEY)));
        }
        let at = place.path().join(is_stated.to_string());
        Recording::new(runs.clone()).unwrap().write(&at, Format::Parquet, Existing::Refuse).unwrap();
        let shown = slideway(&["identify", "sweep", &at.display().to_string(), "--delay", "0"]);
        assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
        let text = String::from_utf8_lossy(&shown.stdout).into_owned();
        assert!(text.contains("T(s) = 99"), "{text}");
        let read = Recording::read(&at).unwrap();
        let runs: Vec<&Run> = read.runs().iter().collect();
        let sines = sines(&runs, Signal::Current, Signal::Velocity, Gain::Fundamental).unwrap();
        stated.push(sines.iter().map(|sine| sine.point).collect::<Vec<_>>());
    }
    for (stated, found) in stated[0].iter().zip(&stated[1]) {
        near(found.frequency_hz, stated.frequency_hz, 1e-4);
        assert!((found.response() / stated.response() - 1.0).norm() < 1e-3);
    }
}

// ---- the fit -------------------------------------------------------------------------------------

fn response_of(
    truth: &ContinuousTransfer,
    [from, to]: [f64; 2],
    count: usize,
    noise: f64,
    seed: u64,
) -> Vec<Point> {
    let mut random = StdRng::seed_from_u64(seed);
    let mut gauss = || {
        let [u, v]: [f64; 2] = [random.random_range(1e-12..1.0), random.random_range(0.0..TAU)];
        (-2.0 * u.ln()).sqrt() * v.cos()
    };
    (0..count)
        .map(|k| {
            let frequency_hz = from * (to / from).powf(k as f64 / (count - 1) as f64);
            // Twice the noise in every other point.
            let relative_sd = noise * if k % 2 == 0 { 1.0 } else { 2.0 };
            let error = Complex::new(relative_sd * gauss(), relative_sd * gauss());
            let value = truth.response(frequency_hz) * (error + 1.0);
            Point { frequency_hz, re: value.re, im: value.im, coherence: 1.0, relative_sd, quantile: 1.96 }
        })
        .collect()
}

/// A zero, a resonance and a delay.
fn resonant() -> ContinuousTransfer {
    ContinuousTransfer { numerator: vec![4.0e4, 90.0], denominator: vec![2500.0, 12.0, 1.0], delay_s: 3e-3 }
}

const RESONANT: Structure = Structure {
    zeros: 1,
    poles: 2,
    delay: Delay::Free,
    compared: Compared::GainAndPhase,
    weights: Weights::Equal,
};

#[test]
fn exact_transfer_function_is_found_again_without_noise() {
    let found = identified(fit(&response_of(&resonant(), [0.5, 80.0], 40, 0.0, 1), RESONANT).unwrap());
    let truth = resonant();
    for (found, truth) in found.transfer.numerator.iter().zip(&truth.numerator) {
        near(*found, *truth, 1e-6);
    }
    for (found, truth) in found.transfer.denominator.iter().zip(&truth.denominator) {
        near(*found, *truth, 1e-6);
    }
    near(found.transfer.delay_s, truth.delay_s, 1e-6);
    assert!(found.deviation < 1e-7, "{}", found.deviation);
    for pole in found.transfer.poles() {
        assert!((pole.re + 6.0).abs() < 1e-4 && (pole.im.abs() - 2464f64.sqrt()).abs() < 1e-4, "{pole}");
    }
}

/// 95 % intervals cover the truth in 95 % of the draws, with either weighting: 5 coefficients and the static gain, 200 draws.
#[test]
fn exact_intervals_cover() {
    let truth = resonant();
    for weights in [Weights::Equal, Weights::ByNoise] {
        let (mut covered, mut asked) = (0, 0);
        for seed in 0..200 {
            let points = response_of(&truth, [0.5, 80.0], 40, 0.01, seed);
            let found = identified(fit(&points, Structure { weights, ..RESONANT }).unwrap());
            let pairs = found.numerator.iter().zip(&truth.numerator);
            let pairs = pairs.chain(found.denominator.iter().zip(&truth.denominator));
            let (delay, gain) = (found.delay_s.unwrap(), found.static_gain.unwrap());
            let more = [(&delay, &truth.delay_s), (&gain, &16.0)];
            for (estimate, truth) in pairs.chain(more) {
                covered += usize::from(estimate.covers(*truth));
                asked += 1;
            }
        }
        let share = f64::from(covered as u32) / f64::from(asked as u32);
        // Six numbers a draw go together: 200 draws leave a standard error of at most 1.5 %.
        assert!((0.91..0.99).contains(&share), "{weights:?}: {share}");
    }
}

/// Where half of the points are noisier, weighting by noise is the better estimate.
#[test]
fn exact_weights_by_noise_sharpen() {
    let truth = ContinuousTransfer { numerator: vec![9975.0], denominator: vec![1.6, 1.0], delay_s: 0.0 };
    let structure = Structure { delay: Delay::Known(0.0), ..FIRST_ORDER };
    let spread = |weights| {
        let off = |seed| {
            let mut points = response_of(&truth, [0.03, 10.0], 30, 0.005, seed);
            for point in points.iter_mut().skip(1).step_by(2) {
                // Ten times the noise of the others.
                let more = point.response() / truth.response(point.frequency_hz) - 1.0;
                let value = truth.response(point.frequency_hz) * (more * 5.0 + 1.0);
                (point.re, point.im, point.relative_sd) = (value.re, value.im, 5.0 * point.relative_sd);
            }
            let found = identified(fit(&points, Structure { weights, ..structure }).unwrap());
            (found.transfer.denominator[0] - 1.6).powi(2)
        };
        (0..60).map(off).sum::<f64>()
    };
    let [equal, by_noise] = [Weights::Equal, Weights::ByNoise].map(spread);
    assert!(by_noise < 0.25 * equal, "{by_noise} {equal}");
}

#[test]
fn exact_fit_refuses_what_the_points_do_not_tell() {
    let truth = ContinuousTransfer { numerator: vec![9975.0], denominator: vec![1.6, 1.0], delay_s: 0.0 };
    let all = response_of(&truth, [0.03, 10.0], 30, 0.001, 3);
    let kind = |points: &[Point], structure| fit(points, structure).unwrap_err().kind();
    assert_eq!(kind(&all[..3], FIRST_ORDER), ErrorKind::TooLittleData);
    assert_eq!(kind(&all, Structure { zeros: 2, ..FIRST_ORDER }), ErrorKind::OutOfRange);
    assert_eq!(kind(&all, Structure { compared: Compared::Gain, ..FIRST_ORDER }), ErrorKind::Inconsistent);
    let mut broken = all.clone();
    broken[4].re = f64::NAN;
    assert_eq!(kind(&broken, FIRST_ORDER), ErrorKind::NotFinite);
    // One frequency, many times: a line of transfer functions goes through it.
    let same = vec![all[10]; 30];
    match fit(&same, RESONANT) {
        Ok(Outcome::NotExcited(why)) => assert!(why.condition > 1e8, "{why}"),
        Ok(Outcome::Identified(found)) => panic!("{:?}", found.transfer),
        Err(error) => assert_eq!(error.kind(), ErrorKind::Undetermined),
    }
    // Far above the corner nothing tells it: its interval reaches to the other side of zero.
    let above = response_of(&truth, [1e3, 1e5], 30, 0.001, 5);
    let found = identified(fit(&above, FIRST_ORDER).unwrap());
    assert!(found.denominator[0].covers(0.0), "{:?}", found.denominator);
}

// ---- one sine ------------------------------------------------------------------------------------

fn sine(samples: usize, amplitude: impl Fn(f64) -> f64, turns: f64, phase: f64) -> Vec<f64> {
    (0..samples).map(|k| amplitude(k as f64) * (TAU * turns * k as f64 + phase).sin()).collect()
}

#[test]
fn exact_gain_and_phase_of_a_sine() {
    let (u, y) = (sine(4000, |_| 0.1, 0.013, 0.4), sine(4000, |_| 62.0, 0.013, -1.1));
    for (gain, drift) in [(Gain::Peaks, 0.0), (Gain::Fundamental, 1e-3)] {
        // An offset and a drift, as a coasting axis has them; a drift shifts the peaks of a period against each other.
        let y: Vec<f64> = y.iter().enumerate().map(|(k, y)| y + 30.0 + drift * k as f64).collect();
        let found = settled(&u, &y, 2e-3, 0.013 / 2e-3, gain).unwrap();
        near(found.point.response().norm(), 620.0, 1e-4);
        assert!((found.point.response().arg() + 1.5).abs() < 1e-6);
        assert_eq!(found.periods, 26);
    }
    // A third harmonic of a tenth: the peaks of sin x + sin(3x)/10 are 0.9 at π/2, its fundamental 1.
    let bent: Vec<f64> = sine(4000, |_| 1.0, 0.013, 0.0)
        .iter()
        .zip(sine(4000, |_| 0.1, 0.039, 0.0))
        .map(|(a, b)| a + b)
        .collect();
    let fundamental = settled(&u, &bent, 2e-3, 0.013 / 2e-3, Gain::Fundamental).unwrap();
    near(fundamental.output_amplitude, 1.0, 1e-3);
    let by_peaks = settled(&u, &bent, 2e-3, 0.013 / 2e-3, Gain::Peaks).unwrap();
    assert!((0.88..0.93).contains(&by_peaks.output_amplitude), "{}", by_peaks.output_amplitude);
}

#[test]
fn exact_runs_that_are_no_settled_sine_are_refused() {
    let u = sine(4000, |_| 0.1, 0.013, 0.0);
    let frequency_hz = 0.013 / 2e-3;
    let growing = sine(4000, |k| 1.0 + k / 4000.0, 0.013, 0.0);
    let error = settled(&u, &growing, 2e-3, frequency_hz, Gain::Peaks).unwrap_err();
    assert!(error.to_string().contains("output"), "{error}");
    let error = settled(&growing, &u, 2e-3, frequency_hz, Gain::Peaks).unwrap_err();
    assert!(error.to_string().contains("input"), "{error}");
    // Too short, too fast, another frequency.
    assert_eq!(
        settled(&u[..200], &u[..200], 2e-3, frequency_hz, Gain::Peaks).unwrap_err().kind(),
        ErrorKind::TooLittleData
    );
    assert_eq!(settled(&u, &u, 2e-3, 200.0, Gain::Peaks).unwrap_err().kind(), ErrorKind::OutOfRange);
    assert_eq!(
        settled(&u, &u, 2e-3, 2.0 * frequency_hz, Gain::Peaks).unwrap_err().kind(),
        ErrorKind::Undetermined
    );
    // A run without a sine, its frequency not stated.
    let still = BTreeMap::from([(Signal::Current, vec![0.1; 500]), (Signal::Velocity, vec![0.0; 500])]);
    let run = Run::new("still", Motion::Revolute, 2e-3, still).unwrap();
    let error = sines(&[&run], Signal::Current, Signal::Velocity, Gain::Peaks).unwrap_err();
    assert!(error.to_string().contains("still"), "{error}");
    let error = sines(&[&run], Signal::Thrust, Signal::Velocity, Gain::Peaks).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Missing);
}

// ---- the command ---------------------------------------------------------------------------------

fn slideway(arguments: &[&str]) -> Output {
    Process::new(env!("CARGO_BIN_EXE_slideway")).args(arguments).output().unwrap()
}

#[test]
fn ref_command_shows_the_published_transfer_function() {
    let place = tempfile::tempdir().unwrap();
    let page = place.path().join("sweep.html");
    let machine = folder().display().to_string();
    let base = ["identify", "sweep", "--machine", &machine, "--peak-to-peak", "0.2", "--band"];
    let html = page.display().to_string();
    let figures = place.path().join("figures").display().to_string();
    let shown = slideway(&[&base[..], &["0.2..60rad/s", "--html", &html, "--figures", &figures]].concat());
    assert!(shown.status.success(), "{}", String::from_utf8_lossy(&shown.stderr));
    let text = String::from_utf8_lossy(&shown.stdout).into_owned();
    assert!(text.contains("30 sines") && text.contains("75.89"), "{text}");
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("Bode") && page.contains("<svg"));
    assert!(place.path().join("figures/sweep.svg").is_file());
    // The same band in Hz is not the same band.
    let refused = slideway(&[&base[..], &["0.2..600"]].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--band"));
    let refused = slideway(&["identify", "sweep", "--machine", &machine]);
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--peak-to-peak"));
}

#[test]
fn exact_sweep_refuses_bands_points_and_amplitudes() {
    let runs = SineSweep::logarithmic([2.0, 4.0], 2, 0.1)
        .unwrap()
        .runs(&servo(), PlantChoice::Axis, |_| ())
        .unwrap();
    let lengths: Vec<usize> = runs.iter().map(Run::len).collect();
    assert!(lengths.iter().all(|length| *length > 1000), "{lengths:?}");
    for (points, band, amplitude) in [(1, [1.0, 2.0], 0.1), (5, [2.0, 1.0], 0.1), (5, [1.0, 2.0], 0.0)] {
        let error = SineSweep::logarithmic(band, points, amplitude).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::OutOfRange);
    }
}
