//! Frequency response: the linear loop against the twin it describes, margins against closed forms, estimators and modal fits
//! against known systems.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};

use nalgebra::Complex;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};
use slideway::controller::Gains;
use slideway::error::ErrorKind;
use slideway::guide::StepForce;
use slideway::identify::frequency_response::{Point, Signals, periodic, spectral, welch};
use slideway::identify::margins::Margins;
use slideway::identify::modes::{Hold, modes};
use slideway::identify::transfer::TransferFunction;
use slideway::machine::Machine;
use slideway::plant::axis::{Axis, SampledResponse};
use slideway::plant::rapier::Rig;
use slideway::plant::{Drive, Plant};
use slideway::replay::PlantChoice;
use slideway::replay::excitation::Excitation;
use slideway::replay::multisine::{Injection, Limits, Multisine, Peaks, Request, Wave};
use slideway::replay::{follow, run};
use slideway::twin::{Command, LinearLoop, Sensing, Twin};

fn models(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)
}

fn machine_with(name: &str, settings: &[(&str, f64)]) -> Machine {
    let machine = Machine::read(&models(name)).unwrap();
    // A register holds whole numbers.
    let value = |path: &str, number: f64| match path {
        "controller.integral" => toml::Value::Integer(number as i64),
        _ => toml::Value::Float(number),
    };
    let values: Vec<(String, toml::Value)> =
        settings.iter().map(|(path, number)| ((*path).to_owned(), value(path, *number))).collect();
    machine.with_settings(values.iter().map(|(path, value)| (path.as_str(), value.clone()))).unwrap()
}

fn even(from: f64, to: f64, count: i32) -> Vec<f64> {
    (0..count).map(|k| from * (to / from).powf(f64::from(k) / f64::from(count - 1))).collect()
}

fn on(grid: Vec<f64>, open: impl Fn(f64) -> Complex<f64>) -> Vec<(f64, Complex<f64>)> {
    grid.into_iter().map(|f| (f, open(f))).collect()
}

// --- margins ---

#[test]
fn exact_margins_of_an_integrator_with_a_delay() {
    let (gain, delay) = (30.0, 0.01);
    let open = |f: f64| Complex::from_polar(gain / (TAU * f), -FRAC_PI_2 - TAU * f * delay);
    let grid = even(0.01, 100.0, 400);
    let margins = Margins::refined(&grid.iter().map(|f| (*f, open(*f))).collect::<Vec<_>>(), open);
    let phase = margins.phase.unwrap();
    assert!((phase.frequency_hz - gain / TAU).abs() < 1e-9);
    assert!((phase.margin_deg - (90.0 - (gain * delay).to_degrees())).abs() < 1e-8);
    let up = margins.gain.unwrap();
    assert!((up.frequency_hz - 0.25 / delay).abs() < 1e-8);
    assert!((up.margin_db - 20.0 * (FRAC_PI_2 / (delay * gain)).log10()).abs() < 1e-9);
    assert!((margins.delay.unwrap().margin_s - (FRAC_PI_2 / gain - delay)).abs() < 1e-10);
    assert!(margins.gain_down.is_none());
    // |1 + L|² of this loop, on a grid a thousand times as close.
    let nearest =
        even(1.0, 50.0, 400_000).into_iter().map(|f| (open(f) + 1.0).norm()).fold(f64::MAX, f64::min);
    let modulus = margins.modulus.unwrap();
    assert!((modulus.margin - nearest).abs() < 1e-8, "{} {nearest}", modulus.margin);
    assert!((modulus.largest_sensitivity() * nearest - 1.0).abs() < 1e-7);
    // From the points alone: |L| is a straight line over log f, its phase is not quite.
    let points: Vec<_> = grid.iter().map(|f| (*f, open(*f))).collect();
    let measured = Margins::of(&points).unwrap();
    assert!((measured.phase.unwrap().margin_deg - phase.margin_deg).abs() < 0.01);
    assert!((measured.gain.unwrap().margin_db - up.margin_db).abs() < 0.01);
}

#[test]
fn exact_margins_of_a_lag_with_an_integrator() {
    let (gain, lag) = (50.0_f64, 0.04);
    let open = |f: f64| {
        let s = Complex::new(0.0, TAU * f);
        (s * (s * lag + 1.0)).inv() * gain
    };
    let margins = Margins::refined(&on(even(0.01, 1000.0, 300), open), open);
    let crossover = (((1.0 + 4.0 * (gain * lag).powi(2)).sqrt() - 1.0) / (2.0 * lag * lag)).sqrt();
    let phase = margins.phase.unwrap();
    assert!((TAU * phase.frequency_hz / crossover - 1.0).abs() < 1e-10);
    assert!((phase.margin_deg - (90.0 - (crossover * lag).atan().to_degrees())).abs() < 1e-8);
    assert!(margins.gain.is_none() && margins.gain_down.is_none(), "its phase never reaches −180°");
}

#[test]
fn exact_a_conditionally_stable_loop_has_a_downward_margin() {
    // k·(s + 1)²/s³ crosses −180° at ω = 1 with |L| = 2k, from the unstable side.
    let open = |f: f64| {
        let s = Complex::new(0.0, TAU * f);
        (s + 1.0).powi(2) / s.powi(3) * 3.0
    };
    let margins = Margins::refined(&on(even(1e-3, 100.0, 300), open), open);
    let down = margins.gain_down.unwrap();
    assert!(
        (down.margin_db + 20.0 * 6f64.log10()).abs() < 1e-9 && (TAU * down.frequency_hz - 1.0).abs() < 1e-9
    );
    assert!(margins.gain.is_none());
}

#[test]
fn exact_a_sampled_integrator_has_its_margin_at_half_the_sampling_rate() {
    let (gain, period) = (0.4, 1e-3);
    let open = |f: f64| (Complex::from_polar(1.0, TAU * f * period) - 1.0).inv() * gain;
    let margins = Margins::refined(&on(even(0.1, 500.0, 300), open), open);
    let up = margins.gain.unwrap();
    assert!(
        (up.margin_db - 20.0 * (2.0 / gain).log10()).abs() < 1e-9 && (up.frequency_hz - 500.0).abs() < 1e-9
    );
}

