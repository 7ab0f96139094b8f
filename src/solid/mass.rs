//! Mass, centre of mass and inertia tensor: from shapes, moved, combined, checked.

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::mesh::Mesh;
use crate::error::{Error, ErrorKind, Result};

/// Heavier than any machine, in kg and kg·m².
const HEAVIEST: f64 = 1e9;
/// Lighter than any part, in kg.
const LIGHTEST_KG: f64 = 1e-9;
/// Slack of the physical checks relative to the tensor's trace: thin plates meet the triangle
/// inequality with equality, and files print some six to nine digits.
const INERTIA_SLACK: f64 = 1e-6;

/// Mass properties of a body or a part of it.
///
/// The tensor's elements follow the tensor convention, as in URDF: I_xy = −∫ x·y dm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass, in kg.
    pub mass_kg: f64,
    /// Centre of mass in the frame, in m.
    pub centre_m: Vector3<f64>,
    /// Inertia tensor about the centre of mass, along the axes of the frame, in kg·m².
    pub inertia_kg_m2: Matrix3<f64>,
}

impl MassProperties {
    /// Nothing: the neutral element of [`MassProperties::combined`].
    pub fn zero() -> Self {
        Self { mass_kg: 0.0, centre_m: Vector3::zeros(), inertia_kg_m2: Matrix3::zeros() }
    }

    /// A homogeneous solid enclosed by `mesh`, which must be closed ([`Mesh::check_closed`]).
    ///
    /// # Model
    /// Sum over the tetrahedra spanned by each triangle (a, b, c) and a reference point, D = a·(b × c):
    ///   V = Σ D/6,  V·r = Σ D·(a+b+c)/24,
    ///   ∫ x xᵀ dV = Σ D/120 · ((a+b+c)(a+b+c)ᵀ + a aᵀ + b bᵀ + c cᵀ),  I = tr(C)·1 − C about the centre.
    /// Exact for a polyhedron.
    pub fn from_mesh(mesh: &Mesh, density_kg_per_m3: f64) -> Self {
        let reference = mesh.middle();
        let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for corners in mesh.corners() {
            let [a, b, c] = corners.map(|p| p - reference);
            let d = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += d / 6.0;
            first += sum * (d / 24.0);
            second += (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose())
                * (d / 120.0);
        }
        let centre = first / volume;
        let spread = second - centre * centre.transpose() * volume;
        Self {
            mass_kg: density_kg_per_m3 * volume,
            centre_m: reference.coords + centre,
            inertia_kg_m2: (Matrix3::identity() * spread.trace() - spread) * density_kg_per_m3,
        }
    }

