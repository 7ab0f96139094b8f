//! Writing a machine as a folder of its own: all of it, or nothing.

use super::Machine;
use super::file_text::file_text;
use super::provenance::Provenance;
use crate::error::{Error, ErrorKind, Result};
use crate::recording::Existing;
use crate::whole::{Build, probe};
use sha2::{Digest, Sha256};
use std::path::{Component, Path, PathBuf};

/// The machine file of a machine folder.
const FILE_NAME: &str = "machine.toml";
/// How the names of folders under way begin.
const PREFIX: &str = ".machine-";
/// The file with the sources of the numbers, where there is one.
const README: &str = "README.md";
/// What was written, as `sha256sum --check` reads it: a file that differs was changed by hand.
const SUMS: &str = "written.sha256";

impl Machine {
    /// Writes the machine as a folder: `machine.toml` with the settings in force and one entry of provenance more,
    /// the URDF and the meshes that it names, the README beside the machine file, and the sums of all of them.
    ///
    /// Comments of the machine file are kept where its values can be changed in their places. The folder is built
    /// beside its place and renamed into it, so that a half-written machine is never seen.
    ///
    /// # Errors
    /// A folder that [`Machine::check_place`] refuses, a mesh outside the machine's folder, or whatever the file
    /// system refuses.
    pub fn write(&self, folder: &Path, provenance: Provenance, existing: Existing) -> Result<()> {
        Self::check_place(folder, existing)?;
        let build = Build::beside(folder, PREFIX)?;
        let fresh = build.fresh();
        let (urdf, files) = self.files()?;
        let text = file_text(&self.file, &self.table_with(provenance, &urdf)?)?;
        let machine_file = fresh.join(FILE_NAME);
        std::fs::write(&machine_file, text).map_err(|e| Error::io(&machine_file, &e))?;
        for (from, to) in files {
            copy(&from, &fresh.join(to))?;
        }
        let sums = fresh.join(SUMS);
        std::fs::write(&sums, sums_of(&fresh)?).map_err(|e| Error::io(&sums, &e))?;
        build.put(folder, true)
    }

    /// Refuses a folder that is not empty, unless an earlier diagnosis wrote the machine in it and nothing else is
    /// there. What was changed by hand since is replaced only where `existing` says so.
    ///
    /// # Errors
    /// As said, with what to do instead.
    pub fn check_place(folder: &Path, existing: Existing) -> Result<()> {
        let refuse = |found: String, remedy: &str| {
            Err(Error::new(ErrorKind::Io)
                .file(folder)
                .found(found)
                .expected("a new or empty folder, or a machine that an earlier diagnosis wrote")
                .remedy(remedy))
        };
        if !folder.exists() {
            return probe(folder, PREFIX);
        }
        if !folder.is_dir() {
            return refuse("a file".to_owned(), "name a folder");
        }
        let there = files_below(folder)?;
        if there.is_empty() {
            return probe(folder, PREFIX);
        }
        let another = "name another folder: what stands there was not written by a diagnosis";
        if !there.contains(&PathBuf::from(FILE_NAME)) {
            return refuse(format!("a folder with {} files that is not a machine", there.len()), another);
        }
        let Ok(machine) = Self::read(folder) else {
            return refuse("a machine that cannot be read".to_owned(), another);
        };
        if machine.description.provenance.is_empty() {
            return refuse("a machine without [[provenance]]".to_owned(), another);
        }
        let (_, own) = machine.files()?;
        let foreign = there.iter().find(|file| {
            !([FILE_NAME, SUMS].map(Path::new).contains(&file.as_path())
                || own.iter().any(|(_, to)| to == *file))
        });
        if let Some(foreign) = foreign {
            return refuse(
                format!("`{}`, which the machine there does not name", foreign.display()),
                "move it away first: replacing would delete it",
            );
        }
        match changed(folder)? {
            Some(changed) if existing == Existing::Refuse => refuse(
                format!("`{changed}`, which was changed since it was written"),
                "name another folder; --replace overwrites it",
            ),
            _ => probe(folder, PREFIX),
        }
    }

