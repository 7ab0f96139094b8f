//! HOW FAR: the gap before and after, signal by signal and as a whole.

use super::Style;
use super::layout::{Align, Table, labelled};
use super::number::{change, determination, percent, plain, value};
use super::words::{baseline, name};
use crate::diagnose::Verdict;
use crate::diagnose::noise::Source;
use crate::diagnose::verdict::{Diagnosis, SignalGap};
use crate::recording::Signal;
use crate::units::Motion;

/// A residual below this share of the noise says that the noise is overstated, and the gap understated.
const OVERSTATED: f64 = 0.3;
/// Width of the labels below the table.
const LABEL: usize = 11;

/// The section.
pub(super) fn section(diagnosis: &Diagnosis, motion: Motion, style: Style) -> String {
    let improved = if diagnosis.causes.is_empty() { "calibrated" } else { "with the causes, calibrated" };
    let remark = format!("held-out residuals, {} → {improved}", baseline(diagnosis));
    let mut out = style.heading("HOW FAR", &remark);
    let signals = &diagnosis.gap.signals;
    let whole = table(signals, motion, [true, true]);
    if whole.width() <= style.width {
        out += &whole.text(style);
    } else {
        out += &table(signals, motion, [true, false]).text(style);
        out += "\n";
        out += &table(signals, motion, [false, true]).text(style);
    }
    out += "\n";
    out + &summary(diagnosis, style)
}

/// RMS and noise, or peak and R², or both.
fn table(signals: &[SignalGap], motion: Motion, [size, shape]: [bool; 2]) -> Table {
    use Align::{Left, Right};
    let heads = [
        (true, ("signal", Left)),
        (size, ("RMS", Right)),
        (size, ("noise σ", Right)),
        (shape, ("peak", Right)),
        (shape, ("R²", Right)),
    ];
    let shown: Vec<_> = heads.iter().filter(|(shown, _)| *shown).map(|(_, head)| *head).collect();
    let mut table = Table::new(&shown);
    for gap in signals {
        let unit = Signal::from_key(&gap.signal).map_or("", |(signal, _)| signal.si_unit(motion));
        let mut row = vec![name(&gap.signal)];
        if size {
            row.push(change(gap.rms_before, gap.rms_after, unit));
            row.push(value(gap.noise, unit));
        }
        if shape {
            row.push(change(gap.peak_before, gap.peak_after, unit));
            row.push(format!("{} → {}", determination(gap.r2_before), determination(gap.r2_after)));
        }
        table.row(row);
    }
    table
}

fn summary(diagnosis: &Diagnosis, style: Style) -> String {
    let gap = &diagnosis.gap;
    let line = |label: &str, text: &str| labelled(label, LABEL, text, style);
    let mut out = line("noise σ", &noise_sources(&gap.signals));
    if let Some(text) = overstated(&gap.signals) {
        out += &line("", &text);
    }
    let g = format!(
        "{} → {} × noise (all signals together; {} is what noise alone leaves)",
        plain(gap.before),
        plain(gap.after),
        plain(gap.floor)
    );
    out += &line("gap G", &g);
    if diagnosis.verdict != Verdict::NoGap {
        let [from, to] = gap.closed_ci95.map(percent);
        let closed = format!(
            "{} achieved (95 % interval {}); {} predicted by cross-validation on the training runs",
            percent(gap.closed),
            if from == to { from } else { format!("{from} to {to}") },
            percent(gap.predicted_closed)
        );
        out += &line("closed", &closed);
        if let Some(scene) = &gap.rigid_body {
            let text = format!(
                "{} closed in the rigid-body scene, {} on the reduced axis ({} → {} × noise, {} of {} held-out runs){}",
                percent(scene.closed),
                percent(scene.closed_on_axis),
                plain(scene.before),
                plain(scene.after),
                scene.runs.len(),
                diagnosis.data.held_out.len(),
                if scene.has_failed() { ": the explanation is not confirmed there" } else { "" }
            );
            out += &line("rigid body", &text);
        }
        out += &line("unexplained", &percent(diagnosis.unexplained));
        if let Some(left) = &diagnosis.left {
            out += &line("", &left.sentence);
        }
    }
    out
}

/// Signals whose noise is stated larger than what is left of their residual; none where there is none.
pub(super) fn overstated(signals: &[SignalGap]) -> Option<String> {
    let is_loud = |signal: &&SignalGap| signal.rms_after < OVERSTATED * signal.noise;
    let loud: Vec<String> = signals.iter().filter(is_loud).map(|signal| name(&signal.signal)).collect();
    let words = || format!("overstated for {}: far more than is left of the residual", loud.join(", "));
    (!loud.is_empty()).then(words)
}

/// "from standstill: position, current; declared by the machine file: velocity".
pub(super) fn noise_sources(signals: &[SignalGap]) -> String {
    let sources = [
        (Source::Repeats, "from repeated runs"),
        (Source::Dwell, "from standstill"),
        (Source::Declared, "from the sensors as the machine file states them, through the loop"),
        (Source::Reference, "from what the twin leaves of the reference"),
        (Source::Assumed, "nothing to go by, 10⁻⁴ of the signal assumed"),
    ];
    let parts: Vec<String> = sources
        .iter()
        .filter_map(|(source, words)| {
            let of: Vec<String> = signals
                .iter()
                .filter(|gap| gap.noise_source == *source)
                .map(|gap| name(&gap.signal))
                .collect();
            let all = of.len() == signals.len();
            (!of.is_empty())
                .then(|| if all { (*words).to_owned() } else { format!("{}: {words}", of.join(", ")) })
        })
        .collect();
    parts.join("; ")
}
