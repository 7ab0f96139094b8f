//! Checks of the data: each fault put into a recording is found and told, and clean recordings raise no warning.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs, clippy::print_stdout)]

use crate::support::strokes::Strokes;
use crate::support::{self, needs};
use slideway::diagnose::check::{Check, Finding, Severity, check};
use slideway::diagnose::experiment::Experiment;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal, SplitRule};
use slideway::replay::recording::recorded;
use slideway::replay::{PlantChoice, simulate};
use slideway::twin::Sensing;
use std::collections::BTreeMap;
use std::path::Path;

const GRINDER: &str = "models/grinder";
const EMPS: &str = "models/emps";

fn machine(path: &str) -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

fn set(machine: &Machine, settings: &[(&str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, value)| (*key, toml::Value::Float(*value)))).unwrap()
}

/// Stroke (m), feed (m/min) and role of each run.
const CELLS: [(f64, f64, Role); 3] =
    [(0.03, 8.0, Role::Training), (0.04, 16.0, Role::Training), (0.02, 8.0, Role::HeldOut)];

/// Runs of a machine with noise as stated; `legs` are shares of each stroke, one after the other.
fn runs_of(real: &Machine, cells: &[(f64, f64, Role)], legs: &[f64]) -> Vec<Run> {
    Strokes { legs, ..Strokes::both_ways(real, real, 7) }.recording(cells).runs().to_vec()
}

fn clean() -> Vec<Run> {
    runs_of(&machine(GRINDER), &CELLS, &[1.0, -1.0])
}

type Signals = BTreeMap<Signal, Vec<f64>>;

/// The runs with their signals changed.
fn changed(runs: &[Run], change: impl Fn(&mut Signals)) -> Vec<Run> {
    runs.iter()
        .map(|run| {
            let mut signals = run.signals().clone();
            change(&mut signals);
            let mut altered = Run::new(run.name(), run.motion(), run.sample_period_s(), signals).unwrap();
            altered.role = run.role;
            altered
        })
        .collect()
}

fn findings(machine: &Machine, runs: &[Run]) -> Vec<Finding> {
    let of = |role| -> Vec<Experiment> {
        let chosen = runs.iter().filter(|run| run.role == Some(role));
        chosen.map(|run| Experiment::new(run, machine).unwrap()).collect()
    };
    let found = check(machine, &of(Role::Training), &of(Role::HeldOut));
    for finding in &found {
        assert!(finding.message.ends_with('.') && !finding.message.contains("NaN"), "{}", finding.message);
    }
    found
}

/// What is more than a note.
fn warnings(found: &[Finding]) -> Vec<&Finding> {
    found.iter().filter(|finding| finding.severity != Severity::Note).collect()
}

fn are_fatal(found: &[&Finding]) -> bool {
    found.iter().all(|finding| finding.severity == Severity::Fatal && finding.signal.is_some())
}

fn with(found: &[Finding], check: Check) -> Vec<&Finding> {
    found.iter().filter(|finding| finding.check == check).collect()
}

/// The signal as a channel that lies `samples` behind logs it.
fn delayed(signal: &[f64], samples: f64) -> Vec<f64> {
    let at = |k: isize| signal[k.clamp(0, signal.len() as isize - 1) as usize];
    let (whole, rest) = (samples.floor() as isize, samples.fract());
    (0..signal.len() as isize).map(|k| (1.0 - rest) * at(k - whole) + rest * at(k - whole - 1)).collect()
}

/// Recovered delays lie within this of the true ones: linear interpolation of the test's own fractional delays and
/// the base modes, which the inverse dynamics leave out, shift them by a few hundredths.
const SHIFT_WITHIN: f64 = 0.1;

/// The samples that a finding of a late channel tells.
fn told_samples(finding: &Finding) -> f64 {
    let (before, _) = finding.message.split_once(" samples").unwrap();
    before.rsplit(' ').next().unwrap().parse().unwrap()
}

