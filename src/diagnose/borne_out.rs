//! Effects that the training runs do not bear out: their size scatters from run to run as if they were not there.

use super::amplitude::amplitudes;
use super::evidence::Score;
use super::experiment::Experiment;
use super::found::Found;
use super::free::Free;
use super::hypothesis::EffectSet;
use super::posterior::posterior;
use super::selection::Search;
use super::significance::is_significant;
use super::uncertainty::Uncertainty;
use super::wald::{amplitude_shows, independent_frequencies};
use crate::effect::EffectId;
use crate::error::Result;

impl Search<'_> {
    /// Takes out of the chosen explanation what the training runs do not bear out, where the rest leaves little.
    ///
    /// # Model
    /// Residuals of one fit do not tell what a law that is only nearly right puts into a small effect: it takes up what other laws leave,
    /// and another share of it in each run. An effect is borne out where an interval of its numbers, as the report states it
    /// ([`Uncertainty`]), leaves out the twin's own value; a wave, where an amplitude is beyond what the largest of all frequencies is by chance. An effect without which
    /// more is left than may stay open is proven by what it closes, and stays. So is one without which unseen runs are not predicted to their noise
    /// any more: an explanation that leaves noise leaves nothing of other laws to be taken up. Where calibration alone leaves noise, all of them may go.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn keep_what_is_borne_out(&self, found: &mut Found, before: &Score) -> Result<()> {
        let samples = self.training.runs().iter().map(Experiment::samples).sum();
        let frequencies = independent_frequencies(samples);
        while !found.effects().is_empty() {
            let fit = &found.candidates[found.chosen].fit;
            if !found.uncertainties.contains_key(&found.chosen) {
                let uncertainty = Uncertainty::of(self.machine, fit, self.training, &self.floors.common)?;
                found.uncertainties.insert(found.chosen, uncertainty);
            }
            let uncertainty = &found.uncertainties[&found.chosen];
            let is_open = |effect: &EffectId| !is_borne_out(uncertainty, *effect, frequencies);
            let open: Vec<EffectId> = found.effects().iter().copied().filter(is_open).collect();
            // Two may stand for one another, so that neither is superfluous beside the other: all of them go, or one.
            let one = open.iter().map(|effect| self.without(found.effects(), [*effect]));
            let sets = one.chain([self.without(found.effects(), open.iter().copied())]);
            let may_be =
                |set: &EffectSet| set != found.effects() && (!set.is_empty() || found.predicts_to_noise(0));
            let smaller: Vec<EffectSet> = sets.filter(may_be).collect();
            let Some(index) = self.sufficient(found, &smaller, before)? else { break };
            let rest = found.candidates[index].effects();
            found.not_borne_out.extend(found.candidates[found.chosen].effects().difference(rest).copied());
            found.chosen = index;
            found.posterior = posterior(found, before);
        }
        Ok(())
    }

    /// The best of these sets of effects that leaves little.
    fn sufficient(&self, found: &mut Found, sets: &[EffectSet], before: &Score) -> Result<Option<usize>> {
        let indices = self.explored(found, sets)?;
        let measured = self.floors.common.is_measured();
        let sufficient: Vec<usize> =
            indices.into_iter().filter(|&k| found.suffices(k, before, measured)).collect();
        Ok(found.best_of(&sufficient))
    }
}

impl Found {
    /// Whether a candidate leaves so little that the further effects of the chosen explanation may be taken out.
    fn suffices(&self, index: usize, before: &Score, noise_is_measured: bool) -> bool {
        if index == 0 {
            self.predicts_to_noise(0)
        } else if self.predicts_to_noise(self.chosen) {
            self.leaves_nothing_to_name(index, before, noise_is_measured)
        } else {
            self.is_sufficient(index, before, noise_is_measured)
        }
    }
}

