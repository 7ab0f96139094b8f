//! A named cause.

use super::parameter::Parameter;
use super::phase::RunPhase;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An effect that is named as a cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Cause {
    /// Effect id.
    pub effect: String,
    /// The group that it belongs to, where several effects are numbers of one thing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Its place on the signal path.
    #[serde(default)]
    pub site: String,
    /// Posterior probability that it acts.
    #[serde(default)]
    pub probability: f64,
    /// Share of the gap that it closes.
    #[serde(default)]
    pub closes: f64,
    /// Effects that could stand in its place on these data.
    #[serde(default)]
    pub confusable_with: Vec<String>,
    /// Why these data cannot tell them apart, as a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confusable_reason: Option<String>,
    /// Its parameters.
    #[serde(default)]
    pub parameters: BTreeMap<String, Parameter>,
    /// Amplitudes of its waves, each of a sine and a cosine among the parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub amplitudes: BTreeMap<String, Parameter>,
    /// Of a vibration from outside, its phase in each run, training runs first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<RunPhase>,
    /// Of what repeats along the axis, harmonics beyond those of its law; their amplitudes stand among the others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub harmonics: Vec<Harmonic>,
}

impl Cause {
    /// Whether the cause, or an effect that is reported as one with it, has a name.
    pub fn covers(&self, name: &str) -> bool {
        self.effect == name || self.confusable_with.iter().any(|other| other == name)
    }

    /// What an engineer asks for: amplitudes in the place of sines and cosines.
    pub fn told(&self) -> impl Iterator<Item = (&String, &Parameter)> {
        let of_wave = |key: &str| {
            let rest = key.strip_prefix("sine").or_else(|| key.strip_prefix("cosine"));
            rest.is_some_and(|rest| self.amplitudes.contains_key(&format!("amplitude{rest}")))
        };
        self.amplitudes.iter().chain(self.parameters.iter().filter(move |(key, _)| !of_wave(key)))
    }

    /// What it sets in a machine, by key path: its own parameters, then those of its harmonics.
    pub fn settings(&self) -> impl Iterator<Item = (String, &Parameter)> {
        let of = |effect: &str, parameters| {
            let path = format!("effect.{effect}.");
            BTreeMap::iter(parameters).map(move |(key, parameter)| (format!("{path}{key}"), parameter))
        };
        let harmonics = self.harmonics.iter().flat_map(move |h| of(&h.effect, &h.parameters));
        of(&self.effect, &self.parameters).chain(harmonics)
    }

    /// Every number: amplitudes, then parameters.
    pub fn numbers(&self) -> impl Iterator<Item = (&String, &Parameter)> {
        self.amplitudes.iter().chain(&self.parameters)
    }
}

/// A harmonic that the law with the pitch does not have: it is in the machine as a further pitch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Harmonic {
    /// Pitch over its period.
    pub order: u32,
    /// Effect that it is in the machine.
    pub effect: String,
    /// That effect's parameters.
    pub parameters: BTreeMap<String, Parameter>,
}