#[test]
fn exact_the_edge_of_what_was_measured_is_no_modulus_margin() {
    let open = |f: f64| Complex::from_polar(30.0 / (TAU * f), -FRAC_PI_2 - TAU * f * 0.01);
    let nearest = Margins::of(&on(even(1.0, 50.0, 400), open)).unwrap().modulus.unwrap().frequency_hz;
    assert!((10.0..20.0).contains(&nearest), "{nearest}");
    for band in [[1.0, 0.8 * nearest], [1.2 * nearest, 50.0]] {
        let cut = Margins::of(&on(even(band[0], band[1], 400), open)).unwrap();
        assert_eq!(cut.modulus, None, "{band:?}");
    }
}

#[test]
fn exact_points_that_are_no_response_are_refused() {
    let one = Complex::new(1.0, 0.0);
    let kind = |points: &[(f64, Complex<f64>)]| Margins::of(points).unwrap_err().kind();
    assert_eq!(kind(&[(1.0, one)]), ErrorKind::TooLittleData);
    assert_eq!(kind(&[(1.0, one), (2.0, Complex::new(f64::NAN, 0.0))]), ErrorKind::NotFinite);
    assert_eq!(kind(&[(2.0, one), (1.0, one)]), ErrorKind::Inconsistent);
    assert_eq!(kind(&[(0.0, one), (1.0, one)]), ErrorKind::Inconsistent);
}

// --- the linear loop ---

/// Amplitude and phase of a steady periodic signal at a line, k turns in its length.
fn line(signal: &[f64], k: usize) -> Complex<f64> {
    let n = signal.len();
    let turn = |i: usize| Complex::from_polar(1.0, -TAU * ((i * k) % n) as f64 / n as f64);
    signal.iter().enumerate().map(|(i, x)| turn(i) * *x).sum()
}

/// Largest relative differences of the twin's steady response from the linear loop's, over lines up to near half the
/// sampling rate: position over reference, effort over injected voltage, position over injected voltage.
fn differences(machine: &Machine, periods: usize) -> [f64; 3] {
    let period_s = machine.description().sample_period_s;
    let samples = 4000;
    let lines: Vec<usize> = vec![2, 3, 7, 13, 29, 51, 87, 90, 137, 163, 310, 701, 1201, 1777];
    let linear = LinearLoop::of(machine).unwrap();
    let hz = |k: usize| k as f64 / (samples as f64 * period_s);
    let wave = |i: usize, size: f64| -> f64 {
        let one = |(m, k): (usize, &usize)| {
            (TAU * ((i * k) % samples) as f64 / samples as f64 + (m * m) as f64).sin()
        };
        size * lines.iter().enumerate().map(one).sum::<f64>()
    };
    let mut twin = Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let steady: Vec<f64> = (0..periods * samples).map(|i| wave(i, 1e-4)).collect();
    let last = (periods - 1) * samples..;
    let followed = run(&mut twin, follow(&steady, period_s), |_| ());
    let mut twin = Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let pushed: Vec<Command> =
        steady.iter().map(|d| Command { disturbance_v: 1e3 * d, ..Command::follow(0.0, 0.0) }).collect();
    let pushed = run(&mut twin, pushed.into_iter(), |_| ());
    let mut worst = [0.0_f64; 3];
    for k in &lines {
        let (r, f) = (line(&steady[last.clone()], *k), hz(*k));
        let found = [
            line(&followed.position[last.clone()], *k) / r / linear.closed_loop(f),
            line(&pushed.effort_v[last.clone()], *k) / (r * 1e3) / linear.sensitivity(f),
            line(&pushed.position[last.clone()], *k) / (r * 1e3) / (linear.plant(f) * linear.sensitivity(f)),
        ];
        for (worst, ratio) in worst.iter_mut().zip(found) {
            *worst = worst.max((ratio - 1.0).norm());
        }
    }
    worst
}

#[test]
fn exact_the_linear_loop_is_the_twins_own_response() {
    let machines = [
        machine_with("grinder", &[]),
        machine_with("grinder", &[("amplifier.delay_s", 0.4e-3), ("reference.delay_s", 0.9e-3)]),
        machine_with("grinder", &[("motor.back_emf_v_s_per_m", 20.0), ("effect.payload.mass_kg", 9.0)]),
        machine_with("grinder_yaxis", &[]),
        machine_with("delta_a3", &[]),
    ];
    for machine in machines {
        let differences = differences(&machine, 12);
        // What is left is the start dying away and the rounding of twelve seconds.
        assert!(differences.iter().all(|d| *d < 1e-6), "{differences:?}");
    }
}

#[test]
fn exact_a_retuned_loop_is_the_loop_of_those_gains() {
    let stated = LinearLoop::of(&machine_with("grinder", &[])).unwrap();
    let other =
        LinearLoop::of(&machine_with("grinder", &[("controller.position_gain_per_s", 11.0)])).unwrap();
    let retuned = stated.retuned(other.gains());
    assert_eq!(retuned.margins(), other.margins());
    assert_ne!(stated.margins(), other.margins());
    assert!((retuned.open_loop(40.0) / (retuned.plant(40.0) * retuned.feedback(40.0)) - 1.0).norm() < 1e-12);
}

#[test]
fn exact_margins_between_grid_points_are_those_of_the_exact_response() {
    for name in ["grinder", "grinder_yaxis", "delta_a3"] {
        let linear = LinearLoop::of(&machine_with(name, &[])).unwrap();
        let points: Vec<_> =
            linear.linear_plant().frequencies_hz().map(|f| (f, linear.open_loop(f))).collect();
        let (exact, quick) = (Margins::refined(&points, |f| linear.open_loop(f)), linear.margins());
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-5 * a.abs();
        assert!(near(exact.gain.unwrap().margin_db, quick.gain.unwrap().margin_db), "{name}");
        assert!(near(exact.phase.unwrap().margin_deg, quick.phase.unwrap().margin_deg), "{name}");
        assert!(near(exact.modulus.unwrap().margin, quick.modulus.unwrap().margin), "{name}");
        assert!(near(exact.delay.unwrap().margin_s, quick.delay.unwrap().margin_s), "{name}");
    }
}

