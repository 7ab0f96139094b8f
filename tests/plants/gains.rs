//! Controller gains: those that a law ran with are found again, from twins and from measured logs; runs that do not
//! show them are refused.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::{self, needs};
use proptest::prelude::*;
use slideway::controller::integer::IntegerGain;
use slideway::controller::regression::{ControllerGains, ControllerRun, gain_regression};
use slideway::controller::regressor::Unknown;
use slideway::controller::{AntiWindup, Cascade, Controller, Input, Memory, Pdf};
use slideway::error::ErrorKind;
use slideway::identify::excitation::Outcome;
use slideway::machine::Machine;
use slideway::recording::{Recording, Signal};
use slideway::replay::gain_table::{GainTable, Recovered};
use slideway::replay::{PlantChoice, controller_run};
use std::path::Path;

const PERIOD_S: f64 = 250e-6;
/// Without noise rounding times the condition number is left.
const NOISE_FREE: f64 = 1e-8;

fn pdf() -> Pdf {
    Pdf {
        integral: IntegerGain::saturating(19),
        proportional: IntegerGain::saturating(260),
        integral_gain_per_count: 6.942e-2,
        proportional_gain_per_count: 2.359e-4,
        velocity_units_per_si: 1000.0,
        position_gain_per_s: 6.5,
        velocity_feedforward: 0.7,
        filter: Vec::new(),
    }
}

fn cascade(integral: f64) -> Cascade {
    Cascade {
        position_gain_per_s: 160.0,
        velocity_gain_v_s_per_m: 240.0,
        velocity_integral_per_s: integral,
        velocity_feedforward: 0.4,
        effort_limit_v: None,
        anti_windup: AntiWindup::None,
        filter: Vec::new(),
    }
}

/// Motion as a lightly damped axis has it, neither the law's own loop nor a constant.
fn inputs(samples: usize) -> Vec<Input> {
    (0..samples)
        .map(|k| {
            let t = k as f64 * PERIOD_S;
            let reference = 0.02 * (3.0 * t).sin() + 0.005 * (17.0 * t).sin();
            let velocity_reference = 0.06 * (3.0 * t).cos() + 0.085 * (17.0 * t).cos();
            let lag = 1e-3 * (11.0 * t).cos() + 2e-4 * (140.0 * t).sin();
            let rate = -11e-3 * (11.0 * t).sin() + 28e-3 * (140.0 * t).cos();
            Input {
                position_reference: reference,
                velocity_reference,
                position: reference - lag,
                velocity: velocity_reference - rate,
            }
        })
        .collect()
}

/// What `real` commands on the inputs, told as runs of `stated`.
fn run_of(stated: &Controller, real: &Controller, inputs: Vec<Input>) -> ControllerRun {
    let mut memory = Memory::default();
    let effort_v = inputs.iter().map(|input| real.effort_v(&mut memory, *input, PERIOD_S)).collect();
    ControllerRun { law: stated.clone(), period_s: PERIOD_S, inputs, effort_v, limit_v: None }
}

fn identified(outcome: Outcome<ControllerGains>) -> ControllerGains {
    match outcome {
        Outcome::Identified(gains) => gains,
        Outcome::NotExcited(why) => panic!("{why}"),
    }
}

fn values(gains: &ControllerGains) -> Vec<f64> {
    gains.gains.iter().map(|gain| gain.estimate.value).collect()
}

fn assert_near(found: &[f64], truth: &[f64]) {
    assert_eq!(found.len(), truth.len());
    for (found, truth) in found.iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < NOISE_FREE, "{found} for {truth}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Every law gives back the gains that it ran with, whatever gains were stated.
    #[test]
    fn exact_gains_are_found_again(scale in proptest::array::uniform4(0.7..1.4f64), integral in 5.0..40.0f64) {
        let [a, b, c, d] = scale;
        let (law, other) = (pdf(), cascade(integral));
        let real = Pdf {
            integral_gain_per_count: a * law.integral_gain_per_count,
            proportional_gain_per_count: b * law.proportional_gain_per_count,
            position_gain_per_s: c * law.position_gain_per_s,
            velocity_feedforward: d * law.velocity_feedforward,
            ..law.clone()
        };
        let truth = [
            real.integral_gain_per_count,
            real.proportional_gain_per_count,
            real.position_gain_per_s,
            real.velocity_feedforward,
        ];
        let run = run_of(&Controller::Pdf(law), &Controller::Pdf(real), inputs(4000));
        let found = identified(gain_regression(&[run], Unknown::BothLoops).unwrap());
        assert_near(&values(&found), &truth);
        prop_assert!(found.integrates_as_stated());
        let real = Cascade {
            velocity_gain_v_s_per_m: a * other.velocity_gain_v_s_per_m,
            velocity_integral_per_s: b * other.velocity_integral_per_s,
            position_gain_per_s: c * other.position_gain_per_s,
            velocity_feedforward: d * other.velocity_feedforward,
            ..other.clone()
        };
        let truth = [
            real.velocity_gain_v_s_per_m,
            real.velocity_integral_per_s,
            real.position_gain_per_s,
            real.velocity_feedforward,
        ];
        let run = run_of(&Controller::Cascade(other), &Controller::Cascade(real), inputs(4000));
        let found = identified(gain_regression(&[run], Unknown::BothLoops).unwrap());
        assert_near(&values(&found), &truth);
    }
}

