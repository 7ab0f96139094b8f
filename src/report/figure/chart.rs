//! Curves over an axis.

use super::axis::Axis;
use super::draw::Draw;
use super::{Ink, Width, text_width};
use std::fmt::Write as _;

/// Something drawn over an axis, in the axes' units.
#[derive(Debug, Clone)]
pub enum Mark {
    /// A curve.
    Line {
        /// Its colour.
        ink: Ink,
        /// Its points, from left to right.
        points: Vec<[f64; 2]>,
        /// Whether it is dashed.
        is_dashed: bool,
    },
    /// Samples.
    Dots {
        /// Their colour.
        ink: Ink,
        /// Where they lie.
        points: Vec<[f64; 2]>,
    },
    /// A band between two heights.
    Band {
        /// Its colour.
        ink: Ink,
        /// From, to.
        range: [f64; 2],
    },
    /// A band between two curves: across, from, to.
    Ribbon {
        /// Its colour.
        ink: Ink,
        /// Its points, from left to right.
        points: Vec<[f64; 3]>,
    },
    /// A moment that has a name.
    Event {
        /// Where.
        x: f64,
        /// Its name; may be empty.
        word: String,
    },
}

impl Mark {
    /// A curve of so many points at most, extremes kept.
    pub fn line(ink: Ink, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self::Line { ink, points: points.into_iter().collect(), is_dashed: false }
    }

    /// A dashed curve.
    pub fn dashed(ink: Ink, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self::Line { ink, points: points.into_iter().collect(), is_dashed: true }
    }
}

/// Curves over an axis.
#[derive(Debug, Clone)]
pub struct Chart {
    /// What stands above it; may be empty.
    pub title: String,
    /// Across.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// What is drawn, the later on top.
    pub marks: Vec<Mark>,
    /// Height of the drawn area in px.
    pub height: f64,
    /// Whether the axis across is labelled; not where the same axis follows below.
    pub has_x_labels: bool,
}

const LEFT: f64 = 64.0;
const RIGHT: f64 = 12.0;
const FONT: f64 = 11.5;

/// Points of a curve for a width of so many columns at most.
const COLUMNS: usize = 330;
const NARROW_COLUMNS: usize = 140;
/// Dots that are drawn at most.
const DOTS: usize = 900;

/// Fewer dots are drawn larger.
const FEW: usize = 250;

/// Where the drawn area lies.
struct Frame {
    top: f64,
    height: f64,
    right: f64,
}