fn scaled(gains: Gains, factor: f64) -> Gains {
    Gains {
        integral: factor * gains.integral,
        error: factor * gains.error,
        velocity: factor * gains.velocity,
        ..gains
    }
}

#[test]
fn exact_stability_ends_at_the_gain_margin_and_at_the_delay_margin() {
    let machine = machine_with("grinder", &[]);
    let stated = LinearLoop::of(&machine).unwrap();
    let margins = stated.margins();
    assert!(stated.is_stable());
    let factor = 10f64.powf(margins.gain.unwrap().margin_db / 20.0);
    assert!(stated.retuned(scaled(stated.gains(), 0.999 * factor)).is_stable());
    assert!(!stated.retuned(scaled(stated.gains(), 1.001 * factor)).is_stable());
    let reached = stated.retuned(scaled(stated.gains(), factor)).margins();
    assert!(reached.modulus.unwrap().margin < 1e-3, "{reached:?}");
    let late = |share: f64| {
        let delay = margins.delay.unwrap().margin_s * share;
        LinearLoop::of(&machine_with("grinder", &[("amplifier.delay_s", delay)])).unwrap()
    };
    // A hold acts at the sample: the delay enters between two samples as part of one, within a hundredth here.
    assert!(late(0.99).is_stable() && !late(1.01).is_stable(), "{margins:?}");
}

#[test]
fn exact_beyond_the_gain_margin_the_twin_runs_away() {
    let stated = LinearLoop::of(&machine_with("grinder", &[])).unwrap();
    let factor = 10f64.powf(stated.margins().gain.unwrap().margin_db / 20.0);
    let [calm, wild] = [0.9, 1.1].map(|share| {
        let settings = [
            ("controller.integral_gain_per_count", share * factor * 6.942e-2),
            ("controller.proportional_gain_per_count", share * factor * 2.359e-4),
        ];
        let machine = machine_with("grinder", &settings);
        let mut twin = Twin::new(&machine, Axis::of(&machine.constants()), Sensing::Perfect);
        let mut reference = vec![1e-4; 8000];
        reference[0] = 0.0;
        let traces = run(&mut twin, follow(&reference, 250e-6), |_| ());
        traces.effort_v[7000..].iter().fold(0.0, |most: f64, u| most.max(u.abs()))
    });
    assert!(calm < 0.1 && wild > 10.0, "{calm} {wild}");
}

#[test]
fn exact_a_machine_without_a_controller_has_a_plant_but_no_loop() {
    let machine = Machine::read(&models("grinder")).unwrap();
    let mut constants = machine.constants();
    constants.controller = None;
    let plant = slideway::twin::LinearPlant::of_constants(&constants, 0.0);
    assert!(plant.plant(10.0).norm() > 0.0);
}

