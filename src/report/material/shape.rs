//! The machine's surface for drawing, in the base body's frame at joint position zero.

use crate::machine::Machine;
use crate::plant::rapier::Supports;
use crate::solid::{Joint, Mesh, Shape, Side};
use crate::units::Motion;
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// The surface of one link.
#[derive(Debug, Clone)]
pub struct Surface {
    /// The link.
    pub name: String,
    /// Whether the joint moves it.
    pub moves: bool,
    /// Corners in m.
    pub vertices: Vec<[f64; 3]>,
    /// Indices into them.
    pub triangles: Vec<[u32; 3]>,
}

/// A machine to be drawn.
#[derive(Debug, Clone)]
pub struct MachineShape {
    /// Kind of axis.
    pub motion: Motion,
    /// Its links.
    pub surfaces: Vec<Surface>,
    /// Direction of positive motion.
    pub axis: [f64; 3],
    /// A point on the joint's axis, in m.
    pub origin: [f64; 3],
    /// Places of the sliders in m, with their names.
    pub sliders: Vec<(String, [f64; 3])>,
    /// Lowest and highest position of the joint; a guess where it has no limits.
    pub limits: [f64; 2],
    /// Frequencies of the base's modes in Hz with their modal masses in kg.
    pub modes: Vec<[f64; 2]>,
}

/// Triangles that are drawn at most; a finer mesh is drawn coarser.
const MOST_TRIANGLES: usize = 24_000;
/// Sides of a cylinder, meridians of a ball.
const SIDES: u32 = 32;

impl MachineShape {
    /// The surface of a machine.
    pub fn of(machine: &Machine) -> Self {
        let solid = machine.solid();
        let joint = &solid.joint;
        let mut surfaces = Vec::new();
        for (side, link) in solid.links() {
            let moves = side == Side::Moving;
            let body = if moves { joint.origin } else { Isometry3::identity() };
            let mut surface =
                Surface { name: link.name.clone(), moves, vertices: Vec::new(), triangles: Vec::new() };
            for geometry in &link.geometry {
                let pose = body * link.pose_in_body * geometry.pose;
                surface.add(&tessellated(&geometry.shape), &pose);
            }
            if !surface.triangles.is_empty() {
                surfaces.push(surface);
            }
        }
        coarsen(&mut surfaces);
        let point = |p: Point3<f64>| [p.x, p.y, p.z];
        let axis = joint.origin * joint.axis.into_inner();
        let names: Vec<&str> = machine.description().guide.sliders.iter().map(String::as_str).collect();
        let supports = (joint.motion == Motion::Prismatic)
            .then(|| Supports::new(solid, &names, Vector3::z()).ok())
            .flatten();
        let sliders = supports.map_or_else(Vec::new, |supports| {
            let points = supports.points().iter().map(|p| point(joint.origin * p));
            supports.names().iter().cloned().zip(points).collect()
        });
        let modes = machine.constants().modes;
        Self {
            motion: joint.motion,
            surfaces,
            axis: [axis.x, axis.y, axis.z],
            origin: point(Point3::from(joint.origin.translation.vector)),
            sliders,
            limits: limits(joint),
            modes: modes.as_slice().iter().map(|m| [m.frequency_hz(), m.mass_kg()]).collect(),
        }
    }

    /// Lower and upper corner of everything at joint position zero, in m.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let all = self.surfaces.iter().flat_map(|surface| &surface.vertices);
        all.fold(start, |[low, high], v| {
            [std::array::from_fn(|k| low[k].min(v[k])), std::array::from_fn(|k| high[k].max(v[k]))]
        })
    }
}

/// The joint's limits, or a turn and a metre where it has none.
fn limits(joint: &Joint) -> [f64; 2] {
    let reach = if joint.motion == Motion::Prismatic { 0.5 } else { 0.5 * TAU };
    let finite = |limit: f64, guess: f64| if limit.is_finite() { limit } else { guess };
    [finite(joint.lower, -reach), finite(joint.upper, reach)]
}

impl Surface {
    fn add(&mut self, mesh: &Mesh, pose: &Isometry3<f64>) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(mesh.vertices.iter().map(|v| {
            let p = pose * v;
            [p.x, p.y, p.z]
        }));
        self.triangles.extend(mesh.triangles.iter().map(|t| t.map(|k| k + first)));
    }

    /// The surface on a grid: corners of one cell become one, triangles within a cell vanish.
    fn on_grid(&self, cell: f64) -> Self {
        let mut places: HashMap<[i64; 3], u32> = HashMap::new();
        let mut vertices = Vec::new();
        let index: Vec<u32> = self
            .vertices
            .iter()
            .map(|v| {
                *places.entry(v.map(|x| (x / cell).round() as i64)).or_insert_with(|| {
                    vertices.push(*v);
                    vertices.len() as u32 - 1
                })
            })
            .collect();
        let moved = self.triangles.iter().map(|t| t.map(|k| index[k as usize]));
        let mut triangles: Vec<[u32; 3]> = moved.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        triangles.sort_unstable();
        triangles.dedup();
        Self { name: self.name.clone(), moves: self.moves, vertices, triangles }
    }
}

