//! What the time column says about the sampling.

use crate::error::{Error, ErrorKind, Result};

/// An interval that differs from the period by more than this fraction counts as irregular.
const JITTER_FRACTION: f64 = 0.01;
/// An interval longer than this many periods is a gap: samples are missing.
const GAP_PERIODS: f64 = 1.5;
/// The same where samples were taken at uneven times.
const UNEVEN_GAP_PERIODS: f64 = 10.0;
/// A clock has fewer intervals than this share that are no whole number of periods.
const UNEVEN_SHARE: f64 = 0.1;
/// Declared and measured period must agree to this fraction; the clocks of drives do, to a few 1e-5.
const PERIOD_AGREEMENT: f64 = 1e-3;
/// A time stamp this many periods off an even clock belongs to another sample of it.
const STRAYED_PERIODS: f64 = 0.5;
/// Rows of irregular intervals that are kept for reports.
const ROWS_KEPT: usize = 20;

/// Where the sample period comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeriodSource {
    /// `sample_period_s` of the recording; the file has no time column.
    Declared,
    /// The time column alone.
    Measured,
    /// Both, and they agree.
    DeclaredAndMeasured,
}

/// What was found about the time column of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// Where the period comes from.
    pub source: PeriodSource,
    /// The period in force.
    pub sample_period_s: f64,
    /// Mean interval of the time column, where there is one.
    pub measured_period_s: Option<f64>,
    /// Largest deviation of an interval from the period.
    pub worst_jitter_s: f64,
    /// Row at the end of that interval.
    pub worst_jitter_row: Option<u64>,
    /// Number of intervals that are off by more than 1 % of the period.
    pub irregular_intervals: usize,
    /// Number of intervals.
    pub intervals: usize,
    /// Number of intervals that are off by more than 1 % of the period from any whole number of periods.
    pub off_grid_intervals: usize,
    /// Rows at the end of the first of these.
    pub irregular_rows: Vec<u64>,
    /// Largest distance of a time stamp from the even clock that begins with the first one and has the period.
    pub wander_s: f64,
}

impl Timing {
    /// The timing of a run without a time column.
    pub fn declared(sample_period_s: f64) -> Self {
        Self {
            source: PeriodSource::Declared,
            sample_period_s,
            measured_period_s: None,
            worst_jitter_s: 0.0,
            worst_jitter_row: None,
            irregular_intervals: 0,
            intervals: 0,
            off_grid_intervals: 0,
            irregular_rows: Vec::new(),
            wander_s: 0.0,
        }
    }

    /// Whether the samples were taken at uneven times, not by a clock: no period is declared, more than a tenth of the
    /// intervals are no whole number of periods, and the time stamps stray from an even clock by more than half a period. Rounded stamps and
    /// stamps that jitter about a clock do not stray, and where a clock's samples are lost the intervals are whole.
    pub fn is_uneven(&self) -> bool {
        self.source == PeriodSource::Measured
            && self.off_grid_intervals as f64 > UNEVEN_SHARE * self.intervals as f64
            && self.wander_s > STRAYED_PERIODS * self.sample_period_s
    }

    /// The worst jitter as a fraction of the period.
    pub fn worst_jitter(&self) -> f64 {
        self.worst_jitter_s / self.sample_period_s
    }

    /// Examines a time column in s; `first_row` is the row of its first sample in the file.
    ///
    /// # Errors
    /// Time that does not increase, a gap (more than 1.5 periods), a declared period that the column
    /// contradicts, a single sample with nothing declared; each with the row where there is one.
    pub(super) fn of_column(time_s: &[f64], declared_s: Option<f64>, first_row: u64) -> Result<Self> {
        let row = |index: usize| first_row + index as u64;
        if let Some(at) = (1..time_s.len()).find(|&at| time_s[at] <= time_s[at - 1]) {
            return Err(Error::new(ErrorKind::Inconsistent)
                .row(row(at))
                .found(format!("{} s after {} s", time_s[at], time_s[at - 1]))
                .expected("time that increases from row to row")
                .remedy("sort the rows, drop repeated ones, or split the run where the clock was reset"));
        }
        let Some(measured) = measured_period(time_s) else {
            return declared_s.map(Self::declared).ok_or_else(|| {
                Error::new(ErrorKind::TooLittleData)
                    .found("a single sample")
                    .expected("two samples at least, to tell the sample period")
                    .remedy("take the run out, or give sample_period_s")
            });
        };
        let timing = Self::intervals(time_s, declared_s, measured, first_row);
        let most_periods = if timing.is_uneven() { UNEVEN_GAP_PERIODS } else { GAP_PERIODS };
        refuse_gap(time_s, timing.sample_period_s, most_periods, first_row)?;
        if let Some(declared) = declared_s
            && (measured / declared - 1.0).abs() > PERIOD_AGREEMENT
        {
            return Err(disagreement(declared, measured));
        }
        Ok(timing)
    }

    fn intervals(time_s: &[f64], declared_s: Option<f64>, measured: f64, first_row: u64) -> Self {
        let period = declared_s.unwrap_or(measured);
        let mut timing = Self::declared(period);
        timing.measured_period_s = Some(measured);
        timing.source =
            if declared_s.is_some() { PeriodSource::DeclaredAndMeasured } else { PeriodSource::Measured };
        timing.intervals = time_s.len() - 1;
        let even = time_s.iter().enumerate().map(|(k, t)| (t - time_s[0] - k as f64 * period).abs());
        timing.wander_s = even.fold(0.0, f64::max);
        for (index, pair) in time_s.windows(2).enumerate() {
            let interval = pair[1] - pair[0];
            let off = (interval - period).abs();
            let periods = (interval / period).round().max(1.0);
            if (interval - periods * period).abs() > JITTER_FRACTION * period {
                timing.off_grid_intervals += 1;
            }
            let row = first_row + index as u64 + 1;
            if off > timing.worst_jitter_s {
                timing.worst_jitter_s = off;
                timing.worst_jitter_row = Some(row);
            }
            if off > JITTER_FRACTION * period {
                timing.irregular_intervals += 1;
                if timing.irregular_rows.len() < ROWS_KEPT {
                    timing.irregular_rows.push(row);
                }
            }
        }
        timing
    }
}

