//! Filters of the effort: notch and low-pass.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;
use serde::{Deserialize, Serialize};

/// A filter between a control law and the amplifier, as drives have them to keep resonances quiet.
///
/// # Model
/// With ω₀ = 2π·f₀ and ω_b = 2π·bandwidth:
/// ```text
///   notch       (s² + d·ω_b·s + ω₀²) / (s² + ω_b·s + ω₀²)          gain d at ω₀, 1 far from it
///   low_pass    ω₀/(s + ω₀)                                        first order, without damping stated
///               ω₀²/(s² + 2·D·ω₀·s + ω₀²)                          second order, with it
/// ```
/// made discrete by Tustin's rule, `s = ω₀/tan(ω₀T/2) · (1 − z⁻¹)/(1 + z⁻¹)`, so that f₀ stays where it is.
///
/// # Validity
/// f₀ below half the sampling rate.
///
/// # Source
/// Franklin, Powell, Workman, *Digital Control of Dynamic Systems*, 3rd ed. (1998), section 6.1.3 (prewarping).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Filter {
    /// Takes out a narrow band.
    Notch {
        /// f₀ in Hz.
        frequency_hz: f64,
        /// Width in Hz at which a notch of depth 0 passes 1/√2.
        bandwidth_hz: f64,
        /// d, the gain that is left at f₀; 0 takes it out altogether.
        #[serde(default)]
        depth: f64,
    },
    /// Passes what is slow.
    LowPass {
        /// f₀ in Hz.
        frequency_hz: f64,
        /// D of a filter of second order; absent: first order.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        damping: Option<f64>,
    },
}

/// Filters of a law at most.
pub const MOST_FILTERS: usize = 4;

/// `(b₀ + b₁z⁻¹ + b₂z⁻²) / (1 + a₁z⁻¹ + a₂z⁻²)`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// The filters of a law, sampled.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Filters {
    sections: [Section; MOST_FILTERS],
    count: usize,
    period_s: f64,
}

/// What the filters of a law remember: two numbers a filter (transposed direct form II).
pub type FilterMemory = [[f64; 2]; MOST_FILTERS];

impl Filter {
    /// What is wrong with its numbers at a sample period, if anything: the key and a sentence.
    pub fn fault(&self, period_s: f64) -> Option<(&'static str, String)> {
        let nyquist_hz = 0.5 / period_s;
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let (Self::Notch { frequency_hz, .. } | Self::LowPass { frequency_hz, .. }) = *self;
        if !(positive(frequency_hz) && frequency_hz < nyquist_hz) {
            let expected = format!("more than 0 and less than {nyquist_hz} Hz, half the sampling rate");
            return Some(("frequency_hz", format!("{frequency_hz}, expected {expected}")));
        }
        match *self {
            Self::Notch { bandwidth_hz, .. } if !positive(bandwidth_hz) => {
                Some(("bandwidth_hz", format!("{bandwidth_hz}, expected more than zero")))
            }
            Self::Notch { depth, .. } if !(0.0..=1.0).contains(&depth) => {
                Some(("depth", format!("{depth}, expected 0 to 1")))
            }
            Self::LowPass { damping: Some(damping), .. } if !positive(damping) => {
                Some(("damping", format!("{damping}, expected more than zero")))
            }
            _ => None,
        }
    }

    fn section(&self, period_s: f64) -> Section {
        // Numerator and denominator in s, highest power first.
        let (frequency_hz, [n2, n1, n0], [d2, d1, d0]) = match *self {
            Self::Notch { frequency_hz, bandwidth_hz, depth } => {
                let (own, width) = (TAU * frequency_hz, TAU * bandwidth_hz);
                (frequency_hz, [1.0, depth * width, own * own], [1.0, width, own * own])
            }
            Self::LowPass { frequency_hz, damping: None } => {
                let own = TAU * frequency_hz;
                (frequency_hz, [0.0, 0.0, own], [0.0, 1.0, own])
            }
            Self::LowPass { frequency_hz, damping: Some(damping) } => {
                let own = TAU * frequency_hz;
                (frequency_hz, [0.0, 0.0, own * own], [1.0, 2.0 * damping * own, own * own])
            }
        };
        let own = TAU * frequency_hz;
        let k = own / (PI * frequency_hz * period_s).tan();
        let first_order = d2 == 0.0;
        let expand = |[c2, c1, c0]: [f64; 3]| {
            if first_order {
                [c1 * k + c0, c0 - c1 * k, 0.0]
            } else {
                [c2 * k * k + c1 * k + c0, 2.0 * (c0 - c2 * k * k), c2 * k * k - c1 * k + c0]
            }
        };
        let (n, d) = (expand([n2, n1, n0]), expand([d2, d1, d0]));
        Section { b: n.map(|x| x / d[0]), a: [d[1] / d[0], d[2] / d[0]] }
    }
}

