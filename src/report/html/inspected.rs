//! A machine or a recording as a page.

use super::page::{Builder, Page, Part};
use super::replayed::{recorded, version};
use super::{data, head, provenance, scene, spectrum};
use crate::base::Modes;
use crate::machine::Machine;

use crate::recording::{Recording, Signal, plausibility};
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel, escape};
use crate::report::material::{MachineShape, Response, RunTraces};
use crate::report::number::value;
use crate::twin::LinearLoop;
use crate::units::Motion;

/// Parts of the description in hardware order; the modes of the base have a section of their own.
const PARTS: [&str; 10] = [
    "reference",
    "controller",
    "amplifier",
    "motor",
    "guide",
    "encoder",
    "load_sensor",
    "current_sensor",
    "tolerance",
    "effect",
];
/// Points of a response.
const POINTS: i32 = 500;

/// A machine as a page: its shape, its parts, its masses, its base.
pub fn machine(machine: &Machine, command: &str) -> Page {
    let description = machine.description();
    let shape = MachineShape::of(machine);
    let (unit, word) = match machine.motion() {
        Motion::Prismatic => ("kg", "moving mass"),
        Motion::Revolute => ("kg·m²", "inertia about the joint"),
    };
    let sentence = format!(
        "A {} axis with a {word} of {}, controlled every {}.",
        machine.motion(),
        value(machine.constants().moving_mass, unit),
        value(description.sample_period_s, "s")
    );
    let warning = LinearLoop::warning(machine).map_or(String::new(), |text| format!(" {text}"));
    let sentence = sentence + &warning;
    let title = format!("{}: machine", description.name);
    let mut page = Builder::new(&title, head::plain_head(&description.name, "machine", &sentence, None));
    page.section("machine", "The machine", scene::part(&shape, false));
    page.section("links", "Links", links(machine));
    page.section("parts", "Parts in the order of the signal path", parts(machine));
    page.section("base", "Base modes", base(machine));
    let rows = [("machine file", machine.file().display().to_string()), version()];
    page.section("provenance", "Where this comes from", provenance::list(&rows, command));
    page.finish(&data::of(machine.motion(), &[], Some(&shape)))
}

fn links(machine: &Machine) -> Part {
    let mut part = Part::default();
    let rows: Vec<Vec<String>> = machine
        .solid()
        .links()
        .map(|(side, link)| {
            let moves = if side == crate::solid::Side::Moving { "yes" } else { "no" };
            vec![link.name.clone(), moves.to_owned(), value(link.mass.mass_kg, "kg")]
        })
        .collect();
    part.table(&["link", "moves", ">mass"], &rows);
    part
}

fn parts(machine: &Machine) -> Part {
    let mut part = Part::default();
    let table = toml::Table::try_from(machine.description()).unwrap_or_else(|_| machine.table().clone());
    for name in PARTS {
        if let Some(toml::Value::Table(keys)) = table.get(name)
            && !keys.is_empty()
        {
            let text: String =
                keys.iter().map(|(key, value)| format!("{key} = {}\n", written(value))).collect();
            part.raw(&format!("<h3>{}</h3>\n<pre>{}</pre>\n", escape(name), escape(text.trim_end())));
        }
    }
    part
}

/// A value as in the file; a small number with its power of ten.
fn written(value: &toml::Value) -> String {
    match value.as_float() {
        Some(number) if number != 0.0 && number.abs() < 1e-4 => format!("{number:e}"),
        _ => value.to_string(),
    }
}

