//! `F1..F2` on the command line: a band of frequencies.

use std::str::FromStr;

/// Lowest and highest frequency in Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Band(pub(super) [f64; 2]);

impl FromStr for Band {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || {
            format!("`{text}` is not a band; write two frequencies in Hz, 0 < F1 < F2, for instance 5..300")
        };
        let (from, to) = text.split_once("..").ok_or_else(refused)?;
        let number = |part: &str| part.trim().parse::<f64>().ok().filter(|f| f.is_finite() && *f > 0.0);
        match (number(from), number(to)) {
            (Some(from), Some(to)) if from < to => Ok(Self([from, to])),
            _ => Err(refused()),
        }
    }
}
