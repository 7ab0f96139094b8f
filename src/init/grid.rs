//! The grid and the noise that readings show.

use crate::recording::{Run, Signal};

/// A reading lies on a grid where it is off by less than this share of the step, as printed digits leave it.
const ON_GRID: f64 = 0.05;
/// So many readings must lie on it, …
const LEAST_ON: f64 = 0.999;
/// … and so many different ones are needed to tell.
const LEAST_LEVELS: usize = 20;
/// Readings in one window of which the scatter is taken.
const WINDOW: usize = 64;
/// White noise of σ has fourth differences of √70·σ.
const FOURTH: f64 = 70.0;

/// The step of the positions of all runs; none where they lie on no grid.
pub fn step(runs: &[Run]) -> Option<f64> {
    let positions = || runs.iter().filter_map(|run| run.signal(Signal::Position));
    let moves = |x: &[f64]| x.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect::<Vec<f64>>();
    let mut moved: Vec<f64> = positions().flat_map(moves).collect();
    let largest = moved.iter().copied().fold(0.0, f64::max);
    moved.retain(|step| *step > 1e-9 * largest);
    moved.sort_by(f64::total_cmp);
    let least = *moved.first()?;
    // The least move may be more than one step, and is off by its rounding: the mean of those near it is not.
    let near: Vec<f64> = moved.iter().copied().take_while(|step| *step < 1.5 * least).collect();
    let step = round_to(near.iter().sum::<f64>() / near.len() as f64);
    let levels =
        moved.iter().map(|moved| (moved / step).round() as i64).collect::<std::collections::BTreeSet<_>>();
    let of_all = moved.len() as f64;
    let is_on = |moved: &&f64| ((**moved / step) - (**moved / step).round()).abs() < ON_GRID;
    let on = moved.iter().filter(is_on).count() as f64;
    (levels.len() >= LEAST_LEVELS && on >= LEAST_ON * of_all).then_some(step)
}

/// A number to six significant digits: what a file prints of a step.
fn round_to(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number)
}

/// σ of the position readings, grid and noise together.
pub fn reading_noise(runs: &[Run]) -> f64 {
    scatter(runs, Signal::Position)
}

/// σ of white noise in a signal: the median over short windows of what its fourth differences show, to which smooth motion adds
/// next to nothing.
pub fn scatter(runs: &[Run], signal: Signal) -> f64 {
    let mut windows: Vec<f64> = Vec::new();
    for samples in runs.iter().filter_map(|run| run.signal(signal)) {
        let fourth: Vec<f64> =
            samples.windows(5).map(|s| s[0] - 4.0 * s[1] + 6.0 * s[2] - 4.0 * s[3] + s[4]).collect();
        windows.extend(
            fourth.chunks_exact(WINDOW).map(|w| w.iter().map(|d| d * d).sum::<f64>() / WINDOW as f64),
        );
    }
    if windows.is_empty() {
        return 0.0;
    }
    let middle = windows.len() / 2;
    (*windows.select_nth_unstable_by(middle, f64::total_cmp).1 / FOURTH).sqrt()
}

/// A limit that the effort is seen to stay at; none where it is not.
pub fn limit(runs: &[Run]) -> Option<f64> {
    /// Samples in a row at the extreme that no law would command.
    const IN_A_ROW: usize = 5;
    let efforts: Vec<&[f64]> = runs.iter().filter_map(|run| run.signal(Signal::ControlEffort)).collect();
    let most = efforts.iter().flat_map(|u| u.iter()).fold(0.0_f64, |most, u| most.max(u.abs()));
    let is_at = |u: &f64| most > 0.0 && u.abs() >= most * (1.0 - 1e-6);
    let stays = |u: &&[f64]| u.windows(IN_A_ROW).any(|w| w.iter().all(is_at));
    efforts.iter().any(stays).then_some(most)
}
