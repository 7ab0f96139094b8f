//! From a URDF file to [`Solid`].
//!
//! Why not an existing loader: `rapier3d-urdf` is single precision, drops the rotation of `<inertial>`
//! and the joint's `<dynamics>`, and passes over missing meshes and links without inertia in silence.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Unit, Vector3};
use urdf_rs::JointType;

use super::tree::{PlacedLink, Tree, isometry};
use super::{Body, Driven, Geometry, Joint, Link, MassProperties, Mesh, Shape, Solid, xml};
use crate::confine;
use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// Mass over mesh volume, in kg/m³, that only a mesh drawn in mm and read in m can have (error 1e9).
const LOWEST_DENSITY_KG_PER_M3: f64 = 0.01;
/// The same for a mesh drawn in m and scaled as if in mm.
const HIGHEST_DENSITY_KG_PER_M3: f64 = 1e10;

/// Bytes of a URDF at most.
const MOST_BYTES: u64 = 64 << 20;

pub(super) fn import(urdf_path: &Path, driven: &Driven<'_>) -> Result<Solid> {
    let text = confine::read_text(urdf_path, MOST_BYTES)?;
    import_text(urdf_path, &text, driven).map_err(|e| e.file(urdf_path))
}

fn import_text(urdf_path: &Path, text: &str, driven: &Driven<'_>) -> Result<Solid> {
    let robot = parsed(text)?;
    let tree = Tree::new(&robot)?;
    let moving_joint = tree.moving_joint(driven.joint)?;
    if let Some(held) = driven.held {
        tree.check_held(&moving_joint.name, held)?;
    }
    let base_links = tree.base_links(&moving_joint.name)?;
    let parent_pose = base_links
        .iter()
        .find(|(link, _)| link.name == moving_joint.parent.link)
        .map(|(_, pose)| *pose)
        .ok_or_else(|| {
            Error::new(ErrorKind::Inconsistent)
                .key(&moving_joint.name)
                .expected("a joint whose parent is on the base's side")
        })?;
    let joint = read_joint(moving_joint, parent_pose, text)?;
    let mut reader = LinkReader::new(urdf_path, driven.folder);
    let base = Body::from_links(reader.links(&base_links)?);
    let moving = Body::from_links(reader.links(&tree.moving_links(&moving_joint.child.link)?)?);
    Ok(Solid { name: robot.name.clone(), path: urdf_path.to_path_buf(), base, moving, joint })
}

/// A joint of a URDF that could be the driven one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Movable {
    /// Its name.
    pub name: String,
    /// Its type, as the URDF writes it.
    pub kind: String,
}

/// The joints of a URDF that are not fixed, in the order of the file.
///
/// # Errors
/// A file that is not there or is no URDF.
pub fn movable_joints(urdf_path: &Path) -> Result<Vec<Movable>> {
    let text = confine::read_text(urdf_path, MOST_BYTES)?;
    let robot = parsed(&text).map_err(|e| e.file(urdf_path))?;
    let kind = |joint: &urdf_rs::Joint| format!("{:?}", joint.joint_type).to_lowercase();
    let movable = robot.joints.iter().filter(|joint| joint.joint_type != JointType::Fixed);
    Ok(movable.map(|joint| Movable { name: joint.name.clone(), kind: kind(joint) }).collect())
}

fn parsed(text: &str) -> Result<urdf_rs::Robot> {
    xml::check(text)?;
    urdf_rs::read_from_string(text).map_err(|e| {
        Error::new(ErrorKind::Syntax)
            .found(e.to_string())
            .expected("a URDF <robot> of links and joints, each with a name and what the format asks for")
            .remedy("compare with the specification of URDF, or export it again")
    })
}

