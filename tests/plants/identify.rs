//! Identification: known systems are recovered within the stated intervals, data that do not tell are
//! refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, Normal};
use slideway::controller::Controller;
use slideway::drive::printed::{self, ControlEffort, Variant};
use slideway::error::ErrorKind;
use slideway::identify::arx::{ArxModel, Orders, arx, arx_runs};
use slideway::identify::excitation::{Excitation, Outcome, persistence, persistence_order};
use slideway::identify::first_order::FirstOrder;
use slideway::identify::frequency_response::welch;
use slideway::identify::transfer::TransferFunction;
use slideway::identify::whiteness::Whiteness;
use slideway::machine::Machine;
use slideway::report::{Style, printed_equations};
use std::path::Path;

/// Noise-free data leave rounding times the condition number.
const NOISE_FREE: f64 = 1e-9;
/// Closed forms evaluated two ways differ by a few roundings.
const ROUNDING: f64 = 1e-12;
/// Bounds on the coverage of a 95 % interval, counted over some hundred seeds.
const COVERAGE: std::ops::Range<f64> = 0.90..0.99;

/// The grinding machine's controller period, winding and force constant, as published.
const PERIOD_S: f64 = 250e-6;
const RESISTANCE_OHM: f64 = 1.3;
const INDUCTANCE_H: f64 = 0.008;
const FORCE_CONSTANT_N_PER_A: f64 = 83.1;

fn noise(seed: u64, count: usize, sd: f64) -> Vec<f64> {
    let mut random = StdRng::seed_from_u64(seed);
    Normal::new(0.0, sd).unwrap().sample_iter(&mut random).take(count).collect()
}

fn transfer(numerator: &[f64], denominator: &[f64]) -> TransferFunction {
    TransferFunction::new(numerator.to_vec(), denominator.to_vec(), 0.01).unwrap()
}

/// y = (B u + e)/A from rest.
fn respond(system: &TransferFunction, input: &[f64], equation_error: &[f64]) -> Vec<f64> {
    let shaped =
        TransferFunction::new(vec![1.0], system.denominator().to_vec(), system.sample_period_s()).unwrap();
    let driven = system.simulate(input);
    driven.iter().zip(shaped.simulate(equation_error)).map(|(a, b)| a + b).collect()
}

fn identified<M: std::fmt::Debug>(outcome: Outcome<M>) -> M {
    match outcome {
        Outcome::Identified(model) => model,
        Outcome::NotExcited(why) => panic!("{why}"),
    }
}

fn parameters(model: &ArxModel) -> Vec<slideway::identify::least_squares::Estimate> {
    model.a.iter().chain(&model.b).copied().collect()
}

fn worktable() -> TransferFunction {
    TransferFunction::new(vec![0.0, 0.45], vec![1.0, -0.85], PERIOD_S).unwrap()
}

// --- transfer functions ---

#[test]
fn exact_lag_by_hand() {
    let lag = transfer(&[0.0, 0.45], &[1.0, -0.85]);
    assert_eq!(lag.to_string(), "0.45 z^-1 / (1 - 0.85 z^-1)");
    assert_eq!(lag.poles(), vec![Complex::new(0.85, 0.0)]);
    assert!(lag.zeros().is_empty());
    assert!((lag.dc_gain() - 3.0).abs() < ROUNDING);
    assert_eq!(lag.simulate(&[1.0, 0.0, 0.0]), vec![0.0, 0.45, 0.85 * 0.45]);
    assert!((lag.response(0.0) - 3.0).norm() < ROUNDING);
    // half the sampling rate: z = −1
    assert!((lag.response(50.0) + 0.45 / 1.85).norm() < ROUNDING);
}

