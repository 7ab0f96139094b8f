//! The runs of blind trials: what is drawn stays within joint and drive, and a diagnosis can read it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use rand::SeedableRng;
use rand::rngs::StdRng;
use slideway::diagnose::experiment::Experiment;
use slideway::drive::motor::Circuit;
use slideway::machine::Machine;
use slideway::recording::{Existing, Format, Recording, Role, Run, SplitRule};
use slideway::replay::run_seed;
use slideway::trial::Engine;
use slideway::trial::engine::STEP_S;
use slideway::trial::forge::logged;
use slideway::trial::gauge::as_logged;
use slideway::trial::laws::Otherwise;
use slideway::trial::runs::{Bounds, Layout, Movement, Session, TrialRun, draw, shared_out};
use slideway::twin::Sensing;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const SESSIONS: u64 = 200;
/// Joints with limits on both sides, without any, and with one at zero; a pendulum under its weight; direct motors.
const MACHINES: [&str; 6] = ["grinder", "servo", "grinder_yaxis", "xl330", "emps", "delta_a3"];
/// Nothing that the machine's file does not state.
const OTHERWISE: Otherwise = Otherwise::bristles(4e-8, 0.7);

fn machine(name: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(name)).unwrap()
}

fn session(machine: &Machine, seed: u64) -> Session {
    draw(machine, &mut StdRng::seed_from_u64(seed)).unwrap()
}

fn sessions(machine: &Machine) -> impl Iterator<Item = Session> {
    (0..SESSIONS).map(|seed| session(machine, seed))
}

/// Largest magnitude.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, x| most.max(x.abs()))
}

/// Largest speed, acceleration and share of the drive's limits of a reference, by its differences.
fn asked(machine: &Machine, reference: &[f64]) -> [f64; 3] {
    let (c, period_s) = (machine.constants(), machine.description().sample_period_s);
    let speeds: Vec<f64> = reference.windows(2).map(|x| (x[1] - x[0]) / period_s).collect();
    let accelerations: Vec<f64> = speeds.windows(2).map(|v| (v[1] - v[0]) / period_s).collect();
    let (volts_per_force, back_emf) = match c.circuit {
        Circuit::Winding { resistance_ohm, force_constant, back_emf, .. } => {
            (resistance_ohm / force_constant, back_emf)
        }
        Circuit::Direct { force_per_volt } => (1.0 / force_per_volt, 0.0),
    };
    let weight = machine.weight().map_or(0.0, |weight| weight.largest());
    let (effort, limit_v) = (machine.solid().joint.effort, c.effort_limit_v().unwrap_or(f64::INFINITY));
    let share = |(a, v): (&f64, &f64)| {
        let force = c.moving_mass * a.abs() + c.viscous * v.abs();
        let volts = (force * volts_per_force + back_emf * v.abs()) / c.amplifier.gain();
        let held_v = weight * volts_per_force / c.amplifier.gain();
        (volts / (limit_v - held_v))
            .max(force / (effort - weight))
            .max(v.abs() / machine.solid().joint.velocity)
    };
    let shares = accelerations.iter().zip(&speeds).map(share);
    [largest(speeds.iter().copied()), largest(accelerations.iter().copied()), largest(shares)]
}

fn kinds(movement: &Movement) -> Vec<&'static str> {
    match movement {
        Movement::Sequence { parts } => parts.iter().flat_map(kinds).chain(["sequence"]).collect(),
        other => vec![other.name()],
    }
}

