//! Recorded runs beside the machine's twin as text, and the rows that their page shows too.

use super::Style;
use super::layout::{Align, Ink, Table, paragraph};
use super::number::{NONE, value};
use crate::machine::Machine;
use crate::recording::{Recording, Signal};
use crate::replay::compared::Agreement;
use crate::replay::{Compared, Figures, PlantChoice, SETTLING_BAND};

/// Heads of the table of signals; those of numbers begin with `>`.
pub(super) const SIGNAL_HEADS: [&str; 5] = ["signal", ">MAE", ">RMS", ">peak", ">R²"];
/// Heads of the table of figures.
pub(super) const FIGURE_HEADS: [&str; 3] = ["", ">recorded", ">twin"];

/// Recorded runs beside the twin as text: a table of errors a run, and of figures where it states stroke and feed.
pub fn compared(
    recording: &Recording,
    machine: &Machine,
    runs: &[Compared],
    plant: PlantChoice,
    style: Style,
) -> String {
    let mut out = format!("{}\n", style.ink(Ink::Heading, &machine.description().name));
    out += &paragraph(&subject(runs, plant), style);
    if let Some(note) = &recording.note {
        out += &paragraph(&format!("Data: {note}"), style);
    }
    for run in runs {
        out += &style.heading(run.run.name(), &settings(run));
        out += &table(&SIGNAL_HEADS, signal_rows(run), style);
        let rows = figure_rows(run);
        if !rows.is_empty() {
            out += "\n";
            out += &table(&FIGURE_HEADS, rows, style);
        }
    }
    out += "\n";
    out + &paragraph(&counted(runs), style)
}

fn table(heads: &[&str], rows: Vec<Vec<String>>, style: Style) -> String {
    let align = |head: &str| if head.starts_with('>') { Align::Right } else { Align::Left };
    let heads: Vec<(&str, Align)> =
        heads.iter().map(|head| (head.trim_start_matches('>'), align(head))).collect();
    let mut table = Table::new(&heads);
    rows.into_iter().for_each(|row| table.row(row));
    table.text(style)
}

/// What was replayed on what, and how.
pub(super) fn subject(runs: &[Compared], plant: PlantChoice) -> String {
    let count = if runs.len() == 1 { "One run".to_owned() } else { format!("{} runs", runs.len()) };
    let mut ways: Vec<String> = runs.iter().map(|run| run.driven_by.to_string()).collect();
    ways.sort_unstable();
    ways.dedup();
    format!("{count} replayed on the {plant}: {}, perfect sensors.", ways.join("; "))
}

/// Settings in force in a run.
pub(super) fn settings(run: &Compared) -> String {
    let list = run.run.settings.iter().map(|(path, value)| format!("{path} = {value}"));
    list.collect::<Vec<_>>().join(", ")
}

/// A row a signal.
pub(super) fn signal_rows(run: &Compared) -> Vec<Vec<String>> {
    let motion = run.run.motion();
    let row = |Agreement { signal, mae, rms, peak, r2 }: &Agreement| {
        let si = |number: f64| value(number, signal.si_unit(motion));
        let share = r2.map_or_else(|| NONE.to_owned(), |r2| format!("{r2:.5}"));
        vec![signal.word(motion).to_owned(), si(*mae), si(*rms), si(*peak), share]
    };
    run.agreement.iter().map(row).collect()
}

/// What an operator asks of a stroke, recorded beside twin; no rows where the run does not state stroke and feed.
pub(super) fn figure_rows(run: &Compared) -> Vec<Vec<String>> {
    let Some([recorded, twin]) = &run.figures else { return Vec::new() };
    // No "-0.00": what does not run back has none.
    let percent = |share: f64| format!("{:.2}", (1e4 * share).round() / 100.0 + 0.0);
    let settling =
        |f: &Figures| f.settling_s.map_or_else(|| "not settled".to_owned(), |s| format!("{:.0} ms", 1e3 * s));
    let force = Signal::Thrust.si_unit(run.run.motion());
    let logged = run.run.signal(Signal::Thrust).is_some();
    let peak = |f: &Figures| value(f.peak_thrust, force);
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut row =
        |word: &str, recorded: String, twin: String| rows.push(vec![word.to_owned(), recorded, twin]);
    row("position overshoot, % of the stroke", percent(recorded.overshoot), percent(twin.overshoot));
    row("peak velocity over the feed, %", percent(recorded.peak_velocity), percent(twin.peak_velocity));
    let [a, b] = [recorded, twin].map(|f| percent(f.most_negative_velocity));
    row("most negative velocity, % of the feed", a, b);
    row(
        &format!("peak {}", Signal::Thrust.word(run.run.motion())),
        if logged { peak(recorded) } else { NONE.to_owned() },
        peak(twin),
    );
    row("settling", settling(recorded), settling(twin));
    rows
}

/// How errors and figures are counted.
pub(super) fn counted(runs: &[Compared]) -> String {
    let errors = "Errors are recorded less twin, the sensors' noise in them.";
    if runs.iter().all(|run| run.figures.is_none()) {
        return errors.to_owned();
    }
    format!(
        "{errors} Velocity figures are of its mean over 2 ms; settling into ±{:.0} % of the stroke, counted from the end \
         of the commanded motion.",
        100.0 * SETTLING_BAND
    )
}