#[test]
fn exact_text_of_polynomials() {
    assert_eq!(transfer(&[1.0, -0.5], &[1.0]).to_string(), "(1 - 0.5 z^-1)");
    assert_eq!(transfer(&[-1.0], &[2.0, 0.0, -2.0]).to_string(), "-0.5 / (1 - z^-2)");
    assert_eq!(transfer(&[0.0], &[1.0, 1e-9]).to_string(), "0 / (1 + 1e-9 z^-1)");
    assert_eq!(format!("{:.2}", transfer(&[0.0, 1.0 / 3.0], &[1.0, -0.5])), "0.33 z^-1 / (1 - 0.50 z^-1)");
}

#[test]
fn exact_stability() {
    assert!(transfer(&[1.0], &[1.0, -1.6, 0.8]).is_stable());
    assert!(!transfer(&[1.0], &[1.0, -1.0]).is_stable());
    assert!(!transfer(&[1.0], &[1.0, -1.8923, 0.886]).is_stable());
    assert_eq!(transfer(&[1.0], &[1.0, -1.0]).dc_gain(), f64::INFINITY);
}

#[test]
fn exact_bad_transfer_function_is_refused() {
    for (numerator, denominator, period, key) in [
        (vec![], vec![1.0], 0.1, "numerator"),
        (vec![1.0], vec![], 0.1, "denominator"),
        (vec![1.0], vec![0.0, 1.0], 0.1, "denominator"),
        (vec![f64::NAN], vec![1.0], 0.1, "numerator"),
        (vec![1.0], vec![1.0], 0.0, "sample_period_s"),
    ] {
        assert_eq!(TransferFunction::new(numerator, denominator, period).unwrap_err().key_name(), Some(key));
    }
    let slow = TransferFunction::new(vec![1.0], vec![1.0], 0.2).unwrap();
    let error = transfer(&[1.0], &[1.0]).multiply(&slow).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Inconsistent);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exact_series_is_one_after_the_other(
        b1 in prop::collection::vec(-1.0..1.0f64, 1..4),
        b2 in prop::collection::vec(-1.0..1.0f64, 1..4),
        p1 in -0.95..0.95f64,
        p2 in -0.95..0.95f64,
        frequency in 0.0..50.0f64,
        input in prop::collection::vec(-1.0..1.0f64, 1..40),
    ) {
        let (first, second) = (transfer(&b1, &[1.0, -p1]), transfer(&b2, &[1.0, -p2]));
        let series = first.multiply(&second).unwrap();
        let product = first.response(frequency) * second.response(frequency);
        prop_assert!((series.response(frequency) - product).norm() < 1e3 * ROUNDING * (1.0 + product.norm()));
        let chained = second.simulate(&first.simulate(&input));
        for (a, b) in series.simulate(&input).iter().zip(chained) {
            prop_assert!((a - b).abs() < 1e3 * ROUNDING);
        }
    }

    #[test]
    fn exact_poles_are_those_put_in(re in -0.9..0.9f64, im in 0.05..0.9f64, real in -0.9..0.9f64) {
        let pair = transfer(&[1.0], &[1.0, -2.0 * re, re * re + im * im]);
        let both = pair.multiply(&transfer(&[1.0], &[1.0, -real])).unwrap();
        for truth in [Complex::new(re, im), Complex::new(re, -im), Complex::new(real, 0.0)] {
            let nearest = both.poles().iter().map(|p| (p - truth).norm()).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest < NOISE_FREE, "{truth} in {:?}", both.poles());
        }
        let inside = re.hypot(im) < 1.0;
        prop_assert_eq!(both.is_stable(), inside);
    }
}

// --- the printed motor and plant ---

#[test]
fn ref_motor_and_plant_as_printed() {
    let (r, l, kt) = (RESISTANCE_OHM, INDUCTANCE_H, FORCE_CONSTANT_N_PER_A);
    let motor = printed::motor(Variant::AsPrinted, r, l, kt, PERIOD_S).unwrap();
    assert_eq!(format!("{:.4}", motor.poles()[0].re), "1.0423");
    assert!(!motor.is_stable());
    let plant = printed::plant(Variant::AsPrinted, &worktable(), r, l, kt).unwrap();
    assert_eq!(format!("{plant:.3}"), "1.218 z^-1 / (1 - 1.892 z^-1 + 0.886 z^-2)");
}