    /// A homogeneous box with edges `size_m` along the axes, centred at the origin.
    pub fn from_box(size_m: Vector3<f64>, density_kg_per_m3: f64) -> Self {
        let mass = density_kg_per_m3 * size_m.product();
        let s = size_m.component_mul(&size_m);
        let diagonal = Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 12.0);
        Self { mass_kg: mass, centre_m: Vector3::zeros(), inertia_kg_m2: Matrix3::from_diagonal(&diagonal) }
    }

    /// A homogeneous cylinder along z, centred at the origin.
    pub fn from_cylinder(radius_m: f64, length_m: f64, density_kg_per_m3: f64) -> Self {
        let mass = density_kg_per_m3 * std::f64::consts::PI * radius_m.powi(2) * length_m;
        let across = mass * (3.0 * radius_m.powi(2) + length_m.powi(2)) / 12.0;
        let diagonal = Vector3::new(across, across, 0.5 * mass * radius_m.powi(2));
        Self { mass_kg: mass, centre_m: Vector3::zeros(), inertia_kg_m2: Matrix3::from_diagonal(&diagonal) }
    }

    /// A homogeneous sphere centred at the origin.
    pub fn from_sphere(radius_m: f64, density_kg_per_m3: f64) -> Self {
        let mass = density_kg_per_m3 * std::f64::consts::PI * radius_m.powi(3) * 4.0 / 3.0;
        let inertia = Matrix3::identity() * (0.4 * mass * radius_m.powi(2));
        Self { mass_kg: mass, centre_m: Vector3::zeros(), inertia_kg_m2: inertia }
    }

    /// The same body described in the frame that `pose` leads to: r' = R·r + t, I' = R·I·Rᵀ.
    #[must_use]
    pub fn transformed(&self, pose: &Isometry3<f64>) -> Self {
        let rotation = pose.rotation.to_rotation_matrix();
        let r = rotation.matrix();
        Self {
            mass_kg: self.mass_kg,
            centre_m: r * self.centre_m + pose.translation.vector,
            inertia_kg_m2: r * self.inertia_kg_m2 * r.transpose(),
        }
    }

    /// One body made of several, all described in the same frame (parallel-axis theorem).
    ///
    /// The combination of nothing, or of weightless parts, is [`MassProperties::zero`].
    ///
    /// ```
    /// use nalgebra::{Isometry3, Vector3};
    /// use slideway::solid::MassProperties;
    /// let half = MassProperties::from_box(Vector3::new(0.5, 0.2, 0.1), 7850.0);
    /// let (left, right) = (Isometry3::translation(-0.25, 0.0, 0.0), Isometry3::translation(0.25, 0.0, 0.0));
    /// let joined = MassProperties::combined(&[half.transformed(&left), half.transformed(&right)]);
    /// let whole = MassProperties::from_box(Vector3::new(1.0, 0.2, 0.1), 7850.0);
    /// assert!((joined.inertia_kg_m2 - whole.inertia_kg_m2).norm() < 1e-12 * whole.inertia_kg_m2.norm());
    /// ```
    pub fn combined(parts: &[Self]) -> Self {
        let mass: f64 = parts.iter().map(|p| p.mass_kg).sum();
        if mass == 0.0 {
            return Self::zero();
        }
        let moment: Vector3<f64> = parts.iter().map(|p| p.centre_m * p.mass_kg).sum();
        let centre = moment / mass;
        let about_centre = |p: &Self| p.inertia_about(centre);
        Self { mass_kg: mass, centre_m: centre, inertia_kg_m2: parts.iter().map(about_centre).sum() }
    }

    /// Inertia tensor about `point_m` of the frame: I + m·(|d|²·1 − d dᵀ), d from the point to the centre.
    pub fn inertia_about(&self, point_m: Vector3<f64>) -> Matrix3<f64> {
        let d = self.centre_m - point_m;
        self.inertia_kg_m2 + (Matrix3::identity() * d.norm_squared() - d * d.transpose()) * self.mass_kg
    }

    /// Checks that a real body can have these properties: finite, positive mass, a symmetric positive
    /// definite tensor whose principal moments meet the triangle inequality.
    ///
    /// # Errors
    /// What is violated, with the numbers; place (file, link) is the caller's to add.
    pub fn check(&self) -> Result<()> {
        let finite = self.mass_kg.is_finite()
            && self.centre_m.iter().chain(self.inertia_kg_m2.iter()).all(|x| x.is_finite());
        if !finite {
            return Err(Error::new(ErrorKind::NotFinite)
                .found("an inertial with NaN or infinity")
                .expected("finite mass, centre and inertia")
                .remedy("correct the <inertial> of this link"));
        }
        let largest = self.mass_kg.abs().max(self.inertia_kg_m2.amax());
        if largest > HEAVIEST || self.mass_kg.abs() < LIGHTEST_KG {
            return Err(Error::new(ErrorKind::OutOfRange)
                .found(format!(
                    "mass {} kg, moments up to {:e} kg·m²",
                    self.mass_kg,
                    self.inertia_kg_m2.amax()
                ))
                .expected(format!("a mass from {LIGHTEST_KG:e} kg, and at most {HEAVIEST:e} kg and kg·m²"))
                .remedy("correct the <inertial> of this link: kg and kg·m²"));
        }
        if self.mass_kg <= 0.0 {
            return Err(Error::new(ErrorKind::OutOfRange)
                .found(format!("mass {} kg", self.mass_kg))
                .expected("a positive mass")
                .remedy("give the link an <inertial> with its mass and inertia"));
        }
        let mut moments: Vec<f64> = self.inertia_kg_m2.symmetric_eigenvalues().iter().copied().collect();
        moments.sort_by(f64::total_cmp);
        let slack = INERTIA_SLACK * self.inertia_kg_m2.trace().abs();
        let text =
            || format!("principal moments {:.6e}, {:.6e}, {:.6e} kg·m²", moments[0], moments[1], moments[2]);
        if moments[0] <= 0.0 {
            return Err(Error::new(ErrorKind::OutOfRange)
                .found(text())
                .expected("three positive principal moments")
                .remedy("correct ixx … izz (tensor elements: ixy = −∫ x·y dm)"));
        }
        if moments[0] + moments[1] < moments[2] - slack {
            return Err(Error::new(ErrorKind::Inconsistent)
                .found(text())
                .expected("no principal moment above the sum of the other two (no real body has such)")
                .remedy("correct ixx … izz; check that they are about the centre of mass"));
        }
        Ok(())
    }
}
