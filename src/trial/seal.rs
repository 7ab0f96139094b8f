//! The seal: a truth that opens only against committed verdicts.

use super::folder::{Trial, sha256, write};
use super::truth::Truth;
use super::verdict::Said;
use crate::error::{Error, ErrorKind, Result};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

/// A value in a file that nobody has read yet.
///
/// There is one way to it, [`Sealed::open`], and that takes [`CommittedVerdicts`]:
///
/// ```compile_fail
/// use slideway::trial::{Sealed, Truth};
/// fn peek(sealed: Sealed<Truth>) -> Truth {
///     sealed.open()
/// }
/// ```
///
/// ```compile_fail
/// // Verdicts are committed on disk or not at all.
/// let none = slideway::trial::CommittedVerdicts { verdicts: Vec::new() };
/// ```
#[derive(Debug, Clone)]
pub struct Sealed<T> {
    path: PathBuf,
    sha256: String,
    value: PhantomData<T>,
}

/// What is left behind when a seal is opened.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Opened {
    committed_sha256: String,
}

impl<T: Serialize + DeserializeOwned> Sealed<T> {
    /// Seals a value in a file.
    ///
    /// # Errors
    /// Whatever the file system refuses.
    pub fn close(value: &T, path: &Path) -> Result<Self> {
        let text = json(value, path)?;
        write(path, text.as_bytes())?;
        Ok(Self::at(path, &sha256(text.as_bytes())))
    }

    /// The hash that a value will have once it is sealed.
    ///
    /// # Errors
    /// A value that JSON cannot hold.
    pub fn hash(value: &T) -> Result<String> {
        Ok(sha256(json(value, Path::new(""))?.as_bytes()))
    }

    /// What was sealed in a file earlier.
    pub fn at(path: &Path, sha256: &str) -> Self {
        Self { path: path.to_path_buf(), sha256: sha256.to_owned(), value: PhantomData }
    }

    /// SHA-256 of the file.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Opens the seal against verdicts, and notes against which; from then on it opens against no others.
    ///
    /// # Errors
    /// Verdicts of another trial, a seal that was opened against other verdicts, or a file that is not the one that was
    /// sealed.
    pub fn open(&self, verdicts: &CommittedVerdicts) -> Result<T> {
        if verdicts.truth_sha256 != self.sha256 {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&verdicts.ledger)
                .key("truth_sha256")
                .found(verdicts.truth_sha256.clone())
                .expected(self.sha256.clone())
                .remedy("score verdicts with the truth of their own trial"));
        }
        let text = std::fs::read(&self.path).map_err(|error| Error::io(&self.path, &error))?;
        if sha256(&text) != self.sha256 {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&self.path)
                .found(format!("a file with the SHA-256 {}", sha256(&text)))
                .expected(format!("the sealed one, {}", self.sha256))
                .remedy("the truth was changed after it was sealed: forge the trial again"));
        }
        self.note(verdicts)?;
        serde_json::from_slice(&text).map_err(|error| {
            Error::new(ErrorKind::Syntax)
                .file(&self.path)
                .found(error.to_string())
                .expected("a truth as this version of slideway seals it")
                .remedy("score with the version that forged the trial")
        })
    }

    fn note(&self, verdicts: &CommittedVerdicts) -> Result<()> {
        let path = opened_file(&self.path);
        if let Some(opened) = opened(&path)? {
            if opened.committed_sha256 == verdicts.sha256 {
                return Ok(());
            }
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&verdicts.ledger)
                .found("verdicts other than those that the seal was opened against")
                .expected(format!("the committed verdicts with the SHA-256 {}", opened.committed_sha256))
                .remedy("a verdict that was changed after the truth was known counts nothing: forge a trial with another seed"));
        }
        let text = json(&Opened { committed_sha256: verdicts.sha256.clone() }, &path)?;
        write(&path, text.as_bytes())
    }
}

fn opened_file(truth: &Path) -> PathBuf {
    truth.with_file_name("opened.json")
}

fn opened(path: &Path) -> Result<Option<Opened>> {
    if !path.is_file() {
        return Ok(None);
    }
    let text = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
    serde_json::from_slice(&text).map(Some).map_err(|error| {
        Error::new(ErrorKind::Syntax)
            .file(path)
            .found(error.to_string())
            .expected("what opening a seal leaves behind")
            .remedy("forge a trial with another seed")
    })
}

impl Trial {
    /// The sealed truth.
    pub fn truth(&self) -> Sealed<Truth> {
        Sealed::at(&Self::truth_file(&self.folder), &self.announcement.truth_sha256)
    }
}

/// Whether a trial's seal is open.
pub fn is_open(trial: &Trial) -> bool {
    opened_file(&Trial::truth_file(&trial.folder)).exists()
}

pub(super) fn json<T: Serialize>(value: &T, path: &Path) -> Result<String> {
    let text = serde_json::to_string_pretty(value).map_err(|error| {
        Error::new(ErrorKind::Syntax)
            .file(path)
            .found(error.to_string())
            .expected("a value that JSON can hold")
    })?;
    Ok(text + "\n")
}

/// Schema of `committed.json`.
const SCHEMA: &str = "slideway-verdicts/1";

