//! What an operator asks of a stroke: overshoot, peaks, settling.

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
        let (mut start, counts) = motion.samples(period_s);
        let mut from = 0.0;
        for (stroke, count) in motion.strokes.iter().zip(counts) {
            let moving = (stroke.duration_s(motion.ramp_s) / period_s).ceil() as usize;
            let feed = stroke.feed.copysign(stroke.stroke);
            let end = (start + count).min(traces.len());
            let mut last_outside = None;
            let places = traces.position[start.min(end)..end].iter().zip(&velocity[start.min(end)..end]);
            for (k, (position, velocity)) in places.enumerate() {
                let travelled = (position - from) / stroke.stroke;
                let speed = velocity / feed;
                figures.overshoot = figures.overshoot.max(travelled - 1.0);
                figures.peak_velocity = figures.peak_velocity.max(speed - 1.0);
                figures.most_negative_velocity = figures.most_negative_velocity.min(speed);
                if (travelled - 1.0).abs() > SETTLING_BAND {
                    last_outside = Some(start + k);
                }
            }
            let settled = last_outside.map_or(start, |k| k + 1);
            let after_motion = settled.saturating_sub(start + moving) as f64 * period_s;
            let worst = figures.settling_s.map(|before| before.max(after_motion));
            figures.settling_s = if settled < end { worst } else { None };
            start += count;
            from += stroke.stroke;
        }
        figures
    }
}

/// Mean over `reach` samples to each side, fewer at the ends.
fn running_mean(samples: &[f64], reach: usize) -> Vec<f64> {
    let window = |k: usize| &samples[k.saturating_sub(reach)..(k + reach + 1).min(samples.len())];
    (0..samples.len()).map(|k| window(k).iter().sum::<f64>() / window(k).len() as f64).collect()
}
