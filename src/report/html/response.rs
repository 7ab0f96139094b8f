//! A frequency response as a page: Bode in dB and degrees, coherence, margins, modes.

use super::page::{Builder, Page, Part};
use super::replayed::version;
use super::spectrum::unwrapped;
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
        part.figure(figure(response));
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

fn decibels(value: f64) -> f64 {
    20.0 * value.max(f64::MIN_POSITIVE).log10()
}

/// Magnitude in dB, phase in degrees, coherence, each with the 95 % band.
fn figure(response: &Response) -> Figure {
    let Response { title, unit, measured, computed, marked, computed_word, .. } = response;
    let sure: Vec<&Point> = measured.iter().filter(|p| p.coherence >= COHERENT).collect();
    let frequencies = || sure.iter().map(|p| p.frequency_hz).chain(computed.iter().map(|(f, _)| *f));
    let across = |label: &str| Axis::decades(label, frequencies());
    let magnitude = |z: Complex<f64>| decibels(z.norm());
    let band: Vec<[f64; 3]> = sure
        .iter()
        .map(|p| p.magnitude_ci95())
        .zip(&sure)
        .map(|([low, high], p)| {
            [p.frequency_hz, decibels(low.max(1e-3 * p.response().norm())), decibels(high)]
        })
        .collect();
    let own = phases(computed.iter().copied());
    let measured_phase = beside(phases(sure.iter().map(|p| (p.frequency_hz, p.response()))), &own);
    let phase_band: Vec<[f64; 3]> = measured_phase
        .iter()
        .zip(&sure)
        .map(|([f, angle], p)| [*f, angle - p.phase_half_width_deg(), angle + p.phase_half_width_deg()])
        .collect();
    let dots = |points: Vec<[f64; 2]>| Mark::Dots { ink: Ink::Measured, points };
    let ribbon = |points: Vec<[f64; 3]>| Mark::Ribbon { ink: Ink::Measured, points };
    let events = |named: bool| {
        marked.iter().map(move |(x, word)| Mark::Event {
            x: *x,
            word: if named { word.clone() } else { String::new() },
        })
    };
    let heights =
        || sure.iter().map(|p| magnitude(p.response())).chain(computed.iter().map(|(_, z)| magnitude(*z)));
    let angles = measured_phase.iter().chain(&own).map(|p| p[1]).collect::<Vec<_>>();
    let in_dots = sure.iter().map(|p| [p.frequency_hz, magnitude(p.response())]).collect();
    let mut upper = vec![
        ribbon(band),
        dots(in_dots),
        Mark::line(Ink::After, computed.iter().map(|(f, z)| [*f, magnitude(*z)])),
    ];
    upper.extend(events(true));
    let mut middle = vec![ribbon(phase_band), dots(measured_phase), Mark::line(Ink::After, own)];
    middle.extend(events(false));
    let is_last = sure.is_empty();
    let unit = if unit.is_empty() { "dB".to_owned() } else { format!("dB ({unit})") };
    let chart = |title: &str, x: Axis, y: Axis, marks: Vec<Mark>, height: f64| {
        let has_x_labels = !x.label.is_empty();
        Panel::Chart(Chart { title: title.to_owned(), x, y, marks, height, has_x_labels })
    };
    let below = if is_last { "frequency in Hz" } else { "" };
    let mut panels = vec![
        chart("magnitude", across(""), Axis::holding(unit, heights()), upper, 190.0),
        chart("phase", across(below), Axis::holding("°", angles), middle, 150.0),
    ];
    if !is_last {
        let points = measured.iter().map(|p| [p.frequency_hz, p.coherence]);
        let coherence = vec![Mark::line(Ink::Measured, points)];
        panels.push(chart(
            "coherence",
            across("frequency in Hz"),
            Axis::linear("γ²", [0.0, 1.05]),
            coherence,
            70.0,
        ));
    }
    let caption = match is_last {
        true => format!("Frequency response, {title}: {computed_word}."),
        false => format!(
            "Frequency response, {title}, with its 95 % band where the coherence is above {COHERENT}."
        ),
    };
    let mut figure = Figure::new(response.name.clone(), caption, panels);
    if !sure.is_empty() {
        figure.legend.push((Ink::Measured, "measured, 95 % band".to_owned()));
    }
    if !computed.is_empty() {
        figure.legend.push((Ink::After, computed_word.clone()));
    }
    figure
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
