//! Signals that were not logged, and what cannot be told without them.

use super::super::experiment::Experiment;
use super::{Check, Finding};
use crate::recording::Signal;

/// What the lack of signals costs.
pub fn missing(all: &[&Experiment]) -> Vec<Finding> {
    let logged = |signal| all.iter().all(|e| e.run().signal(signal).is_some());
    let mut findings = Vec::new();
    let mut say = |message: &str| findings.push(Finding::note("", Check::MissingSignal, message));
    if !logged(Signal::ControlEffort) {
        say("The control effort was not logged: controller and amplifier cannot be told apart.");
    }
    if !logged(Signal::Current) && !logged(Signal::Thrust) {
        say(
            "Neither current nor thrust was logged: amplifier, motor, guide and structure are one segment, and only the effects' different signatures in the motion tell them apart.",
        );
    }
    if !logged(Signal::LoadPosition) {
        say(
            "There is no second position sensor: what lies between motor and load, and errors of the one sensor, show only through the control loop.",
        );
    }
    findings
}
