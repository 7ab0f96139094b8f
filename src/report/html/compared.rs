//! Recorded runs beside the machine's twin as a page.

use super::page::{Builder, Page, Part};
use super::replayed::version;
use super::scale::Scale;
use super::{data, head, provenance};
use crate::recording::Signal;
use crate::replay::Compared;
use crate::report::compared::{self as rows, Comparison};
use crate::report::figure::{Axis, Chart, Figure, Ink, Mark, Panel};

/// Signals that may stand in the lowest panel: the first that was logged does.
const LOWEST: [Signal; 3] = [Signal::Thrust, Signal::Current, Signal::ControlEffort];

/// Recorded runs beside the twin as a page: for each run its signals over time, recording upon twin, and how far they are
/// apart.
pub fn compared(of: &Comparison<'_>, command: &str) -> Page {
    let name = &of.machine.description().name;
    let head = head::plain_head(name, "recording beside twin", &of.subject(), of.recording.note.as_deref());
    let mut page = Builder::new(&format!("{name}: recording beside twin"), head);
    if let Some(reached) = of.reached() {
        let mut published = Part::default();
        published.table(of.published_heads(), &of.published_rows());
        published.paragraph(&reached);
        page.section("published", "Beside what is published", published);
    }
    for (k, (run, beside)) in of.pairs().enumerate() {
        page.section(&format!("run{}", k + 1), run.run.name(), part(of, run, beside));
    }
    let mut remark = Part::default();
    remark.paragraph(&rows::counted(of.runs));
    page.section("counted", "How it is counted", remark);
    let mut list = vec![("machine file", of.machine.file().display().to_string())];
    if let Some((beside, _)) = of.beside {
        list.push(("machine file beside it", beside.file().display().to_string()));
    }
    list.extend([("SHA-256 of the recording", of.recording.sha256()), version()]);
    page.section("provenance", "Where this comes from", provenance::list(&list, command));
    page.finish(&data::of(of.machine.motion(), &[], None))
}

fn part(of: &Comparison<'_>, run: &Compared, beside: Option<&Compared>) -> Part {
    let mut part = Part::default();
    let settings = rows::settings(run);
    if !settings.is_empty() {
        part.remark(&format!("Settings in force: {settings}"));
    }
    part.figure(figure(of, run, beside));
    part.table(of.signal_heads(), &rows::signal_rows(run, beside));
    part.table(&rows::FIGURE_HEADS, &rows::figure_rows(run));
    part
}

/// Position, velocity and force of a run: reference, twin, recording.
fn figure(of: &Comparison<'_>, run: &Compared, beside: Option<&Compared>) -> Figure {
    let logged = |signal: &Signal| run.of_signal(*signal).is_some();
    let lowest = LOWEST.into_iter().find(logged);
    let signals: Vec<Signal> =
        [Signal::Position, Signal::Velocity].into_iter().filter(logged).chain(lowest).collect();
    let last = signals.len().saturating_sub(1);
    let each = signals.iter().enumerate();
    let charts = each.map(|(k, &signal)| Panel::Chart(chart(run, beside, signal, k == last)));
    let name: String =
        run.run.name().chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect();
    let settings = rows::settings(run);
    let settings = if settings.is_empty() { String::new() } else { format!(" with {settings}") };
    let words: Vec<&str> = signals.iter().map(|signal| signal.word(run.run.motion())).collect();
    let caption =
        format!("Run {}{settings}: {}, recorded and of the twin.", run.run.name(), words.join(", "));
    let mut figure = Figure::new(name, caption, charts.collect());
    if reference(run, Signal::Position).is_some() {
        figure.legend.push((Ink::Reference, "reference".to_owned()));
    }
    figure.legend.push((Ink::Measured, "recording".to_owned()));
    match of.beside {
        None => figure.legend.push((Ink::Before, "twin".to_owned())),
        Some((other, _)) => figure.legend.extend([
            (Ink::Before, format!("twin: {}", of.machine.description().name)),
            (Ink::After, format!("beside: {}", other.description().name)),
        ]),
    }
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

fn chart(run: &Compared, beside: Option<&Compared>, signal: Signal, is_last: bool) -> Chart {
    let motion = run.run.motion();
    let recorded = run.run.signal(signal).unwrap_or_default();
    let twin = run.twin.signal(signal).unwrap_or_default();
    let other = beside.and_then(|beside| beside.twin.signal(signal)).unwrap_or_default();
    let reference = reference(run, signal).unwrap_or_default();
    let all = || recorded.iter().chain(twin).chain(other).chain(&reference);
    let scale = Scale::signal(signal, motion, all());
    let period_s = run.run.sample_period_s();
    let points = |samples: &[f64]| -> Vec<[f64; 2]> {
        samples.iter().enumerate().map(|(k, x)| [k as f64 * period_s, scale.to(*x)]).collect()
    };
    let mut marks = Vec::new();
    if !reference.is_empty() {
        marks.push(Mark::line(Ink::Reference, points(&reference)));
    }
    if !other.is_empty() {
        marks.push(Mark::line(Ink::After, points(other)));
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
