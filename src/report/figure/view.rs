//! The machine seen from a corner, drawn from back to front.

use super::Width;
use super::draw::Draw;
use crate::report::material::MachineShape;
use std::fmt::Write as _;

/// A machine at joint position zero.
#[derive(Debug, Clone)]
pub struct View {
    /// The machine.
    pub shape: MachineShape,
}

/// Where the eye is: turned about the upright, then lifted, in rad.
const AZIMUTH: f64 = 0.62;
const ELEVATION: f64 = 0.5;
/// Height over width of the picture.
const ASPECT: f64 = 0.52;
/// Facets are cut until no edge is longer than this share of the machine, so that they can be sorted.
const FINEST: f64 = 0.11;
/// Cells of the picture in which the nearest facet is looked for, across.
const CELLS: usize = 360;
/// Shades of a colour.
const SHADES: f64 = 12.0;

/// A facet in the picture: places in px, nearness, shade and whether it moves.
struct Facet {
    corners: [[f64; 3]; 3],
    light: f64,
    moves: bool,
}

impl View {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let size = [width.px(), (ASPECT * width.px()).max(230.0)];
        let camera = Camera::of(&self.shape, size);
        let mut facets = self.facets(&camera);
        let seen = visible(&facets, size);
        let mut keep = seen.into_iter();
        facets.retain(|_| keep.next().unwrap_or(true));
        facets.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        let mut data = String::new();
        let mut last: Option<(bool, i64)> = None;
        for facet in &facets {
            let shade = (facet.light * SHADES).round() as i64;
            if last.is_some_and(|known| known != (facet.moves, shade)) {
                paint(draw, &mut data, last);
            }
            last = Some((facet.moves, shade));
            let [a, b, c] = facet.corners.map(|[x, y, _]| [x, top + y]);
            let _ = write!(data, "M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}z", a[0], a[1], b[0], b[1], c[0], c[1]);
        }
        paint(draw, &mut data, last);
        self.labels(draw, &camera, top);
        top_height(size)
    }

    /// Direction of positive motion, and the sliders' names.
    fn labels(&self, draw: &mut Draw, camera: &Camera, top: f64) {
        for (name, place) in &self.shape.sliders {
            let [x, y, _] = camera.project(*place);
            let letter: String = name.chars().rev().take(1).collect::<String>().to_uppercase();
            draw.text([x, top + y + 4.0], 12.0, "strong halo", "middle", &letter);
        }
        let middle = [camera.size[0] - 78.0, camera.size[1] - 26.0];
        let flat = [dot(self.shape.axis, camera.right), -dot(self.shape.axis, camera.up)];
        let long = 44.0 / flat[0].hypot(flat[1]).max(0.2);
        let (x0, y0) = (middle[0] - 0.5 * long * flat[0], middle[1] - 0.5 * long * flat[1]);
        let (x1, y1) = (x0 + long * flat[0], y0 + long * flat[1]);
        let (dx, dy) = (x1 - x0, y1 - y0);
        let length = dx.hypot(dy).max(1.0);
        let (ux, uy) = (dx / length, dy / length);
        draw.path(
            &format!(
                "M{x0:.1} {:.1}L{x1:.1} {:.1}M{:.1} {:.1}L{x1:.1} {:.1}L{:.1} {:.1}",
                top + y0,
                top + y1,
                x1 - 8.0 * ux + 4.0 * uy,
                top + y1 - 8.0 * uy - 4.0 * ux,
                top + y1,
                x1 - 8.0 * ux - 4.0 * uy,
                top + y1 - 8.0 * uy + 4.0 * ux
            ),
            "l after",
        );
        draw.text([x1 + 8.0 * ux, top + y1 - 6.0], 12.0, "strong", "middle", "+");
    }

    fn facets(&self, camera: &Camera) -> Vec<Facet> {
        let [low, high] = self.shape.bounds();
        let finest = FINEST * (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
        let mut facets = Vec::new();
        for surface in &self.shape.surfaces {
            for triangle in &surface.triangles {
                let corners = triangle.map(|k| surface.vertices[k as usize]);
                let Some(normal) = normal(corners) else { continue };
                if camera.away(normal) {
                    continue;
                }
                let light = camera.light(normal);
                let mut pending = vec![corners];
                while let Some(corners) = pending.pop() {
                    match halves(corners, finest) {
                        Some(two) => pending.extend(two),
                        None => facets.push(Facet {
                            corners: corners.map(|p| camera.project(p)),
                            light,
                            moves: surface.moves,
                        }),
                    }
                }
            }
        }
        facets
    }
}

fn top_height([_, height]: [f64; 2]) -> f64 {
    height + 4.0
}

fn paint(draw: &mut Draw, data: &mut String, of: Option<(bool, i64)>) {
    if let (Some((moves, shade)), false) = (of, data.is_empty()) {
        draw.shade(data, if moves { "facet moves" } else { "facet" }, shade as f64 / SHADES);
    }
    data.clear();
}