#[test]
fn ref_motor_and_plant_corrected() {
    let (r, l, kt) = (RESISTANCE_OHM, INDUCTANCE_H, FORCE_CONSTANT_N_PER_A);
    let motor = printed::motor(Variant::Corrected, r, l, kt, PERIOD_S).unwrap();
    assert_eq!(format!("{:.5}", motor.poles()[0].re), "0.96096");
    assert_eq!(format!("{:.4}", motor.numerator()[0]), "2.4955");
    assert_eq!(format!("{:.5}", printed::zero_order_hold_pole(r, l, PERIOD_S).unwrap()), "0.96019");
    // backward Euler keeps the steady force
    assert!((motor.dc_gain() - kt / r).abs() < NOISE_FREE);
    let plant = printed::plant(Variant::Corrected, &worktable(), r, l, kt).unwrap();
    assert_eq!(format!("{plant:.4}"), "1.1230 z^-1 / (1 - 1.8110 z^-1 + 0.8168 z^-2)");
    assert!(plant.is_stable());
}

#[test]
fn ref_control_effort_as_printed_and_corrected() {
    let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let Some(Controller::Pdf(law)) = &machine.description().controller else { panic!("no PDF law") };
    let [printed, corrected] =
        [Variant::AsPrinted, Variant::Corrected].map(|variant| ControlEffort::of(variant, law, PERIOD_S));
    assert_eq!(printed.to_string(), "4.75e-3 k1 e(k) + u1(k-1) + 260 k2 y(k)");
    assert_eq!(corrected.to_string(), "4.75e-3 k1 e(k) + u1(k-1) - 260 k2 y(k)");
    assert!(corrected.feeds_back_negatively() && !printed.feeds_back_negatively());
    // All of the equations from an identified W(z), which the paper rounds before it goes on.
    let identified = transfer(&[0.0, 0.449_97], &[1.0, -0.850_02]);
    let section = printed_equations(&machine, &identified).unwrap().unwrap();
    let text = section.text(Style { colour: false, width: 120 });
    for row in [
        "1 - 1.0423 z^-1",
        "1.0423: unstable",
        "1.218 z^-1 / (1 - 1.892 z^-1 + 0.886 z^-2)",
        "1.123 z^-1 / (1 - 1.811 z^-1 + 0.817 z^-2)",
    ] {
        assert!(text.contains(row), "{row} is not in\n{text}");
    }
}

#[test]
fn exact_motor_without_a_value_is_refused() {
    // R·T = L: the printed form divides by zero
    let error = printed::motor(Variant::AsPrinted, 2.0, 0.5, 1.0, 0.25).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Undetermined);
    assert_eq!(
        printed::motor(Variant::Corrected, -1.0, 0.5, 1.0, 0.25).unwrap_err().key_name(),
        Some("resistance_ohm")
    );
    assert_eq!(printed::zero_order_hold_pole(1.0, 0.0, 0.25).unwrap_err().key_name(), Some("inductance_h"));
}

// --- excitation ---

#[test]
fn exact_order_of_excitation() {
    let wave = |f: f64| (0..400).map(|k| (f * f64::from(k)).sin()).collect::<Vec<_>>();
    let two: Vec<f64> = wave(0.5).iter().zip(wave(1.3)).map(|(a, b)| a + b).collect();
    assert_eq!(persistence_order(&[0.0; 100], 5).unwrap(), 0);
    assert_eq!(persistence_order(&[2.5; 100], 5).unwrap(), 1);
    assert_eq!(persistence_order(&wave(0.5), 5).unwrap(), 2);
    assert_eq!(persistence_order(&two, 8).unwrap(), 4);
    assert_eq!(persistence_order(&noise(1, 400, 1.0), 20).unwrap(), 20);
}

