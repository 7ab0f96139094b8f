//! Strokes: trapezoidal velocity profiles as a controller generates them.

use crate::error::{Error, ErrorKind, Result};

/// Strokes and feeds that some axis could make, in m and m/s, or rad and rad/s.
const SHORTEST: f64 = 1e-15;
const LONGEST: f64 = 1e5;
const SLOWEST: f64 = 1e-15;
const FASTEST: f64 = 1e5;

/// One stroke: a distance at a feed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Distance in m, or rad for a revolute axis; negative strokes go the other way.
    pub stroke: f64,
    /// Feed (speed between the ramps) in m/s or rad/s; more than zero.
    pub feed: f64,
}

impl Stroke {
    /// A stroke as operators name it: metres at metres per minute.
    ///
    /// ```
    /// use slideway::replay::Stroke;
    /// let stroke = Stroke::metres_at_metres_per_minute(0.02, 8.0).unwrap();
    /// assert!((stroke.feed - 0.13333).abs() < 1e-5);
    /// ```
    ///
    /// # Errors
    /// A stroke of zero, a feed of zero or less, or anything not finite.
    pub fn metres_at_metres_per_minute(stroke_m: f64, feed_m_per_min: f64) -> Result<Self> {
        Self::new(stroke_m, feed_m_per_min / 60.0)
    }

    /// A stroke in SI.
    ///
    /// # Errors
    /// A stroke of zero, a feed of zero or less, or anything not finite.
    pub fn new(stroke: f64, feed: f64) -> Result<Self> {
        let right = (SHORTEST..=LONGEST).contains(&stroke.abs()) && (SLOWEST..=FASTEST).contains(&feed);
        if right {
            return Ok(Self { stroke, feed });
        }
        Err(Error::new(ErrorKind::OutOfRange)
            .key("stroke")
            .found(format!("a stroke of {stroke} at a feed of {feed}"))
            .expected(format!(
                "a stroke that is not zero, up to {LONGEST:e} m or rad, at a feed above zero, up to {FASTEST:e} m/s or rad/s"
            ))
            .remedy("write STROKE@FEED in m and m/min, for instance 0.02@8"))
    }

    /// Position of the profile `time` seconds after its start, from 0 to `stroke`.
    ///
    /// # Model
    /// Velocity rises linearly to the feed in `ramp_s`, stays, and falls linearly in `ramp_s`; where the
    /// stroke is too short for the feed, the ramps meet at the peak that keeps their slope.
    pub fn position(&self, time: f64, ramp_s: f64) -> f64 {
        let distance = self.stroke.abs();
        let slope = self.feed / ramp_s.max(f64::MIN_POSITIVE);
        let ramp = ramp_s.min((distance / slope).sqrt());
        let peak = if ramp < ramp_s { slope * ramp } else { self.feed };
        let end = self.duration_s(ramp_s);
        let travelled = if time <= 0.0 {
            0.0
        } else if time < ramp {
            0.5 * peak * time * time / ramp
        } else if time < end - ramp {
            peak * (time - 0.5 * ramp)
        } else if time < end {
            distance - 0.5 * peak * (end - time) * (end - time) / ramp
        } else {
            distance
        };
        travelled.copysign(self.stroke)
    }

    /// Time that the profile takes, in s.
    pub fn duration_s(&self, ramp_s: f64) -> f64 {
        let distance = self.stroke.abs();
        let slope = self.feed / ramp_s.max(f64::MIN_POSITIVE);
        let ramp = ramp_s.min((distance / slope).sqrt());
        let peak = if ramp < ramp_s { slope * ramp } else { self.feed };
        distance / peak + ramp
    }
}

/// A motion: strokes one after the other, each with a dwell after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// The strokes in their order.
    pub strokes: Vec<Stroke>,
    /// Standstill before the first stroke and after each one, in s.
    pub lead_s: f64,
    /// Standstill after each stroke, in s.
    pub dwell_s: f64,
    /// Time from rest to feed, in s.
    pub ramp_s: f64,
}

impl Motion {
    /// Samples of the standstill before the first stroke, then of each stroke with its dwell.
    pub fn samples(&self, period_s: f64) -> (usize, Vec<usize>) {
        let count = |duration: f64| (duration / period_s).round() as usize;
        let of_stroke = |stroke: &Stroke| count(stroke.duration_s(self.ramp_s) + self.dwell_s);
        (count(self.lead_s), self.strokes.iter().map(of_stroke).collect())
    }

    /// The position reference, sampled.
    pub fn reference(&self, period_s: f64) -> Vec<f64> {
        let (lead, counts) = self.samples(period_s);
        let mut reference = vec![0.0; lead];
        let mut from = 0.0;
        for (stroke, samples) in self.strokes.iter().zip(counts) {
            reference.extend(
                (0..samples).map(|k| from + stroke.position((k as f64 + 1.0) * period_s, self.ramp_s)),
            );
            from += stroke.stroke;
        }
        reference
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn exact_short_stroke_keeps_the_slope() {
        let stroke = Stroke::new(0.001, 1.0).unwrap();
        // 1 mm at 50 m/s²: peak √(a·d) = 0.2236 m/s, lasting 2·√(d/a).
        assert!((stroke.duration_s(0.02) - 2.0 * (0.001f64 / 50.0).sqrt()).abs() < 1e-12);
    }

    proptest! {
        /// The profile is monotonic, ends at the stroke, and never exceeds the feed.
        #[test]
        fn exact_profile_keeps_its_word(stroke in 1e-4..0.5f64, feed in 0.01..1.0f64, ramp in 1e-3..0.1f64) {
            let profile = Stroke::new(stroke, feed).unwrap();
            let end = profile.duration_s(ramp);
            let steps = 2000;
            let mut before = 0.0;
            for k in 1..=steps {
                let now = profile.position(end * f64::from(k) / f64::from(steps), ramp);
                let speed = (now - before) / (end / f64::from(steps));
                prop_assert!(speed >= -1e-9 && speed <= feed * (1.0 + 1e-6));
                before = now;
            }
            prop_assert!((before - stroke).abs() < 1e-9);
        }
    }
}