/// Every run tells that `word` is late by so much, and nothing else is a warning.
#[track_caller]
fn assert_late(found: &[Finding], runs: usize, word: &str, samples: f64) {
    let warnings = warnings(found);
    assert_eq!(warnings.len(), runs, "{word} {samples}: {warnings:#?}");
    for finding in warnings {
        assert_eq!(finding.check, Check::ChannelDelay);
        assert!(finding.message.starts_with(&format!("The {word} channel lies")), "{}", finding.message);
        assert!(finding.message.contains("not of the loop"));
        assert!((told_samples(finding) - samples).abs() <= SHIFT_WITHIN, "{}", finding.message);
    }
}

/// The recorded machine is stable; the twin that is said to be it is not: every replay of it would run away.
#[test]
fn exact_a_twin_whose_loop_is_unstable_is_a_finding_and_a_stable_one_is_not() {
    let (stated, runs) = (machine(GRINDER), clean());
    assert_eq!(with(&findings(&stated, &runs), Check::UnstableLoop), Vec::<&Finding>::new());
    let late = set(&stated, &[("effect.loop_delay.delay_s", 0.02)]);
    let found = findings(&late, &runs);
    let unstable = with(&found, Check::UnstableLoop);
    assert_eq!(unstable.len(), 1, "{found:#?}");
    assert!(unstable[0].severity == Severity::Warning && unstable[0].message.contains("not stable"));
}

#[test]
fn exact_clean_recordings_raise_no_warning() {
    let found = findings(&machine(GRINDER), &clean());
    assert!(warnings(&found).is_empty(), "{found:#?}");
    assert!(found.iter().all(|finding| finding.check == Check::MissingSignal), "{found:#?}");
}

/// Whatever the axis has that its twin lacks is for the diagnosis to find, not a fault of the data.
#[test]
fn exact_effects_are_no_faults_of_the_data() {
    let stated = machine(GRINDER);
    let cases: [&[(&str, f64)]; 10] = [
        &[("effect.loop_delay.delay_s", 400e-6)],
        &[("effect.loop_delay.delay_s", 1.5e-3)],
        &[("effect.coulomb_friction.force_n", 60.0)],
        &[("effect.payload.mass_kg", 8.0), ("effect.constant_force.force_n", 40.0)],
        &[("effect.viscous_friction.viscous_n_s_per_m", 900.0)],
        &[("controller.position_gain_per_s", 10.0)],
        &[("motor.inductance_h", 12e-3), ("motor.resistance_ohm", 2.0)],
        &[("motor.force_constant_n_per_a", 60.0)],
        &[("encoder.velocity.time_constant_s", 1.5e-3)],
        &[("encoder.velocity.time_constant_s", 0.0)],
    ];
    for settings in cases {
        let runs = runs_of(&set(&stated, settings), &CELLS, &[1.0, -1.0]);
        let found = findings(&stated, &runs);
        assert!(warnings(&found).is_empty(), "{settings:?}: {found:#?}");
        // Nor where only some signals were logged.
        for dropped in [&[Signal::Velocity][..], &[Signal::Velocity, Signal::Current, Signal::Thrust]] {
            let fewer = changed(&runs, |signals| signals.retain(|signal, _| !dropped.contains(signal)));
            let found = findings(&stated, &fewer);
            assert!(
                warnings(&found).iter().all(|f| f.severity != Severity::Fatal),
                "{settings:?}: {found:#?}"
            );
            for finding in with(&found, Check::ChannelDelay) {
                // What looks alike is said to.
                assert!(finding.message.contains("would look alike"), "{settings:?}: {}", finding.message);
                assert!(settings[0].0.starts_with("encoder.velocity"), "{settings:?}: {}", finding.message);
            }
        }
    }
}

