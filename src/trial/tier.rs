//! The tiers of a trial: what is hidden, and what the diagnosis is given.

use crate::error::{Error, ErrorKind};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// A tier.
///
/// In every tier the nominal parameters are a little off, inside their tolerances, as on real machines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Tier {
    /// Nothing hidden: any cause named is a false alarm.
    Null,
    /// One effect.
    Single,
    /// Two effects that can act beside each other.
    Pair,
    /// Three effects that can act beside one another.
    Triple,
    /// What no law of the catalogue describes: foreign to all of it, or one effect, struck from the catalogue together with those that contain it, are its equal or stand in for it.
    Outside,
    /// One effect beside nominal parameters that are all off together by a third of their tolerance.
    Poor,
    /// One effect, and no current, no effort or no velocity logged.
    Missing,
    /// Two recordings of one machine, the reference and a later one, between which one effect came or changed. Half of these
    /// machines differ from their twin in the reference already.
    Change,
}

impl Tier {
    /// Every tier.
    pub const ALL: [Self; 8] = [
        Self::Null,
        Self::Single,
        Self::Pair,
        Self::Triple,
        Self::Outside,
        Self::Poor,
        Self::Missing,
        Self::Change,
    ];

    /// The word on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Triple => "triple",
            Self::Outside => "outside",
            Self::Poor => "poor",
            Self::Missing => "missing",
            Self::Change => "change",
        }
    }

    /// Cases where no number is asked for, with so many effects that can be forged.
    pub fn cases(self, effects: usize) -> usize {
        match self {
            Self::Null => 300,
            Self::Pair | Self::Triple => 40,
            Self::Single => 5 * effects,
            Self::Outside | Self::Poor | Self::Missing | Self::Change => effects,
        }
    }

    /// Effects that one case hides.
    pub fn effects(self) -> usize {
        match self {
            Self::Null => 0,
            Self::Pair => 2,
            Self::Triple => 3,
            _ => 1,
        }
    }
}

impl fmt::Display for Tier {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Tier {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|tier| tier.name() == text).ok_or_else(|| {
            Error::new(ErrorKind::OutOfRange)
                .key("tier")
                .found(format!("`{text}`"))
                .expected(Self::ALL.map(Self::name).join(", "))
                .remedy("correct its name")
        })
    }
}
