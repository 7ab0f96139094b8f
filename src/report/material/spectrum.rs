//! Spectra of the residuals.

use super::RunTraces;
use crate::recording::Signal;
use crate::units::Motion;
use realfft::RealFftPlanner;

/// Spectral densities of one signal's residual on the held-out runs.
#[derive(Debug, Clone)]
pub struct Spectrum {
    /// The signal.
    pub signal: Signal,
    /// Its SI unit.
    pub unit: &'static str,
    /// Frequency in Hz, twin as it is and with its causes in SI unit per √Hz.
    pub density: Vec<[f64; 3]>,
}

/// Bins a decade.
const BINS: f64 = 24.0;

/// Spectra of every compared signal.
pub fn of(runs: &[RunTraces], motion: Motion) -> Vec<Spectrum> {
    let held_out: Vec<&RunTraces> = runs.iter().filter(|run| run.is_held_out).collect();
    let Some(first) = held_out.first() else { return Vec::new() };
    let spectrum = |signal: Signal| {
        let mut bins: Vec<(i64, [f64; 2], f64)> = Vec::new();
        for (run, trace) in held_out.iter().filter_map(|run| Some((run, run.trace(signal)?))) {
            let [before, after] = [&trace.before, &trace.after].map(|predicted| {
                let residual: Vec<f64> = trace.measured.iter().zip(predicted).map(|(m, p)| m - p).collect();
                density(&residual, run.period_s)
            });
            let resolution = 1.0 / (trace.measured.len() as f64 * run.period_s);
            for (k, (b, a)) in before.iter().zip(&after).enumerate().skip(1) {
                let bin = (BINS * (k as f64 * resolution).log10()).round() as i64;
                match bins.iter_mut().find(|(known, ..)| *known == bin) {
                    Some((_, sum, count)) => {
                        (sum[0], sum[1], *count) = (sum[0] + b, sum[1] + a, *count + 1.0);
                    }
                    None => bins.push((bin, [*b, *a], 1.0)),
                }
            }
        }
        bins.sort_by_key(|(bin, ..)| *bin);
        let density = bins.iter().map(|(bin, sum, count)| {
            [10f64.powf(*bin as f64 / BINS), (sum[0] / count).sqrt(), (sum[1] / count).sqrt()]
        });
        Spectrum { signal, unit: signal.si_unit(motion), density: density.collect() }
    };
    first.traces.iter().map(|trace| spectrum(trace.signal)).collect()
}

/// Power spectral density, one-sided, under a Hann window.
pub(super) fn density(samples: &[f64], period_s: f64) -> Vec<f64> {
    let count = samples.len();
    let mean = samples.iter().sum::<f64>() / count.max(1) as f64;
    let window = |k: usize| 0.5 - 0.5 * (std::f64::consts::TAU * k as f64 / count as f64).cos();
    let mut windowed: Vec<f64> = samples.iter().enumerate().map(|(k, x)| (x - mean) * window(k)).collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
    let mut out = transform.make_output_vec();
    if transform.process(&mut windowed, &mut out).is_err() {
        return Vec::new();
    }
    // The mean square of a Hann window is 3/8.
    let scale = 2.0 * period_s / (0.375 * count as f64);
    out.iter().map(|z| z.norm_sqr() * scale).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_density_holds_the_mean_square() {
        let samples: Vec<f64> = (0..4096).map(|k| (0.3 * f64::from(k)).sin()).collect();
        let total: f64 = density(&samples, 1e-3).iter().sum::<f64>() / (4096.0 * 1e-3);
        assert!((total - 0.5).abs() < 0.01, "{total}");
    }
}
