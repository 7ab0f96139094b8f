//! Machines with waves over place, of which replays tell the responses.

use super::hypothesis::with_effect;
use crate::effect::EffectId;
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

impl Wave {
    /// Sine and cosine of one period with this amplitude.
    pub fn both(period: f64, amplitude: f64) -> [Self; 2] {
        [Self { period, sine: amplitude, cosine: 0.0 }, Self { period, sine: 0.0, cosine: amplitude }]
    }
}

/// The machine with each of these waves of a law of period, sine and cosine, whose other numbers are zero (a second harmonic, a flank); none where
/// its description refuses one.
pub fn machines(machine: &Machine, law: EffectId, waves: impl Iterator<Item = Wave>) -> Option<Vec<Machine>> {
    let with = |wave: Wave| with_effect(machine, law, &[wave.period, wave.sine, wave.cosine, 0.0, 0.0]).ok();
    waves.map(with).collect()
}

/// The first of some laws that a machine does not have.
pub fn free(machine: &Machine, laws: &[EffectId]) -> Option<EffectId> {
    laws.iter().copied().find(|law| !machine.description().effect.contains(*law))
}