#[test]
fn exact_condition_of_a_regressor_ignores_units() {
    let regressor = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 2e6, 0.0, 0.0]);
    let excitation = Excitation::of(&regressor).unwrap();
    assert!((excitation.condition() - 1.0).abs() < ROUNDING);
    // columns at 60°: singular values √(1 ± cos 60°)
    let oblique = DMatrix::from_row_slice(3, 2, &[1.0, 0.5, 0.0, 0.75_f64.sqrt(), 0.0, 0.0]);
    let excitation = Excitation::of(&oblique).unwrap();
    assert!((excitation.condition() - 3.0_f64.sqrt()).abs() < ROUNDING);
    let weak = excitation.weak_direction();
    assert!((weak[0] + weak[1]).abs() < ROUNDING, "{weak:?}");
}

#[test]
fn exact_regressor_with_a_repeated_column_is_refused() {
    let column = noise(3, 50, 1.0);
    let regressor =
        DMatrix::from_fn(
            50,
            3,
            |row, c| if c == 2 { 7.0 * column[row] } else { column[row] + c as f64 * row as f64 },
        );
    let excitation = Excitation::of(&regressor).unwrap();
    assert_eq!(excitation.rank(), 2);
    assert!(!excitation.is_full_rank());
    assert_eq!(Excitation::of(&DMatrix::zeros(2, 3)).unwrap_err().kind(), ErrorKind::TooLittleData);
    assert_eq!(persistence(&[&[1.0, f64::NAN, 2.0]], 1).unwrap_err().kind(), ErrorKind::NotFinite);
    assert_eq!(persistence(&[&[1.0]], 0).unwrap_err().kind(), ErrorKind::OutOfRange);
}

// --- ARX: recovery ---

/// Systems of several orders and delays.
fn systems() -> Vec<(TransferFunction, Orders)> {
    vec![
        (transfer(&[0.0, 0.45], &[1.0, -0.85]), Orders { na: 1, nb: 1, delay: 1 }),
        (transfer(&[0.3, 0.1], &[1.0, -0.5]), Orders { na: 1, nb: 2, delay: 0 }),
        (transfer(&[0.0, 0.0, 1.0, 0.5], &[1.0, -1.5, 0.7]), Orders { na: 2, nb: 2, delay: 2 }),
        (transfer(&[0.0, 0.0, 0.0, 0.2], &[1.0, -1.2, 0.7, -0.2]), Orders { na: 3, nb: 1, delay: 3 }),
        (transfer(&[0.0, 0.4, 0.3, 0.2, 0.1], &[1.0]), Orders { na: 0, nb: 4, delay: 1 }),
    ]
}

fn truth(system: &TransferFunction, orders: Orders) -> Vec<f64> {
    [&system.denominator()[1..], &system.numerator()[orders.delay..]].concat()
}

#[test]
fn exact_noise_free_systems_are_recovered() {
    for (system, orders) in systems() {
        let input = noise(7, 300, 1.0);
        let output = system.simulate(&input);
        let model = identified(arx(&input, &output, 0.01, orders).unwrap());
        for (estimate, truth) in parameters(&model).iter().zip(truth(&system, orders)) {
            assert!((estimate.value - truth).abs() < NOISE_FREE, "{system}: {}", model.transfer);
        }
        assert!(model.one_step_fit_percent.unwrap() > 99.999_999);
        assert!(model.free_run_fit_percent.unwrap() > 99.999_999);
        let free = model.simulate(&input, &[]);
        assert!(free.iter().zip(&output).all(|(a, b)| (a - b).abs() < 1e3 * NOISE_FREE));
    }
}

