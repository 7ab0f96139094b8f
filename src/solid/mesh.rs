//! Triangle meshes: reading OBJ and STL, closedness, orientation, size.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _};
use std::path::Path;

use nalgebra::{Point3, Vector3};

use super::obj;
use crate::confine;
use crate::error::guarded::guarded;
use crate::error::{Error, ErrorKind, Result};

/// Largest extent of a machine part, in m; a mesh beyond it was most likely drawn in mm.
const LARGEST_PART_M: f64 = 50.0;
/// Smallest overall extent of a machine part, in m; a mesh below it was most likely scaled twice.
const SMALLEST_PART_M: f64 = 1e-4;

/// Farther from its origin no part is drawn, in m.
const FARTHEST_M: f64 = 1e3;
/// Bytes of a mesh at most.
const MOST_BYTES: u64 = 1 << 30;
/// Bytes of a binary STL before its triangles, and of each.
const STL_HEAD: u64 = 84;
const STL_TRIANGLE: u64 = 50;

/// A triangle mesh. Vertices in m; triangles list their corners counter-clockwise seen from outside.
///
/// # Validity
/// A mesh as read is only syntactically sound. [`Mesh::check_closed`] must pass before a volume or a
/// mass means anything: the integrals of an open or inward mesh are finite, plausible and wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Corners, in m.
    pub vertices: Vec<Point3<f64>>,
    /// Indices into `vertices`, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Reads an OBJ or STL file (by its extension) and multiplies every coordinate by `scale`.
    ///
    /// Neither format carries a unit: `scale` must turn the file's unit into m. Vertices of STL files,
    /// which repeat every corner, are welded where their coordinates are equal; those of OBJ files only
    /// where the faces do not already close by index.
    ///
    /// # Errors
    /// A missing or malformed file, an unknown extension, no triangle, a coordinate that is not finite.
    pub fn read(path: &Path, scale: Vector3<f64>) -> Result<Self> {
        confine::check_regular(path, MOST_BYTES)?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let mesh = match extension.as_str() {
            "obj" => guarded("OBJ file", || read_obj(path)).map_err(|error| error.file(path))?,
            "stl" => guarded("STL file", || read_stl(path)).map_err(|error| error.file(path))?.welded(),
            other => {
                return Err(Error::new(ErrorKind::Syntax)
                    .file(path)
                    .found(format!("a mesh with extension \"{other}\""))
                    .expected("\"obj\" or \"stl\"")
                    .remedy("export the part as OBJ or STL"));
            }
        };
        mesh.scaled(scale).and_then(Self::checked_numbers).map_err(|e| e.file(path))
    }

    fn checked_numbers(self) -> Result<Self> {
        if self.triangles.is_empty() {
            return Err(Error::new(ErrorKind::TooLittleData)
                .found("no triangle")
                .expected("a closed surface")
                .remedy("export the part's surface, not only its points or lines"));
        }
        if let Some(bad) = self.vertices.iter().position(|v| !v.coords.iter().all(|x| x.is_finite())) {
            return Err(Error::new(ErrorKind::NotFinite)
                .found(format!("vertex {} = {}", bad + 1, point_text(&self.vertices[bad])))
                .expected("finite coordinates")
                .remedy("export the mesh again"));
        }
        Ok(self)
    }

    fn scaled(mut self, scale: Vector3<f64>) -> Result<Self> {
        if !scale.iter().all(|s| s.is_finite() && *s != 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .found(format!("scale=\"{} {} {}\"", scale.x, scale.y, scale.z))
                .expected("three finite numbers other than zero")
                .remedy("set the mesh's scale in the URDF"));
        }
        for vertex in &mut self.vertices {
            vertex.coords.component_mul_assign(&scale);
        }
        // A mirrored part is turned inside out; restore counter-clockwise order.
        if scale.product() < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        Ok(self)
    }

    /// The same surface with vertices of equal coordinates made one and collapsed triangles dropped.
    #[must_use]
    pub fn welded(&self) -> Self {
        let mut index_of = HashMap::with_capacity(self.vertices.len());
        let mut vertices = Vec::new();
        let new_index: Vec<u32> = self
            .vertices
            .iter()
            .map(|v| {
                // Adding 0.0 makes -0.0 and 0.0 the same key.
                let key = [v.x, v.y, v.z].map(|x| (x + 0.0).to_bits());
                *index_of.entry(key).or_insert_with(|| {
                    vertices.push(*v);
                    (vertices.len() - 1) as u32
                })
            })
            .collect();
        let triangles = self
            .triangles
            .iter()
            .map(|t| t.map(|i| new_index[i as usize]))
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        Self { vertices, triangles }
    }

    /// Checks that the surface encloses a volume: every directed edge occurs exactly once and so does
    /// its reverse, and the enclosed volume is positive (triangles face outwards).
    ///
    /// ```
    /// use nalgebra::Point3;
    /// use slideway::solid::Mesh;
    /// let vertices = vec![Point3::origin(), [1.0, 0.0, 0.0].into(), [0.0, 1.0, 0.0].into(), [0.0, 0.0, 1.0].into()];
    /// let mut mesh = Mesh { vertices, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] };
    /// assert!(mesh.check_closed().is_ok());
    /// assert!((mesh.volume_m3() - 1.0 / 6.0).abs() < 1e-15);
    /// mesh.triangles.pop();
    /// assert!(mesh.check_closed().is_err());
    /// ```
    ///
    /// # Errors
    /// [`ErrorKind::OpenMesh`] with the number of open edges and where the first of them is, or with
    /// the negative volume of a surface that is turned inside out.
    pub fn check_closed(&self) -> Result<()> {
        let open = self.open_edges();
        if let Some(&(from, to)) = open.first() {
            let edges =
                if open.len() == 1 { "1 open edge".into() } else { format!("{} open edges", open.len()) };
            return Err(Error::new(ErrorKind::OpenMesh)
                .found(format!(
                    "{edges}, the first from {} to {} m",
                    point_text(&self.vertices[from as usize]),
                    point_text(&self.vertices[to as usize])
                ))
                .expected(
                    "a closed surface: each edge shared by exactly two triangles of the same orientation",
                )
                .remedy("fill the hole (or turn the flipped triangle) and export the mesh again"));
        }
        let volume = self.volume_m3();
        if volume > 0.0 {
            return Ok(());
        }
        let error =
            Error::new(ErrorKind::OpenMesh).expected("triangles that face outwards, a positive volume");
        Err(if volume < 0.0 {
            error
                .found(format!("all triangles facing inwards (volume {volume:.6e} m³)"))
                .remedy("flip the mesh's normals and export it again")
        } else {
            error.found("a surface without volume").remedy("export a solid, not a sheet")
        })
    }

    /// Edges that are not shared by exactly two triangles running along them in opposite directions.
    fn open_edges(&self) -> Vec<(u32, u32)> {
        let mut count: HashMap<(u32, u32), u32> = HashMap::with_capacity(3 * self.triangles.len());
        for edge in self.directed_edges() {
            *count.entry(edge).or_default() += 1;
        }
        let is_single = |edge| count.get(&edge) == Some(&1);
        let mut open: Vec<(u32, u32)> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for (a, b) in self.directed_edges() {
            if !(is_single((a, b)) && is_single((b, a))) && seen.insert((a.min(b), a.max(b))) {
                open.push((a, b));
            }
        }
        open
    }

    fn directed_edges(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
    }

    /// The three corners of every triangle, in m.
    pub fn corners(&self) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
        self.triangles.iter().map(|t| t.map(|i| self.vertices[i as usize]))
    }

    /// Enclosed volume in m³; negative for a surface turned inside out.
    ///
    /// # Model
    ///   V = Σ a·(b × c)/6 over the triangles, corners taken relative to the middle of the bounding box.
    pub fn volume_m3(&self) -> f64 {
        let middle = self.middle();
        let six_volumes: f64 = self
            .corners()
            .map(|t| {
                let [a, b, c] = t.map(|p| p - middle);
                a.dot(&b.cross(&c))
            })
            .sum();
        six_volumes / 6.0
    }

    /// Lower and upper corner of the bounding box, in m.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        let start = (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3]));
        self.vertices.iter().fold(start, |(low, high), v| (low.inf(v), high.sup(v)))
    }

    /// Middle of the bounding box: the reference of every integral, so that an offset costs no digits.
    pub(crate) fn middle(&self) -> Point3<f64> {
        let (low, high) = self.bounds();
        nalgebra::center(&low, &high)
    }

    /// Checks that the mesh has the size of a machine part, i.e. that its unit was m.
    ///
    /// # Errors
    /// [`ErrorKind::Unit`] for a largest extent above 50 m or below 0.1 mm.
    pub fn check_size(&self) -> Result<()> {
        let (low, high) = self.bounds();
        let extent = (high - low).max();
        if low.coords.amax().max(high.coords.amax()) > FARTHEST_M {
            return Err(Error::new(ErrorKind::OutOfRange)
                .found(format!("vertices from {} to {} m", point_text(&low), point_text(&high)))
                .expected(format!("at most {FARTHEST_M} m from the origin"))
                .remedy("export the mesh again, in its part's frame and in m"));
        }
        if extent > LARGEST_PART_M {
            return Err(Error::new(ErrorKind::Unit)
                .found(format!("a mesh {extent:.4} m long"))
                .expected(format!("at most {LARGEST_PART_M} m"))
                .remedy("mesh probably in mm: set scale=\"0.001 0.001 0.001\" on the <mesh>"));
        }
        if extent < SMALLEST_PART_M {
            return Err(Error::new(ErrorKind::Unit)
                .found(format!("a mesh {extent:.4e} m long"))
                .expected(format!("at least {SMALLEST_PART_M} m"))
                .remedy("mesh probably in m already: remove the scale of the <mesh>"));
        }
        Ok(())
    }
}

