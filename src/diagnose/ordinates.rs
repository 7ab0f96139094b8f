//! Ordinates of a spectrum beside their neighbours.

/// The larger median of the ordinates below and above a place, those from `near` to `far` places away; a side with fewer than
/// `least` of them does not count. None where neither does.
///
/// ```text
///   max(median(p[k − far … k − near]), median(p[k + near … k + far]))
/// ```
/// The larger one: on a slope that is the side from which the line must stand out.
pub fn around(ordinates: &[f64], place: usize, [near, far]: [usize; 2], least: usize) -> Option<f64> {
    let median = |side: std::ops::Range<usize>| {
        let mut own = ordinates[side].to_vec();
        let middle = own.len() / 2;
        (own.len() >= least).then(|| *own.select_nth_unstable_by(middle, f64::total_cmp).1)
    };
    let end = ordinates.len();
    let below = median(place.saturating_sub(far)..place.saturating_sub(near));
    let above = median((place + near).min(end)..(place + far).min(end));
    below.into_iter().chain(above).reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_larger_median_of_both_sides() {
        let ordinates = [1.0, 2.0, 3.0, 9.0, 100.0, 9.0, 7.0, 6.0, 5.0];
        assert_eq!(around(&ordinates, 4, [2, 5], 2), Some(6.0));
        // One side is cut off by the end.
        assert_eq!(around(&ordinates, 8, [2, 5], 2), Some(9.0));
        assert_eq!(around(&ordinates[3..6], 1, [2, 5], 1), None);
    }
}