#[test]
fn exact_intervals_cover_as_stated() {
    const SEEDS: u64 = 300;
    for (system, orders) in systems() {
        let truth = truth(&system, orders);
        let mut covered = vec![0.0; truth.len()];
        for seed in 0..SEEDS {
            let input = noise(2 * seed, 400, 1.0);
            let output = respond(&system, &input, &noise(2 * seed + 1, 400, 0.3));
            let model = identified(arx(&input, &output, 0.01, orders).unwrap());
            for (count, (estimate, truth)) in covered.iter_mut().zip(parameters(&model).iter().zip(&truth)) {
                *count += f64::from(u8::from(estimate.covers(*truth))) / SEEDS as f64;
            }
        }
        for share in covered {
            assert!(COVERAGE.contains(&share), "{system}: {share}");
        }
    }
}

#[test]
fn exact_residual_spread_and_whiteness_are_those_put_in() {
    const SEEDS: u64 = 200;
    let (system, orders) = systems().swap_remove(2);
    let (mut white, mut spread) = (0.0, 0.0);
    for seed in 0..SEEDS {
        let input = noise(1000 + 2 * seed, 800, 1.0);
        let output = respond(&system, &input, &noise(1001 + 2 * seed, 800, 0.3));
        let model = identified(arx(&input, &output, 0.01, orders).unwrap());
        white += f64::from(u8::from(model.whiteness.is_white())) / SEEDS as f64;
        spread += model.residual_sd / SEEDS as f64;
        assert!(model.one_step_fit_percent.unwrap() >= model.free_run_fit_percent.unwrap());
    }
    // about 95 %, less three standard errors of 200 tries
    assert!((0.90..1.0).contains(&white), "{white}");
    // 200 × 800 samples give the mean spread to 0.2 %; four times that
    assert!((spread / 0.3 - 1.0).abs() < 0.008, "{spread}");
}

#[test]
fn exact_measurement_noise_is_flagged_as_not_white() {
    let (system, orders) = systems().swap_remove(0);
    let input = noise(5, 2000, 1.0);
    let output: Vec<f64> =
        system.simulate(&input).iter().zip(noise(6, 2000, 0.5)).map(|(y, n)| y + n).collect();
    let model = identified(arx(&input, &output, 0.01, orders).unwrap());
    assert!(!model.whiteness.is_white(), "{:?}", model.whiteness);
    assert!(model.whiteness.autocorrelation.iter().any(|r| r.abs() > 3.0 * model.whiteness.bound));
}

#[test]
fn exact_autocorrelation_by_hand() {
    let whiteness = Whiteness::of(&[&[1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0]]);
    assert!((whiteness.autocorrelation[0] + 7.0 / 8.0).abs() < ROUNDING);
    assert!((whiteness.autocorrelation[1] - 6.0 / 8.0).abs() < ROUNDING);
    // Q = N(N+2)·(r₁²/7 + r₂²/6)
    assert!((whiteness.statistic - 80.0 * (49.0 / 64.0 / 7.0 + 36.0 / 64.0 / 6.0)).abs() < 100.0 * ROUNDING);
    assert!(!whiteness.is_white());
    assert!(Whiteness::of(&[&[0.0; 10]]).is_white());
}

#[test]
fn exact_regressors_stay_inside_their_run() {
    let (system, orders) = systems().swap_remove(2);
    let inputs: Vec<_> = (0..3).map(|seed| noise(40 + seed, 60, 1.0)).collect();
    let outputs: Vec<_> = inputs.iter().map(|input| system.simulate(input)).collect();
    let runs: Vec<(&[f64], &[f64])> = inputs.iter().zip(&outputs).map(|(u, y)| (&u[..], &y[..])).collect();
    let model = identified(arx_runs(&runs, 0.01, orders).unwrap());
    assert!(model.residual_sd < NOISE_FREE);
    assert_eq!(model.degrees_of_freedom, 3 * (60 - 3) - 4);
    // end to end in one run the seams are equation errors of the size of the signal
    let seams = identified(arx(&inputs.concat(), &outputs.concat(), 0.01, orders).unwrap());
    assert!(seams.residual_sd > 1e-3);
}

