//! The bars that a trial must reach.

use super::score::Summary;
use super::tier::Tier;
use serde::Serialize;

/// One bar and whether it was reached.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bar {
    /// Tier that it is for.
    pub tier: Tier,
    /// What is measured.
    pub name: &'static str,
    /// What was measured; none where there was nothing to measure.
    pub value: Option<f64>,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// The bar.
    pub bar: f64,
    /// Whether less is better.
    pub at_most: bool,
    /// Of how many cases.
    pub of: usize,
}

impl Bar {
    /// Whether the measured value reaches the bar; none where nothing was measured.
    pub fn is_reached(&self) -> Option<bool> {
        self.value.map(|value| if self.at_most { value <= self.bar } else { value >= self.bar })
    }
}

/// Best published mean probability on the true cause where it is isolated on a driving cycle that was not seen before.
pub const BEST_PUBLIC_PROBABILITY: f64 = 0.662;

const TOP_1: f64 = 0.90;
const TOP_2: f64 = 0.97;
const PROBABILITY: f64 = 0.85;
const FALSE_ALARMS: f64 = 0.02;
const BOTH_NAMED: f64 = 0.75;
const FLAGGED: f64 = 0.80;
const CLOSED: f64 = 0.95;
const PREDICTED: f64 = 0.90;

/// The bars of the tiers that were tried.
pub fn bars(summaries: &[Summary]) -> Vec<Bar> {
    let mut bars = Vec::new();
    for s in summaries {
        let mut rate = |name, rate: super::interval::Rate, bar, at_most| {
            bars.push(Bar {
                tier: s.tier,
                name,
                value: rate.value,
                ci95: rate.ci95,
                bar,
                at_most,
                of: rate.of,
            });
        };
        match s.tier {
            Tier::Null => rate("false alarms", s.false_alarms, FALSE_ALARMS, true),
            Tier::Single => {
                rate("top-1", s.top_1, TOP_1, false);
                rate("top-2", s.top_2, TOP_2, false);
            }
            Tier::Pair => rate("both named", s.all_named, BOTH_NAMED, false),
            Tier::Outside => rate("flagged unknown or undecided", s.flagged, FLAGGED, false),
            Tier::Triple | Tier::Poor | Tier::Missing | Tier::Change => {}
        }
        if s.tier == Tier::Single {
            rate("predicted within ±0.1 of achieved", s.predicted_within, PREDICTED, false);
            let mut level = |name, level: super::interval::Level, bar| {
                bars.push(Bar {
                    tier: s.tier,
                    name,
                    value: level.value,
                    ci95: level.ci95,
                    bar,
                    at_most: false,
                    of: level.of,
                });
            };
            level("mean probability on the true cause", s.probability, PROBABILITY);
            level("median share of the gap closed", s.closed, CLOSED);
        }
    }
    bars
}
