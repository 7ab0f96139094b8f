//! Blind trials: what no law of the catalogue describes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use rand::SeedableRng;
use rand::rngs::StdRng;
use slideway::guide::{Coast, StepForce};
use slideway::machine::Machine;
use slideway::plant::axis::Axis;
use slideway::plant::{Drive, Plant};
use slideway::recording::{Role, Run, Signal};
use slideway::replay::{follow, run as walk};
use slideway::trial::engine::sketch;
use slideway::trial::foreign::{
    Burst, DriftingClock, Foreign, ForeignKind, MissedSamples, Pulse, Rows, Shocks, WarmSensor, WarmingScale,
};
use slideway::trial::laws::{Forged, ForgedLaws, Otherwise};
use slideway::twin::{Sensing, Twin};
use slideway::units::Motion;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::Path;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

/// The machine with a second sensor at the load.
fn two_sensors(closes: bool) -> Machine {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(source.join("machine.toml")).unwrap();
    let text = format!(
        "{text}\n[load_sensor]\nresolution_m = 1e-8\nnoise_m = 1e-9\ncloses_position_loop = {closes}\n"
    );
    std::fs::write(folder.path().join("machine.toml"), text).unwrap();
    std::fs::copy(source.join("machine.urdf"), folder.path().join("machine.urdf")).unwrap();
    std::fs::create_dir(folder.path().join("meshes")).unwrap();
    for mesh in std::fs::read_dir(source.join("meshes")).unwrap().map(Result::unwrap) {
        std::fs::copy(mesh.path(), folder.path().join("meshes").join(mesh.file_name())).unwrap();
    }
    Machine::read(folder.path()).unwrap()
}

fn otherwise(foreign: Option<Foreign>) -> Otherwise {
    Otherwise { foreign, ..Otherwise::bristles(4e-8, 0.7) }
}

/// A mass that nothing holds.
#[derive(Clone)]
struct FreeMass {
    mass: f64,
    step_s: f64,
    position: f64,
    velocity: f64,
}

impl Plant for FreeMass {
    fn step_s(&self) -> f64 {
        self.step_s
    }
    fn position(&self) -> f64 {
        self.position
    }
    fn velocity(&self) -> f64 {
        self.velocity
    }
    fn current(&self) -> f64 {
        0.0
    }
    fn set_current(&mut self, _: f64) {}
    fn coast(&mut self, _: Drive) -> Coast {
        Coast::of_mass(self.mass, self.velocity, self.step_s)
    }
    fn advance(&mut self, motor: StepForce, guide: StepForce) {
        let coast = Coast::of_mass(self.mass, self.velocity, self.step_s);
        self.position += coast.travel_under(motor + guide);
        self.velocity = coast.velocity_under(motor + guide);
    }
    fn place(&mut self, position: f64, velocity: f64) {
        (self.position, self.velocity) = (position, velocity);
    }
    fn snapshot(&self) -> Vec<f64> {
        vec![self.position, self.velocity]
    }
    fn restore(&mut self, snapshot: &[f64]) {
        (self.position, self.velocity) = (snapshot[0], snapshot[1]);
    }
}

/// Three shocks, of which two overlap.
fn shocks() -> Shocks {
    let pulse = |begins_s, force| Pulse { begins_s, force };
    Shocks { length_s: 7e-3, pulses: vec![pulse(0.0123, 40.0), pulse(0.0171, -25.0), pulse(0.0603, 33.0)] }
}

fn laws(foreign: Foreign) -> (Machine, ForgedLaws) {
    ForgedLaws::split(&machine(), &otherwise(Some(foreign))).unwrap()
}

const SESSION_S: f64 = 0.1;

/// A plant after a session under the shocks, nothing else driving it.
fn struck<P: Plant + Clone>(plant: P) -> P {
    let (_, laws) = laws(Foreign::Shocks(shocks()));
    let mut forged = Forged::new(plant, laws, 0.0);
    for _ in 0..(SESSION_S / forged.step_s()).round() as usize {
        forged.coast(Drive::voltage(0.0));
        forged.advance(StepForce::ZERO, StepForce::ZERO);
    }
    forged.inner().clone()
}

