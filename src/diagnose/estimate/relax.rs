//! Several pitches at once: each is estimated again beside the others until none moves.

use super::periodogram::AS_MUCH;
use rayon::prelude::*;

/// Rounds in which each pitch is estimated again at most.
const MOST_ROUNDS: usize = 8;
/// Spatial frequencies are at rest when none moves by more than this part of the grid's step.
const AT_REST: f64 = 1e-2;
/// Steps of the golden-section search around a frequency of the grid.
const SECTIONS: usize = 12;

/// What waves of a spatial frequency (one over a pitch) explain.
pub trait Spectrum: Sync {
    /// Other waves, as far as a gain beside them needs them.
    type Beside: Sync;

    /// Spatial frequencies that are looked at, evenly spaced and rising.
    fn frequencies(&self) -> &[f64];

    /// From one spatial frequency to the next.
    fn spacing(&self) -> f64;

    /// The waves of these frequencies.
    fn beside(&self, frequencies: &[f64]) -> Self::Beside;

    /// What the waves of a frequency explain beside others.
    fn gain(&self, frequency: f64, beside: &Self::Beside) -> f64;

    /// The gains of all frequencies that are looked at.
    fn gains(&self, beside: &Self::Beside) -> Vec<f64> {
        self.frequencies().par_iter().map(|&f| self.gain(f, beside)).collect()
    }
}

/// `count` spatial frequencies that explain most together, of which this one is the first to be taken.
///
/// # Model
/// RELAX: the pitch that explains most beside the others is added until there are `count`, then each is estimated again beside all
/// others, in the whole grid once and around its place thereafter, until none moves. Within a travel of few periods a wave
/// estimated alone takes up part of the others, and its second harmonic takes the place of another pitch.
///
/// # Source
/// Li, Stoica (1996), *Efficient mixed-spectrum estimation with applications to target feature extraction*, IEEE Trans. Signal
/// Process. 44:281; over position instead of time, each wave with two harmonics.
pub fn relaxed(spectrum: &impl Spectrum, first: f64, count: usize) -> Vec<f64> {
    let mut frequencies = vec![first];
    while frequencies.len() < count {
        frequencies.push(strongest(spectrum, &spectrum.beside(&frequencies)));
    }
    round(spectrum, &mut frequencies, |_, others| strongest(spectrum, others));
    settled(spectrum, frequencies)
}

/// Spatial frequencies of which each is estimated again beside all others, around its place, until none moves.
fn settled(spectrum: &impl Spectrum, mut frequencies: Vec<f64>) -> Vec<f64> {
    for _ in 1..MOST_ROUNDS {
        let before = frequencies.clone();
        let again = |f, others: &_| undoubled(spectrum, refined(spectrum, f, others), others);
        round(spectrum, &mut frequencies, again);
        if is_same(spectrum, &before, &frequencies) {
            break;
        }
    }
    frequencies
}

/// Each frequency once more, from itself and what the others are.
fn round<S: Spectrum>(spectrum: &S, frequencies: &mut [f64], again: impl Fn(f64, &S::Beside) -> f64) {
    for k in 0..frequencies.len() {
        let others = frequencies.iter().enumerate().filter(|(j, _)| *j != k);
        let others: Vec<f64> = others.map(|(_, f)| *f).collect();
        frequencies[k] = again(frequencies[k], &spectrum.beside(&others));
    }
}

/// Whether two lists of frequencies are one.
pub fn is_same(spectrum: &impl Spectrum, some: &[f64], others: &[f64]) -> bool {
    some.iter().zip(others).all(|(a, b)| (a - b).abs() <= AT_REST * spectrum.spacing())
}

/// The frequency that explains most beside others.
fn strongest<S: Spectrum>(spectrum: &S, beside: &S::Beside) -> f64 {
    let gains = spectrum.gains(beside);
    let best = spectrum.frequencies().iter().zip(gains).max_by(|a, b| a.1.total_cmp(&b.1));
    let best = best.map_or(0.0, |(f, _)| *f);
    undoubled(spectrum, refined(spectrum, best, beside), beside)
}

/// A frequency, or its second harmonic where that explains as much by itself.
pub fn undoubled<S: Spectrum>(spectrum: &S, mut frequency: f64, beside: &S::Beside) -> f64 {
    let highest = spectrum.frequencies().last().copied().unwrap_or(frequency);
    let explains_as_much = |f: f64| spectrum.gain(2.0 * f, beside) > AS_MUCH * spectrum.gain(f, beside);
    while 2.0 * frequency <= highest && explains_as_much(frequency) {
        frequency = refined(spectrum, 2.0 * frequency, beside);
    }
    frequency
}

/// The frequency that explains most within one step of the grid, by golden section.
pub fn refined<S: Spectrum>(spectrum: &S, frequency: f64, beside: &S::Beside) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (lowest, step) = (spectrum.frequencies().first().copied().unwrap_or(frequency), spectrum.spacing());
    let (mut low, mut high) = ((frequency - step).max(lowest), frequency + step);
    let inner = |low: f64, high: f64| [high - golden * (high - low), low + golden * (high - low)];
    let [mut a, mut b] = inner(low, high);
    let (mut at_a, mut at_b) = (spectrum.gain(a, beside), spectrum.gain(b, beside));
    for _ in 0..SECTIONS {
        if at_a > at_b {
            (high, b, at_b) = (b, a, at_a);
            a = inner(low, high)[0];
            at_a = spectrum.gain(a, beside);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = inner(low, high)[1];
            at_b = spectrum.gain(b, beside);
        }
    }
    0.5 * (low + high)
}
