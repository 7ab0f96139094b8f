//! One stroke, test or log: signals sampled together at one period.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::signal::{Signal, TIME_KEY};
use super::timing::Timing;
use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// The key of a run under which a recording states what was fed forward beside the logged effort.
pub const FEEDFORWARD_KEY: &str = "feedforward";

/// What a run may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Parameters may be fitted to it.
    Training,
    /// It only judges what was fitted elsewhere.
    HeldOut,
}

impl Role {
    /// The text in `recording.toml`.
    pub fn text(self) -> &'static str {
        match self {
            Self::Training => "training",
            Self::HeldOut => "held_out",
        }
    }

    pub(super) fn from_text(text: &str) -> Option<Self> {
        [Self::Training, Self::HeldOut].into_iter().find(|role| role.text() == text)
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// One run: at least one sample of at least one measured signal, all finite, all of one length, in SI.
///
/// Sample k was taken at `start_s + k · sample_period_s`. A copy is cheap: the samples are shared.
#[derive(Debug, Clone)]
pub struct Run {
    name: String,
    motion: Motion,
    sample_period_s: f64,
    signals: Arc<BTreeMap<Signal, Vec<f64>>>,
    extra_columns: Arc<BTreeMap<String, Vec<f64>>>,
    instants_s: Option<Arc<Vec<f64>>>,
    entry: Option<[f64; 3]>,
    /// The samples before those that were cut out of a longer run.
    lead: Option<Arc<Run>>,
    /// Name of the run that it is a part of.
    whole: Option<String>,
    /// What it may be used for, where that was declared.
    pub role: Option<Role>,
    /// Time of the first sample, as its file counts.
    pub start_s: f64,
    /// When it begins within the session, in s; see [`Recording::new`](super::Recording::new).
    pub begins_s: f64,
    /// Free keys of the recording (stroke, feed, …).
    pub metadata: toml::Table,
    /// Machine settings in force in this run, by key path (the key `set`).
    pub settings: BTreeMap<String, toml::Value>,
    /// The file it was read from; empty for a run made in memory.
    pub file: PathBuf,
    sha256: OnceLock<String>,
    /// What was found about its time column.
    pub timing: Timing,
    /// Columns of the file that no signal uses.
    pub ignored_columns: Vec<String>,
    /// What was done at the door beyond taking columns over: the layout read, lost samples filled in, clocks joined.
    pub remarks: Vec<String>,
}

impl Run {
    /// A run made in memory, a replay say.
    ///
    /// # Errors
    /// An empty name or one that cannot name a file, a period that is not positive, no measured signal,
    /// no samples, different lengths, NaN or infinity.
    pub fn new(
        name: impl Into<String>,
        motion: Motion,
        sample_period_s: f64,
        signals: BTreeMap<Signal, Vec<f64>>,
    ) -> Result<Self> {
        let name = name.into();
        check_measured(&signals, motion).map_err(|error| error.key(name.clone()))?;
        Self::hashed(name, motion, sample_period_s, signals, OnceLock::new())
    }

    /// A run with the hash of the file that it was read from; whether anything was measured is the caller's to ask.
    pub(super) fn of_file(
        name: String,
        motion: Motion,
        sample_period_s: f64,
        signals: BTreeMap<Signal, Vec<f64>>,
        sha256: String,
    ) -> Result<Self> {
        Self::hashed(name, motion, sample_period_s, signals, sha256.into())
    }

    fn hashed(
        name: String,
        motion: Motion,
        sample_period_s: f64,
        signals: BTreeMap<Signal, Vec<f64>>,
        sha256: OnceLock<String>,
    ) -> Result<Self> {
        check_name(&name)?;
        if !(sample_period_s.is_finite() && sample_period_s > 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("sample_period_s")
                .found(sample_period_s.to_string())
                .expected("a positive number of seconds")
                .remedy("give the time between two samples, 250e-6 say"));
        }
        check_signals(&signals, motion).map_err(|error| error.key(name.clone()))?;
        Ok(Self {
            name,
            motion,
            sample_period_s,
            signals: Arc::new(signals),
            extra_columns: Arc::default(),
            instants_s: None,
            entry: None,
            lead: None,
            whole: None,
            role: None,
            start_s: 0.0,
            begins_s: 0.0,
            metadata: toml::Table::new(),
            settings: BTreeMap::new(),
            file: PathBuf::new(),
            sha256,
            timing: Timing::declared(sample_period_s),
            ignored_columns: Vec::new(),
            remarks: Vec::new(),
        })
    }

    /// The run with columns that no signal of the list stands for, slider loads say; they replace earlier ones.
    ///
    /// # Errors
    /// A name that is empty, padded, quoted or that of a signal; another length than the signals'; NaN or infinity.
    pub fn with_extra_columns(mut self, extra_columns: BTreeMap<String, Vec<f64>>) -> Result<Self> {
        for (name, samples) in &extra_columns {
            check_extra_name(name)?;
            check_samples(name, samples, self.len())?;
        }
        self.extra_columns = Arc::new(extra_columns);
        Ok(self)
    }

    /// Columns kept beside the signals, by name; the name should end in the unit.
    pub fn extra_columns(&self) -> &BTreeMap<String, Vec<f64>> {
        &self.extra_columns
    }

    /// The name, unique within its recording.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the axis slides or turns.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// Time between two samples.
    pub fn sample_period_s(&self) -> f64 {
        self.sample_period_s
    }

    pub(super) fn set_sample_period_s(&mut self, sample_period_s: f64) {
        self.sample_period_s = sample_period_s;
    }

    /// Times of the samples from the first one on, where they were not taken by an even clock
    /// ([`Timing::is_uneven`]); none where they were.
    pub fn instants_s(&self) -> Option<&[f64]> {
        self.instants_s.as_ref().map(|instants| instants.as_slice())
    }

    /// Time of a sample since the first one, in s.
    pub fn time_s(&self, sample: usize) -> f64 {
        self.instants_s().map_or(sample as f64 * self.sample_period_s, |instants| instants[sample])
    }

    pub(super) fn set_instants_s(&mut self, instants_s: Vec<f64>) {
        self.instants_s = Some(Arc::new(instants_s));
    }

    /// The same run on an even clock: signals between two time stamps on a straight line, `torque_enabled` held.
    ///
    /// # Errors
    /// A period that is not positive.
    pub fn resampled(&self, period_s: f64) -> Result<Self> {
        let Some(instants) = self.instants_s() else { return Ok(self.clone()) };
        let last = instants.last().copied().unwrap_or(0.0);
        let count = (last / period_s) as usize + 1;
        let places: Vec<(usize, f64)> = (0..count)
            .map(|k| {
                let t = k as f64 * period_s;
                let row = instants.partition_point(|instant| *instant <= t).saturating_sub(1);
                let next = (row + 1).min(instants.len() - 1);
                let interval = instants[next] - instants[row];
                (row, if interval > 0.0 { ((t - instants[row]) / interval).min(1.0) } else { 0.0 })
            })
            .collect();
        let resampled = |(signal, samples): (&Signal, &Vec<f64>)| {
            let at = |&(row, share): &(usize, f64)| {
                let share = if *signal == Signal::TorqueEnabled { 0.0 } else { share };
                let next = samples[(row + 1).min(samples.len() - 1)];
                samples[row] + share * (next - samples[row])
            };
            (*signal, places.iter().map(at).collect())
        };
        let signals = self.signals.iter().map(resampled).collect();
        let sha256 = self.sha256().to_owned();
        let mut run = Self::of_file(self.name.clone(), self.motion, period_s, signals, sha256)?;
        run.role = self.role;
        (run.start_s, run.begins_s) = (self.start_s, self.begins_s);
        run.metadata.clone_from(&self.metadata);
        run.settings.clone_from(&self.settings);
        run.file.clone_from(&self.file);
        run.ignored_columns.clone_from(&self.ignored_columns);
        Ok(run)
    }

    /// SHA-256 of the file that it was read from, or of the samples for a run made in memory.
    pub fn sha256(&self) -> &str {
        // Replays are runs too, and nobody asks for theirs.
        self.sha256.get_or_init(|| samples_sha256(self.sample_period_s, &self.signals, self.motion))
    }

    /// The same run with other samples of its signals, with its settings, metadata and time stamps, and what tells its start where it was cut out of a longer
    /// one; as if made in memory.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn with_signals(&self, signals: BTreeMap<Signal, Vec<f64>>) -> Result<Self> {
        let mut run = Self::new(self.name.clone(), self.motion, self.sample_period_s, signals)?;
        run.settings.clone_from(&self.settings);
        run.metadata.clone_from(&self.metadata);
        run.begins_s = self.begins_s;
        run.instants_s.clone_from(&self.instants_s);
        (run.entry, run.lead) = (self.entry, self.lead.clone());
        Ok(run)
    }

    /// Position, velocity and acceleration at the first sample of a run that was cut out of a longer one, read from the samples on
    /// both sides of the cut.
    pub fn entry(&self) -> Option<[f64; 3]> {
        self.entry
    }

    /// The samples before a run that was cut out of a longer one: a replay that begins with them has its state at the first sample from the
    /// motion before, whatever of it no signal tells.
    pub fn lead(&self) -> Option<&Self> {
        self.lead.as_deref()
    }

    /// The same run after these samples.
    pub(super) fn led_by(self, lead: Self) -> Self {
        Self { lead: Some(Arc::new(lead)), ..self }
    }

    /// Time of a sample as the file counts; of the one after the last, the time of the last.
    pub fn file_time_s(&self, sample: usize) -> f64 {
        self.start_s + self.time_s(sample.min(self.len() - 1))
    }

    /// Whether it was cut out of a longer run.
    pub fn is_part(&self) -> bool {
        self.whole.is_some()
    }

    /// Some samples of the run as a run of its own, named by its times, at its place in file and session, with its state there.
    pub(super) fn part(&self, samples: Range<usize>, entry: Option<[f64; 3]>) -> Self {
        let whole = self.whole.as_ref().unwrap_or(&self.name);
        let [from, to] = [samples.start, samples.end].map(|sample| self.file_time_s(sample));
        let name = format!("{whole} {from:.3}-{to:.3} s");
        let of = |all: &Vec<f64>| all[samples.clone()].to_vec();
        let from_s = self.time_s(samples.start);
        let instants = |all: &[f64]| Arc::new(all[samples.clone()].iter().map(|t| t - from_s).collect());
        Self {
            name,
            signals: Arc::new(self.signals.iter().map(|(signal, all)| (*signal, of(all))).collect()),
            extra_columns: Arc::new(
                self.extra_columns.iter().map(|(name, all)| (name.clone(), of(all))).collect(),
            ),
            instants_s: self.instants_s().map(instants),
            whole: Some(whole.clone()),
            entry: entry.or(self.entry.filter(|_| samples.start == 0)),
            lead: self.lead.clone().filter(|_| samples.start == 0),
            start_s: self.start_s + from_s,
            begins_s: self.begins_s + from_s,
            sha256: self.sha256().to_owned().into(),
            ..self.clone()
        }
    }

    /// Number of samples; at least one.
    #[expect(clippy::len_without_is_empty, reason = "a run is never empty")]
    pub fn len(&self) -> usize {
        self.signals.values().next().map_or(0, Vec::len)
    }

    /// From the first sample to the last.
    pub fn duration_s(&self) -> f64 {
        self.time_s(self.len() - 1)
    }

    /// All signals in signal-path order.
    pub fn signals(&self) -> &BTreeMap<Signal, Vec<f64>> {
        &self.signals
    }

    /// The samples of a signal, if it was logged.
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.signals.get(&signal).map(Vec::as_slice)
    }

    /// Refuses a run with uneven time stamps, for `purpose`, which needs an even clock.
    ///
    /// # Errors
    /// [`ErrorKind::Inconsistent`] where the time stamps are uneven.
    pub fn require_even(&self, purpose: &str) -> Result<()> {
        if self.instants_s.is_none() {
            return Ok(());
        }
        let stray_s = self.timing.wander_s;
        let error = Error::new(ErrorKind::Inconsistent)
            .key(format!("{}.{TIME_KEY}", self.name))
            .found(format!("time stamps that stray by up to {stray_s:.1e} s from an even clock"))
            .expected(format!("an even clock: {purpose} compares each sample with the one before"))
            .remedy("resample the log, or state sample_period_s if the clock is even and its stamps are not");
        Err(if self.file.as_os_str().is_empty() { error } else { error.file(&self.file) })
    }

    /// Refuses a run whose logged effort is not the whole one, for `purpose`, which needs that.
    ///
    /// # Errors
    /// [`ErrorKind::Inconsistent`] where the run states a feed-forward.
    pub fn require_whole_effort(&self, purpose: &str) -> Result<()> {
        let Some(stated) = self.metadata.get(FEEDFORWARD_KEY) else { return Ok(()) };
        let error = Error::new(ErrorKind::Inconsistent)
            .key(format!("{}.{FEEDFORWARD_KEY}", self.name))
            .found(format!("{FEEDFORWARD_KEY} = {stated}: the logged effort is the feedback's share"))
            .expected(format!(
                "runs without feed-forward: {purpose} takes the logged effort for the whole one"
            ))
            .remedy("use runs without feed-forward, or log current, thrust or torque and take that");
        Err(if self.file.as_os_str().is_empty() { error } else { error.file(&self.file) })
    }

    /// The samples of a signal that the caller cannot do without.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`], naming the run, the signal and those that are there.
    pub fn require(&self, signal: Signal) -> Result<&[f64]> {
        self.signal(signal).ok_or_else(|| {
            let key = signal.key(self.motion);
            let there: Vec<_> = self.signals.keys().map(|signal| signal.key(self.motion)).collect();
            let error = Error::new(ErrorKind::Missing)
                .key(key)
                .found(format!("run `{}` with {}", self.name, there.join(", ")))
                .expected(format!("the {} of the axis", signal.word(self.motion)))
                .remedy(format!("log it, or map its column to `{key}` in [columns] of recording.toml"));
            if self.file.as_os_str().is_empty() { error } else { error.file(&self.file) }
        })
    }
}

