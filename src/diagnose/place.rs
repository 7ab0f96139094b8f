//! Where a gap lies: shares by place, phase, frequency, position and speed.

use super::json;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A share of the gap by name.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Share {
    /// Site, segment or phase.
    #[serde(alias = "site", alias = "segment", alias = "phase")]
    pub name: String,
    /// Share, 0 to 1.
    #[serde(deserialize_with = "json::number")]
    pub share: f64,
}

/// A share of the gap between two values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// From.
    pub from: f64,
    /// To.
    pub to: f64,
    /// Share, 0 to 1.
    #[serde(deserialize_with = "json::number")]
    pub share: f64,
}

/// Where the gap lies.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Where {
    /// By place on the signal path.
    pub site: Vec<Share>,
    /// By stretch of the signal path between two logged signals, with its residual as a force.
    pub segment: Vec<Share>,
    /// By phase of the motion.
    pub phase: Vec<Share>,
    /// By frequency.
    pub frequency_hz: Vec<Band>,
    /// By position, m or rad.
    pub position: Vec<Band>,
    /// By speed, m/s or rad/s.
    pub speed: Vec<Band>,
}

impl Serialize for Where {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let named = |key: &'static str, shares: &[Share]| -> Vec<BTreeMap<&'static str, serde_json::Value>> {
            shares
                .iter()
                .map(|s| BTreeMap::from([(key, s.name.clone().into()), ("share", s.share.into())]))
                .collect()
        };
        let mut map = serializer.serialize_struct("Where", 6)?;
        map.serialize_field("site", &named("site", &self.site))?;
        map.serialize_field("segment", &named("segment", &self.segment))?;
        map.serialize_field("phase", &named("phase", &self.phase))?;
        map.serialize_field("frequency_hz", &self.frequency_hz)?;
        map.serialize_field("position", &self.position)?;
        map.serialize_field("speed", &self.speed)?;
        map.end()
    }
}
