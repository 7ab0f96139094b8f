//! Checks of the data before anything is solved, in plain words.

use super::experiment::Experiment;
use crate::machine::Machine;
use crate::recording::Signal;
use serde::Serialize;

/// Something about the data that limits or colours what can be told from them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The run concerned; empty for the recording as a whole.
    pub run: String,
    /// What was found and what follows, as a sentence.
    pub message: String,
}

/// Interval jitter above this share of the period is mentioned.
const JITTER: f64 = 0.01;
/// Share of samples at the voltage limit above which clipping is mentioned.
const CLIPPED: f64 = 0.001;

/// Looks through the runs.
pub fn check(machine: &Machine, training: &[Experiment], held_out: &[Experiment]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for experiment in training.iter().chain(held_out) {
        let mut say = |message: String| {
            findings.push(Finding { run: experiment.run().name().to_string(), message });
        };
        timing(experiment, &mut say);
        motion(experiment, &mut say);
        clipping(experiment, machine, &mut say);
    }
    let mut say = |message: &str| findings.push(Finding { run: String::new(), message: message.to_string() });
    let logged = |signal| training.iter().chain(held_out).all(|e| e.run().signal(signal).is_some());
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

fn timing(experiment: &Experiment, say: &mut impl FnMut(String)) {
    let timing = &experiment.run().timing;
    if timing.worst_jitter() > JITTER {
        say(format!(
            "Sampling jitter of up to {:.1} % of the period ({} irregular intervals): the replay assumes an even clock.",
            100.0 * timing.worst_jitter(),
            timing.irregular_intervals
        ));
    }
}

fn motion(experiment: &Experiment, say: &mut impl FnMut(String)) {
    let commands = experiment.recorded().commands();
    let most = commands.iter().fold(0.0, |most: f64, c| most.max(c.velocity_reference.abs()));
    if most == 0.0 {
        say("The reference never moves: this run says nothing about friction, mass or delay.".to_string());
        return;
    }
    let (forward, backward) = commands.iter().fold((false, false), |(f, b), c| {
        (f || c.velocity_reference > 0.1 * most, b || c.velocity_reference < -0.1 * most)
    });
    if !(forward && backward) {
        say("The axis moves in one direction only: Coulomb friction and a constant force look alike while it moves.".to_string());
    }
}

fn clipping(experiment: &Experiment, machine: &Machine, say: &mut impl FnMut(String)) {
    let (Some(limit), Some(effort)) =
        (machine.description().amplifier.voltage_limit_v, experiment.run().signal(Signal::ControlEffort))
    else {
        return;
    };
    let clipped = effort.iter().filter(|u| u.abs() >= limit).count() as f64 / effort.len() as f64;
    if clipped > CLIPPED {
        say(format!(
            "The effort is at the amplifier's limit of {limit} V in {:.1} % of the samples: the loop is open there.",
            100.0 * clipped
        ));
    }
}