// --- ARX: refusal ---

fn assert_not_excited(input: &[f64], system: &TransferFunction, orders: Orders) {
    for sd in [0.0, 0.1] {
        let output = respond(system, input, &noise(11, input.len(), sd));
        match arx(input, &output, 0.01, orders).unwrap() {
            Outcome::Identified(model) => panic!("identified {}", model.transfer),
            Outcome::NotExcited(why) => {
                assert!(why.condition > 1e8);
                assert!(why.weak_direction.iter().any(|(_, share)| share.abs() > 0.1));
                assert!(why.to_string().contains("input that keeps changing"), "{why}");
            }
        }
    }
}

#[test]
fn exact_constant_input_is_refused() {
    for (system, orders) in systems() {
        assert_not_excited(&[1.7; 300], &system, orders);
        assert_not_excited(&[0.0; 300], &system, orders);
    }
}

#[test]
fn exact_one_sine_for_four_parameters_is_refused() {
    let (system, orders) = systems().swap_remove(2);
    let sine: Vec<f64> = (0..400).map(|k| (0.4 * f64::from(k)).sin()).collect();
    assert_not_excited(&sine, &system, orders);
    // but it tells two
    let (lag, orders) = systems().swap_remove(0);
    let model = identified(arx(&sine, &lag.simulate(&sine), 0.01, orders).unwrap());
    assert!((model.a[0].value + 0.85).abs() < NOISE_FREE);
}

#[test]
fn exact_too_few_samples_are_refused() {
    let orders = Orders { na: 1, nb: 1, delay: 1 };
    let input = noise(1, 10, 1.0);
    let error = arx(&input, &input, 0.01, orders).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::TooLittleData);
    assert!(error.to_string().contains("9 usable samples"), "{error}");
    assert_eq!(arx(&[], &[], 0.01, orders).unwrap_err().kind(), ErrorKind::TooLittleData);
    assert_eq!(arx_runs(&[], 0.01, orders).unwrap_err().kind(), ErrorKind::TooLittleData);
}

#[test]
fn exact_broken_signals_are_refused() {
    let orders = Orders { na: 1, nb: 1, delay: 1 };
    let good = noise(1, 50, 1.0);
    let mut bad = good.clone();
    bad[17] = f64::NAN;
    let error = arx(&bad, &good, 0.01, orders).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::NotFinite, Some("input")));
    assert!(error.to_string().contains("sample 17"), "{error}");
    assert_eq!(arx(&good, &bad, 0.01, orders).unwrap_err().key_name(), Some("output"));
    assert_eq!(arx(&good, &good[1..], 0.01, orders).unwrap_err().kind(), ErrorKind::Inconsistent);
    assert_eq!(arx(&good, &good, -0.01, orders).unwrap_err().key_name(), Some("sample_period_s"));
    assert_eq!(arx(&good, &good, 0.01, Orders { nb: 0, ..orders }).unwrap_err().key_name(), Some("nb"));
}

// --- the table behind W(z) ---

/// Velocity in mm/s of a mass with viscous drag under random force steps held over each period: exact.
fn table(mass_kg: f64, viscous_n_s_per_m: f64, period_s: f64, force: &[f64]) -> Vec<f64> {
    let pole = (-viscous_n_s_per_m / mass_kg * period_s).exp();
    let mut velocity = 0.0;
    force
        .iter()
        .map(|f| {
            let before = velocity;
            velocity = pole * velocity + (1.0 - pole) / viscous_n_s_per_m * f;
            1000.0 * before
        })
        .collect()
}

const LAG: Orders = Orders { na: 1, nb: 1, delay: 1 };