#[test]
fn exact_late_channels_are_told_from_a_late_loop() {
    let stated = machine(GRINDER);
    let late = set(&stated, &[("effect.loop_delay.delay_s", 400e-6)]);
    let channels = [
        (Signal::Current, "current"),
        (Signal::Thrust, "thrust"),
        (Signal::ControlEffort, "control effort"),
        (Signal::Velocity, "velocity"),
        (Signal::Position, "position"),
        (Signal::PositionReference, "position reference"),
    ];
    for real in [&stated, &late] {
        let runs = runs_of(real, &CELLS, &[1.0, -1.0]);
        for (signal, word) in channels {
            for samples in [1.0, 1.6, 3.0] {
                let found = findings(
                    &stated,
                    &changed(&runs, |s| {
                        let moved = delayed(&s[&signal], samples);
                        s.insert(signal, moved);
                    }),
                );
                assert_late(&found, runs.len(), word, samples);
                // What the law computes is exact; a force has more in it than what moves the stated mass.
                let is_of_law =
                    matches!(signal, Signal::ControlEffort | Signal::Position | Signal::PositionReference);
                println!("{word} {samples}: {:?}", warnings(&found)[0].severity);
                assert!(!is_of_law || are_fatal(&warnings(&found)), "{word} {samples}: {found:#?}");
            }
        }
    }
}

#[test]
fn exact_what_the_signals_cannot_tell_apart_is_said() {
    let late = |signal, kept: &[Signal]| {
        let runs = changed(&clean(), |s| {
            let moved = delayed(&s[&signal], 2.0);
            s.insert(signal, moved);
            s.retain(|signal, _| kept.contains(signal));
        });
        let found = findings(&machine(GRINDER), &runs);
        with(&found, Check::ChannelDelay).into_iter().cloned().collect::<Vec<Finding>>()
    };
    use Signal::{ControlEffort, Current, Position, PositionReference, Velocity};
    let found = late(Position, &[PositionReference, Position, Current]);
    assert!(found.len() == 3 && found.iter().all(|f| f.severity == Severity::Note), "{found:#?}");
    assert!(found.iter().all(|f| f.message.contains("do not tell which")));
    // A second witness decides it.
    let found = late(Position, &[PositionReference, Position, Current, Velocity]);
    assert!(
        found.len() == 3 && found.iter().all(|f| f.message.contains("force and velocity alike")),
        "{found:#?}"
    );
    let found = late(ControlEffort, &[PositionReference, Position, ControlEffort]);
    assert!(found.len() == 3 && found.iter().all(|f| f.message.contains("would look alike")), "{found:#?}");
    let found = late(Current, &[PositionReference, Position, Current]);
    assert!(
        found.len() == 3 && found.iter().all(|f| f.message.contains("motion that it causes")),
        "{found:#?}"
    );
}

/// Forces that no check knows (cogging, Stribeck friction) neither make nor hide a delay of the current.
#[test]
fn exact_unmodelled_forces_are_no_delay() {
    let force_constant = 83.1;
    let with_forces = changed(&clean(), |signals| {
        let force = |k: usize| {
            let (x, v) = (signals[&Signal::Position][k], signals[&Signal::Velocity][k]);
            6.0 * (std::f64::consts::TAU * x / 0.03).sin() + 10.0 * v.signum() * (-(v / 0.02).powi(2)).exp()
        };
        let more: Vec<f64> = (0..signals[&Signal::Position].len()).map(force).collect();
        for (signal, scale) in [(Signal::Current, 1.0 / force_constant), (Signal::Thrust, 1.0)] {
            for (sample, force) in signals.get_mut(&signal).unwrap().iter_mut().zip(&more) {
                *sample += scale * force;
            }
        }
    });
    let found = findings(&machine(GRINDER), &with_forces);
    assert!(warnings(&found).is_empty(), "{found:#?}");
}

#[test]
fn exact_swapped_signs_are_named_with_their_column() {
    let signals =
        [Signal::Current, Signal::Thrust, Signal::ControlEffort, Signal::Velocity, Signal::Position];
    for signal in signals {
        let runs = changed(&clean(), |s| s.get_mut(&signal).unwrap().iter_mut().for_each(|x| *x = -*x));
        let found = findings(&machine(GRINDER), &runs);
        let warnings = warnings(&found);
        assert_eq!(warnings.len(), runs.len(), "{signal}: {warnings:#?}");
        assert!(are_fatal(&warnings), "{warnings:#?}");
        for finding in warnings {
            let key = signal.key(slideway::units::Motion::Prismatic);
            assert_eq!(finding.check, Check::SwappedSign);
            assert!(
                finding.message.contains(&format!("`{key}` the entry `scale = -1`")),
                "{}",
                finding.message
            );
        }
    }
}

