//! A transfer function from a sweep of sines: points, fit, and what it says of the axis.

use std::f64::consts::TAU;

use super::html::{Response, bode};
use super::sheet::{Section, Sheet};
use crate::drive::motor::Circuit;
use crate::identify::continuous::TransferFit;
use crate::identify::least_squares::Estimate;
use crate::identify::stepped_sine::Sine;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::units::Motion;
use nalgebra::Complex;

/// Points of the fitted curve.
const CURVE: usize = 200;

/// What was measured and fitted.
#[derive(Debug, Clone)]
pub struct Swept {
    /// Machine or recording.
    pub subject: String,
    /// Where the data come from.
    pub note: Option<String>,
    /// Kind of axis.
    pub motion: Motion,
    /// Signal that is the input.
    pub input: Signal,
    /// Signal that is the output.
    pub output: Signal,
    /// The points.
    pub sines: Vec<Sine>,
    /// The transfer function through them.
    pub fit: TransferFit,
    /// The machine, where there is one.
    pub machine: Option<Machine>,
}

/// The sweep as a report.
pub fn sheet(swept: &Swept) -> Sheet {
    let Swept { subject, note, motion, fit, sines, .. } = swept;
    let gain = fit
        .static_gain
        .map_or_else(String::new, |gain| format!(", static gain {:.3} dB", decibels(gain.value.abs())));
    let sentence = format!(
        "T(s) = {} in {} from {} sines{gain}; the points lie {:.3} % off, RMS.",
        fit.transfer,
        unit(swept),
        sines.len(),
        100.0 * fit.deviation,
    );
    let mut sections = vec![coefficients(swept), Section::new("Bode").figure(bode(&response(swept)))];
    sections.extend(axis(swept));
    sections.push(points(swept));
    Sheet {
        subject: subject.clone(),
        kind: "sine sweep",
        sentence,
        note: note.clone(),
        motion: *motion,
        sections,
    }
}

fn decibels(value: f64) -> f64 {
    20.0 * value.max(f64::MIN_POSITIVE).log10()
}

/// Unit of output over input.
fn unit(swept: &Swept) -> String {
    let [output, input] = [swept.output, swept.input].map(|signal| signal.si_unit(swept.motion));
    let bracketed = if output.contains('/') { format!("({output})") } else { output.to_owned() };
    format!("{bracketed}/{input}")
}

fn row(name: String, estimate: &Estimate, factor: f64, unit: &str) -> Vec<String> {
    let Estimate { value, standard_error, ci95: [from, to] } = *estimate;
    // Two digits of the standard error, not more than twelve of the value.
    let size = (factor * value).abs().max(f64::MIN_POSITIVE);
    let places = (1.0 - (factor * standard_error).abs().max(1e-9 * size).log10().floor()).clamp(0.0, 15.0);
    let text = |number: f64| match (1e-3..1e7).contains(&size) {
        true => format!("{:.1$}", factor * number, places as usize),
        false => format!("{:.5e}", factor * number),
    };
    vec![name, text(value), text(from), text(to), unit.to_owned()]
}

fn coefficients(swept: &Swept) -> Section {
    let fit = &swept.fit;
    let power = |letter: &str, k: usize| match k {
        0 => format!("{letter}0"),
        1 => format!("{letter}1, of s"),
        k => format!("{letter}{k}, of s^{k}"),
    };
    let mut rows: Vec<Vec<String>> =
        fit.numerator.iter().enumerate().map(|(k, e)| row(power("b", k), e, 1.0, "")).collect();
    rows.extend(fit.denominator.iter().enumerate().map(|(k, e)| row(power("a", k), e, 1.0, "")));
    if let (1, [a]) = (fit.denominator.len(), &fit.denominator[..]) {
        rows.push(row("corner".to_owned(), a, 1.0, "rad/s"));
    }
    rows.extend(fit.static_gain.map(|gain| row("static gain".to_owned(), &gain, 1.0, &unit(swept))));
    rows.extend(fit.delay_s.map(|delay| row("delay".to_owned(), &delay, 1e3, "ms")));
    Section::new("Transfer function")
        .table(&["coefficient", "value", "95 % from", "to", "unit"], rows)
        .remark(format!(
            "{} points, condition {:.1}; numerator b, denominator a with 1 before its highest power of s; intervals from the \
             scatter of the points about the fit",
            fit.points, fit.condition
        ))
}

