//! Numbers that the held-out runs tell better than the training runs do.

use super::candidate::Candidate;
use super::free::Freedom;
use super::verdict::{Gap, Updated};

/// The gap of an explanation, with what training and held-out runs together say of its numbers.
pub fn with_predictive(gap: Gap, candidate: &Candidate) -> Gap {
    let after_predictive = candidate.predictive.score.gap();
    Gap { after_predictive, updated: updated(candidate), ..gap }
}

/// The numbers of causes that the held-out runs move by a standard error or more, the one that moves by the largest share of itself first.
fn updated(candidate: &Candidate) -> Vec<Updated> {
    let Some(values) = &candidate.predictive.values else { return Vec::new() };
    let fit = &candidate.fit;
    let moved = fit.hypothesis.free.iter().enumerate().filter(|(k, free)| {
        let standard_error = fit.covariance[(*k, *k)].sqrt() * free.scale;
        free.freedom == Freedom::Cause && (values[*k] - fit.values[*k]).abs() >= standard_error
    });
    let mut moved: Vec<Updated> = moved
        .map(|(k, free)| {
            let [fitted, updated] = [fit.values[k], values[k]];
            Updated { path: free.path.clone(), fitted, updated, unit: free.unit.to_owned() }
        })
        .filter(|number| number.fitted != number.updated)
        .collect();
    moved.sort_by(|a, b| share(b).total_cmp(&share(a)));
    moved
}

/// How far a number moves, as a share of itself.
fn share(number: &Updated) -> f64 {
    (number.updated - number.fitted).abs() / number.fitted.abs().max(number.updated.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate};

    /// Two numbers of 1.0 with standard errors of 0.1: the first moves by one and a half of them, the second by two thirds; then both.
    #[test]
    fn exact_numbers_that_move_by_a_standard_error_are_listed() {
        let moved = |values: [f64; 2]| {
            let mut candidate = candidate(&[COULOMB, BACKLASH], 1.0, 4.0);
            candidate.predictive.values = Some(values.to_vec());
            updated(&candidate).into_iter().map(|number| number.updated).collect::<Vec<_>>()
        };
        assert_eq!(moved([1.15, 0.93]), [1.15]);
        assert_eq!(moved([1.15, 0.8]), [0.8, 1.15]);
        assert!(updated(&candidate(&[COULOMB], 1.0, 4.0)).is_empty());
    }
}