/// Whether the interval of one of an effect's numbers leaves out the twin's own value; of waves, whether one amplitude is beyond chance, among so many
/// `frequencies` where their period was searched: the first wave of half a pitch cannot be told from the second one of the whole pitch, and its own second one is certain
/// nevertheless.
fn is_borne_out(Uncertainty { fit, folds }: &Uncertainty, effect: EffectId, frequencies: f64) -> bool {
    let waves = amplitudes(fit, folds, effect);
    if !waves.is_empty() {
        let is_searched = |free: &Free| free.effect == effect && free.is_line() && free.neutral.is_nan();
        let trials = if fit.hypothesis.free.iter().any(is_searched) { frequencies } else { 1.0 };
        return waves.values().any(|amplitude| amplitude_shows(amplitude, trials));
    }
    is_significant(fit, effect)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::candidate::Candidate;
    use crate::diagnose::folds::Folds;
    use crate::diagnose::found::tests::{COULOMB, candidate, found};
    use nalgebra::{DMatrix, DVector};

    /// A size of 1 ± 0.1 is borne out by runs that agree on it, and not by runs of which each says another one.
    #[test]
    fn exact_runs_that_disagree_do_not_bear_out_an_effect() {
        let is_borne_out = |values: &[f64]| {
            let mut fit = candidate(&[COULOMB], 1.0, 1.0).fit;
            let fits = values.iter().map(|value| candidate(&[COULOMB], *value, 1.0).fit).collect();
            let folds = Folds { fits };
            fit.standard_errors = folds.widened(&fit);
            is_borne_out(&Uncertainty { fit, folds }, COULOMB, 1e4)
        };
        assert!(is_borne_out(&[0.9, 1.0, 1.1]) && !is_borne_out(&[0.2, 1.0, 1.8]));
        // Two runs have no scatter to speak of: the interval of the fit holds.
        assert!(is_borne_out(&[0.2, 1.8]));
    }

    /// Of 10⁸, what leaves 20² is little. Beside an explanation that leaves noise it is not enough, and 2² is; beside one that leaves 15² it is.
    #[test]
    fn exact_what_takes_the_rest_to_its_noise_stays() {
        let may_be_beside = |training_gap: f64, own: f64, rest: f64| {
            let whole = candidate(&[COULOMB, EffectId::Backlash], 1.0, own * own);
            let all = vec![
                candidate(&[], 0.0, 1e8),
                candidate(&[COULOMB], 1.0, rest * rest),
                Candidate { training_gap, ..whole },
            ];
            found(all, 2).suffices(1, &Score::even(1e8), true)
        };
        let may_be = |own: f64, rest: f64| may_be_beside(own, own, rest);
        assert!(!may_be(1.0, 20.0) && may_be(1.0, 2.0) && may_be(15.0, 20.0));
        // However little the training runs agree with it.
        assert!(!may_be_beside(5.0, 1.0, 20.0));
    }

    /// All effects may go where calibration alone leaves noise.
    #[test]
    fn exact_calibration_that_leaves_noise_is_enough() {
        let is_enough = |left: f64| {
            let all = vec![candidate(&[], 0.0, left * left), candidate(&[COULOMB], 1.0, 1.0)];
            found(all, 1).suffices(0, &Score::even(1e8), true)
        };
        assert!(is_enough(1.2) && !is_enough(1.3));
    }

    /// A wave whose first harmonic is uncertain is borne out by its second one.
    #[test]
    fn exact_one_certain_amplitude_bears_out_a_wave() {
        let effect = EffectId::Cogging;
        let wave = |errors: [f64; 2]| {
            let mut fit = candidate(&[effect], 1.0, 1.0).fit;
            let number = fit.hypothesis.free[0].clone();
            let names = ["sine_n", "cosine_n", "sine_2_n", "cosine_2_n"];
            fit.hypothesis.free = names.map(|name| Free { name, ..number.clone() }).into();
            fit.values = vec![1.0, 0.0, 1.0, 0.0];
            let [first, second] = errors.map(|error: f64| error * error);
            fit.covariance = DMatrix::from_diagonal(&DVector::from_vec(vec![first, first, second, second]));
            is_borne_out(&Uncertainty { fit, folds: Folds { fits: vec![] } }, effect, 1e4)
        };
        assert!(wave([0.1, 2.0]) && wave([2.0, 0.1]) && !wave([2.0, 2.0]));
    }

    /// An amplitude of 3.3 standard errors is significant where the period is known, and not where it is the largest of 10⁴ frequencies; one of ten standard errors is.
    #[test]
    fn exact_a_wave_whose_period_was_searched_has_to_beat_all_of_them() {
        let effect = EffectId::Cogging;
        let wave = |error: f64, period: f64| {
            let mut fit = candidate(&[effect], 1.0, 1.0).fit;
            let number = fit.hypothesis.free[0].clone();
            let named = |name, neutral| Free { name, neutral, ..number.clone() };
            fit.hypothesis.free =
                vec![named("period_m", period), named("sine_n", 0.0), named("cosine_n", 0.0)];
            fit.values = vec![0.03, 1.0, 0.0];
            let variance = error * error;
            fit.covariance = DMatrix::from_diagonal(&DVector::from_vec(vec![1e-12, variance, variance]));
            is_borne_out(&Uncertainty { fit, folds: Folds { fits: vec![] } }, effect, 1e4)
        };
        assert!(wave(0.3, 0.03) && !wave(0.3, f64::NAN) && wave(0.1, f64::NAN));
    }
}