/// The hashes of the verdicts committed so far.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    schema: String,
    /// SHA-256 of the truth that they are committed against.
    truth_sha256: String,
    /// By case.
    verdicts: BTreeMap<usize, Entry>,
}

/// One committed verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    sha256: String,
    /// Computing time on one core.
    seconds: f64,
}

impl Ledger {
    /// The verdicts of a trial that are committed; those whose file is gone are not.
    ///
    /// # Errors
    /// A ledger of another trial, or a verdict that is not the one that was committed.
    pub fn read(trial: &Trial) -> Result<Self> {
        let path = ledger_file(trial);
        let truth_sha256 = trial.announcement.truth_sha256.clone();
        if !path.is_file() {
            return Ok(Self { schema: SCHEMA.to_owned(), truth_sha256, verdicts: BTreeMap::new() });
        }
        let text = std::fs::read(&path).map_err(|error| Error::io(&path, &error))?;
        let mut ledger: Self = serde_json::from_slice(&text).map_err(|error| {
            Error::new(ErrorKind::Syntax)
                .file(&path)
                .found(error.to_string())
                .expected("the hashes of committed verdicts")
                .remedy("delete the folder of the verdicts and run the trial again")
        })?;
        if ledger.truth_sha256 != truth_sha256 {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&path)
                .key("truth_sha256")
                .found(ledger.truth_sha256)
                .expected(truth_sha256)
                .remedy("these verdicts are another trial's: delete their folder and run the trial again"));
        }
        ledger.verdicts.retain(|case, _| verdict_file(trial, *case).is_file());
        for (case, entry) in &ledger.verdicts {
            verdict_text(trial, *case, entry)?;
        }
        Ok(ledger)
    }

    /// Whether the verdict of a case is committed.
    pub fn contains(&self, case: usize) -> bool {
        self.verdicts.contains_key(&case)
    }

    /// Commits the verdict of a case: its file first, then its hash.
    ///
    /// # Errors
    /// Whatever the file system refuses.
    pub fn commit(&mut self, trial: &Trial, case: usize, verdict: &str, seconds: f64) -> Result<()> {
        write(&verdict_file(trial, case), verdict.as_bytes())?;
        self.verdicts.insert(case, Entry { sha256: sha256(verdict.as_bytes()), seconds });
        let path = ledger_file(trial);
        write(&path, json(self, &path)?.as_bytes())
    }
}

fn ledger_file(trial: &Trial) -> PathBuf {
    trial.verdicts().join("committed.json")
}

fn verdict_file(trial: &Trial, case: usize) -> PathBuf {
    trial.verdicts().join(format!("{case:03}.json"))
}

fn verdict_text(trial: &Trial, case: usize, entry: &Entry) -> Result<Vec<u8>> {
    let path = verdict_file(trial, case);
    let text = std::fs::read(&path).map_err(|error| Error::io(&path, &error))?;
    if sha256(&text) == entry.sha256 {
        return Ok(text);
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .file(&path)
        .found(format!("a file with the SHA-256 {}", sha256(&text)))
        .expected(format!("the committed verdict, {}", entry.sha256))
        .remedy("it was changed after it was committed: delete it and run the trial again"))
}

/// The verdicts of every case of a trial, committed and unchanged.
#[derive(Debug, Clone)]
pub struct CommittedVerdicts {
    ledger: PathBuf,
    truth_sha256: String,
    sha256: String,
    verdicts: Vec<Committed>,
}

/// One of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Committed {
    /// Case, from 1.
    pub case: usize,
    /// The verdict.
    pub said: Said,
    /// Computing time on one core.
    pub seconds: f64,
}

impl CommittedVerdicts {
    /// Reads the verdicts of a trial.
    ///
    /// # Errors
    /// A case without a committed verdict, or a verdict that is not the one that was committed.
    pub fn read(trial: &Trial) -> Result<Self> {
        let (ledger, path) = (Ledger::read(trial)?, ledger_file(trial));
        let missing: Vec<String> =
            trial.cases().filter(|case| !ledger.contains(*case)).map(|case| case.to_string()).collect();
        if !missing.is_empty() {
            return Err(Error::new(ErrorKind::Missing)
                .file(&path)
                .found(format!("no verdict on {} of {} cases", missing.len(), trial.announcement.cases))
                .expected("a committed verdict on every case before the truth is opened")
                .remedy(format!("slideway trial run {}", trial.folder.display())));
        }
        let read = |(case, entry): (&usize, &Entry)| -> Result<Committed> {
            let text = verdict_text(trial, *case, entry)?;
            let said = Said::parse(&text).map_err(|error| error.file(verdict_file(trial, *case)))?;
            Ok(Committed { case: *case, said, seconds: entry.seconds })
        };
        let verdicts: Vec<Committed> = ledger.verdicts.iter().map(read).collect::<Result<_>>()?;
        let text = std::fs::read(&path).map_err(|error| Error::io(&path, &error))?;
        Ok(Self { ledger: path, truth_sha256: ledger.truth_sha256, sha256: sha256(&text), verdicts })
    }

    /// The verdicts, by case.
    pub fn verdicts(&self) -> &[Committed] {
        &self.verdicts
    }
}
