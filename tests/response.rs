//! Frequency response: the linear loop against the twin it describes, margins against closed forms, estimators and modal fits
//! against known systems.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};

use nalgebra::Complex;
use slideway::controller::Gains;
use slideway::error::ErrorKind;
use slideway::identify::margins::Margins;
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::replay::{follow, run};
use slideway::twin::{Command, LinearLoop, Sensing, Twin};

fn models(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)
}

fn machine_with(name: &str, settings: &[(&str, f64)]) -> Machine {
    let machine = Machine::read(&models(name)).unwrap();
    let values: Vec<(String, toml::Value)> =
        settings.iter().map(|(path, value)| ((*path).to_owned(), toml::Value::Float(*value))).collect();
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
    let (gain, lag) = (50.0, 0.04);
    let open = |f: f64| {
        let s = Complex::new(0.0, TAU * f);
        (s * (s * lag + 1.0)).inv() * gain
    };
    let margins = Margins::refined(&on(even(0.01, 1000.0, 300), open), open);
    let crossover = ((((1.0 + 4.0 * (gain * lag).powi(2)) as f64).sqrt() - 1.0) / (2.0 * lag * lag)).sqrt();
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

#[test]
fn throwaway_cost() {
    let stated = LinearLoop::of(&machine_with("grinder", &[])).unwrap();
    for part in 0..3 {
        let start = std::time::Instant::now();
        let mut sum = 0.0;
        for k in 0..3600 {
            let l = stated.retuned(scaled(stated.gains(), 0.5 + 1e-4 * f64::from(k)));
            if part != 1 {
                sum += l.margins().modulus.unwrap().margin;
            }
            if part != 0 {
                sum += f64::from(u8::from(l.is_stable()));
            }
        }
        println!("{part} {:?} a setting, {sum}", start.elapsed() / 3600);
    }
}
