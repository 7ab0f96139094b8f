//! A cross-check of the plants as text, and the rows that its page shows too.

use super::Style;
use super::layout::{Align, Ink, Table, paragraph};
use super::number::{NONE, engineering_unit, plain, value};
use crate::machine::Machine;
use crate::plant::mujoco;
use crate::replay::crosscheck::{Bound, Outcome, Pair, Quantity, Replayed, Static, short_name};
use crate::units::Motion;

/// Tables of three pairs need this width.
const WIDTH: usize = 110;
/// Share of a quantity's scale that is no more than rounding.
const ROUNDING: f64 = 1e-12;
/// Decades that are written without a power of ten.
const PLAIN: std::ops::Range<i32> = -3..9;

/// How to have MuJoCo in the program.
pub(super) const HOW_TO: [&str; 3] = [
    ".ci/mujoco .mujoco",
    "export MUJOCO_DYNAMIC_LINK_DIR=…    # the folder that it names",
    "cargo install --path . --features mujoco",
];

/// A cross-check as text: what needs no replay, a table a stroke, the bounds with their reasons, the verdict in the last line.
pub fn crosscheck(outcome: &Outcome, machine: &Machine, style: Style) -> String {
    let style = Style { width: style.width.max(WIDTH), ..style };
    let motion = machine.motion();
    let mut out = format!("{}\n", style.ink(Ink::Heading, &machine.description().name));
    out += &paragraph(&subject(outcome), style);
    if !mujoco::IS_BUILT_IN {
        out += &paragraph(
            "This program was built without MuJoCo; the other two are compared. To have it:",
            style,
        );
        out += &HOW_TO.map(|line| format!("    {line}\n")).concat();
    }
    out += &style.heading("WITHOUT REPLAY", "differences relative");
    out += &table(&static_heads(), static_rows(outcome), style);
    for stroke in &outcome.strokes {
        out += &style.heading(&format!("STROKE {}", title(stroke, motion)), "RMS (peak)");
        out += &table(&stroke_heads(stroke), stroke_rows(stroke, motion), style);
    }
    out += &style.heading("HOW STEPS ARE ACCOUNTED FOR", "");
    out += &steps(outcome, motion).iter().map(|line| paragraph(line, style)).collect::<String>();
    out += &style.heading("BOUNDS", "");
    out += &outcome.bounds().iter().map(|bound| paragraph(&reason(bound), style)).collect::<String>();
    let ink = if outcome.is_within() { Ink::Good } else { Ink::Bad };
    out + "\n" + &style.ink(ink, &verdict(outcome)) + "\n"
}

fn table(heads: &[String], rows: Vec<Vec<String>>, style: Style) -> String {
    let align = |k: usize| if k == 0 { Align::Left } else { Align::Right };
    let heads: Vec<(&str, Align)> =
        heads.iter().enumerate().map(|(k, head)| (head.as_str(), align(k))).collect();
    let mut table = Table::new(&heads);
    rows.into_iter().for_each(|row| table.row(row));
    table.text(style)
}

/// Which plants, and how they are driven.
pub(super) fn subject(outcome: &Outcome) -> String {
    let names: Vec<String> = outcome.plants.iter().map(|plant| plant.to_string()).collect();
    let driven = if outcome.is_closed_loop {
        "in closed loop with perfect sensors"
    } else {
        "in open loop, by the force that each stroke needs (the machine has no controller)"
    };
    format!("{} strokes on the {}, {driven}.", outcome.strokes.len(), names.join(", the "))
}

/// Whether all is within its bounds; otherwise what is not.
pub(super) fn verdict(outcome: &Outcome) -> String {
    match &outcome.exceeded()[..] {
        [] => {
            let plants: Vec<&str> = outcome.plants.iter().map(|plant| short_name(*plant)).collect();
            format!("WITHIN BOUNDS: {}", plants.join(", "))
        }
        list => format!("EXCEEDED: {}", list.join("; ")),
    }
}

/// A stroke and its ramp.
pub(super) fn title(stroke: &Replayed, motion: Motion) -> String {
    let units = match motion {
        Motion::Prismatic => "m@m/min",
        Motion::Revolute => "rad@rad/s",
    };
    format!("{} {units}, ramp {}", stroke.cell, value(stroke.ramp_s, "s"))
}

pub(super) fn static_heads() -> Vec<String> {
    ["", "solid, axis", "rapier", "MuJoCo", "unit", "difference", "bound", ""].map(str::to_owned).to_vec()
}

/// A row a quantity.
pub(super) fn static_rows(outcome: &Outcome) -> Vec<Vec<String>> {
    let row = |row: &Static| {
        let mut cells = vec![row.quantity.clone()];
        cells.extend(
            row.values.map(|value| value.map_or_else(|| NONE.to_owned(), |value| digits(value, row))),
        );
        cells.push(if row.unit == "1" { String::new() } else { row.unit.to_owned() });
        cells.push(row.difference().map_or_else(|| NONE.to_owned(), small));
        cells.push(small(row.bound.limit));
        cells.push(if row.difference().is_some() { mark(row.is_exceeded()) } else { NONE.to_owned() });
        cells
    };
    outcome.statics.iter().map(row).collect()
}

