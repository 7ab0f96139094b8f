//! Files that a command writes beside its tables: whole or not at all.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use slideway::error::{Error, ErrorKind};
use slideway::report::html::Page;
use slideway::whole;

use super::Screen;

/// The report as a page, and its figures for papers.
#[derive(Debug, Args)]
pub(super) struct Pictures {
    /// Write the report as one self-contained HTML file
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the report's figures as SVG files into this folder
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
}

impl Pictures {
    /// Whether any are asked for.
    pub(super) fn are_wanted(&self) -> bool {
        self.html.is_some() || self.figures.is_some()
    }

    /// Where the page goes.
    pub(super) fn html(&self) -> Option<&Path> {
        self.html.as_deref()
    }

    /// Where the figures go.
    pub(super) fn figures(&self) -> Option<&Path> {
        self.figures.as_deref()
    }

    /// Makes sure that they can be written before the work begins.
    pub(super) fn check_places(&self) -> Result<(), Error> {
        self.html.iter().try_for_each(|path| check_place(path, "--html"))?;
        let Some(folder) = &self.figures else { return Ok(()) };
        if folder.exists() && !folder.is_dir() {
            return Err(refused(folder, "--figures", "a file", "a folder", "name another folder"));
        }
        let above = folder.ancestors().find(|above| above.as_os_str().is_empty() || above.exists());
        let above = above.filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !above.is_dir() {
            return Err(refused(
                folder,
                "--figures",
                "a path through a file",
                "a folder",
                "name another folder",
            ));
        }
        whole::probe_file(&above.join("figure.svg")).map_err(|error| error.key("--figures"))
    }

    /// Writes what is asked for; the screen names it.
    pub(super) fn write(&self, page: &Page, screen: &mut Screen) -> Result<(), Error> {
        if let Some(path) = &self.html {
            write(path, &page.html)?;
            screen.written.push(path.clone());
        }
        let Some(folder) = &self.figures else { return Ok(()) };
        std::fs::create_dir_all(folder).map_err(|error| {
            Error::io(folder, &error).key("--figures").remedy("name a folder in which you may write")
        })?;
        let files: Vec<(PathBuf, String)> = page
            .figures
            .iter()
            .map(|figure| (folder.join(format!("{}.svg", figure.name)), figure.file()))
            .collect();
        if let Some((foreign, _)) = files.iter().find(|(path, _)| path.exists() && !is_ours(path, "svg")) {
            let found = "a file that is there already and is no figure of slideway";
            return Err(refused(foreign, "--figures", found, "a new file", "name another folder"));
        }
        let files: Vec<(&Path, &[u8])> =
            files.iter().map(|(path, text)| (path.as_path(), text.as_bytes())).collect();
        whole::write_all(&files)?;
        screen.written.push(folder.clone());
        Ok(())
    }
}

/// What was typed, as a line that can be pasted.
pub(super) fn command_line() -> String {
    let quoted = |word: String| {
        let is_plain = |c: char| c.is_alphanumeric() || "-_./=@:,+".contains(c);
        if !word.is_empty() && word.chars().all(is_plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    let words = std::env::args_os().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    ["slideway".to_owned()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
}

fn refused(path: &Path, option: &str, found: &str, expected: &str, remedy: &str) -> Error {
    Error::new(ErrorKind::Io).file(path).key(option).found(found).expected(expected).remedy(remedy)
}

/// Endings of what a recording or a machine is made of.
const INPUTS: [&str; 7] = ["toml", "csv", "parquet", "urdf", "stl", "obj", "dae"];

/// Makes sure that no two options write the same file.
pub(super) fn check_apart(places: &[(&str, Option<&Path>)]) -> Result<(), Error> {
    let place =
        |path: &Path| folder(path).canonicalize().ok().map(|f| f.join(path.file_name().unwrap_or_default()));
    for (k, (option, path)) in places.iter().enumerate() {
        let Some(path) = path else { continue };
        let is_same =
            |(_, other): &&(&str, Option<&Path>)| other.is_some_and(|other| place(other) == place(path));
        if let Some((other, _)) = places[..k].iter().find(is_same) {
            let found = format!("the file that {other} writes");
            return Err(refused(path, option, &found, "a file of its own", "name another file"));
        }
    }
    Ok(())
}

/// Makes sure that a file can be written there before the work begins, and that it is no input that would be lost.
pub(super) fn check_place(path: &Path, option: &str) -> Result<(), Error> {
    if path.as_os_str().is_empty() {
        return Err(refused(path, option, "an empty path", "a file to write", "name a file"));
    }
    if path.is_dir() {
        return Err(refused(path, option, "a folder", "a file to write", "name a file in it"));
    }
    if !folder(path).is_dir() {
        let found = "a file in a folder that is not there";
        return Err(refused(path, option, found, "a folder", "make the folder first"));
    }
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if path.exists() && INPUTS.contains(&ending.as_str()) {
        let found = format!("a .{ending} file that is there already");
        return Err(refused(path, option, &found, "a file that holds no input", "name another file"));
    }
    if path.exists() && !path.is_file() {
        return Err(refused(path, option, "a device or pipe", "a file to write", "name a file"));
    }
    if path.exists() && !is_ours(path, &ending) {
        let found = "a file that is there already and is no report of slideway";
        return Err(refused(path, option, found, "a new file", "name another file, or move that one away"));
    }
    whole::probe_file(path).map_err(|error| error.key(option))
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes a file whole or not at all.
pub(super) fn write(path: &Path, text: &str) -> Result<(), Error> {
    whole::write(path, text.as_bytes())
}

/// What this program's reports begin with, by ending.
const OURS: [(&str, &str, &str); 3] = [
    ("html", "<!DOCTYPE html>", "<meta name=\"generator\" content=\"slideway"),
    ("json", "{", "\"schema\": \"slideway-"),
    ("svg", "<svg ", "role=\"img\""),
];
/// So much of a file tells whose it is.
const HEAD_BYTES: u64 = 4096;

/// Whether a file may be written over: an earlier report of this program, or nothing.
fn is_ours(path: &Path, ending: &str) -> bool {
    let mut head = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head));
    let head = String::from_utf8_lossy(&head);
    let is_like = |(of, begins, holds): &(&str, &str, &str)| {
        *of == ending && head.starts_with(begins) && head.contains(holds)
    };
    read.is_ok() && (head.is_empty() || OURS.iter().any(is_like))
}
