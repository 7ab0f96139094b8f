//! A value over two numbers, as shaded cells.

use super::axis::{Axis, extremes};
use super::draw::Draw;
use super::{Width, text_width};
use std::fmt::Write as _;

/// Shades of the scale.
const SHADES: usize = 12;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 14.0;
const FONT: f64 = 11.5;
/// Height of a line of words.
const LINE: f64 = 14.0;
/// Height over width of the drawn area.
const ASPECT: f64 = 0.5;
/// Height of the scale below.
const SCALE: f64 = 10.0;

/// Shaded cells over two numbers: dark is more. Cells outside the limits are hatched grey.
#[derive(Debug, Clone)]
pub struct Map {
    /// What stands above.
    pub title: String,
    /// Centres of the columns, ascending, and what they are.
    pub x: (String, Vec<f64>),
    /// Centres of the rows, ascending, and what they are.
    pub y: (String, Vec<f64>),
    /// A value a cell, the columns fastest; not a number where there is none.
    pub values: Vec<f64>,
    /// Whether a cell keeps all limits.
    pub is_inside: Vec<bool>,
    /// What the values are, with their unit.
    pub scale: String,
    /// Places with a name.
    pub marks: Vec<([f64; 2], String)>,
}

/// The drawn area and the edges of its cells.
struct Field {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
    x: Axis,
    y: Axis,
}

impl Field {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [
            self.left + self.x.place(x) * (self.right - self.left),
            self.bottom - self.y.place(y) * (self.bottom - self.top),
        ]
    }
}

/// Edges of cells around their centres.
fn edges(centres: &[f64]) -> Vec<f64> {
    let (Some(first), Some(last)) = (centres.first(), centres.last()) else { return vec![0.0, 1.0] };
    let half = |a: f64, b: f64| 0.5 * (b - a);
    let lead = centres.get(1).map_or(0.5, |next| half(*first, *next));
    let trail = if centres.len() > 1 { half(centres[centres.len() - 2], *last) } else { 0.5 };
    let between = centres.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    [first - lead].into_iter().chain(between).chain([last + trail]).collect()
}