/// Largest distance from the start within a second, 0.1 mm away from where it is to be.
fn farthest(machine: &Machine) -> f64 {
    let mut twin = Twin::new(machine, Axis::of(&machine.constants()), Sensing::Perfect);
    let traces = run(&mut twin, follow(&vec![1e-4; 8000], 250e-6), |_| ());
    traces.position.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

#[test]
fn exact_a_gain_that_is_too_large_is_unstable_as_the_twin_shows() {
    let key = ["controller.integral", "controller.position_gain_per_s"];
    for (settings, is_stable) in [
        ([(key[0], 19.0), (key[1], 6.5)], true),
        ([(key[0], 5.0), (key[1], 3.0)], true),
        ([(key[0], 200.0), (key[1], 6.5)], false),
        ([(key[0], 400.0), (key[1], 3.0)], false),
    ] {
        let machine = machine_with("grinder", &settings);
        assert_eq!(LinearLoop::of(&machine).unwrap().is_stable(), is_stable, "{settings:?}");
        let farthest = farthest(&machine);
        assert!((farthest < 1e-3) == is_stable, "{settings:?}: {farthest}");
    }
}

#[test]
fn exact_a_loop_without_position_feedback_is_not_stable() {
    let stated = LinearLoop::of(&machine_with("grinder", &[])).unwrap();
    let gains = stated.gains();
    for gains in [
        Gains { integral: 0.0, ..gains },
        Gains { position: 0.0, ..gains },
        Gains { integral: 0.0, error: 0.0, velocity: 0.0, ..gains },
    ] {
        let other = stated.retuned(gains);
        assert!(!other.is_stable(), "{gains:?}");
        // What can be read off it does not fail.
        assert!(other.margins().modulus.is_some());
    }
}

#[test]
fn exact_an_unstable_twin_is_not_excited() {
    let machine = machine_with("grinder", &[("controller.integral", 200.0)]);
    let request = request(&machine, Injection::Voltage, Wave::Multisine);
    let error = Multisine::design(&machine, &request).unwrap_err();
    assert_eq!(error.key_name(), Some("controller"));
    assert!(error.to_string().contains("not stable"), "{error}");
}

// --- estimators ---

fn noise(seed: u64, count: usize, sd: f64) -> Vec<f64> {
    let mut random = StdRng::seed_from_u64(seed);
    (0..count).map(|_| sd * Distribution::<f64>::sample(&StandardNormal, &mut random)).collect()
}

/// Share of the points whose 95 % band of the magnitude, and of the phase, holds the truth.
fn covered(points: &[Point], truth: impl Fn(f64) -> Complex<f64>) -> [f64; 2] {
    let mut hits = [0.0; 2];
    for point in points {
        let truth = truth(point.frequency_hz);
        let [low, high] = point.magnitude_ci95();
        hits[0] += f64::from(u8::from((low..=high).contains(&truth.norm())));
        let off = (truth / point.response()).arg().to_degrees().abs();
        hits[1] += f64::from(u8::from(off <= point.phase_half_width_deg()));
    }
    hits.map(|hits| hits / points.len() as f64)
}

/// Bounds on the coverage of a 95 % band, counted over a thousand points.
const COVERAGE: std::ops::Range<f64> = 0.92..0.98;

fn plant() -> TransferFunction {
    TransferFunction::new(vec![0.0, 0.1, 0.06], vec![1.0, -1.2, 0.5], 1e-3).unwrap()
}

#[test]
fn exact_bands_cover_as_stated() {
    let mut points = Vec::new();
    for seed in 0..8 {
        let input = noise(3 * seed, 16_384, 1.0);
        let clean = plant().simulate(&input);
        let output: Vec<f64> =
            clean.iter().zip(noise(3 * seed + 1, 16_384, 0.3)).map(|(y, n)| y + n).collect();
        points.extend(
            welch(&input, &output, 1e-3, 256).unwrap().into_iter().filter(|p| p.frequency_hz < 499.0),
        );
    }
    let hits = covered(&points, |f| plant().response(f));
    assert!(hits.iter().all(|share| COVERAGE.contains(share)), "{hits:?}");
}

/// A loop around the plant: u = r − 0.8·y with noise on y; reference, input, output.
fn noisy_loop(reference: &[f64], seed: u64, sd: f64) -> [Vec<f64>; 2] {
    let disturbance = noise(seed, reference.len(), sd);
    let (system, mut input, mut clean, mut output) = (plant(), vec![], vec![], vec![]);
    let (b, a) = (system.numerator().to_vec(), system.denominator().to_vec());
    for k in 0..reference.len() {
        let past = |list: &[f64], back: usize| if k >= back { list[k - back] } else { 0.0 };
        let y = (1..3).map(|j| b[j] * past(&input, j) - a[j] * past(&clean, j)).sum::<f64>();
        clean.push(y);
        output.push(y + disturbance[k]);
        input.push(reference[k] - 0.8 * output[k]);
    }
    [input, output]
}

#[test]
fn exact_in_closed_loop_the_instrument_removes_the_bias() {
    let (mut direct, mut indirect) = (Vec::new(), Vec::new());
    for seed in 0..8 {
        let reference = noise(100 + seed, 16_384, 1.0);
        let [input, output] = noisy_loop(&reference, 200 + seed, 0.5);
        let keep = |points: Vec<Point>| points.into_iter().filter(|p| p.frequency_hz < 499.0);
        direct.extend(keep(welch(&input, &output, 1e-3, 256).unwrap()));
        let signals = Signals { instrument: &reference, input: &input, output: &output };
        indirect.extend(keep(spectral(&[signals], 1e-3, 256).unwrap()));
    }
    let hits = covered(&indirect, |f| plant().response(f));
    assert!(hits.iter().all(|share| COVERAGE.contains(share)), "{hits:?}");
    let biased = covered(&direct, |f| plant().response(f));
    assert!(biased[0] < 0.9, "the direct estimate leans towards −1/K: {biased:?}");
}

#[test]
fn exact_several_runs_are_averaged_together() {
    let input = noise(5, 8192, 1.0);
    let output: Vec<f64> =
        plant().simulate(&input).iter().zip(noise(6, 8192, 0.3)).map(|(y, n)| y + n).collect();
    let half =
        |k: usize| Signals::direct(&input[k * 4096..(k + 1) * 4096], &output[k * 4096..(k + 1) * 4096]);
    let one = spectral(&[half(0)], 1e-3, 256).unwrap();
    let both = spectral(&[half(0), half(1)], 1e-3, 256).unwrap();
    // Where the plant answers well above the noise; elsewhere |H| itself is mostly noise.
    let median = |points: &[Point]| {
        let coherent = points.iter().filter(|p| p.frequency_hz < 120.0);
        let mut all: Vec<f64> = coherent.map(|p| p.relative_sd).collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    };
    assert!((median(&one) / median(&both) / 2f64.sqrt() - 1.0).abs() < 0.1);
}

#[test]
fn exact_periods_give_the_response_without_leakage() {
    let lines: Vec<usize> = (3..400).collect();
    let one: Vec<f64> = (0..1000)
        .map(|i| {
            lines.iter().map(|k| (TAU * ((i * k) % 1000) as f64 / 1000.0 - (k * k) as f64 * 0.01).cos()).sum()
        })
        .collect();
    let reference = one.repeat(8);
    let [input, output] = noisy_loop(&reference, 1, 0.0);
    let exact = periodic(&[(&input, &output)], 1e-3, 1000, &lines, 2).unwrap();
    for point in &exact {
        assert!((point.response() / plant().response(point.frequency_hz) - 1.0).norm() < 1e-9, "{point:?}");
        assert!(point.coherence > 1.0 - 1e-12);
    }
    let mut points = Vec::new();
    for seed in 0..3 {
        let [input, output] = noisy_loop(&reference, 300 + seed, 3.0);
        points.extend(periodic(&[(&input, &output)], 1e-3, 1000, &lines, 2).unwrap());
    }
    let hits = covered(&points, |f| plant().response(f));
    assert!(hits.iter().all(|share| COVERAGE.contains(share)), "{hits:?}");
}

#[test]
fn exact_signals_that_tell_no_response_are_refused() {
    let signal = noise(1, 1000, 1.0);
    let short = Signals { instrument: &signal[1..], input: &signal, output: &signal };
    assert_eq!(spectral(&[short], 1e-3, 64).unwrap_err().key_name(), Some("input"));
    assert_eq!(spectral(&[], 1e-3, 64).unwrap_err().kind(), ErrorKind::TooLittleData);
    let pair = [(&signal[..], &signal[..])];
    assert_eq!(periodic(&pair, 1e-3, 400, &[1], 1).unwrap_err().key_name(), Some("period"));
    assert_eq!(periodic(&pair, 1e-3, 100, &[51], 1).unwrap_err().key_name(), Some("lines"));
    assert_eq!(periodic(&pair, 1e-3, 100, &[], 1).unwrap_err().key_name(), Some("lines"));
}

// --- modes ---

/// Natural frequencies and modal masses of the grinding machine's base, as stated.
const BASE: [(f64, f64); 5] =
    [(86.1, 1500.0), (88.69, 1800.0), (134.19, 2200.0), (140.92, 2500.0), (162.86, 3000.0)];

/// Response of a plant's position to a periodic force that is held over each sample, without friction but viscous.
fn forced(mut plant: impl Plant, period_s: f64, lines: std::ops::Range<usize>, sd: f64) -> Vec<Point> {
    let (samples, periods) = (4000, 8);
    let lines: Vec<usize> = lines.collect();
    let phase = |j: usize| -std::f64::consts::PI * ((j * j) as f64 / lines.len() as f64);
    let force: Vec<f64> = (0..samples)
        .map(|i| {
            let one = |(j, k): (usize, &usize)| {
                (TAU * ((i * k) % samples) as f64 / samples as f64 + phase(j)).cos()
            };
            lines.iter().enumerate().map(one).sum::<f64>()
        })
        .collect();
    let steps = (period_s / plant.step_s()).round() as usize;
    let (mut input, mut output) = (Vec::new(), Vec::new());
    for force in force.repeat(periods) {
        input.push(force);
        output.push(plant.position());
        for _ in 0..steps {
            plant.coast(Drive::Force(force));
            plant.advance(StepForce::ZERO, StepForce::ZERO);
        }
    }
    let output: Vec<f64> = output.iter().zip(noise(9, output.len(), sd)).map(|(y, n)| y + n).collect();
    periodic(&[(&input, &output)], period_s, samples, &lines, 4).unwrap()
}

#[test]
fn exact_force_response_is_that_of_the_axis() {
    let machine = machine_with("grinder", &[]);
    let constants = machine.constants();
    let response = SampledResponse::to_force(&constants);
    for point in forced(Axis::of(&constants), constants.sample_period_s, 5..300, 0.0) {
        assert!((point.response() / response.position(point.frequency_hz) - 1.0).norm() < 1e-6, "{point:?}");
    }
}

#[test]
fn exact_modes_of_a_response_without_noise_are_those_stated() {
    let constants = machine_with("grinder", &[]).constants();
    let response = SampledResponse::to_force(&constants);
    let points: Vec<Point> = (5..300)
        .map(|k| {
            let (frequency_hz, value) = (f64::from(k), response.position(f64::from(k)));
            Point {
                frequency_hz,
                re: value.re,
                im: value.im,
                coherence: 1.0,
                relative_sd: 1e-5,
                quantile: 2.0,
            }
        })
        .collect();
    for number in [Some(5), None] {
        let found = modes(&points, constants.sample_period_s, Hold::Zero, number).unwrap();
        assert_eq!(found.modes.len(), 5);
        assert!((found.moving_mass.value / constants.moving_mass - 1.0).abs() < 1e-5);
        assert!((found.viscous.value / constants.viscous - 1.0).abs() < 1e-4);
        for (mode, (frequency, mass)) in found.modes.iter().zip(BASE) {
            assert!((mode.frequency_hz.value / frequency - 1.0).abs() < 1e-6, "{mode:?}");
            assert!((mode.damping_ratio.value / 0.02 - 1.0).abs() < 1e-4, "{mode:?}");
            assert!((mode.mass.value / mass - 1.0).abs() < 1e-4, "{mode:?}");
        }
    }
}

#[test]
fn ref_base_modes_are_found_from_the_rigid_body_scene() {
    let machine = machine_with("grinder", &[]);
    let rig = Rig::new(&machine).unwrap();
    let points = forced(rig, machine.description().sample_period_s, 5..300, 1e-10);
    let found = modes(&points, machine.description().sample_period_s, Hold::Zero, None).unwrap();
    assert_eq!(found.modes.len(), 5, "{found:?}");
    for (mode, (frequency, _)) in found.modes.iter().zip(BASE) {
        let off = [mode.frequency_hz.value / frequency - 1.0, mode.damping_ratio.value / 0.02 - 1.0];
        assert!(off[0].abs() < 1e-3 && off[1].abs() < 0.05, "{mode:?}");
    }
}

#[test]
fn exact_a_response_without_a_peak_is_refused() {
    let machine = machine_with("grinder", &[]);
    let mut constants = machine.constants();
    constants.modes = slideway::base::Modes::default();
    let points = forced(Axis::of(&constants), constants.sample_period_s, 5..300, 1e-8);
    let error = modes(&points, constants.sample_period_s, Hold::Zero, None).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Undetermined, Some("modes")));
    let few = modes(&points[..8], constants.sample_period_s, Hold::Zero, None).unwrap_err();
    assert_eq!(few.kind(), ErrorKind::TooLittleData);
}

