//! A single run is cut at standstills; of a long recording the stretches are used that hold most of its motion.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use proptest::prelude::*;
use slideway::error::ErrorKind;
use slideway::recording::{Recording, Run, Signal, Split, SplitRule};
use slideway::units::Motion;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

const PERIOD_S: f64 = 1e-3;

/// Moves of a length in m at a speed in m/s, each after a standstill in s.
fn reference(moves: &[(f64, f64)], dwell_s: f64) -> Vec<f64> {
    let mut samples = vec![0.0];
    let mut at = 0.0;
    let stand = |samples: &mut Vec<f64>, at: f64| samples.extend(vec![at; (dwell_s / PERIOD_S) as usize]);
    for (length, speed) in moves {
        stand(&mut samples, at);
        let count = (length.abs() / speed / PERIOD_S) as usize;
        samples.extend((1..=count).map(|k| at + length * k as f64 / count as f64));
        at += length;
    }
    stand(&mut samples, at);
    samples
}

/// What a sensor shows of an axis that follows with a lag of 20 ms, shaken and noisy.
fn run(reference: Vec<f64>, noise: f64, shaken: f64, with_reference: bool) -> Run {
    let mut at = reference[0];
    let mut weyl = 0.0_f64;
    let measured = |(k, r): (usize, &f64)| {
        at += (r - at) * PERIOD_S / 20e-3;
        weyl = (weyl + 0.618_033_988_749_895).fract();
        at + noise * (weyl - 0.5) + shaken * (TAU * 23.0 * k as f64 * PERIOD_S).sin()
    };
    let position: Vec<f64> = reference.iter().enumerate().map(measured).collect();
    let mut signals = BTreeMap::from([(Signal::Position, position)]);
    if with_reference {
        signals.insert(Signal::PositionReference, reference);
    }
    Run::new("x", Motion::Prismatic, PERIOD_S, signals).unwrap()
}

fn there_and_back(count: usize) -> Vec<(f64, f64)> {
    let speeds = [0.02, 0.1, 0.25];
    (0..count).map(|k| (if k % 2 == 0 { 0.04 } else { -0.04 }, speeds[k / 2 % 3])).collect()
}

fn split(run: Run, most: usize) -> Split {
    Recording::new(vec![run]).unwrap().split_within(SplitRule::default(), most).unwrap()
}

fn length(runs: &[Run]) -> usize {
    runs.iter().map(Run::len).sum()
}

/// Largest speeds forward and backward over 20 ms.
fn speeds(runs: &[Run]) -> [f64; 2] {
    let both = |run: &Run| {
        let x = run.signal(Signal::Position).unwrap();
        let of = |sign: f64| x.windows(21).map(|w| sign * (w[20] - w[0]) / 0.02).fold(0.0, f64::max);
        [of(1.0), of(-1.0)]
    };
    runs.iter().map(both).fold([0.0; 2], |most, own| [most[0].max(own[0]), most[1].max(own[1])])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the noise and the vibration: cuts lie in standstills, nothing is lost or used twice, both sides move both ways.
    #[test]
    fn exact_a_single_run_is_cut_at_standstills(
        count in 8_usize..20,
        dwell_s in 0.35_f64..0.8,
        noise in 0.0_f64..20e-6,
        shaken in 0.0_f64..20e-6,
        with_reference in any::<bool>(),
    ) {
        let reference = reference(&there_and_back(count), dwell_s);
        let still = |sample: usize| reference[sample - 60..sample + 60].iter().all(|r| *r == reference[sample]);
        let whole = run(reference.clone(), noise, shaken, with_reference);
        let split = split(whole.clone(), usize::MAX);
        let cut = split.cut.unwrap();
        prop_assert!(!cut.in_motion && cut.one_sided.is_empty(), "{cut:?}");
        prop_assert!(cut.at_s.iter().all(|at| still((at / PERIOD_S).round() as usize)), "{cut:?}");
        let (training, held_out) = (split.training.runs(), split.held_out.runs());
        let mut pieces: Vec<&Run> = training.iter().chain(held_out).collect();
        pieces.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
        let joined: Vec<f64> =
            pieces.iter().flat_map(|piece| piece.signal(Signal::Position).unwrap()).copied().collect();
        prop_assert_eq!(&joined[..], whole.signal(Signal::Position).unwrap());
        prop_assert!(pieces.iter().all(|piece| (piece.start_s - piece.begins_s).abs() < 1e-9));
        let share = length(held_out) as f64 / whole.len() as f64;
        prop_assert!((0.15..0.5).contains(&share), "{share} {cut:?}");
        prop_assert!(speeds(training).iter().chain(&speeds(held_out)).all(|v| *v > 0.09), "{cut:?}");
        prop_assert_eq!((split.samples.used, split.samples.recorded), (whole.len(), whole.len()));
    }

    /// Within the budget, nothing twice, both ways and the one fast move among many slow ones.
    #[test]
    fn exact_of_a_long_run_the_telling_stretches_are_used(count in 60_usize..120, fast in 0_usize..50) {
        let mut moves: Vec<(f64, f64)> = there_and_back(count).into_iter().map(|(l, _)| (l, 0.05)).collect();
        (moves[fast].1, moves[fast + 5].1) = (0.3, 0.3);
        let whole = run(reference(&moves, 0.4), 1e-6, 0.0, true);
        let most = 15_000;
        let split = split(whole.clone(), most);
        let (training, held_out) = (split.training.runs(), split.held_out.runs());
        let used = length(training) + length(held_out);
        prop_assert!(used <= most && 10 * used > 8 * most, "{used}");
        prop_assert_eq!((split.samples.used, split.samples.recorded), (used, whole.len()));
        prop_assert!(3 * length(held_out) <= most);
        let mut spans: Vec<[f64; 2]> = training
            .iter()
            .chain(held_out)
            .map(|piece| [piece.start_s, piece.start_s + piece.duration_s()])
            .collect();
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        prop_assert!(spans.windows(2).all(|pair| pair[0][1] < pair[1][0]));
        let fastest = |runs| speeds(runs).into_iter().fold(0.0, f64::max);
        prop_assert!(fastest(training).max(fastest(held_out)) > 0.25);
        prop_assert!(speeds(training).into_iter().chain(speeds(held_out)).all(|v| v > 0.045));
    }
}

