//! Putting a folder in its place: whole, at once, and without losing what stood there.
//!
//! A folder is built beside its place under a hidden name. Where nothing stands, it is renamed into place. Where something is to
//! be replaced, the two are exchanged in one step, so that a kill at any moment leaves the old one or the new one there. On file
//! systems without that step the old one is moved away first, and the next run moves it back if nothing came after it.
//!
//! Whoever builds holds a lock on the build. What a killed run left is found by its lock, which nobody holds any more, and
//! taken away by the next run that writes beside it.

use std::fs::File;
use std::path::{Path, PathBuf};

use crate::error::{Error, ErrorKind, Result};

/// A folder under way beside its place, locked; taken away when it is dropped.
#[derive(Debug)]
pub(crate) struct Build {
    folder: tempfile::TempDir,
    /// Held until the end.
    _lock: File,
}

/// Name of the lock in a build.
const LOCK: &str = "lock";
/// Name of the fresh folder in a build.
const NEW: &str = "new";
/// Name of the replaced folder in a build, where it could not be exchanged, and of the note that says where it stood.
const OLD: &str = "old";
const NOTE: &str = "stood";
/// Starts of one build at most. One is lost only where another run looks between two calls of the file system.
const STARTS: usize = 100;

impl Build {
    /// A build beside `place`; leftovers of killed runs there are taken away first.
    pub(crate) fn beside(place: &Path, prefix: &str) -> Result<Self> {
        let parent = parent(place);
        std::fs::create_dir_all(parent).map_err(|error| Error::io(parent, &error).expected("a folder"))?;
        clean(parent, prefix);
        // Files are tried by making one; the answer names the folder, not the file.
        let failed = |error: &std::io::Error| {
            Error::io(parent, error)
                .expected("a folder in which files can be made")
                .remedy("name a place where you may write")
        };
        let start = || -> std::io::Result<_> {
            let folder = tempfile::Builder::new().prefix(prefix).tempdir_in(parent)?;
            let lock = File::create(folder.path().join(LOCK))?;
            lock.lock()?;
            // One level below, because the temporary folder itself is readable by its owner only.
            std::fs::create_dir(folder.path().join(NEW))?;
            Ok((folder, lock))
        };
        // Another run takes the folder for a leftover until its lock is held; it is gone then, and made anew.
        let mut started = start();
        for _ in 1..STARTS {
            match &started {
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => started = start(),
                _ => break,
            }
        }
        let (folder, lock) = started.map_err(|error| failed(&error))?;
        Ok(Self { folder, _lock: lock })
    }

    /// The folder to be filled.
    pub(crate) fn fresh(&self) -> PathBuf {
        self.folder.path().join(NEW)
    }

    /// Moves the filled folder to its place, instead of what stands there where that may be replaced.
    ///
    /// # Errors
    /// A place that was taken meanwhile and may not be replaced; whatever the file system refuses.
    pub(crate) fn put(self, place: &Path, replace: bool) -> Result<()> {
        let fresh = self.fresh();
        let failed = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::DirectoryNotEmpty | std::io::ErrorKind::AlreadyExists => {
                Error::new(ErrorKind::Io)
                    .file(place)
                    .found("a folder that was filled meanwhile")
                    .expected("a new or empty folder")
                    .remedy("another run writes there: name another folder")
            }
            _ => Error::io(place, &error).expected("a place where a folder can be put"),
        };
        if replace && place.exists() {
            return exchange(&fresh, place).or_else(|_| self.move_over(place)).map_err(failed);
        }
        // Takes the place of an empty folder, and of no other.
        std::fs::rename(&fresh, place).map_err(failed)
    }

    /// Without an exchange: the old folder is moved away, with a note for the next run until the new one stands.
    fn move_over(&self, place: &Path) -> std::io::Result<()> {
        let (old, note) = (self.folder.path().join(OLD), self.folder.path().join(NOTE));
        let name = place.file_name().unwrap_or_default();
        std::fs::write(&note, name.as_encoded_bytes())?;
        std::fs::rename(place, &old)?;
        let moved = std::fs::rename(self.fresh(), place);
        if moved.is_err() {
            std::fs::rename(&old, place)?;
        }
        moved
    }
}

/// Makes sure that a folder can be put there, before the work for it begins.
///
/// # Errors
/// As [`Build::beside`].
pub(crate) fn probe(place: &Path, prefix: &str) -> Result<()> {
    let parent = parent(place);
    // Folders above that are not there yet are made with the rest.
    let there = parent.ancestors().find(|folder| folder.as_os_str().is_empty() || folder.exists());
    let there = there.filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !there.is_dir() {
        return Err(Error::new(ErrorKind::Io)
            .file(place)
            .found(format!("a path through the file {}", there.display()))
            .expected("a new or empty folder")
            .remedy("name another folder"));
    }
    Build::beside(&there.join("probe"), prefix).map(drop)
}

