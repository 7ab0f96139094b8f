//! The signal path with each site's share of the gap.

use super::Width;
use super::draw::Draw;

/// The sites in hardware order with their shares.
#[derive(Debug, Clone)]
pub struct SignalPath {
    /// Name, share (0 to 1) and its text.
    pub sites: Vec<(String, f64, String)>,
}

const FONT: f64 = 13.0;
const BOX: f64 = 54.0;

impl SignalPath {
    pub(super) fn draw(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        if width.is_narrow() { self.downwards(draw, width, top) } else { self.across(draw, width, top) }
    }

    fn site(&self, draw: &mut Draw, k: usize, [x, y]: [f64; 2], [w, h]: [f64; 2]) {
        let (name, share, text) = &self.sites[k];
        let full = share.clamp(0.0, 1.0);
        draw.rect([x, y], [w, h], "f ground");
        draw.cell([x, y], [w, h], "f heat", 0.92 * full);
        draw.path(&format!("M{x:.1} {y:.1}h{w:.1}v{h:.1}h-{w:.1}z"), "frame");
        let class = if full > 0.72 { "onheat strong" } else { "strong" };
        if h > 40.0 {
            draw.text([x + 0.5 * w, y + 22.0], FONT, class, "middle", name);
            draw.text([x + 0.5 * w, y + 42.0], FONT, class, "middle", text);
        } else {
            draw.text([x + 10.0, y + 0.5 * h + 4.5], FONT, class, "start", name);
            draw.text([x + w - 10.0, y + 0.5 * h + 4.5], FONT, class, "end", text);
        }
    }

    fn across(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let gap = 24.0;
        let (left, right, y) = (8.0, width.px() - 8.0, top + 24.0);
        let count = self.sites.len().max(1) as f64;
        let each = (right - left - gap * (count + 1.0)) / count;
        let middle = y + 0.5 * BOX;
        draw.text([left, top + 13.0], 11.5, "pale", "start", "command");
        for k in 0..self.sites.len() {
            let x = left + gap + k as f64 * (each + gap);
            arrow(draw, [x - gap + 3.0, middle], [gap - 6.0, 0.0]);
            self.site(draw, k, [x, y], [each, BOX]);
        }
        // The loop is closed by what the sensor reads.
        let (end, back) = (right - gap, y + BOX + 22.0);
        let first = left + gap + 0.5 * each;
        draw.path(
            &format!("M{end:.1} {middle:.1}H{:.1}V{back:.1}H{first:.1}V{:.1}", right - 6.0, y + BOX + 8.0),
            "wire",
        );
        draw.path(&format!("M{:.1} {:.1}l4 -8l4 8", first - 4.0, y + BOX + 10.0), "wire");
        draw.text(
            [0.5 * (left + right), back - 6.0],
            11.5,
            "pale",
            "middle",
            "what was measured, back to the controller",
        );
        back + 12.0 - top
    }

    fn downwards(&self, draw: &mut Draw, width: Width, top: f64) -> f64 {
        let (height, gap) = (34.0, 18.0);
        let (x, w) = (24.0, width.px() - 64.0);
        let mut y = top + 8.0;
        let first = y + 0.5 * height;
        for k in 0..self.sites.len() {
            if k > 0 {
                arrow(draw, [x + 0.5 * w, y - gap + 2.0], [0.0, gap - 4.0]);
            }
            self.site(draw, k, [x, y], [w, height]);
            y += height + gap;
        }
        let last = y - gap - 0.5 * height;
        let right = x + w + 22.0;
        draw.path(&format!("M{:.1} {last:.1}H{right:.1}V{first:.1}H{:.1}", x + w, x + w + 3.0), "wire");
        draw.path(&format!("M{:.1} {:.1}l-8 4l8 4", x + w + 10.0, first - 4.0), "wire");
        y - gap + 8.0 - top
    }
}

fn arrow(draw: &mut Draw, [x, y]: [f64; 2], [dx, dy]: [f64; 2]) {
    let (ex, ey) = (x + dx, y + dy);
    let head = if dx > 0.0 {
        format!("M{:.1} {:.1}L{ex:.1} {ey:.1}L{:.1} {:.1}", ex - 6.0, ey - 4.0, ex - 6.0, ey + 4.0)
    } else {
        format!("M{:.1} {:.1}L{ex:.1} {ey:.1}L{:.1} {:.1}", ex - 4.0, ey - 6.0, ex + 4.0, ey - 6.0)
    };
    draw.path(&format!("M{x:.1} {y:.1}L{ex:.1} {ey:.1}{head}"), "wire");
}
