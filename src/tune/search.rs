//! The map of settings, and the search from its best.

use super::{Bench, Criterion, Knob, Setting, Tuning};
use crate::error::Result;
use std::collections::HashSet;

/// Settings of a map at most.
const MOST_SETTINGS: f64 = 3600.0;
/// Objectives within this share of the least are nearly as good.
const NEARLY: f64 = 0.1;
/// Settings that are re-checked at most.
const MOST_CANDIDATES: usize = 64;
/// Steps of the search at most.
const MOST_ROUNDS: usize = 200;

/// What is made small among settings that keep the limits: the mean over the strokes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Objective {
    /// Settling time.
    #[default]
    SettlingTime,
    /// Following error.
    FollowingError,
    /// Peak thrust.
    PeakThrust,
}

impl Objective {
    /// The criterion whose mean it is.
    pub fn criterion(self) -> Criterion {
        match self {
            Self::SettlingTime => Criterion::SettlingTime,
            Self::FollowingError => Criterion::FollowingError,
            Self::PeakThrust => Criterion::PeakThrust,
        }
    }
}

/// Every setting of a grid.
#[derive(Debug, Clone)]
pub struct Map {
    /// Values of each knob.
    pub values: Vec<Vec<f64>>,
    /// The settings, the last knob fastest.
    pub settings: Vec<Setting>,
}

impl Map {
    /// Settings that a map holds at most.
    pub const MOST: usize = MOST_SETTINGS as usize;

    /// Knobs with their step in the map where that is wider than asked for.
    pub fn widened<'k>(&self, knobs: &'k [Knob]) -> Vec<(&'k Knob, f64)> {
        widened(knobs, &self.values)
    }
}

fn widened<'k>(knobs: &'k [Knob], values: &[Vec<f64>]) -> Vec<(&'k Knob, f64)> {
    let step = |values: &[f64]| values.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let pairs = knobs.iter().zip(values).map(|(knob, values)| (knob, step(values)));
    pairs.filter(|(knob, step)| *step > knob.step * (1.0 + 1e-9)).collect()
}

/// Values of each knob such that there are not too many settings in all.
pub(super) fn grid(knobs: &[Knob]) -> Vec<Vec<f64>> {
    let most = MOST_SETTINGS.powf(1.0 / knobs.len().max(1) as f64).floor().max(2.0);
    let values = |knob: &Knob| {
        let range = knob.to - knob.from;
        let coarsest = range / (most - 1.0);
        let step = if range / knob.step + 1.0 <= most + 1e-9 {
            knob.step
        } else if knob.is_integer {
            coarsest.ceil()
        } else {
            coarsest
        };
        let count = (range / step + 1e-9).floor() as usize;
        let mut values: Vec<f64> = (0..=count).map(|k| knob.inside(knob.from + k as f64 * step)).collect();
        values.dedup();
        values
    };
    knobs.iter().map(values).collect()
}

/// Every combination, the last knob fastest.
fn combinations(values: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let joined = |all: Vec<Vec<f64>>, knob: &Vec<f64>| {
        all.iter().flat_map(|begun| knob.iter().map(move |v| [&begun[..], &[*v]].concat())).collect()
    };
    values.iter().fold(vec![Vec::new()], joined)
}

/// A search of a tuning.
pub(super) struct Search<'a> {
    pub tuning: &'a Tuning,
    pub bench: &'a Bench<'a>,
    pub marks: &'a [Setting],
}

