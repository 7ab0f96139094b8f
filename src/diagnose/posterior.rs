//! Posterior probabilities of explanations.

use super::candidate::Candidate;
use super::evidence::{Score, bootstrap};
use super::found::{DRAWS, Found};
use super::prior::price;

/// Posterior probabilities of the candidates: likelihood times prior, averaged over a bootstrap of the
/// held-out blocks, so that evidence resting on a few blocks counts less. One that has details beside the chosen one counts as that: in both the
/// chosen effects act, and the details are not told.
pub(super) fn posterior(found: &Found, before: &Score) -> Vec<f64> {
    let candidates = &found.candidates;
    let best = found.reference();
    let is_borne_out = |index: usize| candidates[index].effects().is_disjoint(&found.not_borne_out);
    let identified = found.identified();
    let stands = |index| {
        !found.is_refinement(index, before)
            && !candidates[index].has_noise_line()
            && is_borne_out(index)
            && (found.is_resolved(index) || found.likelihood(index) > identified)
    };
    let stands: Vec<bool> = (0..candidates.len()).map(stands).collect();
    let blocks: Vec<Vec<f64>> = candidates.iter().map(|c| c.log_likelihoods(best)).collect();
    let mut sum = vec![0.0; candidates.len()];
    for weights in bootstrap(best.blocks(), DRAWS) {
        let likelihood = |k: usize| blocks[k].iter().zip(&weights).map(|(l, w)| l * w).sum::<f64>();
        let merit = |(k, candidate): (usize, &Candidate)| {
            if !stands[k] {
                return f64::NEG_INFINITY;
            }
            likelihood(k) - price(candidate.effects(), &found.stated) - candidate.fit.strain()
        };
        let merits: Vec<f64> = candidates.iter().enumerate().map(merit).collect();
        let most = merits.iter().copied().fold(f64::MIN, f64::max);
        let total: f64 = merits.iter().map(|m| (m - most).exp()).sum();
        for (sum, merit) in sum.iter_mut().zip(&merits) {
            *sum += (merit - most).exp() / total;
        }
    }
    let mut posterior: Vec<f64> = sum.into_iter().map(|s| s / DRAWS as f64).collect();
    for k in (0..candidates.len()).filter(|&k| found.is_detail(k, before)) {
        posterior[found.chosen] += std::mem::take(&mut posterior[k]);
    }
    posterior
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate, found};
    use crate::diagnose::free::tests::number;
    use crate::diagnose::free::{Free, Freedom};
    use crate::diagnose::hypothesis::EffectSet;
    use crate::effect::EffectId;

    /// An explanation with a number at its bound has no share beside one that predicts as well with all numbers inside, and has one where it predicts
    /// better than all of these.
    #[test]
    fn exact_what_is_not_identified_gives_way_to_what_predicts_as_well() {
        let shares = |left: f64| {
            let all = vec![
                candidate(&[], 0.0, 1e4),
                candidate(&[COULOMB], 1.0, 1.2),
                candidate(&[BACKLASH], 10.0, left),
                candidate(&[COULOMB, BACKLASH], 1.0, 1.1),
            ];
            posterior(&found(all, 1), &Score::even(1e4))
        };
        // Play beside the friction that leaves no more than noise is a detail: it counts for the friction.
        assert_eq!(shares(1.1)[2..], [0.0; 2]);
        assert!(shares(1.1)[1] > 0.99 && shares(1.05)[2] > 0.99);
    }

    /// A twin that states a cogging has its pitch among the calibrated constants of every explanation; the probabilities are those without it.
    #[test]
    fn exact_a_stated_pitch_is_no_line_of_the_noise() {
        let shares = |states_pitch: bool| {
            let mut all = vec![
                candidate(&[], 0.0, 4.0),
                candidate(&[COULOMB], 1.0, 3.0),
                candidate(&[BACKLASH], 1.0, 3.01),
            ];
            let pitch = Free { freedom: Freedom::Calibration, ..number(EffectId::Cogging, "period_m") };
            for candidate in all.iter_mut().filter(|_| states_pitch) {
                candidate.fit.hypothesis.free.push(pitch.clone());
                candidate.fit.values.push(pitch.neutral);
            }
            posterior(&found(all, 1), &Score::even(1e4))
        };
        assert_eq!(shares(true), shares(false));
        assert!((shares(true).iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    /// Of two that predict alike, a change of what the twin has is likelier than something new.
    #[test]
    fn exact_change_comes_before_novelty() {
        let all = || {
            let one = |effect| candidate(&[effect], 1.0, 2.0);
            vec![candidate(&[], 0.0, 1e4), one(BACKLASH), one(COULOMB)]
        };
        let mut found = found(all(), 1);
        found.stated = EffectSet::from([COULOMB]);
        let before = Score::even(1e4);
        let posterior = posterior(&found, &before);
        assert!((posterior[2] / posterior[1] - 10.0).abs() < 0.01, "{posterior:?}");
        assert_eq!(found.best_of(&[1, 2]), Some(2));
    }

    /// A twin that leaves no gap has the probability, and what predicts a little better is a refinement.
    #[test]
    fn exact_what_leaves_no_gap_is_most_probable() {
        let before = Score::even(1e4);
        let all = vec![
            candidate(&[], 0.0, 1.0),
            candidate(&[COULOMB], 1.0, 0.99),
            candidate(&[BACKLASH], 1.0, 1.0),
        ];
        let mut found = found(all, 1);
        found.posterior = posterior(&found, &before);
        assert!(found.posterior[1] > 0.9);
        found.settle(&before);
        assert!(found.posterior[0] > 0.9 && found.posterior[1] == 0.0, "{:?}", found.posterior);
        assert_eq!([1, 2].map(|k| found.is_refinement(k, &before)), [true, false]);
    }
}
