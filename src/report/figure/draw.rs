//! The strokes that every figure is made of.

use super::escape;
use std::fmt::Write as _;

/// An SVG under way.
#[derive(Debug, Default)]
pub(super) struct Draw {
    out: String,
}

impl Draw {
    /// Words at a place; `anchor` is start, middle or end.
    pub(super) fn text(&mut self, [x, y]: [f64; 2], size: f64, class: &str, anchor: &str, words: &str) {
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let _ = writeln!(
            self.out,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\"{class} text-anchor=\"{anchor}\">{}</text>",
            escape(words)
        );
    }

    /// Words that run upwards.
    pub(super) fn upright(&mut self, [x, y]: [f64; 2], size: f64, class: &str, words: &str) {
        let _ = writeln!(
            self.out,
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"{size}\" class=\"{class}\" \
             text-anchor=\"middle\">{}</text>",
            escape(words)
        );
    }

    /// A path.
    pub(super) fn path(&mut self, data: &str, class: &str) {
        let _ = writeln!(self.out, "<path d=\"{data}\" class=\"{class}\"/>");
    }

    /// A rectangle; nothing where it has no size.
    pub(super) fn rect(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], class: &str) {
        if width > 0.0 && height > 0.0 {
            let _ = writeln!(
                self.out,
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"{class}\"/>"
            );
        }
    }

    /// A rectangle filled so far, 0 to 1.
    pub(super) fn cell(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2], class: &str, full: f64) {
        let _ = writeln!(
            self.out,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"{class}\" \
             fill-opacity=\"{full:.3}\"/>"
        );
    }

    /// An area filled so far, 0 to 1; nothing where it is empty.
    pub(super) fn fill(&mut self, data: &str, class: &str, full: f64) {
        if !data.is_empty() {
            let _ = writeln!(self.out, "<path d=\"{data}\" class=\"{class}\" fill-opacity=\"{full:.3}\"/>");
        }
    }

    /// Facets of one shade, 0 (dark) to 1 (light).
    pub(super) fn shade(&mut self, data: &str, class: &str, light: f64) {
        let _ = writeln!(self.out, "<path d=\"{data}\" class=\"{class}\" style=\"--i:{light:.2}\"/>");
    }

    /// All of it.
    pub(super) fn text_of(&self) -> &str {
        &self.out
    }
}