fn depth(facet: &Facet) -> f64 {
    facet.corners.iter().map(|c| c[2]).sum()
}

fn normal([a, b, c]: [[f64; 3]; 3]) -> Option<[f64; 3]> {
    let (u, v) = (difference(b, a), difference(c, a));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let size = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    (size > 0.0).then(|| n.map(|x| x / size))
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

/// A triangle cut through its longest edge, where that is too long.
fn halves([a, b, c]: [[f64; 3]; 3], finest: f64) -> Option<[[[f64; 3]; 3]; 2]> {
    let length = |p: [f64; 3], q: [f64; 3]| difference(p, q).iter().map(|x| x * x).sum::<f64>().sqrt();
    let middle = |p: [f64; 3], q: [f64; 3]| std::array::from_fn(|k| 0.5 * (p[k] + q[k]));
    let (ab, bc, ca) = (length(a, b), length(b, c), length(c, a));
    if ab.max(bc).max(ca) <= finest {
        None
    } else if ab >= bc && ab >= ca {
        let m = middle(a, b);
        Some([[a, m, c], [m, b, c]])
    } else if bc >= ca {
        let m = middle(b, c);
        Some([[a, b, m], [a, m, c]])
    } else {
        let m = middle(c, a);
        Some([[a, b, m], [m, b, c]])
    }
}

/// Which facets are the nearest anywhere in the picture.
fn visible(facets: &[Facet], [width, height]: [f64; 2]) -> Vec<bool> {
    let scale = CELLS as f64 / width;
    let rows = (height * scale).ceil() as usize + 1;
    let mut nearest = vec![(f64::NEG_INFINITY, usize::MAX); CELLS * rows];
    for (index, facet) in facets.iter().enumerate() {
        let [a, b, c] = facet.corners.map(|[x, y, z]| [x * scale, y * scale, z]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 {
            continue;
        }
        let range = |values: [f64; 3], most: usize| {
            let [low, high] = super::axis::extremes(values);
            (low.floor().max(0.0) as usize)..((high.ceil().max(0.0) as usize + 1).min(most))
        };
        for row in range([a[1], b[1], c[1]], rows) {
            for column in range([a[0], b[0], c[0]], CELLS) {
                let (x, y) = (column as f64, row as f64);
                let v = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                let w = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                if v < -0.02 || w < -0.02 || v + w > 1.02 {
                    continue;
                }
                let z = a[2] + v * (b[2] - a[2]) + w * (c[2] - a[2]);
                let cell = &mut nearest[row * CELLS + column];
                if z > cell.0 {
                    *cell = (z, index);
                }
            }
        }
    }
    let mut seen = vec![false; facets.len()];
    for (_, index) in nearest {
        if let Some(facet) = seen.get_mut(index) {
            *facet = true;
        }
    }
    seen
}

/// A parallel projection that holds the whole machine.
struct Camera {
    right: [f64; 3],
    up: [f64; 3],
    toward: [f64; 3],
    scale: f64,
    middle: [f64; 2],
    size: [f64; 2],
}

impl Camera {
    fn of(shape: &MachineShape, size: [f64; 2]) -> Self {
        let ((sa, ca), (se, ce)) = (AZIMUTH.sin_cos(), ELEVATION.sin_cos());
        let toward = [-sa * ce, -ca * ce, se].map(|x: f64| x);
        let right = [ca, -sa, 0.0];
        let up = [sa * se, ca * se, ce];
        let mut camera = Self { right, up, toward, scale: 1.0, middle: [0.0; 2], size };
        let flat: Vec<[f64; 2]> = shape
            .surfaces
            .iter()
            .flat_map(|surface| &surface.vertices)
            .map(|v| [dot(*v, camera.right), dot(*v, camera.up)])
            .collect();
        let [x, y] = [0, 1].map(|k| super::axis::extremes(flat.iter().map(|p| p[k])));
        camera.middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
        let room = [size[0] - 40.0, size[1] - 60.0];
        camera.scale = (room[0] / (x[1] - x[0]).max(1e-9)).min(room[1] / (y[1] - y[0]).max(1e-9));
        camera
    }

    fn project(&self, p: [f64; 3]) -> [f64; 3] {
        [
            0.5 * self.size[0] + self.scale * (dot(p, self.right) - self.middle[0]),
            0.5 * self.size[1] + 14.0 - self.scale * (dot(p, self.up) - self.middle[1]),
            self.scale * dot(p, self.toward),
        ]
    }

    fn away(&self, normal: [f64; 3]) -> bool {
        dot(normal, self.toward) <= 0.0
    }

    /// Light from above, the side and the eye.
    fn light(&self, normal: [f64; 3]) -> f64 {
        let side = dot(normal, self.right);
        (0.3 + 0.45 * normal[2].max(0.0) + 0.22 * dot(normal, self.toward) + 0.12 * side).clamp(0.0, 1.0)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(&b).map(|(x, y)| x * y).sum()
}