fn read_joint(joint: &urdf_rs::Joint, parent_pose: Isometry3<f64>, text: &str) -> Result<Joint> {
    let key = joint.name.as_str();
    let bad_axis = |found: String| {
        Error::new(ErrorKind::OutOfRange)
            .key(key)
            .found(found)
            .expected("an <axis xyz=\"…\"> other than zero")
            .remedy("state the joint's direction of positive motion, such as <axis xyz=\"1 0 0\"/>")
    };
    if !declares_axis(text, key) {
        return Err(bad_axis("no <axis>".into()));
    }
    let direction = Vector3::from(joint.axis.xyz.0);
    let axis = Unit::try_new(direction, f64::MIN_POSITIVE)
        .filter(|a| a.iter().all(|x| x.is_finite()))
        .ok_or_else(|| bad_axis(format!("<axis xyz=\"{} {} {}\">", direction.x, direction.y, direction.z)))?;
    let (lower, upper) = position_limits(joint)?;
    let stated = |value: f64| if value == 0.0 { f64::INFINITY } else { value };
    let dynamics = joint.dynamics.clone().unwrap_or_default();
    for (name, value) in [
        ("effort", joint.limit.effort),
        ("velocity", joint.limit.velocity),
        ("damping", dynamics.damping),
        ("friction", dynamics.friction),
    ] {
        if value.is_nan() || value < 0.0 {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key(key)
                .found(format!("{name}=\"{value}\""))
                .expected("zero or a positive number")
                .remedy("correct the joint's <limit> or <dynamics>"));
        }
    }
    Ok(Joint {
        name: joint.name.clone(),
        motion: if joint.joint_type == JointType::Prismatic { Motion::Prismatic } else { Motion::Revolute },
        origin: parent_pose * isometry(&joint.origin, key)?,
        axis,
        lower,
        upper,
        effort: stated(joint.limit.effort),
        velocity: stated(joint.limit.velocity),
        damping: dynamics.damping,
        friction: dynamics.friction,
    })
}

fn position_limits(joint: &urdf_rs::Joint) -> Result<(f64, f64)> {
    let limit = &joint.limit;
    let unlimited = joint.joint_type == JointType::Continuous || *limit == urdf_rs::JointLimit::default();
    if unlimited {
        return Ok((f64::NEG_INFINITY, f64::INFINITY));
    }
    if limit.lower < limit.upper {
        return Ok((limit.lower, limit.upper));
    }
    Err(Error::new(ErrorKind::OutOfRange)
        .key(&joint.name)
        .found(format!("<limit lower=\"{}\" upper=\"{}\">", limit.lower, limit.upper))
        .expected("lower below upper")
        .remedy("state the travel of the joint, or leave <limit> out for an unlimited one"))
}

/// Whether the joint states its `<axis>`; `urdf_rs` silently reads an absent one as (1, 0, 0).
fn declares_axis(text: &str, joint: &str) -> bool {
    let without_comments: String = text
        .split("<!--")
        .enumerate()
        .map(|(i, part)| if i == 0 { part } else { part.split_once("-->").map_or("", |(_, rest)| rest) })
        .collect();
    let quoted = |tag: &str, quote: char| {
        tag.split_whitespace().any(|word| word.starts_with(&format!("name={quote}{joint}{quote}")))
    };
    without_comments.split("<joint").skip(1).any(|element| {
        let element = element.split("</joint>").next().unwrap_or_default();
        let Some((tag, content)) = element.split_once('>') else { return false };
        let tag = tag.replace(" =", "=").replace("= ", "=");
        (quoted(&tag, '"') || quoted(&tag, '\'')) && content.contains("<axis")
    })
}

/// Reads links; a mesh that several of them name is read and checked once.
struct LinkReader<'a> {
    urdf_path: &'a Path,
    /// The folder that meshes are in.
    folder: &'a Path,
    meshes: HashMap<(PathBuf, [u64; 3]), Arc<Mesh>>,
}

impl<'a> LinkReader<'a> {
    fn new(urdf_path: &'a Path, folder: Option<&'a Path>) -> Self {
        let own = urdf_path.parent().unwrap_or(Path::new(""));
        Self { urdf_path, folder: folder.unwrap_or(own), meshes: HashMap::new() }
    }

