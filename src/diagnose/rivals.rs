//! Explanations that stand beside the chosen one.

use super::candidate::Candidate;
use super::found::Found;
use super::hypothesis::EffectSet;
use super::prior::price;

/// Explanations closer than this in log-likelihood predict equally well (a factor of 20 in likelihood).
pub const INDISTINCT: f64 = 3.0;
/// Explanations closer than this in log-likelihood may differ by no more than chance: by what each fit made of the
/// noise of the training runs.
const NEAR: f64 = 12.0;
/// A rival less probable than this share of the chosen explanation is not looked into.
const WORTH_MENTIONING: f64 = 0.001;

/// Explanations that lack one of the chosen effects, with their probabilities.
pub fn rivals(found: &Found) -> impl Iterator<Item = (&Candidate, f64)> {
    let chosen = found.candidates[found.chosen].effects();
    let pairs = found.candidates.iter().zip(found.posterior.iter().copied());
    pairs.filter(move |(candidate, _)| !candidate.effects().is_superset(chosen))
}

/// Log-likelihood by which another explanation predicts the held-out runs better than the chosen one, whatever their prior;
/// none where either cannot be.
pub fn better(found: &Found, other: &Candidate, probability: f64) -> Option<f64> {
    let own = found.posterior[found.chosen];
    let chosen = found.candidates[found.chosen].effects();
    let likelihood = |probability: f64, effects: &EffectSet| probability.ln() + price(effects, &found.stated);
    (own > 0.0 && probability > 0.0)
        .then(|| likelihood(probability, other.effects()) - likelihood(own, chosen))
}

/// A rival of the chosen explanation.
pub struct Rival<'a> {
    /// The explanation.
    pub candidate: &'a Candidate,
    /// Its weight among the rivals.
    pub weight: f64,
    /// Whether it predicts the held-out runs as well, or leaves the verdict undecided; else it only comes near, and
    /// chance may be all that is between them.
    pub is_open: bool,
}

/// Explanations that these data do not set apart from the chosen one, or hardly, most probable first.
pub fn open_rivals(found: &Found, is_undecided: bool) -> Vec<Rival<'_>> {
    let least = if is_undecided { WORTH_MENTIONING } else { f64::INFINITY };
    let most = found.posterior.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let own = found.posterior[found.chosen].max(WORTH_MENTIONING * most);
    let is_near = |candidate: &Candidate, p: f64, within: f64| {
        better(found, candidate, p).is_some_and(|better| better > -within) || p > least * own
    };
    let mut open: Vec<Rival> = rivals(found)
        .filter(|(candidate, p)| is_near(candidate, *p, NEAR))
        .map(|(candidate, p)| Rival {
            candidate,
            weight: p / own + WORTH_MENTIONING,
            is_open: is_near(candidate, p, INDISTINCT),
        })
        .collect();
    open.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    open
}
