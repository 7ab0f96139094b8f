//! Recorded runs beside the machine's twin as a page.

use super::page::{Builder, Page, Part};
use super::replayed::version;
use super::scale::Scale;
use super::{data, head, provenance};
use crate::machine::Machine;
use crate::recording::{Recording, Signal};
use crate::replay::{Compared, PlantChoice};
use crate::report::compared as rows;
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};

/// Signals that may stand in the lowest panel: the first that was logged does.
const LOWEST: [Signal; 3] = [Signal::Thrust, Signal::Current, Signal::ControlEffort];

/// Recorded runs beside the twin as a page: for each run its signals over time, recording upon twin, and how far they are
/// apart.
pub fn compared(
    recording: &Recording,
    machine: &Machine,
    runs: &[Compared],
    plant: PlantChoice,
    command: &str,
) -> Page {
    let name = &machine.description().name;
    let sentence = rows::subject(runs, plant);
    let head = head::plain_head(name, "recording beside twin", &sentence, recording.note.as_deref());
    let mut page = Builder::new(&format!("{name}: recording beside twin"), head);
    for (k, run) in runs.iter().enumerate() {
        page.section(&format!("run{}", k + 1), run.run.name(), part(run));
    }
    let mut remark = Part::default();
    remark.paragraph(&rows::counted(runs));
    page.section("counted", "How it is counted", remark);
    let list = [
        ("machine file", machine.file().display().to_string()),
        ("SHA-256 of the recording", recording.sha256()),
        version(),
    ];
    page.section("provenance", "Where this comes from", provenance::list(&list, command));
    page.finish(&data::of(machine.motion(), &[], None))
}

fn part(run: &Compared) -> Part {
    let mut part = Part::default();
    let settings = rows::settings(run);
    if !settings.is_empty() {
        part.remark(&format!("Settings in force: {settings}"));
    }
    part.figure(figure(run));
    part.table(&rows::SIGNAL_HEADS, &rows::signal_rows(run));
    part.table(&rows::FIGURE_HEADS, &rows::figure_rows(run));
    part
}

/// Position, velocity and force of a run: reference, twin, recording.
fn figure(run: &Compared) -> Figure {
    let logged = |signal: &Signal| run.of_signal(*signal).is_some();
    let lowest = LOWEST.into_iter().find(logged);
    let signals: Vec<Signal> =
        [Signal::Position, Signal::Velocity].into_iter().filter(logged).chain(lowest).collect();
    let last = signals.len().saturating_sub(1);
    let charts = signals.iter().enumerate().map(|(k, &signal)| Panel::Chart(chart(run, signal, k == last)));
    let name: String =
        run.run.name().chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect();
    let settings = rows::settings(run);
    let settings = if settings.is_empty() { String::new() } else { format!(" with {settings}") };
    let words: Vec<&str> = signals.iter().map(|signal| signal.word(run.run.motion())).collect();
    let caption =
        format!("Run {}{settings}: {}, recorded and of the twin.", run.run.name(), words.join(", "));
    let mut figure = Figure::new(name, caption, charts.collect());
    let has_reference = reference(run, Signal::Position).is_some();
    let legend = [(Ink::Reference, "reference"), (Ink::Measured, "recording"), (Ink::Before, "twin")];
    figure.legend = legend
        .into_iter()
        .filter(|(ink, _)| *ink != Ink::Reference || has_reference)
        .map(|(ink, word)| (ink, word.to_owned()))
        .collect();
    figure
}

/// What a signal was told to be, where that was logged; a velocity reference may also be the position reference's slope.
fn reference(run: &Compared, signal: Signal) -> Option<Vec<f64>> {
    let logged = |signal| run.run.signal(signal).map(<[f64]>::to_vec);
    match signal {
        Signal::Position => logged(Signal::PositionReference),
        Signal::Velocity => logged(Signal::VelocityReference).or_else(|| {
            let position = logged(Signal::PositionReference)?;
            let period_s = run.run.sample_period_s();
            let slope = |k: usize| (position[k] - position[k.saturating_sub(1)]) / period_s;
            Some((0..position.len()).map(slope).collect())
        }),
        _ => None,
    }
}

fn chart(run: &Compared, signal: Signal, is_last: bool) -> Chart {
    let motion = run.run.motion();
    let recorded = run.run.signal(signal).unwrap_or_default();
    let twin = run.twin.signal(signal).unwrap_or_default();
    let reference = reference(run, signal).unwrap_or_default();
    let all = || recorded.iter().chain(twin).chain(&reference);
    let scale = Scale::signal(signal, motion, all());
    let period_s = run.run.sample_period_s();
    let points = |samples: &[f64]| -> Vec<[f64; 2]> {
        samples.iter().enumerate().map(|(k, x)| [k as f64 * period_s, scale.to(*x)]).collect()
    };
    let mut marks = Vec::new();
    if !reference.is_empty() {
        marks.push(Mark::line(Ink::Reference, points(&reference)));
    }
    // The twin lies upon the recording, dashed: where they agree, both are seen.
    marks.push(Mark::line(Ink::Measured, points(recorded)));
    marks.push(Mark::dashed(Ink::Before, points(twin)));
    let word = signal.word(motion);
    Chart {
        title: word[..1].to_uppercase() + &word[1..],
        x: Axis::linear(if is_last { "time in s" } else { "" }, [0.0, run.run.len() as f64 * period_s]),
        y: Axis::holding(scale.unit.clone(), all().map(|x| scale.to(*x))),
        marks,
        height: 150.0,
        has_x_labels: is_last,
    }
}
