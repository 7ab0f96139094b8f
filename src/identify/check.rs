//! What every identifier asks of its signals before it looks at them.

use crate::error::{Error, ErrorKind, Result};

/// Refuses NaN and infinity, naming the signal and the sample.
pub(super) fn finite(key: &str, samples: &[f64]) -> Result<()> {
    match samples.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(k) => Err(Error::new(ErrorKind::NotFinite)
            .key(key)
            .found(format!("{} at sample {k} (counted from 0)", samples[k]))
            .expected("finite numbers")
            .remedy("cut the run there or repair the recording")),
    }
}

/// Refuses two signals of one run that differ in length.
pub(super) fn same_length(key: &str, samples: &[f64], other_key: &str, other: &[f64]) -> Result<()> {
    if samples.len() == other.len() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .key(key)
        .found(format!("{} samples, but `{other_key}` has {}", samples.len(), other.len()))
        .expected("as many samples in every signal of a run")
        .remedy("record the signals on one time base"))
}

/// Refuses a sample period that is not a finite positive number.
pub(super) fn sample_period(sample_period_s: f64) -> Result<()> {
    if sample_period_s.is_finite() && sample_period_s > 0.0 {
        return Ok(());
    }
    Err(Error::new(ErrorKind::OutOfRange)
        .key("sample_period_s")
        .found(sample_period_s.to_string())
        .expected("a finite number of seconds > 0")
        .remedy("state the sample period in seconds"))
}

/// Refuses fewer rows than `least`, which the caller derives from the number of parameters.
pub(super) fn enough_rows(rows: usize, least: usize, parameters: usize) -> Result<()> {
    if rows >= least {
        return Ok(());
    }
    Err(Error::new(ErrorKind::TooLittleData)
        .found(format!("{rows} usable samples for {parameters} parameters"))
        .expected(format!("at least {least}"))
        .remedy("record longer runs or ask for lower orders"))
}
