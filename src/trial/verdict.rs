//! A verdict on a case: a diagnosis, or that the recording was refused.

use crate::diagnose::Diagnosis;
use crate::diagnose::place::Share;
use crate::diagnose::verdict::{Cause, EffectProbability, Ranked, SCHEMA, Verdict};
use crate::error::{Error, ErrorKind, Result};
use serde::Deserialize;

/// The word of a refusal in the place of a verdict.
pub const REFUSED: &str = "refused";

/// What was said of a case.
#[derive(Debug, Clone, PartialEq)]
pub enum Said {
    /// A diagnosis.
    Diagnosed(Box<Diagnosis>),
    /// The recording was refused.
    Refused,
}

/// The word that tells a refusal from a diagnosis.
#[derive(Deserialize)]
struct Word {
    verdict: String,
}

impl Said {
    /// Reads a verdict.
    ///
    /// # Errors
    /// Text that is no verdict.
    pub fn parse(text: &[u8]) -> Result<Self> {
        let read = || -> serde_json::Result<Self> {
            let Word { verdict } = serde_json::from_slice(text)?;
            if verdict == REFUSED {
                return Ok(Self::Refused);
            }
            serde_json::from_slice(text).map(|diagnosis| Self::Diagnosed(Box::new(diagnosis)))
        };
        read().map_err(|error| {
            Error::new(ErrorKind::Syntax)
                .found(error.to_string())
                .expected(format!("a verdict of the schema {SCHEMA}"))
                .remedy("delete it and run the trial again")
        })
    }

    /// The verdict on a recording that the diagnosis refused, as JSON.
    pub fn refusal(error: &Error) -> String {
        let value = serde_json::json!({ "schema": SCHEMA, "verdict": REFUSED, "error": error.to_string() });
        format!("{value:#}\n")
    }

    /// The diagnosis; none where the recording was refused.
    pub fn diagnosis(&self) -> Option<&Diagnosis> {
        match self {
            Self::Diagnosed(diagnosis) => Some(diagnosis),
            Self::Refused => None,
        }
    }

    /// What it comes to; none where the recording was refused.
    pub fn verdict(&self) -> Option<Verdict> {
        self.diagnosis().map(|diagnosis| diagnosis.verdict)
    }

    /// The word of the JSON.
    pub fn name(&self) -> &'static str {
        self.verdict().map_or(REFUSED, Verdict::name)
    }

    /// Whether the recording was refused.
    pub fn is_refused(&self) -> bool {
        matches!(self, Self::Refused)
    }

    /// The causes, most closing first.
    pub fn causes(&self) -> &[Cause] {
        self.diagnosis().map_or(&[], |diagnosis| &diagnosis.causes)
    }

    /// Probability of every effect, most probable first.
    pub fn effects(&self) -> &[EffectProbability] {
        self.diagnosis().map_or(&[], |diagnosis| &diagnosis.effects)
    }

    /// Explanations, most probable first.
    pub fn ranking(&self) -> &[Ranked] {
        self.diagnosis().map_or(&[], |diagnosis| &diagnosis.ranking)
    }

    /// Shares of the gap by site.
    pub fn sites(&self) -> &[Share] {
        self.diagnosis().map_or(&[], |diagnosis| &diagnosis.place.site)
    }

    /// G before and after; nothing where the recording was refused.
    pub fn gap(&self) -> [f64; 2] {
        self.diagnosis().map_or([0.0; 2], |diagnosis| [diagnosis.gap.before, diagnosis.gap.after])
    }

    /// Shares of the gap closed, and predicted to be closed.
    pub fn closed(&self) -> [f64; 2] {
        self.diagnosis().map_or([0.0; 2], |diagnosis| [diagnosis.gap.closed, diagnosis.gap.predicted_closed])
    }
}
