//! Frequency response from a recording, without a model.

use std::f64::consts::TAU;

use nalgebra::Complex;
use serde::Serialize;

use super::check;
use crate::error::{Error, ErrorKind, Result};

/// Fewest segments for which a coherence means anything (with one segment it is 1 by construction).
pub const LEAST_SEGMENTS: usize = 4;

/// The measured response at one frequency.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Point {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Real part of output over input.
    pub re: f64,
    /// Imaginary part of output over input.
    pub im: f64,
    /// Coherence γ², 0 to 1: the share of the output's power that the input explains linearly.
    pub coherence: f64,
}

impl Point {
    /// Output over input.
    pub fn response(&self) -> Complex<f64> {
        Complex::new(self.re, self.im)
    }
}

/// Frequency response H₁ with coherence by averaged windowed periodograms (Welch), segments overlapping by
/// half.
///
/// # Model
/// H₁ = S_uy/S_uu, γ² = |S_uy|²/(S_uu·S_yy), from segments of `segment_length` samples less their mean, under
/// a Hann window. Frequencies m/(segment_length·Ts) for m = 1 … segment_length/2.
///
/// # Validity
/// Noise on the output only, segments much longer than the impulse response. In closed loop H₁ leans towards
/// the negative inverse of the controller where the noise outweighs the excitation. Look at the coherence
/// first: at a frequency that the input does not contain the response is noise over nothing.
///
/// # Source
/// Welch, IEEE Trans. Audio Electroacoust. 15, 1967; Bendat, Piersol, Random Data, section 6.
///
/// # Errors
/// Signals of unequal length; numbers that are not finite; fewer than four segments; segments below 8
/// samples.
pub fn welch(
    input: &[f64],
    output: &[f64],
    sample_period_s: f64,
    segment_length: usize,
) -> Result<Vec<Point>> {
    check::sample_period(sample_period_s)?;
    check::same_length("input", input, "output", output)?;
    check::finite("input", input)?;
    check::finite("output", output)?;
    let starts = segment_starts(input.len(), segment_length)?;
    // one turn of the circle, from which every bin picks its phases
    let circle: Vec<_> = (0..segment_length)
        .map(|k| Complex::from_polar(1.0, -TAU * k as f64 / segment_length as f64))
        .collect();
    let window: Vec<f64> = circle.iter().map(|z| 0.5 * (1.0 - z.re)).collect();
    let cut = |signal: &[f64]| -> Vec<Vec<f64>> {
        starts.iter().map(|&s| windowed(&signal[s..s + segment_length], &window)).collect()
    };
    let (inputs, outputs) = (cut(input), cut(output));
    let step_hz = 1.0 / (segment_length as f64 * sample_period_s);
    Ok((1..=segment_length / 2)
        .map(|bin| {
            let (mut s_uu, mut s_yy, mut s_uy) = (0.0, 0.0, Complex::new(0.0, 0.0));
            for (u, y) in inputs.iter().zip(&outputs) {
                let (u, y) = (transform(u, bin, &circle), transform(y, bin, &circle));
                s_uu += u.norm_sqr();
                s_yy += y.norm_sqr();
                s_uy += u.conj() * y;
            }
            let response = if s_uu > 0.0 { s_uy / s_uu } else { Complex::new(0.0, 0.0) };
            let power = s_uu * s_yy;
            let coherence = if power > 0.0 { s_uy.norm_sqr() / power } else { 0.0 };
            Point { frequency_hz: bin as f64 * step_hz, re: response.re, im: response.im, coherence }
        })
        .collect())
}

fn segment_starts(samples: usize, segment_length: usize) -> Result<Vec<usize>> {
    let refuse = |kind, found: String, expected: String| {
        Err(Error::new(kind)
            .key("segment_length")
            .found(found)
            .expected(expected)
            .remedy("record longer, or ask for shorter segments (coarser frequency steps)"))
    };
    if segment_length < 8 {
        return refuse(ErrorKind::OutOfRange, segment_length.to_string(), "at least 8 samples".into());
    }
    let hop = segment_length / 2;
    let starts: Vec<_> = (0..).map(|m| m * hop).take_while(|s| s + segment_length <= samples).collect();
    if starts.len() < LEAST_SEGMENTS {
        return refuse(
            ErrorKind::TooLittleData,
            format!("{} segments of {segment_length} in {samples} samples", starts.len()),
            format!("at least {LEAST_SEGMENTS} half-overlapping segments"),
        );
    }
    Ok(starts)
}

fn windowed(segment: &[f64], window: &[f64]) -> Vec<f64> {
    let mean = segment.iter().sum::<f64>() / segment.len() as f64;
    segment.iter().zip(window).map(|(x, w)| (x - mean) * w).collect()
}

fn transform(segment: &[f64], bin: usize, circle: &[Complex<f64>]) -> Complex<f64> {
    let mut phase = 0;
    let mut sum = Complex::new(0.0, 0.0);
    for x in segment {
        sum += circle[phase] * *x;
        phase += bin;
        if phase >= circle.len() {
            phase -= circle.len();
        }
    }
    sum
}
