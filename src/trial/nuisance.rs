//! Small effects that a machine has beside those asked for, below what must be named.

use super::gauge::Gauge;
use super::real::{Acting, Real};
use crate::effect::{EffectId, Machinery, Prior};

/// Share of machines with nuisances.
const SHARE: f64 = 1.0 / 3.0;
/// What each makes by itself, RMS in standard deviations of the noise.
const SIZES: (f64, f64) = (0.3, 3.0);
/// A small force along the travel, and a small offset: of the amplifier, or, where that does not exist, a force.
const KINDS: [&[EffectId]; 2] = [&[EffectId::Cogging], &[EffectId::AmplifierOffset, EffectId::ConstantForce]];

/// The nuisances of a machine: in one of three, small cogging and a small offset, as far as nothing of the kind is hidden already.
///
/// Their pitches and phases are drawn as those of others, their sizes so that each makes 0.3 to 3 standard deviations by itself, and never
/// more than was drawn.
pub fn nuisances(
    gauge: &Gauge,
    real: &Real,
    machinery: &Machinery,
    hidden: &[Acting],
    prior: &mut Prior,
) -> Vec<Acting> {
    if !prior.chance(SHARE) {
        return Vec::new();
    }
    let one = |kind: &&[EffectId]| {
        let is_like = |acting: &Acting| {
            kind.iter().any(|e| *e == acting.effect || acting.effect.modifies().contains(e))
        };
        let effect = kind.iter().copied().find(|effect| effect.applies(&machinery.constants))?;
        let values = effect.draw(machinery, prior);
        let wanted = prior.log_uniform(SIZES.0, SIZES.1);
        if hidden.iter().chain(real.known()).any(is_like) {
            return None;
        }
        let own = Acting::attendant(effect, values);
        let with = |acting: &Acting| [hidden, std::slice::from_ref(acting)].concat();
        let size = gauge.size(&gauge.change(&real.with(&with(&own)).ok()?)?);
        let share = (wanted / size).min(1.0);
        let absent = real.absent(effect);
        let scaled = |(value, absent): (&f64, &f64)| {
            if absent.is_nan() { *value } else { absent + share * (value - absent) }
        };
        let values = own.values.iter().zip(&absent).map(scaled).collect();
        Some(Acting::attendant(effect, values))
    };
    KINDS.iter().filter_map(one).collect()
}
