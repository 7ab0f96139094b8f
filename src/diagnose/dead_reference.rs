//! References that cannot be what the controller was told.

use super::experiment::Experiment;
use crate::error::{Error, ErrorKind, Result};
use crate::recording::{Run, Signal};
use crate::units::engineering;

// Both shares tell being moved from being held, which differ by orders: a held axis gives way by noise, drift or sag, microns of a
// stroke. A run that was pushed by hand without a note would be refused too.
/// A position that travels this share of what other runs are told to travel was told to.
const TRAVELS: f64 = 0.25;
/// A position that comes to rest this share of its travel away from where it began was told to go there.
const ENDS_ELSEWHERE: f64 = 0.5;
/// Parts of a run whose means say where it begins and ends.
const PARTS: usize = 50;

/// Refuses a run whose reference stands still while its position goes where nothing pushed it: a replay in closed loop would
/// stand still too, and what it leaves would pass for noise.
///
/// # Errors
/// As said. A run with a logged disturbance passes: that may have moved it.
pub(super) fn refuse(runs: &[&Experiment]) -> Result<()> {
    let told = |experiment: &&Experiment| travel(samples(experiment.run(), Signal::PositionReference));
    let told = runs.iter().map(told).fold(0.0, f64::max);
    for experiment in runs.iter().filter(|experiment| experiment.input().is_none()) {
        let run = experiment.run();
        let pushed = [Signal::DisturbanceVoltage, Signal::DisturbanceForce];
        let (reference, position) = (samples(run, Signal::PositionReference), samples(run, Signal::Position));
        if position.is_empty() {
            continue;
        }
        let gone = travel(position);
        let is_elsewhere = if told > 0.0 {
            gone > TRAVELS * told
        } else {
            let part = position.len() / PARTS + 1;
            let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
            let (begins, ends) = (mean(&position[..part]), mean(&position[position.len() - part..]));
            gone > 0.0 && (ends - begins).abs() > ENDS_ELSEWHERE * gone
        };
        if travel(reference) > 0.0 || !is_elsewhere || pushed.iter().any(|s| run.signal(*s).is_some()) {
            continue;
        }
        let (key, unit) =
            (Signal::PositionReference.key(run.motion()), Signal::Position.si_unit(run.motion()));
        return Err(Error::new(ErrorKind::Inconsistent)
            .file(&run.file)
            .key(key)
            .found(format!(
                "{} throughout run `{}`, while the position travels {}",
                engineering(reference.first().copied().unwrap_or(0.0), unit),
                run.name(),
                engineering(gone, unit)
            ))
            .expected("what the controller was told")
            .remedy("map the column that holds the reference, or take the run out; without a reference, runs are replayed from a measured effort"));
    }
    Ok(())
}

fn samples(run: &Run, signal: Signal) -> &[f64] {
    run.signal(signal).unwrap_or_default()
}

fn travel(samples: &[f64]) -> f64 {
    let low = samples.iter().copied().fold(f64::INFINITY, f64::min);
    let high = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if high > low { high - low } else { 0.0 }
}
