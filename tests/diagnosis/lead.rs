//! A piece that was cut out of a longer run is replayed from before the cut.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use slideway::machine::Machine;
use slideway::plant::axis::{Axis, LONGEST_STEP_S};
use slideway::recording::{Recording, Role, Run, Signal, SplitRule};
use slideway::replay::{PlantChoice, Recorded};
use slideway::twin::Sensing;
use std::path::Path;

/// Largest error of the replayed position, in m.
fn error(run: &Run, machine: &Machine) -> f64 {
    let recorded = Recorded::of(run, machine).unwrap();
    let alone = recorded.replay(machine, Axis::of(&machine.constants()), Sensing::Perfect).position;
    let together =
        recorded.replay_together(&[machine.clone(), machine.clone(), machine.clone()], LONGEST_STEP_S);
    for traces in together {
        assert!(traces.position.iter().zip(&alone).all(|(a, b)| (a - b).abs() < 1e-12));
    }
    let measured = run.signal(Signal::Position).unwrap();
    assert_eq!(measured.len(), alone.len());
    measured.iter().zip(alone).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Where a stroke follows before the base has come to rest no signal tells how it swings at the cut. The motion before does: the machine's own
/// twin replays each piece ten times closer than from what the samples at the cut tell.
#[test]
fn exact_a_piece_begins_with_the_motion_before() {
    let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let legs: Vec<f64> = (0..12).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let exact = [("encoder.noise_m", 0.0.into()), ("encoder.resolution_m", 1e-13.into())];
    let real = machine.with_settings(exact).unwrap();
    let strokes = Strokes {
        stated: &machine,
        real: &real,
        plant: PlantChoice::Axis,
        legs: &legs,
        dwell_s: 0.06,
        seed: 1,
    };
    let recording = strokes.recording(&[(0.03, 8.0, Role::Training)]);
    let mut whole = recording.runs()[0].clone();
    whole.role = None;
    let split = Recording::new(vec![whole]).unwrap().split_within(SplitRule::default(), 40_000).unwrap();
    let pieces = split.training.runs().iter().chain(split.held_out.runs());
    let mut cut = 0;
    for piece in pieces.filter(|piece| piece.entry().is_some()) {
        let signals = piece.signals().clone();
        let bare = Run::new("bare", piece.motion(), piece.sample_period_s(), signals).unwrap();
        let [led, bare] = [piece, &bare].map(|run| error(run, &machine));
        println!("{}: {led:.2e} m, {bare:.2e} m without what was before", piece.name());
        assert!(led < 0.1 * bare && bare > 1e-7);
        cut += 1;
    }
    assert!(cut > 0);
}