#[test]
fn exact_units_off_by_a_power_of_ten_are_named() {
    let cases = [
        (Signal::Current, 1e3, "in mA"),
        (Signal::Thrust, 1e-3, "in kN"),
        (Signal::Thrust, 0.1, "in daN"),
        (Signal::ControlEffort, 1e3, "in mV"),
        (Signal::Velocity, 1e3, "unit = \"mm/s\""),
        (Signal::Velocity, 60.0, "unit = \"m/min\""),
    ];
    for (signal, factor, unit) in cases {
        let runs = changed(&clean(), |s| s.get_mut(&signal).unwrap().iter_mut().for_each(|x| *x *= factor));
        let found = findings(&machine(GRINDER), &runs);
        let warnings = warnings(&found);
        assert_eq!(warnings.len(), runs.len(), "{signal} × {factor}: {warnings:#?}");
        for finding in warnings {
            assert_eq!(finding.check, Check::ImplausibleUnit);
            // Ten times too small a force may be a mass that is not there.
            let is_certain = !(0.05..20.0).contains(&factor);
            assert_eq!(finding.severity == Severity::Fatal, is_certain, "{signal} × {factor}");
            assert!(finding.message.contains(unit), "{}", finding.message);
        }
    }
    // Twice as much is no unit.
    let runs = changed(&clean(), |s| s.get_mut(&Signal::Current).unwrap().iter_mut().for_each(|x| *x *= 2.0));
    assert!(warnings(&findings(&machine(GRINDER), &runs)).is_empty());
}

#[test]
fn exact_clipping_is_found_with_and_without_a_stated_limit() {
    let top = |signal, share: f64| {
        changed(&clean(), |s| {
            let samples = s.get_mut(&signal).unwrap();
            let most = share * samples.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            samples.iter_mut().for_each(|x| *x = x.clamp(-most, most));
        })
    };
    for signal in [Signal::Current, Signal::ControlEffort] {
        let found = findings(&machine(GRINDER), &top(signal, 0.6));
        assert_eq!(with(&found, Check::Clipping).len(), 3, "{found:#?}");
        assert!(with(&found, Check::Clipping).iter().all(|f| f.message.contains("it is clipped")));
    }
    let limit =
        clean()[0].signal(Signal::ControlEffort).unwrap().iter().fold(0.0, |a: f64, b| a.max(*b)) * 0.7;
    let limited = set(&machine(GRINDER), &[("amplifier.voltage_limit_v", limit)]);
    let found = findings(&limited, &clean()[..2]);
    assert!(with(&found, Check::Clipping).iter().all(|f| f.message.contains("stated limit")), "{found:#?}");
    assert_eq!(with(&found, Check::Clipping).len(), 2);
}

#[test]
fn exact_dead_frozen_and_held_channels_are_found() {
    let one = |signal, change: &dyn Fn(&mut Vec<f64>)| {
        let found = findings(&machine(GRINDER), &changed(&clean(), |s| change(s.get_mut(&signal).unwrap())));
        warnings(&found).into_iter().cloned().collect::<Vec<Finding>>()
    };
    let dead = one(Signal::Current, &|samples| samples.fill(0.25));
    assert!(dead.len() == 3 && dead.iter().all(|f| f.check == Check::StuckChannel), "{dead:#?}");
    let frozen = one(Signal::Position, &|samples| {
        // From 0.125 s on, in the first stroke.
        let value = samples[500];
        samples[500..1000].fill(value);
    });
    let frozen = with(&frozen, Check::StuckChannel).len();
    assert_eq!(frozen, 3);
    let held = one(Signal::Thrust, &|samples| {
        for k in 0..samples.len() {
            samples[k] = samples[k - k % 4];
        }
    });
    let held: Vec<&Finding> = with(&held, Check::HeldChannel);
    assert!(held.len() == 3 && held[0].message.contains("every 4th sample"), "{held:#?}");
}

