//! The part of a file that a run uses: `from_s` and `to_s` of a `[[run]]`.

use std::ops::Range;

use super::document::{Document, Step, number};
use crate::error::{Error, ErrorKind, Result};

/// A time stamp that misses an end of the range by less, in s, stands on it: rounding of decimal numbers.
const ROUNDING_S: f64 = 1e-9;

/// The samples with `from_s` ≤ t < `to_s`, so that two ranges may share an end and no sample.
///
/// Time is that of the time column; where there is none, the first sample of the file is at 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeRange {
    from_s: f64,
    to_s: f64,
}

impl TimeRange {
    /// Every sample.
    pub(super) fn whole() -> Self {
        Self { from_s: f64::NEG_INFINITY, to_s: f64::INFINITY }
    }

    /// Reads the keys of the `[[run]]` at `base`; an end that is not given is open.
    pub(super) fn read(document: &Document, base: &[Step<'_>], run: &toml::Table) -> Result<Self> {
        let end = |key: &str, open: f64| {
            let Some(value) = run.get(key) else { return Ok(open) };
            let steps = [base, &[Step::Key(key)]].concat();
            number(value)
                .filter(|time| time.is_finite())
                .ok_or_else(|| document.wrong_type(&steps, value, "a time in seconds, such as 8.0"))
        };
        let range = Self { from_s: end("from_s", f64::NEG_INFINITY)?, to_s: end("to_s", f64::INFINITY)? };
        if range.from_s < range.to_s {
            return Ok(range);
        }
        Err(document
            .refuse(ErrorKind::OutOfRange, &[base, &[Step::Key("from_s")]].concat())
            .found(format!("from {} s to {} s", range.from_s, range.to_s))
            .expected("a range that ends after it begins")
            .remedy("correct from_s or to_s, or leave one of them out"))
    }

    /// The indices of the samples in the range, of a file whose samples stand at these times.
    ///
    /// # Errors
    /// No sample in it.
    pub(super) fn of(self, count: usize, time_s: impl Fn(usize) -> f64) -> Result<Range<usize>> {
        let first_from = |end: f64| (0..count).find(|&k| time_s(k) >= end - ROUNDING_S).unwrap_or(count);
        let inside = first_from(self.from_s)..first_from(self.to_s);
        if !inside.is_empty() || count == 0 {
            return Ok(inside);
        }
        let key = if self.from_s > f64::NEG_INFINITY { "from_s" } else { "to_s" };
        let (first, last) = (time_s(0), time_s(count - 1));
        Err(Error::new(ErrorKind::TooLittleData)
            .key(key)
            .found(format!("no sample {self}; the file has {first} s to {last} s"))
            .expected("at least one sample in the time range of the run")
            .remedy("correct from_s and to_s of this [[run]], in seconds as the time column has them"))
    }
}

impl std::fmt::Display for TimeRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.from_s.is_finite(), self.to_s.is_finite()) {
            (true, true) => write!(f, "from {} s to before {} s", self.from_s, self.to_s),
            (true, false) => write!(f, "from {} s on", self.from_s),
            _ => write!(f, "before {} s", self.to_s),
        }
    }
}
