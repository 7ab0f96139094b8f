//! Periods of a reading's error that are short against the travel, from what the replays of a fit leave of the position.

use super::estimate::relax::{Spectrum, refined};
use super::experiment::Experiment;
use super::ordinates::OVERSAMPLING;
use super::thresholds::SIGNIFICANCE;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::axis::LONGEST_STEP_S;
use crate::recording::Signal;
use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;
use realfft::RealFftPlanner;
use std::f64::consts::{LN_2, PI, TAU};

/// Samples on either side of one whose mean is taken out, so that changes faster than some twentieth of the sampling rate stay. A choice of cost: periods
/// that pass slower are looked for through the twin's own loop.
const HALF_WIDTH: usize = 10;
/// Samples with less than this share of the largest speed rest or turn, and are left out: many residuals at one place have power at all spatial frequencies.
/// An estimate, that starts of fits depend on and no verdict.
const MOVING: f64 = 0.05;
/// Longer periods are looked for through the twin's own loop, see [`PitchSearch`](super::pitch_search::PitchSearch).
const FEWEST_PERIODS: f64 = 7.0;
/// Bins a period, at least: a nearest bin then leaves nine tenths of its amplitude.
const BINS_A_PERIOD: f64 = 4.0;
/// Bins at most, as a power of two: a transform of 2²¹ numbers takes some 20 ms.
const MOST_BINS_LOG2: u32 = 19;
/// Ordinates whose median tells a level; one period of the travel has [`OVERSAMPLING`] of them, a line two.
const BAND: usize = 64 * OVERSAMPLING;
/// Position and what is left of it, one a moving sample.
type Points = Vec<(f64, f64)>;

/// Starting values (period, sine, cosine) of an error of the reading with a period from `shortest` to a seventh of the travel, at most so many; the
/// machine is as fitted, and readings lie on a grid of this step, if on one.
///
/// # Model
/// An encoder reads `x + s·sin(2πx/p) + c·cos(2πx/p)`. Periods pass a moving axis faster than its loop follows, so that the error stands in the
/// position residual, and seen over place it has one line at 1/p however often sampling has folded it in time: the residuals, without what changes slowly in
/// time, are added up in bins of place and transformed. A line is what noise makes with a probability of 5 % at one of all frequencies, against the median of the
/// ordinates around it; the lines that stand out most are refined, and s, c follow by least squares.
///
/// # Validity
/// Amplitudes far below p, and above q/π where readings lie on a grid of step q: that is the first harmonic of rounding, which an even pace folds into
/// lines. Amplitudes of periods that take more than some 20 samples to pass begin too small. Where one speed prevails, lines that sampling folds into one another
/// cannot be told apart.
///
/// # Source
/// N. R. Lomb (1976), Astrophys. Space Sci. 39:447; J. D. Scargle (1982), Astrophys. J. 263:835, the probability of a line; over place instead of time.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub(super) fn periods(
    machine: &Machine,
    experiments: &[Experiment],
    shortest: f64,
    step: Option<f64>,
    most: usize,
) -> Result<Vec<[f64; 3]>> {
    let of_run = |experiment: &Experiment| -> Result<Points> {
        let predicted = experiment.predict_together(std::slice::from_ref(machine), LONGEST_STEP_S)?;
        let predicted = predicted.first().and_then(|traces| traces.signal(Signal::Position));
        let measured = experiment.run().signal(Signal::Position);
        Ok(measured.zip(predicted).map(|(measured, predicted)| left(measured, predicted)).unwrap_or_default())
    };
    let with_position = experiments.par_iter().filter(|e| e.signals().contains(&Signal::Position));
    let points = with_position.map(of_run).collect::<Result<Vec<Points>>>()?.concat();
    let rounding = step.unwrap_or(0.0) / PI;
    let is_more = |[_, sine, cosine]: &[f64; 3]| sine.hypot(*cosine) > rounding;
    Ok(lines(&points, shortest, most).into_iter().filter(is_more).collect())
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

/// The lines of residuals over place, the one that stands out most first.
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
    let chance = (range.len().max(1) as f64 / SIGNIFICANCE).ln();
    let is_peak = |&k: &usize| {
        let own = k.saturating_sub(OVERSAMPLING)..(k + OVERSAMPLING + 1).min(power.len());
        own.into_iter().all(|j| power[j] <= power[k])
    };
    let levels: Vec<f64> = power.chunks(BAND).map(level).collect();
    // On a slope the side from which a line must stand out, as `ordinates::around` has it.
    let beside = |band: usize| levels[band.saturating_sub(1)..(band + 2).min(levels.len())].iter().copied();
    let around: Vec<f64> =
        (0..levels.len()).map(|band| beside(band).fold(f64::MIN_POSITIVE, f64::max)).collect();
    let stands_out = |k: usize| power[k] / around[k / BAND];
    let mut lines: Vec<usize> = range.filter(is_peak).filter(|&k| stands_out(k) > chance).collect();
    lines.sort_by(|&a, &b| stands_out(b).total_cmp(&stands_out(a)));
    let over_place = OverPlace { points, least: [FEWEST_PERIODS / travel], spacing };
    let wave = |k: usize| over_place.wave(refined(&over_place, k as f64 * spacing, &()));
    lines.into_iter().take(most).filter_map(wave).collect()
}

/// Mean of the ordinates of noise in a band that may hold lines: they are exponential, with a median of ln 2 of their mean.
fn level(band: &[f64]) -> f64 {
    let mut band = band.to_vec();
    let middle = band.len() / 2;
    *band.select_nth_unstable_by(middle, f64::total_cmp).1 / LN_2
}

