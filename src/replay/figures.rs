//! What an operator asks of a stroke: overshoot, peaks, settling.

use std::ops::Range;

use super::{Motion, Traces};

/// Band around the end of a stroke inside which the axis counts as settled, as a fraction of the stroke.
pub const SETTLING_BAND: f64 = 0.02;

/// Window of the running mean of velocity, in s: short beside every motion, long beside the noise.
pub const VELOCITY_WINDOW_S: f64 = 2e-3;

/// Figures of one run; of several strokes the worst counts.
///
/// # Model
/// Position and velocity of each stroke are divided by the signed stroke and feed, so that a return stroke counts
/// like one forth. Velocity is averaged over `VELOCITY_WINDOW_S` around each sample, which takes the sensor's
/// noise out of its peaks. Overshoot = max(position) − 1, not below 0; settling = time from the end of the reference's
/// motion until position stays within 1 ± [`SETTLING_BAND`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Position beyond the end of the stroke, as a fraction of the stroke.
    pub overshoot: f64,
    /// Highest velocity less the feed, as a fraction of the feed.
    pub peak_velocity: f64,
    /// Lowest velocity in the stroke's direction, as a fraction of the feed; negative when it ran back.
    pub most_negative_velocity: f64,
    /// Largest thrust in either direction, N or N·m.
    pub peak_thrust: f64,
    /// Largest effort in either direction, V.
    pub peak_effort_v: f64,
    /// Time to settle in s; none where some stroke did not within its dwell.
    pub settling_s: Option<f64>,
}

impl Figures {
    /// Of the traces of a motion sampled at `period_s`.
    pub fn of(motion: &Motion, period_s: f64, traces: &Traces) -> Self {
        let (mut start, counts) = motion.samples(period_s);
        let (mut from, mut legs) = (0.0, Vec::new());
        for (stroke, count) in motion.strokes.iter().zip(counts) {
            let moving = (stroke.duration_s(motion.ramp_s) / period_s).ceil() as usize;
            let samples = start..start + count;
            legs.push(Leg { samples, moving, from, stroke: stroke.stroke, feed: stroke.feed });
            start += count;
            from += stroke.stroke;
        }
        Self::over(&legs, period_s, traces)
    }

    /// Of traces that were recorded along a reference of strokes at a feed in m/s or rad/s; none where the reference
    /// does not move.
    pub fn along(reference: &[f64], feed: f64, period_s: f64, traces: &Traces) -> Option<Self> {
        let legs = Leg::all(reference, feed);
        (!legs.is_empty()).then(|| Self::over(&legs, period_s, traces))
    }

    fn over(legs: &[Leg], period_s: f64, traces: &Traces) -> Self {
        let magnitude = |samples: &[f64]| samples.iter().fold(0.0_f64, |peak, x| peak.max(x.abs()));
        let mut figures = Self {
            overshoot: 0.0,
            peak_velocity: f64::NEG_INFINITY,
            most_negative_velocity: f64::INFINITY,
            peak_thrust: magnitude(&traces.thrust),
            peak_effort_v: magnitude(&traces.effort_v),
            settling_s: Some(0.0),
        };
        let velocity = running_mean(&traces.velocity, (0.5 * VELOCITY_WINDOW_S / period_s).round() as usize);
        for leg in legs {
            let feed = leg.feed.copysign(leg.stroke);
            let start = leg.samples.start;
            let end = leg.samples.end.min(traces.len());
            let mut last_outside = None;
            let places = traces.position[start.min(end)..end].iter().zip(&velocity[start.min(end)..end]);
            for (k, (position, velocity)) in places.enumerate() {
                let travelled = (position - leg.from) / leg.stroke;
                let speed = velocity / feed;
                figures.overshoot = figures.overshoot.max(travelled - 1.0);
                figures.peak_velocity = figures.peak_velocity.max(speed - 1.0);
                figures.most_negative_velocity = figures.most_negative_velocity.min(speed);
                if (travelled - 1.0).abs() > SETTLING_BAND {
                    last_outside = Some(start + k);
                }
            }
            let settled = last_outside.map_or(start, |k| k + 1);
            let after_motion = settled.saturating_sub(start + leg.moving) as f64 * period_s;
            let worst = figures.settling_s.map(|before| before.max(after_motion));
            figures.settling_s = if settled < end { worst } else { None };
        }
        figures
    }
}

/// One stroke and the dwell after it, among the samples of a run.
struct Leg {
    samples: Range<usize>,
    /// Samples in which the reference moves.
    moving: usize,
    /// Where it begins, m or rad.
    from: f64,
    /// Signed distance in m or rad.
    stroke: f64,
    /// Feed in m/s or rad/s.
    feed: f64,
}

impl Leg {
    /// The stretches in which a reference moves one way, each with the standstill after it.
    fn all(reference: &[f64], feed: f64) -> Vec<Self> {
        let mut legs: Vec<Self> = Vec::new();
        let mut before = 0.0;
        for (k, pair) in reference.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            if step != 0.0 && step * before <= 0.0 {
                if let Some(last) = legs.last_mut() {
                    last.samples.end = k + 1;
                }
                let samples = k + 1..reference.len();
                legs.push(Self { samples, moving: 0, from: pair[0], stroke: 0.0, feed });
            }
            if let (Some(leg), true) = (legs.last_mut(), step != 0.0) {
                leg.moving += 1;
                leg.stroke = pair[1] - leg.from;
            }
            before = step;
        }
        legs
    }
}

/// Mean over `reach` samples to each side, fewer at the ends.
fn running_mean(samples: &[f64], reach: usize) -> Vec<f64> {
    let window = |k: usize| &samples[k.saturating_sub(reach)..(k + reach + 1).min(samples.len())];
    (0..samples.len()).map(|k| window(k).iter().sum::<f64>() / window(k).len() as f64).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::Stroke;

    /// Forth and back: told from the reference as from the motion that made it.
    #[test]
    fn exact_figures_along_a_reference_are_those_of_its_motion() {
        let stroke = Stroke::new(0.02, 0.13).unwrap();
        let back = Stroke { stroke: -stroke.stroke, ..stroke };
        let motion = Motion { strokes: vec![stroke, back], lead_s: 0.05, dwell_s: 0.2, ramp_s: 0.02 };
        let period_s = 1e-3;
        let reference = motion.reference(period_s);
        // An axis that follows 5 ms late and goes 3 % too far.
        let late = |k: usize| 1.03 * reference[k.saturating_sub(5)];
        let position: Vec<f64> = (0..reference.len()).map(late).collect();
        let slope = |k: usize| (late(k) - late(k.saturating_sub(1))) / period_s;
        let velocity = (0..reference.len()).map(slope).collect();
        let traces = Traces { position, velocity, ..Traces::default() };
        let of_motion = Figures::of(&motion, period_s, &traces);
        let along = Figures::along(&reference, stroke.feed, period_s, &traces).unwrap();
        for (a, b) in [
            (along.overshoot, of_motion.overshoot),
            (along.peak_velocity, of_motion.peak_velocity),
            (along.most_negative_velocity, of_motion.most_negative_velocity),
        ] {
            assert!((a - b).abs() < 1e-9, "{along:?} {of_motion:?}");
        }
        assert!((along.overshoot - 0.03).abs() < 1e-9);
        assert!(Figures::along(&[0.0; 50], 0.1, period_s, &traces).is_none());
    }
}
