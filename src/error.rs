//! The one error type: where it happened, what was read, what was expected, what to do.
//!
//! Outcomes that are part of a result (not excited, no gap, undecided) are values of that result;
//! an [`Error`] is broken input or a file that cannot be read or written.

pub(crate) mod guarded;
mod plain;
pub(crate) mod spelling;
pub(crate) mod toml_text;

use std::fmt;
use std::path::{Path, PathBuf};

pub(crate) use plain::plain;

/// Characters of each part of a refusal at most.
const MOST_SHOWN: usize = 600;
/// Characters of a key at most.
const MOST_OF_KEY: usize = 160;

/// Short form of `Result` with this crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What rule was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A file could not be opened, read or written.
    Io,
    /// The text of a file does not follow its format (TOML, CSV, URDF, OBJ, STL, Parquet).
    Syntax,
    /// A key that the format does not know.
    UnknownKey,
    /// A key, column, link or file that must be there is not.
    Missing,
    /// NaN or infinity where a finite number is needed.
    NotFinite,
    /// A number outside the range that its meaning allows.
    OutOfRange,
    /// A unit that is unknown or measures something else.
    Unit,
    /// Two statements that cannot both be true.
    Inconsistent,
    /// A mesh that does not enclose a volume.
    OpenMesh,
    /// Too little data for what was asked.
    TooLittleData,
    /// The numbers do not determine an answer (singular, not converged).
    Undetermined,
}

#[derive(Debug, Clone, Default)]
struct Place {
    file: Option<PathBuf>,
    row: Option<u64>,
    key: Option<String>,
}

/// A refusal that names the place, what was read, what was expected and what to do.
///
/// ```
/// use slideway::error::{Error, ErrorKind};
/// let error = Error::new(ErrorKind::NotFinite)
///     .file("log.csv").row(20_431).key("position_m")
///     .found("nan").expected("a finite number")
///     .remedy("remove the row or fill the gap before diagnosing");
/// assert_eq!(
///     error.to_string(),
///     "log.csv, row 20431, `position_m`: read nan, expected a finite number; \
///      remove the row or fill the gap before diagnosing"
/// );
/// ```
#[derive(Debug, Clone)]
pub struct Error(Box<Detail>);

#[derive(Debug, Clone)]
struct Detail {
    kind: ErrorKind,
    place: Place,
    found: Option<String>,
    expected: Option<String>,
    remedy: Option<String>,
}

impl Error {
    /// A refusal of the given kind; say the rest with the methods below.
    pub fn new(kind: ErrorKind) -> Self {
        Self(Box::new(Detail { kind, place: Place::default(), found: None, expected: None, remedy: None }))
    }

    /// A file that could not be read or written.
    pub fn io(path: impl AsRef<Path>, error: &std::io::Error) -> Self {
        Self::new(ErrorKind::Io).file(path).found(said(error)).expected("a file that can be opened").remedy(
            match error.kind() {
                std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
                    "make room on the disk, or write elsewhere"
                }
                _ => "check the path and its permissions",
            },
        )
    }

    /// The file in which it happened; an empty path names none. Kept if one was named already (the innermost knows best).
    #[must_use]
    pub fn file(mut self, path: impl AsRef<Path>) -> Self {
        if !path.as_ref().as_os_str().is_empty() {
            self.0.place.file.get_or_insert_with(|| path.as_ref().to_path_buf());
        }
        self
    }

    /// The row (of a table, counted from 1 with the header as row 1) or line of a text.
    #[must_use]
    pub fn row(mut self, row: u64) -> Self {
        self.0.place.row.get_or_insert(row);
        self
    }

    /// The key, column, link or signal. Kept if one was named already.
    #[must_use]
    pub fn key(mut self, key: impl Into<String>) -> Self {
        self.0.place.key.get_or_insert_with(|| key.into());
        self
    }

    /// The same refusal at another place: that of the words which caused it.
    #[must_use]
    pub fn moved_to(mut self, path: impl AsRef<Path>, key: impl Into<String>) -> Self {
        let row = None;
        self.0.place = Place { file: Some(path.as_ref().to_path_buf()), row, key: Some(key.into()) };
        self
    }

    /// The same refusal, of what was typed: an option of the command.
    #[must_use]
    pub fn typed(mut self, option: impl Into<String>) -> Self {
        self.0.place = Place { file: None, row: None, key: Some(option.into()) };
        self
    }

    /// What was read.
    #[must_use]
    pub fn found(mut self, found: impl Into<String>) -> Self {
        self.0.found = Some(found.into());
        self
    }

    /// What would have been right.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.0.expected = Some(expected.into());
        self
    }

    /// What to do about it.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.0.remedy = Some(remedy.into());
        self
    }

    /// Which rule was broken.
    pub fn kind(&self) -> ErrorKind {
        self.0.kind
    }

    /// The file, if one is concerned.
    pub fn path(&self) -> Option<&Path> {
        self.0.place.file.as_deref()
    }

    /// The row or line, counted from 1.
    pub fn row_number(&self) -> Option<u64> {
        self.0.place.row
    }

    /// The key, column, link or signal.
    pub fn key_name(&self) -> Option<&str> {
        self.0.place.key.as_deref()
    }

    /// What to do about it.
    pub fn remedy_text(&self) -> Option<&str> {
        self.0.remedy.as_deref()
    }

    fn place_text(&self) -> String {
        let Place { file, row, key } = &self.0.place;
        let parts = [
            file.as_ref().map(|f| plain(&f.display().to_string(), MOST_SHOWN)),
            row.map(|r| format!("row {r}")),
            key.as_ref().map(|k| format!("`{}`", plain(k, MOST_OF_KEY))),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    /// The sentence without the remedy: place, what was read, what was expected.
    pub fn statement(&self) -> String {
        let place = self.place_text();
        let mut text = if place.is_empty() { String::new() } else { format!("{place}: ") };
        let shown = |part: &Option<String>| part.as_ref().map(|part| plain(part, MOST_SHOWN));
        match (shown(&self.0.found), shown(&self.0.expected)) {
            (Some(found), Some(expected)) => text += &format!("read {found}, expected {expected}"),
            (Some(found), None) => text += &format!("read {found}"),
            (None, Some(expected)) => text += &format!("expected {expected}"),
            (None, None) => text += &format!("{:?}", self.0.kind),
        }
        text
    }
}

/// What the system says of a file, in plain words.
pub(crate) fn said(error: &std::io::Error) -> String {
    use std::io::ErrorKind as E;
    match error.kind() {
        E::NotFound => "no such file or folder".to_owned(),
        E::PermissionDenied => "no permission".to_owned(),
        E::AlreadyExists => "a file or folder that is there already".to_owned(),
        E::IsADirectory => "a folder".to_owned(),
        E::NotADirectory => "a path through a file".to_owned(),
        E::StorageFull => "a full disk".to_owned(),
        E::QuotaExceeded => "a quota that is used up".to_owned(),
        E::ReadOnlyFilesystem => "a file system that is read only".to_owned(),
        _ => error.to_string(),
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.statement())?;
        match &self.0.remedy {
            Some(remedy) => write!(f, "; {remedy}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_innermost_place_is_kept() {
        let error = Error::new(ErrorKind::Missing).file("inner.csv").file("outer.toml").key("a").key("b");
        assert_eq!(error.path(), Some(Path::new("inner.csv")));
        assert_eq!(error.key_name(), Some("a"));
    }
}
