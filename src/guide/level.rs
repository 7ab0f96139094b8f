//! The level at which a guide slides.

use crate::elementary::decay;

/// The level at which a guide slides over one step, by direction and speed.
///
/// # Model
/// ```text
///   g(s, |v|) = max(0, (b_s + p_s·exp(−(v/v_s)²))·k + l)
/// ```
/// with the direction s, a base and a peak at rest for each direction, the factor k that time has made of them and the part l of the place; all
/// forces in N or N·m.
///
/// # Source
/// As [`DryFriction`](super::DryFriction), whose level this is with load, place and time put in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// b in the positive and the negative direction.
    pub base: [f64; 2],
    /// p in the positive and the negative direction.
    pub peak: [f64; 2],
    /// v_s in m/s or rad/s; infinite without a peak.
    pub velocity: f64,
    /// k.
    pub factor: f64,
    /// l.
    pub local: f64,
}

impl Level {
    /// The same level in both directions at every speed.
    pub const fn constant(level: f64) -> Self {
        Self { base: [level; 2], peak: [0.0; 2], velocity: f64::INFINITY, factor: 1.0, local: 0.0 }
    }

    /// Its numbers, for levels of several axes in arrays.
    #[inline(always)]
    pub(crate) fn numbers(&self) -> [f64; 7] {
        let Self { base: [forward, backward], peak: [forward_peak, backward_peak], velocity, factor, local } =
            *self;
        [forward, backward, forward_peak, backward_peak, velocity, factor, local]
    }

    /// The level with these [`numbers`](Self::numbers).
    #[inline(always)]
    pub(crate) fn of_numbers(
        [forward, backward, forward_peak, backward_peak, velocity, factor, local]: [f64; 7],
    ) -> Self {
        Self { base: [forward, backward], peak: [forward_peak, backward_peak], velocity, factor, local }
    }

    /// g in a direction (±1) at a speed ≥ 0.
    #[inline(always)]
    pub fn at(&self, direction: f64, speed: f64) -> f64 {
        let peak = if direction > 0.0 { self.peak[0] } else { self.peak[1] };
        let ratio = speed / self.velocity;
        self.with(direction, peak * decay(ratio * ratio)[0])
    }

    /// g in a direction at speeds far above those of the peak.
    #[inline(always)]
    pub fn without_peak(&self, direction: f64) -> f64 {
        self.with(direction, 0.0)
    }

    /// g at rest in the positive and the negative direction.
    #[inline(always)]
    pub fn at_rest(&self) -> [f64; 2] {
        [self.with(1.0, self.peak[0]), self.with(-1.0, self.peak[1])]
    }

    /// g in a direction with so much of the peak.
    #[inline(always)]
    fn with(&self, direction: f64, peak: f64) -> f64 {
        let base = if direction > 0.0 { self.base[0] } else { self.base[1] };
        let level = (base + peak) * self.factor + self.local;
        if level > 0.0 { level } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_level_is_base_and_fading_peak_times_factor_and_the_place() {
        let level = Level { base: [8.0, 6.0], peak: [4.0, 3.0], velocity: 0.01, factor: 1.5, local: -2.0 };
        let excess = (-0.25_f64).exp();
        assert!((level.at(1.0, 0.005) - ((8.0 + 4.0 * excess) * 1.5 - 2.0)).abs() < 1e-14);
        assert!((level.at(-1.0, 0.005) - ((6.0 + 3.0 * excess) * 1.5 - 2.0)).abs() < 1e-14);
        assert_eq!(level.at_rest(), [16.0, 11.5]);
        assert_eq!([level.at(1.0, 0.0), level.at(-1.0, 0.0)], level.at_rest());
        let deep = Level { local: -20.0, ..level };
        assert_eq!((deep.at(1.0, 0.0), deep.at_rest()), (0.0, [0.0; 2]));
    }
}
