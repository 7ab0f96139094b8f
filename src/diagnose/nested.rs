//! A fit leaves no more of the training runs than one with fewer effects.

use super::Progress;
use super::care::Care;
use super::fit::Fit;
use super::found::Found;
use super::selection::Search;
use crate::error::Result;

impl Fit {
    /// Its values where one with fewer effects ended: what that has not does nothing there; none where that leaves no less.
    ///
    /// A number without a value at which it does nothing (a period, a place) stays as it is: the others of its effect do nothing.
    fn begun_at(&self, smaller: &Self) -> Option<Vec<f64>> {
        let pairs = self.hypothesis.free.iter().zip(&self.values);
        let begun = pairs.map(|(free, own)| {
            let known = smaller.hypothesis.value(&free.path, &smaller.values);
            known.unwrap_or(if free.neutral.is_finite() { free.neutral } else { *own })
        });
        (smaller.size < self.size).then(|| begun.collect())
    }
}

impl Search<'_> {
    /// Fits candidates to the end again, from where one with an effect less ended that leaves less of the training runs than they do: they ended in a minimum that is not the
    /// least. What leaves less is kept.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn nest(&self, found: &mut Found, indices: &[usize]) -> Result<()> {
        for &k in indices {
            let candidate = &found.candidates[k];
            let set = candidate.effects();
            // A twin that makes noise leaves more than one that makes none, where the machine makes it.
            let may_lack = set.iter().filter(|effect| !effect.makes_noise());
            let smaller = may_lack.filter_map(|effect| found.index(&self.without(set, [*effect])));
            let ended = smaller.map(|j| &found.candidates[j]).filter(|smaller| smaller.thorough);
            let least = ended.min_by(|a, b| a.fit.size.total_cmp(&b.fit.size));
            let Some(begun) = least.and_then(|least| candidate.fit.begun_at(&least.fit)) else { continue };
            (self.progress)(Progress::Asked(1));
            let again = self.evaluate(&candidate.fit.hypothesis, Some(&begun), Care::Thorough)?;
            if again.fit.size < candidate.fit.size {
                found.candidates[k] = again;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate};
    use crate::diagnose::free::Free;
    use crate::diagnose::free::tests::number;
    use crate::diagnose::hypothesis::tests::hypothesis;

    /// Friction that leaves less than friction and play do is where these are begun anew: the friction as it ended alone, the play's width at nothing and its phase, which
    /// has no such value, as it was. Of what leaves no less nothing is begun.
    #[test]
    fn exact_a_fuller_fit_begins_where_a_smaller_one_left_less() {
        let sized = |size: f64, value: f64| Fit { size, ..candidate(&[COULOMB], value, 1.0).fit };
        let phase = Free { neutral: f64::NAN, ..number(BACKLASH, "phase") };
        let numbers = vec![number(COULOMB, "n"), number(BACKLASH, "width"), phase];
        let fuller = Fit { hypothesis: hypothesis(numbers), values: vec![1.0, 2.0, 3.0], ..sized(5.0, 1.0) };
        assert_eq!(fuller.begun_at(&sized(4.9, 7.0)), Some(vec![7.0, 0.0, 3.0]));
        assert_eq!([5.0, 5.1].map(|size| fuller.begun_at(&sized(size, 7.0))), [None, None]);
    }
}