fn point_text(p: &Point3<f64>) -> String {
    format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z)
}

fn read_obj(path: &Path) -> Result<Mesh> {
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, &e))?;
    let text = obj::positions_only(&String::from_utf8_lossy(&bytes)).map_err(|error| error.file(path))?;
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    // Materials are of no use here, and their files anywhere.
    let none = |_: &Path| Ok((Vec::new(), Default::default()));
    let (models, _materials) = tobj::load_obj_buf(&mut text.as_bytes(), &options, none).map_err(|e| {
        Error::new(ErrorKind::Syntax)
            .file(path)
            .found(e.to_string())
            .expected("an OBJ file of vertices and faces")
            .remedy("export the mesh again")
    })?;
    let mut mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for model in models {
        let offset = mesh.vertices.len() as u32;
        let (points, _) = model.mesh.positions.as_chunks::<3>();
        mesh.vertices.extend(points.iter().map(|p| Point3::from(*p)));
        let (triangles, _) = model.mesh.indices.as_chunks::<3>();
        mesh.triangles.extend(triangles.iter().map(|t| t.map(|i| i + offset)));
    }
    Ok(if mesh.open_edges().is_empty() { mesh } else { mesh.welded() })
}

/// Refuses a binary STL that is shorter than the triangles that its head counts.
fn check_stl_length(path: &Path, mut file: &File) -> Result<()> {
    let told = |e: std::io::Error| Error::io(path, &e);
    let length = file.metadata().map_err(told)?.len();
    let mut head = Vec::new();
    file.take(STL_HEAD).read_to_end(&mut head).map_err(told)?;
    file.rewind().map_err(told)?;
    if head.starts_with(b"solid") {
        return Ok(());
    }
    let counted = head.get(80..84).and_then(|count| Some(u32::from_le_bytes(count.try_into().ok()?)));
    let needed = counted.map_or(STL_HEAD, |count| STL_HEAD + u64::from(count) * STL_TRIANGLE);
    if length >= needed {
        return Ok(());
    }
    let found = match counted {
        Some(count) => format!("{length} bytes, and {count} triangles counted at their head"),
        None => format!("{length} bytes"),
    };
    Err(Error::new(ErrorKind::Syntax)
        .file(path)
        .found(found)
        .expected(format!("a binary STL of {needed} bytes, or a text that begins with `solid`"))
        .remedy("the file was cut off, or is no STL: export the mesh again"))
}

fn read_stl(path: &Path) -> Result<Mesh> {
    let file = File::open(path).map_err(|e| Error::io(path, &e))?;
    let malformed = |e: &std::io::Error| {
        let cut = e.kind() == std::io::ErrorKind::UnexpectedEof;
        let found = if cut { "the end of the file inside a triangle" } else { "lines that are no triangle" };
        Error::new(ErrorKind::Syntax)
            .file(path)
            .found(found)
            .expected("a binary or text STL file")
            .remedy("export the mesh again")
    };
    check_stl_length(path, &file)?;
    let mut reader = BufReader::new(file);
    let mut mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for triangle in stl_io::create_stl_reader(&mut reader).map_err(|e| malformed(&e))? {
        let triangle = triangle.map_err(|e| malformed(&e))?;
        let first = mesh.vertices.len() as u32;
        for corner in triangle.vertices {
            let [x, y, z] = corner.0.map(f64::from);
            mesh.vertices.push(Point3::new(x, y, z));
        }
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(mesh)
}
