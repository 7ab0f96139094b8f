//! Whether an effect is significant by the intervals of its numbers as the report states them.

use super::fit::Fit;
use super::found::Found;
use super::free::{Free, Freedom};
use super::grounds::Unidentified;
use super::hypothesis::EffectSet;
use super::parameter::NORMAL_975;
use crate::effect::{Cogging, EffectId, Site};
use crate::machine::Machine;

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
    /// Whether calibration alone leaves noise, and none of the effects of the chosen explanation is significant.
    pub(super) fn has_nothing_to_name(&self) -> bool {
        let fit = &self.candidates[self.chosen].fit;
        let none_is_significant = self.effects().iter().all(|&effect| lacks_significance(fit, effect));
        self.chosen != 0 && none_is_significant && self.predicts_to_noise(0)
    }

    /// Why no verdict rests on the chosen explanation, with the intervals that the report states.
    pub(super) fn unidentified(&self, machine: &Machine) -> Option<Unidentified> {
        let of_motor = Cogging::longest_pitch(&machine.constants(), machine.motion());
        let chosen = &self.candidates[self.chosen];
        let unidentified = chosen.unidentified().or_else(|| chosen.incomplete());
        unidentified
            .or_else(|| self.not_significant())
            .or_else(|| open_period(&self.candidates[self.chosen].fit, of_motor))
    }

    /// An effect of the chosen explanation that is not significant, and without which no more than a small gap is left: neither its interval nor what it closes proves it. Waves
    /// are left out: sine and cosine far from the zero of position hang on the period, and each is uncertain by itself where both together are not.
    fn not_significant(&self) -> Option<Unidentified> {
        let fit = &self.candidates[self.chosen].fit;
        // A set that was not fitted, or roughly alone, may leave less than is known: it forbids nothing.
        let leaves_little = |effect: EffectId| {
            let rest: EffectSet = self.effects().iter().copied().filter(|other| *other != effect).collect();
            self.index(&rest).is_some_and(|k| self.left(k) <= self.limits.small_gap.powi(2))
        };
        let mut effects = self.effects().iter().copied();
        let open = effects.find(|&effect| lacks_significance(fit, effect) && leaves_little(effect));
        open.map(|effect| Unidentified::NotSignificant { effect: effect.name() })
    }
}

/// A wave of the motor's force that is longer than the pitch of any motor (`of_motor`), and whose period is not told: its 95 % interval reaches beyond the longest that a fit may look
/// for, and is wider than an octave, within which the second harmonic of one period is the first of another. With few periods on the travel, and no period for certain, its harmonics are a curve as any other: what changes along the travel without repeating is
/// fitted as well.
fn open_period(fit: &Fit, of_motor: f64) -> Option<Unidentified> {
    let numbers = fit.hypothesis.free.iter().zip(fit.values.iter().zip(&fit.standard_errors));
    let is_searched = |free: &Free| {
        free.freedom == Freedom::Cause && free.is_period() && free.neutral.is_nan() && !free.held
    };
    let is_force = |free: &Free| free.effect.site() == Site::Motor;
    let mut searched = numbers.filter(|(free, _)| is_searched(free) && is_force(free));
    searched.find_map(|(free, (value, error))| {
        let (down_to, up_to) = (value - NORMAL_975 * error, value + NORMAL_975 * error);
        let longest = free.range.1;
        let found = Unidentified::PeriodOpen { effect: free.effect.name(), up_to, of_motor, unit: free.unit };
        (*value > of_motor && up_to > longest && up_to > 2.0 * down_to).then_some(found)
    })
}

/// Whether an effect that is no wave is not significant.
fn lacks_significance(fit: &Fit, effect: EffectId) -> bool {
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

    /// A pitch of 0.7 ± 0.3 m (standard error) is told where fits look up to 1.35 m, and 0.7 ± 0.34 m is not, unless motors have such pitches; a pitch that the twin states is, and so is
    /// one of 1.34 ± 0.02 m. The period of a reading's error is none of a force.
    #[test]
    fn exact_a_period_whose_interval_goes_beyond_what_is_looked_for_is_open() {
        let told = |effect: EffectId, [value, error, neutral, of_motor]: [f64; 4]| {
            let mut fit = candidate(&[effect], value, 1.0).fit;
            fit.standard_errors = vec![error];
            let number = fit.hypothesis.free[0].clone();
            fit.hypothesis.free[0] = Free { name: "period_m", neutral, range: (0.0, 1.35), ..number };
            open_period(&fit, of_motor).is_none()
        };
        let searched = f64::NAN;
        let pitches = [
            [0.7, 0.3, searched, 0.06],
            [0.7, 0.34, searched, 0.06],
            [0.7, 0.34, searched, 0.8],
            [0.7, 0.34, 0.7, 0.06],
            [1.34, 0.02, searched, 0.06],
        ];
        assert_eq!(pitches.map(|of| told(EffectId::Cogging, of)), [true, false, true, true, true]);
        assert!(told(EffectId::ScrewError, pitches[1]));
    }

    /// Of two effects none is significant, or one is. Where calibration leaves 1.3 × noise something is left to explain.
    #[test]
    fn exact_nothing_is_named_where_calibration_leaves_noise_and_no_effect_is_significant() {
        let is_so = |errors: [f64; 2], left: f64| {
            let mut both = candidate(&[COULOMB, BACKLASH], 1.0, 1.0);
            both.fit.standard_errors = errors.to_vec();
            let all = vec![candidate(&[], 0.0, left * left), both];
            [0, 1].map(|chosen| found(all.clone(), chosen).has_nothing_to_name())
        };
        assert_eq!(is_so([0.6, 0.6], 1.2), [false, true]);
        assert_eq!([is_so([0.6, 0.5], 1.2), is_so([0.6, 0.6], 1.3)], [[false; 2]; 2]);
    }
}
