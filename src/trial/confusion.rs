//! Which effect was named for which: the confusion matrix.

use super::judge::Judged;
use super::tier::Tier;
use serde::Serialize;
use std::collections::BTreeMap;

/// Counts of what was named first where one effect was hidden, by hidden effect.
///
/// An effect that is reported as confusable with the one named counts where it belongs: on the diagonal. The tiers of one
/// hidden effect and the null tier are in it; where no cause is named, the verdict stands in its place.
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

impl Confusion {
    /// Counts cases.
    pub fn of(cases: &[Judged]) -> Self {
        let order = |name: &str| {
            crate::effect::EffectId::ALL.iter().position(|e| e.name() == name).map_or(0, |place| place + 1)
        };
        let mut counts: BTreeMap<(usize, String), BTreeMap<String, usize>> = BTreeMap::new();
        let mut named: BTreeMap<(usize, String), ()> = BTreeMap::new();
        let mut unnamed: BTreeMap<String, ()> = BTreeMap::new();
        for case in cases.iter().filter(|case| case.tier != Tier::Outside && case.tier != Tier::Pair) {
            let hidden = case.hidden.first().copied().unwrap_or(NOTHING).to_owned();
            let first = match case.named.first() {
                _ if case.top_1 => hidden.clone(),
                Some(name) => name.clone(),
                None => format!("({})", case.verdict),
            };
            if first.starts_with('(') {
                unnamed.insert(first.clone(), ());
            } else {
                named.insert((order(&first), first.clone()), ());
            }
            *counts.entry((order(&hidden), hidden)).or_default().entry(first).or_default() += 1;
        }
        let rows: Vec<String> = counts.keys().map(|(_, name)| name.clone()).collect();
        for row in counts.keys() {
            named.insert(row.clone(), ());
        }
        let columns: Vec<String> =
            named.into_keys().map(|(_, name)| name).chain(unnamed.into_keys()).collect();
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
