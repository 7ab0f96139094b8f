//! The prior of explanations: how many effects, which of them, and how far constants are off.

use super::thresholds::SIGNIFICANCE;
use crate::effect::EffectId;
use std::collections::BTreeSet;

/// An effect more must be worth this much log-likelihood, ln 100: a prior of 1 in 100 for each effect.
pub const PRICE_PER_EFFECT: f64 = 4.605;

/// More effects than this are not named at once: friction with its features is four.
pub(super) const MOST_EFFECTS: usize = 6;

/// A tolerance, or half of where machines usually have the logarithm of a number, is so many standard deviations of what it is
/// usually off by, where twins are fitted and where they are judged.
pub(super) const TOLERANCE_SIGMAS: f64 = 2.0;

/// What a set of effects must be worth in log-likelihood, beside a twin that has those `stated`.
pub fn price(effects: &BTreeSet<EffectId>, stated: &BTreeSet<EffectId>) -> f64 {
    // Numbers of what is there are found beyond their tolerance more often than something new comes: of two that predict alike, the
    // change is ten times likelier.
    let of =
        |effect: &EffectId| if stated.contains(effect) { 0.5 * PRICE_PER_EFFECT } else { PRICE_PER_EFFECT };
    effects.iter().map(|effect| of(effect) + effect.rarity()).sum()
}

/// Log-likelihood by which one of all explanations must predict better than a twin that leaves no gap, before it counts as more than the best of many
/// by chance.
///
/// # Model
/// By chance a likelihood ratio on runs that were not fitted exceeds x with a probability of 1/x at most (its expectation is 1), and one of N does with
/// N/x. N is the number of sets of up to [`MOST_EFFECTS`] effects of the catalogue, and N/x is [`SIGNIFICANCE`]: 18.5 for 41 effects.
///
/// # Validity
/// As far as the noise model holds.
///
/// # Source
/// Markov's inequality and Bonferroni's; A. Wald (1945), *Sequential tests of statistical hypotheses*, Ann. Math. Stat. 16:117, has the first for likelihood ratios.
pub(super) fn overwhelming() -> f64 {
    let catalogue = EffectId::ALL.len();
    let next = |sets: &mut f64, size: usize| {
        *sets *= (catalogue + 1 - size) as f64 / size as f64;
        Some(*sets)
    };
    let sets: f64 = (1..=MOST_EFFECTS.min(catalogue)).scan(1.0, next).sum();
    (sets / SIGNIFICANCE).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of n effects there are n sets of one and n(n − 1)/2 of two; of 41 up to six there are 5 358 577.
    #[test]
    fn exact_the_best_of_all_sets_by_chance() {
        let count = EffectId::ALL.len();
        let choose = |size: usize| (0..size).fold(1, |product, k| product * (count - k) / (k + 1));
        let sets: usize = (1..=6).map(choose).sum();
        assert!((overwhelming() - (20.0 * sets as f64).ln()).abs() < 1e-9);
        assert!(count != 41 || sets == 5_358_577);
    }
}
