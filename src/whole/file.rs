//! Files written under a hidden name beside their place, then renamed.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::Path;
use std::time::Duration;

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// How the hidden names begin.
const PREFIX: &str = ".slideway-";
/// A hidden file that was not touched for so long, and that nobody holds, was left by a run that was killed.
const LEFT_BEHIND: Duration = Duration::from_secs(60);

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn told(path: &Path, error: &io::Error) -> Error {
    let bare = error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error);
    // What a temporary file's error adds is the name of that file.
    let error = if matches!(bare.kind(), io::ErrorKind::Other) {
        Error::io(path, error)
    } else {
        Error::io(path, &bare)
    };
    error.expected("a file that can be written")
}

fn hidden(path: &Path) -> Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    // Temporary files are for their owner only; this one becomes a file like any other.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder(path)).map_err(|error| told(path, &error))?;
    // Held as long as it is under way; without locks only age tells.
    let _ = file.as_file().try_lock();
    Ok(file)
}

/// Makes sure that a file can be written there, before the work for it begins; takes away what killed runs left beside it.
///
/// # Errors
/// Whatever the file system refuses.
pub fn probe_file(path: &Path) -> Result<()> {
    clean(folder(path));
    hidden(path).map(drop)
}

/// Writes a file whole or not at all, in the place of one that is there.
///
/// # Errors
/// Whatever the file system refuses.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_all(&[(path, bytes)])
}

/// Writes several files; none of them where one cannot be written.
///
/// # Errors
/// Whatever the file system refuses.
pub fn write_all(files: &[(&Path, &[u8])]) -> Result<()> {
    let mut written = Vec::with_capacity(files.len());
    for (path, bytes) in files {
        let mut file = hidden(path)?;
        file.write_all(bytes).map_err(|error| told(path, &error))?;
        written.push((path, file));
    }
    written
        .into_iter()
        .try_for_each(|(path, file)| file.persist(path).map(drop).map_err(|error| told(path, &error.error)))
}

/// Takes away hidden files that killed runs left.
fn clean(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        if !entry.file_name().to_string_lossy().starts_with(PREFIX) {
            continue;
        }
        let age =
            entry.metadata().and_then(|about| about.modified()).ok().and_then(|time| time.elapsed().ok());
        if age.is_none_or(|age| age < LEFT_BEHIND) {
            continue;
        }
        let Ok(file) = File::open(entry.path()) else { continue };
        // What cannot be taken away stays.
        let _ = match file.try_lock() {
            Ok(()) if entry.path().is_dir() => std::fs::remove_dir_all(entry.path()),
            Ok(()) => std::fs::remove_file(entry.path()),
            Err(_) => Ok(()),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::SystemTime;

    #[test]
    fn exact_files_are_written_together_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let (a, b) = (folder.path().join("a"), folder.path().join("none/b"));
        assert!(write_all(&[(&a, b"1"), (&b, b"2")]).is_err());
        assert!(!a.exists() && std::fs::read_dir(folder.path()).unwrap().next().is_none());
        write(&a, b"1").unwrap();
        assert_eq!(std::fs::read(&a).unwrap(), b"1");
    }

    #[test]
    fn exact_old_leftovers_are_taken_away() {
        let folder = tempfile::tempdir().unwrap();
        for name in [".slideway-old", ".slideway-new", "notes"] {
            let file = File::create(folder.path().join(name)).unwrap();
            let age = if name.ends_with("new") { 0 } else { 3600 };
            file.set_modified(SystemTime::now() - Duration::from_secs(age)).unwrap();
        }
        probe_file(&folder.path().join("a")).unwrap();
        let mut names: Vec<_> =
            std::fs::read_dir(folder.path()).unwrap().flatten().map(|e| e.file_name()).collect();
        names.sort();
        assert_eq!(names, [".slideway-new", "notes"]);
    }
}