impl Filters {
    /// The filters sampled at a period; those beyond [`MOST_FILTERS`] are left out.
    pub fn new(filters: &[Filter], period_s: f64) -> Self {
        let mut sampled = Self { period_s, ..Self::default() };
        for (section, filter) in sampled.sections.iter_mut().zip(filters) {
            *section = filter.section(period_s);
            sampled.count += 1;
        }
        sampled
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// One sample through all filters.
    #[inline]
    pub fn pass(&self, memory: &mut FilterMemory, sample: f64) -> f64 {
        let sections = self.sections[..self.count].iter().zip(memory);
        sections.fold(sample, |x, (Section { b, a }, [first, second])| {
            let y = b[0] * x + *first;
            *first = b[1] * x - a[0] * y + *second;
            *second = b[2] * x - a[1] * y;
            y
        })
    }

    /// The memory with which a steady `level` passes as it is (all filters have the gain 1 at standstill).
    pub fn steady(&self, level: f64) -> FilterMemory {
        let mut memory = FilterMemory::default();
        for (Section { b, a }, [first, second]) in self.sections[..self.count].iter().zip(&mut memory) {
            *second = (b[2] - a[1]) * level;
            *first = (b[1] - a[0]) * level + *second;
        }
        memory
    }

    /// Output over input at a frequency.
    pub fn response(&self, frequency_hz: f64) -> Complex<f64> {
        let back = Complex::from_polar(1.0, -TAU * frequency_hz * self.period_s);
        let of = |Section { b, a }: &Section| {
            let square = back * back;
            (back * b[1] + square * b[2] + b[0]) / (back * a[0] + square * a[1] + 1.0)
        };
        self.sections[..self.count].iter().map(of).product()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 250e-6;
    const NOTCH: Filter = Filter::Notch { frequency_hz: 120.0, bandwidth_hz: 30.0, depth: 0.1 };
    const LOW: Filter = Filter::LowPass { frequency_hz: 300.0, damping: Some(0.7) };
    const FIRST: Filter = Filter::LowPass { frequency_hz: 300.0, damping: None };

    /// Amplitude and phase that a sine settles at.
    fn settled(filters: &Filters, frequency_hz: f64) -> Complex<f64> {
        let mut memory = FilterMemory::default();
        let turn = |k: i32| TAU * frequency_hz * PERIOD_S * f64::from(k);
        let mut sum = Complex::new(0.0, 0.0);
        for k in 0..44_000 {
            let y = filters.pass(&mut memory, turn(k).cos());
            if k >= 4_000 {
                sum += Complex::from_polar(y, -turn(k)) * 2.0 / 40_000.0;
            }
        }
        sum
    }

    #[test]
    fn exact_response_is_what_sines_settle_at() {
        let filters = Filters::new(&[NOTCH, LOW, FIRST], PERIOD_S);
        for frequency_hz in [10.0, 100.0, 120.0, 130.0, 300.0, 900.0] {
            let (found, stated) = (settled(&filters, frequency_hz), filters.response(frequency_hz));
            assert!((found - stated).norm() < 1e-9, "{frequency_hz}: {found} {stated}");
        }
    }

    #[test]
    fn exact_gains_where_they_are_stated() {
        let at = |filter: Filter, hz: f64| Filters::new(&[filter], PERIOD_S).response(hz);
        assert!((at(NOTCH, 120.0) - 0.1).norm() < 1e-12);
        assert!((at(LOW, 300.0).norm() - 1.0 / 1.4).abs() < 1e-12);
        assert!((at(FIRST, 300.0) - Complex::new(0.5, -0.5)).norm() < 1e-12);
        for filter in [NOTCH, LOW, FIRST] {
            assert!((at(filter, 0.0) - 1.0).norm() < 1e-12);
        }
    }

    #[test]
    fn exact_a_steady_level_passes() {
        let filters = Filters::new(&[FIRST, NOTCH, LOW], PERIOD_S);
        let mut memory = filters.steady(3.2);
        for _ in 0..100 {
            assert!((filters.pass(&mut memory, 3.2) - 3.2).abs() < 1e-12);
        }
    }

    #[test]
    fn exact_nonsense_is_told() {
        let beyond = Filter::LowPass { frequency_hz: 2000.0, damping: None };
        assert_eq!(beyond.fault(PERIOD_S).unwrap().0, "frequency_hz");
        let deep = Filter::Notch { frequency_hz: 120.0, bandwidth_hz: 30.0, depth: 1.5 };
        assert_eq!(deep.fault(PERIOD_S).unwrap().0, "depth");
        assert!(NOTCH.fault(PERIOD_S).is_none() && LOW.fault(PERIOD_S).is_none());
    }
}