/// Modes as a table and the response at the reaction point.
fn base(machine: &Machine) -> Part {
    let mut part = Part::default();
    let Some(base) = &machine.description().base else { return part };
    let rows: Vec<Vec<String>> = base
        .mode
        .iter()
        .enumerate()
        .map(|(k, mode)| {
            vec![
                (k + 1).to_string(),
                format!("{} Hz", mode.frequency_hz()),
                format!("{} kg", mode.mass_kg()),
                format!("{} %", 100.0 * mode.damping_ratio()),
                format!("{:.1} N/µm", mode.stiffness_n_per_m() / 1e6),
            ]
        })
        .collect();
    let modes = Modes::new(base.mode.clone());
    let highest = base.mode.iter().map(|m| m.frequency_hz()).fold(1.0, f64::max);
    let lowest = base.mode.iter().map(|m| m.frequency_hz()).fold(highest, f64::min);
    let (from, to) = (0.3 * lowest, 2.0 * highest);
    let points: Vec<[f64; 2]> = (0..=POINTS)
        .map(|k| from * (to / from).powf(f64::from(k) / f64::from(POINTS)))
        .map(|f| [f, 1e9 * modes.drive_point_response(f).norm()])
        .collect();
    let chart = Chart {
        title: String::new(),
        x: Axis::linear("frequency in Hz", [from, to]),
        y: Axis::decades("nm per N", points.iter().map(|p| p[1])),
        marks: vec![Mark::line(Ink::After, points)],
        height: 190.0,
        has_x_labels: true,
    };
    let caption = "Motion of the base per force at the point that receives the motor's reaction.";
    part.figure(Figure::new("base", caption, vec![Panel::Chart(chart)]));
    part.table(&[">mode", ">frequency", ">modal mass", ">damping", ">stiffness"], &rows);
    part
}

/// A recording as a page: its runs, its signals, what is implausible in it.
pub fn recording(recording: &Recording, machine: Option<&Machine>, command: &str) -> Page {
    let runs: Vec<RunTraces> = recording.runs().iter().map(|run| RunTraces::recorded(run, machine)).collect();
    let name = recording.path.display().to_string();
    let samples: usize = recording.runs().iter().map(crate::recording::Run::len).sum();
    let sentence = format!(
        "{} runs of a {} axis, {samples} samples, one every {}.",
        runs.len(),
        recording.motion(),
        value(recording.sample_period_s(), "s")
    );
    let title = format!("{name}: recording");
    let mut page =
        Builder::new(&title, head::plain_head(&name, "recording", &sentence, recording.note.as_deref()));
    page.section("runs", "Runs", run_table(recording));
    page.section("traces", "Signals", recorded(&runs, recording));
    let shape = machine.map(MachineShape::of);
    if let Some(shape) = &shape {
        page.section("machine", "The machine", scene::part(shape, true));
    }
    let mut response = Part::default();
    if let Some(found) = Response::of(&runs) {
        response.figure(spectrum::figure(&found, recording.motion(), ""));
    }
    page.section("spectrum", "Frequency response", response);
    page.section("checks", "What was noticed", noticed(recording));
    let rows = [("recording", name), ("SHA-256 of the recording", recording.sha256()), version()];
    page.section("provenance", "Where this comes from", provenance::list(&rows, command));
    page.finish(&data::of(recording.motion(), &runs, shape.as_ref()))
}

fn run_table(recording: &Recording) -> Part {
    let mut part = Part::default();
    let rows: Vec<Vec<String>> = recording
        .runs()
        .iter()
        .map(|run| {
            let words: Vec<&str> =
                run.signals().keys().map(|signal: &Signal| signal.word(run.motion())).collect();
            vec![
                run.name().to_owned(),
                run.role.map_or("not declared".to_owned(), |role| role.to_string().replace('_', " ")),
                run.len().to_string(),
                value(run.duration_s(), "s"),
                words.join(", "),
            ]
        })
        .collect();
    part.table(&["run", "role", ">samples", ">duration", "signals"], &rows);
    part
}

fn noticed(recording: &Recording) -> Part {
    let mut part = Part::default();
    let mut items = String::new();
    for run in recording.runs() {
        for finding in plausibility(run) {
            items += &format!("<li>{}: {}</li>\n", escape(run.name()), escape(&finding.to_string()));
        }
    }
    if items.is_empty() {
        part.paragraph("Nothing implausible in any column.");
    } else {
        part.raw(&format!("<ul class=\"findings\">\n{items}</ul>\n"));
    }
    part
}
