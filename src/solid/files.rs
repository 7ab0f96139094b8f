//! The files that a URDF names.

use super::Solid;
use super::import::mesh_path;
use crate::error::{Error, ErrorKind, Result};
use std::path::PathBuf;

impl Solid {
    /// The file that a mesh's name in the URDF stands for.
    ///
    /// # Errors
    /// A mesh that is not there.
    #[cfg_attr(not(feature = "mujoco"), expect(dead_code))]
    pub(crate) fn mesh_file(&self, written: &str) -> Result<PathBuf> {
        mesh_path(&self.path, written)
    }

    /// Every mesh that the URDF names: its path as the URDF writes it, without `package://name/` or `file://`, and
    /// the file that it stands for.
    ///
    /// # Errors
    /// A URDF or mesh that is not there any more.
    pub fn mesh_files(&self) -> Result<Vec<(PathBuf, PathBuf)>> {
        let text = std::fs::read_to_string(&self.path).map_err(|e| Error::io(&self.path, &e))?;
        let robot = urdf_rs::read_from_string(&text).map_err(|e| {
            Error::new(ErrorKind::Syntax)
                .file(&self.path)
                .found(e.to_string())
                .expected("the URDF as it was read")
        })?;
        let shapes = robot.links.iter().flat_map(|link| {
            let visual = link.visual.iter().map(|v| &v.geometry);
            visual.chain(link.collision.iter().map(|c| &c.geometry))
        });
        let mut files = Vec::new();
        for shape in shapes {
            if let urdf_rs::Geometry::Mesh { filename, .. } = shape {
                files.push((PathBuf::from(place(filename)), mesh_path(&self.path, filename)?));
            }
        }
        files.sort();
        files.dedup();
        Ok(files)
    }
}

/// The path of a mesh from the URDF's folder.
fn place(filename: &str) -> &str {
    match filename.strip_prefix("package://") {
        Some(rest) => rest.split_once('/').map_or(rest, |(_, inside)| inside),
        None => filename.strip_prefix("file://").unwrap_or(filename),
    }
}
