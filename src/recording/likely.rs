//! Samples that no axis has: too large for any, out of proportion to the other runs, or stuck while the axis is told to move.

use super::run::Run;
use super::signal::Signal;
use crate::error::{Error, ErrorKind, Result};
use crate::units::{Dimension, engineering};

/// Peaks of the same signal in two runs of one motion differ by less than this factor, feeds and loads apart.
const PROPORTION: f64 = 300.0;
/// Travels differ by less than this factor where two runs are compared.
const LIKE_TRAVEL: f64 = 10.0;

/// Larger than any axis has it, in SI.
fn largest(dimension: Dimension) -> f64 {
    match dimension {
        Dimension::Length => 1e6,
        Dimension::Velocity | Dimension::Acceleration => 1e6,
        Dimension::Angle | Dimension::AngularVelocity | Dimension::AngularAcceleration => 1e9,
        Dimension::Force | Dimension::Torque => 1e9,
        Dimension::Voltage | Dimension::Current => 1e7,
        _ => 1e12,
    }
}

/// Refuses a sample that is larger than any axis has it.
pub(super) fn check_size(samples: &[f64], dimension: Dimension, first_row: u64, column: &str) -> Result<()> {
    let most = largest(dimension);
    let Some(place) = samples.iter().position(|sample| !(-most..=most).contains(sample)) else {
        return Ok(());
    };
    let unit = dimension.si_symbol();
    Err(Error::new(ErrorKind::OutOfRange)
        .row(first_row + place as u64)
        .key(column)
        .found(format!("{:e} {unit}", samples[place]))
        .expected(format!("a {dimension} of at most {most:e} {unit}"))
        .remedy("repair the row, or correct the unit of the column in [columns]"))
}

/// Refuses what all runs together show to be wrong.
pub(super) fn check(runs: &[Run]) -> Result<()> {
    check_proportions(runs)?;
    check_moving(runs)
}

fn peak(samples: &[f64]) -> f64 {
    samples.iter().fold(0.0, |peak: f64, sample| peak.max(sample.abs()))
}

fn travel(samples: &[f64]) -> f64 {
    let ends = samples
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high): (f64, f64), x| (low.min(*x), high.max(*x)));
    (ends.1 - ends.0).max(0.0)
}

/// A signal of one run that is larger than in every other of like travel by far: another unit or scale.
fn check_proportions(runs: &[Run]) -> Result<()> {
    let travels: Vec<f64> = runs.iter().map(|run| run.signal(Signal::Position).map_or(0.0, travel)).collect();
    for signal in [Signal::Current, Signal::ControlEffort, Signal::Thrust, Signal::Velocity] {
        let peaks: Vec<f64> = runs.iter().map(|run| run.signal(signal).map_or(0.0, peak)).collect();
        for (at, run) in runs.iter().enumerate() {
            let alike = |other: &usize| {
                let ratio = travels[*other] / travels[at];
                *other != at && peaks[*other] > 0.0 && ratio > 1.0 / LIKE_TRAVEL && ratio < LIKE_TRAVEL
            };
            let others: Vec<f64> = (0..runs.len()).filter(alike).map(|other| peaks[other]).collect();
            let most = others.iter().copied().fold(0.0, f64::max);
            if others.is_empty() || peaks[at] <= PROPORTION * most {
                continue;
            }
            let (key, unit) = (signal.key(run.motion()), signal.si_unit(run.motion()));
            return Err(Error::new(ErrorKind::Unit)
                .file(&run.file)
                .key(key)
                .found(format!("up to {} in run `{}`", engineering(peaks[at], unit), run.name()))
                .expected(format!(
                    "about what the other runs of like travel have, {} at most",
                    engineering(most, unit)
                ))
                .remedy("give this run's columns their unit in [run.columns], or leave the run out"));
        }
    }
    Ok(())
}

/// A position that stands still to the last bit in every run, while its reference moves: a sensor that is stuck.
fn check_moving(runs: &[Run]) -> Result<()> {
    let moved = |signal, run: &Run| run.signal(signal).map_or(0.0, travel);
    let is_stuck = |run: &&Run| {
        run.signal(Signal::Position).is_some()
            && moved(Signal::Position, run) == 0.0
            && moved(Signal::LoadPosition, run) == 0.0
            && moved(Signal::PositionReference, run) > 0.0
    };
    let told = |run: &&Run| moved(Signal::PositionReference, run) > 0.0;
    let Some(first) = runs.iter().find(is_stuck) else { return Ok(()) };
    // One of several may be held by friction at a small stroke.
    let largest = runs.iter().map(|run| moved(Signal::PositionReference, run)).fold(0.0, f64::max);
    let is_held = moved(Signal::PositionReference, first) < largest / LIKE_TRAVEL;
    if is_held && !runs.iter().filter(told).all(|run| is_stuck(&run)) {
        return Ok(());
    }
    let key = Signal::Position.key(first.motion());
    let unit = Signal::Position.si_unit(first.motion());
    Err(Error::new(ErrorKind::Inconsistent)
        .file(&first.file)
        .key(key)
        .found(format!("the same value in all samples of run `{}`", first.name()))
        .expected(format!(
            "a position that follows its reference, which moves by {}",
            engineering(moved(Signal::PositionReference, first), unit)
        ))
        .remedy("the sensor is stuck or another column was meant: correct [columns], or leave the run out"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Motion;
    use std::collections::BTreeMap;

    fn run(name: &str, position: f64, current: f64) -> Run {
        let ramp = |size: f64| (0..100).map(|k| size * f64::from(k) / 99.0).collect::<Vec<f64>>();
        let signals = BTreeMap::from([
            (Signal::PositionReference, ramp(0.02)),
            (Signal::Position, ramp(position)),
            (Signal::Current, ramp(current)),
        ]);
        Run::new(name, Motion::Prismatic, 1e-3, signals).unwrap()
    }

    #[test]
    fn exact_runs_out_of_proportion_are_refused() {
        assert!(check(&[run("a", 0.02, 1.0), run("b", 0.02, 2.0)]).is_ok());
        let error = check(&[run("a", 0.02, 1.0), run("b", 0.02, 1e3)]).unwrap_err();
        assert_eq!(error.key_name(), Some("current_a"));
        // A run of another travel is another experiment.
        assert!(check(&[run("a", 0.02, 1.0), run("b", 2.0, 1e3)]).is_ok());
    }

    #[test]
    fn exact_a_position_that_stands_still_is_refused() {
        assert_eq!(
            check(&[run("a", 0.0, 1.0), run("b", 0.02, 1.0)]).unwrap_err().key_name(),
            Some("position_m")
        );
    }

    #[test]
    fn exact_samples_beyond_any_axis_are_refused_with_their_row() {
        let error = check_size(&[0.0, 1e300], Dimension::Current, 2, "i").unwrap_err();
        assert_eq!(error.row_number(), Some(3));
        assert!(check_size(&[0.0, -1e3], Dimension::Current, 2, "i").is_ok());
    }
}