/// Half sines of impulse 2·F̂·ℓ/π each give a free mass that impulse over its mass, and carry it on from their middle.
#[test]
fn exact_shocks_give_a_free_mass_their_impulse() {
    let mass = 50.0;
    let shocks = shocks();
    let gained = |pulse: &Pulse| 2.0 * pulse.force * shocks.length_s / PI / mass;
    let middle = |pulse: &Pulse| pulse.begins_s + 0.5 * shocks.length_s;
    let velocity: f64 = shocks.pulses.iter().map(gained).sum();
    let travel: f64 = shocks.pulses.iter().map(|p| gained(p) * (SESSION_S - middle(p))).sum();
    assert!((shocks.impulse() / mass - velocity).abs() < 1e-15);
    for step_s in [1e-3, 250e-6, 125e-6, 31.25e-6] {
        let end = struck(FreeMass { mass, step_s, position: 0.0, velocity: 0.0 });
        assert!((end.velocity / velocity - 1.0).abs() < 1e-11, "{} at {step_s}", end.velocity);
        assert!((end.position / travel - 1.0).abs() < 1e-9, "{} at {step_s}", end.position);
    }
}

/// On an axis with drag, winding and base, halved steps give the same motion.
#[test]
fn exact_shocks_move_an_axis_alike_at_halved_steps() {
    let frictionless = machine().constants();
    let end = |step_s: f64| {
        let axis = struck(Axis::new(&frictionless, step_s));
        [axis.position(), axis.velocity()]
    };
    let [coarse, fine, finest] = [125e-6, 62.5e-6, 31.25e-6].map(end);
    println!("{coarse:?} {fine:?} {finest:?}");
    for k in 0..2 {
        assert!((fine[k] / finest[k] - 1.0).abs() < 1e-6, "{fine:?} {finest:?}");
        assert!((coarse[k] / finest[k] - 1.0).abs() < 1e-5, "{coarse:?} {finest:?}");
    }
}

/// Force of a step by the definition of its mean and rise, from a fine sum.
#[test]
fn exact_shock_over_a_step_is_its_mean_and_first_moment() {
    let shocks = shocks();
    let at = |time_s: f64| -> f64 {
        let force = |p: &Pulse| {
            let share = (time_s - p.begins_s) / shocks.length_s;
            if (0.0..=1.0).contains(&share) { p.force * (PI * share).sin() } else { 0.0 }
        };
        shocks.pulses.iter().map(force).sum()
    };
    let count = 200_000;
    for (clock_s, step_s) in [(0.0, 0.1), (0.0125, 1e-3), (0.0170, 5e-3), (0.0119, 0.5e-3)] {
        let (mut mean, mut moment) = (0.0, 0.0);
        for k in 0..count {
            let share = (f64::from(k) + 0.5) / f64::from(count);
            let force = at(clock_s + share * step_s);
            mean += force / f64::from(count);
            moment += 12.0 * force * (share - 0.5) / f64::from(count);
        }
        let push = shocks.push(clock_s, step_s);
        assert!(
            (push.mean - mean).abs() < 1e-6 && (push.rise - moment).abs() < 1e-5,
            "{push:?} {mean} {moment}"
        );
    }
    assert_eq!(shocks.push(0.03, 0.01), StepForce::ZERO);
}

/// In the closed loop the controller answers a shock, and there is no other difference before it.
#[test]
fn exact_shocks_show_in_a_recording_from_the_first_one_on() {
    let machine = machine();
    let reference = vec![0.0; 400];
    let told = |foreign| sketch(&machine, &otherwise(foreign), &reference, 0.0).unwrap();
    let (plain, struck) = (told(None), told(Some(Foreign::Shocks(shocks()))));
    let first = plain.position.iter().zip(&struck.position).position(|(a, b)| a != b).unwrap();
    let period_s = machine.description().sample_period_s;
    let begins = (0.0123 / period_s).floor() as usize;
    assert!((begins..begins + 3).contains(&first), "{first} {begins}");
    assert!(struck.effort_v[first + 1..].iter().any(|v| *v != 0.0));
}

/// A ramp that counts its samples, beginning at 10 s of the session.
fn ramp(samples: usize) -> Run {
    let count = |scale: f64| (0..samples).map(|k| scale * k as f64).collect::<Vec<_>>();
    let signals = BTreeMap::from([
        (Signal::PositionReference, count(1.0)),
        (Signal::ControlEffort, count(2.0)),
        (Signal::Position, count(1.0)),
        (Signal::Velocity, count(3.0)),
    ]);
    let mut run = Run::new("ramp", Motion::Prismatic, 0.01, signals).unwrap();
    run = run.with_extra_columns(BTreeMap::from([("slider_a_n".to_owned(), count(4.0))])).unwrap();
    (run.role, run.begins_s) = (Some(Role::HeldOut), 10.0);
    run.metadata.insert("stroke_m".to_owned(), 0.03.into());
    run
}

