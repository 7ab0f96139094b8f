//! Identified transfer functions as a page.

use super::page::{Builder, Page, Part};
use super::polar::{decibel_unit, decibels, magnitude_band};
use super::replayed::version;
use super::sheet::part as section_part;
use super::{data, head, provenance};
use crate::identify::frequency_response::Point;
use crate::identify::transfer::TransferFunction;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel, escape};
use crate::report::sheet::Section;
use crate::units::Motion;
use nalgebra::Complex;

/// One identified model, its coefficients from the constant on.
#[derive(Debug, Clone)]
pub struct Model {
    /// What it is, and at which period.
    pub title: String,
    /// The function.
    pub transfer: TransferFunction,
    /// Rows of name, value and interval.
    pub rows: Vec<Vec<String>>,
    /// How well it fits, in words.
    pub fit: String,
    /// Frequency response of the data at the same period; empty where it could not be estimated.
    pub measured: Vec<Point>,
}

/// What was identified.
#[derive(Debug, Clone)]
pub struct Identified {
    /// Machine or recording.
    pub subject: String,
    /// What was done, in a sentence.
    pub sentence: String,
    /// Where the data come from.
    pub note: Option<String>,
    /// Unit of output over input.
    pub unit: String,
    /// Kind of axis.
    pub motion: Motion,
    /// Hash of the data, where they are a recording.
    pub sha256: Option<String>,
    /// The models.
    pub models: Vec<Model>,
    /// What else there is to say.
    pub further: Vec<Section>,
}

/// Points of a curve.
const POINTS: i32 = 300;
/// Decades that are drawn.
const DECADES: f64 = 3.5;
/// Below this coherence a measured point is not drawn.
const COHERENT: f64 = 0.5;

/// Identified transfer functions as a page.
pub fn identified(found: &Identified, command: &str) -> Page {
    let Identified { subject, sentence, note, motion, sha256, models, .. } = found;
    let head = head::plain_head(subject, "identification", sentence, note.as_deref());
    let mut page = Builder::new(&format!("{subject}: identification"), head);
    for (k, model) in models.iter().enumerate() {
        page.section(&format!("model{}", k + 1), &model.title, part(model, k, &found.unit));
    }
    for (k, section) in found.further.iter().enumerate() {
        page.section(&format!("further{}", k + 1), &section.title, section_part(section));
    }
    let rows = [
        ("subject", subject.clone()),
        ("SHA-256 of the recording", sha256.clone().unwrap_or_default()),
        version(),
    ];
    page.section("provenance", "Where this comes from", provenance::list(&rows, command));
    page.finish(&data::of(*motion, &[], None))
}

fn part(model: &Model, k: usize, unit: &str) -> Part {
    let mut part = Part::default();
    part.raw(&format!("<pre>{}</pre>\n", escape(&model.transfer.to_string())));
    part.paragraph(&model.fit);
    part.table(&["", ">value", ">95 % from", ">to"], &model.rows);
    part.figure(figure(model, k, unit));
    part
}

fn coherence(model: &Model, frequencies_hz: [f64; 2]) -> Panel {
    let points = model.measured.iter().map(|p| [p.frequency_hz, p.coherence]);
    Panel::Chart(Chart {
        title: "coherence of the data".to_owned(),
        x: Axis::decades("frequency in Hz", frequencies_hz),
        y: Axis::linear("γ²", [0.0, 1.05]),
        marks: vec![Mark::line(Ink::Measured, points)],
        height: 80.0,
        has_x_labels: true,
    })
}

fn figure(model: &Model, k: usize, unit: &str) -> Figure {
    let highest = 0.5 / model.transfer.sample_period_s();
    let lowest = highest / 10f64.powf(DECADES);
    let curve: Vec<(f64, Complex<f64>)> = (0..=POINTS)
        .map(|k| lowest * (highest / lowest).powf(f64::from(k) / f64::from(POINTS)))
        .map(|f| (f, model.transfer.response(f)))
        .collect();
    let sure: Vec<&Point> = model.measured.iter().filter(|p| p.coherence >= COHERENT).collect();
    let level = |z: Complex<f64>| decibels(z.norm());
    let degrees = |z: Complex<f64>| z.arg().to_degrees();
    let dots = |of: &dyn Fn(Complex<f64>) -> f64| -> Mark {
        let points = sure.iter().map(|p| [p.frequency_hz, of(p.response())]).collect();
        Mark::Dots { ink: Ink::Measured, points }
    };
    let line =
        |of: &dyn Fn(Complex<f64>) -> f64| Mark::line(Ink::After, curve.iter().map(|(f, z)| [*f, of(*z)]));
    let bars = |of: &dyn Fn(&Point) -> [f64; 3]| {
        let points = sure.iter().map(|p| of(p)).collect();
        Mark::Ribbon { ink: Ink::Measured, points }
    };
    let around = |p: &Point| {
        let (angle, half) = (degrees(p.response()), p.phase_half_width_deg());
        [p.frequency_hz, (angle - half).max(-185.0), (angle + half).min(185.0)]
    };
    let heights: Vec<f64> =
        curve.iter().map(|(_, z)| level(*z)).chain(sure.iter().map(|p| level(p.response()))).collect();
    let mut panels = vec![
        Panel::Chart(Chart {
            title: "magnitude".to_owned(),
            x: Axis::decades("", [lowest, highest]),
            y: Axis::holding(decibel_unit(unit), heights),
            marks: vec![bars(&magnitude_band), dots(&level), line(&level)],
            height: 170.0,
            has_x_labels: false,
        }),
        Panel::Chart(Chart {
            title: "phase".to_owned(),
            x: Axis::decades(if sure.is_empty() { "frequency in Hz" } else { "" }, [lowest, highest]),
            y: Axis::linear("°", [-185.0, 185.0]),
            marks: vec![bars(&around), dots(&degrees), line(&degrees)],
            height: 120.0,
            has_x_labels: sure.is_empty(),
        }),
    ];
    if !sure.is_empty() {
        panels.push(coherence(model, [lowest, highest]));
    }
    let caption = format!(
        "Frequency response of {}: the model, and the data with their 95 % band where their coherence is above {COHERENT}.",
        model.title
    );
    let mut figure = Figure::new(format!("model{}", k + 1), caption, panels);
    figure.legend = vec![(Ink::After, "model".to_owned()), (Ink::Measured, "data, 95 % band".to_owned())];
    figure
}
