//! The sensor at the load beside that of the axis: do they count from one zero?

use super::{Check, Finding};
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use crate::units::engineering;

/// An offset counts from so many standard deviations of the difference on: below, lost motion and screw errors
/// are all there is.
const LEAST_DEVIATIONS: f64 = 3.0;
/// A difference that varies more than this share of the travel is no offset but another unit or sign.
const LARGEST_VARIATION: f64 = 0.1;

/// A constant difference between the two sensors.
pub fn offset(run: &Run, machine: &Machine) -> Option<Finding> {
    let (load, position) = (run.signal(Signal::LoadPosition)?, run.signal(Signal::Position)?);
    let count = run.len() as f64;
    let mean = load.iter().zip(position).map(|(l, x)| l - x).sum::<f64>() / count;
    let squares: f64 = load.iter().zip(position).map(|(l, x)| (l - x - mean).powi(2)).sum();
    let deviation = (squares / count).sqrt();
    let (low, high) =
        position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    let encoder = &machine.description().encoder;
    let noise = encoder.resolution_m.max(encoder.noise_m);
    let is_offset = mean.abs() > LEAST_DEVIATIONS * deviation.max(noise)
        && deviation <= LARGEST_VARIATION * (high - low).max(f64::MIN_POSITIVE);
    is_offset.then(|| {
        let (key, unit) = (Signal::LoadPosition.key(run.motion()), Signal::Position.si_unit(run.motion()));
        Finding::note(
            run.name(),
            Check::SensorOffset,
            format!(
                "The second sensor counts from another zero: the load position is {} more than the position \
                 throughout. Give `{key}` the entry `offset = {:.6e}` in [columns].",
                engineering(mean, unit),
                -mean
            ),
        )
    })
}
