//! A random input as a signal generator makes it.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::TAU;

/// White noise through two first-order low-passes of a corner frequency, of this RMS value, sampled at a period.
pub fn random(seed: u64, [seconds, period_s]: [f64; 2], corner_hz: f64, rms: f64) -> Vec<f64> {
    let (mut draw, share) = (StdRng::seed_from_u64(seed), 1.0 - (-TAU * corner_hz * period_s).exp());
    let (mut a, mut b) = (0.0, 0.0);
    let samples: Vec<f64> = (0..(seconds / period_s) as usize)
        .map(|_| {
            a += share * (draw.random_range(-1.0..1.0) - a);
            b += share * (a - b);
            b
        })
        .collect();
    let size = (samples.iter().map(|x| x * x).sum::<f64>() / samples.len() as f64).sqrt();
    samples.into_iter().map(|x| x * rms / size).collect()
}