fn check_name(name: &str) -> Result<()> {
    let plain = |letter: char| !letter.is_control() && !"/\\:*?\"<>|".contains(letter);
    if !name.is_empty() && !name.starts_with('.') && name.trim() == name && name.chars().all(plain) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::OutOfRange)
        .key("name")
        .found(format!("{name:?}"))
        .expected("a run name that can name a file: no slashes, colons, quotes or leading dot")
        .remedy("rename the run, with `name = \"…\"` in its [[run]] if need be"))
}

/// Refuses signals of which none was measured.
pub(super) fn check_measured(signals: &BTreeMap<Signal, Vec<f64>>, motion: Motion) -> Result<()> {
    if signals.keys().any(|signal| signal.is_measured()) {
        return Ok(());
    }
    let measured = Signal::ALL.into_iter().filter(|signal| signal.is_measured());
    let keys: Vec<_> = measured.map(|signal| signal.key(motion)).collect();
    Err(Error::new(ErrorKind::Missing)
        .found("a run without any measured signal")
        .expected(format!("at least one of {}", keys.join(", ")))
        .remedy("name the columns so, or map them in [columns] of recording.toml"))
}

fn check_signals(signals: &BTreeMap<Signal, Vec<f64>>, motion: Motion) -> Result<()> {
    let length = signals.values().next().map_or(0, Vec::len);
    if length == 0 {
        return Err(Error::new(ErrorKind::TooLittleData)
            .found("a run without samples")
            .expected("at least one sample")
            .remedy("take the run out of the recording"));
    }
    for (signal, samples) in signals {
        check_samples(signal.key(motion), samples, length)?;
    }
    Ok(())
}

