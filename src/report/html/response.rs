//! A frequency response as a page: Bode in dB and degrees, coherence, margins, modes.

use super::page::{Builder, Page, Part};
use super::polar::{decibel_unit, decibels, magnitude_band, unwrapped};
use super::replayed::version;
use super::{data, head, provenance};
use crate::identify::frequency_response::Point;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};
use crate::units::Motion;
use nalgebra::Complex;

/// A response measured or computed, and what was read off it.
#[derive(Debug, Clone)]
pub struct Responded {
    /// Machine or recording.
    pub subject: String,
    /// What was done, in a sentence.
    pub sentence: String,
    /// Where the data come from.
    pub note: Option<String>,
    /// Kind of axis.
    pub motion: Motion,
    /// Hash of the data, where they are a recording.
    pub sha256: Option<String>,
    /// The responses, each a figure.
    pub responses: Vec<Response>,
    /// Heads and rows of the margins.
    pub margins: (Vec<String>, Vec<Vec<String>>),
    /// Heads and rows of the modes.
    pub modes: (Vec<String>, Vec<Vec<String>>),
    /// A remark on the modes.
    pub modes_remark: String,
}

/// One response.
#[derive(Debug, Clone)]
pub struct Response {
    /// File name of the figure.
    pub name: String,
    /// What it is: "open loop".
    pub title: String,
    /// Unit of output over input; empty for a ratio.
    pub unit: String,
    /// Measured, by frequency; may be empty.
    pub measured: Vec<Point>,
    /// The linear loop's or the fitted one, by frequency; may be empty.
    pub computed: Vec<(f64, Complex<f64>)>,
    /// What the computed curve is.
    pub computed_word: String,
    /// Frequencies with names: crossovers, modes.
    pub marked: Vec<(f64, String)>,
}

/// Below this coherence a measured point is not drawn.
const COHERENT: f64 = 0.5;

/// A frequency response as a page.
pub fn responded(found: &Responded, command: &str) -> Page {
    let Responded { subject, sentence, note, motion, sha256, .. } = found;
    let head = head::plain_head(subject, "frequency response", sentence, note.as_deref());
    let mut page = Builder::new(&format!("{subject}: frequency response"), head);
    let table = |(heads, rows): &(Vec<String>, Vec<Vec<String>>)| {
        let mut part = Part::default();
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        part.table(&heads, rows);
        part
    };
    page.section("margins", "Margins", table(&found.margins));
    for response in &found.responses {
        let mut part = Part::default();
        part.figure(bode(response));
        page.section(&response.name, &capitalised(&response.title), part);
    }
    let mut modes = table(&found.modes);
    if !found.modes_remark.is_empty() {
        modes.remark(&found.modes_remark);
    }
    page.section("modes", "Modes", modes);
    let rows = [
        ("subject", subject.clone()),
        ("SHA-256 of the recording", sha256.clone().unwrap_or_default()),
        version(),
    ];
    page.section("provenance", "Where this comes from", provenance::list(&rows, command));
    page.finish(&data::of(*motion, &[], None))
}

fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Magnitude in dB, phase in degrees, coherence, each with the 95 % band.
pub fn bode(response: &Response) -> Figure {
    let Response { title, measured, computed, computed_word, .. } = response;
    let sure: Vec<&Point> = measured.iter().filter(|p| p.coherence >= COHERENT).collect();
    let across = |label: &str| {
        let frequencies = sure.iter().map(|p| p.frequency_hz).chain(computed.iter().map(|(f, _)| *f));
        Axis::decades(label, frequencies)
    };
    let is_last = sure.is_empty();
    let mut panels = vec![
        magnitude(response, &sure, across("")),
        phase(response, &sure, across(if is_last { "frequency in Hz" } else { "" })),
    ];
    if !is_last {
        let points = measured.iter().map(|p| [p.frequency_hz, p.coherence]);
        let marks = vec![Mark::line(Ink::Measured, points)];
        let y = Axis::linear("γ²", [0.0, 1.05]);
        panels.push(chart("coherence", across("frequency in Hz"), y, marks, 70.0));
    }
    let caption = match is_last {
        true => format!("Frequency response, {title}: {computed_word}."),
        false => format!(
            "Frequency response, {title}, with its 95 % band where the coherence is above {COHERENT}."
        ),
    };
    let mut figure = Figure::new(response.name.clone(), caption, panels);
    if !is_last {
        figure.legend.push((Ink::Measured, "measured, 95 % band".to_owned()));
    }
    if !computed.is_empty() {
        figure.legend.push((Ink::After, computed_word.clone()));
    }
    figure
}

fn chart(title: &str, x: Axis, y: Axis, marks: Vec<Mark>, height: f64) -> Panel {
    let has_x_labels = !x.label.is_empty();
    Panel::Chart(Chart { title: title.to_owned(), x, y, marks, height, has_x_labels })
}

/// Magnitude in dB with the names of what is marked.
fn magnitude(response: &Response, sure: &[&Point], x: Axis) -> Panel {
    let height = |z: Complex<f64>| decibels(z.norm());
    let dots: Vec<[f64; 2]> = sure.iter().map(|p| [p.frequency_hz, height(p.response())]).collect();
    let curve: Vec<[f64; 2]> = response.computed.iter().map(|(f, z)| [*f, height(*z)]).collect();
    let band = |p: &&Point| magnitude_band(p);
    let unit = decibel_unit(&response.unit);
    let y = Axis::holding(unit, dots.iter().chain(&curve).map(|p| p[1]));
    let mut marks = vec![
        Mark::Ribbon { ink: Ink::Measured, points: sure.iter().map(band).collect() },
        Mark::Dots { ink: Ink::Measured, points: dots },
        Mark::line(Ink::After, curve),
    ];
    marks.extend(response.marked.iter().map(|(x, word)| Mark::Event { x: *x, word: word.clone() }));
    chart("magnitude", x, y, marks, 190.0)
}

/// Phase in degrees, without jumps.
fn phase(response: &Response, sure: &[&Point], x: Axis) -> Panel {
    let curve = phases(response.computed.iter().copied());
    let dots = beside(phases(sure.iter().map(|p| (p.frequency_hz, p.response()))), &curve);
    let band = |([f, angle], p): (&[f64; 2], &&Point)| {
        let half = p.phase_half_width_deg();
        [*f, angle - half, angle + half]
    };
    let y = Axis::holding("°", dots.iter().chain(&curve).map(|p| p[1]));
    let mut marks = vec![
        Mark::Ribbon { ink: Ink::Measured, points: dots.iter().zip(sure).map(band).collect() },
        Mark::Dots { ink: Ink::Measured, points: dots },
        Mark::line(Ink::After, curve),
    ];
    marks.extend(response.marked.iter().map(|(x, _)| Mark::Event { x: *x, word: String::new() }));
    chart("phase", x, y, marks, 150.0)
}

fn phases(points: impl Iterator<Item = (f64, Complex<f64>)>) -> Vec<[f64; 2]> {
    unwrapped(points.map(|(f, z)| [f, z.arg().to_degrees()]).collect())
}

/// Angles moved by whole turns to where the other curve is at their middle.
fn beside(mut points: Vec<[f64; 2]>, other: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let Some([f, angle]) = points.get(points.len() / 2).copied() else { return points };
    let nearest = other.iter().min_by(|a, b| (a[0] - f).abs().total_cmp(&(b[0] - f).abs()));
    let turns = nearest.map_or(0.0, |[_, known]| 360.0 * ((angle - known) / 360.0).round());
    points.iter_mut().for_each(|point| point[1] -= turns);
    points
}
