//! How large an effect may be on a machine: what blind trials draw from, and what they do otherwise than a law.

use super::Constants;
use rand::RngExt;
use rand::rngs::StdRng;
use std::f64::consts::TAU;
use std::fmt;

/// Deviations of constants with a tolerance begin at so many times what is absorbed: nearer, a deviation is no cause.
pub const BEYOND: f64 = 1.5;
/// Coulomb part of laws that hold Coulomb friction as a special case, as shares of the largest motor force.
const COULOMB_PART: (f64, f64) = (0.02, 0.08);
/// Periods along the axis as shares of the largest stroke: several fit into it.
const PERIODS: (f64, f64) = (0.08, 0.25);

/// What the nominal machine does on the runs of a case: what a small or large effect is measured by.
#[derive(Debug, Clone)]
pub struct Scale {
    /// Constants of the machine as it really is, hidden effect aside.
    pub constants: Constants,
    /// Largest motor force or torque in N or N·m.
    pub force: f64,
    /// Largest commanded voltage in V.
    pub voltage_v: f64,
    /// Largest speed of the reference in m/s or rad/s.
    pub speed: f64,
    /// Largest stroke in m or rad, signed.
    pub stroke: f64,
}

/// How far a constant may be off, as a fraction, before no combination of constants inside their tolerances stands for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Absorbed {
    /// Moving mass or inertia.
    pub mass: f64,
    /// Viscous coefficient.
    pub viscous: f64,
    /// Force or torque constant.
    pub force_constant: f64,
    /// Resistance of the winding.
    pub resistance: f64,
    /// Inductance of the winding.
    pub inductance: f64,
}

/// What is drawn whatever the effect.
#[derive(Debug, Clone, Copy)]
pub struct Drawn {
    /// +1 or −1.
    pub sign: f64,
    /// A period along the axis in m or rad.
    pub period: f64,
    /// Phases of two harmonics in rad.
    pub phase: [f64; 2],
    /// Second harmonic as a share of the first.
    pub second: f64,
    /// Coulomb friction in N or N·m.
    pub coulomb: f64,
    /// Share by which a direction has more Coulomb friction than the mean of both.
    pub lean: f64,
    /// Viscous coefficient in N·s/m or N·m·s/rad: the stated one, or a plausible one.
    pub viscous: f64,
    /// Numbers from 0 to 1 for what else a law leaves open.
    pub share: [f64; 3],
}

impl Drawn {
    /// Draws for a machine of this scale.
    pub fn of(scale: &Scale, random: &mut StdRng) -> Self {
        let stated = scale.constants.viscous;
        Self {
            sign: if random.random_range(0.0..1.0) < 0.5 { -1.0 } else { 1.0 },
            period: scale.stroke.abs() * random.random_range(PERIODS.0..PERIODS.1),
            phase: [random.random_range(0.0..TAU), random.random_range(0.0..TAU)],
            second: random.random_range(0.0..0.4),
            coulomb: scale.force * random.random_range(COULOMB_PART.0..COULOMB_PART.1),
            lean: random.random_range(-0.3..0.3),
            viscous: if stated > 0.0 { stated } else { 0.1 * scale.force / scale.speed },
            share: [0, 1, 2].map(|_| random.random_range(0.0..1.0)),
        }
    }

    /// Two harmonics of amplitude s: period, then sine and cosine of each.
    pub fn wave(self, s: f64) -> Vec<f64> {
        let [first, second] = self.phase.map(f64::sin_cos);
        let t = s * self.second;
        vec![self.period, s * first.1, s * first.0, t * second.1, t * second.0]
    }
}

/// The parameters of a law, one number of them still open: its size.
pub struct Sizes {
    /// Least and largest size.
    pub range: (f64, f64),
    /// Of a law that holds another one as a special case: the parameters at which it is that one, from which its size counts.
    pub reduced: Option<Vec<f64>>,
    values: Box<dyn Fn(f64) -> Vec<f64> + Send + Sync>,
}

impl Sizes {
    /// Parameters in the law's order at a size from one to another.
    pub fn new(range: (f64, f64), values: impl Fn(f64) -> Vec<f64> + Send + Sync + 'static) -> Self {
        Self { range, reduced: None, values: Box::new(values) }
    }

    /// The one parameter of a law at a size from one to another.
    pub fn one(range: (f64, f64), value: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Self::new(range, move |s| vec![value(s)])
    }

    /// The sizes, counted from where the law is another one.
    #[must_use]
    pub fn from_reduced(self, reduced: Vec<f64>) -> Self {
        Self { reduced: Some(reduced), ..self }
    }

    /// The parameters at a size, in the law's order.
    pub fn values(&self, size: f64) -> Vec<f64> {
        (self.values)(size)
    }
}

impl fmt::Debug for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sizes")
            .field("range", &self.range)
            .field("reduced", &self.reduced)
            .finish_non_exhaustive()
    }
}

/// What a machine of a blind trial does otherwise than the law, which the diagnosis would meet again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unlike {
    /// Nothing: the machine has the effect by its law.
    Nothing,
    /// Dry friction by bristles of another kind.
    Bristles,
    /// More harmonics of a force along the axis, from period and amplitude of the first.
    ForceHarmonics {
        /// Period in m or rad.
        period: f64,
        /// Amplitude of the first harmonic in N or N·m.
        first: f64,
    },
    /// More harmonics of the motor's relative force along the axis, from period and amplitude of the first.
    RippleHarmonics {
        /// Period in m or rad.
        period: f64,
        /// Amplitude of the first harmonic.
        first: f64,
    },
}

/// What a constant with a tolerance must be off by at least, as a fraction.
pub(super) fn least_beyond(absorbed: f64) -> f64 {
    (BEYOND * absorbed).max(1e-4)
}

/// A number between two, on a logarithmic scale.
pub(super) fn between(from: f64, to: f64, share: f64) -> f64 {
    from * (to / from).powf(share)
}