#[test]
fn ref_worktable_at_25_ms_is_the_published_one() {
    // the inertia and drag are rounded to four digits
    const ROUNDED: f64 = 0.005;
    let force = noise(21, 400, 100.0);
    let velocity = table(51.28, 333.3, 0.025, &force);
    let model = identified(arx(&force, &velocity, 0.025, LAG).unwrap());
    assert!((model.b[0].value / 0.45 - 1.0).abs() < ROUNDED, "{}", model.transfer);
    assert!((-model.a[0].value / 0.85 - 1.0).abs() < ROUNDED, "{}", model.transfer);
    assert_eq!(format!("{:.2}", model.transfer), "0.45 z^-1 / (1 - 0.85 z^-1)");
    let axis = FirstOrder::of(&model, 1000.0).unwrap();
    assert!((axis.inertia.value / 51.28 - 1.0).abs() < NOISE_FREE, "{axis:?}");
    assert!((axis.viscous_coefficient.value / 333.3 - 1.0).abs() < NOISE_FREE, "{axis:?}");
    assert!((axis.decay_rate_per_s.value - 333.3 / 51.28).abs() < NOISE_FREE);
}

#[test]
fn ref_worktable_read_at_250_us_is_a_hundredth_of_the_mass() {
    let force = noise(22, 400, 1.0);
    let printed = worktable();
    let model = identified(arx(&force, &printed.simulate(&force), PERIOD_S, LAG).unwrap());
    let axis = FirstOrder::of(&model, 1000.0).unwrap();
    assert_eq!(format!("{:.1}", axis.viscous_coefficient.value), "333.3");
    assert_eq!(format!("{:.3}", axis.inertia.value), "0.513");
    let slow = identified(arx(&force, &printed.simulate(&force), 0.025, LAG).unwrap());
    assert_eq!(format!("{:.2}", FirstOrder::of(&slow, 1000.0).unwrap().inertia.value), "51.28");
}

