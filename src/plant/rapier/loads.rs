//! What the guide carries: the joint's reaction and its share on each bearing slider.

use nalgebra::{DMatrix, Point3, SVector, Unit, Vector3};

use crate::error::{Error, ErrorKind, Result};
use crate::solid::{Side, Solid};

/// Smallest ratio of singular values at which the supports count as holding the body.
const RANK_TOLERANCE: f64 = 1e-9;

/// Force and moment that the base exerts on the moving body through the joint, in the moving body's
/// frame; the moment is about the moving body's centre of mass.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reaction {
    /// Force, in N.
    pub force_n: Vector3<f64>,
    /// Moment about the centre of mass, in N·m.
    pub moment_n_m: Vector3<f64>,
}

/// Load of one bearing slider: what the rail exerts on it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SupportLoad {
    /// Along the supports' up direction, in N: positive presses the slider onto the rail.
    pub vertical_n: f64,
    /// Along up × direction of motion (to the left of the motion), in N.
    pub lateral_n: f64,
}

/// Bearing sliders that carry the moving body of a prismatic joint, and how they share a reaction.
///
/// # Model
/// A rigid body on n equal springs, each with the same stiffness k vertically and laterally. The body
/// yields by u (two displacements and three rotations, small), slider i is loaded by f = k·Aᵀ·u, and
/// equilibrium demands A·f = b, where b is the reaction (two forces, three moments about the sliders'
/// centre) and A the 5 × 2n matrix of unit loads. Hence f = Aᵀ·(A·Aᵀ)⁻¹·b whatever k: the loads of least
/// sum of squares among all that balance the reaction.
///
/// # Validity
/// No preload (it adds the same pair of inner forces whatever the motion), no difference between rails,
/// carriages that pass no moment of their own. Loads may come out negative: the slider is pulled off,
/// which a profile rail carries.
#[derive(Debug, Clone)]
pub struct Supports {
    names: Vec<String>,
    points: Vec<Point3<f64>>,
    centre: Point3<f64>,
    mass_centre: Point3<f64>,
    up: Unit<Vector3<f64>>,
    left: Unit<Vector3<f64>>,
    along: Unit<Vector3<f64>>,
    /// Aᵀ(AAᵀ)⁻¹: rows are vertical and lateral load of each slider in turn, columns the five of b.
    share: DMatrix<f64>,
}

impl Supports {
    /// Supports at the origins of the named links, which must belong to the moving body. `up` is in the
    /// moving body's frame; its part along the joint is ignored.
    ///
    /// # Errors
    /// An unknown link, a link of the base, `up` along the joint, or places that cannot hold the body
    /// (fewer than three, or all in one line).
    pub fn new(solid: &Solid, links: &[&str], up: Vector3<f64>) -> Result<Self> {
        let mut points = Vec::with_capacity(links.len());
        for name in links {
            let (side, link) = solid.link(name)?;
            if side == Side::Base {
                return Err(Error::new(ErrorKind::Inconsistent)
                    .file(&solid.path)
                    .key(*name)
                    .found("a link that stands still")
                    .expected("a link of the moving body")
                    .remedy("name the sliders, not the rails"));
            }
            points.push(Point3::from(link.pose_in_body.translation.vector));
        }
        let along = solid.joint.axis;
        let up =
            Unit::try_new(up - along.into_inner() * along.dot(&up), 1e-9 * up.norm()).ok_or_else(|| {
                Error::new(ErrorKind::OutOfRange)
                    .file(&solid.path)
                    .key("up")
                    .found("a direction along the joint, or zero")
                    .expected("the direction in which the sliders carry the weight")
                    .remedy("state it in the frame of the moving body")
            })?;
        let left = Unit::new_normalize(up.cross(&along));
        let count = points.len().max(1) as f64;
        let centre = Point3::from(points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / count);
        let share = Self::shares(&points, &centre, &[up, left], &along).ok_or_else(|| {
            Error::new(ErrorKind::Undetermined)
                .file(&solid.path)
                .key(links.join(", "))
                .found(format!("{} supports that do not hold the body", links.len()))
                .expected("at least three supports that are not in one line")
                .remedy("place the sliders where they are on the machine")
        })?;
        let names = links.iter().map(|name| (*name).to_owned()).collect();
        let mass_centre = Point3::from(solid.moving.mass.centre_m);
        Ok(Self { names, points, centre, mass_centre, up, left, along, share })
    }

    fn shares(
        points: &[Point3<f64>],
        centre: &Point3<f64>,
        directions: &[Unit<Vector3<f64>>; 2],
        along: &Unit<Vector3<f64>>,
    ) -> Option<DMatrix<f64>> {
        let mut a = DMatrix::zeros(5, 2 * points.len());
        let [up, left] = directions;
        // Moments are in units of force at the supports' spread, so that rank does not depend on size.
        let spread = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
        if spread == 0.0 {
            return None;
        }
        for (i, point) in points.iter().enumerate() {
            for (k, direction) in directions.iter().enumerate() {
                let moment = (point - centre).cross(direction) / spread;
                let column = [
                    up.dot(direction),
                    left.dot(direction),
                    moment.dot(along),
                    moment.dot(left),
                    moment.dot(up),
                ];
                a.set_column(2 * i + k, &SVector::from(column));
            }
        }
        let singular = a.clone().svd(true, true);
        let largest = singular.singular_values.max();
        if singular.rank(RANK_TOLERANCE * largest) < 5 {
            return None;
        }
        let mut share = singular.pseudo_inverse(RANK_TOLERANCE * largest).ok()?;
        share.columns_mut(2, 3).scale_mut(1.0 / spread);
        Some(share)
    }

    /// Names of the sliders, in the order of the loads.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Where the sliders are in the moving body's frame.
    pub fn points(&self) -> &[Point3<f64>] {
        &self.points
    }

    /// Loads of the sliders that balance `reaction`.
    ///
    /// The reaction's part along the joint (an end stop's, else zero) is carried by none of them.
    pub fn distribute(&self, reaction: &Reaction) -> Vec<SupportLoad> {
        let Self { up, left, along, .. } = self;
        let force = reaction.force_n - along.into_inner() * along.dot(&reaction.force_n);
        let moment = reaction.moment_n_m + (self.mass_centre - self.centre).cross(&force);
        let b = SVector::from([
            up.dot(&force),
            left.dot(&force),
            along.dot(&moment),
            left.dot(&moment),
            up.dot(&moment),
        ]);
        let loads = &self.share * b;
        let (pairs, _) = loads.as_slice().as_chunks::<2>();
        pairs.iter().map(|&[vertical_n, lateral_n]| SupportLoad { vertical_n, lateral_n }).collect()
    }
}
