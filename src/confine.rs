//! Which files a file may name: what lies in its own folder, or in a folder that the user named.
//!
//! A machine or a recording comes from elsewhere, and what it names is opened. So a path in it does not lead out of its
//! folder, links followed, unless the user said so on the command line or with the environment variable `SLIDEWAY_DATA`.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::error::{Error, ErrorKind, Result};

/// Environment variable that says where the data of recordings with a `data_folder` are.
pub const DATA_VARIABLE: &str = "SLIDEWAY_DATA";

static ALLOWED: OnceLock<Vec<PathBuf>> = OnceLock::new();

/// Lets machines and recordings name files in these folders too; the first call in a process holds.
pub fn allow(folders: Vec<PathBuf>) {
    // Said once, by the command line.
    let _ = ALLOWED.set(folders);
}

/// Refuses a file that lies in none of the folders, nor in one that the user named. One that is not there passes: opening it
/// is refused.
///
/// # Errors
/// [`ErrorKind::Inconsistent`] with what to do.
pub fn check(path: &Path, folders: &[&Path]) -> Result<()> {
    let Ok(real) = path.canonicalize() else { return Ok(()) };
    let named = ALLOWED.get().into_iter().flatten().cloned();
    let data = std::env::var_os(DATA_VARIABLE).map(PathBuf::from);
    let own = folders.iter().map(|folder| folder.to_path_buf());
    let holds = |folder: PathBuf| {
        let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
        folder.canonicalize().is_ok_and(|folder| real.starts_with(folder))
    };
    if own.chain(named).chain(data).any(holds) {
        return Ok(());
    }
    let own = folders.first().map_or(Path::new("."), |folder| folder);
    Err(Error::new(ErrorKind::Inconsistent)
        .found(format!("the path {}, which leads out of the folder", path.display()))
        .expected(format!("a file in {}", if own.as_os_str().is_empty() { Path::new(".") } else { own }.display()))
        .remedy(
            "move the file into that folder, or name the folder it is in: --allow-outside DIR, or the environment variable SLIDEWAY_DATA",
        ))
}

/// Reads a text of at most so many bytes.
///
/// # Errors
/// What is no regular file, is larger, or is no UTF-8.
pub fn read_text(path: &Path, most_bytes: u64) -> Result<String> {
    check_regular(path, most_bytes)?;
    let bytes = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let line = bytes.iter().take(valid).filter(|byte| **byte == b'\n').count() as u64 + 1;
        let (found, row) = match bytes {
            [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => ("UTF-16 text".to_owned(), None),
            _ => (
                format!("the byte {:#04x}, which is no text", bytes.get(valid).copied().unwrap_or(0)),
                Some(line),
            ),
        };
        let error = Error::new(ErrorKind::Syntax)
            .file(path)
            .found(found)
            .expected("UTF-8 text")
            .remedy("save the file as UTF-8");
        row.map_or(error.clone(), |row| error.row(row))
    })
}

/// Refuses a folder, a device, and a file of more than so many bytes.
///
/// # Errors
/// As said; a file that is not there too.
pub fn check_regular(path: &Path, most_bytes: u64) -> Result<()> {
    let about = std::fs::metadata(path).map_err(|error| Error::io(path, &error))?;
    let refuse = |found: String, expected: &str| {
        Err(Error::new(ErrorKind::Io).file(path).found(found).expected(expected).remedy("correct the path"))
    };
    if about.is_dir() {
        return refuse("a folder".to_owned(), "a file");
    }
    if !about.is_file() {
        return refuse("a device or pipe".to_owned(), "a file");
    }
    if about.len() > most_bytes {
        let (found, most) = (about.len() as f64 / 1e6, most_bytes as f64 / 1e6);
        return refuse(format!("{found:.0} MB"), &format!("at most {most:.0} MB"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_path_does_not_lead_out_of_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let (own, other) = (folder.path().join("own"), folder.path().join("other"));
        for place in [&own, &other] {
            std::fs::create_dir(place).unwrap();
            std::fs::write(place.join("a"), "1").unwrap();
        }
        assert!(check(&own.join("a"), &[&own]).is_ok());
        assert!(check(&other.join("a"), &[&own, &other]).is_ok());
        for path in [other.join("a"), own.join("../other/a")] {
            assert_eq!(check(&path, &[&own]).unwrap_err().kind(), ErrorKind::Inconsistent);
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(other.join("a"), own.join("link")).unwrap();
            assert!(check(&own.join("link"), &[&own]).is_err());
        }
    }

    #[test]
    fn exact_folders_and_large_files_are_no_texts() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, "12345").unwrap();
        assert_eq!(read_text(&file, 5).unwrap(), "12345");
        assert!(read_text(&file, 4).is_err() && read_text(folder.path(), 5).is_err());
        std::fs::write(&file, b"a\nb\xFF").unwrap();
        assert_eq!(read_text(&file, 5).unwrap_err().row_number(), Some(2));
    }
}
