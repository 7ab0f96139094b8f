//! Writing the draft: all of a folder, or nothing.

use std::path::{Component, Path, PathBuf};

use super::Draft;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::{self, Machine};
use crate::recording;
use crate::solid::Solid;
use crate::whole::Build;

/// How the names of folders under way begin.
const PREFIX: &str = ".init-";
const MACHINE_FILE: &str = "machine.toml";
const RECORDING_FILE: &str = "recording.toml";
/// Folder of the machine beside a recording.
pub const MACHINE_FOLDER: &str = "machine";

/// Bare logs that become a recording with the machine in it.
#[derive(Debug, Clone)]
pub struct Logs {
    /// Text of `recording.toml`.
    pub outline: String,
    /// The logs, which are copied: what a recording names lies in its folder.
    pub files: Vec<PathBuf>,
}

/// Writes the draft into a new or empty folder: with logs a recording and the machine in a folder of it, else the machine
/// alone. The machine is read back before anything stands there. Returns what was written, relative to the folder.
///
/// # Errors
/// A draft that lacks numbers; a folder that is not empty; a mesh outside the folder of the URDF; whatever the file system
/// refuses.
pub fn write(
    draft: &Draft,
    solid: Option<&Solid>,
    logs: Option<&Logs>,
    folder: &Path,
) -> Result<Vec<PathBuf>> {
    if let Some(lack) = draft.lacks.first() {
        return Err(Error::new(ErrorKind::Missing)
            .key(lack.flag)
            .found(format!("a draft that lacks {} numbers", draft.lacks.len()))
            .expected(lack.why.clone())
            .remedy("state what is missing"));
    }
    check_place(folder)?;
    let build = Build::beside(folder, PREFIX)?;
    let fresh = build.fresh();
    let mut written = Vec::new();
    let machine = logs.map_or_else(PathBuf::new, |_| PathBuf::from(MACHINE_FOLDER));
    let mut put = |place: PathBuf, content: &[u8]| -> Result<()> {
        let path = fresh.join(&place);
        let above = path.parent().unwrap_or(&fresh);
        std::fs::create_dir_all(above).map_err(|error| Error::io(above, &error))?;
        std::fs::write(&path, content).map_err(|error| Error::io(&path, &error))?;
        written.push(place);
        Ok(())
    };
    if let Some(logs) = logs {
        put(PathBuf::from(RECORDING_FILE), logs.outline.as_bytes())?;
        put(PathBuf::from("recording.schema.json"), format!("{:#}\n", recording::schema()).as_bytes())?;
        for file in &logs.files {
            put(PathBuf::from(file.file_name().unwrap_or_default()), &read(file)?)?;
        }
    }
    put(machine.join(MACHINE_FILE), draft.text().as_bytes())?;
    put(machine.join("machine.schema.json"), format!("{:#}\n", machine::schema()).as_bytes())?;
    match (solid, &draft.urdf) {
        (Some(solid), _) => {
            let name = solid.path.file_name().unwrap_or_default();
            put(machine.join(name), &read(&solid.path)?)?;
            for (place, file) in solid.mesh_files()? {
                check_inside(&place, solid)?;
                put(machine.join(place), &read(&file)?)?;
            }
        }
        (None, Some(urdf)) => put(machine.join(super::draft::URDF), urdf.as_bytes())?,
        (None, None) => {}
    }
    // Whatever is written can be read.
    Machine::read(&fresh.join(&machine))
        .map_err(|error| error.moved_to(folder.join(MACHINE_FILE), "draft"))?;
    build.put(folder, false)?;
    Ok(written)
}

/// Refuses a place where something stands.
///
/// # Errors
/// A file, or a folder that is not empty.
pub fn check_place(folder: &Path) -> Result<()> {
    let is_free = !folder.exists()
        || folder.is_dir() && std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    if is_free {
        return crate::whole::probe(folder, PREFIX);
    }
    Err(Error::new(ErrorKind::Io)
        .file(folder)
        .key("--out")
        .found(if folder.is_dir() { "a folder that is not empty" } else { "a file" })
        .expected("a new or empty folder")
        .remedy("name another folder with --out; what stands there stays"))
}

fn check_inside(place: &Path, solid: &Solid) -> Result<()> {
    if place.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .file(&solid.path)
        .found(format!("the mesh {}", place.display()))
        .expected("meshes in the URDF's folder, so that they can be copied with it")
        .remedy("move the meshes below the URDF's folder"))
}

fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|error| Error::io(path, &error))
}