/// The mean interval, gaps left aside; to 12 digits, so that decimal time stamps give a decimal period.
pub(super) fn measured_period(time_s: &[f64]) -> Option<f64> {
    /// Between the 1.5 medians that time stamps rounded to a coarse clock reach and the 2 of a lost sample.
    const LONG_MEDIANS: f64 = 1.75;
    let (first, last) = (time_s.first()?, time_s.last()?);
    let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if intervals.is_empty() {
        return None;
    }
    let middle = intervals.len() / 2;
    let median = *intervals.select_nth_unstable_by(middle, f64::total_cmp).1;
    let long: Vec<f64> =
        intervals.iter().copied().filter(|interval| *interval > LONG_MEDIANS * median).collect();
    let kept = (intervals.len() - long.len()) as f64;
    let period = (last - first - long.iter().sum::<f64>()) / kept;
    Some(format!("{period:.11e}").parse().unwrap_or(period))
}

fn refuse_gap(time_s: &[f64], period: f64, most_periods: f64, first_row: u64) -> Result<()> {
    // When most intervals are too long the period itself is wrong: that is said elsewhere, not as a gap.
    let is_gap = |pair: &[f64]| pair[1] - pair[0] > most_periods * period;
    let gaps = time_s.windows(2).filter(|pair| is_gap(pair)).count();
    let Some(at) = time_s.windows(2).position(is_gap) else { return Ok(()) };
    if 2 * gaps > time_s.len() - 1 {
        return Ok(());
    }
    let interval = time_s[at + 1] - time_s[at];
    Err(Error::new(ErrorKind::Inconsistent)
        .row(first_row + at as u64 + 1)
        .found(format!(
            "a gap of {} periods ({gaps} such in the run)",
            (interval / period * 10.0).round() / 10.0
        ))
        .expected(format!("one sample every {period} s"))
        .remedy("split the run there or resample"))
}

fn disagreement(declared: f64, measured: f64) -> Error {
    Error::new(ErrorKind::Inconsistent)
        .found(format!("one sample every {measured} s"))
        .expected(format!("every {declared} s, as sample_period_s declares"))
        .remedy("correct sample_period_s or the unit of the time column, or leave sample_period_s out")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_decimal_time_stamps_give_a_decimal_period() {
        let time: Vec<f64> = (0..1000).map(|k| 3.7 + f64::from(k) * 250e-6).collect();
        let timing = Timing::of_column(&time, None, 2).unwrap();
        assert_eq!(timing.sample_period_s, 250e-6);
        assert_eq!(timing.irregular_intervals, 0);
        assert_eq!(timing.source, PeriodSource::Measured);
    }

    #[test]
    fn exact_jitter_is_found_with_its_row() {
        let mut time: Vec<f64> = (0..100).map(|k| f64::from(k) * 1e-3).collect();
        time[50] += 0.2e-3;
        let timing = Timing::of_column(&time, None, 2).unwrap();
        assert_eq!(timing.irregular_intervals, 2);
        assert_eq!(timing.irregular_rows, [52, 53]);
        assert!((timing.worst_jitter() - 0.2).abs() < 1e-9);
    }

    #[test]
    fn exact_coarse_time_stamps_are_jitter_not_gaps() {
        let time: Vec<f64> = (0..100).map(|k| (f64::from(k) * 2.5).round() * 1e-4).collect();
        let timing = Timing::of_column(&time, None, 2).unwrap();
        assert!((timing.sample_period_s - 250e-6).abs() < 1e-6);
        assert!(timing.irregular_intervals > 90);
    }

    #[test]
    fn exact_polled_samples_are_uneven_and_those_of_a_clock_are_not() {
        let uneven = |time: Vec<f64>, declared| Timing::of_column(&time, declared, 2).unwrap().is_uneven();
        // 5.3 ms, then 3.5 ms when there is less to poll.
        let polled: Vec<f64> =
            (0..200).map(|k| f64::from(k) * 5.3e-3 - f64::from((k - 100).max(0)) * 1.8e-3).collect();
        assert!(uneven(polled.clone(), None));
        let coarse: Vec<f64> = (0..1000).map(|k| (f64::from(k) * 2.5).round() * 1e-4).collect();
        let jittery: Vec<f64> =
            (0..1000).map(|k| (f64::from(k) + 0.4 * f64::from(k * k % 7) / 7.0) * 1e-3).collect();
        assert!(!uneven(coarse, None) && !uneven(jittery, None));
        let steady: Vec<f64> = (0..1000).map(|k| f64::from(k) * 1e-3).collect();
        assert!(!uneven(steady, Some(1e-3)));
    }

    #[test]
    fn exact_gap_is_refused() {
        let time: Vec<f64> = (0..100).filter(|k| *k != 40).map(|k| f64::from(k) * 1e-3).collect();
        let error = Timing::of_column(&time, None, 2).unwrap_err();
        assert_eq!(error.row_number(), Some(42));
        assert!(error.to_string().contains("split the run there or resample"));
    }
}