#[test]
fn exact_a_residual_within_its_deviation_does_not_narrow_intervals() {
    let constants = machine_with("grinder", &[]).constants();
    let response = SampledResponse::to_force(&constants);
    let with = |relative_sd: f64| {
        let point = |k: i32| {
            let (frequency_hz, value) = (f64::from(k), response.position(f64::from(k)));
            Point { frequency_hz, re: value.re, im: value.im, coherence: 1.0, relative_sd, quantile: 2.0 }
        };
        let points: Vec<Point> = (5..300).map(point).collect();
        modes(&points, constants.sample_period_s, Hold::Zero, Some(5)).unwrap()
    };
    let (fine, coarse) = (with(1e-4), with(1e-3));
    assert!(coarse.residual < 0.1, "{}", coarse.residual);
    let ratio = coarse.modes[0].frequency_hz.standard_error / fine.modes[0].frequency_hz.standard_error;
    assert!((ratio / 10.0 - 1.0).abs() < 0.01, "{ratio}");
}

// --- excitation ---

fn request(machine: &Machine, injection: Injection, wave: Wave) -> Request {
    Request { band_hz: [5.0, 300.0], resolution_hz: 1.0, injection, wave, limits: Limits::of(machine, 0.25) }
}

#[test]
fn exact_an_excitation_stays_within_its_limits_and_is_as_predicted() {
    let machine = machine_with("grinder", &[("amplifier.voltage_limit_v", 10.0)]);
    for (injection, wave) in [
        (Injection::Voltage, Wave::Multisine),
        (Injection::Voltage, Wave::Sweep),
        (Injection::Reference, Wave::Multisine),
    ] {
        let request = request(&machine, injection, wave);
        let found = Multisine::design(&machine, &request).unwrap();
        let limits = request.limits;
        let simulated = found.simulated;
        assert!(simulated.effort_v <= limits.effort_v.unwrap() * 1.000_001, "{found:?}");
        assert!(simulated.position <= limits.position.unwrap() && simulated.thrust <= limits.thrust.unwrap());
        let traces = found.excite(&machine, PlantChoice::Axis, Sensing::Perfect, 6).unwrap();
        let steady =
            traces.effort_v[5 * found.period.len()..].iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        assert!((steady / found.predicted.effort_v - 1.0).abs() < 1e-3, "{steady} {:?}", found.predicted);
        assert!(found.crest_factor() < 2.5, "{}", found.crest_factor());
        assert_eq!(
            Peaks::about(0.0, &traces).effort_v.max(simulated.effort_v),
            Peaks::about(0.0, &traces).effort_v
        );
    }
}

