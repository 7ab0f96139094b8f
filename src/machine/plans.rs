//! What commands do with a machine where nothing else is asked; nothing that the twin reads.

use super::bounds::{finite, positive, zero_or_more};
use crate::error::{Error, ErrorKind, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a cross-check replays.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrosscheckPlan {
    /// Strokes at feeds, `STROKE@FEED`: m at m/min, or rad at rad/s for a revolute axis.
    pub cells: Vec<String>,
}

/// How the controller is tuned.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TunePlan {
    /// Strokes at feeds; where there are none, those of the cross-check.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cells: Vec<String>,
    /// Numbers that are turned; where there are none, the gains that an operator turns first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<Vary>,
    /// Settings to be beaten, a number for each entry of `vary`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<Vec<f64>>,
    /// Bounds on criteria by their keys.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub limits: BTreeMap<String, f64>,
    /// Largest Coulomb friction that a setting must withstand, N or N·m.
    #[serde(alias = "friction_nm", skip_serializing_if = "Option::is_none")]
    pub friction_n: Option<f64>,
}

/// A number that is turned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// Key path.
    pub key: String,
    /// Smallest value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
    /// Step of the map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<f64>,
}

impl CrosscheckPlan {
    pub(super) fn check(&self) -> Result<()> {
        let fault = if self.cells.is_empty() { Some("no cell".to_owned()) } else { fault(&self.cells) };
        fault.map_or(Ok(()), |fault| Err(not_a_cell("crosscheck", fault)))
    }
}

impl TunePlan {
    pub(super) fn check(&self) -> Result<()> {
        fault(&self.cells).map_or(Ok(()), |fault| Err(not_a_cell("tune", fault)))?;
        self.friction_n.map_or(Ok(()), |friction| zero_or_more("tune.friction_n", friction))?;
        self.limits.iter().try_for_each(|(key, limit)| finite(&format!("tune.limits.{key}"), *limit))?;
        self.vary.iter().enumerate().try_for_each(|(place, vary)| vary.check(place))
    }
}

impl Vary {
    fn check(&self, place: usize) -> Result<()> {
        let key = |name: &str| format!("tune.vary.{place}.{name}");
        finite(&key("from"), self.from)?;
        finite(&key("to"), self.to)?;
        if self.from >= self.to {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key(key("to"))
                .found(format!("{} to {}", self.from, self.to))
                .expected("a range that ends above where it begins")
                .remedy("correct `from` or `to`"));
        }
        self.step.map_or(Ok(()), |step| positive(&key("step"), step))
    }
}

fn not_a_cell(table: &str, fault: String) -> Error {
    Error::new(ErrorKind::Syntax)
        .key(format!("{table}.cells"))
        .found(fault)
        .expected("strokes at feeds, STROKE@FEED: m@m/min, or rad@rad/s for a turning axis")
        .remedy(format!("write for instance cells = [\"0.02@8\"], or leave [{table}] out"))
}

/// The first cell that is not two numbers with an `@` between them.
fn fault(cells: &[String]) -> Option<String> {
    let is_right = |cell: &&String| {
        let numbers = cell.split_once('@').map(|(stroke, feed)| {
            [stroke, feed].map(|number| number.trim().parse::<f64>().unwrap_or(f64::NAN))
        });
        numbers.is_some_and(|[stroke, feed]| {
            stroke.is_finite() && stroke != 0.0 && feed.is_finite() && feed > 0.0
        })
    };
    cells.iter().find(|cell| !is_right(cell)).map(|cell| format!("`{cell}`"))
}