#[test]
fn exact_missed_samples_are_gone_from_a_ramp() {
    let burst = |begins_s, samples| Burst { begins_s, samples };
    // Before the run, over its begin, one, three from a time between samples, over the end, after it.
    let bursts = vec![
        burst(9.0, 4),
        burst(9.98, 4),
        burst(10.04, 1),
        burst(10.0555, 3),
        burst(10.11, 9),
        burst(11.0, 1),
    ];
    let machine = machine();
    let logged = |rows| {
        let missed = Foreign::MissedSamples(MissedSamples { rows, bursts: bursts.clone() });
        missed.logged(ramp(12), &machine).unwrap()
    };
    let (joined, held) = (logged(Rows::Joined), logged(Rows::Held));
    // Missed: 1; 4; 6, 7, 8; 11.
    let left = [0.0, 2.0, 3.0, 5.0, 9.0, 10.0];
    let last = [0.0, 0.0, 2.0, 3.0, 3.0, 5.0, 5.0, 5.0, 5.0, 9.0, 10.0, 10.0];
    for (run, expected) in [(&joined, &left[..]), (&held, &last[..])] {
        assert_eq!(run.len(), expected.len());
        let scaled = |scale: f64| expected.iter().map(|k| scale * k).collect::<Vec<_>>();
        assert_eq!(run.signal(Signal::PositionReference).unwrap(), scaled(1.0));
        assert_eq!(run.signal(Signal::ControlEffort).unwrap(), scaled(2.0));
        assert_eq!(run.signal(Signal::Position).unwrap(), scaled(1.0));
        assert_eq!(run.signal(Signal::Velocity).unwrap(), scaled(3.0));
        assert_eq!(run.extra_columns()["slider_a_n"], scaled(4.0));
        assert_eq!((run.role, run.begins_s, run.sample_period_s()), (Some(Role::HeldOut), 10.0, 0.01));
        assert_eq!(run.metadata, ramp(12).metadata);
    }
}

/// Sines sampled at drifting times are the closed form but for the cubic's error and the sensor's step.
#[test]
fn exact_drifting_clock_samples_a_sine_late() {
    let (machine, period_s, samples) = (two_sensors(false), 250e-6, 8000);
    let (amplitude, rate) = (0.02, TAU * 5.0);
    let sine = |time_s: f64| amplitude * (rate * time_s).sin();
    let taken = |f: &dyn Fn(f64) -> f64| (0..samples).map(|k| f(f64::from(k) * period_s)).collect::<Vec<_>>();
    let signals = BTreeMap::from([
        (Signal::PositionReference, taken(&sine)),
        (Signal::Current, taken(&sine)),
        (Signal::Position, taken(&sine)),
        (Signal::Velocity, taken(&sine)),
        (Signal::LoadPosition, taken(&sine)),
    ]);
    let mut run = Run::new("sine", Motion::Prismatic, period_s, signals).unwrap();
    run.begins_s = 7.0;
    let (r, w, p, phase) = (-400e-6, 100e-6, 20.0, 0.7);
    let clock =
        DriftingClock { rate_ppm: 1e6 * r, wander_ppm: 1e6 * w, wander_period_s: p, wander_phase_rad: phase };
    let late = |t: f64| {
        // By the midpoint rule.
        let count = 2000;
        let middle = |k: i32| t * (f64::from(k) + 0.5) / f64::from(count);
        let wave: f64 = (0..count).map(|k| (TAU * (7.0 + middle(k)) / p + phase).sin()).sum();
        r * t + w * wave * t / f64::from(count)
    };
    assert!((clock.late_s(7.0, 1.9) - late(1.9)).abs() < 1e-10);
    assert_eq!(clock.late_s(7.0, 0.0), 0.0);
    let logged = Foreign::DriftingClock(clock).logged(run.clone(), &machine).unwrap();
    let encoder_step = machine.description().encoder.resolution_m;
    // 3/128·T⁴·x⁗ between inner samples, 1/24 at the ends.
    let cubic = amplitude * (rate * period_s).powi(4) / 24.0;
    for (signal, step) in
        [(Signal::Position, encoder_step), (Signal::Velocity, 0.0), (Signal::LoadPosition, 1e-8)]
    {
        for (k, sample) in logged.signal(signal).unwrap().iter().enumerate() {
            let t = k as f64 * period_s;
            let expected = sine((t + clock.late_s(7.0, t)).max(0.0));
            assert!(
                (sample - expected).abs() < cubic + 0.5 * step + 1e-15,
                "{signal:?} {k}: {sample} {expected}"
            );
            if step > 0.0 {
                assert!((sample / step - (sample / step).round()).abs() < 1e-6, "{signal:?} off its step");
            }
        }
    }
    for signal in [Signal::PositionReference, Signal::Current] {
        assert_eq!(logged.signal(signal), run.signal(signal));
    }
    // A clock that is right changes nothing but the rounding; one run begins as well as the other.
    let right = DriftingClock { rate_ppm: 0.0, wander_ppm: 0.0, ..clock };
    let same = Foreign::DriftingClock(right).logged(run.clone(), &machine).unwrap();
    assert_eq!(same.signal(Signal::Velocity), run.signal(Signal::Velocity));
}