#[test]
fn exact_an_excitation_stands_in_the_middle_of_the_travel() {
    let machine = machine_with("grinder_yaxis", &[]);
    let joint = &machine.solid().joint;
    assert_eq!((joint.lower, joint.middle(), joint.upper), (0.0, 1.0, 2.0));
    for injection in [Injection::Voltage, Injection::Reference] {
        let limits = Limits::of(&machine, 0.25);
        assert_eq!(limits.position, Some(0.25));
        let band_hz = [1.0, 30.0];
        let request = Request { band_hz, limits, ..request(&machine, injection, Wave::Multisine) };
        let found = Multisine::design(&machine, &request).unwrap();
        assert!(found.simulated.position <= 0.25 && found.simulated.position > 1e-6, "{:?}", found.simulated);
        let reference = found.reference(1);
        let mean = reference.iter().sum::<f64>() / reference.len() as f64;
        assert!((mean - 1.0).abs() < 1e-9, "{mean}");
        let traces = found.excite(&machine, PlantChoice::Rapier, Sensing::Perfect, 3).unwrap();
        let peaks = Peaks::about(1.0, &traces);
        assert!((peaks.position / found.simulated.position - 1.0).abs() < 0.02, "{peaks:?}");
    }
}

#[test]
fn exact_random_forces_keep_the_axis_off_its_end_stops() {
    let machine = machine_with("grinder_yaxis", &[]);
    let constants = machine.constants();
    let excitation = Excitation { period_s: 0.025, samples: 1000, seed: 1 };
    let excited = excitation.run(&machine, PlantChoice::Rapier).unwrap();
    let fastest = excited.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let z = constants.viscous * 0.025 / constants.moving_mass;
    let gain = if z > 0.0 { (1.0 - (-z).exp()) / constants.viscous } else { 0.025 / constants.moving_mass };
    for (k, pair) in excited.velocity.windows(2).enumerate() {
        let off = pair[1] - (-z).exp() * pair[0] - gain * excited.force[k];
        assert!(off.abs() < 1e-6 * fastest, "sample {k}: {off}");
    }
}

#[test]
fn exact_below_the_bandwidth_the_injected_voltage_is_what_the_machine_can_use() {
    let machine = machine_with("grinder", &[]);
    let good = request(&machine, Injection::Voltage, Wave::Multisine);
    let request = Request { band_hz: [0.1, 0.5], resolution_hz: 0.1, ..good };
    let found = Multisine::design(&machine, &request).unwrap();
    // The joint's 2000 N through 1.3 Ω and 83.1 N/A.
    let usable = 2000.0 * 1.3 / 83.1;
    // Never more, though below the bandwidth the loop takes an injected voltage off again and no peak limits it; the joint's
    // other limits may ask for less.
    assert!(found.peak() <= usable * (1.0 + 1e-9) && found.peak() > 0.1 * usable, "{} V", found.peak());
    let error = request.check_length(1_000_000, 250e-6).unwrap_err();
    assert_eq!(error.key_name(), Some("--resolution"));
}

#[test]
fn exact_measured_loop_is_the_linear_one() {
    let machine = machine_with("grinder", &[("amplifier.delay_s", 0.4e-3)]);
    let linear = LinearLoop::of(&machine).unwrap();
    let found = Multisine::design(&machine, &request(&machine, Injection::Voltage, Wave::Multisine)).unwrap();
    let traces = found.excite(&machine, PlantChoice::Rapier, Sensing::Perfect, 6).unwrap();
    let back: Vec<f64> = found.command(6).iter().zip(&traces.effort_v).map(|(d, u)| d - u).collect();
    let runs = [(&traces.effort_v[..], &back[..])];
    let open = periodic(&runs, 250e-6, found.period.len(), &found.lines, 4).unwrap();
    for point in &open {
        let off = point.response() / linear.open_loop(point.frequency_hz) - 1.0;
        assert!(off.norm() < 5e-3, "{} Hz: {off}", point.frequency_hz);
    }
    let points: Vec<_> = open.iter().map(|p| (p.frequency_hz, p.response())).collect();
    let (measured, stated) = (Margins::of(&points).unwrap(), linear.margins());
    assert!((measured.phase.unwrap().margin_deg - stated.phase.unwrap().margin_deg).abs() < 0.3);
    assert!((measured.gain.unwrap().margin_db - stated.gain.unwrap().margin_db).abs() < 0.3);
}

