//! Readings that repeat the one before while the axis moves: rows that were lost, and filled with old values.

use super::{Check, Finding};
use crate::recording::{Run, Signal};
use std::ops::Range;

/// An axis that moves so many steps of the reading from sample to sample, one way before and after, reads no value twice by chance: noise would have to be as large.
const CLEAR_STEPS: f64 = 10.0;
/// Fewer repeated readings are not told: a reading may rest for reasons of its own once.
const LEAST: usize = 3;
/// Readings in a row that are taken for lost ones at most; more of them are a frozen channel, or an axis that was stopped.
const MOST_IN_A_ROW: usize = 10;

/// Repeated readings of the position sensors of a run.
pub(super) fn repeated(run: &Run) -> Vec<Finding> {
    [Signal::Position, Signal::LoadPosition].into_iter().filter_map(|signal| finding(run, signal)).collect()
}

fn finding(run: &Run, signal: Signal) -> Option<Finding> {
    let held = repeats(run.signal(signal)?);
    let count: usize = held.iter().map(|samples| samples.len()).sum();
    let first = held.first().filter(|_| count >= LEAST)?.start;
    let signal = signal.word(run.motion());
    Some(Finding::warning(
        run.name(),
        Check::HeldChannel,
        format!(
            "The {signal} repeats its reading of the sample before at {count} samples, first at sample {first}, while the axis moves: samples were lost there and filled with \
             old values, or the channel was read too early. Log it again, or take those rows out: up to five lost rows in a row, in at most 2 % of the rows, are filled in on the straight line."
        ),
    ))
}

/// The samples that repeat the one before, where the axis moves one way before and after them; none where that is how the signal is sampled throughout.
///
/// # Validity
/// Readings on a grid, whose step is the least difference between two neighbours; of readings without a grid, that repeat no value by chance.
fn repeats(samples: &[f64]) -> Vec<Range<usize>> {
    let steps: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let least = steps.iter().map(|step| step.abs()).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let moves = |step: f64| step.abs() > CLEAR_STEPS * least;
    let (mut found, mut from) = (Vec::new(), 0);
    for at in 0..steps.len() {
        if steps[at] == 0.0 {
            continue;
        }
        // Steps from..at are zero.
        let is_lost = from > 0
            && (from + 1..=from + MOST_IN_A_ROW).contains(&at)
            && [from - 1, at].iter().all(|k| moves(steps[*k]))
            && steps[from - 1].signum() == steps[at].signum();
        if is_lost {
            found.push(from + 1..at + 1);
        }
        from = at + 1;
    }
    let repeated: usize = found.iter().map(ExactSizeIterator::len).sum();
    let moving = steps.iter().filter(|step| moves(**step)).count();
    // A channel that is sampled more slowly and held is another finding.
    if 2 * repeated < moving { found } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 1000 samples read in steps of 10⁻⁴ of its amplitude, some readings held.
    fn read(held: &[Range<usize>]) -> Vec<f64> {
        let exact = |k: usize| (1e4 * (0.01 * k as f64).sin()).round();
        let at = |k: usize| {
            held.iter().find(|samples| samples.contains(&k)).map_or(k, |samples| samples.start - 1)
        };
        (0..1000).map(|k| exact(at(k))).collect()
    }

    #[test]
    fn exact_held_readings_are_found_where_the_axis_moves() {
        assert!(repeats(&read(&[])).is_empty());
        let held = [10..11, 40..43, 300..301];
        assert_eq!(repeats(&read(&held)), held);
        // At a reversal readings rest of themselves; a long rest is no lost sample; nor is what is held throughout.
        let rests = [155..160, 300..330];
        assert!(rests.chunks(1).all(|rest| repeats(&read(rest)).is_empty()));
        assert!(repeats(&read(&(1..500).map(|k| 2 * k..2 * k + 1).collect::<Vec<_>>())).is_empty());
        assert!(repeats(&[]).is_empty() && repeats(&[1.0; 9]).is_empty());
    }
}
