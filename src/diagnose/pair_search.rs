//! Two effects that nearly cancel: each explains little by itself, and both together much.

use super::care::Care;
use super::fit::Fit;
use super::found::Found;
use super::hypothesis::EffectSet;
use super::prior::MOST_EFFECTS;
use super::score_test::ScoreTest;
use super::selection::Search;
use super::thresholds::MOST;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

/// So many pairs are fitted: a choice of cost.
const MOST_PAIRS: usize = 3;

impl Search<'_> {
    /// Looks at explanations with two effects more than one that leaves more than noise, as the chosen one does; once for each of these.
    ///
    /// # Model
    /// Effects are added one by one, and of two gains of a controller that are off in opposite directions neither may be worth it. Each effect has been fitted beside
    /// those of the explanation; R are the changes that these fits make of the residuals. By the [score test](ScoreTest) of R the pairs (i, j) are fitted that lower the
    /// sum of squares most, where that is by more than the better one of both does by what decides between two explanations, and to less than half of what the chosen
    /// explanation leaves:
    /// ```text
    ///   gain(i, j) = (b_i, b_j)·G_ij⁻¹·(b_i, b_j)ᵀ,   gain(i) = b_i²/G_ii
    /// ```
    ///
    /// # Validity
    /// To first order in what the fits changed: it chooses what is fitted, and no verdict.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn explore_pairs(&self, found: &mut Found, from: usize) -> Result<()> {
        let is_quiet = [found.chosen, from].iter().any(|&k| found.is_adequate(k));
        if is_quiet || found.candidates[from].effects().len() + 2 > MOST_EFFECTS {
            return Ok(());
        }
        self.prepare(found, from)?;
        let base = found.bases.get_mut(&from).filter(|base| !base.is_paired);
        let Some(base) = base else { return Ok(()) };
        base.is_paired = true;
        let pairs = self.promising_pairs(found, from)?;
        self.explore(found, &pairs, from)?;
        Ok(())
    }

    /// The effects of an explanation with two more, those first that promise most.
    fn promising_pairs(&self, found: &Found, from: usize) -> Result<Vec<EffectSet>> {
        let base = &found.bases[&from];
        let known = &found.candidates[from].fit;
        let own = &known.hypothesis.effects;
        let single = |set: &EffectSet| set.len() == own.len() + 1;
        let fits = self.larger(own).into_iter().filter(single).filter_map(|set| found.index(&set));
        let fits: Vec<&Fit> =
            fits.map(|k| &found.candidates[k]).filter(|one| !one.has_own_floor).map(|one| &one.fit).collect();
        let machines: Vec<Machine> =
            fits.iter().map(|fit| fit.machine(self.machine)).collect::<Result<_>>()?;
        let objective = self.objective(&known.hypothesis).for_care(Care::Rough(&base.sensitivities));
        let chosen = found.candidates[found.chosen].fit.machine(self.machine)?;
        let residuals = objective.residuals(&known.values)?;
        let left = objective.residuals_at(std::slice::from_ref(&chosen))?.remove(0);
        let changes: Vec<DVector<f64>> =
            objective.residuals_at(&machines)?.into_iter().map(|changed| changed - &residuals).collect();
        if changes.len() < 2 {
            return Ok(Vec::new());
        }
        let responses = DMatrix::from_columns(&changes);
        let columns = &base.sensitivities.columns;
        let test = ScoreTest::of(&objective, &known.values, &residuals, columns, &responses);
        // What is worth naming closes most of what is left.
        let weights = objective.weights(&residuals);
        let [all, left] = [&residuals, &left].map(|r| r.component_mul(&weights).dot(r));
        // A gain is twice a log-likelihood.
        let pairs = promising(&test, 2.0 * self.limits.log_odds(), all - MOST * left).into_iter();
        let set =
            |(i, j): (usize, usize)| fits[i].hypothesis.effects.union(&fits[j].hypothesis.effects).copied();
        let sets = pairs.map(|pair| set(pair).collect::<EffectSet>());
        Ok(sets.filter(|set| found.index(set).is_none()).take(MOST_PAIRS).collect())
    }
}

/// Pairs of responses that lower the sum of squares by so much `in_all`, and by `more` than the better one of both does, those first that lower it most.
fn promising(test: &ScoreTest, more: f64, in_all: f64) -> Vec<(usize, usize)> {
    let (normal, right) = (&test.normal, &test.right);
    let alone = |i: usize| if normal[(i, i)] > 0.0 { right[i] * right[i] / normal[(i, i)] } else { 0.0 };
    let gain = |i: usize, j: usize| {
        let block = Matrix2::new(normal[(i, i)], normal[(i, j)], normal[(j, i)], normal[(j, j)]);
        let pull = Vector2::new(right[i], right[j]);
        // Two that do the same to half of the digits have no inverse.
        let is_one = block.determinant() <= f64::EPSILON.sqrt() * block[(0, 0)] * block[(1, 1)];
        block.try_inverse().filter(|_| !is_one).map(|inverse| pull.dot(&(inverse * pull)))
    };
    let count = right.len();
    let mut pairs: Vec<((usize, usize), f64)> = (0..count)
        .flat_map(|i| (i + 1..count).map(move |j| (i, j)))
        .filter_map(|(i, j)| Some(((i, j), gain(i, j)?)))
        .filter(|((i, j), gain)| *gain > in_all.max(alone(*i).max(alone(*j)) + more))
        .collect();
    pairs.sort_by(|a, b| b.1.total_cmp(&a.1));
    pairs.into_iter().map(|(pair, _)| pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Responses (1, 0.1) and (−1, 0.1) add up to (0, 0.2): residuals of 100 along that are explained by both, for a gain of 100², and hardly by either. The third response is
    /// along another direction.
    #[test]
    fn exact_two_that_cancel_promise_most() {
        let responses = DMatrix::from_row_slice(3, 3, &[1.0, -1.0, 0.0, 0.1, 0.1, 0.0, 0.0, 0.0, 1.0]);
        let residuals = DVector::from_vec(vec![0.0, 100.0, 1.0]);
        let test = ScoreTest { normal: responses.tr_mul(&responses), right: -responses.tr_mul(&residuals) };
        assert_eq!(promising(&test, 2.0, 0.5 * 1e4), [(0, 1)]);
        assert!(promising(&test, 1e5, 0.0).is_empty() && promising(&test, 2.0, 1.1e4).is_empty());
        // One and the same response twice is no pair.
        let twice = DMatrix::from_element(2, 2, 1.0);
        let test = ScoreTest { normal: twice, right: DVector::from_element(2, 3.0) };
        assert!(promising(&test, 0.0, 0.0).is_empty());
    }
}