#[test]
fn exact_bands_that_hold_nothing_are_refused() {
    let machine = machine_with("grinder", &[]);
    let good = request(&machine, Injection::Voltage, Wave::Multisine);
    let key =
        |request: Request| Multisine::design(&machine, &request).unwrap_err().key_name().map(str::to_owned);
    for band_hz in [[0.0, 100.0], [100.0, 5.0], [5.0, 2500.0], [f64::NAN, 5.0], [5.2, 5.4]] {
        assert_eq!(key(Request { band_hz, ..good }).as_deref(), Some("--band"));
    }
    for resolution_hz in [0.0, -1.0, f64::NAN, 4000.0, 1e-9] {
        assert_eq!(key(Request { resolution_hz, ..good }).as_deref(), Some("--resolution"));
    }
}

// --- the commands ---

const SLIDEWAY: &str = env!("CARGO_BIN_EXE_slideway");

/// Exit code, standard output, standard error.
fn slideway(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = std::process::Command::new(SLIDEWAY).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[track_caller]
fn refused(arguments: &[&str], words: &[&str]) {
    let (code, out, told) = slideway(arguments);
    assert_eq!((code, out.as_str()), (Some(2), ""), "{told}");
    for word in words {
        assert!(told.contains(word), "`{word}` is not in: {told}");
    }
}

/// Numbers of the row that begins with a name.
fn row(shown: &str, name: &str) -> Vec<f64> {
    let line =
        shown.lines().find(|line| line.trim_start().starts_with(name)).unwrap_or_else(|| panic!("{shown}"));
    line.trim_start()[name.len()..].split_whitespace().map(|word| word.parse().unwrap()).collect()
}

#[test]
fn exact_the_command_prints_margins_and_the_stated_modes() {
    let folder = tempfile::tempdir().unwrap();
    let (page, figures) = (folder.path().join("a.html"), folder.path().join("figures"));
    let machine = models("grinder").display().to_string();
    let more = ["--html", page.to_str().unwrap(), "--figures", figures.to_str().unwrap()];
    let (code, shown, told) =
        slideway(&[&["identify", "response", "--machine", &machine][..], &more].concat());
    assert_eq!((code, told.as_str()), (Some(0), ""));
    for (name, off) in [("gain margin, dB", 0.5), ("phase margin, °", 0.5), ("modulus margin", 0.01)] {
        let [stated, _, measured, _] = row(&shown, name)[..] else { panic!("{shown}") };
        assert!((stated - measured).abs() < off, "{name}: {stated} {measured}\n{shown}");
    }
    assert!(
        shown.contains(" kg and a viscous coefficient of ") && shown.contains(" N·s/m; residual"),
        "{shown}"
    );
    let modes: Vec<Vec<f64>> = (1..=5).map(|k| row(&shown, &format!("{k} "))).collect();
    for (mode, (frequency, _)) in modes.iter().zip(BASE) {
        assert!((mode[0] / frequency - 1.0).abs() < 1e-3 && (mode[3] / 0.02 - 1.0).abs() < 0.05, "{shown}");
    }
    assert!(std::fs::read_to_string(page).unwrap().contains("phase margin"));
    assert!(figures.join("response.svg").is_file() && figures.join("structure.svg").is_file());
}

#[test]
fn exact_strokes_show_the_open_loop_by_the_known_controller() {
    let machine = models("grinder").display().to_string();
    let start = ["identify", "response", "--machine", &machine, "--excitation", "strokes", "--plant", "axis"];
    let (code, shown, told) = slideway(&start);
    assert_eq!((code, told.as_str()), (Some(0), ""));
    assert!(
        shown.contains("controller as stated") && shown.contains("No resonance stands out between"),
        "{shown}"
    );
    let [stated, _, measured, _] = row(&shown, "phase margin, °")[..] else { panic!("{shown}") };
    // Eight strokes leave some degrees of scatter at the crossover.
    assert!((stated - measured).abs() < 8.0, "{shown}");
}

#[test]
fn exact_response_of_wrong_input_is_refused() {
    let machine = models("grinder").display().to_string();
    let response = |more: &[&'static str], words: &[&str]| {
        refused(&[&["identify", "response", "--machine", &machine][..], more].concat(), words);
    };
    response(&["--band", "300..5"], &["--band", "5..300"]);
    response(&["--band", "5..3000"], &["--band", "2000", "write"]);
    response(&["--resolution", "-1"], &["--resolution", "-1"]);
    response(&["--set", "controller.nonsense=3"], &["--set", "nonsense"]);
    response(
        &["--excitation", "strokes", "--plant", "axis", "--modes", "5"],
        &["modes", "ask for fewer modes"],
    );
    refused(&["identify", "response", "/no/such/place"], &["/no/such/place"]);
    refused(&["identify", "response"], &["--machine"]);
}

#[test]
fn exact_a_multisine_is_written_recorded_and_read() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sine");
    let (machine, place) = (models("grinder").display().to_string(), out.display().to_string());
    let start = ["identify", "multisine", &machine, "--band", "5..300", "--resolution", "1", "--out", &place];
    let (code, shown, told) = slideway(&start);
    assert_eq!((code, told.as_str()), (Some(0), ""));
    let [_, twin, allowed] = row(&shown, "thrust, N")[..] else { panic!("{shown}") };
    assert!(twin <= allowed, "{shown}");
    refused(&start, &["--out", "new folder"]);
    // The machine records what was played.
    let machine = machine_with("grinder", &[]);
    let csv = std::fs::read_to_string(out.join("command.csv")).unwrap();
    let command: Vec<f64> =
        csv.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let mut twin = Twin::new(&machine, Axis::of(&machine.constants()), Sensing::AsStated { seed: 3 });
    let commands = command.iter().map(|d| Command { disturbance_v: *d, ..Command::follow(0.0, 0.0) });
    let traces = run(&mut twin, commands, |_| ());
    let mut log = "time_s,disturbance_v,control_effort_v,position_m\n".to_owned();
    for (k, (d, (u, x))) in command.iter().zip(traces.effort_v.iter().zip(&traces.position)).enumerate() {
        log += &format!("{},{d:e},{u:e},{x:e}\n", k as f64 * 250e-6);
    }
    std::fs::write(out.join("measured.csv"), log).unwrap();
    let (code, shown, told) = slideway(&["identify", "response", &place]);
    assert_eq!((code, told.as_str()), (Some(0), ""));
    assert!(shown.contains("whole periods"), "{shown}");
    let [stated, _, measured, _] = row(&shown, "phase margin, °")[..] else { panic!("{shown}") };
    assert!((stated - measured).abs() < 0.2, "{shown}");
}