fn scale(sensor: WarmSensor) -> WarmingScale {
    WarmingScale { sensor, expansion_ppm_per_k: -23.0, warming_k: 12.0, time_constant_s: 400.0, zero_m: 5e-6 }
}

/// A controller that holds a reading holds x = (reading − z)/(1 + αΔT).
#[test]
fn exact_warming_scale_moves_what_the_controller_holds() {
    let (held, clock_s, samples) = (0.03, 900.0, 12_000);
    let warm = scale(WarmSensor::Own);
    let (walked, laws) = laws(Foreign::WarmingScale(warm));
    let period_s = walked.description().sample_period_s;
    let plant = Forged::new(Axis::new(&walked.constants(), 62.5e-6), laws, clock_s);
    let mut twin = Twin::new(&walked, plant, Sensing::Perfect);
    twin.start(held, 0.0, 0.0);
    let traces = walk(&mut twin, follow(&vec![held; samples], period_s), |_| ());
    let now_s = clock_s + samples as f64 * period_s;
    let share = 1.0 - (-now_s / 400.0).exp();
    let expected = (held - 5e-6 * share) / (1.0 - 276e-6 * share);
    let place = twin.plant().inner().position();
    println!("held {:.3} µm beside the cold place", 1e6 * (place - held));
    assert!((place - expected).abs() < 1e-10, "{place} {expected}");
    assert!((place - held).abs() > 1e-6);
    assert!((traces.position.last().unwrap() - held).abs() < 1e-10);
}

/// Of two sensors one is warm: their difference is the growth, whether the loop is closed on it or not.
#[test]
fn exact_warming_scale_shows_between_two_sensors() {
    for (closes, sensor) in [(false, WarmSensor::Load), (true, WarmSensor::LoadInLoop)] {
        let machine = two_sensors(closes);
        assert_eq!(WarmSensor::of(&machine), sensor);
        let foreign = Foreign::WarmingScale(scale(sensor));
        let otherwise = otherwise(Some(foreign));
        let reference: Vec<f64> = (0..2000).map(|k| 0.02 * (1.0 - (1.5e-3 * f64::from(k)).cos())).collect();
        let begins_s = 300.0;
        let traces = sketch(&machine, &otherwise, &reference, begins_s).unwrap();
        let period_s = machine.description().sample_period_s;
        let signals = BTreeMap::from([
            (Signal::PositionReference, reference),
            (Signal::Position, traces.position),
            (Signal::Velocity, traces.velocity),
            (Signal::LoadPosition, traces.load_position),
        ]);
        let mut run = Run::new("run", Motion::Prismatic, period_s, signals).unwrap();
        run.begins_s = begins_s;
        let logged = otherwise.logged(run, &machine).unwrap();
        let (own, load) =
            (logged.signal(Signal::Position).unwrap(), logged.signal(Signal::LoadPosition).unwrap());
        let step = machine.description().encoder.resolution_m + 1e-8;
        for k in 0..logged.len() {
            let share = 1.0 - (-(begins_s + k as f64 * period_s) / 400.0).exp();
            let expected = own[k] * (1.0 - 276e-6 * share) + 5e-6 * share;
            assert!((load[k] - expected).abs() < 0.5 * step + 1e-12, "{closes} {k}: {} {expected}", load[k]);
        }
    }
}

#[test]
fn exact_foreign_kinds_show_where_they_can() {
    for kind in Foreign::ALL_KINDS {
        assert_eq!(kind.shows(&machine()), kind != ForeignKind::WarmingScale, "{kind}");
        assert!(kind.shows(&two_sensors(false)) && kind.shows(&two_sensors(true)), "{kind}");
    }
}