/// What fits is left alone, to the sample; the choice does not change from one time to the next.
#[test]
fn exact_nothing_changes_up_to_the_budget() {
    let runs = |names: &[&str]| -> Vec<Run> {
        // Each run has a sensor noise of its own: copies of one would be refused.
        let one = |name: &&str| {
            let noise = 1e-6 * (1.0 + name.len() as f64 + f64::from(name.as_bytes()[0] - b'a'));
            let made = run(reference(&there_and_back(4), 0.4), noise, 0.0, true);
            Run::new(*name, Motion::Prismatic, PERIOD_S, made.signals().clone()).unwrap()
        };
        names.iter().map(one).collect()
    };
    let recording = Recording::new(runs(&["a", "b", "c", "d"])).unwrap();
    let whole = length(recording.runs());
    let names = |runs: &[Run]| runs.iter().map(|run| run.name().to_owned()).collect::<Vec<_>>();
    let (training, held_out) = recording.split(SplitRule::default()).unwrap();
    let within = recording.split_within(SplitRule::default(), whole).unwrap();
    assert_eq!(names(training.runs()), names(within.training.runs()));
    assert_eq!(names(held_out.runs()), names(within.held_out.runs()));
    let less = || recording.split_within(SplitRule::default(), whole / 2).unwrap();
    assert!(less().samples.used <= whole / 2 && less().cut.is_none());
    assert_eq!(names(less().training.runs()), names(less().training.runs()));
}

/// A sine never stands: cut once, near the last third, where the axis is fastest, its state read from both sides.
#[test]
fn exact_a_run_that_never_stands_is_cut_where_it_is_fastest() {
    let (amplitude, omega) = (0.02, TAU * 1.3);
    let sine = |k: usize| amplitude * (omega * k as f64 * PERIOD_S).sin();
    let position: Vec<f64> = (0..9000).map(sine).collect();
    let signals =
        BTreeMap::from([(Signal::Position, position.clone()), (Signal::PositionReference, position)]);
    let whole = Run::new("sine", Motion::Prismatic, PERIOD_S, signals).unwrap();
    let split = split(whole, usize::MAX);
    let cut = split.cut.unwrap();
    assert!(cut.in_motion && cut.at_s.len() == 1 && (cut.at_s[0] - 6.0).abs() < 0.8, "{cut:?}");
    let [held_out] = split.held_out.runs() else { panic!("{cut:?}") };
    let [position, velocity, _] = held_out.entry().unwrap();
    assert!((position - held_out.signal(Signal::Position).unwrap()[0]).abs() < 1e-7);
    assert!(velocity.abs() > 0.95 * amplitude * omega && velocity.abs() < 1.01 * amplitude * omega);
    assert!(split.training.runs()[0].entry().is_none());
}

#[test]
fn exact_a_single_run_without_motion_is_refused() {
    let refused = |run: Run| Recording::new(vec![run]).unwrap().split(SplitRule::default()).unwrap_err();
    let error = refused(run(vec![0.0; 5000], 0.0, 0.0, true));
    assert_eq!(error.kind(), ErrorKind::TooLittleData);
    assert!(error.to_string().contains("does not move"), "{error}");
    assert!(refused(run(vec![0.0; 20], 0.0, 0.0, true)).to_string().contains("20 samples"));
}
