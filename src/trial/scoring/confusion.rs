//! Which effect was named for which: the confusion matrix.

use super::judge::{Alarm, Judged};
use super::naming::Standing;
use crate::effect::EffectId;
use crate::trial::tier::Tier;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Counts of what was named first where one effect was hidden, by hidden effect.
///
/// In it are the cases with one planned effect of 1 σ or more, and the null cases, of every tier that leaves the catalogue whole.
/// An equal, or a group that the hidden effect is a member of, counts where it belongs: on the diagonal. Else the first
/// extra name counts; where there is none, the verdict stands in its place.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Confusion {
    /// What was hidden, in signal-path order, `nothing` first.
    pub rows: Vec<String>,
    /// What was named: the rows, then verdicts without causes.
    pub columns: Vec<String>,
    /// Counts, row by row.
    pub counts: Vec<Vec<usize>>,
}

const NOTHING: &str = "nothing";

/// What was hidden and whether it came out so; none where a case is not in the matrix.
fn hidden(case: &Judged) -> Option<(&'static str, bool)> {
    if case.tier == Tier::Outside {
        return None;
    }
    if let Some(alarm) = case.alarm {
        return Some((NOTHING, alarm == Alarm::Quiet));
    }
    let planned: Vec<_> = case.hidden.iter().filter(|h| h.planned).collect();
    let [one] = planned[..] else { return None };
    Some((one.effect, case.top_1?))
}

/// What was said in the place of what is hidden.
fn instead(case: &Judged) -> String {
    let extra = case.named.iter().find(|name| name.standing == Standing::Extra);
    extra.map_or_else(|| format!("({})", case.verdict), |name| name.effect.clone())
}

impl Confusion {
    /// Counts cases.
    pub fn of(cases: &[Judged]) -> Self {
        let order =
            |name: &str| EffectId::ALL.iter().position(|e| e.name() == name).map_or(0, |place| place + 1);
        let mut counts: BTreeMap<(usize, String), BTreeMap<String, usize>> = BTreeMap::new();
        let mut named: BTreeSet<(usize, String)> = BTreeSet::new();
        let mut unnamed: BTreeSet<String> = BTreeSet::new();
        for case in cases {
            let Some((hidden, is_right)) = hidden(case) else { continue };
            let first = if is_right { hidden.to_owned() } else { instead(case) };
            if first.starts_with('(') {
                unnamed.insert(first.clone());
            } else {
                named.insert((order(&first), first.clone()));
            }
            *counts.entry((order(hidden), hidden.to_owned())).or_default().entry(first).or_default() += 1;
        }
        let rows: Vec<String> = counts.keys().map(|(_, name)| name.clone()).collect();
        named.extend(counts.keys().cloned());
        let columns: Vec<String> = named.into_iter().map(|(_, name)| name).chain(unnamed).collect();
        let line = |row: &BTreeMap<String, usize>| {
            columns.iter().map(|column| row.get(column).copied().unwrap_or(0)).collect()
        };
        let counts = counts.values().map(line).collect();
        Self { rows, columns, counts }
    }

    /// How often something else was named than what was hidden, most often first.
    pub fn mistakes(&self) -> Vec<(&str, &str, usize)> {
        let mut mistakes: Vec<(&str, &str, usize)> = Vec::new();
        for (row, counts) in self.rows.iter().zip(&self.counts) {
            for (column, &count) in self.columns.iter().zip(counts) {
                if row != column && count > 0 {
                    mistakes.push((row, column, count));
                }
            }
        }
        mistakes.sort_by_key(|mistake| std::cmp::Reverse(mistake.2));
        mistakes
    }
}
