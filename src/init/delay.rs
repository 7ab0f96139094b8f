//! A delay from what is left at whole numbers of samples.

use crate::identify::least_squares::Estimate;

/// The delay in s: the lowest point of the parabola through the cost at the best number of samples and at its neighbours; that
/// number itself at the first and last one tried.
pub fn of_costs(costs: &[f64], best: usize, period_s: f64) -> Estimate {
    let at = best as f64 * period_s;
    let neighbours = best.checked_sub(1).map(|k| costs[k]).zip(costs.get(best + 1));
    // At the first one what comes before is not known.
    let shift = neighbours.map_or(0.0, |(before, after)| {
        let bend = before - 2.0 * costs[best] + after;
        if bend > 0.0 { 0.5 * period_s * (before - after) / bend } else { 0.0 }
    });
    within_half_a_period(at + shift, period_s)
}

/// A delay that is known to half a sample period either way: what a sampled log shows of it, taken for a 95 % interval.
pub fn within_half_a_period(value: f64, period_s: f64) -> Estimate {
    let half = 0.5 * period_s;
    Estimate { value, standard_error: 0.5 * half, ci95: [value - half, value + half] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola about 2.3 samples gives 2.3 samples; at the first one tried nothing is known before it.
    #[test]
    fn exact_the_lowest_point_of_a_parabola() {
        let costs: Vec<f64> = (0..5).map(|k| 1.0 + (f64::from(k) - 2.3).powi(2)).collect();
        let found = of_costs(&costs, 2, 1e-3);
        assert!((found.value - 2.3e-3).abs() < 1e-12 && found.covers(2.0e-3) && !found.covers(1.7e-3));
        assert_eq!(of_costs(&[1.0, 2.0], 0, 1e-3).value, 0.0);
    }
}
