//! Where identified values of a machine file come from.

use super::Machine;
use serde::{Deserialize, Serialize};

/// One diagnosis that wrote values into a machine file: `[[provenance]]`, the newest last.
///
/// The twin does not read it; people and later diagnoses do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// SHA-256 of the recording that was diagnosed.
    pub recording_sha256: String,
    /// Runs that the values were fitted to.
    pub training: Vec<String>,
    /// Runs that judged them.
    pub held_out: Vec<String>,
    /// Gap G on the held-out runs before, in units of noise.
    pub gap_before: f64,
    /// Gap G with these values.
    pub gap_after: f64,
    /// Closed share of the gap.
    pub closed: f64,
    /// Its 95 % interval.
    pub closed_ci95: [f64; 2],
    /// Version of the program.
    pub version: String,
    /// The values.
    pub value: Vec<Identified>,
}

/// A value that a diagnosis identified.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Identified {
    /// Key path.
    pub path: String,
    /// Estimate, as it stands at the key path.
    pub value: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// Unit.
    pub unit: String,
    /// What the machine had before; absent where it had nothing like it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<f64>,
    /// Why it was changed.
    pub reason: Reason,
}

/// Why a value was changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// It belongs to an effect named as a cause.
    Cause,
    /// A stated constant, moved inside its tolerance.
    Calibration,
}

impl Machine {
    /// The value that was stated at a key path before any diagnosis changed it: `None` where none did, `Some(None)` where
    /// nothing was stated.
    pub fn stated_before(&self, path: &str) -> Option<Option<f64>> {
        let mut values = self.description().provenance.iter().flat_map(|step| &step.value);
        values.find(|value| value.path == path).map(|value| value.before)
    }

    /// A known setting on top of what diagnoses identified: a weight of 5 kg bolted to a machine whose moving mass was
    /// found to be 0.3 kg off is a payload of 5.3 kg. Settings of values that no diagnosis changed are left as they are.
    pub fn on_top(&self, path: &str, setting: toml::Value) -> toml::Value {
        let known = setting.as_float().or_else(|| setting.as_integer().map(|n| n as f64));
        match (known, self.stated_before(path), self.number(path)) {
            (Some(known), Some(before), Some(now)) => (now + (known - before.unwrap_or(0.0))).into(),
            _ => setting,
        }
    }
}
