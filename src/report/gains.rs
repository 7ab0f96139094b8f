//! Identified controller gains as a report.

use super::number::plain;
use super::sheet::{Section, Sheet};
use crate::controller::regression::{ControllerGains, IdentifiedGain};
use crate::machine::Machine;
use crate::recording::Recording;
use crate::replay::gain_table::{GainTable, Mean, Recovered};
use crate::units::Motion;

/// A law that explains less of the effort's changes is another one.
const LEAST_EXPLAINED: f64 = 0.9;
/// Autocorrelation is no matter where nothing but rounding is left of the effort.
const ROUNDING: f64 = 1e-12;

/// Gains identified from a recording.
pub fn gains(found: &ControllerGains, machine: &Machine, recording: &Recording, runs: usize) -> Sheet {
    let name = &machine.description().name;
    let heads = ["gain", "stated", "identified", "95 % from", "to"];
    let rows = found.gains.iter().map(|gain| row(gain, machine)).collect();
    let mut section = Section::new("Gains").table(&heads, rows);
    let heads = ["gain", "what it multiplies", "register", "equivalent"];
    section =
        section.table_with(&heads, found.gains.iter().map(|gain| regressor(gain, machine)).collect(), 2);
    if found.gains.iter().any(|gain| gain.register.is_some()) {
        section = section
            .remark("equivalent: the register that would command the same with the stated gain per count.");
    }
    let mut quality = Section::new("How well they are determined");
    for words in quality_of(found) {
        quality = quality.words(words);
    }
    let mut sentence =
        format!("Gains of the control law of {name}, from {runs} of {} runs.", recording.runs().len());
    if found.explained < LEAST_EXPLAINED {
        sentence += &format!(
            " This law explains {:.0} % of the effort's changes: another law ran, or the signals are not of one sample. The gains say \
             nothing then.",
            100.0 * found.explained.max(0.0)
        );
    }
    Sheet {
        subject: recording.path.display().to_string(),
        kind: "controller gains",
        sentence,
        note: recording.note.clone(),
        motion: machine.motion(),
        sections: vec![section, quality],
    }
}

/// The key as this kind of axis has it.
fn key(gain: &IdentifiedGain, machine: &Machine) -> String {
    match machine.motion() {
        Motion::Prismatic => gain.key.to_owned(),
        Motion::Revolute => gain.key.replace("_per_m", "_per_rad"),
    }
}

fn row(gain: &IdentifiedGain, machine: &Machine) -> Vec<String> {
    let [from, to] = gain.estimate.ci95;
    vec![key(gain, machine), number(gain.stated), number(gain.estimate.value), number(from), number(to)]
}

fn regressor(gain: &IdentifiedGain, machine: &Machine) -> Vec<String> {
    let register = gain.register.map(|(stated, _)| stated.to_string()).unwrap_or_default();
    let equivalent = gain.register.map(|(_, nearest)| number(nearest)).unwrap_or_default();
    vec![key(gain, machine), gain.regressor.to_owned(), register, equivalent]
}

/// Five significant digits.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.4e}");
    }
    let digits = if value == 0.0 { 4 } else { (4 - value.abs().log10().floor() as i32).max(0) };
    format!("{value:.*}", digits as usize)
}

fn quality_of(found: &ControllerGains) -> Vec<String> {
    let mut words = vec![format!(
        "Condition number {:.1}, {} degrees of freedom; residual {} V, the law explains {:.4} % of the effort's changes.",
        found.condition,
        found.degrees_of_freedom,
        number(found.residual_sd_v),
        100.0 * found.explained
    )];
    if let Some(rho) = found.previous_effort {
        let says = if found.integrates_as_stated() {
            "1 is inside: the controller integrates as its law says."
        } else {
            "1 is outside: the law is another one, or the effort was clipped, recorded late or at another period."
        };
        let [from, to] = rho.ci95;
        words.push(format!("Coefficient of u(k-1): {:.6} ({from:.6} to {to:.6}). {says}", rho.value));
    }
    if found.clipped > 0 {
        words.push(format!(
            "{} samples were left out: the effort is at the amplifier's limit.",
            found.clipped
        ));
    }
    if !found.whiteness.is_white() && 1.0 - found.explained > ROUNDING {
        words.push(
            "The residual is not white (rounding in the logger does that, and so does a law that lacks something): the \
             intervals take its autocorrelation into account."
                .to_owned(),
        );
    }
    words
}

/// A published table of gains and what was found again.
pub fn gain_table(recovered: &[Recovered], machine: &Machine, plant: &str, seed: u64) -> Sheet {
    let heads = ["stroke", "published", "recovered", "95 % from", "to", "error", "condition"];
    let means = GainTable::means(recovered);
    let of_gain = |(j, mean): (usize, &Mean)| {
        let mut rows: Vec<Vec<String>> = recovered.iter().map(|cell| recovered_row(cell, j)).collect();
        rows.push(mean_row(*mean));
        let key = recovered[0].found.gains[j].key;
        Section::new(key).table(&heads, rows)
    };
    let sections = means.iter().enumerate().map(of_gain).collect();
    let worst = recovered.iter().flat_map(Recovered::errors).fold(0.0, |worst: f64, e| worst.max(e.abs()));
    Sheet {
        subject: machine.description().name.clone(),
        kind: "controller gains",
        sentence: format!(
            "{} strokes replayed with their published gains on the {plant}; each gain is found again within {:.2} %.",
            recovered.len(),
            100.0 * worst
        ),
        note: Some(format!(
            "simulated, not measured: sensors as the machine file states, seed {seed}; signals in the logger's resolution"
        )),
        motion: machine.motion(),
        sections,
    }
}

fn recovered_row(cell: &Recovered, j: usize) -> Vec<String> {
    let estimate = &cell.found.gains[j].estimate;
    let [from, to] = estimate.ci95;
    vec![
        cell.stroke.clone(),
        number(cell.published[j]),
        number(estimate.value),
        number(from),
        number(to),
        format!("{:+.3} %", 100.0 * cell.errors()[j]),
        plain(cell.found.condition),
    ]
}

fn mean_row(mean: Mean) -> Vec<String> {
    vec![
        "mean".to_owned(),
        number(mean.published),
        number(mean.found),
        String::new(),
        String::new(),
        format!("{:+.3} %", 100.0 * (mean.found / mean.published - 1.0)),
        String::new(),
    ]
}