fn parent(place: &Path) -> &Path {
    place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(any(target_os = "linux", target_os = "android"))]
fn exchange(a: &Path, b: &Path) -> std::io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE).map_err(Into::into)
}

#[cfg(not(any(target_os = "linux", target_os = "android")))]
fn exchange(_: &Path, _: &Path) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Takes away what killed runs left beside a place, and puts back what they had moved away.
fn clean(parent: &Path, prefix: &str) {
    let Ok(entries) = std::fs::read_dir(parent) else { return };
    for entry in entries.flatten() {
        let build = entry.path();
        if !entry.file_name().to_string_lossy().starts_with(prefix) || !build.is_dir() {
            continue;
        }
        let Ok(lock) = File::open(build.join(LOCK)) else {
            // Killed before its lock was there, and nothing is in it; or while it was taken away, its lock first.
            let is_left = std::fs::remove_dir(&build).is_err() && !build.join(LOCK).exists();
            if is_left && !build.join(OLD).exists() {
                let _ = std::fs::remove_dir_all(&build);
            }
            continue;
        };
        if lock.try_lock().is_err() {
            continue;
        }
        let stood = std::fs::read(build.join(NOTE)).ok().and_then(|name| String::from_utf8(name).ok());
        if let Some(place) = stood.map(|name| parent.join(name)).filter(|_| build.join(OLD).exists())
            && !place.exists()
            && std::fs::rename(build.join(OLD), &place).is_err()
        {
            continue;
        }
        // What cannot be taken away stays; the next run tries again.
        let _ = std::fs::remove_dir_all(&build);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, text: &str) {
        std::fs::create_dir_all(folder).unwrap();
        std::fs::write(folder.join("a"), text).unwrap();
    }

    fn names(folder: &Path) -> Vec<String> {
        std::fs::read_dir(folder).unwrap().flatten().map(|e| e.file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn exact_a_folder_is_put_in_place_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("x");
        for (text, replace) in [("1", false), ("2", true)] {
            let build = Build::beside(&place, ".b-").unwrap();
            write(&build.fresh(), text);
            build.put(&place, replace).unwrap();
            assert_eq!(std::fs::read_to_string(place.join("a")).unwrap(), text);
        }
        let build = Build::beside(&place, ".b-").unwrap();
        write(&build.fresh(), "3");
        assert!(build.put(&place, false).is_err());
        assert_eq!(std::fs::read_to_string(place.join("a")).unwrap(), "2");
        assert_eq!(names(folder.path()), ["x"]);
    }

    #[test]
    fn exact_builds_that_start_at_once_do_not_take_each_other_away() {
        let folder = tempfile::tempdir().unwrap();
        let build = |thread: usize| {
            for round in 0..100 {
                let place = folder.path().join(format!("{thread}-{round}"));
                let build = Build::beside(&place, ".b-").unwrap();
                write(&build.fresh(), "1");
                build.put(&place, false).unwrap();
            }
        };
        std::thread::scope(|scope| {
            for thread in 0..4 {
                scope.spawn(move || build(thread));
            }
        });
        assert_eq!(names(folder.path()).len(), 400);
    }

    #[test]
    fn exact_leftovers_are_taken_away_and_put_back() {
        let folder = tempfile::tempdir().unwrap();
        // One that is under way, one that was killed, one that was killed between two renames.
        let under_way = Build::beside(&folder.path().join("x"), ".b-").unwrap();
        write(&folder.path().join(".b-half").join(NEW), "1");
        for name in [".b-killed", ".b-moved"] {
            write(&folder.path().join(name), "1");
            std::fs::write(folder.path().join(name).join(LOCK), "").unwrap();
        }
        write(&folder.path().join(".b-moved").join(OLD), "kept");
        std::fs::write(folder.path().join(".b-moved").join(NOTE), "x").unwrap();
        clean(folder.path(), ".b-");
        assert_eq!(std::fs::read_to_string(folder.path().join("x/a")).unwrap(), "kept");
        assert!(under_way.fresh().is_dir());
        assert_eq!(names(folder.path()).len(), 2);
    }

    #[test]
    fn exact_without_an_exchange_the_old_folder_is_moved_over() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("x");
        write(&place, "old");
        let build = Build::beside(&place, ".b-").unwrap();
        write(&build.fresh(), "new");
        build.move_over(&place).unwrap();
        assert_eq!(std::fs::read_to_string(place.join("a")).unwrap(), "new");
    }
}