/// Inertia and drag behind a first-order lag from current (or effort) to velocity.
fn axis(swept: &Swept) -> Option<Section> {
    let fit = &swept.fit;
    let constants = swept.machine.as_ref()?.constants();
    let ([b], [a], Signal::Velocity) = (&fit.numerator[..], &fit.denominator[..], swept.output) else {
        return None;
    };
    let constant = match (swept.input, constants.circuit) {
        (Signal::Thrust, _) => 1.0,
        (Signal::Current, Circuit::Winding { force_constant, .. }) => force_constant,
        (Signal::ControlEffort, _) if !constants.has_voltage_fed_winding => constants.force_per_volt(),
        _ => return None,
    };
    let words = match swept.motion {
        Motion::Prismatic => ["moving mass", "kg", "viscous coefficient", "N·s/m"],
        Motion::Revolute => ["inertia", "kg·m²", "viscous coefficient", "N·m·s/rad"],
    };
    let cells = |name: &str, found: f64, stated: f64, unit: &str| {
        vec![name.to_owned(), format!("{found:.5e}"), format!("{stated:.5e}"), unit.to_owned()]
    };
    let inertia = constant / b.value;
    let rows = vec![
        cells(words[0], inertia, constants.moving_mass, words[1]),
        cells(words[2], inertia * a.value, constants.viscous, words[3]),
    ];
    let remark = format!(
        "with the stated constant of {constant} {}",
        match swept.motion {
            Motion::Prismatic => "N per unit of the input",
            Motion::Revolute => "N·m per unit of the input",
        }
    );
    Some(Section::new("Axis").table(&["constant", "found", "stated", "unit"], rows).remark(remark))
}

fn points(swept: &Swept) -> Section {
    let one = |sine: &Sine| {
        let (measured, fitted) =
            (sine.point.response(), swept.fit.transfer.response(sine.point.frequency_hz));
        let off = measured / fitted;
        vec![
            format!("{:.4}", TAU * sine.point.frequency_hz),
            format!("{:.4}", decibels(measured.norm())),
            format!("{:.2}", measured.arg().to_degrees()),
            format!("{:+.4}", decibels(off.norm())),
            format!("{:+.2}", off.arg().to_degrees()),
            sine.periods.to_string(),
            format!("{:.5}", sine.point.coherence),
        ]
    };
    let heads = ["rad/s", "gain dB", "phase °", "off fit dB", "off fit °", "periods", "sine's share"];
    Section::new("Points").table_with(&heads, swept.sines.iter().map(one).collect(), 0)
}

fn response(swept: &Swept) -> Response {
    let (fit, sines) = (&swept.fit, &swept.sines);
    let ends = [sines.first(), sines.last()].map(|s| s.map_or(1.0, |s| s.point.frequency_hz));
    let curve = |k: usize| -> (f64, Complex<f64>) {
        let frequency = ends[0] * (ends[1] / ends[0]).powf(k as f64 / (CURVE - 1) as f64);
        (frequency, fit.transfer.response(frequency))
    };
    let word = |signal: Signal| signal.word(swept.motion);
    let marked = match &fit.denominator[..] {
        [corner] if corner.value > 0.0 => vec![(corner.value / TAU, "corner".to_owned())],
        _ => Vec::new(),
    };
    Response {
        name: "sweep".to_owned(),
        title: format!("{} to {}", word(swept.input), word(swept.output)),
        unit: unit(swept),
        measured: sines.iter().map(|sine| sine.point).collect(),
        computed: (0..CURVE).map(curve).collect(),
        computed_word: format!("T(s) = {}", fit.transfer),
        marked,
    }
}
