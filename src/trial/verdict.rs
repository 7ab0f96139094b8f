//! A verdict as its JSON says it: the part that is scored.

use crate::error::{Error, ErrorKind, Result};
use serde::Deserialize;
use std::collections::BTreeMap;

/// What a verdict comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Came {
    /// The twin is as good as noise allows.
    NoGap,
    /// Causes are named.
    Cause,
    /// Several explanations are left.
    Undecided,
    /// No effect of the catalogue explains the gap.
    Unknown,
    /// The recording was refused.
    Refused,
}

impl Came {
    /// The word of the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoGap => "no_gap",
            Self::Cause => "cause",
            Self::Undecided => "undecided",
            Self::Unknown => "unknown",
            Self::Refused => "refused",
        }
    }
}

/// The scored part of `slideway-diagnosis/1`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Said {
    /// What it comes to.
    pub verdict: Came,
    /// The causes, most closing first.
    #[serde(default)]
    pub causes: Vec<Cause>,
    /// Probability of every effect, most probable first.
    #[serde(default)]
    pub effects: Vec<Probability>,
    /// Explanations, most probable first.
    #[serde(default)]
    pub ranking: Vec<Explanation>,
    /// How far the gap shrinks.
    #[serde(default)]
    pub gap: Gap,
    /// Where it lies.
    #[serde(default, rename = "where")]
    pub place: Place,
}

/// A named cause.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Cause {
    /// Effect id.
    pub effect: String,
    /// Its site.
    #[serde(default)]
    pub site: String,
    /// Probability that it acts.
    #[serde(default)]
    pub probability: f64,
    /// Effects that could stand in its place.
    #[serde(default)]
    pub confusable_with: Vec<String>,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, Number>,
}

impl Cause {
    /// Whether the cause, or an effect that is reported as one with it, has a name.
    pub fn covers(&self, name: &str) -> bool {
        self.effect == name || self.confusable_with.iter().any(|other| other == name)
    }
}

/// A fitted number.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Number {
    /// Estimate.
    pub value: f64,
    /// 95 % interval.
    pub ci95: [Option<f64>; 2],
}

/// Probability of an effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Probability {
    /// Effect id.
    pub effect: String,
    /// Probability that it acts.
    pub probability: f64,
}

/// An explanation of the ranking.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Explanation {
    /// Its effects.
    pub effects: Vec<String>,
    /// Its probability.
    pub probability: f64,
}

/// The scored part of the gap.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Gap {
    /// G of the twin as it is.
    #[serde(default)]
    pub before: f64,
    /// G with the causes.
    #[serde(default)]
    pub after: f64,
    /// Share closed.
    #[serde(default)]
    pub closed: f64,
    /// Share that was predicted to be closed.
    #[serde(default)]
    pub predicted_closed: f64,
}

/// The scored part of the place.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub struct Place {
    /// Shares by site.
    #[serde(default)]
    pub site: Vec<SiteShare>,
}

/// A site's share.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct SiteShare {
    /// The site.
    pub site: String,
    /// Its share.
    pub share: f64,
}

impl Said {
    /// Reads a verdict.
    ///
    /// # Errors
    /// Text that is no verdict.
    pub fn parse(text: &[u8]) -> Result<Self> {
        serde_json::from_slice(text).map_err(|error| {
            Error::new(ErrorKind::Syntax)
                .found(error.to_string())
                .expected("a verdict of the schema slideway-diagnosis/1")
                .remedy("delete it and run the trial again")
        })
    }

    /// The verdict on a recording that the diagnosis refused, as JSON.
    pub fn refusal(error: &Error) -> String {
        let value = serde_json::json!({
            "schema": "slideway-diagnosis/1", "verdict": "refused", "error": error.to_string(),
        });
        format!("{value:#}\n")
    }

    /// Probability that an effect acts.
    pub fn probability(&self, effect: &str) -> f64 {
        self.effects.iter().find(|e| e.effect == effect).map_or(0.0, |e| e.probability)
    }
}