/// A recording of runs with a multisine, each of the machine with another integral gain.
fn recorded_with(folder: &Path, integrals: &[(&str, f64)]) -> String {
    let place = models("grinder").display().to_string();
    let mut head = format!("machine = {place:?}\nsample_period_s = 250e-6\n");
    for (name, integral) in integrals {
        let machine = machine_with("grinder", &[("controller.integral", *integral)]);
        let request = request(&machine, Injection::Voltage, Wave::Multisine);
        let design = Multisine::design(&machine, &request).unwrap();
        let sensing = Sensing::AsStated { seed: 3 };
        let traces = design.excite(&machine, PlantChoice::Axis, sensing, 4).unwrap();
        let mut log = "time_s,disturbance_v,control_effort_v,position_m\n".to_owned();
        for (k, d) in design.command(4).iter().enumerate() {
            let (u, x) = (traces.effort_v[k], traces.position[k]);
            log += &format!("{},{d:e},{u:e},{x:e}\n", k as f64 * 250e-6);
        }
        std::fs::write(folder.join(format!("{name}.csv")), log).unwrap();
        head += &format!(
            "[[run]]\nfile = \"{name}.csv\"\nset = {{ \"controller.integral\" = {integral} }}\n\
             excitation_period_s = 1.0\nexcitation_band_hz = [5.0, 300.0]\n"
        );
    }
    std::fs::write(folder.join("recording.toml"), head).unwrap();
    folder.display().to_string()
}

#[test]
fn exact_a_recordings_own_settings_are_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let place = recorded_with(folder.path(), &[("soft", 10.0), ("stiff", 19.0)]);
    refused(&["identify", "response", &place], &["stiff.set", "soft", "--run"]);
    let (code, _, told) = slideway(&["identify", "response", &place, "--of", "plant"]);
    assert_eq!((code, told.as_str()), (Some(0), ""), "one plant, whatever the controller");
    let mut margins = Vec::new();
    for name in ["soft", "stiff"] {
        let (code, shown, told) = slideway(&["identify", "response", &place, "--run", name]);
        assert_eq!((code, told.as_str()), (Some(0), ""));
        let [stated, _, measured, _] = row(&shown, "phase margin, °")[..] else { panic!("{shown}") };
        assert!((stated - measured).abs() < 0.5, "{name}: {shown}");
        margins.push(stated);
    }
    assert!((margins[0] - margins[1]).abs() > 2.0, "{margins:?}");
    refused(&["identify", "response", &place, "--run", "none"], &["--run", "soft, stiff"]);
}

#[test]
fn exact_an_unstable_loop_is_said_and_has_no_margins() {
    let folder = tempfile::tempdir().unwrap();
    let place = recorded_with(folder.path(), &[("one", 19.0)]);
    let text = std::fs::read_to_string(folder.path().join("recording.toml")).unwrap();
    std::fs::write(folder.path().join("recording.toml"), text.replace("= 19 }", "= 200 }")).unwrap();
    let (code, shown, told) = slideway(&["identify", "response", &place]);
    assert_eq!((code, told.as_str()), (Some(0), ""));
    assert!(shown.contains("NOT STABLE") && !shown.contains("linear loop "), "{shown}");
    let machine = models("grinder").display().to_string();
    for value in ["controller.integral=200", "controller.proportional=100000"] {
        let response = ["identify", "response", "--machine", &machine, "--set", value];
        refused(&response, &["machine.toml", "controller", "not stable"]);
        refused(&[&response[..], &["--excitation", "strokes"]].concat(), &["not stable"]);
    }
}

#[test]
fn exact_a_resolution_that_a_recording_does_not_have_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let place = recorded_with(folder.path(), &[("one", 19.0)]);
    let text = std::fs::read_to_string(folder.path().join("recording.toml")).unwrap();
    // Without its period it is read by segments.
    let text: String =
        text.lines().filter(|l| !l.starts_with("excitation_")).map(|l| format!("{l}\n")).collect();
    std::fs::write(folder.path().join("recording.toml"), text).unwrap();
    for value in ["0", "-1", "1e-300", "1e300", "nan"] {
        refused(&["identify", "response", &place, "--resolution", value], &["--resolution"]);
    }
    let (code, _, told) = slideway(&["identify", "response", &place, "--resolution", "2"]);
    assert_eq!((code, told.as_str()), (Some(0), ""));
}

#[test]
fn exact_multisine_of_wrong_input_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("sine").display().to_string();
    let machine = models("grinder").display().to_string();
    let multisine = |more: &[&'static str], words: &[&str]| {
        refused(&[&["identify", "multisine", &machine, "--out", &out][..], more].concat(), words);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "something was left behind");
    };
    multisine(&["--band", "5"], &["--band", "5..300"]);
    multisine(&["--band", "5..9000"], &["--band", "half the sampling rate"]);
    multisine(&["--band", "5.2..5.3"], &["--band", "at least one line"]);
    multisine(&["--band", "5..300", "--share", "2"], &["--share"]);
    multisine(&["--band", "5..300", "--resolution", "0"], &["--resolution"]);
    multisine(&["--band", "0.001..0.01", "--resolution", "0.001"], &["--resolution", "ten million"]);
}
