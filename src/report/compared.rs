//! Recorded runs beside the machine's twin as text, and the rows that their page shows too.

use super::Style;
use super::layout::{Align, Ink, Table, paragraph};
use super::number::{NONE, value};
use crate::machine::Machine;
use crate::recording::{Recording, Signal};
use crate::replay::compared::Agreement;
use crate::replay::{Compared, Figures, PlantChoice, Published, SETTLING_BAND};

/// Heads of the table of signals; those of numbers begin with `>`.
const SIGNAL_HEADS: [&str; 7] = ["signal", ">MAE", ">RMS", ">peak", ">R²", ">MAE beside", ">R² beside"];
/// How many of them a comparison without a second machine has.
const HEADS_ALONE: usize = 5;
/// Heads of the table of figures.
pub(super) const FIGURE_HEADS: [&str; 3] = ["", ">recorded", ">twin"];
/// Heads of the table of published figures of merit, and how many of them a comparison without a second machine has.
const PUBLISHED_HEADS: [&str; 8] =
    ["run", "signal", ">MAE", ">published", ">R²", ">published", ">MAE beside", ">R² beside"];
const PUBLISHED_ALONE: usize = 6;

/// Recorded runs beside a machine's twin, and beside that of a second one where it was asked for.
#[derive(Debug)]
pub struct Comparison<'a> {
    /// What was recorded.
    pub recording: &'a Recording,
    /// The machine.
    pub machine: &'a Machine,
    /// Its runs.
    pub runs: &'a [Compared],
    /// A second machine along the same runs, in the same order.
    pub beside: Option<(&'a Machine, &'a [Compared])>,
    /// What both were replayed on.
    pub plant: PlantChoice,
}

impl<'a> Comparison<'a> {
    /// The runs, each with what the second machine makes of it.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (&'a Compared, Option<&'a Compared>)> {
        let beside = self.beside.map(|(_, runs)| runs);
        self.runs.iter().enumerate().map(move |(k, run)| (run, beside.and_then(|runs| runs.get(k))))
    }

    /// What was replayed on what, and how.
    pub(super) fn subject(&self) -> String {
        let (runs, plant) = (self.runs, self.plant);
        let count = if runs.len() == 1 { "One run".to_owned() } else { format!("{} runs", runs.len()) };
        let beside = self.beside.iter().flat_map(|(_, runs)| runs.iter());
        let mut ways: Vec<String> = runs.iter().chain(beside).map(|run| run.driven_by.to_string()).collect();
        ways.sort_unstable();
        ways.dedup();
        let beside = self.beside.map_or(String::new(), |(machine, _)| {
            format!(" Beside it: {} ({}).", machine.description().name, machine.file().display())
        });
        format!("{count} replayed on the {plant}: {}, perfect sensors.{beside}", ways.join("; "))
    }

    /// Heads of the table of signals.
    pub(super) fn signal_heads(&self) -> &'static [&'static str] {
        if self.beside.is_some() { &SIGNAL_HEADS } else { &SIGNAL_HEADS[..HEADS_ALONE] }
    }

    /// Heads of the table of published figures of merit.
    pub(super) fn published_heads(&self) -> &'static [&'static str] {
        if self.beside.is_some() { &PUBLISHED_HEADS } else { &PUBLISHED_HEADS[..PUBLISHED_ALONE] }
    }

    /// A row a signal whose figures of merit a run states as published.
    pub(super) fn published_rows(&self) -> Vec<Vec<String>> {
        let rows = self.pairs().flat_map(|(run, beside)| {
            run.published.iter().filter_map(move |published| published_row(run, beside, published))
        });
        rows.collect()
    }

    /// How many of the published errors are not exceeded; none where none is stated.
    pub(super) fn reached(&self) -> Option<String> {
        let both = |run: &Compared| -> Vec<bool> {
            let of = |p: &Published| Some(p.unit.from_si(run.of_signal(p.signal)?.mae) <= p.mae?);
            run.published.iter().filter_map(of).collect()
        };
        let all: Vec<bool> = self.runs.iter().flat_map(both).collect();
        let reached = all.iter().filter(|is_reached| **is_reached).count();
        (!all.is_empty())
            .then(|| format!("MAE at or below the published one in {reached} of {} rows.", all.len()))
    }
}

