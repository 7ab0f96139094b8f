//! Lost samples: rows that a clock should have written and did not.

use super::timing::measured_period;

/// So many samples in a row are filled in at most.
const MOST_IN_A_ROW: f64 = 5.0;
/// Share of a run that may be filled in.
const MOST_SHARE: f64 = 0.02;
/// How far an interval may be from a whole number of periods, in periods.
const OFF_GRID: f64 = 0.2;
/// Rows that are named.
const ROWS_NAMED: usize = 8;

/// Puts lost samples in on the straight line between their neighbours, and says how many and where.
///
/// Nothing is done where intervals are no whole numbers of periods, or where more than 2 % of the samples are missing: then the time
/// column is no clock that lost samples, and it is judged as it stands.
pub(super) fn fill(
    time_s: &mut Vec<f64>,
    columns: &mut [Vec<f64>],
    declared_s: Option<f64>,
    first_row: u64,
) -> Option<String> {
    if !time_s.windows(2).all(|pair| pair[1] > pair[0]) {
        return None;
    }
    let period = declared_s.or_else(|| measured_period(time_s))?;
    let lost = |pair: &[f64]| {
        let periods = (pair[1] - pair[0]) / period;
        let whole = periods.round();
        let fits = (2.0..=MOST_IN_A_ROW + 1.0).contains(&whole) && (periods - whole).abs() < OFF_GRID;
        if fits { whole as usize - 1 } else { 0 }
    };
    let gaps: Vec<(usize, usize)> = time_s.windows(2).enumerate().map(|(k, pair)| (k, lost(pair))).collect();
    let gaps: Vec<(usize, usize)> = gaps.into_iter().filter(|(_, lost)| *lost > 0).collect();
    let total: usize = gaps.iter().map(|(_, lost)| lost).sum();
    if total == 0 || gaps.len() as f64 > (MOST_SHARE * time_s.len() as f64).max(1.0) {
        return None;
    }
    for column in std::iter::once(time_s).chain(columns.iter_mut()) {
        filled(column, &gaps, total);
    }
    let rows: Vec<String> =
        gaps.iter().take(ROWS_NAMED).map(|(k, _)| (first_row + *k as u64 + 1).to_string()).collect();
    let more = if gaps.len() > ROWS_NAMED { ", …" } else { "" };
    let (sample, row) =
        (if total == 1 { "sample" } else { "samples" }, if gaps.len() == 1 { "row" } else { "rows" });
    Some(format!(
        "{total} lost {sample} filled in on the straight line between neighbours (before {row} {}{more})",
        rows.join(", ")
    ))
}

fn filled(column: &mut Vec<f64>, gaps: &[(usize, usize)], total: usize) {
    let mut out = Vec::with_capacity(column.len() + total);
    let mut from = 0;
    for &(place, lost) in gaps {
        out.extend_from_slice(&column[from..=place]);
        let (left, right) = (column[place], column[place + 1]);
        out.extend((1..=lost).map(|k| left + (right - left) * k as f64 / (lost + 1) as f64));
        from = place + 1;
    }
    out.extend_from_slice(&column[from..]);
    *column = out;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(keep: impl Fn(&usize) -> bool) -> (Vec<f64>, Vec<Vec<f64>>) {
        let kept: Vec<usize> = (0..200).filter(keep).collect();
        (kept.iter().map(|k| *k as f64 * 0.5).collect(), vec![kept.iter().map(|k| 3.0 * *k as f64).collect()])
    }

    #[test]
    fn exact_lost_samples_come_back_on_the_line() {
        let (mut time_s, mut columns) = clock(|k| ![40, 90, 91].contains(k));
        let told = fill(&mut time_s, &mut columns, None, 2).unwrap();
        assert_eq!(time_s, clock(|_| true).0);
        assert_eq!(columns, clock(|_| true).1);
        assert!(told.starts_with("3 lost samples") && told.contains("rows 42, 91"), "{told}");
    }

    #[test]
    fn exact_whole_logs_long_holes_and_polled_logs_are_left() {
        for (mut time_s, mut columns) in
            [clock(|_| true), clock(|k| !(50..80).contains(k)), clock(|k| k % 3 > 0)]
        {
            let before = time_s.clone();
            assert_eq!(fill(&mut time_s, &mut columns, None, 2), None);
            assert_eq!(time_s, before);
        }
    }
}
