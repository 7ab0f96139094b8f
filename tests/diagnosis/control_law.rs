//! The control law, held against the logged effort: what the drive feeds forward beyond the law that the machine states is told, and no effect is
//! named in its place.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::diagnose::check::{Check, Severity};
use slideway::diagnose::grounds::Veto;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose};
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::replay::recording::recorded;
use slideway::replay::{Commands, Motion, PlantChoice, Stroke, run_seed};
use slideway::report::{Style, terminal};
use slideway::twin::Sensing;
use slideway::units::Motion as Kind;
use std::collections::BTreeMap;
use std::path::Path;

const VELOCITY_GAIN: f64 = 243.45;
const PERIOD_S: f64 = 1e-3;

fn set(machine: &Machine, settings: &[(&str, f64)]) -> Machine {
    machine.with_settings(settings.iter().map(|(key, value)| (*key, toml::Value::Float(*value)))).unwrap()
}

/// A screw axis at 1 kHz with a full velocity feed-forward and 0.2 µm of noise.
fn machine() -> Machine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps");
    let settings = [
        ("controller.position_gain_per_s", 30.0),
        ("controller.velocity_feedforward", 1.0),
        ("encoder.noise_m", 2e-7),
        ("guide.viscous_n_s_per_m", 200.0),
    ];
    set(&Machine::read(&path).unwrap(), &settings)
}

/// Strokes of `real` whose drive feeds `fed` volts of the reference forward; the log holds them in the effort only.
fn recording(real: &Machine, fed: impl Fn(&[f64]) -> Vec<f64>) -> Recording {
    let cells = [
        (0.05, 8.0, Role::Training),
        (0.12, 12.0, Role::Training),
        (0.02, 5.0, Role::Training),
        (0.08, 10.0, Role::HeldOut),
    ];
    let run = |(stroke, feed, role): (f64, f64, Role)| {
        let whole = Stroke::metres_at_metres_per_minute(stroke, feed).unwrap();
        let strokes = [1.0, -1.0].map(|share| Stroke { stroke: share * whole.stroke, ..whole }).to_vec();
        let reference = Motion { strokes, lead_s: 0.3, dwell_s: 0.6, ramp_s: 0.15 }.reference(PERIOD_S);
        let name = format!("stroke{:.0}", 1e3 * stroke);
        let told = BTreeMap::from([
            (Signal::PositionReference, reference.clone()),
            (Signal::DisturbanceVoltage, fed(&reference)),
            (Signal::Position, vec![0.0; reference.len()]), // a run has to have a measured signal; none is read here
        ]);
        let told = Run::new(&name, Kind::Prismatic, PERIOD_S, told).unwrap();
        let sensing = Sensing::AsStated { seed: run_seed(11, &name) };
        let commands = Commands::of(&told, real).unwrap();
        let traces = commands.simulate(real, PlantChoice::Axis, sensing, |_| ()).unwrap();
        let mut run = recorded(&name, real, &reference, traces).unwrap();
        run.role = Some(role);
        run
    };
    Recording::new(cells.map(run).to_vec()).unwrap()
}

/// Backward difference of the reference per s.
fn rate(reference: &[f64], k: usize) -> f64 {
    if k == 0 { 0.0 } else { (reference[k] - reference[k - 1]) / PERIOD_S }
}

fn fed_forward(volts: impl Fn(&[f64], usize) -> f64) -> impl Fn(&[f64]) -> Vec<f64> {
    move |reference| (0..reference.len()).map(|k| volts(reference, k)).collect()
}

fn diagnosed(fed: impl Fn(&[f64], usize) -> f64) -> Diagnosis {
    diagnose(&machine(), &recording(&machine(), fed_forward(fed)), &Options::default()).unwrap()
}

/// One warning about the control law, which says this; no verdict, and no fault of a column.
#[track_caller]
fn assert_told(d: &Diagnosis, words: &str) {
    let told: Vec<_> = d.checks.iter().filter(|finding| finding.check == Check::ControlLaw).collect();
    assert!(matches!(told[..], [one] if one.message.contains(words)), "{:#?}", d.checks);
    assert!(d.checks.iter().all(|finding| finding.severity != Severity::Fatal), "{:#?}", d.checks);
    assert_eq!(d.verdict, Verdict::Unknown, "{:?}", d.causes);
    let text = terminal(d, Kind::Prismatic, Style::default());
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.find(words.trim()).unwrap() < text.find("training").unwrap(), "{text}");
}