/// What a run may be, checked on its samples.
fn check(machine: &Machine, bounds: &Bounds, run: &TrialRun, tag: &str) {
    let (joint, reference) = (&machine.solid().joint, run.reference(machine));
    let resting = (0.1 / machine.description().sample_period_s).round() as usize;
    assert!(reference.iter().all(|x| x.is_finite()), "{tag}");
    let within = (0.8 * joint.lower)..=(0.8 * joint.upper);
    assert!(reference.iter().all(|x| within.contains(x)), "{tag}: {run:?}");
    assert!(reference[..resting].iter().all(|x| *x == run.from), "{tag} begins in motion");
    let last = reference[reference.len() - 1];
    assert!(reference[reference.len() - resting..].iter().all(|x| *x == last), "{tag} ends in motion");
    let [speed, acceleration, share] = asked(machine, &reference);
    assert!(speed > 0.0 && speed <= bounds.speed * (1.0 + 1e-6), "{tag}: {speed} of {}", bounds.speed);
    // Differences of positions of one digit in 10¹⁶.
    let slack = 1e-6
        + 1e-14 * largest(reference.iter().copied()) / bounds.acceleration
            * machine.description().sample_period_s.powi(-2);
    let most = bounds.acceleration * (1.0 + slack);
    assert!(acceleration <= most, "{tag}: {acceleration} of {}: {run:?}", bounds.acceleration);
    assert!(share <= 0.6 * (1.0 + slack), "{tag}: {share} of the drive");
    assert!((run.speed(machine) / speed - 1.0).abs() < 1e-9);
    assert_eq!(run.travel(machine).abs(), largest(reference.iter().copied()));
}

/// What is drawn stays within joint and drive, from rest to rest, and a session within its length.
#[test]
fn exact_sessions_stay_within_joint_drive_and_time() {
    for name in MACHINES {
        let machine = machine(name);
        let bounds = Bounds::of(&machine).unwrap();
        let (mut layouts, mut seen, mut whole_s) = (BTreeMap::new(), BTreeSet::new(), 0.0);
        for (seed, session) in sessions(&machine).enumerate() {
            *layouts.entry(session.layout).or_insert(0) += 1;
            let mut ends_s = 0.0;
            for run in &session.runs {
                check(&machine, &bounds, run, &format!("{name} {seed} {}", run.name));
                assert!((run.begins_s - ends_s).abs() < 1e-9, "{name} {seed}");
                ends_s = run.begins_s + run.length_s(&machine);
                seen.extend(kinds(&run.movement));
            }
            assert!(
                ends_s <= session.layout.longest_s(),
                "{name} {seed}: {:?} of {ends_s} s",
                session.layout
            );
            whole_s += ends_s;
        }
        println!("{name}: {bounds:?}, {:.1} s on average, {layouts:?}", whole_s / SESSIONS as f64);
        assert_eq!(layouts.len(), Layout::SHARES.len(), "{name}: {layouts:?}");
        let all = ["jogs", "multisine", "production", "sequence", "sine", "strokes"];
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), all, "{name}");
        for (layout, share) in Layout::SHARES {
            // Four standard deviations of a binomial number.
            let (wanted, drawn) = (share * SESSIONS as f64, f64::from(layouts[&layout]));
            assert!(
                (drawn - wanted).abs() < 4.0 * (wanted * (1.0 - share)).sqrt(),
                "{name} {layout:?}: {drawn}"
            );
        }
    }
}

/// Everything follows from the seed, and a truth file holds it.
#[test]
fn exact_sessions_follow_from_the_seed_and_are_kept() {
    let machine = machine("grinder");
    let mut distinct = BTreeSet::new();
    for (seed, drawn) in sessions(&machine).enumerate() {
        assert_eq!(drawn, session(&machine, seed as u64));
        let text = serde_json::to_string(&drawn.runs).unwrap();
        let read: Vec<TrialRun> = serde_json::from_str(&text).unwrap();
        for (read, run) in read.iter().zip(&drawn.runs) {
            // Sums of many digits may come back with the last one off.
            assert!((read.begins_s - run.begins_s).abs() < 1e-12);
            let [a, b] = [read, run].map(|run| run.reference(&machine));
            assert!(a.len() == b.len() && largest(a.iter().zip(&b).map(|(a, b)| a - b)) < 1e-15);
            assert_eq!((&read.name, read.role), (&run.name, run.role));
        }
        assert_eq!(read.len(), drawn.runs.len());
        assert!(distinct.insert(text));
    }
}

