//! Whether an effect is significant by the intervals of its numbers as the report states them.

use super::fit::Fit;
use super::found::Found;
use super::free::Freedom;
use super::grounds::Unidentified;
use super::hypothesis::EffectSet;
use super::parameter::NORMAL_975;
use crate::effect::EffectId;

/// Whether the 95 % interval of one of an effect's numbers leaves out the twin's own value.
///
/// An effect whose numbers are all held has no interval to go by, and counts as significant. A number that does nothing on these runs has none either, and tells nothing.
pub(super) fn is_significant(fit: &Fit, effect: EffectId) -> bool {
    let errors = &fit.standard_errors;
    let free = &fit.hypothesis.free;
    let own = |k: &usize| free[*k].effect == effect && free[*k].freedom == Freedom::Cause && !free[*k].held;
    let mut numbers = (0..free.len()).filter(own).filter(|&k| !free[k].neutral.is_nan()).peekable();
    numbers.peek().is_none()
        || numbers
            .any(|k| errors[k] > 0.0 && (fit.values[k] - free[k].neutral).abs() > NORMAL_975 * errors[k])
}

impl Found {
    /// Why no verdict rests on the chosen explanation, with the intervals that the report states.
    pub(super) fn unidentified(&self) -> Option<Unidentified> {
        let chosen = &self.candidates[self.chosen];
        let unidentified = chosen.unidentified().or_else(|| chosen.incomplete());
        unidentified.or_else(|| self.not_significant())
    }

    /// An effect of the chosen explanation that is not significant, and without which no more than a small gap is left: neither its interval nor what it closes proves it. Waves
    /// are left out: sine and cosine far from the zero of position hang on the period, and each is uncertain by itself where both together are not.
    fn not_significant(&self) -> Option<Unidentified> {
        let fit = &self.candidates[self.chosen].fit;
        let leaves_little = |effect: EffectId| {
            let rest: EffectSet = self.effects().iter().copied().filter(|other| *other != effect).collect();
            self.index(&rest).is_some_and(|k| self.left(k) <= self.limits.small_gap.powi(2))
        };
        let mut effects = self.effects().iter().copied();
        let open = effects.find(|&effect| is_open(fit, effect) && leaves_little(effect));
        open.map(|effect| Unidentified::NotSignificant { effect: effect.name() })
    }
}

/// Whether a fit has effects, and none of them is significant.
pub(super) fn none_is_significant(fit: &Fit) -> bool {
    let effects = &fit.hypothesis.effects;
    !effects.is_empty() && effects.iter().all(|&effect| is_open(fit, effect))
}

fn is_open(fit: &Fit, effect: EffectId) -> bool {
    let mut free = fit.hypothesis.free.iter();
    let is_wave = free.any(|free| free.effect == effect && free.name.starts_with("sine"));
    !is_wave && !is_significant(fit, effect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};

    /// A size of 1 with a standard error of 0.5 is significant, and one of 0.52 is not where the twin without it leaves 2.9 × noise; what closes 3.1 × noise is proven by that.
    #[test]
    fn exact_what_neither_interval_nor_gap_proves_is_not_significant() {
        let told = |error: f64, name: &'static str, left: f64| {
            let mut friction = candidate(&[COULOMB], 1.0, 1.0);
            (friction.fit.standard_errors, friction.fit.hypothesis.free[0].name) = (vec![error], name);
            found(vec![candidate(&[], 0.0, left * left), friction], 1).not_significant()
        };
        assert_eq!([told(0.5, "n", 2.9), told(0.52, "n", 3.1), told(0.52, "sine_n", 2.9)], [None; 3]);
        let effect = COULOMB.name();
        assert_eq!(told(0.52, "n", 2.9), Some(Unidentified::NotSignificant { effect }));
    }

    /// Of two effects one is, of one none; what has no effect has none that is not.
    #[test]
    fn exact_none_is_significant_where_every_interval_leaves_it_open() {
        let none = |effects: &[EffectId], errors: &[f64]| {
            let fit = Fit { standard_errors: errors.to_vec(), ..candidate(effects, 1.0, 1.0).fit };
            none_is_significant(&fit)
        };
        let both = [COULOMB, BACKLASH];
        assert!(none(&both, &[0.6, 0.6]) && !none(&both, &[0.6, 0.5]) && !none(&[], &[]));
    }
}
