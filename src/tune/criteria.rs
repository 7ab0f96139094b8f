//! What is asked of a setting, in the field's terms.

use crate::error::Result;
use crate::machine::{Criterion, Machine};
use crate::units::Motion;
use std::collections::BTreeMap;
use std::str::FromStr;

/// Gain margin, phase margin and modulus margin that a loop is usually given: 6 dB, 30°, 0.5.
///
/// # Source
/// Åström, Murray (2008), *Feedback Systems*, section 9.3.
const USUAL_MARGINS: [f64; 3] = [6.0, 30.0, 0.5];
/// Overshoot, velocity overshoot and reverse velocity that count as none: 0.1 %, 1 % and 0.5 %.
const USUAL_SHARES: [f64; 3] = [0.001, 0.01, 0.005];

/// No excess counts more.
const MOST_EXCESS: f64 = 1e3;
/// A bound of zero is exceeded in relation to this.
const LEAST_BOUND: f64 = 1e-9;

/// A value of every criterion, in the order of [`Criterion::ALL`].
pub type Values = [f64; 10];

/// Bounds on criteria: upper ones, of margins lower ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    bounds: BTreeMap<Criterion, f64>,
}

impl Limits {
    /// What is usually asked: no overshoot to speak of, the margins of a sound loop, an effort within the amplifier's limit.
    pub fn usual(machine: &Machine) -> Self {
        let shares = Criterion::ALL[..3].iter().copied().zip(USUAL_SHARES);
        let margins = Criterion::ALL[Criterion::OF_STROKE..].iter().copied().zip(USUAL_MARGINS);
        let mut bounds: BTreeMap<Criterion, f64> = shares.chain(margins).collect();
        if let Some(limit_v) = machine.constants().effort_limit_v() {
            bounds.insert(Criterion::PeakEffort, limit_v);
        }
        Self { bounds }
    }

    /// Sets the bound of the criterion with this key, in the key's unit.
    ///
    /// # Errors
    /// A key that is none of this kind of axis, or a bound that is not finite and zero or more.
    pub fn set(&mut self, motion: Motion, key: &str, bound: f64) -> Result<()> {
        let criterion = Criterion::bounded(motion, key, bound)?;
        self.bounds.insert(criterion, criterion.per_key() * bound);
        Ok(())
    }

    /// The bound of a criterion, where there is one.
    pub fn bound(&self, criterion: Criterion) -> Option<f64> {
        self.bounds.get(&criterion).copied()
    }

    /// By how much a value exceeds its bound, relative to it; 0 inside. A stroke that never settles exceeds by 1 even where
    /// settling time has no bound, and no excess counts more than 1000: what is far off is not to hide the rest.
    pub fn excess(&self, criterion: Criterion, value: f64) -> f64 {
        if value.is_nan() {
            return MOST_EXCESS;
        }
        let Some(bound) = self.bound(criterion) else {
            return f64::from(u8::from(criterion == Criterion::SettlingTime && value.is_infinite()));
        };
        let over = if criterion.is_margin() { bound - value } else { value - bound };
        if over <= 0.0 { 0.0 } else { (over / bound.max(LEAST_BOUND)).min(MOST_EXCESS) }
    }

    /// The criteria that exceed their bounds.
    pub fn exceeded(&self, values: &Values) -> Vec<Criterion> {
        let is_exceeded = |criterion: &Criterion| self.excess(*criterion, values[*criterion as usize]) > 0.0;
        Criterion::ALL.into_iter().filter(is_exceeded).collect()
    }

    /// The criterion that exceeds its bound most; none where all keep theirs.
    pub fn worst(&self, values: &Values) -> Option<Criterion> {
        let excess = |criterion: Criterion| self.excess(criterion, values[criterion as usize]);
        let exceeded = Criterion::ALL.into_iter().filter(|criterion| excess(*criterion) > 0.0);
        exceeded.max_by(|a, b| excess(*a).total_cmp(&excess(*b)))
    }
}

/// `KEY=VALUE`.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenLimit {
    /// Key of a criterion.
    pub key: String,
    /// Bound in the key's unit.
    pub bound: f64,
}

impl FromStr for WrittenLimit {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parsed = text.split_once('=').and_then(|(key, bound)| {
            Some(Self { key: key.trim().to_owned(), bound: bound.trim().parse().ok()? })
        });
        parsed.ok_or_else(|| {
            format!("`{text}` is not KEY=NUMBER; write for instance position_overshoot_percent=0.5")
        })
    }
}
