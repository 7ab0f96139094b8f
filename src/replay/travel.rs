//! The motions that an axis can make: within its travel, and not longer than can be simulated.

use super::stroke::{Motion, Stroke};
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::units;

/// Samples of a run at most: more than a day at 1 kHz.
const MOST_SAMPLES: f64 = 1e8;

/// The sampled position reference of a motion that the machine can make.
///
/// # Errors
/// A motion beyond the joint's limits, or one that would take more than 10⁸ samples; found before anything is sampled.
pub fn planned_reference(machine: &Machine, motion: &Motion) -> Result<Vec<f64>> {
    let reached: Vec<f64> = motion
        .strokes
        .iter()
        .scan(0.0, |from, stroke| {
            *from += stroke.stroke;
            Some(*from)
        })
        .collect();
    check_travel(machine, &reached)?;
    check_samples(machine, motion, 1)?;
    Ok(motion.reference(machine.description().sample_period_s))
}

/// Refuses so many runs of a motion that would take more than 10⁸ samples together.
///
/// # Errors
/// As said.
pub fn check_samples(machine: &Machine, motion: &Motion, runs: usize) -> Result<()> {
    let period_s = machine.description().sample_period_s;
    let of_stroke = |stroke: &Stroke| stroke.duration_s(motion.ramp_s) + motion.dwell_s;
    let duration_s = motion.lead_s + motion.strokes.iter().map(of_stroke).sum::<f64>();
    let samples = duration_s / period_s * runs as f64;
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let each = if runs > 1 { format!("{runs} motions") } else { "a motion".to_owned() };
    Err(Error::new(ErrorKind::OutOfRange)
        .key("cell")
        .found(format!("{each} of {duration_s:.3e} s, {samples:.1e} samples"))
        .expected(format!("at most {MOST_SAMPLES:.0e} samples"))
        .remedy("ask for a higher feed, a shorter standstill, or fewer runs"))
}

/// Refuses a reference beyond the joint's limits.
pub(super) fn check_travel(machine: &Machine, reference: &[f64]) -> Result<()> {
    let joint = &machine.solid().joint;
    match reference.iter().find(|position| !(joint.lower..=joint.upper).contains(*position)) {
        None => Ok(()),
        Some(_) => {
            let far = reference.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
            let unit = match joint.motion {
                units::Motion::Prismatic => "m",
                units::Motion::Revolute => "rad",
            };
            Err(Error::new(ErrorKind::OutOfRange)
                .file(&machine.solid().path)
                .key(joint.name.clone())
                .found(format!("a motion to {far} {unit}"))
                .expected(format!("positions from {} to {} {unit}", joint.lower, joint.upper))
                .remedy("shorten the stroke; it starts at position 0"))
        }
    }
}
