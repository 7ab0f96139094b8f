//! How long a machine is to stand still, on the command line.

/// Longest standstill that may be asked for, in s.
const LONGEST_S: f64 = 3600.0;

/// Seconds of a standstill that there need not be.
pub(super) fn standstill(text: &str) -> Result<f64, String> {
    read(text).filter(|s| (0.0..=LONGEST_S).contains(s)).ok_or_else(|| refused("from 0"))
}

/// Seconds of a standstill that there must be.
pub(super) fn some_standstill(text: &str) -> Result<f64, String> {
    read(text).filter(|s| *s > 0.0 && *s <= LONGEST_S).ok_or_else(|| refused("above 0"))
}

fn read(text: &str) -> Option<f64> {
    text.parse().ok()
}

fn refused(from: &str) -> String {
    format!("expected a number of seconds {from} to {LONGEST_S}")
}