    fn links(&mut self, placed: &[PlacedLink<'_>]) -> Result<Vec<Link>> {
        placed.iter().map(|(link, pose)| self.link(link, *pose).map_err(|e| e.key(&link.name))).collect()
    }

    fn link(&mut self, link: &urdf_rs::Link, pose_in_body: Isometry3<f64>) -> Result<Link> {
        let mass = inertial(&link.inertial, &link.name)?;
        let shown: Vec<_> = link.visual.iter().map(|v| (&v.origin, &v.geometry)).collect();
        let solid: Vec<_> = link.collision.iter().map(|c| (&c.origin, &c.geometry)).collect();
        // Collision shapes are read even where visuals are shown: a broken mesh is refused in either place.
        let collision = self.geometry(&solid, &link.name)?;
        let visual = self.geometry(&shown, &link.name)?;
        let geometry = if visual.is_empty() { collision } else { visual };
        let link = Link { name: link.name.clone(), pose_in_body, mass, geometry };
        check_mesh_unit(&link)?;
        Ok(link)
    }

    fn geometry(
        &mut self,
        shapes: &[(&urdf_rs::Pose, &urdf_rs::Geometry)],
        link: &str,
    ) -> Result<Vec<Geometry>> {
        shapes
            .iter()
            .map(|(pose, shape)| Ok(Geometry { pose: isometry(pose, link)?, shape: self.shape(shape)? }))
            .collect()
    }

    fn shape(&mut self, geometry: &urdf_rs::Geometry) -> Result<Shape> {
        let shape = match geometry {
            urdf_rs::Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or(Vector3::repeat(1.0), |s| Vector3::from(s.0));
                return self.mesh(filename, scale);
            }
            urdf_rs::Geometry::Box { size } => Shape::Box { size_m: Vector3::from(size.0) },
            urdf_rs::Geometry::Cylinder { radius, length } => {
                Shape::Cylinder { radius_m: *radius, length_m: *length }
            }
            urdf_rs::Geometry::Sphere { radius } => Shape::Sphere { radius_m: *radius },
            urdf_rs::Geometry::Capsule { .. } => {
                return Err(Error::new(ErrorKind::Syntax)
                    .found("a capsule")
                    .expected("a mesh, box, cylinder or sphere")
                    .remedy("describe the link by one of these shapes"));
            }
        };
        let sizes = match &shape {
            Shape::Box { size_m } => size_m.iter().copied().collect(),
            Shape::Cylinder { radius_m, length_m } => vec![*radius_m, *length_m],
            Shape::Sphere { radius_m } => vec![*radius_m],
            Shape::Mesh { .. } => vec![],
        };
        match sizes.iter().find(|s| !(s.is_finite() && **s > 0.0)) {
            None => Ok(shape),
            Some(bad) => Err(Error::new(ErrorKind::OutOfRange)
                .found(format!("a shape of size {bad} m"))
                .expected("positive sizes")
                .remedy("correct the <geometry> of this link")),
        }
    }

    fn mesh(&mut self, filename: &str, scale: Vector3<f64>) -> Result<Shape> {
        let path = mesh_path(self.urdf_path, filename)?;
        // The folder above holds the packages that meshes of one are looked for in.
        let above = self.folder.join("..");
        let is_package = filename.starts_with("package://");
        let folders = if is_package { vec![self.folder, &above] } else { vec![self.folder] };
        confine::check(&path, &folders).map_err(|e| e.file(self.urdf_path))?;
        let key = (path.clone(), [scale.x, scale.y, scale.z].map(f64::to_bits));
        if let Some(mesh) = self.meshes.get(&key) {
            return Ok(Shape::Mesh { path, mesh: Arc::clone(mesh) });
        }
        let mesh = Mesh::read(&path, scale)?;
        // Size before closedness: welding and orientation of a mesh in the wrong unit are beside the point.
        mesh.check_size().and_then(|()| mesh.check_closed()).map_err(|e| e.file(&path))?;
        let mesh = Arc::new(mesh);
        self.meshes.insert(key, Arc::clone(&mesh));
        Ok(Shape::Mesh { path, mesh })
    }
}

