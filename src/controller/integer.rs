//! Integer gains of a microprocessor controller and their one conversion to SI.

use serde::{Deserialize, Serialize};

/// A gain as the operator types it: a 16-bit signed register that saturates instead of wrapping.
///
/// ```
/// use slideway::controller::integer::IntegerGain;
/// assert_eq!(IntegerGain::saturating(70_000), IntegerGain::MAX);
/// assert_eq!(IntegerGain::saturating(260).value(), 260);
/// ```
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(from = "i64", into = "i64")]
pub struct IntegerGain(i16);

impl IntegerGain {
    /// Largest register value.
    pub const MAX: Self = Self(i16::MAX);
    /// Smallest register value.
    pub const MIN: Self = Self(i16::MIN);

    /// The register value nearest to `value`; beyond full scale it stays at full scale.
    pub fn saturating(value: i64) -> Self {
        Self(value.clamp(i64::from(i16::MIN), i64::from(i16::MAX)) as i16)
    }

    /// The register's content.
    pub fn value(self) -> i16 {
        self.0
    }
}

impl From<i64> for IntegerGain {
    fn from(value: i64) -> Self {
        Self::saturating(value)
    }
}

impl From<IntegerGain> for i64 {
    fn from(gain: IntegerGain) -> Self {
        i64::from(gain.0)
    }
}

/// The one place where a register value becomes an SI gain and back.
///
/// # Model
/// `gain_si = register · gain_per_count · velocity_units_per_si`: the controller computes with
/// velocities in its own unit (`velocity_units_per_si` of them make 1 m/s or 1 rad/s), and one
/// register count is worth `gain_per_count` in volts per that unit.
///
/// ```
/// use slideway::controller::integer::{IntegerGain, Scale};
/// let scale = Scale { gain_per_count: 2.359e-4, velocity_units_per_si: 1000.0 };
/// let register = IntegerGain::saturating(260);
/// assert_eq!(scale.nearest(scale.si(register)), register);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Volts per controller velocity unit (and per second, for an integral gain) of one register count.
    pub gain_per_count: f64,
    /// Controller velocity units in one SI unit of velocity.
    pub velocity_units_per_si: f64,
}

impl Scale {
    /// The SI gain of a register value.
    pub fn si(self, register: IntegerGain) -> f64 {
        f64::from(register.0) * self.gain_per_count * self.velocity_units_per_si
    }

    /// The register value whose SI gain is nearest; saturates at full scale.
    pub fn nearest(self, gain_si: f64) -> IntegerGain {
        let counts = gain_si / (self.gain_per_count * self.velocity_units_per_si);
        IntegerGain::saturating(counts.round() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Registers survive the way to SI and back; what does not fit stays at full scale with its sign.
        #[test]
        fn exact_registers_and_si_gains_are_one(
            value in any::<i64>(),
            per_count in 1e-6..1e3f64,
            units in 1e-3..1e4f64,
            beyond in 1.0..1e6f64,
        ) {
            let scale = Scale { gain_per_count: per_count, velocity_units_per_si: units };
            let register = IntegerGain::saturating(value);
            prop_assert_eq!(i64::from(register), value.clamp(-32_768, 32_767));
            prop_assert_eq!(scale.nearest(scale.si(register)), register);
            prop_assert_eq!(scale.nearest(beyond * scale.si(IntegerGain::MAX)), IntegerGain::MAX);
            prop_assert_eq!(scale.nearest(-(1.0 + beyond) * scale.si(IntegerGain::MAX)), IntegerGain::MIN);
        }

        /// The nearest register is at most half a count off.
        #[test]
        fn exact_nearest_register_is_nearest(counts in -32_000.0..32_000.0f64, per_count in 1e-6..1e3f64) {
            let scale = Scale { gain_per_count: per_count, velocity_units_per_si: 1000.0 };
            let gain = counts * per_count * 1000.0;
            let off = (scale.si(scale.nearest(gain)) - gain).abs() / (per_count * 1000.0);
            prop_assert!(off <= 0.5 + 1e-9, "{off} counts");
        }
    }
}
