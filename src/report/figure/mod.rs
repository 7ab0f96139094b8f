//! Figures: drawn once as SVG, shown in a page and saved as files for papers.
//!
//! Colours are classes; a page gives them for a light and a dark ground, a file carries those for paper.

pub mod axis;
pub mod bars;
pub mod budget;
pub mod chart;
mod draw;
pub mod heat;
pub mod map;
pub mod matrix;
pub mod path;
mod summary;
pub mod view;

pub use axis::Axis;
pub use bars::{Bar, Bars, Row};
pub use budget::{Budget, Part};
pub use chart::{Chart, Mark};
pub use heat::Heat;
pub use map::Map;
pub use matrix::Matrix;
pub use path::SignalPath;
pub use summary::svg;
pub use view::View;

use super::wrap::fill;
use draw::Draw;

/// Style of figures: every colour is a variable.
pub const STYLE: &str = include_str!("../../../assets/report/figure.css");

/// What something in a figure stands for; one colour each, from Okabe and Ito's palette.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Recorded on the machine.
    Measured,
    /// The twin as it is.
    Before,
    /// The twin with its causes.
    After,
    /// What was commanded.
    Reference,
    /// Noise.
    Noise,
    /// A fitted law, or a cause.
    Law,
    /// A second cause.
    Second,
    /// A third cause.
    Third,
    /// Calibration inside tolerance.
    Calibration,
    /// What stays open.
    Unexplained,
}

impl Ink {
    /// The class of the style sheet.
    pub fn class(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::Before => "before",
            Self::After => "after",
            Self::Reference => "reference",
            Self::Noise => "noise",
            Self::Law => "law",
            Self::Second => "second",
            Self::Third => "third",
            Self::Calibration => "calibration",
            Self::Unexplained => "unexplained",
        }
    }
}

/// How wide a figure is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Width {
    /// For a screen or a sheet of paper.
    Wide,
    /// For a telephone.
    Narrow,
}

impl Width {
    /// In px.
    pub fn px(self) -> f64 {
        match self {
            Self::Wide => 860.0,
            Self::Narrow => 350.0,
        }
    }

    /// The class of the style sheet.
    pub fn class(self) -> &'static str {
        match self {
            Self::Wide => "wide",
            Self::Narrow => "narrow",
        }
    }

    fn is_narrow(self) -> bool {
        self == Self::Narrow
    }
}

/// A part of a figure; parts stand below each other.
#[derive(Debug, Clone)]
pub enum Panel {
    /// Curves over an axis.
    Chart(Chart),
    /// Lying bars.
    Bars(Bars),
    /// One bar divided into parts.
    Budget(Budget),
    /// The signal path.
    Path(SignalPath),
    /// A strip of cells.
    Heat(Heat),
    /// Cells over two numbers.
    Map(Map),
    /// Correlations.
    Matrix(Matrix),
    /// The machine.
    View(View),
}

/// A figure.
#[derive(Debug, Clone)]
pub struct Figure {
    /// File name without ending, and the anchor in a page.
    pub name: String,
    /// What it shows, in a sentence; read out where it is not seen.
    pub caption: String,
    /// What the inks stand for.
    pub legend: Vec<(Ink, String)>,
    /// Its parts.
    pub panels: Vec<Panel>,
}

const LEGEND_ROW: f64 = 20.0;
const FONT: f64 = 12.0;

impl Figure {
    /// A figure of these parts.
    pub fn new(name: impl Into<String>, caption: impl Into<String>, panels: Vec<Panel>) -> Self {
        Self { name: name.into(), caption: caption.into(), legend: Vec::new(), panels }
    }

    /// With words for its inks.
    #[must_use]
    pub fn legend<const N: usize>(mut self, legend: [(Ink, &str); N]) -> Self {
        self.legend = legend.into_iter().map(|(ink, word)| (ink, word.to_owned())).collect();
        self
    }

    /// The figure as an element of a page, without colours of its own.
    pub fn element(&self, width: Width) -> String {
        let (draw, height) = self.drawn(width);
        format!(
            "<svg class=\"fig {}\" viewBox=\"0 0 {} {height:.0}\" role=\"img\" aria-label=\"{}\">{}</svg>\n",
            width.class(),
            width.px(),
            escape(&self.caption),
            draw.text_of()
        )
    }

    /// The figure as a file: with its colours, on white.
    pub fn file(&self) -> String {
        let (draw, height) = self.drawn(Width::Wide);
        let width = Width::Wide.px();
        format!(
            "<svg class=\"fig\" xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {width} {height:.0}\" role=\"img\">\n<title>{}</title>\n<style>{}</style>\n\
             <rect width=\"{width}\" height=\"{height:.0}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            escape(&self.caption),
            STYLE,
            draw.text_of()
        )
    }

    fn drawn(&self, width: Width) -> (Draw, f64) {
        let mut draw = Draw::default();
        let mut top = self.draw_legend(&mut draw, width);
        for panel in &self.panels {
            top += match panel {
                Panel::Chart(chart) => chart.draw(&mut draw, width, top),
                Panel::Bars(bars) => bars.draw(&mut draw, width, top),
                Panel::Budget(budget) => budget.draw(&mut draw, width, top),
                Panel::Path(path) => path.draw(&mut draw, width, top),
                Panel::Heat(heat) => heat.draw(&mut draw, width, top),
                Panel::Map(map) => map.draw(&mut draw, width, top),
                Panel::Matrix(matrix) => matrix.draw(&mut draw, width, top),
                Panel::View(view) => view.draw(&mut draw, width, top),
            };
        }
        (draw, top)
    }

    /// Words with a stroke of their colour, as many in a row as fit; returns the height.
    fn draw_legend(&self, draw: &mut Draw, width: Width) -> f64 {
        if self.legend.is_empty() {
            return 0.0;
        }
        let (mut x, mut y) = (8.0, 14.0);
        for (ink, words) in &self.legend {
            let takes = 30.0 + text_width(words, FONT) + 14.0;
            if x + takes > width.px() && x > 8.0 {
                (x, y) = (8.0, y + LEGEND_ROW);
            }
            draw.path(&format!("M{x:.0} {:.1}h22", y - 4.0), &format!("l key {}", ink.class()));
            for (k, line) in lines(words, FONT, width.px() - x - 30.0).iter().enumerate() {
                y += if k > 0 { LEGEND_ROW - 4.0 } else { 0.0 };
                draw.text([x + 28.0, y], FONT, "", "start", line);
            }
            x += takes;
        }
        y + 10.0
    }
}

/// Text that may stand in HTML, XML and their attributes.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control letters are no part of any page.
            c if (c as u32) < 0x20 && c != '\n' && c != '\t' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Room that words take at most, in px: fonts differ.
pub(super) fn text_width(words: &str, size: f64) -> f64 {
    0.57 * size * words.chars().count() as f64
}

/// Words broken into lines that fit.
pub(super) fn lines(words: &str, size: f64, room: f64) -> Vec<String> {
    fill(words.split_whitespace(), |line, word| {
        text_width(line, size) + text_width(word, size) + 0.6 * size <= room
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_markup_in_words_is_text() {
        assert_eq!(escape("<b a=\"x\">'&\u{7}"), "&lt;b a=&quot;x&quot;&gt;&#39;&amp; ");
    }

    #[test]
    fn exact_lines_fit_their_room() {
        for room in [60.0, 120.0, 400.0] {
            for line in lines("Coulomb friction on the guide is the cause of the gap", 12.0, room) {
                assert!(text_width(&line, 12.0) <= room || !line.contains(' '), "{line}");
            }
        }
    }
}