pub(super) fn stroke_heads(stroke: &Replayed) -> Vec<String> {
    let pairs = stroke.pairs().into_iter().map(|pair| pair.to_string());
    [String::new()].into_iter().chain(pairs).chain(["bound, RMS".to_owned(), String::new()]).collect()
}

/// A row a quantity: RMS and peak of each pair, the bound.
pub(super) fn stroke_rows(stroke: &Replayed, motion: Motion) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    let pairs = stroke.pairs();
    for of_quantity in stroke.differences.chunk_by(|a, b| a.quantity == b.quantity) {
        let quantity = of_quantity[0].quantity;
        let unit = unit(quantity, motion);
        let cell = |pair: &Pair| {
            let found = of_quantity.iter().find(|difference| difference.pair == *pair);
            found.map_or_else(|| NONE.to_owned(), |d| both(d.rms, d.peak, unit))
        };
        let mut row = vec![quantity.to_string()];
        row.extend(pairs.iter().map(cell));
        row.push(format!("≤ {}", value(of_quantity[0].bound.limit, unit)));
        row.push(mark(of_quantity.iter().any(|difference| difference.is_exceeded())));
        rows.push(row);
    }
    rows
}

/// What was taken off or added for the engines' steps.
pub(super) fn steps(outcome: &Outcome, motion: Motion) -> Vec<String> {
    let unit = unit(Quantity::Position, motion);
    let offsets = &outcome.offsets;
    let mut lines = vec![
        "axis: exact between switches of the voltage; nothing is taken off.".to_owned(),
        format!(
            "rapier: symplectic Euler leads by half a step; h·v/2 is taken off its position, at most {} here (h = {}).",
            value(offsets.lead, unit),
            value(offsets.step_s, "s")
        ),
    ];
    if mujoco::IS_BUILT_IN {
        lines.push("MuJoCo: Runge–Kutta of fourth order leads by nothing.".to_owned());
    }
    lines.push(format!(
        "Engines hold a force over a step; its rise in it moves the position by −rise·h²/12·(1/m + Σ 1/M), which is added: \
         at most {} in all here.",
        value(offsets.rise, unit)
    ));
    let has_loads =
        |stroke: &Replayed| stroke.differences.iter().any(|d| matches!(d.quantity, Quantity::Slider(_)));
    if mujoco::IS_BUILT_IN && outcome.strokes.iter().any(has_loads) {
        lines.push(
            "Slider loads: both are means over the last step. rapier's comes from the change of momentum over it, MuJoCo's \
             from the interaction force half-way under the step's mean forces; by the midpoint rule they differ by h²/24 of \
             the load's second derivative."
                .to_owned(),
        );
    }
    lines
}

/// A bound with its reason.
pub(super) fn reason(bound: &Bound) -> String {
    format!("{}: {}.", bound.of, bound.reason)
}

/// SI unit of a quantity.
pub(super) fn unit(quantity: Quantity, motion: Motion) -> &'static str {
    match (quantity, motion) {
        (Quantity::Position, Motion::Prismatic) => "m",
        (Quantity::Position, Motion::Revolute) => "rad",
        (Quantity::Velocity, Motion::Prismatic) => "m/s",
        (Quantity::Velocity, Motion::Revolute) => "rad/s",
        (Quantity::Thrust, Motion::Revolute) => "N·m",
        _ => "N",
    }
}

fn both(rms: f64, peak: f64, si_unit: &str) -> String {
    if !(rms.is_finite() && peak.is_finite()) {
        return NONE.to_owned();
    }
    let (size, symbol) = engineering_unit(peak, si_unit);
    format!("{} ({}) {symbol}", plain(rms / size), plain(peak / size))
}

/// Nine significant digits, as many as the bounds on masses need; a count as such, and what only rounding makes differ from
/// zero as zero.
fn digits(number: f64, row: &Static) -> String {
    if number.abs() < ROUNDING * row.scale {
        return "0".to_owned();
    }
    if row.bound.limit == 0.0 {
        return number.to_string();
    }
    let text = format!("{number:.8e}");
    let exponent = text.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
    match exponent {
        Some(exponent) if PLAIN.contains(&exponent) => {
            format!("{number:.*}", usize::try_from(8 - exponent).unwrap_or(0))
        }
        _ => text,
    }
}

fn small(number: f64) -> String {
    if number == 0.0 { "0".to_owned() } else { format!("{number:.1e}") }
}

fn mark(is_exceeded: bool) -> String {
    if is_exceeded { "EXCEEDED" } else { "ok" }.to_owned()
}
