//! Machines with waves over place, of which replays tell the responses.

use crate::effect::{Cogging, Effect, EncoderPeriodicError, ForceRipple, ScrewError};
use crate::machine::Machine;

/// One wave over place x: s·sin(2πx/p) + c·cos(2πx/p).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// p in m or rad.
    pub period: f64,
    /// s, in what the law has it in.
    pub sine: f64,
    /// c, alike.
    pub cosine: f64,
}

/// Amplitude of what acts while its response is taken, as a share of the largest that is usual: small against any friction, large against rounding.
pub const PROBE: f64 = 1e-5;

/// A law of a wave: what repeats.
pub type WaveLaw = fn(Wave) -> Effect;

impl Wave {
    /// Sine and cosine of one period with this amplitude.
    pub fn both(period: f64, amplitude: f64) -> [Self; 2] {
        [Self { period, sine: amplitude, cosine: 0.0 }, Self { period, sine: 0.0, cosine: amplitude }]
    }
}

/// The machine with each of these waves of a law beside what it has.
pub fn machines(machine: &Machine, law: WaveLaw, waves: impl Iterator<Item = Wave>) -> Vec<Machine> {
    waves.map(|wave| machine.clone().with_probe(law(wave))).collect()
}

/// A force that repeats over place, in N or N·m.
pub fn force(Wave { period, sine, cosine }: Wave) -> Effect {
    Effect::Cogging(Cogging::single(period, sine, cosine))
}

/// A share of the motor's force that repeats over place.
pub fn ripple(Wave { period, sine, cosine }: Wave) -> Effect {
    Effect::ForceRipple(ForceRipple::single(period, sine, cosine))
}

/// What an encoder reads wrong over place, in m or rad.
pub fn reading(Wave { period, sine, cosine }: Wave) -> Effect {
    Effect::EncoderPeriodicError(EncoderPeriodicError { period_m: period, sine_m: sine, cosine_m: cosine })
}

/// What a screw moves wrong over place, in m or rad.
pub fn lead(Wave { period, sine, cosine }: Wave) -> Effect {
    Effect::ScrewError(ScrewError { period_m: period, sine_m: sine, cosine_m: cosine, flank: 0.0 })
}