#[test]
fn exact_a_velocity_feedforward_that_acts_late_is_told_and_no_effect_named() {
    let late = |reference: &[f64], k: usize| match k {
        0 => 0.0,
        _ => VELOCITY_GAIN * (rate(reference, k - 1) - rate(reference, k)),
    };
    let d = diagnosed(late);
    assert_told(&d, "a velocity feed-forward that acts");
    let message = &d.checks.iter().find(|finding| finding.check == Check::ControlLaw).unwrap().message;
    let (lag, _) = message.split_once("that acts ").unwrap().1.split_once(" later").unwrap();
    let (value, unit) = lag.split_once(' ').unwrap();
    let lag_s = value.parse::<f64>().unwrap() * if unit == "ms" { 1e-3 } else { 1e-6 };
    assert!((lag_s - PERIOD_S).abs() < 0.02 * PERIOD_S, "{message}");
    assert_eq!(d.withheld.unwrap().by, Veto::Stretch);
}

#[test]
fn exact_an_acceleration_feedforward_is_told_and_no_channel_late() {
    let d = diagnosed(|reference, k| match k {
        0 => 0.0,
        _ => (rate(reference, k) - rate(reference, k - 1)) / PERIOD_S,
    });
    assert_told(&d, " per m/s² of the reference's acceleration");
    assert!(d.checks.iter().all(|finding| finding.check != Check::ChannelDelay), "{:#?}", d.checks);
}

#[test]
fn exact_a_friction_feedforward_is_told() {
    let sign = |rate: f64| if rate == 0.0 { 0.0 } else { rate.signum() };
    let d = diagnosed(|reference, k| 0.5 * sign(rate(reference, k)));
    assert_told(&d, "a feed-forward of 500 mV in the direction of the commanded motion");
}

/// What the log has beside the law as stated is no contradiction of an effect of the plant: the reference reaches the controller as late as stated.
#[test]
fn exact_a_stated_delay_of_the_reference_is_no_gap_of_the_controller() {
    let stated = set(&machine(), &[("reference.delay_s", 2.5e-3)]);
    let real = set(&stated, &[("effect.coulomb_friction.force_n", 20.0)]);
    let d = diagnose(&stated, &recording(&real, |reference| vec![0.0; reference.len()]), &Options::default());
    let d = d.unwrap();
    assert_eq!(d.verdict, Verdict::Cause, "{:?}", d.withheld);
    assert!(d.causes.iter().map(|cause| cause.effect.as_str()).eq(["coulomb_friction"]), "{:?}", d.causes);
    assert!(d.checks.iter().all(|finding| finding.check != Check::ControlLaw), "{:#?}", d.checks);
    let controller = d.place.segment.iter().find(|share| share.name == "controller").unwrap();
    assert!(controller.share < 0.01, "{:?}", d.place.segment);
}

/// Another gain than stated is an effect of the catalogue: it is named, and closes what the law as stated leaves.
#[test]
fn exact_another_gain_is_named_and_not_contradicted() {
    let gain = ("controller.velocity_gain_v_s_per_m", 0.85 * VELOCITY_GAIN);
    let real = set(&machine(), &[gain, ("effect.coulomb_friction.force_n", 20.0)]);
    let d =
        diagnose(&machine(), &recording(&real, |reference| vec![0.0; reference.len()]), &Options::default());
    let d = d.unwrap();
    let mut named: Vec<&str> = d.causes.iter().map(|cause| cause.effect.as_str()).collect();
    named.sort_unstable();
    assert_eq!((d.verdict, &named[..]), (Verdict::Cause, &["coulomb_friction", "velocity_gain"][..]));
    assert!(d.checks.iter().all(|finding| finding.check != Check::ControlLaw), "{:#?}", d.checks);
}
