//! What is hidden in a machine: the effects asked for, what they stand on, and what every real machine has beside them.

use super::real::{Acting, Real};
use crate::effect::{EffectId, Machinery, Prior};
use crate::error::Result;
use crate::machine::Machine;

/// Probability that the twin states the friction of the guide already.
const STATED: f64 = 0.5;

/// The friction that a twin states already, as it really is; none in half of the machines, and where the machine's file states its own or
/// can have none. Friction stands on a bristle, which the twin states as well unless that is what is hidden. Where Coulomb friction itself is
/// hidden, the twin states another value.
pub fn stated_friction(
    machine: &Machine,
    machinery: &Machinery,
    planned: &[EffectId],
    prior: &mut Prior,
) -> Vec<Acting> {
    let coulomb = EffectId::CoulombFriction;
    let has_own = machine.description().effect.acting().iter().any(|effect| is_dry(effect.id()));
    if !prior.chance(STATED) || has_own || !coulomb.applies(&machinery.constants) {
        return Vec::new();
    }
    let level = coulomb.draw(machinery, prior);
    let with = Machinery { coulomb: level.first().copied().unwrap_or(0.0), ..machinery.clone() };
    let mut stated = vec![Acting::attendant(coulomb, level)];
    if !planned.contains(&EffectId::Presliding) {
        stated.push(Acting::attendant(EffectId::Presliding, EffectId::Presliding.draw(&with, prior)));
    }
    stated
}

/// Whether an effect is dry friction by itself, not a feature of it.
fn is_dry(effect: EffectId) -> bool {
    EffectId::Presliding.modifies().contains(&effect)
}

/// Draws the parameters of the effects asked for and of what they stand on; then the bristle that dry friction has.
///
/// # Errors
/// Values that the machine's description refuses.
pub fn hidden(
    real: &Real,
    machinery: &Machinery,
    planned: &[EffectId],
    prior: &mut Prior,
) -> Result<Vec<Acting>> {
    let mut order = planned.to_vec();
    // What is modified comes before what modifies it.
    order.sort_by_key(|effect| !effect.modifies().is_empty());
    let mut hidden = Vec::new();
    for effect in order {
        add(effect, true, real, machinery, &mut hidden, prior)?;
    }
    let friction = real.with(&hidden)?.constants().friction;
    let is_rubbing =
        machinery_with(real, machinery, &hidden)?.coulomb > 0.0 || friction.load_coefficient > 0.0;
    if is_rubbing && friction.bristle.is_none() && EffectId::Presliding.applies(&machinery.constants) {
        add(EffectId::Presliding, false, real, machinery, &mut hidden, prior)?;
    }
    Ok(hidden)
}

/// Adds an effect, before it what it modifies where nothing of that is there.
fn add(
    effect: EffectId,
    planned: bool,
    real: &Real,
    machinery: &Machinery,
    hidden: &mut Vec<Acting>,
    prior: &mut Prior,
) -> Result<()> {
    let is_there = |of: EffectId, hidden: &[Acting]| {
        let description = real.machine().description();
        let has = |list: &[Acting]| list.iter().any(|acting| acting.effect == of);
        has(hidden) || has(real.known()) || description.effect.contains(of) || description.guide_has(of)
    };
    if let (Some(&first), false) = (effect.modifies().first(), effect.has_modified(|of| is_there(of, hidden)))
    {
        add(first, false, real, machinery, hidden, prior)?;
    }
    let values = effect.draw(&machinery_with(real, machinery, hidden)?, prior);
    hidden.push(Acting { effect, values, planned });
    Ok(())
}

/// The machinery with the dry friction that is there by now.
fn machinery_with(real: &Real, machinery: &Machinery, hidden: &[Acting]) -> Result<Machinery> {
    let constants = real.with(hidden)?.constants();
    let coulomb = constants.friction.at_rest();
    Ok(Machinery { coulomb, ..machinery.clone() })
}
