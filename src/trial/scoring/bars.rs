//! The bars that a trial must reach.

use super::interval::{Level, Rate};
use super::judge::{Alarm, Judged};
use super::size::{FLOOR, MUST};
use crate::trial::tier::Tier;
use serde::Serialize;
use std::fmt;

/// Null cases that it takes to say anything about a false alarm in a hundred.
pub const NULL_CASES: usize = 300;

const NAMED_FIRST: f64 = 0.95;
const NAMED_ALONE: f64 = 0.85;
const BOTH_NAMED: f64 = 0.80;
const THREE_NAMED: f64 = 0.60;
const FALSE_ALARMS: f64 = 0.01;
const FLAGGED: f64 = 0.90;
const CHANGE_NAMED: f64 = 0.90;
const CONFIDENT_WRONG: f64 = 0.01;
const COVERED: (f64, f64) = (0.90, 0.99);
/// What sums of shares lose to rounding.
const ROUNDING: f64 = 1e-12;

/// What is asked of a measured share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// At least so much.
    AtLeast(f64),
    /// At most so much.
    AtMost(f64),
    /// Between these, both included.
    Between(f64, f64),
}

impl Limit {
    /// Whether a value keeps it.
    pub fn holds(self, value: f64) -> bool {
        let (least, most) = match self {
            Self::AtLeast(least) => (least, f64::INFINITY),
            Self::AtMost(most) => (f64::NEG_INFINITY, most),
            Self::Between(least, most) => (least, most),
        };
        value >= least - ROUNDING && value <= most + ROUNDING
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: &f64| format!("{:.0}", 100.0 * share);
        match self {
            Self::AtLeast(least) => write!(f, "≥ {} %", percent(least)),
            Self::AtMost(most) => write!(f, "≤ {} %", percent(most)),
            Self::Between(least, most) => write!(f, "{}–{} %", percent(least), percent(most)),
        }
    }
}

/// What a bar came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The measured value keeps it.
    Passed,
    /// It does not.
    Missed,
    /// It does, but of fewer cases than the bar asks for: neither passed nor missed.
    NotEnoughCases,
    /// There was no such case.
    NotMeasured,
}

impl Outcome {
    /// The words of a table.
    pub fn words(self) -> &'static str {
        match self {
            Self::Passed => "pass",
            Self::Missed => "MISS",
            Self::NotEnoughCases => "not enough cases",
            Self::NotMeasured => "not measured",
        }
    }
}

/// One bar and what was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bar {
    /// What is measured.
    pub name: &'static str,
    /// What is asked.
    pub limit: Limit,
    /// Cases that it takes.
    pub needs: usize,
    /// What was measured; none where there was nothing to measure.
    pub value: Option<f64>,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Of how many cases.
    pub of: usize,
    /// What it came to.
    pub outcome: Outcome,
}

impl Bar {
    fn of_rate(name: &'static str, limit: Limit, needs: usize, rate: Rate) -> Self {
        Self::of_level(name, limit, needs, Level { value: rate.value, ci95: rate.ci95, of: rate.of })
    }

    fn of_level(name: &'static str, limit: Limit, needs: usize, level: Level) -> Self {
        let Level { value, ci95, of } = level;
        let outcome = match value.map(|value| limit.holds(value)) {
            None => Outcome::NotMeasured,
            Some(false) => Outcome::Missed,
            Some(true) if of < needs => Outcome::NotEnoughCases,
            Some(true) => Outcome::Passed,
        };
        Self { name, limit, needs, value, ci95, of, outcome }
    }
}

/// Every bar, in one order.
///
/// Those of one effect, of pairs, of triples and of changes count cases whose planned effects are all of 3 σ or more; that of
/// the tier outside counts cases of 1 σ or more.
pub fn bars(cases: &[Judged]) -> Vec<Bar> {
    let at_least = |name, share, rate| Bar::of_rate(name, Limit::AtLeast(share), 1, rate);
    vec![
        at_least("single from 3 σ: named first", NAMED_FIRST, rate(cases, Tier::Single, |c| c.top_1)),
        at_least("single from 3 σ: all named, nothing extra", NAMED_ALONE, rate(cases, Tier::Single, alone)),
        at_least("pair from 3 σ: both named", BOTH_NAMED, rate(cases, Tier::Pair, |c| c.planned_named)),
        at_least(
            "triple from 3 σ: all three named",
            THREE_NAMED,
            rate(cases, Tier::Triple, |c| c.planned_named),
        ),
        Bar::of_rate("null: false alarms", Limit::AtMost(FALSE_ALARMS), NULL_CASES, false_alarms(cases)),
        at_least("outside: unknown or undecided", FLAGGED, flagged(cases)),
        at_least("change from 3 σ: named, nothing extra", CHANGE_NAMED, changes(cases)),
        Bar::of_rate("confident wrong names, all cases", Limit::AtMost(CONFIDENT_WRONG), 1, confident(cases)),
        Bar::of_level(
            "95 % intervals that hold the truth",
            Limit::Between(COVERED.0, COVERED.1),
            1,
            Level::mean(&cases.iter().filter_map(|case| case.covered).collect::<Vec<f64>>()),
        ),
    ]
}

/// Whether everything is named that must be, and nothing extra.
fn alone(case: &Judged) -> Option<bool> {
    case.all_named.map(|all_named| all_named && case.extra == 0)
}

/// Counts over the cases of a tier whose planned effects must all be named.
fn rate(cases: &[Judged], tier: Tier, holds: impl Fn(&Judged) -> Option<bool>) -> Rate {
    Rate::count(of_size(cases, tier, MUST).filter_map(holds))
}

fn of_size(cases: &[Judged], tier: Tier, least: f64) -> impl Iterator<Item = &Judged> {
    cases.iter().filter(move |case| case.tier == tier && case.size.is_some_and(|size| size >= least))
}

fn false_alarms(cases: &[Judged]) -> Rate {
    Rate::count(cases.iter().filter_map(|case| case.alarm).map(|alarm| alarm != Alarm::Quiet))
}

fn flagged(cases: &[Judged]) -> Rate {
    Rate::count(of_size(cases, Tier::Outside, FLOOR).map(|case| case.flagged))
}

fn changes(cases: &[Judged]) -> Rate {
    rate(cases, Tier::Change, |case| Some(case.is_right()))
}

fn confident(cases: &[Judged]) -> Rate {
    Rate::count(cases.iter().map(|case| case.confident_wrong().next().is_some()))
}
