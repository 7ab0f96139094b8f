//! A trial on disk.

use super::engine::Engine;
use super::seed::Seed;
use super::tier::Tier;
use crate::effect::EffectId;
use crate::error::{Error, ErrorKind, Result, toml_text};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Schema of `trial.toml`.
pub const SCHEMA: &str = "slideway-trial/2";
const FILE_NAME: &str = "trial.toml";

/// The content of `trial.toml`: what anyone may know of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Announcement {
    /// `slideway-trial/2`.
    pub schema: String,
    /// Version of the program that forged it.
    pub version: String,
    /// Seed.
    pub seed: u64,
    /// `development` or `judging`, as the seed says.
    pub purpose: String,
    /// Tiers in it, mixed.
    pub tiers: Vec<Tier>,
    /// Number of cases.
    pub cases: usize,
    /// Name of the machine.
    pub machine: String,
    /// SHA-256 of its machine file.
    pub machine_sha256: String,
    /// Engine that the recordings are simulated on.
    pub engine: Engine,
    /// SHA-256 of the sealed truth.
    pub truth_sha256: String,
    /// Effects that were not forged, and why.
    #[serde(default)]
    pub skipped: Vec<Skipped>,
}

/// An effect that was not forged.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Skipped {
    /// Which one.
    pub effect: EffectId,
    /// Why.
    pub reason: String,
}

/// What a diagnosis of a case is told beside its recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Terms {
    /// Effects struck from the catalogue.
    pub without: Vec<EffectId>,
    /// Settings of the twin beyond the machine's file, by key path.
    #[serde(default)]
    pub twin: BTreeMap<String, f64>,
}

/// A forged trial: its folder and what may be known of it.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The folder.
    pub folder: PathBuf,
    /// What `trial.toml` says.
    pub announcement: Announcement,
    /// The seed.
    pub seed: Seed,
}

impl Trial {
    /// Reads `trial.toml`; nothing that is sealed.
    ///
    /// # Errors
    /// No such file, another schema, or a seed that is none.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(FILE_NAME);
        let text = std::fs::read_to_string(&path).map_err(|error| {
            Error::io(&path, &error)
                .expected("the folder of a forged trial")
                .remedy("name the folder that `slideway trial forge --out FOLDER` wrote")
        })?;
        let announcement: Announcement =
            toml::from_str(&text).map_err(|error| toml_text::refusal(&path, &text, &error))?;
        if announcement.schema != SCHEMA {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(&path)
                .key("schema")
                .found(announcement.schema)
                .expected(SCHEMA)
                .remedy("use the version of slideway that forged it, or forge it again"));
        }
        let seed = Seed::new(announcement.seed).map_err(|error| error.file(&path))?;
        Ok(Self { folder: folder.to_path_buf(), announcement, seed })
    }

    /// Announces a trial whose truth is sealed already.
    ///
    /// # Errors
    /// Whatever the file system refuses.
    pub fn announce(folder: &Path, announcement: Announcement) -> Result<Self> {
        let text = toml::to_string(&announcement).map_err(|error| {
            Error::new(ErrorKind::Syntax).file(folder).found(error.to_string()).expected("plain values")
        })?;
        write(&folder.join(FILE_NAME), text.as_bytes())?;
        Self::read(folder)
    }

    /// Whether a folder holds a trial.
    pub fn is_at(folder: &Path) -> bool {
        folder.join(FILE_NAME).is_file()
    }

    /// Numbers of the cases.
    pub fn cases(&self) -> std::ops::RangeInclusive<usize> {
        1..=self.announcement.cases
    }

    /// The recording of a case.
    pub fn case_folder(&self, case: usize) -> PathBuf {
        self.folder.join("cases").join(format!("{case:03}"))
    }

    /// The recording of a case's machine before it changed; there in the tier of changes only.
    pub fn reference_folder(&self, case: usize) -> PathBuf {
        self.folder.join("cases").join(format!("{case:03}.before"))
    }

    /// What a diagnosis of a case is told.
    ///
    /// # Errors
    /// A file that is not there or names what is no effect.
    pub fn terms(&self, case: usize) -> Result<Terms> {
        let path = self.terms_file(case);
        let text = std::fs::read_to_string(&path).map_err(|error| {
            Error::io(&path, &error)
                .remedy("the trial is not forged to its end: run `slideway trial forge` again")
        })?;
        toml::from_str(&text).map_err(|error| toml_text::refusal(&path, &text, &error))
    }

    /// Writes what a diagnosis of a case is told: the last file of a case.
    pub(super) fn state(&self, case: usize, terms: &Terms) -> Result<()> {
        let path = self.terms_file(case);
        let text = toml::to_string(terms).map_err(|error| {
            Error::new(ErrorKind::Syntax).file(&path).found(error.to_string()).expected("names and numbers")
        })?;
        write(&path, text.as_bytes())
    }

    /// Beside the recording, not in it: a recording's folder holds nothing else.
    fn terms_file(&self, case: usize) -> PathBuf {
        self.folder.join("cases").join(format!("{case:03}.case.toml"))
    }

    /// Whether a case is forged.
    pub fn is_forged(&self, case: usize) -> bool {
        self.case_folder(case).join("recording.toml").is_file() && self.terms_file(case).is_file()
    }

    /// Where the truth of a trial in `folder` lies.
    pub fn truth_file(folder: &Path) -> PathBuf {
        folder.join("sealed").join("truth.json")
    }

    /// Folder of the verdicts.
    pub fn verdicts(&self) -> PathBuf {
        self.folder.join("verdicts")
    }
}

/// SHA-256 in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Writes a file whole or not at all; makes its folder.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error).expected("a folder"))?;
    crate::whole::write(path, bytes)
}
