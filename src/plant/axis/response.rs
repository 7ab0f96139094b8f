//! Frequency response of the sampled axis, exact at every frequency.

use super::dynamics::{Discrete, Dynamics};
use crate::drive::amplifier::SplitDelay;
use crate::effect::Constants;
use crate::plant::Resonance;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// The axis from what is held over each sample period to the position read at the samples.
///
/// # Model
/// With Φ, Γ the exact step of one sample period T and the position x taken out of the state (it acts back on nothing):
/// ```text
///   z⁺ = Φ·z + Γ_now·u[k−n] + Γ_early·u[k−n−1]          delay d = (n + φ)·T
///   x⁺ = x + p·z + γ_now·u[k−n] + γ_early·u[k−n−1]
///   G(e^{iωT}) = z⁻ⁿ·(p·(zI − Φ)⁻¹·Γ(z) + γ(z))/(z − 1),   Γ(z) = Γ_now + Γ_early·z⁻¹,  γ(z) alike
/// ```
/// Γ_now is the response to a voltage that begins φ·T late, Γ_early the rest of the response to one held over the period.
/// Positive input moves the axis along its positive direction; the response is in m per V or N (rad for a revolute axis).
///
/// # Validity
/// The linear part of the axis: winding, moving mass, viscous drag, base modes, delay. No friction but viscous, no clipping,
/// dead zone or rounding. Exact below half the sampling rate; infinite at 0 Hz, where the axis integrates.
///
/// # Source
/// Åström, Wittenmark (1997), *Computer-Controlled Systems*, sections 2.3, 2.6 (delay) and 3.5. Solved in Hessenberg form:
/// Laub (1981), *Efficient multivariable frequency response computations*, IEEE Trans. Automatic Control 26.
#[derive(Debug, Clone)]
pub struct SampledResponse {
    period_s: f64,
    periods: usize,
    /// Upper Hessenberg form of Φ, row by row.
    hessenberg: Vec<f64>,
    /// What each state adds to the position over a period.
    row: Vec<f64>,
    now: Entry,
    early: Entry,
    resonances: Vec<Resonance>,
}

/// How an input held enters the states and the position.
#[derive(Debug, Clone)]
struct Entry {
    states: Vec<f64>,
    position: f64,
}

impl SampledResponse {
    /// From the effort commanded to the amplifier, its delay and the stated supply of a duty cycle included.
    pub fn to_voltage(constants: &Constants) -> Self {
        let dynamics = Dynamics::of(constants);
        let (period_s, delay) = (constants.sample_period_s, constants.amplifier.delay_s);
        let delay = SplitDelay::new(delay, period_s);
        let step = dynamics.over(period_s);
        let early = dynamics.by_earlier_voltage(period_s, delay.fraction);
        let now = &step.by_voltage - &early;
        let per_volt = [now, early].map(|entry| entry * constants.amplifier.gain());
        Self::of(&dynamics, period_s, (&step, delay.periods), per_volt)
    }

    /// From a force on the moving part in the motor's place, held over each sample period.
    pub fn to_force(constants: &Constants) -> Self {
        let dynamics = Dynamics::of(constants).without_motor();
        let period_s = constants.sample_period_s;
        let step = dynamics.over(period_s);
        let (now, early) = (step.by_mean.clone(), step.by_mean.map(|_| 0.0));
        Self::of(&dynamics, period_s, (&step, 0), [now, early])
    }

    fn of(
        dynamics: &Dynamics,
        period_s: f64,
        (step, periods): (&Discrete, usize),
        [now, early]: [DVector<f64>; 2],
    ) -> Self {
        let position = dynamics.layout.position();
        let without = |vector: &DVector<f64>| vector.clone().remove_row(position);
        let states = step.transition.clone().remove_row(position).remove_column(position);
        let row = step.transition.row(position).transpose().remove_row(position);
        let (basis, hessenberg) = if states.nrows() > 2 {
            states.hessenberg().unpack()
        } else {
            (DMatrix::identity(states.nrows(), states.nrows()), states)
        };
        let turned = |vector: &DVector<f64>| basis.tr_mul(vector).as_slice().to_vec();
        let entry =
            |input: &DVector<f64>| Entry { states: turned(&without(input)), position: input[position] };
        Self {
            period_s,
            periods,
            hessenberg: hessenberg.transpose().as_slice().to_vec(),
            row: turned(&row),
            now: entry(&now),
            early: entry(&early),
            resonances: dynamics.resonances(),
        }
    }

    /// The sample period in s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Oscillations of moving part, drag and base together, by frequency.
    pub fn resonances(&self) -> &[Resonance] {
        &self.resonances
    }

    /// Position over input at `frequency_hz`, above 0 and up to half the sampling rate.
    pub fn position(&self, frequency_hz: f64) -> Complex<f64> {
        let half = 0.5 * TAU * frequency_hz * self.period_s;
        let z = Complex::from_polar(1.0, 2.0 * half);
        let back = z.conj();
        let mut states: Vec<Complex<f64>> =
            self.now.states.iter().zip(&self.early.states).map(|(now, early)| back * *early + *now).collect();
        self.solve(z, &mut states);
        let moved: Complex<f64> = self.row.iter().zip(&states).map(|(p, z)| *z * *p).sum();
        let moved = moved + back * self.early.position + self.now.position;
        // z − 1 without taking two numbers near 1 apart.
        let difference = Complex::new(0.0, 2.0 * half.sin()) * Complex::from_polar(1.0, half);
        moved / difference * Complex::from_polar(1.0, -2.0 * half * self.periods as f64)
    }

    /// Solves `(zI − H)·x = b` in place by elimination of the one subdiagonal, the larger of two rows as pivot.
    fn solve(&self, z: Complex<f64>, b: &mut [Complex<f64>]) {
        let size = b.len();
        let mut matrix: Vec<Complex<f64>> = self.hessenberg.iter().map(|h| Complex::new(-h, 0.0)).collect();
        (0..size).for_each(|k| matrix[k * size + k] += z);
        for k in 0..size.saturating_sub(1) {
            let (upper, lower) = matrix.split_at_mut((k + 1) * size);
            let (upper, lower) = (&mut upper[k * size..], &mut lower[..size]);
            if lower[k].norm_sqr() > upper[k].norm_sqr() {
                upper.swap_with_slice(lower);
                b.swap(k, k + 1);
            }
            let factor = lower[k] / upper[k];
            for column in k + 1..size {
                let of_upper = upper[column];
                lower[column] -= factor * of_upper;
            }
            let of_upper = b[k];
            b[k + 1] -= factor * of_upper;
        }
        for k in (0..size).rev() {
            let row = &matrix[k * size..(k + 1) * size];
            let known: Complex<f64> = (k + 1..size).map(|column| row[column] * b[column]).sum();
            b[k] = (b[k] - known) / row[k];
        }
    }
}