/// Recorded runs beside the twin as text: a table of errors a run, and of figures where it states stroke and feed; last,
/// published figures of merit.
pub fn compared(of: &Comparison<'_>, style: Style) -> String {
    let mut out = format!("{}\n", style.ink(Ink::Heading, &of.machine.description().name));
    out += &paragraph(&of.subject(), style);
    if let Some(note) = &of.recording.note {
        out += &paragraph(&format!("Data: {note}"), style);
    }
    for (run, beside) in of.pairs() {
        out += &style.heading(run.run.name(), &settings(run));
        out += &table(of.signal_heads(), signal_rows(run, beside), style);
        let rows = figure_rows(run);
        if !rows.is_empty() {
            out += "\n";
            out += &table(&FIGURE_HEADS, rows, style);
        }
    }
    if let Some(reached) = of.reached() {
        out += &style.heading("Beside what is published", "");
        out += &table(of.published_heads(), of.published_rows(), style);
        out += "\n";
        out += &paragraph(&reached, style);
    }
    out += "\n";
    out + &paragraph(&counted(of.runs), style)
}

fn table(heads: &[&str], rows: Vec<Vec<String>>, style: Style) -> String {
    let align = |head: &str| if head.starts_with('>') { Align::Right } else { Align::Left };
    let heads: Vec<(&str, Align)> =
        heads.iter().map(|head| (head.trim_start_matches('>'), align(head))).collect();
    let mut table = Table::new(&heads);
    rows.into_iter().for_each(|row| table.row(row));
    table.text(style)
}

/// Settings in force in a run.
pub(super) fn settings(run: &Compared) -> String {
    let list = run.run.settings.iter().map(|(path, value)| format!("{path} = {value}"));
    list.collect::<Vec<_>>().join(", ")
}

/// A coefficient of determination; far below zero its digits say nothing.
fn share(r2: Option<f64>) -> String {
    match r2 {
        None => NONE.to_owned(),
        Some(r2) if r2 < -9.0 => format!("{r2:.0}"),
        Some(r2) => format!("{r2:.5}"),
    }
}

/// A row a signal.
pub(super) fn signal_rows(run: &Compared, beside: Option<&Compared>) -> Vec<Vec<String>> {
    let motion = run.run.motion();
    let row = |Agreement { signal, mae, rms, peak, r2 }: &Agreement| {
        let si = |number: f64| value(number, signal.si_unit(motion));
        let mut cells = vec![signal.word(motion).to_owned(), si(*mae), si(*rms), si(*peak), share(*r2)];
        if let Some(beside) = beside {
            let other = beside.of_signal(*signal);
            cells.push(other.map_or_else(|| NONE.to_owned(), |other| si(other.mae)));
            cells.push(share(other.and_then(|other| other.r2)));
        }
        cells
    };
    run.agreement.iter().map(row).collect()
}

fn published_row(run: &Compared, beside: Option<&Compared>, published: &Published) -> Option<Vec<String>> {
    let own = run.of_signal(published.signal)?;
    let unit = published.unit;
    let shown = |number: f64| match number {
        small if small != 0.0 && small.abs() < 1e-3 => format!("{small:.1e} {}", unit.symbol()),
        number => format!("{number:.4} {}", unit.symbol()),
    };
    let stated = |number: Option<f64>, after: &str| {
        number.map_or_else(|| NONE.to_owned(), |number| format!("{number}{after}"))
    };
    let error = |of: Option<&Agreement>| of.map_or_else(|| NONE.to_owned(), |of| shown(unit.from_si(of.mae)));
    let mut cells = vec![
        run.run.name().to_owned(),
        published.signal.word(run.run.motion()).to_owned(),
        error(Some(own)),
        stated(published.mae, &format!(" {}", unit.symbol())),
        share(own.r2),
        stated(published.r2, ""),
    ];
    if let Some(beside) = beside {
        let other = beside.of_signal(published.signal);
        cells.push(error(other));
        cells.push(share(other.and_then(|other| other.r2)));
    }
    Some(cells)
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
