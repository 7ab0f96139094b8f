//! A fitted number.

use super::json;
use serde::{Deserialize, Serialize};

/// 97.5 % quantile of the normal distribution.
pub const NORMAL_975: f64 = 1.959_964;

/// A fitted number with its interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Estimate.
    #[serde(deserialize_with = "json::number")]
    pub value: f64,
    /// 95 % interval.
    #[serde(deserialize_with = "json::interval")]
    pub ci95: [f64; 2],
    /// Unit.
    pub unit: String,
    /// What the twin has instead.
    #[serde(deserialize_with = "json::number")]
    pub twin: f64,
}
