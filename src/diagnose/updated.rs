//! Numbers that the held-out runs tell better than the training runs do.

use super::candidate::Candidate;
use super::free::Freedom;
use super::verdict::{Gap, Updated};

/// The gap of an explanation, with what training and held-out runs together say of its numbers.
pub fn with_predictive(gap: Gap, candidate: &Candidate) -> Gap {
    let after_predictive = candidate.predictive.score.gap();
    Gap { after_predictive, updated: updated(candidate), ..gap }
}

/// The numbers of causes that the held-out runs move by a standard error or more, the one that moves by most of them first.
fn updated(candidate: &Candidate) -> Vec<Updated> {
    let Some(values) = &candidate.predictive.values else { return Vec::new() };
    let fit = &candidate.fit;
    let causes = fit.hypothesis.free.iter().enumerate().filter(|(_, free)| free.freedom == Freedom::Cause);
    let mut moved: Vec<Updated> = causes
        .map(|(k, free)| {
            let [fitted, updated] = [fit.values[k], values[k]];
            let standard_errors = (updated - fitted).abs() / fit.standard_errors[k];
            Updated { path: free.path.clone(), fitted, updated, standard_errors, unit: free.unit.to_owned() }
        })
        .filter(|number| number.standard_errors >= 1.0)
        .collect();
    moved.sort_by(|a, b| b.standard_errors.total_cmp(&a.standard_errors));
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::found::tests::{BACKLASH, COULOMB, candidate};

    /// Two numbers of 1.0 with standard errors of 0.1: the first moves by one and a half of them and the second by two thirds of one; then both by more.
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