#[test]
fn exact_intervals_of_inertia_and_drag_cover_as_stated() {
    const SEEDS: u64 = 300;
    let mut covered = [0.0; 3];
    for seed in 0..SEEDS {
        let force = noise(3 * seed, 400, 100.0);
        let pole: f64 = (-333.3_f64 / 51.28 * 0.025).exp();
        let lag =
            TransferFunction::new(vec![0.0, 1000.0 * (1.0 - pole) / 333.3], vec![1.0, -pole], 0.025).unwrap();
        let velocity = respond(&lag, &force, &noise(3 * seed + 1, 400, 10.0));
        let axis = FirstOrder::of(&identified(arx(&force, &velocity, 0.025, LAG).unwrap()), 1000.0).unwrap();
        let hits = [
            axis.decay_rate_per_s.covers(333.3 / 51.28),
            axis.viscous_coefficient.covers(333.3),
            axis.inertia.covers(51.28),
        ];
        for (count, hit) in covered.iter_mut().zip(hits) {
            *count += f64::from(u8::from(hit)) / SEEDS as f64;
        }
    }
    assert!(covered.iter().all(|share| COVERAGE.contains(share)), "{covered:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// z to s and back: mass and drag give a pole and a gain at any period and in any unit, and are read off them again.
    #[test]
    fn exact_lag_in_z_is_the_lag_in_s(
        mass in 0.01..500.0f64,
        decay in 0.5..200.0f64,
        period_s in 1e-4..5e-3f64,
        units in prop::sample::select(vec![1.0, 1000.0]),
    ) {
        let drag = decay * mass;
        let pole = (-decay * period_s).exp();
        let lag = TransferFunction::new(vec![0.0, units * (1.0 - pole) / drag], vec![1.0, -pole], period_s).unwrap();
        let force = noise(29, 400, 10.0);
        let model = identified(arx(&force, &lag.simulate(&force), period_s, LAG).unwrap());
        let read = FirstOrder::of(&model, units).unwrap();
        prop_assert!((read.inertia.value / mass - 1.0).abs() < 1e-6, "{read:?}");
        prop_assert!((read.viscous_coefficient.value / drag - 1.0).abs() < 1e-6, "{read:?}");
        prop_assert!((read.decay_rate_per_s.value / decay - 1.0).abs() < 1e-6, "{read:?}");
    }

    /// The winding's pole in z is that of R/L in s.
    #[test]
    fn exact_winding_in_z_is_the_winding_in_s(r in 0.05..50.0f64, l in 1e-4..0.1f64, period_s in 1e-5..1e-3f64) {
        let pole = printed::zero_order_hold_pole(r, l, period_s).unwrap();
        prop_assert!((-pole.ln() / period_s * l / r - 1.0).abs() < 1e-9);
        // Backward Euler is its first order: nearer the shorter the period.
        let euler = printed::motor(Variant::Corrected, r, l, 1.0, period_s).unwrap().poles()[0].re;
        let x = r * period_s / l;
        prop_assert!(euler >= pole && euler - pole <= 0.5 * x * x, "{euler} {pole}");
    }
}

#[test]
fn exact_model_that_is_no_lag_is_refused() {
    let force = noise(23, 400, 1.0);
    let fit = |b: &[f64], a: &[f64], orders| {
        identified(arx(&force, &transfer(b, a).simulate(&force), 0.01, orders).unwrap())
    };
    let alternating = fit(&[0.0, 0.45], &[1.0, 0.85], LAG);
    assert_eq!(FirstOrder::of(&alternating, 1.0).unwrap_err().key_name(), Some("pole"));
    let second = fit(&[0.0, 1.0], &[1.0, -1.5, 0.7], Orders { na: 2, nb: 1, delay: 1 });
    assert_eq!(FirstOrder::of(&second, 1.0).unwrap_err().key_name(), Some("orders"));
    let lag = fit(&[0.0, 0.45], &[1.0, -0.85], LAG);
    assert_eq!(FirstOrder::of(&lag, 0.0).unwrap_err().key_name(), Some("output_units_per_si"));
}

// --- frequency response ---

#[test]
fn exact_frequency_response_of_a_known_system() {
    // 78 segments: the relative scatter of a bin is √((1 − γ²)/(γ²·n)), about 0.02 with this noise; five
    // times that for the largest of 256
    const SCATTER: f64 = 0.1;
    let (system, _) = systems().swap_remove(0);
    let input = noise(51, 20_000, 1.0);
    let clean = system.simulate(&input);
    let output: Vec<f64> = clean.iter().zip(noise(52, 20_000, 0.05)).map(|(y, n)| y + n).collect();
    let points = welch(&input, &output, 0.01, 512).unwrap();
    assert_eq!(points.len(), 256);
    assert!((points[0].frequency_hz - 100.0 / 512.0).abs() < ROUNDING);
    for point in &points {
        let truth = system.response(point.frequency_hz);
        assert!((point.response() - truth).norm() < SCATTER * truth.norm(), "{point:?} {truth}");
        let share = 1.0 / (1.0 + 0.05_f64.powi(2) / truth.norm_sqr());
        assert!((point.coherence - share).abs() < 0.05, "{point:?} {share}");
    }
}

#[test]
fn exact_unrelated_output_has_no_coherence() {
    let points = welch(&noise(61, 20_000, 1.0), &noise(62, 20_000, 1.0), 0.01, 256).unwrap();
    let mean = points.iter().map(|p| p.coherence).sum::<f64>() / points.len() as f64;
    // 155 half-overlapping segments count as somewhat fewer independent ones: mean coherence about 1/n
    assert!(mean < 0.02, "{mean}");
}

#[test]
fn exact_recording_too_short_for_its_segments_is_refused() {
    let signal = noise(1, 1000, 1.0);
    let error = welch(&signal, &signal, 0.01, 512).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::TooLittleData, Some("segment_length")));
    assert_eq!(welch(&signal, &signal, 0.01, 4).unwrap_err().kind(), ErrorKind::OutOfRange);
    assert_eq!(welch(&signal, &signal[1..], 0.01, 64).unwrap_err().kind(), ErrorKind::Inconsistent);
}
