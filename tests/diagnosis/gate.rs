//! A fault of the data withholds the verdict: nothing is fitted to a column that is not what it is taken for.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use crate::support::strokes::Strokes;
use slideway::diagnose::check::{Check, Severity};
use slideway::diagnose::grounds::Veto;
use slideway::diagnose::{Diagnosis, Options, Verdict, diagnose, improved};
use slideway::effect::EffectId;
use slideway::machine::Machine;
use slideway::recording::{Recording, Role, Run, Signal};
use slideway::report::material::Material;
use slideway::report::{Style, html, terminal};
use slideway::units::Motion;
use std::path::Path;

fn machine() -> Machine {
    Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap()
}

/// Strokes of a machine with friction that its twin lacks, one signal changed by whoever logged it.
fn recording(signal: Signal, change: impl Fn(&[f64]) -> Vec<f64>) -> Recording {
    let cells = [(0.03, 8.0, Role::Training), (0.04, 16.0, Role::Training), (0.02, 8.0, Role::HeldOut)];
    let stated = machine();
    let real = stated.with_settings([("effect.coulomb_friction.force_n", 15.0.into())]).unwrap();
    let runs = Strokes::both_ways(&stated, &real, 5).recording(&cells).runs().to_vec();
    let altered = |run: &Run| {
        let mut signals = run.signals().clone();
        let changed = change(&signals[&signal]);
        signals.insert(signal, changed);
        let mut altered = Run::new(run.name(), run.motion(), run.sample_period_s(), signals).unwrap();
        altered.role = run.role;
        altered
    };
    Recording::new(runs.iter().map(altered).collect()).unwrap()
}

fn assert_withheld(recording: &Recording, check: Check, key: &str) -> Diagnosis {
    let d = diagnose(&machine(), recording, &Options::default()).unwrap();
    let fatal: Vec<_> = d.checks.iter().filter(|f| f.severity == Severity::Fatal).collect();
    assert_eq!(fatal.len(), 3, "{:#?}", d.checks);
    assert!(fatal.iter().all(|f| f.check == check && f.signal.as_deref() == Some(key)), "{fatal:#?}");
    assert_eq!((d.verdict, d.withheld.as_ref().unwrap().by), (Verdict::Unknown, Veto::Data));
    assert!(d.causes.is_empty() && d.effects.is_empty() && d.next_experiment.is_none());
    assert!(improved(&d, &machine()).unwrap().is_none());
    let json = serde_json::to_value(&d).unwrap();
    assert_eq!((&json["verdict"], &json["withheld"]["by"]), (&"unknown".into(), &"data".into()));
    assert!(
        json["checks"].as_array().unwrap().iter().any(|f| f["severity"] == "fatal" && f["signal"] == key)
    );
    let text = terminal(&d, Motion::Prismatic, Style::default());
    assert!(text.starts_with("FAULT IN THE DATA\n  The "), "{text}");
    let sentence = fatal[0].message.split(' ').take(3).collect::<Vec<_>>().join(" ");
    assert!(text.find(&sentence).unwrap() < text.find("NO VERDICT").unwrap(), "{text}");
    assert!(!text.contains("CALIBRATED") && text.contains("Correct what is wrong with the data"), "{text}");
    d
}

#[test]
fn exact_a_swapped_sign_withholds_the_verdict() {
    let recording = recording(Signal::Current, |samples| samples.iter().map(|x| -x).collect());
    let d = assert_withheld(&recording, Check::SwappedSign, "current_a");
    let machine = machine();
    let page = html::diagnosis(&d, &machine, &Material::of(&machine, &recording, &d).unwrap(), "").html;
    let (fault, head) = (page.find("class=\"withheld\"").unwrap(), page.find("<h1").unwrap());
    assert!(fault < head && page.contains("<li class=\"warning\">Fault: "));
}

#[test]
fn exact_a_wrong_unit_withholds_the_verdict() {
    let in_kilonewton = |samples: &[f64]| samples.iter().map(|f| 1e-3 * f).collect();
    assert_withheld(&recording(Signal::Thrust, in_kilonewton), Check::ImplausibleUnit, "thrust_n");
}

#[test]
fn exact_a_late_channel_withholds_the_verdict() {
    let late = |samples: &[f64]| (0..samples.len()).map(|k: usize| samples[k.saturating_sub(2)]).collect();
    assert_withheld(&recording(Signal::ControlEffort, late), Check::ChannelDelay, "control_effort_v");
}

/// Strokes of 20 to 40 mm at 8 and 16 m/min of an axis with a longer way: what they cannot show is told in their numbers.
#[test]
fn exact_unknown_says_what_these_runs_could_not_test() {
    let catalogue = [EffectId::Payload, EffectId::Cogging, EffectId::StribeckFriction, EffectId::LoopDelay];
    let options = Options { catalogue: &catalogue, ..Options::default() };
    let d = diagnose(&machine(), &recording(Signal::Current, <[f64]>::to_vec), &options).unwrap();
    assert_eq!((d.verdict, d.withheld), (Verdict::Unknown, None));
    let of = |effect: &str| d.untested.iter().find(|u| u.effects.iter().any(|e| e == effect)).unwrap();
    let (pitch, slow) = (of("cogging"), of("stribeck_friction"));
    // The longest stroke, and what the axis overshoots it by.
    assert!(pitch.beyond == "pitch above" && (0.04..0.045).contains(&pitch.limit), "{pitch:?}");
    assert!(slow.beyond == "speed below" && (slow.limit - 8.0 / 60.0).abs() < 1e-6, "{slow:?}");
    assert!(slow.motion.contains("13.3 mm/s"), "{slow:?}");
}

#[test]
fn exact_sound_data_withhold_nothing() {
    let options = Options { catalogue: &[slideway::effect::EffectId::CoulombFriction], ..Options::default() };
    let d = diagnose(&machine(), &recording(Signal::Current, <[f64]>::to_vec), &options).unwrap();
    assert_eq!((d.verdict, d.withheld), (Verdict::Cause, None));
    assert!(d.untested.is_empty() && d.gap.rigid_body.is_some_and(|proof| !proof.has_failed()));
}