#[test]
fn exact_motion_that_leaves_parameters_open_is_told() {
    let m = machine(GRINDER);
    let of = |cells: &[(f64, f64, Role)], legs: &[f64]| findings(&m, &runs_of(&m, cells, legs));
    let still = of(&CELLS, &[]);
    assert_eq!(with(&still, Check::NoMotion).len(), 4);
    assert!(still.iter().any(|f| f.message.contains("never moves")));
    let one_way = of(&CELLS, &[1.0]);
    assert_eq!(with(&one_way, Check::MissingReversal).len(), 4);
    assert!(one_way.iter().any(|f| f.message.contains("one direction")));
    let one_speed = of(&[(0.03, 8.0, Role::Training), (0.04, 16.0, Role::HeldOut)], &[1.0, -1.0]);
    assert!(with(&one_speed, Check::WeakExcitation)[0].message.contains("one speed only"), "{one_speed:#?}");
}

/// Strokes so gentle that friction is all there is.
#[test]
fn exact_a_mass_that_hardly_accelerates_is_not_told() {
    let m = machine(GRINDER);
    let period = m.description().sample_period_s;
    let runs: Vec<Run> = [(0.2, Role::Training), (0.25, Role::HeldOut)]
        .iter()
        .map(|&(pace, role)| {
            let wave = |k: usize| 0.01 * (1.0 - (std::f64::consts::TAU * pace * k as f64 * period).cos());
            let reference: Vec<f64> = (0..24_000).map(wave).collect();
            let traces =
                simulate(&m, PlantChoice::Axis, Sensing::AsStated { seed: 3 }, &reference, |_| ()).unwrap();
            let mut run = recorded(&format!("slow{pace}"), &m, &reference, traces).unwrap();
            run.role = Some(role);
            run
        })
        .collect();
    let found = findings(&m, &runs);
    let weak = with(&found, Check::WeakExcitation);
    assert!(weak.len() == 1 && weak[0].message.contains("hardly accelerate"), "{found:#?}");
    assert_eq!(warnings(&found).len(), 1, "{found:#?}");
}

#[test]
fn exact_uneven_time_stamps_are_told() {
    let jittered = |shift: f64| {
        let mut runs = clean();
        for run in &mut runs {
            run.timing.worst_jitter_s = shift * run.sample_period_s();
            run.timing.irregular_intervals = 2;
            run.timing.worst_jitter_row = Some(52);
        }
        findings(&machine(GRINDER), &runs)
    };
    let found = jittered(0.2);
    let jitter = with(&found, Check::TimingJitter);
    assert!(
        jitter.len() == 3 && jitter[0].message.contains("20.0 %") && jitter[0].message.contains("row 52")
    );
    assert_eq!(with(&jittered(0.8), Check::GapInTime).len(), 3);
    assert!(with(&jittered(0.005), Check::TimingJitter).is_empty());
    let mut drifting = clean();
    for run in &mut drifting {
        run.timing.measured_period_s = Some(run.sample_period_s() * (1.0 + 8e-4));
    }
    let found = findings(&machine(GRINDER), &drifting);
    assert!(with(&found, Check::TimingJitter)[0].message.contains("800 ppm slower"), "{found:#?}");
}

