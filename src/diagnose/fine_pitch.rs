//! Periods of a reading's error that are short against the travel, from what the replays of a fit leave of the position.

use super::experiment::Experiment;
use super::ordinates::{OVERSAMPLING, around};
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::axis::LONGEST_STEP_S;
use crate::recording::Signal;
use nalgebra::{Matrix2, Vector2};
use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Samples on either side of one whose mean is taken out: what changes slower is not a fine period.
const HALF_WIDTH: usize = 10;
/// Samples with less than this share of the largest speed rest or turn: many of them at one place look alike at all spatial frequencies.
const MOVING: f64 = 0.05;
/// Longer periods of the travel are looked for by other means, see [`PitchSearch`](super::pitch_search::PitchSearch).
const FEWEST_PERIODS: f64 = 20.0;
/// Bins a period, at least: a nearest bin then leaves nine tenths of its amplitude.
const BINS_A_PERIOD: f64 = 4.0;
/// Bins at most, as a power of two: a transform of 2²¹ numbers takes some 20 ms.
const MOST_BINS_LOG2: u32 = 19;
/// Probability that noise alone makes a line.
const CHANCE: f64 = 0.05;
/// Ordinates that are compared with their neighbours at most, the largest.
const MOST_PEAKS: usize = 40;
/// Places of neighbours of a line, from and to, of which one period of the travel has [`OVERSAMPLING`].
const NEIGHBOURS: [usize; 2] = [4 * OVERSAMPLING, 16 * OVERSAMPLING];
/// Halvings of a spatial frequency's bracket.
const SECTIONS: usize = 12;

/// Position and what is left of it, one a moving sample.
type Points = Vec<(f64, f64)>;

/// Starting values (period, sine, cosine) of an error of the reading with a period from `shortest` to a twentieth of the travel, at most so many; the
/// machine is as fitted.
///
/// # Model
/// An encoder reads `x + s·sin(2πx/p) + c·cos(2πx/p)`. Periods pass a moving axis faster than its loop follows, so that the error stands in the
/// position residual as it is, and seen over place it has one line at 1/p however often sampling has folded it in time: the residuals, without what changes slowly in
/// time, are added up in bins of place and transformed. A line is what noise makes with a probability of 5 % at one of all frequencies; the frequency of the
/// largest of them is refined and s, c follow by least squares.
///
/// # Validity
/// Amplitudes far below p. Where one speed prevails, a line and those folded from it are equals: all of them are given, a fit decides.
///
/// # Source
/// Lomb (1976), Scargle (1982), *Studies in astronomical time series analysis II*, Astrophys. J. 263:835: the probability of a line; over place instead of time.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub(super) fn periods(
    machine: &Machine,
    experiments: &[Experiment],
    shortest: f64,
    most: usize,
) -> Result<Vec<[f64; 3]>> {
    let mut points = Points::new();
    for experiment in experiments.iter().filter(|e| e.signals().contains(&Signal::Position)) {
        let predicted = experiment.predict_together(std::slice::from_ref(machine), LONGEST_STEP_S)?;
        let predicted = predicted.first().and_then(|traces| traces.signal(Signal::Position));
        if let (Some(measured), Some(predicted)) = (experiment.run().signal(Signal::Position), predicted) {
            points.extend(left(measured, predicted));
        }
    }
    Ok(lines(&points, shortest, most))
}

/// What changes fast in the residual of a run's position where it moves.
fn left(measured: &[f64], predicted: &[f64]) -> Points {
    let residuals: Vec<f64> = measured.iter().zip(predicted).map(|(m, p)| m - p).collect();
    let width = 2 * HALF_WIDTH + 1;
    let travel = |window: &[f64]| (window[width - 1] - window[0]).abs();
    let fastest = predicted.windows(width).map(travel).fold(0.0, f64::max);
    let windows = predicted.windows(width).zip(residuals.windows(width)).enumerate();
    windows
        .filter(|(_, (places, _))| travel(places) > MOVING * fastest)
        .map(|(k, (_, near))| {
            let mean = near.iter().sum::<f64>() / width as f64;
            (measured[k + HALF_WIDTH], near[HALF_WIDTH] - mean)
        })
        .filter(|(place, rest)| place.is_finite() && rest.is_finite())
        .collect()
}

