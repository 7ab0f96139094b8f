//! Training and held-out runs, kept apart by their types.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;

use sha2::{Digest, Sha256};

use super::Recording;
use super::pieces::{Cut, LEAST_PIECE, Samples, halves, most_telling};
use super::run::{Role, Run, hex};
use crate::error::{Error, ErrorKind, Result};

/// How runs without a declared role are shared out: whole runs, one in so many held out.
///
/// # Model
/// The runs are sorted by their metadata and name and cut into as many blocks as runs are to be held out;
/// in each block the run with the smallest hash of its name is held out. So the choice spreads over strokes and
/// feeds, does not fall into step with a grid of them, and does not depend on the order in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplitRule {
    held_out_one_in: NonZeroUsize,
}

impl Default for SplitRule {
    /// One in four.
    fn default() -> Self {
        Self { held_out_one_in: NonZeroUsize::MIN.saturating_add(3) }
    }
}

impl SplitRule {
    /// One run in `runs` is held out (at least one, and at least one is left for training).
    pub fn one_in(runs: NonZeroUsize) -> Self {
        Self { held_out_one_in: runs }
    }
}

/// Runs that parameters may be fitted to. Made only by [`Recording::split`].
#[derive(Debug, Clone)]
pub struct TrainingRuns<T = Run> {
    runs: Vec<T>,
}

/// Runs that judge what was fitted elsewhere. Made only by [`Recording::split`] and by [`TrainingRuns::leaving_out`].
#[derive(Debug, Clone)]
pub struct HeldOutRuns<T = Run> {
    runs: Vec<T>,
}

impl<T> TrainingRuns<T> {
    /// The runs, sorted by name; at least one.
    pub fn runs(&self) -> &[T] {
        &self.runs
    }

    /// The same runs in another form, one each.
    ///
    /// # Errors
    /// The first one that `prepare` returns.
    pub fn prepare<U>(&self, prepare: impl Fn(&T) -> Result<U>) -> Result<TrainingRuns<U>> {
        Ok(TrainingRuns { runs: self.runs.iter().map(prepare).collect::<Result<_>>()? })
    }
}

impl<T: Clone> TrainingRuns<T> {
    /// The training runs without one of them, and that one as their judge, for cross-validation inside the training runs;
    /// nothing when it is the only one or the index is beyond the last.
    pub fn leaving_out(&self, index: usize) -> Option<(Self, HeldOutRuns<T>)> {
        if self.runs.len() < 2 || index >= self.runs.len() {
            return None;
        }
        let mut runs = self.runs.clone();
        let left_out = HeldOutRuns { runs: vec![runs.remove(index)] };
        Some((Self { runs }, left_out))
    }

    /// The training runs as judges of what was fitted to them: resubstitution, an optimistic measure.
    pub fn resubstituted(&self) -> HeldOutRuns<T> {
        HeldOutRuns { runs: self.runs.clone() }
    }
}

impl<T> HeldOutRuns<T> {
    /// The runs, sorted by name; at least one.
    pub fn runs(&self) -> &[T] {
        &self.runs
    }

    /// The same runs in another form, one each.
    ///
    /// # Errors
    /// The first one that `prepare` returns.
    pub fn prepare<U>(&self, prepare: impl Fn(&T) -> Result<U>) -> Result<HeldOutRuns<U>> {
        Ok(HeldOutRuns { runs: self.runs.iter().map(prepare).collect::<Result<_>>()? })
    }
}

/// A recording shared out, and what was left aside.
#[derive(Debug, Clone)]
pub struct Split {
    /// Runs that parameters may be fitted to.
    pub training: TrainingRuns,
    /// Runs that judge.
    pub held_out: HeldOutRuns,
    /// How a single run was cut; none where there were several runs.
    pub cut: Option<Cut>,
    /// How many samples are worked on.
    pub samples: Samples,
}

/// Of a budget of samples, the share that the held-out runs get.
const HELD_OUT_SHARE: f64 = 1.0 / 3.0;

impl Recording {
    /// Shares the runs out: declared roles first, the others by the rule, never part of a run. A single run is cut.
    ///
    /// # Errors
    /// [`ErrorKind::TooLittleData`] when one side stays empty (a single run that is too short or does not move, or all of one
    /// role); [`ErrorKind::Inconsistent`] when the same data stand on both sides.
    pub fn split(&self, rule: SplitRule) -> Result<(TrainingRuns, HeldOutRuns)> {
        self.split_within(rule, usize::MAX).map(|split| (split.training, split.held_out))
    }

    /// The same with at most about so many samples.
    ///
    /// # Model
    /// A single run without a stated role is cut in the middle of standstills, and about a third of each kind of motion (directions, speeds,
    /// accelerations, places) is held out. A run that never stands is cut once, where it is fastest near the last third.
    ///
    /// Where the runs have more samples than `most`, each side keeps the stretches that hold most of its motion; a third of the
    /// samples goes to the held-out side, or what the other side leaves.
    ///
    /// # Errors
    /// As [`Recording::split`].
    pub fn split_within(&self, rule: SplitRule, most: usize) -> Result<Split> {
        let (mut training, mut held_out, cut) = match self.runs() {
            [single] if single.role.is_none() => {
                let (training, held_out, cut) = halves(single).ok_or_else(|| self.uncut(single))?;
                (training, held_out, Some(cut))
            }
            _ => {
                let (training, held_out) = self.whole_runs(rule)?;
                (training, held_out, None)
            }
        };
        let count = |runs: &[Run]| runs.iter().map(Run::len).sum::<usize>();
        let recorded = [count(&training), count(&held_out)];
        let own = (HELD_OUT_SHARE * most as f64) as usize;
        if recorded[0] + recorded[1] > most {
            let judging = own.max(most.saturating_sub(recorded[0]));
            held_out = most_telling(held_out, judging);
            training = most_telling(training, most - count(&held_out).min(most));
        }
        self.refuse_shared_data(&training, &held_out)?;
        let samples = Samples {
            used: count(&training) + count(&held_out),
            recorded: recorded[0] + recorded[1],
            most,
            stretches: training.len() + held_out.len(),
        };
        Ok(Split {
            training: TrainingRuns { runs: training },
            held_out: HeldOutRuns { runs: held_out },
            cut,
            samples,
        })
    }