impl Chart {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let head = if self.title.is_empty() { 8.0 } else { 26.0 };
        if !self.title.is_empty() {
            draw.text([8.0, top + 17.0], FONT + 0.5, "strong", "start", &self.title);
        }
        let frame = Frame { top: top + head, height: self.height, right: width.px() - RIGHT };
        let below = if self.has_x_labels { 36.0 } else { 8.0 };
        self.grid(draw, &frame, width);
        for mark in &self.marks {
            self.mark(draw, &frame, mark, width);
        }
        draw.path(
            &format!("M{LEFT} {:.1}V{:.1}H{:.1}", frame.top, frame.top + frame.height, frame.right),
            "frame",
        );
        self.events(draw, &frame);
        head + self.height + below
    }

    fn across(&self, frame: &Frame, x: f64) -> f64 {
        LEFT + self.x.place(x) * (frame.right - LEFT)
    }

    fn up(&self, frame: &Frame, y: f64) -> f64 {
        frame.top + frame.height * (1.0 - self.y.place(y)).clamp(-0.02, 1.02)
    }

    fn grid(&self, draw: &mut Draw, frame: &Frame, width: Width) {
        let mut lines = String::new();
        for (value, text) in self.y.ticks((self.height / 24.0).clamp(3.0, 6.0) as usize) {
            let y = self.up(frame, value);
            let _ = write!(lines, "M{LEFT} {y:.1}H{:.1}", frame.right);
            draw.text([LEFT - 6.0, y + 4.0], FONT, "pale", "end", &text);
        }
        for (value, text) in self.x.ticks(if width.is_narrow() { 4 } else { 9 }) {
            let x = self.across(frame, value);
            let _ = write!(lines, "M{x:.1} {:.1}V{:.1}", frame.top, frame.top + frame.height);
            if self.has_x_labels {
                draw.text([x, frame.top + frame.height + 15.0], FONT, "pale", "middle", &text);
            }
        }
        draw.path(&lines, "grid");
        if self.has_x_labels {
            let middle = 0.5 * (LEFT + frame.right);
            draw.text([middle, frame.top + frame.height + 30.0], FONT, "pale axis", "middle", &self.x.label);
        }
        // Upright words that are too long for the panel run into the next one.
        let middle = frame.top + 0.5 * frame.height;
        draw.upright([14.0, middle], FONT, "pale axis", &self.y.label);
    }

    fn mark(&self, draw: &mut Draw, frame: &Frame, mark: &Mark, width: Width) {
        let columns = if width.is_narrow() { NARROW_COLUMNS } else { COLUMNS };
        match mark {
            Mark::Line { ink, points, is_dashed } => {
                let class = format!("l {}{}", ink.class(), if *is_dashed { " dashed" } else { "" });
                draw.path(&self.curve(frame, &thinned(points, columns)), &class);
            }
            Mark::Dots { ink, points } => {
                let every = points.len().div_ceil(DOTS).max(1);
                let mut data = String::new();
                let inside = points.iter().step_by(every).filter(|p| {
                    p.iter().all(|x| x.is_finite()) && (-0.005..=1.005).contains(&self.x.place(p[0]))
                });
                for [x, y] in inside {
                    let (x, y) = (self.across(frame, *x), self.up(frame, *y));
                    let _ = write!(data, "M{x:.1} {y:.1}h.1");
                }
                let size = if points.len() < FEW { " few" } else { "" };
                draw.path(&data, &format!("dots {}{size}", ink.class()));
            }
            Mark::Band { ink, range: [from, to] } => {
                let (low, high) = (self.up(frame, *from), self.up(frame, *to));
                draw.rect([LEFT, high], [frame.right - LEFT, low - high], &format!("band {}", ink.class()));
            }
            Mark::Ribbon { ink, points } => {
                draw.path(&self.ribbon(frame, points), &format!("band {}", ink.class()));
            }
            Mark::Event { .. } => {}
        }
    }

    /// There along the upper ends, back along the lower ones.
    fn ribbon(&self, frame: &Frame, points: &[[f64; 3]]) -> String {
        let inside =
            |p: &&[f64; 3]| p.iter().all(|x| x.is_finite()) && (-0.002..=1.002).contains(&self.x.place(p[0]));
        let upper = points.iter().filter(inside).map(|[x, _, to]| [*x, *to]);
        let lower = points.iter().rev().filter(inside).map(|[x, from, _]| [*x, *from]);
        let mut data = String::new();
        for (k, [x, y]) in upper.chain(lower).enumerate() {
            let letter = if k == 0 { "M" } else { "L" };
            let _ = write!(data, "{letter}{:.1} {:.1}", self.across(frame, x), self.up(frame, y));
        }
        if !data.is_empty() {
            data.push('Z');
        }
        data
    }

    fn curve(&self, frame: &Frame, points: &[[f64; 2]]) -> String {
        let mut data = String::new();
        let mut is_down = false;
        for [x, y] in points {
            let is_inside = (-0.002..=1.002).contains(&self.x.place(*x));
            if !(is_inside && y.is_finite()) || (self.y.is_log && *y <= 0.0) {
                is_down = false;
                continue;
            }
            let letter = if is_down { "L" } else { "M" };
            let _ = write!(data, "{letter}{:.1} {:.1}", self.across(frame, *x), self.up(frame, *y));
            is_down = true;
        }
        data
    }

    /// Moments and their names; names that have no room are left out.
    fn events(&self, draw: &mut Draw, frame: &Frame) {
        let mut free = LEFT;
        for mark in &self.marks {
            let Mark::Event { x, word } = mark else { continue };
            if !(self.x.range[0]..=self.x.range[1]).contains(x) {
                continue;
            }
            let x = self.across(frame, *x);
            draw.path(&format!("M{x:.1} {:.1}v{:.1}", frame.top, frame.height), "event");
            let takes = text_width(word, FONT - 1.0);
            if !word.is_empty() && x >= free && x + takes < frame.right {
                draw.text([x + 3.0, frame.top + 11.0], FONT - 1.0, "eventword halo", "start", word);
                free = x + takes + 8.0;
            }
        }
    }
}

/// Of every column's points the first, lowest, highest and last.
pub fn thinned(points: &[[f64; 2]], columns: usize) -> Vec<[f64; 2]> {
    if points.len() <= 2 * columns {
        return points.to_vec();
    }
    let length = points.len().div_ceil(columns);
    let mut kept = Vec::with_capacity(2 * columns);
    for chunk in points.chunks(length) {
        let by = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
        let (Some(low), Some(high)) = (chunk.iter().min_by(by), chunk.iter().max_by(by)) else { continue };
        let (first, second) = if low[0] <= high[0] { (low, high) } else { (high, low) };
        kept.push(*first);
        if first != second {
            kept.push(*second);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_thinning_keeps_extremes() {
        let points: Vec<[f64; 2]> = (0..10_000)
            .map(|k| [f64::from(k), if k == 7777 { 9.0 } else { (0.01 * f64::from(k)).sin() }])
            .collect();
        let kept = thinned(&points, 100);
        assert!(kept.len() <= 200 && kept.contains(&[7777.0, 9.0]));
        assert!(kept.windows(2).all(|w| w[0][0] < w[1][0]));
    }
}