impl Search<'_> {
    /// The map, the best setting, and how many were looked at.
    pub fn run(&self, each: &(impl Fn(usize) + Sync)) -> Result<(Map, Setting, usize)> {
        let values = grid(&self.tuning.knobs);
        let settings = self.bench.measure(&combinations(&values), each)?;
        let steps: Vec<f64> = self
            .tuning
            .knobs
            .iter()
            .zip(&values)
            .map(|(knob, v)| if v.len() > 1 { v[1] - v[0] } else { knob.finest() })
            .collect();
        let mut best: Option<Setting> = None;
        for setting in settings.iter().chain(self.marks) {
            self.take(&mut best, setting);
        }
        let mut looked_at = settings.len() + self.marks.len() + 1;
        let map = Map { values, settings };
        let Some(start) = best else { return Err(super::no_setting(self.bench.machine())) };
        let best = self.refine(start, steps, &mut looked_at, each)?;
        Ok((map, best, looked_at))
    }

    /// Compass search: every knob a step to each side, halved where none is better.
    fn refine(
        &self,
        start: Setting,
        mut steps: Vec<f64>,
        looked_at: &mut usize,
        each: &(impl Fn(usize) + Sync),
    ) -> Result<Setting> {
        let knobs = &self.tuning.knobs;
        let mut known: HashSet<Vec<u64>> = HashSet::new();
        let mut best = start;
        for _ in 0..MOST_ROUNDS {
            let beside = neighbours(knobs, &best.values, &steps);
            let fresh: Vec<Vec<f64>> = beside
                .into_iter()
                .filter(|values| known.insert(values.iter().map(|v| v.to_bits()).collect()))
                .collect();
            *looked_at += fresh.len();
            let before = best.values.clone();
            let mut kept = Some(best);
            for setting in &self.bench.measure(&fresh, each)? {
                self.take(&mut kept, setting);
            }
            best = match kept {
                Some(kept) => kept,
                None => return Err(super::no_setting(self.bench.machine())),
            };
            if best.values != before {
                continue;
            }
            let is_finest = steps.iter().zip(knobs).all(|(step, knob)| *step <= knob.finest());
            if is_finest {
                break;
            }
            for (step, knob) in steps.iter_mut().zip(knobs) {
                let half = 0.5 * *step;
                *step = if knob.is_integer { half.round().max(1.0) } else { half.max(knob.finest()) };
            }
        }
        Ok(best)
    }

    /// Keeps the better of two settings.
    fn take(&self, best: &mut Option<Setting>, setting: &Setting) {
        let is_better = best.as_ref().is_none_or(|best| {
            let (a, b) = (self.rank(setting), self.rank(best));
            let order = a.iter().zip(&b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
            order.is_some_and(|order| order.is_lt())
        });
        if is_better {
            *best = Some(setting.clone());
        }
    }

    /// Settings that keep the limits, are no worse than the marks that do, and lie within a tenth of the best objective:
    /// the best of all first, not too many.
    pub fn nearly_as_good(&self, map: &Map, best: Setting) -> Vec<Setting> {
        let objective = self.tuning.objective.criterion();
        let least = self.rank(&best);
        let most = least[3] * (1.0 + NEARLY);
        let is_near = |setting: &&Setting| {
            let rank = self.rank(setting);
            rank[..3] == least[..3] && rank[3] <= most && setting.values != best.values
        };
        let mut near: Vec<Setting> = Vec::new();
        if best.excess(&self.tuning.limits) == 0.0 {
            near = map.settings.iter().chain(self.marks).filter(is_near).cloned().collect();
            near.sort_by(|a, b| a.mean(objective).total_cmp(&b.mean(objective)));
            near.dedup_by(|a, b| a.values == b.values);
            near.truncate(MOST_CANDIDATES - 1);
        }
        near.insert(0, best);
        near
    }

    /// Margins short of their bounds; strokes beyond their limits; how many marks that keep all limits are better on some
    /// stroke; objective; following error.
    fn rank(&self, setting: &Setting) -> [f64; 5] {
        let limits = &self.tuning.limits;
        let is_worse = |mark: &&Setting| {
            mark.excess(limits) == 0.0 && !setting.is_at_least_as_good_as(mark, limits, self.bench.period_s())
        };
        let worse = self.marks.iter().filter(is_worse).count() as f64;
        let objective = self.tuning.objective.criterion();
        [
            setting.excess_of_margins(limits),
            setting.excess_of_strokes(limits),
            worse,
            setting.mean(objective),
            setting.mean(Criterion::FollowingError),
        ]
    }
}

/// A step to each side of every knob, and of all pairs of knobs.
fn neighbours(knobs: &[Knob], at: &[f64], steps: &[f64]) -> Vec<Vec<f64>> {
    let mut found: Vec<Vec<f64>> = Vec::new();
    let mut add = |turned: &[(usize, f64)]| {
        let mut values = at.to_vec();
        for (k, by) in turned {
            values[*k] = knobs[*k].inside(values[*k] + by * steps[*k]);
        }
        if values != at && !found.contains(&values) {
            found.push(values);
        }
    };
    for k in 0..knobs.len() {
        for by in [-1.0, 1.0] {
            add(&[(k, by)]);
            for other in k + 1..knobs.len() {
                add(&[(k, by), (other, -1.0)]);
                add(&[(k, by), (other, 1.0)]);
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knob(range: [f64; 2], step: f64, is_integer: bool) -> Knob {
        Knob { key: "controller.gain".to_owned(), from: range[0], to: range[1], step, is_integer }
    }

    /// Two knobs share 3600 settings, 60 each; what is asked for more finely is widened, and said to be.
    #[test]
    fn exact_a_map_that_is_too_fine_is_widened() {
        let knobs = [knob([1.0, 200.0], 1e-12, false), knob([6.0, 65.0], 1.0, true)];
        let values = grid(&knobs);
        assert_eq!(values.iter().map(Vec::len).collect::<Vec<_>>(), [60, 60]);
        let wider = widened(&knobs, &values);
        assert_eq!(wider.len(), 1);
        assert!((wider[0].1 - 199.0 / 59.0).abs() < 1e-9, "{}", wider[0].1);
    }
}