#[test]
fn exact_a_second_sensor_is_held_against_the_first() {
    let with_load = |change: &dyn Fn(f64) -> f64, samples: f64| {
        let runs = changed(&clean(), |s| {
            let load = delayed(&s[&Signal::Position], samples).into_iter().map(change).collect();
            s.insert(Signal::LoadPosition, load);
        });
        findings(&machine(GRINDER), &runs)
    };
    assert!(with_load(&|x| x, 0.0).is_empty());
    let offset = with_load(&|x| x + 0.0123, 0.0);
    assert_eq!(with(&offset, Check::SensorOffset).len(), 3, "{offset:#?}");
    assert!(offset[0].message.contains("12.3 mm") && warnings(&offset).is_empty());
    let swapped = with_load(&|x| -x, 0.0);
    assert_eq!(with(&swapped, Check::SwappedSign).len(), 3, "{swapped:#?}");
    let inches = with_load(&|x| x / 0.0254, 0.0);
    assert!(with(&inches, Check::ImplausibleUnit)[0].message.contains("in"), "{inches:#?}");
    let late = with_load(&|x| x, 3.0);
    assert_eq!(with(&late, Check::ChannelDelay).len(), 3, "{late:#?}");
    assert!(late.iter().all(|f| f.message.contains("motor and load") && f.severity == Severity::Note));
}

#[test]
fn ref_the_shipped_recording_raises_no_warning() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let recording = Recording::read(root.join("assets/hidden_coulomb")).unwrap();
    let found = findings(&machine(GRINDER), recording.runs());
    assert!(warnings(&found).is_empty(), "{found:#?}");
}

/// A column is mapped once for all runs: what one run of three shows is not certain.
#[test]
fn exact_one_run_against_the_others_is_no_certain_fault() {
    let mut runs = clean();
    let swapped = changed(&runs, |s| s.get_mut(&Signal::Current).unwrap().iter_mut().for_each(|x| *x = -*x));
    runs[0] = swapped[0].clone();
    let found = findings(&machine(GRINDER), &runs);
    assert_eq!(with(&found, Check::SwappedSign)[0].severity, Severity::Warning);
    runs[1] = swapped[1].clone();
    let found = findings(&machine(GRINDER), &runs);
    assert!(with(&found, Check::SwappedSign).len() == 2 && are_fatal(&with(&found, Check::SwappedSign)));
}

/// No measured log has a fault that would withhold its verdict: a drive whose velocity is filtered, a scale behind a worn screw, a
/// pendulum polled unevenly, a motor with a disc.
#[test]
fn ref_measured_logs_have_no_fatal_finding() {
    let logs = [
        ("emps/emps_estimation.csv", EMPS, &["recording.toml"][..]),
        (
            "grinder_yaxis/normal_1.parquet",
            "models/grinder_yaxis",
            &["normal.toml", "mechanical.toml", "mechanical_8.toml"],
        ),
        ("xl330_pendulum/kp100_sin_sin.csv", "models/xl330", &["recording.toml", "six.toml"]),
        ("delta_a3/S1_noFF_1.parquet", "models/delta_a3", &["recording.toml", "stages.toml"]),
    ];
    for (data, model, files) in logs {
        needs!(support::data(data));
        for file in files {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(model).join(file);
            let (training, held_out) = Recording::read(path).unwrap().split(SplitRule::default()).unwrap();
            let axis = machine(model);
            let of = |runs: &[Run]| -> Vec<Experiment> {
                runs.iter().map(|run| Experiment::new(run, &axis).unwrap()).collect()
            };
            for finding in check(&axis, &of(training.runs()), &of(held_out.runs())) {
                println!("{model}/{file}: {finding:?}");
                assert!(finding.severity != Severity::Fatal, "{model}/{file}: {finding:#?}");
            }
        }
    }
}

/// The measured axis of the EMPS benchmark: its log is sound, and delays put into it are found.
#[test]
fn ref_a_measured_log_raises_no_warning_and_shows_delays_put_into_it() {
    needs!(support::data("emps/emps_estimation.csv"));
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let axis = machine(EMPS);
    let recording = Recording::read(root.join("models/emps/recording.toml")).unwrap();
    let found = findings(&axis, recording.runs());
    assert!(warnings(&found).is_empty(), "{found:#?}");
    for (signal, word) in [(Signal::ControlEffort, "control effort"), (Signal::Position, "position")] {
        let runs = changed(recording.runs(), |s| {
            let moved = delayed(&s[&signal], 2.0);
            s.insert(signal, moved);
        });
        assert_late(&findings(&axis, &runs), 2, word, 2.0);
    }
}