/// Draws meshes coarser until there are few enough triangles.
fn coarsen(surfaces: &mut [Surface]) {
    let size = |surface: &Surface| {
        let [low, high] = surface.vertices.iter().fold(
            [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
            |[low, high]: [[f64; 3]; 2], v| {
                [std::array::from_fn(|k| low[k].min(v[k])), std::array::from_fn(|k| high[k].max(v[k]))]
            },
        );
        (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
    };
    let mut cells = 400.0;
    let share = MOST_TRIANGLES / surfaces.len().max(1);
    while surfaces.iter().map(|s| s.triangles.len()).sum::<usize>() > MOST_TRIANGLES && cells > 4.0 {
        for surface in surfaces.iter_mut().filter(|s| s.triangles.len() > share) {
            *surface = surface.on_grid(size(surface) / cells);
        }
        cells *= 0.7;
    }
}

/// A shape as triangles.
fn tessellated(shape: &Shape) -> Mesh {
    match shape {
        Shape::Mesh { mesh, .. } => (**mesh).clone(),
        Shape::Box { size_m } => block(*size_m),
        Shape::Cylinder { radius_m, length_m } => turned(&[
            [0.0, -0.5 * length_m],
            [*radius_m, -0.5 * length_m],
            [*radius_m, 0.5 * length_m],
            [0.0, 0.5 * length_m],
        ]),
        Shape::Sphere { radius_m } => {
            let half = SIDES / 2;
            let point = |k: u32| {
                let (sine, cosine) = (0.5 * TAU * f64::from(k) / f64::from(half)).sin_cos();
                [radius_m * sine, -radius_m * cosine]
            };
            turned(&(0..=half).map(point).collect::<Vec<_>>())
        }
    }
}

fn block(size: Vector3<f64>) -> Mesh {
    let corner = |k: usize| {
        let sign = |bit: usize| if k >> bit & 1 == 1 { 0.5 } else { -0.5 };
        Point3::new(sign(0) * size.x, sign(1) * size.y, sign(2) * size.z)
    };
    let sides: [[u32; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Mesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A profile (radius, height) turned about z.
fn turned(profile: &[[f64; 2]]) -> Mesh {
    let rows = profile.len() as u32;
    let mut mesh = Mesh { vertices: Vec::new(), triangles: Vec::new() };
    for side in 0..SIDES {
        let (sine, cosine) = (TAU * f64::from(side) / f64::from(SIDES)).sin_cos();
        mesh.vertices.extend(profile.iter().map(|[r, z]| Point3::new(r * cosine, r * sine, *z)));
        let next = (side + 1) % SIDES;
        for row in 0..rows - 1 {
            let (a, b) = (side * rows + row, next * rows + row);
            mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    let is_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| mesh.vertices[k as usize]);
        (b - a).cross(&(c - a)).norm() > 1e-18
    };
    let triangles = mesh.triangles.iter().copied().filter(is_area).collect();
    Mesh { triangles, vertices: mesh.vertices.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_tessellated_shapes_have_nearly_their_volume() {
        let ball = tessellated(&Shape::Sphere { radius_m: 0.1 });
        let cylinder = tessellated(&Shape::Cylinder { radius_m: 0.1, length_m: 0.3 });
        let block = tessellated(&Shape::Box { size_m: Vector3::new(0.1, 0.2, 0.3) });
        let pi = std::f64::consts::PI;
        for (mesh, volume, within) in
            [(ball, 4.0 / 3.0 * pi * 1e-3, 0.03), (cylinder, pi * 3e-3, 0.01), (block, 6e-3, 1e-9)]
        {
            assert!((mesh.volume_m3() / volume - 1.0).abs() < within, "{} for {volume}", mesh.volume_m3());
        }
    }

    #[test]
    fn exact_a_fine_mesh_is_drawn_coarser() {
        let profile: Vec<[f64; 2]> = (0..=2000)
            .map(|k| {
                let x = f64::from(k) / 2000.0;
                [0.1 * (std::f64::consts::PI * x).sin(), x]
            })
            .collect();
        let mesh = turned(&profile);
        let mut surface =
            Surface { name: String::new(), moves: false, vertices: Vec::new(), triangles: Vec::new() };
        surface.add(&mesh, &Isometry3::identity());
        let mut surfaces = vec![surface];
        assert!(surfaces[0].triangles.len() > MOST_TRIANGLES);
        coarsen(&mut surfaces);
        assert!((1000..=MOST_TRIANGLES).contains(&surfaces[0].triangles.len()));
    }
}
