//! What of a motion a stretch of a run holds: directions, speeds, accelerations, places, times.

use std::ops::Range;

use super::profile::{Profile, SLOW};
use super::run::Run;

/// Speeds as shares of the largest that part slow, middle and fast motion.
const SPEEDS: [f64; 2] = [0.1, 0.4];
/// Accelerations beyond this share of the largest are speeding up or slowing down, the others cruising.
const CRUISE: f64 = 0.2;
/// Parts of the travel, and of the session.
const PARTS: usize = 4;

const SPEED_BINS: usize = 2 * 3;
const ACCELERATION_BINS: usize = 2 * 3;
const PLACE_BINS: usize = 2 * PARTS;
/// Bins that tell the motion, …
pub(super) const MOTION_BINS: usize = SPEED_BINS + ACCELERATION_BINS + PLACE_BINS;
/// … and those with when it was.
pub(super) const BINS: usize = MOTION_BINS + PARTS;

/// Samples of a stretch in each bin: direction by speed, by acceleration and by place; time within the session.
pub(super) type Counts = [f64; BINS];

/// The scales in which the motion of several runs is counted.
#[derive(Debug, Clone, Copy)]
pub(super) struct Coverage {
    fastest: f64,
    strongest: f64,
    place: [f64; 2],
    session_s: [f64; 2],
}

impl Coverage {
    /// The scales of runs with these profiles.
    pub(super) fn of(runs: &[Run], profiles: &[Profile]) -> Self {
        let widest = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let strongest = |most: f64, profile: &Profile| {
            profile.acceleration.iter().fold(most, |most: f64, a| most.max(a.abs()))
        };
        Self {
            fastest: profiles.iter().map(Profile::fastest).fold(0.0, f64::max),
            strongest: profiles.iter().fold(0.0, strongest),
            place: profiles.iter().flat_map(|p| p.position.iter().copied()).fold(none, widest),
            session_s: runs
                .iter()
                .flat_map(|run| [run.begins_s, run.begins_s + run.duration_s()])
                .fold(none, widest),
        }
    }

    /// What some samples of a run hold; blocks in which the axis does not move count for nothing.
    pub(super) fn count(&self, run: &Run, profile: &Profile, samples: &Range<usize>) -> Counts {
        let mut counts = [0.0; BINS];
        let blocks = samples.start / profile.block..samples.end.div_ceil(profile.block);
        for b in blocks.start..blocks.end.min(profile.velocity.len()) {
            let v = profile.velocity[b];
            let speed = v.abs() / self.fastest;
            if speed.is_nan() || speed <= SLOW {
                continue;
            }
            let way = usize::from(v < 0.0);
            let class = SPEEDS.iter().filter(|limit| speed > **limit).count();
            let gain = profile.acceleration[b] * v.signum() / self.strongest;
            let change = if gain > CRUISE { 2 } else { usize::from(gain >= -CRUISE) };
            let place = part(profile.position[b], self.place);
            let time_s = run.begins_s + b as f64 * profile.block_s;
            let first = [0, SPEED_BINS, SPEED_BINS + ACCELERATION_BINS, MOTION_BINS];
            let bins = [3 * way + class, 3 * way + change, PARTS * way + place, part(time_s, self.session_s)];
            first.iter().zip(bins).for_each(|(first, bin)| counts[first + bin] += profile.block as f64);
        }
        counts
    }
}

/// Which of the equal parts of a range a value lies in.
fn part(value: f64, [low, high]: [f64; 2]) -> usize {
    ((PARTS as f64 * (value - low) / (high - low)) as usize).min(PARTS - 1)
}

/// Samples that move forward and backward.
pub(super) fn ways(counts: &Counts) -> [f64; 2] {
    [0, 1].map(|way| counts[3 * way..3 * way + 3].iter().sum())
}