/// The same seed draws the same, and a file gives it back as it was.
#[test]
fn exact_foreign_draws_follow_the_seed_and_survive_files() {
    let machine = machine();
    for kind in Foreign::ALL_KINDS {
        let draw = |seed| Foreign::draw(kind, &machine, 200.0, 20.0, &mut StdRng::seed_from_u64(seed));
        for seed in 0..50 {
            let drawn = draw(seed);
            assert_eq!(drawn, draw(seed));
            assert_ne!(drawn, draw(seed + 1));
            assert_eq!((drawn.kind(), drawn.name()), (kind, kind.name()));
            let otherwise = otherwise(Some(drawn.clone()));
            let text = serde_json::to_string(&otherwise).unwrap();
            assert!(text.contains(&format!("\"kind\":\"{kind}\"")), "{text}");
            assert_eq!(serde_json::from_str::<Otherwise>(&text).unwrap(), otherwise);
            let table = toml::to_string(&drawn).unwrap();
            assert_eq!(toml::from_str::<Foreign>(&table).unwrap(), drawn);
        }
    }
    // Truths of before there was anything foreign, and those without, are the same bytes.
    let without = serde_json::to_string(&otherwise(None)).unwrap();
    assert!(!without.contains("foreign"));
    assert_eq!(serde_json::from_str::<Otherwise>(&without).unwrap(), otherwise(None));
}

#[test]
fn exact_shocks_and_missed_samples_lie_in_their_ranges() {
    let (rated, session_s, period_s) = (200.0, 20.0, 250e-6);
    let random = &mut StdRng::seed_from_u64(3);
    let mut joined = 0;
    for _ in 0..300 {
        let shocks = Shocks::draw(rated, session_s, random);
        assert!((2e-3..=20e-3).contains(&shocks.length_s));
        assert!((10..=60).contains(&shocks.pulses.len()), "{}", shocks.pulses.len());
        assert!(shocks.pulses.windows(2).all(|pair| pair[0].begins_s <= pair[1].begins_s));
        for pulse in &shocks.pulses {
            assert!((0.005 * rated..=0.1 * rated).contains(&pulse.force.abs()), "{pulse:?}");
            assert!((0.0..=session_s).contains(&pulse.begins_s));
        }
        let missed = MissedSamples::draw(period_s, session_s, random);
        let samples: usize = missed.bursts.iter().map(|burst| burst.samples).sum();
        let share = samples as f64 * period_s / session_s;
        assert!(missed.bursts.iter().all(|burst| (1..=20).contains(&burst.samples)));
        // The lengths of a dozen bursts are drawn: their sum is not the share to the digit.
        assert!((0.0004..=0.025).contains(&share), "{share}");
        joined += usize::from(missed.rows == Rows::Joined);
    }
    assert!((100..200).contains(&joined), "{joined}");
    // However short the session, something happens in it.
    assert_eq!(Shocks::draw(rated, 0.2, random).pulses.len(), 1);
    assert_eq!(MissedSamples::draw(period_s, 0.01, random).bursts.len(), 1);
}

#[test]
fn exact_clocks_and_scales_lie_in_their_ranges() {
    let random = &mut StdRng::seed_from_u64(4);
    let (mut fast, mut grown) = (0, [0; 2]);
    for _ in 0..300 {
        let clock = DriftingClock::draw(random);
        assert!((50.0..=500.0).contains(&clock.rate_ppm.abs()), "{clock:?}");
        assert!((0.0..=0.3 * clock.rate_ppm.abs()).contains(&clock.wander_ppm), "{clock:?}");
        assert!((5.0..=60.0).contains(&clock.wander_period_s), "{clock:?}");
        fast += usize::from(clock.rate_ppm < 0.0);
        for (session_s, longest_s) in [(3.0, 360.0), (40.0, 1200.0), (900.0, 3600.0)] {
            let scale = WarmingScale::draw(WarmSensor::Load, session_s, random);
            assert!([8.0, 10.0, 11.5, 23.0].contains(&scale.expansion_ppm_per_k.abs()), "{scale:?}");
            assert!((1.0..=15.0).contains(&scale.warming_k) && scale.zero_m.abs() <= 8e-6, "{scale:?}");
            assert!((300.0..=longest_s).contains(&scale.time_constant_s), "{scale:?}");
            grown[usize::from(scale.expansion_ppm_per_k > 0.0)] += 1;
        }
        // Alone, a scale that grows shows less.
        assert!(WarmingScale::draw(WarmSensor::Own, 20.0, random).expansion_ppm_per_k < 0.0);
    }
    assert!((100..200).contains(&fast) && grown[0].min(grown[1]) > 350, "{fast} {grown:?}");
}
