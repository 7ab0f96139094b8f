//! The solid model of a machine: URDF and meshes become two rigid bodies and the joint between them.
//!
//! A machine axis has one joint that moves. Everything on the root's side of it is the *base* body,
//! everything beyond is the *moving* body; links joined by fixed joints are merged, not simulated.
//!
//! Frames: the base body's frame is that of the URDF's root link; the moving body's frame is that of
//! the moving joint's child link, which coincides with the joint frame at joint position zero.

mod files;
mod import;
pub mod mass;
pub mod mesh;
mod obj;
mod tree;
mod weight;
mod xml;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Isometry3, Unit, Vector3};

pub use self::import::{Movable, movable_joints};
pub use self::mass::MassProperties;
pub use self::mesh::Mesh;
pub use self::weight::{GRAVITY_M_PER_S2, SMALL_RAD, Weight};
use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// A machine axis as imported: two rigid bodies and one joint.
#[derive(Debug, Clone)]
pub struct Solid {
    /// The robot's name in the URDF.
    pub name: String,
    /// The URDF file it came from.
    pub path: PathBuf,
    /// All links that stand still.
    pub base: Body,
    /// All links that the joint moves.
    pub moving: Body,
    /// The joint between them.
    pub joint: Joint,
}

/// Links that move as one.
#[derive(Debug, Clone)]
pub struct Body {
    /// Name of the link whose frame is the body's frame.
    pub link: String,
    /// All links together, in the body's frame.
    pub mass: MassProperties,
    /// The links merged into this body, its root link first.
    pub links: Vec<Link>,
}

/// One link of the URDF.
#[derive(Debug, Clone)]
pub struct Link {
    /// Name in the URDF.
    pub name: String,
    /// Link frame in the body's frame.
    pub pose_in_body: Isometry3<f64>,
    /// The URDF's inertial, in the link frame (its rotation applied).
    pub mass: MassProperties,
    /// What the link looks like: its visuals, or its collision shapes where it has no visual.
    pub geometry: Vec<Geometry>,
}

/// A shape at its place in a link.
#[derive(Debug, Clone)]
pub struct Geometry {
    /// Shape frame in the link frame.
    pub pose: Isometry3<f64>,
    /// The shape.
    pub shape: Shape,
}

/// A shape; primitives are centred at their frame, a cylinder lies along z.
#[derive(Debug, Clone)]
pub enum Shape {
    /// A closed mesh, in m after the URDF's scale.
    Mesh {
        /// The file it was read from.
        path: PathBuf,
        /// The mesh; links that name the same file with the same scale share it.
        mesh: Arc<Mesh>,
    },
    /// A box.
    Box {
        /// Edge lengths, in m.
        size_m: Vector3<f64>,
    },
    /// A cylinder.
    Cylinder {
        /// Radius, in m.
        radius_m: f64,
        /// Length along z, in m.
        length_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius, in m.
        radius_m: f64,
    },
}

/// The joint that moves. Positions and efforts in m and N (prismatic) or rad and N·m (revolute).
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// Straight line or rotation.
    pub motion: Motion,
    /// Joint frame in the base body's frame.
    pub origin: Isometry3<f64>,
    /// Direction of positive motion, in the joint frame.
    pub axis: Unit<Vector3<f64>>,
    /// Lowest position; −∞ where the URDF sets no position limit.
    pub lower: f64,
    /// Highest position; +∞ where the URDF sets no position limit.
    pub upper: f64,
    /// Largest effort by the URDF; ∞ where it states none.
    pub effort: f64,
    /// Largest speed by the URDF; ∞ where it states none.
    pub velocity: f64,
    /// Viscous coefficient by the URDF's `<dynamics>`, in N·s/m or N·m·s/rad; zero where it states none.
    pub damping: f64,
    /// Coulomb friction by the URDF's `<dynamics>`, in N or N·m; zero where it states none.
    pub friction: f64,
}

impl Joint {
    /// Gravity in the joint's frame, in m/s²: downwards along −z of the base's.
    pub fn gravity(&self) -> Vector3<f64> {
        self.origin.rotation.inverse_transform_vector(&Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2))
    }

    /// Middle of the travel; where the URDF does not limit it on both sides, the allowed position nearest to zero.
    pub fn middle(&self) -> f64 {
        let middle = 0.5 * (self.lower + self.upper);
        if middle.is_finite() { middle } else { 0.0_f64.max(self.lower).min(self.upper) }
    }

    /// Room to each side of the middle; ∞ where there is no position limit.
    pub fn half_travel(&self) -> f64 {
        (self.middle() - self.lower).min(self.upper - self.middle())
    }
}

/// Which of the two bodies a link belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The body that stands still.
    Base,
    /// The body that the joint moves.
    Moving,
}

/// What of a URDF is imported.
struct Driven<'a> {
    joint: Option<&'a str>,
    /// Further joints that could move and are held at zero; any where not stated.
    held: Option<&'a [String]>,
    /// The folder that meshes are in; the URDF's where not stated.
    folder: Option<&'a Path>,
}