/// Roles are stated where users state them: never of a single run, and of three runs in half of the cases.
#[test]
fn exact_roles_are_stated_where_users_state_them() {
    let machine = machine("servo");
    let (mut three, mut stated) = (0, 0);
    for session in sessions(&machine) {
        let count = |role| session.runs.iter().filter(|run| run.role == role).count();
        let [none, training, held_out] = [None, Some(Role::Training), Some(Role::HeldOut)].map(count);
        match session.layout {
            Layout::SingleRun => assert_eq!([none, training, held_out], [1, 0, 0]),
            Layout::ThreeRuns => {
                three += 1;
                stated += usize::from(none == 0);
                assert!([[3, 0, 0], [0, 2, 1]].contains(&[none, training, held_out]));
            }
            _ => assert!(none == 0 && training >= 3 && held_out >= 1, "{session:?}"),
        }
    }
    assert!(stated > three / 4 && stated < 3 * three / 4, "{stated} of {three}");
}

/// What a logger would have made of a session on a machine with nothing hidden, written and read back.
fn recorded(machine: &Machine, session: &Session) -> (Vec<Run>, Recording) {
    let signals = logged(machine);
    let run = |run: &TrialRun| {
        let (reference, sensing) =
            (run.reference(machine), Sensing::AsStated { seed: run_seed(1, &run.name) });
        let traces =
            Engine::Axis.simulate(machine, &OTHERWISE, sensing, &reference, run.begins_s, STEP_S).unwrap();
        as_logged(run, machine, &reference, traces, &signals).unwrap()
    };
    let runs: Vec<Run> = session.runs.iter().map(run).collect();
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("case");
    Recording::new(runs.clone()).unwrap().write(&place, Format::Parquet, Existing::Refuse).unwrap();
    (runs, Recording::read(&place).unwrap())
}

/// Both sides of a single run are stretches of it that begin where it stands, or creeps or swings a little.
fn single_run_is_cut(groups: &[Vec<&TrialRun>], recording: &Recording, machine: &Machine) {
    assert_eq!(groups.len(), 1);
    let split = recording.split_within(SplitRule::default(), usize::MAX).unwrap();
    let cut = split.cut.unwrap();
    assert!(!cut.in_motion && cut.one_sided.is_empty(), "{cut:?}");
    let whole = recording.runs()[0].len() as f64;
    let held_out: usize = split.held_out.runs().iter().map(Run::len).sum();
    assert!((0.15..0.5).contains(&(held_out as f64 / whole)), "{cut:?}");
    for run in split.training.runs().iter().chain(split.held_out.runs()) {
        let prepared = Experiment::new(run, machine).unwrap();
        let velocity = prepared.recorded().start().velocity;
        assert!(velocity.abs() < 0.05 * groups[0][0].speed(machine), "{} {velocity}", run.name());
    }
}

/// A diagnosis reads and prepares a session of every layout, and shares its runs out as the gauge of sizes does.
#[test]
fn exact_a_session_of_every_layout_is_prepared_without_refusal() {
    for name in ["grinder", "servo", "grinder_yaxis"] {
        let machine = machine(name);
        for (layout, _) in Layout::SHARES {
            let session = sessions(&machine).find(|session| session.layout == layout).unwrap();
            let (logged, recording) = recorded(&machine, &session);
            for (run, drawn) in recording.runs().iter().zip(&session.runs) {
                let prepared = Experiment::new(run, &machine).unwrap();
                assert_eq!(prepared.input(), None, "{name} {layout:?} is replayed in closed loop");
                assert_eq!(prepared.recorded().start().velocity, 0.0, "{name} {layout:?} begins at rest");
                assert_eq!((run.role, run.name()), (drawn.role, drawn.name.as_str()));
                assert!((run.begins_s - drawn.begins_s).abs() < 1e-9, "{name} {layout:?}");
            }
            let groups = shared_out(&session.runs, logged).unwrap();
            if layout == Layout::SingleRun {
                single_run_is_cut(&groups, &recording, &machine);
                continue;
            }
            let (training, held_out) = recording.split(SplitRule::default()).unwrap();
            for (group, side) in groups.iter().zip([training.runs(), held_out.runs()]) {
                let names: Vec<&str> = side.iter().map(Run::name).collect();
                assert_eq!(group.iter().map(|run| run.name.as_str()).collect::<Vec<_>>(), names);
            }
        }
    }
}
