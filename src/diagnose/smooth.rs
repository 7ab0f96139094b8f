//! Value, slope and curvature of sampled signals, by parabolas through neighbouring samples.

use nalgebra::{Matrix3, Vector3};

/// Half width of the smoothing window in s: parabolas over 2 × this pass what is slower than about 100 Hz.
pub(super) const HALF_WIDTH_S: f64 = 4e-3;

/// As [`smooth`], of samples taken at these times, in s.
pub fn smooth_uneven(samples: &[f64], instants_s: &[f64], half: usize) -> [Vec<f64>; 3] {
    let count = samples.len();
    let half = half.min(count.saturating_sub(1) / 2);
    let mut result = [(); 3].map(|()| Vec::with_capacity(count));
    for k in 0..count {
        let window = k.saturating_sub(half)..(k + half + 1).min(count);
        // Σ t^p and Σ t^p·y about the sample itself.
        let (mut powers, mut moments) = ([0.0; 5], Vector3::zeros());
        for j in window {
            let (t, y) = (instants_s[j] - instants_s[k], samples[j] - samples[k]);
            let mut power = 1.0;
            for p in 0..5 {
                powers[p] += power;
                if p < 3 {
                    moments[p] += power * y;
                }
                power *= t;
            }
        }
        let normal = Matrix3::from_fn(|row, column| powers[row + column]);
        let fit = normal.try_inverse().map_or_else(Vector3::zeros, |inverse| inverse * moments);
        for (list, value) in result.iter_mut().zip([samples[k] + fit[0], fit[1], 2.0 * fit[2]]) {
            list.push(value);
        }
    }
    result
}

/// Value, slope and curvature of the least-squares parabola over each window of `2·half + 1` samples; at the
/// ends, where the window is cut, the nearest full window is extended.
pub fn smooth(samples: &[f64], half: usize, period_s: f64) -> [Vec<f64>; 3] {
    let count = samples.len();
    let half = half.min(count.saturating_sub(1) / 2);
    if half == 0 {
        return [samples.to_vec(), vec![0.0; count], vec![0.0; count]];
    }
    let width = (2 * half + 1) as f64;
    let offsets = || (0..=2 * half).map(|j| j as f64 - half as f64);
    let s2: f64 = offsets().map(|j| j * j).sum();
    let s4: f64 = offsets().map(|j| j.powi(4)).sum();
    let determinant = width * s4 - s2 * s2;
    let mut result = [(); 3].map(|()| Vec::with_capacity(count));
    let moments = moments(samples, half);
    for k in 0..count {
        let middle = k.clamp(half, count - 1 - half);
        let base = samples[middle];
        let [m0, m1, m2] = moments.each_ref().map(|of| of[middle - half]);
        let curvature = (width * m2 - s2 * m0) / determinant;
        let slope = m1 / s2;
        let value = (s4 * m0 - s2 * m2) / determinant;
        let away = k as f64 - middle as f64;
        result[0].push(base + value + slope * away + curvature * away * away);
        result[1].push((slope + 2.0 * curvature * away) / period_s);
        result[2].push(2.0 * curvature / (period_s * period_s));
    }
    result
}

/// Σ d, Σ j·d and Σ j²·d of every full window of `2·half + 1` samples, over the places j in it from its middle; d are differences to the middle sample, which keep
/// the digits of a slow, far-travelled axis.
fn moments(samples: &[f64], half: usize) -> [Vec<f64>; 3] {
    let windows = samples.len() - 2 * half;
    let bases = &samples[half..half + windows];
    let mut moments = [(); 3].map(|()| vec![0.0; windows]);
    let [m0, m1, m2] = &mut moments;
    for place in 0..=2 * half {
        let j = place as f64 - half as f64;
        let sums = m0.iter_mut().zip(m1.iter_mut()).zip(m2.iter_mut());
        for (((m0, m1), m2), (y, base)) in sums.zip(samples[place..].iter().zip(bases)) {
            let difference = y - base;
            *m0 += difference;
            *m1 += j * difference;
            *m2 += j * j * difference;
        }
    }
    moments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_parabola_is_read_at_uneven_times() {
        let time: Vec<f64> = (0..60).map(|k| 5e-3 * f64::from(k) + 1e-3 * f64::from(k * k % 5)).collect();
        let samples: Vec<f64> = time.iter().map(|t| 0.3 + 0.2 * t - 4.0 * t * t).collect();
        let [value, slope, curvature] = smooth_uneven(&samples, &time, 4);
        for (k, t) in time.iter().enumerate() {
            assert!((value[k] - samples[k]).abs() < 1e-12 && (slope[k] - (0.2 - 8.0 * t)).abs() < 1e-9);
            assert!((curvature[k] + 8.0).abs() < 1e-6, "{k}");
        }
    }

    #[test]
    fn exact_parabola_is_read_without_error() {
        let period = 1e-3;
        let samples: Vec<f64> = (0..60)
            .map(|k| 0.3 + 0.2 * (f64::from(k) * period) - 4.0 * (f64::from(k) * period).powi(2))
            .collect();
        let [value, slope, curvature] = smooth(&samples, 4, period);
        for k in 0..60 {
            let t = k as f64 * period;
            assert!((value[k] - samples[k]).abs() < 1e-12);
            assert!((slope[k] - (0.2 - 8.0 * t)).abs() < 1e-9, "{k}");
            assert!((curvature[k] + 8.0).abs() < 1e-6);
        }
    }
}