/// The lines of residuals over place, the largest first.
fn lines(points: &Points, shortest: f64, most: usize) -> Vec<[f64; 3]> {
    let places = || points.iter().map(|(place, _)| *place);
    let (low, high) = (places().fold(f64::MAX, f64::min), places().fold(f64::MIN, f64::max));
    let travel = high - low;
    if !(travel > 0.0 && shortest > 0.0) {
        return Vec::new();
    }
    let wanted = (BINS_A_PERIOD * travel / shortest).log2().ceil();
    let bins = 1_usize << (wanted.max(1.0) as u32).min(MOST_BINS_LOG2);
    let power = transformed(points, low, bins as f64 / travel, bins);
    let spacing = 1.0 / (OVERSAMPLING as f64 * travel);
    // Of fewer bins than were wanted, longer periods.
    let to = (1.0 / shortest).min(bins as f64 / (BINS_A_PERIOD * travel));
    let range = (FEWEST_PERIODS * OVERSAMPLING as f64) as usize..((to / spacing) as usize).min(power.len());
    let chance = (range.len().max(1) as f64 / CHANCE).ln();
    let is_peak = |&k: &usize| {
        let own = k.saturating_sub(OVERSAMPLING)..(k + OVERSAMPLING + 1).min(power.len());
        own.into_iter().all(|j| power[j] <= power[k])
    };
    let mut peaks: Vec<usize> = range.filter(is_peak).collect();
    peaks.sort_by(|&a, &b| power[b].total_cmp(&power[a]));
    // Of noise ordinates are exponential, with a median of ln 2 of their mean.
    let is_line = |&k: &usize| {
        let level = around(&power, k, NEIGHBOURS, 1).map(|median| median / std::f64::consts::LN_2);
        level.is_some_and(|level| power[k] > chance * level)
    };
    let found = peaks.into_iter().take(MOST_PEAKS).filter(is_line).take(most);
    found.filter_map(|k| refined(points, k as f64 * spacing, spacing)).collect()
}

/// Squared magnitudes of the transform of residuals that are added up in bins of place, [`OVERSAMPLING`] of them a period of the travel.
fn transformed(points: &Points, low: f64, per_metre: f64, bins: usize) -> Vec<f64> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(OVERSAMPLING * bins);
    let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
    for (place, rest) in points {
        input[(((place - low) * per_metre) as usize).min(bins - 1)] += rest;
    }
    // Lengths are those of the plan's own vectors.
    if plan.process(&mut input, &mut output).is_err() {
        return Vec::new();
    }
    output.iter().map(|ordinate| ordinate.norm_sqr()).collect()
}

/// The wave near a spatial frequency that explains most, by golden section; none where the points do not tell sine from cosine.
fn refined(points: &Points, frequency: f64, spacing: f64) -> Option<[f64; 3]> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let gain = |f: f64| wave(points, f).map_or(0.0, |(gain, _)| gain);
    let (mut low, mut high) = (frequency - spacing, frequency + spacing);
    for _ in 0..SECTIONS {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if gain(a) > gain(b) { high = b } else { low = a }
    }
    let frequency = 0.5 * (low + high);
    let (_, [sine, cosine]) = wave(points, frequency)?;
    Some([1.0 / frequency, sine, cosine])
}

/// What a wave of a spatial frequency explains of the squares, and its sine and cosine.
fn wave(points: &Points, frequency: f64) -> Option<(f64, [f64; 2])> {
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for (place, rest) in points {
        let (sine, cosine) = (TAU * frequency * place).sin_cos();
        let column = Vector2::new(sine, cosine);
        normal += column * column.transpose();
        right += column * *rest;
    }
    let solved = normal.try_inverse()? * right;
    Some((solved.dot(&right), [solved[0], solved[1]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    /// Strokes of 50 mm at 64 and 110 mm/s read at 4 kHz, every 16 and 27 µm, with noise of 42 nm and this error of the reading.
    fn strokes(error: impl Fn(f64) -> f64) -> Points {
        let mut random = StdRng::seed_from_u64(7);
        let mut points = Points::new();
        for speed in [0.064, -0.11] {
            let count = (0.05 / f64::abs(speed) * 4000.0) as usize;
            // An axis never runs as evenly as its reference.
            let at = |k: usize| {
                k as f64 * speed / 4000.0 + 4e-5 * (0.02 * k as f64).sin() + f64::from(speed < 0.0) * 0.05
            };
            let predicted: Vec<f64> = (0..count).map(at).collect();
            let noise = |random: &mut StdRng| 42e-9 * 3.0_f64.sqrt() * random.random_range(-1.0..=1.0);
            let measured: Vec<f64> = predicted.iter().map(|x| x + error(*x) + noise(&mut random)).collect();
            points.extend(left(&measured, &predicted));
        }
        points
    }

    /// A signal period of 20 µm, of which sampling sees one and a quarter and less.
    #[test]
    fn exact_a_period_shorter_than_two_samples_is_found_over_place() {
        let (period, sine, cosine) = (20e-6, 60e-9, -30e-9);
        let wave = |x: f64| sine * (TAU * x / period).sin() + cosine * (TAU * x / period).cos();
        let found = lines(&strokes(wave), 1e-6, 3);
        let near = found.first().unwrap();
        // A tenth of a period over the travel.
        assert!((1.0 / near[0] - 1.0 / period).abs() < 0.1 / 0.05, "{found:?}");
        let size = near[1].hypot(near[2]);
        assert!((size / f64::hypot(sine, cosine) - 1.0).abs() < 0.2, "{found:?}");
    }

    /// Noise alone makes no line in one of twenty cases; what moves slowly makes none.
    #[test]
    fn exact_noise_and_what_is_slow_have_no_line() {
        for slow in [0.0, 3e-6] {
            assert!(lines(&strokes(|x| slow * (TAU * x / 0.02).sin()), 1e-6, 3).is_empty(), "{slow}");
        }
        assert!(lines(&Points::new(), 1e-6, 3).is_empty());
    }
}
