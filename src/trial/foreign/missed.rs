//! Samples that the logger misses.

use super::{remade, times};
use crate::effect::Prior;
use crate::error::Result;
use crate::recording::Run;
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};

/// A logger that misses single samples or short bursts of them.
///
/// # Model
/// Whole rows are missed: all signals alike, the references too. What stands in the log instead is one of two:
/// ```text
///   joined   rows k₁, k₂, … that were not missed, at times 0, T, 2T, …     the run becomes shorter
///   held     row k is the last one at or before k that was not missed       the run keeps its length
/// ```
/// No time stamp tells. The first row of a run is never missed: it starts the logger.
///
/// # Ranges
/// 0.1–2 % of the samples, even on a logarithmic scale; bursts of 1 to at most 1–20 samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MissedSamples {
    /// What stands in the log instead.
    pub rows: Rows,
    /// The bursts, in the order of their begin; they may overlap.
    pub bursts: Vec<Burst>,
}

/// What a logger makes of missed rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rows {
    /// Those after them move up.
    Joined,
    /// The last one is written again.
    Held,
}

/// Samples missed one after the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Burst {
    /// Time of the session in s from which on they are missed.
    pub begins_s: f64,
    /// How many.
    pub samples: usize,
}

const SHARES: (f64, f64) = (0.001, 0.02);
const MOST_SAMPLES: usize = 20;
/// A sample so many periods before a burst belongs to it: rounding.
const ROUNDING: f64 = 1e-6;

impl MissedSamples {
    /// Draws what is missed in a session of `session_s` at a sample period in s; at least one burst.
    pub fn draw(period_s: f64, session_s: f64, random: &mut StdRng) -> Self {
        let rows = if Prior::new(random).sign() < 0.0 { Rows::Joined } else { Rows::Held };
        let longest = random.random_range(1..=MOST_SAMPLES);
        let missed = Prior::new(random).log_uniform(SHARES.0, SHARES.1) * session_s / period_s;
        let count = (2.0 * missed / (1 + longest) as f64).round().max(1.0) as usize;
        let begins = times(count, session_s, random);
        let burst = |begins_s| Burst { begins_s, samples: random.random_range(1..=longest) };
        Self { rows, bursts: begins.into_iter().map(burst).collect() }
    }

    /// The rows of a run of so many that the log shows, in its order.
    ///
    /// ```
    /// use slideway::trial::foreign::{Burst, MissedSamples, Rows};
    /// let bursts = vec![Burst { begins_s: 10.02, samples: 2 }];
    /// let held = MissedSamples { rows: Rows::Held, bursts: bursts.clone() };
    /// assert_eq!(held.shown(10.0, 0.01, 6), [0, 1, 1, 1, 4, 5]);
    /// let joined = MissedSamples { rows: Rows::Joined, bursts };
    /// assert_eq!(joined.shown(10.0, 0.01, 6), [0, 1, 4, 5]);
    /// ```
    pub fn shown(&self, begins_s: f64, period_s: f64, samples: usize) -> Vec<usize> {
        let mut is_missed = vec![false; samples];
        for burst in &self.bursts {
            let first = ((burst.begins_s - begins_s) / period_s - ROUNDING).ceil() as i64;
            for row in first.max(1)..(first + burst.samples as i64).min(samples as i64) {
                is_missed[row as usize] = true;
            }
        }
        let mut last = 0;
        let mut shown = Vec::with_capacity(samples);
        for (row, is_missed) in is_missed.into_iter().enumerate() {
            if !is_missed {
                last = row;
            }
            if !is_missed || self.rows == Rows::Held {
                shown.push(last);
            }
        }
        shown
    }

    /// What is logged of a run.
    pub(super) fn logged(&self, run: &Run) -> Result<Run> {
        let shown = self.shown(run.begins_s, run.sample_period_s(), run.len());
        let picked = |samples: &Vec<f64>| shown.iter().map(|row| samples[*row]).collect();
        let signals = run.signals().iter().map(|(signal, samples)| (*signal, picked(samples))).collect();
        let extra = run.extra_columns().iter().map(|(name, samples)| (name.clone(), picked(samples)));
        remade(run, signals, extra.collect())
    }
}
