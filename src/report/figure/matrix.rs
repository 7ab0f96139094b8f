//! A matrix of correlations: cells the fuller the closer to ±1.

use super::draw::Draw;
use super::{Ink, Width, lines};

/// Correlations of named numbers, symmetric.
#[derive(Debug, Clone)]
pub struct Matrix {
    /// Names of rows and columns.
    pub names: Vec<String>,
    /// Correlations, −1 to 1, row by row.
    pub rows: Vec<Vec<f64>>,
}

const FONT: f64 = 11.0;
const LEAST_ROW: f64 = 20.0;
const LINE: f64 = 13.0;
/// Cells are no wider than this.
const WIDEST: f64 = 52.0;
/// Narrower cells hold no number.
const NUMBERED: f64 = 26.0;
/// Cells fuller than this take letters of the other colour.
const FULL: f64 = 0.72;

impl Matrix {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let count = self.names.len().max(1) as f64;
        let words = if width.is_narrow() { 0.42 } else { 0.36 } * width.px();
        let each = ((width.px() - words - 16.0) / count).min(WIDEST);
        for k in 0..self.names.len() {
            let x = words + (k as f64 + 0.5) * each;
            draw.text([x, top + 13.0], FONT, "pale", "middle", &(k + 1).to_string());
        }
        let mut y = top + 20.0;
        for (k, (name, row)) in self.names.iter().zip(&self.rows).enumerate() {
            let text = lines(&format!("{} {name}", k + 1), FONT, words - 14.0);
            let height = LEAST_ROW.max(LINE * text.len() as f64 + 5.0);
            let first = y + 0.5 * height + 4.0 - 0.5 * LINE * (text.len() as f64 - 1.0);
            for (n, line) in text.iter().enumerate() {
                draw.text([8.0, first + LINE * n as f64], FONT, "", "start", line);
            }
            for (n, value) in row.iter().enumerate() {
                cell(draw, [words + n as f64 * each, y], [each, height], *value);
            }
            y += height;
        }
        let (right, bottom) = (words + count * each, y);
        draw.path(&format!("M{words:.1} {:.1}H{right:.1}V{bottom:.1}H{words:.1}z", top + 20.0), "frame");
        bottom + 10.0 - top
    }
}

fn cell(draw: &mut Draw, [x, y]: [f64; 2], [width, height]: [f64; 2], value: f64) {
    let ink = if value < 0.0 { Ink::Before } else { Ink::After };
    let full = if value.is_finite() { value.abs().min(1.0) } else { 0.0 };
    draw.cell([x, y], [width, height], &format!("f {}", ink.class()), full);
    if width > NUMBERED {
        let text =
            if value.abs() < 0.005 { "0".to_owned() } else { format!("{value:.2}").replace('-', "−") };
        let class = if full > FULL { "onheat" } else { "" };
        draw.text([x + 0.5 * width, y + 0.5 * height + 4.0], FONT - 1.0, class, "middle", &text);
    }
}