impl Map {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        draw.text([8.0, top + 17.0], FONT + 0.5, "strong", "start", &self.title);
        let (columns, rows) = (edges(&self.x.1), edges(&self.y.1));
        let range = |edges: &[f64]| [edges[0], edges[edges.len() - 1]];
        let (left, right) = (LEFT, width.px() - RIGHT);
        let height = ASPECT.max(if width.is_narrow() { 0.8 } else { 0.0 }) * (right - left);
        let field = Field {
            left,
            right,
            top: top + 26.0,
            bottom: top + 26.0 + height,
            x: Axis::linear(self.x.0.clone(), range(&columns)),
            y: Axis::linear(self.y.0.clone(), range(&rows)),
        };
        self.cells(draw, &field, &columns, &rows);
        draw.path(&format!("M{left} {:.1}H{right:.1}V{:.1}H{left}z", field.top, field.bottom), "frame");
        ticks(draw, &field, width);
        self.named(draw, &field);
        26.0 + height + 40.0 + self.legend(draw, &field)
    }

    /// Cells of one shade are one path.
    fn cells(&self, draw: &mut Draw, field: &Field, columns: &[f64], rows: &[f64]) {
        let [least, most] = extremes(self.inside());
        let mut shades = vec![String::new(); SHADES + 1];
        let mut beyond = String::new();
        let count = self.x.1.len();
        for (k, value) in self.values.iter().enumerate() {
            let (column, row) = (k % count, k / count);
            let [x0, y1] = field.place([columns[column], rows[row]]);
            let [x1, y0] = field.place([columns[column + 1], rows[row + 1]]);
            let is_inside = self.is_inside.get(k) == Some(&true) && value.is_finite();
            let share = if most > least { (value - least) / (most - least) } else { 0.0 };
            let path = if is_inside {
                &mut shades[(share.clamp(0.0, 1.0) * SHADES as f64).round() as usize]
            } else {
                &mut beyond
            };
            let _ = write!(path, "M{x0:.1} {y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}z");
        }
        draw.fill(&beyond, "f noise", 0.45);
        for (k, path) in shades.iter().enumerate() {
            draw.fill(path, "f after", opacity(k as f64 / SHADES as f64));
        }
    }

    fn inside(&self) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().zip(&self.is_inside).filter(|(_, inside)| **inside).map(|(value, _)| *value)
    }

    fn named(&self, draw: &mut Draw, field: &Field) {
        let outside = |[x, y]: [f64; 2]| {
            !((0.0..=1.0).contains(&field.x.place(x)) && (0.0..=1.0).contains(&field.y.place(y)))
        };
        let mut taken: Vec<[f64; 3]> = Vec::new();
        for (place, word) in self.marks.iter().filter(|(place, _)| !outside(*place)) {
            let [x, y] = field.place(*place);
            draw.path(&format!("M{:.1} {y:.1}h10M{x:.1} {:.1}v10", x - 5.0, y - 5.0), "l key before");
            let wide = text_width(word, FONT);
            let is_right = x + 10.0 + wide < field.right;
            let (x, anchor) = if is_right { (x + 9.0, "start") } else { (x - 9.0, "end") };
            let from = if is_right { x } else { x - wide };
            // Beside the cross, where another name does not stand there already.
            let free = |y: f64| {
                let is_over = |[a, b, at]: &[f64; 3]| *a < from + wide && from < *b && (at - y).abs() < LINE;
                !taken.iter().any(is_over)
            };
            let y = [y - 7.0, y + LINE, y - 7.0 - LINE, y + 2.0 * LINE]
                .into_iter()
                .find(|y| free(*y))
                .unwrap_or(y);
            taken.push([from, from + wide, y]);
            draw.text([x, y], FONT, "strong halo", anchor, word);
        }
    }

    /// The scale; returns its height.
    fn legend(&self, draw: &mut Draw, field: &Field) -> f64 {
        let [least, most] = extremes(self.inside());
        let y = field.bottom + 46.0;
        let each = 0.4 * (field.right - field.left) / (SHADES + 1) as f64;
        for k in 0..=SHADES {
            let share = opacity(k as f64 / SHADES as f64);
            draw.cell([field.left + k as f64 * each, y], [each, SCALE], "f after", share);
        }
        let end = field.left + (SHADES + 1) as f64 * each;
        let has_inside = self.inside().next().is_some();
        let words = if has_inside {
            format!("{}: {least:.0} to {most:.0}; grey: a limit is exceeded", self.scale)
        } else {
            "grey: a limit is exceeded everywhere".to_owned()
        };
        let mut below = y + SCALE;
        for line in super::lines(&words, FONT, field.right - end - 10.0) {
            draw.text([end + 10.0, below], FONT, "", "start", &line);
            below += 14.0;
        }
        below - field.bottom - 30.0
    }
}

/// The least value is seen too.
fn opacity(share: f64) -> f64 {
    0.08 + 0.87 * share
}

fn ticks(draw: &mut Draw, field: &Field, width: Width) {
    for (value, text) in field.x.ticks(if width.is_narrow() { 4 } else { 9 }) {
        let x = field.left + field.x.place(value) * (field.right - field.left);
        draw.path(&format!("M{x:.1} {:.1}v4", field.bottom), "frame");
        draw.text([x, field.bottom + 16.0], FONT, "pale", "middle", &text);
    }
    for (value, text) in field.y.ticks(6) {
        let y = field.bottom - field.y.place(value) * (field.bottom - field.top);
        draw.path(&format!("M{:.1} {y:.1}h4", field.left - 4.0), "frame");
        draw.text([field.left - 7.0, y + 4.0], FONT, "pale", "end", &text);
    }
    let middle = 0.5 * (field.left + field.right);
    draw.text([middle, field.bottom + 32.0], FONT, "pale axis", "middle", &field.x.label);
    draw.upright([14.0, 0.5 * (field.top + field.bottom)], FONT, "pale axis", &field.y.label);
}
