//! A number of the draft and where it comes from.

use crate::identify::least_squares::Estimate;

/// Where a number comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Found in the log.
    Measured,
    /// By a flag or a rule that the words name.
    Assumed,
    /// Not known: it stands as a comment.
    Missing,
}

impl Mark {
    /// The word in file and table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Assumed => "assumed",
            Self::Missing => "missing",
        }
    }
}

/// A line of the machine file.
#[derive(Debug, Clone, PartialEq)]
pub struct Item {
    /// The table it stands in; empty for the head.
    pub table: &'static str,
    /// Its key.
    pub key: &'static str,
    /// Its value as TOML; none where it is missing.
    pub value: Option<String>,
    /// Unit of the value.
    pub unit: &'static str,
    /// Whether it was measured.
    pub mark: Mark,
    /// Its interval, or the flag or rule it comes from.
    pub words: String,
}

impl Item {
    /// A number with its interval.
    pub fn measured(table: &'static str, key: &'static str, unit: &'static str, found: &Estimate) -> Self {
        let value = Some(digits(found.value, found.standard_error));
        Self { table, key, value, unit, mark: Mark::Measured, words: interval(found, unit) }
    }

    /// A number that is taken.
    pub fn assumed(
        table: &'static str,
        key: &'static str,
        unit: &'static str,
        value: impl std::fmt::Display,
        words: impl Into<String>,
    ) -> Self {
        Self { table, key, value: Some(value.to_string()), unit, mark: Mark::Assumed, words: words.into() }
    }

    /// A number that nobody knows.
    pub fn missing(
        table: &'static str,
        key: &'static str,
        unit: &'static str,
        words: impl Into<String>,
    ) -> Self {
        Self { table, key, value: None, unit, mark: Mark::Missing, words: words.into() }
    }

    /// With something behind its words.
    #[must_use]
    pub fn and(mut self, more: &str) -> Self {
        self.words = if self.words.is_empty() { more.to_owned() } else { format!("{}; {more}", self.words) };
        self
    }
}

/// The 95 % interval in words.
pub fn interval(found: &Estimate, unit: &str) -> String {
    let [from, to] = found.ci95.map(|end| digits(end, found.standard_error));
    format!("95 % {from} to {to} {unit}").trim_end().to_owned()
}

/// A number to two digits of its standard error, at most nine of its own.
pub fn digits(value: f64, standard_error: f64) -> String {
    /// Digits of a number without an error.
    const MOST: i32 = 9;
    if value == 0.0 || !value.is_finite() {
        return "0.0".to_owned();
    }
    let own = value.abs().log10().floor() as i32;
    let last = if standard_error > 0.0 { standard_error.log10().floor() as i32 - 1 } else { own - MOST + 1 };
    let last = last.clamp(own - MOST + 1, own.max(last.min(own)));
    let count = (own - last).max(0) as usize;
    let rounded: f64 = format!("{value:.count$e}").parse().unwrap_or(value);
    let is_plain = (1e-3..1e6).contains(&rounded.abs());
    match is_plain {
        true => format!("{rounded:?}"),
        false => format!("{rounded:e}"),
    }
}

/// A number as TOML has it.
pub fn toml_number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{value:?}")
    }
}

#[cfg(test)]
mod tests {
    use super::digits;

    #[test]
    fn exact_digits_follow_the_standard_error() {
        for (value, error, text) in [
            (44.651_376, 0.03, "44.651"),
            (44.651_376, 3.0, "44.7"),
            (83.1, 0.0, "83.1"),
            (1.234_567e-7, 1e-9, "1.235e-7"),
            (12.0, 500.0, "10.0"),
            (0.0, 1.0, "0.0"),
        ] {
            assert_eq!(digits(value, error), text, "{value} ± {error}");
        }
    }
}
