//! The delay between a reference and the controller that acts on it.

use super::delay_line::DelayLine;
use std::f64::consts::TAU;

use nalgebra::Complex;

/// A delay line for references, whole and fractional samples.
///
/// # Model
/// ```text
///   r(t − d) = (1 − φ)·r[k−n] + φ·r[k−n−1]        d = (n + φ)·T
/// ```
/// for the position and the velocity reference alike. Before the first sample the reference is taken to have moved on
/// at its first velocity: none for a run that begins at rest.
///
/// # Validity
/// A reference that is close to a straight line within one period.
///
/// # Source
/// Laakso, Välimäki, Karjalainen, Laine, *Splitting the unit delay*, IEEE Signal Processing Magazine 13 (1996), eq. 42 (first order).
#[derive(Debug, Clone)]
pub struct ReferenceDelay {
    whole: usize,
    fraction: f64,
    delay_s: f64,
    period_s: f64,
    /// Position and velocity references; none before the first sample.
    past: Option<DelayLine<[f64; 2]>>,
}

impl ReferenceDelay {
    /// The delay line; none where there is no delay.
    pub fn new(delay_s: f64, period_s: f64) -> Option<Self> {
        let periods = delay_s / period_s;
        // A delay that rounding keeps from a whole number of periods is one.
        let whole = (periods + 1e-9).floor();
        (delay_s > 0.0).then(|| Self {
            whole: whole as usize,
            fraction: (periods - whole).max(0.0),
            delay_s,
            period_s,
            past: None,
        })
    }

    /// Forgets the references so far.
    pub fn clear(&mut self) {
        self.past = None;
    }

    /// The position reference of `delay_s` before, of a motion that has been going on at `velocity`.
    pub fn extrapolated(&self, position: f64, velocity: f64) -> f64 {
        position - self.delay_s * velocity
    }

    /// Reference that comes out over the one that goes in: `((1 − φ) + φ·z⁻¹)·z⁻ⁿ`, `z = e^{iωT}`.
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let angle = -TAU * frequency_hz * self.period_s;
        let shared = Complex::from_polar(self.fraction, angle) + (1.0 - self.fraction);
        shared * Complex::from_polar(1.0, angle * self.whole as f64)
    }

    /// Takes the position and velocity reference of a sample and gives those that the controller acts on.
    pub fn pass(&mut self, position: f64, velocity: f64) -> [f64; 2] {
        let Self { whole, period_s, past, .. } = self;
        let past = past.get_or_insert_with(|| {
            let back = |k: usize| position - (*whole + 2 - k) as f64 * *period_s * velocity;
            DelayLine::of((0..*whole + 2).map(|k| [back(k), velocity]).collect())
        });
        let [newer, older] = past.pass([position, velocity]);
        [0, 1].map(|k| newer[k] + self.fraction * (older[k] - newer[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_ramp_comes_out_later() {
        for delay_s in [0.4e-3, 2e-3, 3.0 * 0.7e-3, 9.6e-3, 10e-3] {
            for period_s in [2e-3, 0.7e-3] {
                let mut delay = ReferenceDelay::new(delay_s, period_s).unwrap();
                for k in 0..40 {
                    let t = f64::from(k) * period_s;
                    let [position, velocity] = delay.pass(0.3 + 0.2 * t, 0.2);
                    assert!(
                        (position - (0.3 + 0.2 * (t - delay_s))).abs() < 1e-15,
                        "{delay_s} s, sample {k}"
                    );
                    assert_eq!(velocity, 0.2);
                }
            }
        }
    }

    #[test]
    fn exact_whole_samples_are_those_of_before() {
        let mut delay = ReferenceDelay::new(6e-3, 2e-3).unwrap();
        let steps = [1.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
        let out: Vec<f64> = steps.iter().map(|r| delay.pass(*r, 0.0)[0]).collect();
        assert_eq!(out, [1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 4.0]);
        delay.clear();
        assert_eq!(delay.pass(5.0, 0.0), [5.0, 0.0]);
        assert!(ReferenceDelay::new(0.0, 2e-3).is_none());
    }
}