fn check_samples(key: &str, samples: &[f64], length: usize) -> Result<()> {
    if samples.len() != length {
        return Err(Error::new(ErrorKind::Inconsistent)
            .key(key)
            .found(format!("{} samples where other signals have {length}", samples.len()))
            .expected("signals of one length")
            .remedy("cut all signals to the same samples"));
    }
    match samples.iter().position(|sample| !sample.is_finite()) {
        None => Ok(()),
        Some(at) => Err(Error::new(ErrorKind::NotFinite)
            .key(key)
            .found(format!("{} at sample {at}", samples[at]))
            .expected("a finite number")
            .remedy("the simulation or conversion that made this run went wrong")),
    }
}

/// Names that a header line holds without quotes, and that mean nothing else.
fn check_extra_name(name: &str) -> Result<()> {
    let plain = |letter: char| !letter.is_control() && !",;\"#".contains(letter);
    let is_taken = name == TIME_KEY || Signal::from_key(name).is_some();
    if !name.is_empty() && name.trim() == name && name.chars().all(plain) && !is_taken {
        return Ok(());
    }
    Err(Error::new(ErrorKind::OutOfRange)
        .key("extra_columns")
        .found(format!("{name:?}"))
        .expected("a column name without separators or quotes that is not the name of a signal")
        .remedy("rename the column; signals are read without being listed there"))
}

fn samples_sha256(sample_period_s: f64, signals: &BTreeMap<Signal, Vec<f64>>, motion: Motion) -> String {
    let mut hash = Sha256::new();
    hash.update(sample_period_s.to_le_bytes());
    for (signal, samples) in signals {
        hash.update(signal.key(motion));
        for sample in samples {
            hash.update(sample.to_le_bytes());
        }
    }
    hex(hash)
}

/// A finished hash in hexadecimal.
pub(super) fn hex(hash: Sha256) -> String {
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a file, read piece by piece.
pub(super) fn file_sha256(path: &Path) -> Result<String> {
    let mut file = std::fs::File::open(path).map_err(|error| Error::io(path, &error))?;
    let mut hash = Sha256::new();
    std::io::copy(&mut file, &mut hash).map_err(|error| Error::io(path, &error))?;
    Ok(hex(hash))
}