#[test]
fn exact_proportional_law_needs_no_past_effort() {
    let real = Cascade { velocity_gain_v_s_per_m: 300.0, ..cascade(0.0) };
    let run = run_of(&Controller::Cascade(cascade(0.0)), &Controller::Cascade(real), inputs(2000));
    let found = identified(gain_regression(&[run], Unknown::VelocityLoop).unwrap());
    assert_near(&values(&found), &[300.0]);
    assert_eq!(found.previous_effort, None);
}

#[test]
fn exact_registers_may_differ_from_run_to_run() {
    let retuned =
        Pdf { integral: IntegerGain::saturating(22), proportional: IntegerGain::saturating(220), ..pdf() };
    let laws = [Controller::Pdf(pdf()), Controller::Pdf(retuned)];
    let runs: Vec<_> = laws.iter().map(|law| run_of(law, law, inputs(3000))).collect();
    let found = identified(gain_regression(&runs, Unknown::VelocityLoop).unwrap());
    assert_near(&values(&found), &[6.942e-2, 2.359e-4]);
    assert_eq!(found.gains[0].register, None, "two registers in one fit");
    let one = identified(gain_regression(&runs[1..], Unknown::VelocityLoop).unwrap());
    let (stated, equivalent) = one.gains[0].register.unwrap();
    assert!(stated == 22 && (equivalent - 22.0).abs() < 1e-6, "{equivalent}");
}

#[test]
fn exact_clipped_effort_is_left_out() {
    let law = Controller::Pdf(pdf());
    let mut run = run_of(&law, &law, inputs(4000));
    let highest = run.effort_v.iter().fold(0.0_f64, |peak, u| peak.max(u.abs()));
    let limit = 0.8 * highest;
    run.effort_v.iter_mut().for_each(|u| *u = u.clamp(-limit, limit));
    let blind = identified(gain_regression(&[run.clone()], Unknown::VelocityLoop).unwrap());
    assert!(
        values(&blind).iter().zip([6.942e-2, 2.359e-4]).any(|(a, b)| (a / b - 1.0).abs() > 1e-3),
        "{blind:?}"
    );
    run.limit_v = Some(limit);
    let found = identified(gain_regression(&[run], Unknown::VelocityLoop).unwrap());
    assert!(found.clipped > 100);
    assert_near(&values(&found), &[6.942e-2, 2.359e-4]);
}

#[test]
fn exact_integrator_that_leaks_is_seen() {
    let law = Controller::Pdf(pdf());
    let mut run = run_of(&law, &law, inputs(4000));
    let whole = run.effort_v.clone();
    let mut leaking = whole[0];
    for k in 1..whole.len() {
        leaking = 0.98 * leaking + whole[k] - whole[k - 1];
        run.effort_v[k] = leaking;
    }
    let found = identified(gain_regression(&[run], Unknown::VelocityLoop).unwrap());
    assert!(!found.integrates_as_stated(), "{found:?}");
    assert!((found.previous_effort.unwrap().value - 0.98).abs() < 1e-6);
}

#[test]
fn exact_law_that_the_data_cannot_tell_from_another_is_refused() {
    // A proportional law told as one that integrates: its effort one sample ago is a gain times the error then.
    let run = run_of(&Controller::Cascade(cascade(20.0)), &Controller::Cascade(cascade(0.0)), inputs(3000));
    assert!(matches!(gain_regression(&[run], Unknown::VelocityLoop).unwrap(), Outcome::NotExcited(_)));
}

#[test]
fn exact_rest_and_constant_speed_are_refused() {
    let law = Controller::Pdf(pdf());
    let rest = Input { position_reference: 0.01, velocity_reference: 0.0, position: 0.01, velocity: 0.0 };
    let cruise = |k: usize| Input {
        position_reference: 0.1 * PERIOD_S * k as f64,
        velocity_reference: 0.1,
        position: 0.1 * PERIOD_S * k as f64 - 0.3 * 0.1 / 6.5,
        velocity: 0.1,
    };
    for inputs in [vec![rest; 400], (0..400).map(cruise).collect()] {
        let effort_v = vec![2.0; 400];
        let run = ControllerRun { law: law.clone(), period_s: PERIOD_S, inputs, effort_v, limit_v: None };
        match gain_regression(&[run], Unknown::VelocityLoop).unwrap() {
            Outcome::Identified(gains) => panic!("identified {gains:?}"),
            Outcome::NotExcited(why) => {
                assert!(why.condition > 1e8 && why.remedy.contains("reverse"), "{why}")
            }
        }
    }
}

