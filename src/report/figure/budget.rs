//! One bar divided into what the gap is made of.

use super::draw::Draw;
use super::{Ink, Width, lines, text_width};

/// A part of the bar.
#[derive(Debug, Clone)]
pub struct Part {
    /// Its colour.
    pub ink: Ink,
    /// What it is.
    pub label: String,
    /// Its length, 0 to 1.
    pub share: f64,
    /// Its number in words.
    pub text: String,
}

/// One bar and its parts.
#[derive(Debug, Clone)]
pub struct Budget {
    /// The parts, from left to right.
    pub parts: Vec<Part>,
}

const FONT: f64 = 12.5;
const HEIGHT: f64 = 44.0;

impl Budget {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let (left, right) = (8.0, width.px() - 8.0);
        let total: f64 = self.parts.iter().map(|part| part.share.max(0.0)).sum();
        let scale = (right - left) / total.max(f64::MIN_POSITIVE);
        let mut x = left;
        for part in &self.parts {
            let takes = part.share.max(0.0) * scale;
            draw.rect([x, top + 6.0], [takes, HEIGHT], &format!("f part {}", part.ink.class()));
            if takes > text_width(&part.text, FONT) + 12.0 {
                let place = [x + 0.5 * takes, top + 6.0 + 0.5 * HEIGHT + 4.5];
                draw.text(place, FONT + 0.5, "onfill", "middle", &part.text);
            }
            x += takes;
        }
        draw.path(&format!("M{left} {:.1}H{right}v{HEIGHT}H{left}z", top + 6.0), "frame");
        // The list below the bar: every part with its number, however thin its piece.
        let mut y = top + HEIGHT + 28.0;
        for part in &self.parts {
            draw.rect([left, y - 10.0], [12.0, 12.0], &format!("f part {}", part.ink.class()));
            let words = format!("{}  {}", part.label, part.text);
            for line in lines(&words, FONT, right - left - 24.0) {
                draw.text([left + 20.0, y], FONT, "", "start", &line);
                y += 17.0;
            }
            y += 3.0;
        }
        y - top
    }
}