    /// The machine's table with one entry of provenance more, the URDF at its place in the written folder.
    fn table_with(&self, provenance: Provenance, urdf: &Path) -> Result<toml::Table> {
        let mut table = (*self.table).clone();
        let entry = toml::Value::try_from(provenance).map_err(|e| {
            Error::new(ErrorKind::Syntax).key("provenance").found(e.to_string()).expected("numbers and texts")
        })?;
        let list = table.entry("provenance").or_insert_with(|| toml::Value::Array(Vec::new()));
        if let toml::Value::Array(list) = list {
            list.push(entry);
        }
        table.insert("urdf".to_owned(), urdf.to_string_lossy().into_owned().into());
        Ok(table)
    }

    /// The URDF's place in a folder of the machine's own, and every file beside the machine file with its place.
    fn files(&self) -> Result<(PathBuf, Vec<(PathBuf, PathBuf)>)> {
        let stated = PathBuf::from(&self.description.urdf);
        let name = || PathBuf::from(self.solid.path.file_name().unwrap_or_default());
        // Meshes are found from the URDF: below the machine's folder it stays where it is, and they with it.
        let urdf = if is_inside(&stated) { stated } else { name() };
        let beside = urdf.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut files = vec![(self.solid.path.clone(), urdf.clone())];
        for (written, path) in self.solid.mesh_files()? {
            if written.is_absolute() {
                continue; // found from anywhere
            }
            if !is_inside(&written) {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .file(&self.solid.path)
                    .found(format!("the mesh {}", written.display()))
                    .expected("meshes in the URDF's folder, so that they can be copied with it")
                    .remedy("move the meshes below the URDF's folder, or give their absolute path"));
            }
            files.push((path, beside.join(written)));
        }
        let readme = self.file.parent().unwrap_or(Path::new("")).join(README);
        if readme.is_file() {
            files.push((readme, PathBuf::from(README)));
        }
        files.sort();
        files.dedup();
        Ok((urdf, files))
    }
}

/// Whether a relative path stays below where it begins.
fn is_inside(path: &Path) -> bool {
    path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    let folder = to.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, &e))?;
    // Contents only: a read-only original must not make the copy read-only.
    let content = std::fs::read(from).map_err(|e| Error::io(from, &e))?;
    std::fs::write(to, content).map_err(|e| Error::io(to, &e))
}

/// The sum and the name of every file below a folder, a line each, but for the sums themselves.
fn sums_of(folder: &Path) -> Result<String> {
    let mut files = files_below(folder)?;
    files.sort();
    files.retain(|file| file.as_os_str() != SUMS);
    let line = |file: &PathBuf| {
        let bytes = std::fs::read(folder.join(file)).map_err(|e| Error::io(folder.join(file), &e))?;
        let sum: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(format!("{sum}  {}\n", file.display()))
    };
    files.iter().map(line).collect()
}

/// The first file of a written machine that is not as it was written; the sums where they are gone.
fn changed(folder: &Path) -> Result<Option<String>> {
    let Ok(written) = std::fs::read_to_string(folder.join(SUMS)) else { return Ok(Some(SUMS.to_owned())) };
    let now = sums_of(folder)?;
    let other = now.lines().chain(written.lines());
    let mut other =
        other.filter(|line| !(now.lines().any(|l| l == *line) && written.lines().any(|l| l == *line)));
    Ok(other.next().map(|line| line.split_once("  ").map_or(line, |(_, name)| name).to_owned()))
}

/// Every file below a folder, relative to it.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut open = vec![PathBuf::new()];
    while let Some(inner) = open.pop() {
        let entries = std::fs::read_dir(folder.join(&inner)).map_err(|e| Error::io(folder, &e))?;
        for entry in entries {
            let entry = entry.map_err(|e| Error::io(folder, &e))?;
            let place = inner.join(entry.file_name());
            let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
            if is_folder { open.push(place) } else { files.push(place) }
        }
    }
    Ok(files)
}
