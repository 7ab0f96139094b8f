//! Columns with clocks of their own brought to one clock.

use crate::error::{Error, ErrorKind, Result};

/// Medians that differ by less than this share are one clock.
const SAME_CLOCK: f64 = 0.01;
/// Values are interpolated across so many of their own periods at most.
const MOST_PERIODS: f64 = 6.5;

/// The samples of one column, with their times in s.
#[derive(Debug, Clone)]
pub(super) struct Series {
    pub(super) name: String,
    pub(super) time_s: Vec<f64>,
    pub(super) values: Vec<f64>,
}

/// Columns on one clock.
#[derive(Debug)]
pub(super) struct Together {
    pub(super) time_s: Vec<f64>,
    pub(super) columns: Vec<Vec<f64>>,
    /// What was done, where anything was.
    pub(super) remark: Option<String>,
}

/// Reads every series at the instants of the slowest one; between two samples on the straight line.
///
/// The slowest clock makes up no samples. Of several equal ones the longest counts, so that a lost value is interpolated.
///
/// # Errors
/// A series without two samples, times that do not increase, a hole of more than a few periods, no common time.
pub(super) fn together(series: &[Series]) -> Result<Together> {
    for one in series {
        check(one)?;
    }
    let period = |one: &Series| median_interval(&one.time_s);
    let slowest = series.iter().map(period).fold(0.0, f64::max);
    let of_that_clock = series.iter().filter(|one| period(one) > slowest * (1.0 - SAME_CLOCK));
    let Some(base) = of_that_clock.max_by_key(|one| one.time_s.len()) else {
        return Ok(Together { time_s: Vec::new(), columns: Vec::new(), remark: None });
    };
    if series.iter().all(|one| one.time_s == base.time_s) {
        let columns = series.iter().map(|one| one.values.clone()).collect();
        return Ok(Together { time_s: base.time_s.clone(), columns, remark: None });
    }
    let ends = |one: &Series| (one.time_s[0], one.time_s[one.time_s.len() - 1]);
    let from = series.iter().map(|one| ends(one).0).fold(f64::NEG_INFINITY, f64::max);
    let to = series.iter().map(|one| ends(one).1).fold(f64::INFINITY, f64::min);
    let time_s: Vec<f64> = base.time_s.iter().copied().filter(|t| (from..=to).contains(t)).collect();
    if time_s.len() < 2 {
        return Err(Error::new(ErrorKind::TooLittleData)
            .found("columns that were logged at different times")
            .expected("columns with a time in common")
            .remedy("leave out the column that was logged elsewhere, or export the channels again"));
    }
    let columns = series.iter().map(|one| at(one, &time_s)).collect::<Result<_>>()?;
    let others = series.iter().filter(|one| one.time_s != base.time_s).count();
    let remark = format!(
        "{others} of {} columns have other time stamps than `{}`: read at its {} instants, on the straight line between samples",
        series.len(),
        base.name,
        time_s.len()
    );
    Ok(Together { time_s, columns, remark: Some(remark) })
}

fn check(one: &Series) -> Result<()> {
    let refuse = |kind, found: String, expected: &str| {
        Err(Error::new(kind).key(one.name.clone()).found(found).expected(expected))
    };
    if one.time_s.len() < 2 {
        let found = format!("{} samples", one.time_s.len());
        return refuse(ErrorKind::TooLittleData, found, "two samples at least")
            .map_err(|error| error.remedy("leave the column out, or record it again"));
    }
    match one.time_s.windows(2).find(|pair| pair[0].partial_cmp(&pair[1]) != Some(std::cmp::Ordering::Less)) {
        None => Ok(()),
        Some(pair) => {
            let found = format!("{} s after {} s", pair[1], pair[0]);
            refuse(ErrorKind::Inconsistent, found, "time that increases from sample to sample")
                .map_err(|error| error.remedy("split the log where the clock was reset"))
        }
    }
}

fn median_interval(time_s: &[f64]) -> f64 {
    let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = intervals.len() / 2;
    *intervals.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The values at some instants, which lie between the first and the last of the series.
fn at(one: &Series, instants_s: &[f64]) -> Result<Vec<f64>> {
    let longest = MOST_PERIODS * median_interval(&one.time_s);
    let mut right = 1;
    let value = |&instant: &f64| {
        while right + 1 < one.time_s.len() && one.time_s[right] < instant {
            right += 1;
        }
        let (t0, t1) = (one.time_s[right - 1], one.time_s[right]);
        let share = (instant - t0) / (t1 - t0);
        if t1 - t0 > longest && share > 0.0 && share < 1.0 {
            return Err(Error::new(ErrorKind::Missing)
                .key(one.name.clone())
                .found(format!("no value from {t0} s to {t1} s"))
                .expected("at most 5 values lost in a row")
                .remedy(format!(
                    "split the run there: `to_s = {t0}` in one [[run]], `from_s = {t1}` in the next"
                )));
        }
        let (v0, v1) = (one.values[right - 1], one.values[right]);
        // Exactly on a sample the sample itself: no rounding.
        Ok(if share <= 0.0 {
            v0
        } else if share >= 1.0 {
            v1
        } else {
            v0 + share * (v1 - v0)
        })
    };
    instants_s.iter().map(value).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(name: &str, step: f64, count: usize, slope: f64) -> Series {
        let time_s: Vec<f64> = (0..count).map(|k| k as f64 * step).collect();
        let values = time_s.iter().map(|t| slope * t).collect();
        Series { name: name.to_owned(), time_s, values }
    }

    #[test]
    fn exact_fast_columns_are_read_at_the_instants_of_the_slowest() {
        let both = [series("fast", 0.25, 41, 2.0), series("slow", 1.0, 11, 3.0)];
        let read = together(&both).unwrap();
        assert_eq!(read.time_s, both[1].time_s);
        assert_eq!(read.columns[1], both[1].values);
        assert!(read.columns[0].iter().zip(&read.time_s).all(|(v, t)| *v == 2.0 * t));
        assert!(read.remark.unwrap().contains("1 of 2 columns"));
    }

    #[test]
    fn exact_a_lost_value_is_on_the_line_and_a_hole_is_refused() {
        let whole = series("whole", 0.5, 40, 1.0);
        let without = |lost: std::ops::Range<usize>| {
            let mut holed = series("holed", 0.5, 40, 4.0);
            holed.time_s.drain(lost.clone());
            holed.values.drain(lost);
            holed
        };
        let read = together(&[whole.clone(), without(10..12)]).unwrap();
        assert_eq!(read.time_s, whole.time_s);
        assert!(read.columns[1].iter().zip(&read.time_s).all(|(v, t)| (v - 4.0 * t).abs() < 1e-12));
        let error = together(&[whole, without(10..30)]).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Missing);
        assert!(error.to_string().contains("to_s = 4.5"), "{error}");
    }

    #[test]
    fn exact_equal_clocks_are_left_as_they_are() {
        let read = together(&[series("a", 0.5, 9, 1.0), series("b", 0.5, 9, 2.0)]).unwrap();
        assert!(read.remark.is_none() && read.columns[1][8] == 8.0);
    }
}
