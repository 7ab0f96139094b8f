//! Samples at an uneven pace. Gaps of more than half a period, repeated and falling time stamps are refused where
//! a recording is read; this reports what is let through.

use super::{Check, Finding};
use crate::recording::{Run, Timing};
use crate::units::engineering;

/// Jitter below this share of the period is mentioned nowhere: time stamps are rounded.
const JITTER: f64 = 0.01;
/// From this share of a period on, a sample may belong to its neighbour: comparing sample by sample goes wrong.
const LARGE_JITTER: f64 = 0.5;
/// Share of irregular intervals from which the clock itself is uneven, or its stamps are coarse.
const THROUGHOUT: f64 = 0.5;
/// Samples by which two clocks may drift apart within a run before a delay is mistaken.
const DRIFT_SAMPLES: f64 = 0.5;

/// What the time stamps of a run show.
pub fn timing(run: &Run) -> Vec<Finding> {
    let timing = &run.timing;
    if run.instants_s().is_some() {
        return vec![polled(run)];
    }
    let intervals = run.len().saturating_sub(1).max(1);
    [jitter(run.name(), timing, intervals), drift(run.name(), timing, intervals)]
        .into_iter()
        .flatten()
        .collect()
}

/// A log that was read at uneven times.
fn polled(run: &Run) -> Finding {
    let mean_s = engineering(run.sample_period_s(), "s");
    let message = format!(
        "Samples at uneven times, {mean_s} apart in the mean: the twin is read at their time stamps; what a row commands holds \
         until the next row."
    );
    Finding::note(run.name(), Check::TimingJitter, message)
}

fn jitter(run: &str, timing: &Timing, intervals: usize) -> Option<Finding> {
    let worst = timing.worst_jitter();
    if worst <= JITTER {
        return None;
    }
    let row = timing.worst_jitter_row.map_or(String::new(), |row| format!(", worst at row {row}"));
    let count = timing.irregular_intervals;
    if worst > LARGE_JITTER {
        return Some(Finding::warning(
            run,
            Check::GapInTime,
            format!(
                "Intervals of up to {:.1} periods ({count} irregular ones{row}): samples may be missing. The \
                 replay assumes an even clock; split the run there or resample.",
                1.0 + worst
            ),
        ));
    }
    let percent = 100.0 * worst;
    let throughout = count as f64 > THROUGHOUT * intervals as f64;
    let why = if throughout {
        "nearly every interval is off, as rounded time stamps are; if it is the clock, the replay, which assumes \
         an even one, is wrong by that much"
    } else {
        "the replay assumes an even clock"
    };
    let message = format!(
        "Sampling jitter of up to {percent:.1} % of the period ({count} irregular intervals{row}): {why}."
    );
    Some(Finding::note(run, Check::TimingJitter, message))
}

fn drift(run: &str, timing: &Timing, intervals: usize) -> Option<Finding> {
    let measured = timing.measured_period_s?;
    let off = measured / timing.sample_period_s - 1.0;
    let samples = off.abs() * intervals as f64;
    (samples > DRIFT_SAMPLES).then(|| {
        Finding::note(
            run,
            Check::TimingJitter,
            format!(
                "The time column runs {:.0} ppm {} than sample_period_s says: over the run that adds up to {samples:.1} \
                 samples.",
                1e6 * off.abs(),
                if off > 0.0 { "slower" } else { "faster" }
            ),
        )
    })
}
