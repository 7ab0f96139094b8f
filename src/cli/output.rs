//! Files that a command writes beside its tables: whole or not at all.

use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

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

    /// Where the figures go.
    pub(super) fn figures(&self) -> Option<&Path> {
        self.figures.as_deref()
    }

    /// Makes sure before the work begins that they can be written, apart from what else is written and from what is read.
    pub(super) fn check_places(&self, further: &[Output], inputs: &[&Path]) -> Result<(), Error> {
        let own = [
            Output::file("--html", self.html.as_deref()),
            Output { option: "--figures", path: self.figures.as_deref(), kind: Kind::Figures },
        ];
        check_apart(&own.into_iter().chain(further.iter().copied()).collect::<Vec<_>>(), inputs)?;
        self.html.iter().try_for_each(|path| check_place(path, "--html"))?;
        self.figures.iter().try_for_each(|folder| check_figures(folder))
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

/// A folder for figures: new, or with no drawing in it but earlier ones of this program.
fn check_figures(folder: &Path) -> Result<(), Error> {
    let refuse =
        |found: &str, expected| Err(refused(folder, "--figures", found, expected, "name another folder"));
    if folder.as_os_str().is_empty() {
        return refuse("an empty path", "a folder");
    }
    if folder.exists() && !folder.is_dir() {
        return refuse("a file", "a folder");
    }
    let above = folder.ancestors().find(|above| above.as_os_str().is_empty() || above.exists());
    let above = above.filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !above.is_dir() {
        return refuse("a path through a file", "a folder");
    }
    // Which figures come is not known before the work.
    let mut there: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    there.sort();
    let is_svg = |path: &&PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg"));
    if let Some(foreign) = there.iter().filter(is_svg).find(|path| !is_ours(path, "svg")) {
        let found = "a drawing that is there already and is no figure of slideway";
        let expected = "a folder without drawings that a figure could write over";
        return Err(refused(foreign, "--figures", found, expected, "name another folder"));
    }
    whole::probe_file(&above.join("figure.svg")).map_err(|error| error.key("--figures"))
}

/// What becomes of a place that a command writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A file.
    File,
    /// A folder that is put in its place as a whole.
    Whole,
    /// A folder that figures are put into, beside what is there.
    Figures,
}

/// A place that an option writes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Output<'a> {
    option: &'a str,
    path: Option<&'a Path>,
    kind: Kind,
}

impl<'a> Output<'a> {
    /// A file.
    pub(super) fn file(option: &'a str, path: Option<&'a Path>) -> Self {
        Self { option, path, kind: Kind::File }
    }

    /// A folder that is put in its place as a whole: what else lies in it would go, or keep it from being replaced.
    pub(super) fn whole(option: &'a str, path: Option<&'a Path>) -> Self {
        Self { option, path, kind: Kind::Whole }
    }

    /// Whether something at the other place would be written over or taken away with it.
    fn would_take(&self, own: &Path, other: &Path, is_drawing: bool) -> bool {
        match self.kind {
            Kind::File => other == own,
            Kind::Whole => other.starts_with(own),
            Kind::Figures => other == own || (is_drawing && other.parent() == Some(own)),
        }
    }
}

/// The paths that were given.
pub(super) fn given<'a>(paths: impl IntoIterator<Item = &'a Option<PathBuf>>) -> Vec<&'a Path> {
    paths.into_iter().flatten().map(PathBuf::as_path).collect()
}

/// Makes sure that no output is written over another one, lies in a folder that another one puts in place, or is what is read.
pub(super) fn check_apart(outputs: &[Output], inputs: &[&Path]) -> Result<(), Error> {
    let named: Vec<(&Output, &Path, PathBuf)> =
        outputs.iter().filter_map(|output| Some((output, output.path?, real(output.path?)))).collect();
    for (k, (output, path, place)) in named.iter().enumerate() {
        for (other, _, other_place) in &named[..k] {
            let is_drawing = |path: &Path| path.extension().is_some_and(|ending| ending == "svg");
            if output.would_take(place, other_place, is_drawing(other_place))
                || other.would_take(other_place, place, is_drawing(place))
            {
                let found = match place == other_place {
                    true => format!("the place that {} writes", other.option),
                    false => format!("a place that is not apart from that of {}", other.option),
                };
                let expected = "a place of its own";
                return Err(refused(path, output.option, &found, expected, "name another place"));
            }
        }
        let takes =
            |input: &&&Path| output.kind != Kind::Figures && output.would_take(place, &real(input), false);
        if let Some(input) = inputs.iter().find(takes) {
            let found = format!("the place of {}, which is read", input.display());
            let expected = "a place that holds no input";
            return Err(refused(path, output.option, &found, expected, "name another place"));
        }
    }
    Ok(())
}

/// Makes sure that nothing is written below the folders of a trial: what lies there is sealed or committed.
pub(super) fn check_outside(trial: &Path, outputs: &[Output]) -> Result<(), Error> {
    let trial = real(trial);
    let is_below =
        |path: &Path| real(path).parent().is_some_and(|folder| folder.starts_with(&trial) && folder != trial);
    let Some((output, path)) = outputs.iter().find_map(|o| Some((o, o.path.filter(|path| is_below(path))?)))
    else {
        return Ok(());
    };
    let found = "a file among those of the trial";
    Err(refused(path, output.option, found, "a file of its own", "name a file outside the trial"))
}

/// The path without links, `.` and `..`; its last parts need not exist.
fn real(path: &Path) -> PathBuf {
    if let Ok(real) = path.canonicalize() {
        return real;
    }
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    match (path.parent(), path.components().next_back()) {
        (Some(parent), Some(Component::Normal(name))) => real(parent).join(name),
        (Some(parent), Some(Component::ParentDir)) => {
            let parent = real(parent);
            parent.parent().map_or(parent.clone(), Path::to_path_buf)
        }
        _ => path,
    }
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
