//! A hypothesis once it is fitted and scored.

use super::cut::contradiction::Contradiction;
use super::evidence::Score;
use super::fit::Fit;
use super::free::{Free, Freedom};
use super::grounds::Unidentified;
use super::hypothesis::EffectSet;
use super::merged_waves::merged;
use super::predictive::Predictive;
use super::prior::MOST_EFFECTS;
use super::thresholds::{ADEQUATE_GAP, LARGELY};
use crate::effect::EffectId;
use crate::recording::Signal;

/// A number nearer to an end of its range than this share of it went to the end: far above rounding, and far below any step of a fit that
/// stops of itself.
const EDGE: f64 = 1e-6;

/// A hypothesis fitted on training runs and scored on held-out runs.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The fit.
    pub fit: Fit,
    /// Its score on the held-out runs, as fitted.
    pub score: Score,
    /// Its posterior-predictive score, by which explanations are compared.
    pub predictive: Predictive,
    /// The gap G that it leaves of the training runs.
    pub training_gap: f64,
    /// Whether the score is by a noise floor of its own: its effects make noise.
    pub has_own_floor: bool,
    /// What the log says against it; see [`StatedStretches`](super::cut::contradiction::StatedStretches).
    pub contradiction: Option<Contradiction>,
    /// The gap that each effect makes by itself (of the fitted machine without it, all other numbers kept), where the explanation is compared with another one that leaves
    /// noise.
    pub own_gaps: Option<Vec<(EffectId, f64)>>,
    /// Whether it was fitted to the end; the others were left when they showed that they do not matter.
    pub thorough: bool,
}

impl Candidate {
    /// Its effects.
    pub fn effects(&self) -> &EffectSet {
        &self.fit.hypothesis.effects
    }

    /// Posterior-predictive log-likelihood of each block of the held-out runs; see [`Score::log_likelihoods`].
    pub(super) fn log_likelihoods(&self, reference: &Score) -> Vec<f64> {
        let mut blocks = self.predictive.score.log_likelihoods(reference);
        let cost = self.predictive.cost / blocks.len().max(1) as f64;
        blocks.iter_mut().for_each(|block| *block -= cost);
        blocks
    }

    /// Mean square that it leaves.
    pub(super) fn left(&self) -> f64 {
        self.predictive.score.mean_square()
    }

    /// Whether it leaves nothing that noise would not leave, of the held-out runs and of those that it was fitted to: how well a fit predicts says nothing of a
    /// law that its own runs refute.
    pub(super) fn is_adequate(&self) -> bool {
        self.predictive.score.is_adequate() && self.training_gap <= ADEQUATE_GAP
    }

    /// Whether effects that leave noise may only look like what acts: of a signal more than 1.11 times the power of the noise is left.
    pub(super) fn may_hide_another(&self) -> bool {
        let is_more = |(_, level): &(Signal, f64)| LARGELY * level > 1.0;
        !self.effects().is_empty()
            && self.is_adequate()
            && self.predictive.score.by_signal().iter().any(is_more)
    }

    /// Whether every effect shows (see [`Fit::shown`]), no number went to the end of where a fit may look, and the effort at rest does not contradict it.
    pub(super) fn is_resolved(&self) -> bool {
        self.unidentified().is_none()
    }

    /// Why the training runs do not identify it, where an effect of it does not show, a number went to the end of where a fit may look, or the effort
    /// at rest contradicts it.
    pub(super) fn unidentified(&self) -> Option<Unidentified> {
        let hidden = self.effects().iter().find(|effect| !self.fit.shown.contains(*effect));
        let hidden = hidden.map(|effect| Unidentified::NotSignificant { effect: effect.name() });
        let ran_off = || {
            let numbers = self.fit.hypothesis.free.iter().zip(self.fit.values.iter().copied());
            let (free, value) = numbers.into_iter().find(|(free, value)| runs_off(free, *value))?;
            Some(Unidentified::AtBound {
                effect: free.effect.name(),
                number: free.name,
                value,
                unit: free.unit,
            })
        };
        let at_rest = self.contradiction.filter(|against| *against == Contradiction::AtRest);
        hidden.or_else(ran_off).or_else(|| at_rest.map(Unidentified::Contradicted))
    }

    /// What forbids a verdict on it beside [`Self::unidentified`]: a stretch that stays open, two waves that are not told apart, or that the search went no further. Others may be
    /// missing beside its effects, and what is built upon it may close the stretch and tell the waves apart.
    pub(super) fn incomplete(&self) -> Option<Unidentified> {
        let merged = || merged(&self.fit).map(|waves| Unidentified::Merged(waves.map(EffectId::name)));
        let effects = self.effects().len();
        let ended = || (effects >= MOST_EFFECTS).then_some(Unidentified::SearchEnded { effects });
        self.contradiction.map(Unidentified::Contradicted).or_else(merged).or_else(ended)
    }

    /// Whether it has a line of the noise among its effects: a period or a frequency was searched, and what was found there
    /// does not show. It is the explanation without that effect, once more. A period that the twin states was not searched.
    pub(super) fn has_noise_line(&self) -> bool {
        let is_searched = |free: &Free| free.freedom == Freedom::Cause && free.is_line();
        let mut free = self.fit.hypothesis.free.iter();
        free.any(|free| is_searched(free) && !self.fit.shown.contains(&free.effect))
    }
}

/// Whether a fitted number of a cause went to the end of where a fit may look: that is no finding (none at all is: zero), but what is
/// still missing beside it may be what drives it there.
fn runs_off(free: &Free, value: f64) -> bool {
    let (least, most) = free.range;
    let edge = EDGE * (most - least);
    // A range over many decades is wide beside its lower end: a thousandth of that end counts there.
    let low = least != 0.0 && value - least < edge.min(1e3 * EDGE * least.abs());
    free.freedom == Freedom::Cause && !free.held && (low || most - value < edge)
}

#[cfg(test)]
mod tests {
    use super::{EffectId, Unidentified};
    use crate::diagnose::found::tests::candidate;

    /// Where the search ended at as many effects as it looks for, one that it does not know may do what several of them do.
    #[test]
    fn exact_an_explanation_of_as_many_effects_as_are_looked_for_is_not_complete() {
        let of = |count: usize| candidate(&EffectId::ALL[..count], 1.0, 1.0).incomplete();
        assert!(of(5).is_none() && matches!(of(6), Some(Unidentified::SearchEnded { effects: 6 })));
    }
}
