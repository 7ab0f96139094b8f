//! What the recorded position tells by itself: a reference where none was logged, and the states at which windows
//! begin.

use super::smooth::{HALF_WIDTH_S, smooth};
use crate::replay::windows::{Input, Restart};

/// Length of a window in s: beside it a noisy start dies out, and errors of force have time to show as motion, but not
/// to carry friction into another regime than the measured one.
const WINDOW_S: f64 = 0.25;
/// The same where a measured current drives the twin: its sensor's noise adds up along a window like a random walk. What
/// windows tell of a force does not depend on their length then, but many short ones tell better how large the noise is.
const NOISY_WINDOW_S: f64 = 0.1;
/// Fewer samples do not determine a window's initial state well against what they say of forces.
const LEAST_SAMPLES: usize = 50;
/// A window may begin earlier or later by this share of its length, where the motion is calm.
const PLAY: f64 = 0.2;

/// Half width in samples of the parabolas from which a state is read.
pub fn half_width(period_s: f64) -> usize {
    ((HALF_WIDTH_S / period_s).round() as usize).max(3)
}

/// States at which windows begin for a replay driven by `input`.
///
/// # Model
/// Position and velocity are value and slope of a parabola through the positions around the sample. A jump of the
/// acceleration spoils them: of the samples near the place wanted, the one is taken around which parabolas fit best.
pub fn restarts(position: &[f64], input: Input, period_s: f64) -> Vec<Restart> {
    let half = half_width(period_s);
    let [value, slope, _] = smooth(position, half, period_s);
    let misfit = misfit(position, &value, half);
    let window_s = if input == Input::Current { NOISY_WINDOW_S } else { WINDOW_S };
    let length = ((window_s / period_s).round() as usize).max(LEAST_SAMPLES);
    let play = (PLAY * length as f64) as usize;
    let mut starts = vec![0];
    let mut wanted = length;
    while wanted + length / 2 < position.len() {
        let near = wanted - play..wanted + play + 1;
        let calm = near.min_by(|&a, &b| misfit[a].total_cmp(&misfit[b])).unwrap_or(wanted);
        starts.push(calm);
        wanted = calm + length;
    }
    starts.into_iter().map(|k| Restart { sample: k, position: value[k], velocity: slope[k] }).collect()
}

/// Mean square by which parabolas miss the positions within `half` samples of each.
fn misfit(position: &[f64], value: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    for (x, smooth) in position.iter().zip(value) {
        sums.push(sums[sums.len() - 1] + (x - smooth).powi(2));
    }
    (0..position.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(half), (k + half + 1).min(position.len()));
            (sums[to] - sums[from]).max(0.0) / (to - from) as f64
        })
        .collect()
}

/// Half width in s of the smoothing from which phases of a motion are read.
const PHASE_HALF_WIDTH_S: f64 = 15e-3;
/// An axis slower than so many standard errors of its measured velocity stands still, …
const STILL_STANDARD_ERRORS: f64 = 5.0;
/// … and so does one slower than this share of its largest speed.
const STILL_SHARE: f64 = 5e-3;

/// A position reference read off the measured position: its smoothed velocity, exactly zero at standstill, summed up.
pub fn reference(position: &[f64], period_s: f64) -> Vec<f64> {
    let half =
        ((PHASE_HALF_WIDTH_S / period_s).round() as usize).max(3).min(position.len().saturating_sub(1) / 2);
    let [value, velocity, _] = smooth(position, half, period_s);
    let mut squares: Vec<f64> = position.iter().zip(&value).map(|(x, s)| (x - s).powi(2)).collect();
    let middle = squares.len() / 2;
    let sigma = squares.select_nth_unstable_by(middle, f64::total_cmp).1.sqrt();
    // Standard error of the slope of 2·half + 1 evenly spaced samples.
    let error = sigma * (12.0 / (2.0 * half as f64 + 1.0).powi(3)).sqrt() / period_s;
    let fastest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let still = (STILL_STANDARD_ERRORS * error).max(STILL_SHARE * fastest);
    let mut at = value[0];
    velocity
        .iter()
        .enumerate()
        .map(|(k, v)| {
            if k > 0 && v.abs() > still {
                at += v * period_s;
            }
            at
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 1e-3;

    /// 0.5 s at rest, 0.5 s at 0.1 m/s, 0.5 s at rest.
    fn travel() -> Vec<f64> {
        (0..1500).map(|k| 0.1 * (f64::from(k) * PERIOD - 0.5).clamp(0.0, 0.5)).collect()
    }

    #[test]
    fn exact_windows_begin_where_the_motion_is_a_parabola() {
        let starts = restarts(&travel(), Input::Effort, PERIOD);
        assert!(starts.len() >= 5 && starts[0].sample == 0);
        for start in starts {
            let moves = (510..=990).contains(&start.sample);
            assert!((start.velocity - if moves { 0.1 } else { 0.0 }).abs() < 1e-9, "{start:?}");
        }
    }

    #[test]
    fn exact_a_reference_stands_where_the_axis_stands() {
        let read = reference(&travel(), PERIOD);
        assert!(read[..480].windows(2).chain(read[1020..].windows(2)).all(|w| w[0] == w[1]));
        assert!((read[1499] - read[0] - 0.05).abs() < 1e-3);
    }

    #[test]
    fn exact_noise_at_standstill_is_no_motion() {
        // A fixed sequence that fills an interval evenly: Weyl's.
        let noise: Vec<f64> = (0..1000).map(|k| 1e-7 * (0.618_034 * f64::from(k)).fract()).collect();
        let read = reference(&noise, PERIOD);
        assert!(read.iter().all(|x| *x == read[0]));
    }
}
