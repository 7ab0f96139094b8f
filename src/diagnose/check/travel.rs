//! References that do not move, or only one way.

use super::super::experiment::Experiment;
use super::{Check, Finding};

/// Share of the top speed from which the reference counts as moving in a direction.
const MOVES: f64 = 0.1;

/// Whether a reference goes up, and whether it goes down.
fn directions(experiment: &Experiment) -> (bool, bool) {
    let speeds = || experiment.recorded().commands().iter().map(|c| c.velocity_reference);
    let most = speeds().fold(0.0, |most: f64, v| most.max(v.abs()));
    (most > 0.0 && speeds().any(|v| v > MOVES * most), most > 0.0 && speeds().any(|v| v < -MOVES * most))
}

/// What one run's reference leaves open.
pub fn of_run(experiment: &Experiment) -> Option<Finding> {
    let run = experiment.run().name();
    match directions(experiment) {
        (true, true) => None,
        (false, false) => Some(Finding::note(
            run,
            Check::NoMotion,
            "The reference never moves: this run says nothing about friction, mass or delay.",
        )),
        // What was cut out of a run goes one way because it was cut so.
        _ if experiment.run().is_part() => None,
        _ => Some(Finding::note(
            run,
            Check::MissingReversal,
            "The axis moves in one direction only: Coulomb friction and a constant force look alike while it \
             moves.",
        )),
    }
}

/// What no training run makes good.
pub fn of_recording(training: &[Experiment]) -> Option<Finding> {
    let (up, down) = training.iter().map(directions).fold((false, false), |(a, b), (c, d)| (a || c, b || d));
    match (up, down) {
        (true, true) => None,
        (false, false) => Some(Finding::warning(
            "",
            Check::NoMotion,
            "No training run moves: only forces that push at standstill can be identified. Record strokes there \
             and back.",
        )),
        _ => Some(Finding::warning(
            "",
            Check::MissingReversal,
            "All training runs go the same way: Coulomb friction and a constant force can be told apart only \
             where the axis stops. Record strokes there and back.",
        )),
    }
}
