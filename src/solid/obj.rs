//! What of an OBJ file a mesh needs: vertices and the faces between them, looked at before they are read.
//!
//! Normals and texture coordinates are left out; the reader trusts the indices of all three.

use crate::error::{Error, ErrorKind, Result};

/// The file without normals and texture coordinates, every index one that its vertices can have.
///
/// # Errors
/// With its line: an index that points before the first vertex, or beyond 2³².
pub(super) fn positions_only(text: &str) -> Result<String> {
    let mut out = String::with_capacity(text.len());
    let mut vertices = 0_u64;
    for (row, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vn" | "vt") => {}
            Some(kind @ ("f" | "l" | "p")) => {
                out += kind;
                for word in words {
                    let index = word.split('/').next().unwrap_or(word);
                    check(index, vertices).map_err(|error| error.row(row as u64 + 1))?;
                    out.push(' ');
                    out += index;
                }
            }
            first => {
                vertices += u64::from(first == Some("v"));
                out += line;
            }
        }
        out.push('\n');
    }
    Ok(out)
}

/// What is no number at all is left to the reader.
fn check(index: &str, vertices: u64) -> Result<()> {
    let Ok(number) = index.parse::<i64>() else { return Ok(()) };
    let is_before = number < 0 && number.unsigned_abs() > vertices;
    if is_before || number > i64::from(u32::MAX) {
        return Err(Error::new(ErrorKind::OutOfRange)
            .found(format!("vertex {number} in a face"))
            .expected(format!("one of the {vertices} vertices above it"))
            .remedy("correct that line, or export the mesh again"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_faces_keep_their_vertices_alone() {
        let text = "# box\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 -1/1\n";
        assert_eq!(positions_only(text).unwrap(), "# box\nv 0 0 0\nv 1 0 0\nv 0 1 0\n\n\nf 1 2 -1\n");
    }

    #[test]
    fn exact_an_index_before_the_first_vertex_is_refused_with_its_line() {
        for face in ["f 1 2 -4", "f 1 2 99999999999999999", "l -9 1"] {
            let error = positions_only(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{face}\n")).unwrap_err();
            assert!(error.to_string().starts_with("row 4: "), "{error}");
        }
    }
}
