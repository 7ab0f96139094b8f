//! How replays of recorded runs begin.
#![allow(clippy::unwrap_used, missing_docs)]

use slideway::machine::Machine;
use slideway::replay::start::Start;

/// At rest the twin's drive tells the current; in a transient a current that is seen to differ counts.
#[test]
fn exact_a_resting_current_is_what_the_drive_makes_of_the_effort() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let constants = Machine::read(&folder).unwrap().constants();
    let start = |current, current_off| Start {
        position: 0.0,
        velocity: 0.0,
        acceleration: Some(0.0),
        effort_v: Some(0.13),
        resting_effort_v: Some(0.13),
        current: Some(current),
        current_off,
        reading: None,
        load_position: None,
        feedforward_v: 0.0,
    };
    let settled = start(0.0, f64::INFINITY).current_a(&constants);
    assert!(settled > 0.0);
    assert_eq!(start(0.5, f64::INFINITY).current_a(&constants), settled);
    assert_eq!(start(0.5, 0.01).current_a(&constants), 0.5);
    assert_eq!(start(settled + 0.005, 0.01).current_a(&constants), settled);
    let moving = Start { resting_effort_v: None, ..start(0.5, 0.0) };
    assert_eq!(moving.current_a(&constants), 0.5);
}
