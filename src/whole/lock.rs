//! One process at a time in a folder.

use std::fs::{File, TryLockError};
use std::path::Path;

use crate::error::{Error, ErrorKind, Result};

const NAME: &str = ".lock";

/// A folder that this process works in; free again when it is dropped, and when the process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

/// Takes a folder for this process alone.
///
/// # Errors
/// Another process that works there; whatever the file system refuses.
pub fn lock(folder: &Path) -> Result<Lock> {
    let path = folder.join(NAME);
    let failed =
        |error: &std::io::Error| Error::io(folder, error).expected("a folder in which files can be made");
    let file = File::options()
        .create(true)
        .truncate(false)
        .write(true)
        .open(&path)
        .map_err(|error| failed(&error))?;
    match file.try_lock() {
        Ok(()) => Ok(Lock { _file: file }),
        Err(TryLockError::WouldBlock) => Err(Error::new(ErrorKind::Io)
            .file(folder)
            .found("a folder that another slideway works in")
            .expected("one command at a time")
            .remedy("wait until the other one has ended, then give this command again")),
        Err(TryLockError::Error(error)) => Err(failed(&error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_folder_is_taken_once() {
        let folder = tempfile::tempdir().unwrap();
        let first = lock(folder.path()).unwrap();
        assert!(lock(folder.path()).is_err());
        drop(first);
        assert!(lock(folder.path()).is_ok());
    }
}
