//! A strip of cells, the darker the more of the gap lies there.

use super::axis::Axis;
use super::draw::Draw;
use super::{Width, lines};

/// A strip of cells along an axis.
#[derive(Debug, Clone)]
pub struct Heat {
    /// What stands above.
    pub title: String,
    /// The axis below; ticks at the cells' edges where `names` is empty.
    pub axis: Axis,
    /// Shares, 0 to 1 each.
    pub shares: Vec<f64>,
    /// A word for each cell; empty for cells along the axis.
    pub names: Vec<String>,
}

const FONT: f64 = 11.5;
const HEIGHT: f64 = 34.0;

impl Heat {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        draw.text([8.0, top + 17.0], FONT + 0.5, "strong", "start", &self.title);
        let (left, right, y) = (8.0, width.px() - 8.0, top + 24.0);
        let each = (right - left) / self.shares.len().max(1) as f64;
        let most = self.shares.iter().copied().filter(|s| s.is_finite()).fold(0.0, f64::max);
        for (k, share) in self.shares.iter().enumerate() {
            let full = if most > 0.0 && share.is_finite() { (share / most).max(0.0) } else { 0.0 };
            draw.cell([left + k as f64 * each, y], [each, HEIGHT], "f heat", full);
            let text = if *share >= 0.995 { "> 99 %".to_owned() } else { format!("{:.0} %", 100.0 * share) };
            if each > 38.0 && *share >= 0.005 {
                let class = if full > 0.72 { "onheat" } else { "" };
                let middle = left + (k as f64 + 0.5) * each;
                draw.text([middle, y + 0.5 * HEIGHT + 4.0], FONT, class, "middle", &text);
            }
        }
        draw.path(&format!("M{left} {y:.1}H{right}v{HEIGHT}H{left}z"), "frame");
        let below = if self.names.is_empty() {
            self.ticks(draw, width, [left, right], y)
        } else {
            self.words(draw, each, y)
        };
        y + HEIGHT + below - top
    }

    fn ticks(&self, draw: &mut Draw, width: Width, [left, right]: [f64; 2], y: f64) -> f64 {
        for (value, text) in self.axis.ticks(if width.is_narrow() { 4 } else { 9 }) {
            let x = left + self.axis.place(value) * (right - left);
            draw.path(&format!("M{x:.1} {:.1}v4", y + HEIGHT), "frame");
            let anchor = if x < left + 20.0 {
                "start"
            } else if x > right - 20.0 {
                "end"
            } else {
                "middle"
            };
            draw.text([x, y + HEIGHT + 16.0], FONT - 0.5, "pale", anchor, &text);
        }
        let middle = 0.5 * (left + right);
        draw.text([middle, y + HEIGHT + 31.0], FONT - 0.5, "pale axis", "middle", &self.axis.label);
        42.0
    }

    fn words(&self, draw: &mut Draw, each: f64, y: f64) -> f64 {
        let mut most = 1;
        for (k, name) in self.names.iter().enumerate() {
            let middle = 8.0 + (k as f64 + 0.5) * each;
            let size = if each < 64.0 { 9.0 } else { FONT - 0.5 };
            let rows = lines(name, size, each);
            most = most.max(rows.len());
            for (row, line) in rows.iter().enumerate() {
                draw.text([middle, y + HEIGHT + 15.0 + 12.0 * row as f64], size, "pale", "middle", line);
            }
        }
        12.0 + 13.0 * most as f64
    }
}
