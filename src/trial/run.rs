//! Running a trial: every case diagnosed, every verdict committed, nothing opened.

use super::folder::Trial;
use super::seal::{Ledger, is_open};
use super::verdict::Said;
use crate::diagnose::{Options, compare, diagnose};
use crate::effect::EffectId;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::recording::Recording;
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// What a run came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ran {
    /// Cases that were diagnosed.
    pub diagnosed: usize,
    /// Cases whose verdict was committed already.
    pub committed_before: usize,
}

/// Diagnoses every case of a trial that has no committed verdict yet, `jobs` at a time, one core each.
///
/// Nothing sealed is read: the diagnosis gets the recording, the machine that it names, and what is struck from the
/// catalogue. Each verdict is committed as it comes, so that a run that was killed goes on where it was. A recording
/// that the diagnosis refuses gets a verdict that says so.
///
/// # Errors
/// A trial that is not forged to its end, verdicts that were changed, or a seal that is open already while verdicts
/// are missing.
pub fn run(trial: &Trial, jobs: NonZeroUsize, done: &(dyn Fn(usize) + Sync)) -> Result<Ran> {
    if let Some(case) = trial.cases().find(|case| !trial.is_forged(*case)) {
        return Err(Error::new(ErrorKind::Missing)
            .file(trial.case_folder(case))
            .found("no recording of this case")
            .expected("a trial that is forged to its end")
            .remedy("give the same `slideway trial forge` command again: it goes on where it was"));
    }
    // Two runs at a time would overwrite each other's ledger.
    let _lock = crate::whole::lock(&trial.folder)?;
    let ledger = Ledger::read(trial)?;
    let open: Vec<usize> = trial.cases().filter(|case| !ledger.contains(*case)).collect();
    if is_open(trial) && !open.is_empty() {
        return Err(Error::new(ErrorKind::Inconsistent)
            .file(trial.verdicts())
            .found(format!("no verdict on {} cases of a trial whose seal is open", open.len()))
            .expected("verdicts that were committed before the truth was known")
            .remedy("forge a trial with another seed"));
    }
    let ran = Ran { diagnosed: open.len(), committed_before: trial.announcement.cases - open.len() };
    let (next, ledger, failed) = (AtomicUsize::new(0), Mutex::new(ledger), Mutex::new(None));
    let work = || -> Result<()> {
        // One core a case: its computing time is its own, whatever runs beside it.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| {
            Error::new(ErrorKind::Io).found(error.to_string()).expected("a thread to compute on")
        })?;
        while let Some(&case) = open.get(next.fetch_add(1, Ordering::Relaxed)) {
            let begun = Instant::now();
            let verdict = pool.install(|| verdict(trial, case))?;
            let seconds = begun.elapsed().as_secs_f64();
            lock(&ledger).commit(trial, case, &verdict, seconds)?;
            done(case);
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.get().min(open.len()) {
            scope.spawn(|| {
                if let Err(error) = work() {
                    // The others end with the case they are at.
                    next.store(usize::MAX / 2, Ordering::Relaxed);
                    lock(&failed).get_or_insert(error);
                }
            });
        }
    });
    let failed = lock(&failed).take();
    failed.map_or(Ok(ran), Err)
}

/// What a mutex holds, also after a panic elsewhere: every change to it is whole.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// The verdict on a case, as JSON.
fn verdict(trial: &Trial, case: usize) -> Result<String> {
    let recording = Recording::read(trial.case_folder(case))?;
    let terms = trial.terms(case)?;
    let Some(path) = &recording.machine else {
        return Err(Error::new(ErrorKind::Missing)
            .file(&recording.path)
            .key("machine")
            .found("a recording that names no machine")
            .expected("the machine on trial")
            .remedy("forge the trial again"));
    };
    let settings = terms.twin.iter().map(|(path, value)| (path.as_str(), toml::Value::Float(*value)));
    let machine = Machine::read(path)?.with_settings(settings)?;
    let catalogue: Vec<EffectId> =
        EffectId::ALL.iter().copied().filter(|effect| !terms.without.contains(effect)).collect();
    let options = Options { catalogue: &catalogue, ..Options::default() };
    let before = trial.reference_folder(case);
    let verdict = match before.is_dir() {
        true => {
            Recording::read(before).and_then(|reference| compare(&machine, &reference, &recording, &options))
        }
        false => diagnose(&machine, &recording, &options),
    };
    match verdict {
        Err(error) => Ok(Said::refusal(&error)),
        Ok(diagnosis) => super::seal::json(&diagnosis, &trial.case_folder(case)),
    }
}
