//! The amplifier: from commanded to applied voltage.

use serde::{Deserialize, Serialize};

/// Voltage amplifier: holds the commanded voltage over the sample period, after its delay, within its limit.
///
/// # Model
/// `u_applied(t) = s·clip(dead(u_commanded(t − delay)) + offset, ±limit)` with `dead(u) = u − sgn(u)·min(|u|, w)` for a
/// dead zone of half width w; the commanded voltage is a staircase, so the
/// applied one changes inside a period when the delay is not a whole number of periods.
///
/// s = 1 where the command is a voltage. Where it is a duty cycle, s is the supply voltage, as recorded (`supply_voltage_v`)
/// or else as stated here, and one volt of command stands for a duty of 1: the limit is ±1, and it acts before back-EMF,
/// dead zone and offset are shares of the supply.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
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
    /// s in V of an amplifier that is commanded by a duty cycle; absent: the command is a voltage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply_v: Option<f64>,
}

/// Largest magnitude of a duty cycle.
const WHOLE_DUTY: f64 = 1.0;

impl Amplifier {
    /// Volts applied per volt of command inside the limit: the stated supply of a duty cycle, else 1.
    #[inline]
    pub fn gain(&self) -> f64 {
        self.supply_v.unwrap_or(1.0)
    }

    /// The same at a sample at which the supply was `recorded_v`.
    #[inline]
    pub fn gain_under(&self, recorded_v: Option<f64>) -> f64 {
        match self.supply_v {
            Some(stated) => recorded_v.unwrap_or(stated),
            None => 1.0,
        }
    }

    /// The same amplifier with the limit that a duty cycle has.
    #[must_use]
    pub fn within_duty(mut self) -> Self {
        if self.supply_v.is_some() {
            self.voltage_limit_v =
                Some(self.voltage_limit_v.map_or(WHOLE_DUTY, |stated| stated.min(WHOLE_DUTY)));
        }
        self
    }

    /// The command that reaches the bridge: a voltage, or a duty cycle to be multiplied by [`gain`](Self::gain).
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
