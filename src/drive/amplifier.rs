//! The amplifier: from commanded to applied voltage.

use serde::{Deserialize, Serialize};

/// Voltage amplifier: holds the commanded voltage over the sample period, after its delay, within its limit.
///
/// # Model
/// `u_applied(t) = clip(dead(u_commanded(t − delay)) + offset, ±limit)` with `dead(u) = u − sgn(u)·min(|u|, w)` for a
/// dead zone of half width w; the commanded voltage is a staircase, so the
/// applied one changes inside a period when the delay is not a whole number of periods.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Amplifier {
    /// Symmetric voltage limit in V; absent: no clipping.
    #[serde(default)]
    pub voltage_limit_v: Option<f64>,
    /// Delay between command and voltage that the machine is known to have, in s.
    #[serde(default)]
    pub delay_s: f64,
    /// Half width in V of the dead zone that the machine is known to have.
    #[serde(default)]
    pub dead_zone_v: f64,
    /// Voltage in V at zero command that the machine is known to have.
    #[serde(default)]
    pub offset_v: f64,
}

impl Amplifier {
    /// The voltage that a commanded voltage ends up as.
    #[inline]
    pub fn output_v(&self, command_v: f64) -> f64 {
        let live = command_v - command_v.clamp(-self.dead_zone_v, self.dead_zone_v) + self.offset_v;
        match self.voltage_limit_v {
            Some(limit) => live.clamp(-limit, limit),
            None => live,
        }
    }
}

/// A delay split into whole sample periods and the rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SplitDelay {
    /// Whole periods.
    pub periods: usize,
    /// The rest as a fraction of one period, 0 ≤ fraction < 1.
    pub fraction: f64,
}

impl SplitDelay {
    /// Splits `delay_s` at the sample period; a negative delay counts as none.
    ///
    /// ```
    /// use slideway::drive::amplifier::SplitDelay;
    /// let split = SplitDelay::new(625e-6, 250e-6);
    /// assert_eq!(split.periods, 2);
    /// assert!((split.fraction - 0.5).abs() < 1e-9);
    /// ```
    pub fn new(delay_s: f64, period_s: f64) -> Self {
        let delay = (delay_s / period_s).max(0.0);
        // Rounding noise must not turn "exactly two periods" into 1.999….
        let nearest = delay.round();
        if (delay - nearest).abs() < 1e-9 {
            return Self { periods: nearest as usize, fraction: 0.0 };
        }
        Self { periods: delay.floor() as usize, fraction: delay.fract() }
    }
}
