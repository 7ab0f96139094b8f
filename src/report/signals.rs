//! The signals in words: all in a list, or one with the units that it may be read in.

use super::Style;
use super::layout::{INDENT, Ink, labelled};
use super::wrap::columns;
use crate::recording::{Signal, TIME_KEY};
use crate::units::{Dimension, Motion};

/// Width of the labels of one signal.
const LABEL: usize = 14;

/// Every signal in the order of the signal path: its column on a prismatic and on a revolute axis.
pub fn signal_list(style: Style) -> String {
    let width = |motion| Signal::ALL.iter().map(|signal| columns(signal.key(motion))).max().unwrap_or(0);
    let (slides, turns) = (width(Motion::Prismatic), width(Motion::Revolute));
    let line = |sliding: &str, turning: &str, unit: &str, word: &str| {
        format!("{INDENT}{sliding:<slides$}  {turning:<turns$}  {unit:<12}  {word}\n")
    };
    let mut out =
        style.heading("signals", "columns of a log; the name holds the SI unit").trim_start().to_owned();
    out += &line("prismatic axis", "revolute axis", "unit", "");
    out += &line(TIME_KEY, TIME_KEY, "s", "time of the sample");
    for signal in Signal::ALL {
        let (slides, turns) = (signal.key(Motion::Prismatic), signal.key(Motion::Revolute));
        let word = if signal.is_measured() { format!("{signal} (measured)") } else { signal.to_string() };
        out += &line(slides, turns, &unit(signal), &word);
    }
    out += "\nA recording needs time (or sample_period_s) and one measured signal; what else is missing limits what can be told.\n";
    out + "One of them: slideway signals NAME\n"
}

/// The units of a signal on either kind of axis.
fn unit(signal: Signal) -> String {
    let [slides, turns] = [Motion::Prismatic, Motion::Revolute].map(|motion| signal.si_unit(motion));
    if slides == turns { slides.to_owned() } else { format!("{slides}, {turns}") }
}

/// What a signal is, the units that its column may have, and a line for `recording.toml`.
pub fn signal_sheet(signal: Signal, style: Style) -> String {
    let mut out = format!("{}  {}\n", style.ink(Ink::Heading, signal.key(Motion::Prismatic)), signal);
    let mut row = |label: &str, text: &str| out += &labelled(label, LABEL, text, style);
    row("meaning", signal.meaning());
    let motions = [Motion::Prismatic, Motion::Revolute];
    let same = signal.key(motions[0]) == signal.key(motions[1]);
    for motion in motions.into_iter().take(if same { 1 } else { 2 }) {
        let label = if same { "column".to_owned() } else { motion.to_string() };
        let units = signal.dimension(motion).symbols();
        row(
            &label,
            &format!("{} in {}; read from {}", signal.key(motion), signal.si_unit(motion), units.join(", ")),
        );
    }
    row("count", "a number for a unit is how many SI units one count is");
    out += &style.heading("in recording.toml", "");
    for motion in motions.into_iter().take(if same { 1 } else { 2 }) {
        out += &format!("{INDENT}{}\n", mapping(signal.key(motion), signal.dimension(motion)));
    }
    out
}

/// A line of `[columns]` with a unit other than SI, where there is one.
fn mapping(key: &str, dimension: Dimension) -> String {
    let symbols = dimension.symbols();
    let unit = symbols.iter().find(|symbol| **symbol != dimension.si_symbol()).or(symbols.first());
    format!("{key} = {{ column = \"name in the file\", unit = \"{}\" }}", unit.unwrap_or(&"1"))
}
