//! Effects of any size: one number from barely there to large, everything else drawn.

use super::nominal;
use crate::effect::{Absorbed, Drawn, EffectId, Scale, Sizes};
use crate::error::Result;
use crate::machine::{Machine, Tolerance};
use crate::recording::Signal;
use rand::rngs::StdRng;

/// An effect with a size that is still open.
///
/// # Model
/// What the sizes are, the effect's law says: [`Law::sizes`](crate::effect::Law::sizes). A feature of friction comes with the friction
/// that it modifies and is measured by itself: its size is what it does beyond [`Family::reduced`].
pub struct Family {
    /// The effect.
    pub effect: EffectId,
    /// Least and largest size.
    pub range: (f64, f64),
    /// The effects that it modifies.
    pub base: Vec<(EffectId, Vec<f64>)>,
    /// What is there at size zero beside them.
    pub reduced: Vec<(EffectId, Vec<f64>)>,
    sizes: Sizes,
}

impl Family {
    /// Draws everything but the size.
    pub fn draw(effect: EffectId, scale: &Scale, absorbed: &Absorbed, random: &mut StdRng) -> Self {
        let drawn = Drawn::of(scale, random);
        let sizes = effect.sizes(scale, absorbed, drawn);
        let mut base = Vec::new();
        if effect.modifies().contains(&EffectId::CoulombFriction) {
            base.push((EffectId::CoulombFriction, vec![drawn.coulomb]));
        }
        if effect.modifies().contains(&EffectId::ViscousFriction) && scale.constants.viscous == 0.0 {
            base.push((EffectId::ViscousFriction, vec![drawn.viscous]));
        }
        if effect.follows() {
            followed(effect, scale, absorbed, random, &mut base);
        }
        let reduced = sizes.reduced.iter().map(|values| (effect, values.clone())).collect();
        Self { effect, range: sizes.range, base, reduced, sizes }
    }

    /// The family on the friction that is there already, where that is what it modifies.
    #[must_use]
    pub fn beside(mut self, others: &[(EffectId, Vec<f64>)]) -> Self {
        for (effect, values) in &mut self.base {
            if let Some((_, there)) = others.iter().find(|(other, _)| other == effect) {
                values.clone_from(there);
            }
        }
        self
    }

    /// The parameters at a size, in the law's order.
    pub fn values(&self, size: f64) -> Vec<f64> {
        self.sizes.values(size)
    }
}

/// Effects that one follows which are not there yet, plain to see, those that they follow first.
fn followed(
    effect: EffectId,
    scale: &Scale,
    absorbed: &Absorbed,
    random: &mut StdRng,
    base: &mut Vec<(EffectId, Vec<f64>)>,
) {
    for &modified in effect.modifies() {
        if modified.follows() {
            followed(modified, scale, absorbed, random, base);
        }
        let sizes = modified.sizes(scale, absorbed, Drawn::of(scale, random));
        base.push((modified, sizes.values(PLAIN * sizes.range.1)));
    }
}

/// Size of what another effect follows, as a share of the largest one.
const PLAIN: f64 = 0.2;

/// What the tolerances absorb on the logged signals.
///
/// # Model
/// Closed loop, mass, drag and force constant act as ratios to one another: a force constant off by 4 % is a mass off by
/// 3 % and a force constant off by 1 %, with the drag following. The voltage-to-force chain adds the resistance where no
/// current is logged that would tell it apart.
pub fn absorbed(tolerance: &Tolerance, logged: &[Signal]) -> Absorbed {
    let ratio = tolerance.mass.min(tolerance.viscous);
    let unseen = if logged.contains(&Signal::Current) { 0.0 } else { tolerance.resistance };
    Absorbed {
        mass: tolerance.mass + tolerance.force_constant + unseen,
        viscous: tolerance.viscous + tolerance.mass + tolerance.force_constant + unseen,
        force_constant: tolerance.force_constant + ratio + unseen,
        resistance: tolerance.resistance + if unseen > 0.0 { tolerance.force_constant + ratio } else { 0.0 },
        inductance: tolerance.inductance + unseen,
    }
}

/// A machine with effects in it, each by its parameters in the law's order.
///
/// # Errors
/// Parameters that the description refuses, or effects that cannot stand beside each other.
pub fn with_effects(machine: &Machine, effects: &[(EffectId, Vec<f64>)]) -> Result<Machine> {
    let mut settings: Vec<(String, toml::Value)> = Vec::new();
    for (effect, values) in effects {
        for (parameter, &value) in effect.parameters().iter().zip(values) {
            let path = format!("effect.{}.{}", effect.name(), parameter.key(machine.motion()));
            // A payload comes on top of what the mass is off by.
            let (path, value) =
                if *effect == EffectId::Payload { nominal::payload(machine, value) } else { (path, value) };
            settings.push((path, toml::Value::Float(value)));
        }
    }
    machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), value.clone())))
}