    /// Training and held-out runs of several.
    fn whole_runs(&self, rule: SplitRule) -> Result<(Vec<Run>, Vec<Run>)> {
        let free: Vec<&Run> = self.runs().iter().filter(|run| run.role.is_none()).collect();
        let declared = |role| self.runs().iter().filter(|run| run.role == Some(role)).count();
        let (training, held_out) = (declared(Role::Training), declared(Role::HeldOut));
        let most = free.len().saturating_sub(usize::from(training == 0));
        let least = usize::from(held_out == 0);
        if most < least || training + free.len() == 0 {
            return Err(self.one_sided(training, held_out));
        }
        let one_in = rule.held_out_one_in.get();
        let share = ((2 * free.len() + one_in) / (2 * one_in)).clamp(least, most);
        let chosen = choose(free, share);
        let is_held_out = |run: &&Run| run.role == Some(Role::HeldOut) || chosen.contains(run.name());
        let (mut held_out, mut training): (Vec<Run>, Vec<Run>) =
            self.runs().iter().cloned().partition(|run| is_held_out(&run));
        held_out.sort_by(|a, b| a.name().cmp(b.name()));
        training.sort_by(|a, b| a.name().cmp(b.name()));
        Ok((training, held_out))
    }

    /// The refusal of a single run that cannot be cut.
    fn uncut(&self, run: &Run) -> Error {
        let found = match run.len() < 3 * LEAST_PIECE {
            true => format!("a single run of {} samples", run.len()),
            false => "a single run in which the axis does not move".to_owned(),
        };
        let error = Error::new(ErrorKind::TooLittleData).key("run").found(found);
        let error = error
            .expected(format!("several runs, or one of at least {} samples that moves", 3 * LEAST_PIECE))
            .remedy("record a longer run, with standstills of 0.2 s between motions in both directions, or a second one");
        if self.path.as_os_str().is_empty() { error } else { error.file(&self.path) }
    }

    fn one_sided(&self, training: usize, held_out: usize) -> Error {
        let error = Error::new(ErrorKind::TooLittleData).key("run").expected("training and held-out runs");
        let error = match self.runs().len() {
            1 => error.found("a single run with a role").remedy(
                "leave `role` out: a single run is then cut at its standstills; or record a second run",
            ),
            runs if training == runs => {
                error.found("training runs only").remedy("give one run role = \"held_out\", or no role")
            }
            runs if held_out == runs => {
                error.found("held-out runs only").remedy("give one run role = \"training\", or no role")
            }
            _ => error.found("too few runs without a role").remedy("record a further run"),
        };
        if self.path.as_os_str().is_empty() { error } else { error.file(&self.path) }
    }

    fn refuse_shared_data(&self, training: &[Run], held_out: &[Run]) -> Result<()> {
        for run in held_out {
            super::shared::check(run, training).map_err(|error| error.file(&self.path))?;
            if let Some(twin) =
                training.iter().find(|twin| twin.sha256() == run.sha256() && overlap(twin, run))
            {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .file(&self.path)
                    .key(run.name())
                    .found(format!("held-out data that are the training run `{}` byte for byte", twin.name()))
                    .expected("held-out runs that were not trained on")
                    .remedy("drop one of the two runs"));
            }
        }
        Ok(())
    }
}

/// Whether two runs of one file have a sample in common: each may use a time range of it.
fn overlap(a: &Run, b: &Run) -> bool {
    let end = |run: &Run| run.start_s + (run.len() as f64 - 0.5) * run.sample_period_s();
    a.start_s < end(b) && b.start_s < end(a)
}

/// The names of the runs to hold out.
fn choose(mut free: Vec<&Run>, share: usize) -> BTreeSet<String> {
    free.sort_by_cached_key(|run| (metadata_key(&run.metadata), run.name().to_owned()));
    (0..share)
        .filter_map(|block| {
            let (from, to) = (block * free.len() / share, (block + 1) * free.len() / share);
            free.get(from..to)?.iter().min_by_key(|run| name_hash(run.name()))
        })
        .map(|run| run.name().to_owned())
        .collect()
}

fn name_hash(name: &str) -> String {
    let mut hash = Sha256::new();
    hash.update(name);
    hex(hash)
}

/// Metadata as a text that sorts numbers by size.
fn metadata_key(metadata: &toml::Table) -> Vec<(String, String)> {
    metadata
        .iter()
        .map(|(key, value)| {
            let number = super::document::number(value);
            (key.clone(), number.map_or_else(|| value.to_string(), sortable))
        })
        .collect()
}

/// A number as hexadecimal digits in the order of the numbers.
fn sortable(number: f64) -> String {
    let bits = number.to_bits();
    let ordered = if bits >> 63 == 0 { bits | 1 << 63 } else { !bits };
    format!("{ordered:016x}")
}