#[test]
fn exact_broken_signals_are_refused() {
    let law = Controller::Pdf(pdf());
    let good = run_of(&law, &law, inputs(400));
    let refused = |run: ControllerRun| gain_regression(&[run], Unknown::VelocityLoop).unwrap_err();
    let mut short = good.clone();
    short.effort_v.pop();
    assert_eq!(refused(short).key_name(), Some("control_effort_v"));
    let mut bad = good.clone();
    bad.inputs[3].velocity = f64::NAN;
    assert_eq!(refused(bad).kind(), ErrorKind::NotFinite);
    let off = Controller::Pdf(Pdf { proportional: IntegerGain::saturating(0), ..pdf() });
    let off = ControllerRun { law: off, ..good };
    assert_eq!(refused(off).key_name(), Some("controller.proportional_gain_per_count"));
    assert_eq!(gain_regression(&[], Unknown::VelocityLoop).unwrap_err().kind(), ErrorKind::TooLittleData);
}

fn table() -> (GainTable, Machine) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder/table1.toml");
    let table = GainTable::read(&file).unwrap();
    let machine = table.machine().unwrap();
    (table, machine)
}

#[test]
fn ref_published_gains_are_found_again_on_the_scene() {
    let (table, machine) = table();
    let recovered = table.recover(&machine, PlantChoice::Rapier, 1).unwrap();
    assert_eq!(recovered.len(), 6);
    for cell in &recovered {
        assert!(cell.errors().iter().all(|error| error.abs() < 0.01), "{}: {:?}", cell.stroke, cell.errors());
        assert!(cell.found.condition < 20.0 && cell.found.integrates_as_stated());
    }
    for (mean, published) in GainTable::means(&recovered).iter().zip([6.942e-2, 2.359e-4]) {
        assert!((mean.found / published - 1.0).abs() < 0.003, "{mean:?}");
    }
}

#[test]
fn exact_intervals_hold_the_gains_as_stated() {
    let (table, machine) = table();
    let (mut held, mut asked) = (0, 0);
    for seed in 0..25 {
        for Recovered { published, found, .. } in table.recover(&machine, PlantChoice::Axis, seed).unwrap() {
            held += found.gains.iter().zip(&published).filter(|(g, p)| g.estimate.covers(**p)).count();
            asked += published.len();
        }
    }
    // 300 gains, two and two correlated: a share of 0.95 is then held in 0.90 to 0.99.
    let share = held as f64 / asked as f64;
    assert!((0.90..=0.99).contains(&share), "{held} of {asked}");
}

#[test]
fn exact_verifying_stroke_is_not_identified_on() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("table.toml");
    let text = "machine = \"m\"\nverification = [\"0.02@8\"]\n[[cell]]\nstroke = \"0.02@8\"\ngains = {}\n";
    std::fs::write(&file, text).unwrap();
    let error = GainTable::read(&file).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Inconsistent, Some("cell.stroke")));
    std::fs::write(&file, "machine = \"m\"\ncell = []\n").unwrap();
    assert_eq!(GainTable::read(&file).unwrap_err().key_name(), Some("cell"));
    std::fs::write(&file, "machine = \"m\"\n[logger]\nspeed = 1.0\n[[cell]]\nstroke = \"1@1\"\ngains = {}\n")
        .unwrap();
    assert_eq!(GainTable::read(&file).unwrap_err().key_name(), Some("logger.speed"));
}

#[test]
fn exact_run_without_an_effort_is_refused() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let machine = Machine::read(&root.join("models/grinder")).unwrap();
    let recording = Recording::read(root.join("assets/hidden_coulomb")).unwrap();
    let run = &recording.runs()[0];
    assert!(controller_run(&machine, run).is_ok());
    let signals = run.signals().iter().filter(|(s, _)| **s != Signal::ControlEffort);
    let signals = signals.map(|(s, x)| (*s, x.clone())).collect();
    let without = slideway::recording::Run::new("r", run.motion(), run.sample_period_s(), signals).unwrap();
    let error = controller_run(&machine, &without).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Missing, Some("control_effort_v")));
}

/// Published: 243.45 V·s/m and 160.18 1/s.
#[test]
fn ref_gains_of_a_measured_axis_are_the_published_ones() {
    needs!(support::data("emps/emps_estimation.csv"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps");
    let machine = Machine::read(&root).unwrap();
    let recording = Recording::read(root.join("recording.toml")).unwrap();
    let runs: Vec<_> = recording.runs().iter().map(|run| controller_run(&machine, run).unwrap()).collect();
    let found = identified(gain_regression(&runs, Unknown::BothLoops).unwrap());
    let expected = [243.45, 160.18];
    for (value, published) in values(&found).iter().zip(expected) {
        assert!((value / published - 1.0).abs() < 2e-3, "{value} for {published}");
    }
    assert!(found.gains[2].estimate.value.abs() < 2e-3, "no feed-forward: {found:?}");
}