/// Squared magnitudes of the transform of residuals that are added up in bins of place, [`OVERSAMPLING`] of them a period of the travel.
fn transformed(points: &Points, low: f64, per_length: f64, bins: usize) -> Vec<f64> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(OVERSAMPLING * bins);
    let (mut input, mut output) = (plan.make_input_vec(), plan.make_output_vec());
    for (place, rest) in points {
        input[(((place - low) * per_length) as usize).min(bins - 1)] += rest;
    }
    // Lengths are those of the plan's own vectors.
    if plan.process(&mut input, &mut output).is_err() {
        return Vec::new();
    }
    output.iter().map(|ordinate| ordinate.norm_sqr()).collect()
}

/// Residuals over place, near a spatial frequency.
struct OverPlace<'a> {
    points: &'a Points,
    /// The lowest frequency that is looked at.
    least: [f64; 1],
    spacing: f64,
}

impl OverPlace<'_> {
    /// The wave of a spatial frequency by least squares, as a law has it; none where the points do not tell sine from cosine.
    fn wave(&self, frequency: f64) -> Option<[f64; 3]> {
        let (_, [sine, cosine]) = self.explained(frequency)?;
        Some([1.0 / frequency, sine, cosine])
    }

    /// What a wave explains of the squares, and its sine and cosine.
    fn explained(&self, frequency: f64) -> Option<(f64, [f64; 2])> {
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for (place, rest) in self.points {
            let (sine, cosine) = (TAU * frequency * place).sin_cos();
            let column = Vector2::new(sine, cosine);
            normal += column * column.transpose();
            right += column * *rest;
        }
        let solved = normal.try_inverse()? * right;
        Some((solved.dot(&right), [solved[0], solved[1]]))
    }
}

impl Spectrum for OverPlace<'_> {
    type Beside = ();

    fn frequencies(&self) -> &[f64] {
        &self.least
    }

    fn spacing(&self) -> f64 {
        self.spacing
    }

    fn beside(&self, _frequencies: &[f64]) {}

    fn gain(&self, frequency: f64, _beside: &()) -> f64 {
        self.explained(frequency).map_or(0.0, |(gain, _)| gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    /// Strokes of 50 mm at 64 and 110 mm/s read at 4 kHz, every 16 and 27 µm, with noise of 42 nm and this error of the reading.
    fn strokes(seed: u64, error: impl Fn(f64, f64) -> f64) -> Points {
        let mut random = StdRng::seed_from_u64(seed);
        let mut points = Points::new();
        for speed in [0.064, -0.11] {
            let count = (0.05 / f64::abs(speed) * 4000.0) as usize;
            // An axis never runs as evenly as its reference.
            let at = |k: usize| {
                k as f64 * speed / 4000.0 + 4e-5 * (0.02 * k as f64).sin() + f64::from(speed < 0.0) * 0.05
            };
            let predicted: Vec<f64> = (0..count).map(at).collect();
            let noise = |random: &mut StdRng| 42e-9 * 3.0_f64.sqrt() * random.random_range(-1.0..=1.0);
            let read = |(k, x): (usize, &f64)| x + error(*x, k as f64 / 4000.0) + noise(&mut random);
            let measured: Vec<f64> = predicted.iter().enumerate().map(read).collect();
            points.extend(left(&measured, &predicted));
        }
        points
    }

    /// A signal period of 20 µm, of which sampling sees one and a quarter and less.
    #[test]
    fn exact_a_period_shorter_than_two_samples_is_found_over_place() {
        let (period, sine, cosine) = (20e-6, 60e-9, -30e-9);
        let wave = |x: f64, _: f64| sine * (TAU * x / period).sin() + cosine * (TAU * x / period).cos();
        let found = lines(&strokes(7, wave), 1e-6, 3);
        let near = found.first().unwrap();
        // A tenth of a period over the travel.
        assert!((1.0 / near[0] - 1.0 / period).abs() < 0.1 / 0.05, "{found:?}");
        let size = near[1].hypot(near[2]);
        assert!((size / f64::hypot(sine, cosine) - 1.0).abs() < 0.2, "{found:?}");
    }

    /// Of noise alone a line comes in one of twenty cases or fewer; what moves slowly makes none, and nothing at all has none.
    #[test]
    fn exact_noise_and_what_is_slow_have_no_line() {
        let falses = (0..60).filter(|&seed| !lines(&strokes(seed, |_, _| 0.0), 1e-6, 3).is_empty()).count();
        assert!(falses <= 6, "{falses}"); // of a mean of 3 at most: 7 and more in 3 % of cases
        assert!(lines(&strokes(7, |x, _| 3e-6 * (TAU * x / 0.02).sin()), 1e-6, 3).is_empty());
        assert!(lines(&Points::new(), 1e-6, 3).is_empty());
    }

    /// Beside a mode that leaves thirty times as much, in another band.
    #[test]
    fn exact_a_weak_line_is_found_beside_a_strong_band() {
        let error = |x: f64, t: f64| {
            let band: f64 =
                (0..40).map(|k| (TAU * (150.0 + 0.25 * f64::from(k)) * t + f64::from(k * k)).sin()).sum();
            70e-9 * (TAU * x / 20e-6).sin() + 0.5e-6 * band
        };
        let found = lines(&strokes(7, error), 1e-6, 3);
        assert!(found.iter().any(|[period, ..]| (period / 20e-6 - 1.0).abs() < 1e-4), "{found:?}");
    }
}