/// The file that a mesh's name in the URDF stands for.
pub(super) fn mesh_path(urdf_path: &Path, filename: &str) -> Result<PathBuf> {
    let folder = urdf_path.parent().unwrap_or(Path::new(""));
    let (candidates, written) = match filename.strip_prefix("package://") {
        Some(rest) => {
            let inside = rest.split_once('/').map_or(rest, |(_, inside)| inside);
            (vec![folder.join(inside), folder.join("..").join(inside)], true)
        }
        None => (vec![folder.join(filename.strip_prefix("file://").unwrap_or(filename))], false),
    };
    if let Some(path) = candidates.iter().find(|path| path.is_file()) {
        return Ok(path.clone());
    }
    let error = Error::new(ErrorKind::Missing).file(urdf_path).found(match &candidates[0] {
        _ if filename.is_empty() => "a <mesh> without a file".to_owned(),
        path if path.is_dir() => format!("mesh \"{filename}\", which is a folder"),
        path if path.exists() => format!("mesh \"{filename}\", which is a device or pipe"),
        _ => format!("mesh \"{filename}\", which does not exist"),
    });
    Err(if written {
        error
            .expected("the file in the URDF's folder or the one above (packages are not searched for)")
            .remedy("write the mesh's path relative to the URDF")
    } else {
        error
            .expected(format!("a file at {}", candidates[0].display()))
            .remedy("correct the path (it is relative to the URDF) or add the mesh")
    })
}

fn inertial(inertial: &urdf_rs::Inertial, link: &str) -> Result<MassProperties> {
    let i = &inertial.inertia;
    if inertial.mass.value == 0.0 {
        return Err(Error::new(ErrorKind::Missing)
            .key(link)
            .found("no <inertial>, or one of zero mass")
            .expected("mass, centre of mass and inertia of every link")
            .remedy("add an <inertial>, or merge the link into the one that carries it"));
    }
    let tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    let about_centre =
        MassProperties { mass_kg: inertial.mass.value, centre_m: Vector3::zeros(), inertia_kg_m2: tensor };
    about_centre.check().map_err(|e| e.key(link))?;
    Ok(about_centre.transformed(&isometry(&inertial.origin, link)?))
}

/// A mesh in the wrong unit is off by 1e9 in volume: compare with the mass that the link claims.
fn check_mesh_unit(link: &Link) -> Result<()> {
    let meshes: Vec<_> = link
        .geometry
        .iter()
        .filter_map(|g| match &g.shape {
            Shape::Mesh { path, mesh } => Some((path, mesh.volume_m3())),
            _ => None,
        })
        .collect();
    let Some((path, _)) = meshes.first() else { return Ok(()) };
    let volume: f64 = meshes.iter().map(|(_, volume)| volume).sum();
    let density = link.mass.mass_kg / volume;
    if (LOWEST_DENSITY_KG_PER_M3..=HIGHEST_DENSITY_KG_PER_M3).contains(&density) {
        return Ok(());
    }
    let remedy = if density < LOWEST_DENSITY_KG_PER_M3 {
        "mesh probably in mm: set scale=\"0.001 0.001 0.001\" on the <mesh>"
    } else {
        "mesh probably in m already: remove the scale of the <mesh>"
    };
    Err(Error::new(ErrorKind::Unit)
        .file(path)
        .found(format!("a volume of {volume:.3e} m³ for {} kg, i.e. {density:.1e} kg/m³", link.mass.mass_kg))
        .expected("a volume that goes with the link's mass")
        .remedy(remedy))
}
