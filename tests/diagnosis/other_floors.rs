//! Noise takes another way through a twin that has the cause than through the twin as it is.
#![allow(clippy::unwrap_used, missing_docs)]

use crate::support::strokes::Strokes;
use slideway::diagnose::{Options, Progress, Verdict, diagnose};
use slideway::machine::Machine;
use slideway::recording::Role;
use std::path::Path;
use std::sync::Mutex;

/// On an axis that sticks for seconds after each stroke noise makes more of the position than on its twin without friction. By the floors of that twin friction leaves
/// more than noise, and effects would be looked for beside it that are not there; by its own it leaves noise, and nothing is.
#[test]
fn exact_a_first_effect_is_judged_by_its_own_noise_before_others_are_looked_for_beside_it() {
    let stated = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder")).unwrap();
    let real = stated.with_settings([("effect.coulomb_friction.force_n", 15.0.into())]).unwrap();
    let (training, held_out) = (Role::Training, Role::HeldOut);
    let cells = [
        (0.02, 4.0, training),
        (0.03, 4.0, training),
        (0.03, 8.0, training),
        (0.04, 8.0, training),
        (0.02, 8.0, held_out),
        (0.04, 16.0, held_out),
    ];
    let recording = Strokes { dwell_s: 1.9, ..Strokes::both_ways(&stated, &real, 1) }.recording(&cells);
    let fitted = Mutex::new(Vec::new());
    let progress = |progress: Progress| {
        if let Progress::Fitted(effects) = progress {
            fitted.lock().unwrap().push(effects.to_owned());
        }
    };
    let d = diagnose(&stated, &recording, &Options { progress: &progress, ..Options::default() }).unwrap();
    assert_eq!(d.verdict, Verdict::Cause);
    assert_eq!(d.causes.len(), 1);
    assert!((d.causes[0].parameters["force_n"].value - 15.0).abs() < 0.01, "{:?}", d.causes[0].parameters);
    let fitted = fitted.into_inner().unwrap();
    let friction = fitted.iter().filter(|effects| *effects == "coulomb_friction").count();
    let several: Vec<&String> = fitted.iter().filter(|effects| effects.contains(" + ")).collect();
    assert!(friction >= 3 && several.is_empty(), "{friction} {several:?}");
}
