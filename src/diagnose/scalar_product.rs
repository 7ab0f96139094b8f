//! The scalar product of two series.

use nalgebra::DVectorView;

/// Σ a·b over what both have, in several sums that are independent of each other, as a processor adds fastest.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().min(b.len());
    DVectorView::from_slice(&a[..count], count).dot(&DVectorView::from_slice(&b[..count], count))
}

#[cfg(test)]
mod tests {
    use super::dot;

    #[test]
    fn exact_the_shorter_one_counts() {
        let a: Vec<f64> = (0..19).map(f64::from).collect();
        assert_eq!(dot(&a, &a[1..]), (0..18).map(|k| f64::from(k * (k + 1))).sum::<f64>());
        assert_eq!(dot(&a, &[]), 0.0);
    }
}
