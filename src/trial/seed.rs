//! Seeds, those for developing kept apart from those for judging.

use crate::error::{Error, ErrorKind, Result};
use crate::replay::run_seed;
use rand::SeedableRng;
use rand::rngs::StdRng;
use std::fmt;

/// The seed of a trial, and what its score may be used for.
///
/// A trial that was looked at while the diagnosis was being changed says nothing of the diagnosis afterwards. Seeds below
/// [`Seed::DEVELOPMENT_END`] are for that; those from [`Seed::JUDGING_FROM`] on are for judging, once.
///
/// ```
/// use slideway::trial::Seed;
/// assert!(matches!(Seed::new(7)?, Seed::Development(7)));
/// assert!(matches!(Seed::new(1_000_007)?, Seed::Judging(1_000_007)));
/// assert!(Seed::new(5_000).is_err());
/// # Ok::<(), slideway::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seed {
    /// Below 1000: trials that may be looked at while the diagnosis is being changed.
    Development(u64),
    /// From 1 000 000 on: trials whose score counts.
    Judging(u64),
}

impl Seed {
    /// Development seeds lie below this.
    pub const DEVELOPMENT_END: u64 = 1_000;
    /// Judging seeds begin here.
    pub const JUDGING_FROM: u64 = 1_000_000;

    /// The seed of a number.
    ///
    /// # Errors
    /// A number between the two ranges, or beyond what a trial file can hold.
    pub fn new(number: u64) -> Result<Self> {
        if number < Self::DEVELOPMENT_END {
            return Ok(Self::Development(number));
        }
        if (Self::JUDGING_FROM..=i64::MAX as u64).contains(&number) {
            return Ok(Self::Judging(number));
        }
        Err(Error::new(ErrorKind::OutOfRange)
            .key("seed")
            .found(number.to_string())
            .expected(format!(
                "a development seed below {} or a judging seed from {} on",
                Self::DEVELOPMENT_END,
                Self::JUDGING_FROM
            ))
            .remedy("develop with the small ones; judge once with a large one"))
    }

    /// The number.
    pub fn number(self) -> u64 {
        match self {
            Self::Development(number) | Self::Judging(number) => number,
        }
    }

    /// `development` or `judging`.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Development(_) => "development",
            Self::Judging(_) => "judging",
        }
    }

    /// Random numbers for one purpose: they depend on the seed and the purpose's name only.
    pub fn random(self, purpose: &str) -> StdRng {
        StdRng::seed_from_u64(self.derived(purpose))
    }

    /// A number for one purpose.
    pub fn derived(self, purpose: &str) -> u64 {
        run_seed(self.number(), purpose)
    }
}

impl fmt::Display for Seed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.number(), self.kind())
    }
}
