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

/// Ordinates one over the length of the series apart lie this many places apart where lines are looked for.
pub const OVERSAMPLING: usize = 4;
/// A line has so many times the median of its neighbours on both sides, some six times their mean: enough to start a fit from, which decides. What
/// repeats with the motion has no line so narrow.
const STANDS_OUT: f64 = 8.0;
/// A line's own ordinates on either side, and its neighbours beyond them, one over the length of the series apart. A Hann window makes a line as wide.
const OWN: usize = 2;
const NEIGHBOURS: usize = 6;

/// Places in a range at which a line stands out from its neighbours, the strongest first.
pub fn lines(ordinates: &[f64], range: std::ops::Range<usize>) -> Vec<usize> {
    let end = ordinates.len();
    let is_peak = |k: usize| {
        let own = k.saturating_sub(OVERSAMPLING)..(k + OVERSAMPLING + 1).min(end);
        own.into_iter().all(|j| ordinates[j] <= ordinates[k])
    };
    let (near, far) = (OWN * OVERSAMPLING, (OWN + NEIGHBOURS) * OVERSAMPLING);
    let stands_out = |k: usize| {
        around(ordinates, k, [near, far], 1).is_none_or(|around| ordinates[k] > STANDS_OUT * around)
    };
    let is_line = |&k: &usize| ordinates[k] > 0.0 && is_peak(k) && stands_out(k);
    let mut lines: Vec<usize> = (range.start..range.end.min(end)).filter(is_line).collect();
    lines.sort_by(|&a, &b| ordinates[b].total_cmp(&ordinates[a]));
    lines
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