impl Solid {
    /// Imports a URDF with exactly one joint that is not fixed.
    ///
    /// # Errors
    /// See [`Solid::import_with_joint`].
    pub fn import(urdf_path: &Path) -> Result<Self> {
        Self::import_with_joint(urdf_path, None)
    }

    /// Imports a URDF whose joint `joint` moves; every other joint is held at its zero position.
    ///
    /// Inertials are taken from the URDF, meshes only checked (closed, outward, of a machine part's size,
    /// of a volume that goes with the link's mass). Mesh paths are relative to the URDF's folder;
    /// `package://name/rest` is looked for as `rest` in that folder and the one above.
    ///
    /// # Errors
    /// Each names the file and the link or joint: malformed XML; links and joints that are not one tree;
    /// none or several movable joints and none named; an unsupported joint type; a zero or absent axis;
    /// a link without `<inertial>` or with one that no real body has; a missing, open, inward or
    /// implausibly sized mesh.
    pub fn import_with_joint(urdf_path: &Path, joint: Option<&str>) -> Result<Self> {
        import::import(urdf_path, &Driven { joint, held: None, folder: None })
    }

    /// The same for a machine in `folder`, out of which no mesh leads. Other joints that could move must be among `held`.
    ///
    /// # Errors
    /// As [`Solid::import_with_joint`]; a second joint that could move; a mesh outside the folder.
    pub fn import_of_machine(
        urdf_path: &Path,
        joint: Option<&str>,
        held: &[String],
        folder: &Path,
    ) -> Result<Self> {
        import::import(urdf_path, &Driven { joint, held: Some(held), folder: Some(folder) })
    }

    /// What an effort along the joint accelerates: mass in kg if prismatic; moment of inertia about the
    /// joint axis in kg·m² if revolute.
    pub fn moving_inertia_along_joint(&self) -> f64 {
        let axis = self.joint.axis.into_inner();
        match self.joint.motion {
            Motion::Prismatic => self.moving.mass.mass_kg,
            // The moving body's frame is the joint frame: its origin lies on the axis.
            Motion::Revolute => axis.dot(&(self.moving.mass.inertia_about(Vector3::zeros()) * axis)),
        }
    }

    /// Mass of the moving body, in kg.
    pub fn moving_mass_kg(&self) -> f64 {
        self.moving.mass.mass_kg
    }

    /// Mass of both bodies, in kg.
    pub fn total_mass_kg(&self) -> f64 {
        self.base.mass.mass_kg + self.moving.mass.mass_kg
    }

    /// The link of that name and the body it belongs to.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`] with the names there are.
    pub fn link(&self, name: &str) -> Result<(Side, &Link)> {
        self.links().find(|(_, link)| link.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.links().map(|(_, link)| link.name.as_str()).collect();
            Error::new(ErrorKind::Missing)
                .file(&self.path)
                .key(name)
                .found("no link of that name")
                .expected(format!("one of {}", names.join(", ")))
                .remedy("correct the name or add the link to the URDF")
        })
    }

    /// All links, those of the base first.
    pub fn links(&self) -> impl Iterator<Item = (Side, &Link)> {
        let base = self.base.links.iter().map(|link| (Side::Base, link));
        base.chain(self.moving.links.iter().map(|link| (Side::Moving, link)))
    }
}

impl Body {
    fn from_links(links: Vec<Link>) -> Self {
        let parts: Vec<MassProperties> = links.iter().map(|l| l.mass.transformed(&l.pose_in_body)).collect();
        let link = links.first().map(|l| l.name.clone()).unwrap_or_default();
        Self { link, mass: MassProperties::combined(&parts), links }
    }
}

impl Link {
    /// Mass properties that the link's geometry would have if it were solid and of one density, in the
    /// link frame: to be compared with the URDF's inertial, `self.mass`.
    pub fn mass_from_geometry(&self, density_kg_per_m3: f64) -> MassProperties {
        let parts: Vec<MassProperties> = self
            .geometry
            .iter()
            .map(|g| g.shape.mass_properties(density_kg_per_m3).transformed(&g.pose))
            .collect();
        MassProperties::combined(&parts)
    }
}

impl Shape {
    /// Mass properties of the solid shape in its own frame.
    pub fn mass_properties(&self, density_kg_per_m3: f64) -> MassProperties {
        match self {
            Self::Mesh { mesh, .. } => MassProperties::from_mesh(mesh, density_kg_per_m3),
            Self::Box { size_m } => MassProperties::from_box(*size_m, density_kg_per_m3),
            Self::Cylinder { radius_m, length_m } => {
                MassProperties::from_cylinder(*radius_m, *length_m, density_kg_per_m3)
            }
            Self::Sphere { radius_m } => MassProperties::from_sphere(*radius_m, density_kg_per_m3),
        }
    }
}
