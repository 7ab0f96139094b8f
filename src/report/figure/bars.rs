//! Lying bars with their numbers.

use super::axis::Axis;
use super::draw::Draw;
use super::{Ink, Width, lines, text_width};

/// One bar.
#[derive(Debug, Clone)]
pub struct Bar {
    /// Its colour.
    pub ink: Ink,
    /// Its length on the axis.
    pub value: f64,
    /// What stands at its end.
    pub text: String,
}

/// Bars that belong to one word.
#[derive(Debug, Clone)]
pub struct Row {
    /// The word.
    pub label: String,
    /// The bars, below each other.
    pub bars: Vec<Bar>,
}

/// Lying bars with a common axis.
#[derive(Debug, Clone)]
pub struct Bars {
    /// What stands above; may be empty.
    pub title: String,
    /// The axis; its label stands below.
    pub axis: Axis,
    /// The rows, downwards.
    pub rows: Vec<Row>,
}

const FONT: f64 = 12.0;
const BAR: f64 = 14.0;
const GAP: f64 = 10.0;

impl Bars {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let head = if self.title.is_empty() { 6.0 } else { 28.0 };
        if !self.title.is_empty() {
            for (k, line) in lines(&self.title, FONT, width.px() - 16.0).iter().take(1).enumerate() {
                draw.text([8.0, top + 17.0 + 15.0 * k as f64], FONT, "strong", "start", line);
            }
        }
        // On a telephone the word stands above its bars.
        let above = if width.is_narrow() { 17.0 } else { 0.0 };
        let left = if width.is_narrow() { 8.0 } else { 16.0 + self.label_width() };
        let room = self.rows.iter().flat_map(|row| &row.bars).map(|bar| text_width(&bar.text, FONT));
        let right = width.px() - 12.0 - room.fold(30.0, f64::max);
        let right = right.max(left + 60.0);
        let start = top + head;
        let mut y = start;
        let across = |value: f64| left + self.axis.place(value).clamp(0.0, 1.0) * (right - left);
        let mut grid = String::new();
        let height: f64 = self.rows.iter().map(|row| row_height(row, above)).sum();
        for (value, text) in self.axis.ticks(if width.is_narrow() { 3 } else { 6 }) {
            let x = across(value);
            grid += &format!("M{x:.1} {start:.1}v{height:.1}");
            draw.text([x, start + height + 14.0], FONT - 1.0, "pale", "middle", &text);
        }
        draw.path(&grid, "grid");
        for row in &self.rows {
            if width.is_narrow() {
                draw.text([left, y + 12.0], FONT, "", "start", &row.label);
            } else {
                let middle = y + 0.5 * (BAR * row.bars.len() as f64) + 4.0;
                draw.text([left - 8.0, middle], FONT, "", "end", &row.label);
            }
            for (k, bar) in row.bars.iter().enumerate() {
                let y = y + above + BAR * k as f64;
                let end = if bar.value.is_finite() { across(bar.value) } else { left };
                let end = end.max(left + 1.5);
                draw.rect([left, y + 1.0], [end - left, BAR - 3.0], &format!("f {}", bar.ink.class()));
                draw.text([end + 5.0, y + BAR - 3.5], FONT - 0.5, "", "start", &bar.text);
            }
            y += row_height(row, above);
        }
        let label = lines(&self.axis.label, FONT - 1.0, width.px() - 16.0);
        let middle = if label.len() > 1 { 0.5 * width.px() } else { 0.5 * (left + right) };
        for (k, line) in label.iter().enumerate() {
            draw.text(
                [middle, start + height + 29.0 + 14.0 * k as f64],
                FONT - 1.0,
                "pale axis",
                "middle",
                line,
            );
        }
        head + height + 22.0 + 14.0 * label.len() as f64
    }

    fn label_width(&self) -> f64 {
        self.rows.iter().map(|row| text_width(&row.label, FONT)).fold(40.0, f64::max)
    }
}

fn row_height(row: &Row, above: f64) -> f64 {
    above + BAR * row.bars.len() as f64 + GAP
}
