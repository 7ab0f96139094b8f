//! Sets of waves with their harmonics, fitted to what is known of a function of place.

use super::care::ARRIVED;
use super::prior::TOLERANCE_SIGMAS;
use super::wave_basis::WaveBasis;
use crate::singular::decomposed;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Numbers of a wave: spatial frequency, sine and cosine of the first and of the second harmonic, then of the third and the fourth as shares of the
/// first one's amplitude.
const NUMBERS: usize = 9;
const HARMONICS: usize = 4;
/// Standard deviation of a second harmonic, as a share of the first one: machines have up to 40 % of it, two standard deviations.
const SECOND: f64 = 0.2;
/// A first harmonic below this share of the largest counts as this: the second one is measured by it, and of none there is no measure.
const LEAST: f64 = 1e-4;
/// Amplitudes of the law itself.
const OWN: usize = 4;
/// Damping of the first step, and what a step that falls and one that does not make of it: a choice of cost, as in `descent.rs`.
const FIRST_DAMPING: f64 = 1e-4;
const LESS_DAMPING: f64 = 0.1;
const MORE_DAMPING: f64 = 10.0;
const LARGEST_DAMPING: f64 = 1e6;
/// Directions of the quadratic form that are told less than this share of the best told one are rounding: responses are differences, known to about the
/// square root of it.
const ROUNDING: f64 = 1e-10;

/// A quadratic form of the coefficients of a basis, and the waves that make it small.
///
/// # Model
/// Of the coefficients k of a function of place the data tell `(k − k̂)ᵀG(k − k̂)`, in squares of standard deviations, with `G·k̂ = b`. Waves have the coefficients
/// k(f, a, h) of their spatial frequencies f, their amplitudes a₁, a₂ (sine and cosine each) and the shares h of their third and fourth harmonic; looked for is the least of
/// ```text
///   (k − k̂)ᵀG(k − k̂) + Σ (a₁/a_max)² + Σ (a₂/(0.2·|a₁|))² + Σ (h/σ_h)²,   |h| ≤ 2·σ_h
/// ```
/// by Levenberg and Marquardt's method over all numbers at once. The other terms are what machines have; the first of them keeps waves of nearly one
/// frequency from growing without end against each other.
///
/// # Validity
/// Of harmonics beyond what the basis makes nothing is known: they are left out.
///
/// # Source
/// Marquardt (1963), *An algorithm for least-squares estimation of nonlinear parameters*, J. SIAM 11:431. Second harmonics: the prior of
/// [`Cogging`](crate::effect::Cogging).
pub struct WaveDescent<'a> {
    basis: &'a WaveBasis,
    /// From values at the places to whitened coefficients.
    whitened: DMatrix<f64>,
    /// Whitened k̂.
    target: DVector<f64>,
    spread: Spread,
}

/// How far the numbers of a wave go.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    /// The largest share of a third or fourth harmonic, two standard deviations.
    pub share: f64,
    /// The largest amplitude of a first harmonic.
    pub largest: f64,
}

impl Spread {
    /// Standard deviations of the numbers of a wave with this first harmonic, beside its frequency.
    fn deviations(self, first: f64) -> [f64; NUMBERS - 1] {
        let mut all = [self.share / TOLERANCE_SIGMAS; NUMBERS - 1];
        all[..2].fill(self.largest);
        all[2..OWN].fill(SECOND * first.max(LEAST * self.largest));
        all
    }
}

/// A wave with its harmonics.
#[derive(Debug, Clone)]
pub struct Harmonics {
    /// One over the pitch.
    pub frequency: f64,
    /// Sine and cosine of the first and of the second harmonic.
    pub own: Vec<f64>,
    /// Sine and cosine of the third and of the fourth one, as shares of the first one's amplitude.
    pub form: Vec<f64>,
}

impl<'a> WaveDescent<'a> {
    /// Of G and b; none where G cannot be decomposed.
    pub fn new(
        basis: &'a WaveBasis,
        normal: &DMatrix<f64>,
        right: &DVector<f64>,
        spread: Spread,
    ) -> Option<Self> {
        let parts = decomposed(normal.clone())?;
        let (u, values) = (parts.u?, parts.singular_values);
        let told: Vec<usize> = (0..values.len()).filter(|&k| values[k] > ROUNDING * values.amax()).collect();
        let root = |k: usize| values[told[k]].sqrt();
        let half = DMatrix::from_fn(told.len(), normal.nrows(), |k, j| root(k) * u[(j, told[k])]);
        let target = DVector::from_fn(told.len(), |k, _| u.column(told[k]).dot(right) / root(k));
        Some(Self { whitened: half * &basis.combined, basis, target, spread })
    }

    /// Numbers of waves with these frequencies and amplitudes of first and second harmonic.
    pub fn begun(laws: &[Vec<f64>]) -> DVector<f64> {
        let wave = |law: &Vec<f64>| {
            let mut numbers = [0.0; NUMBERS];
            numbers[0] = 1.0 / law[0];
            numbers[1..=OWN].copy_from_slice(&law[1..=OWN]);
            numbers
        };
        DVector::from_vec(laws.iter().flat_map(wave).collect())
    }

    /// The waves of such numbers.
    pub fn waves(numbers: &DVector<f64>) -> Vec<Harmonics> {
        let wave = |wave: &[f64]| {
            let (own, form) = wave[1..].split_at(OWN);
            Harmonics { frequency: wave[0], own: own.to_vec(), form: form.to_vec() }
        };
        numbers.as_slice().chunks(NUMBERS).map(wave).collect()
    }

    /// Where a descent of at most so many steps from such numbers leads, with what it leaves; spatial frequencies stay between these.
    pub fn descend(&self, begun: DVector<f64>, range: (f64, f64), steps: usize) -> (f64, DVector<f64>) {
        let (mut numbers, mut damping) = (begun, FIRST_DAMPING);
        let mut residuals = self.residuals(&numbers);
        for _ in 0..steps {
            let cost = residuals.norm_squared();
            let next = self.next(&numbers, &residuals, &mut damping, range);
            damping *= LESS_DAMPING;
            let Some(next) = next else { break };
            (numbers, residuals) = next;
            if cost - residuals.norm_squared() < ARRIVED {
                break;
            }
        }
        (residuals.norm_squared(), numbers)
    }

    /// The first step that falls, ever more damped, with what it leaves; none where not even a short one does.
    fn next(
        &self,
        numbers: &DVector<f64>,
        residuals: &DVector<f64>,
        damping: &mut f64,
        range: (f64, f64),
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        let jacobian = self.jacobian(numbers);
        let (normal, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(residuals));
        while *damping < LARGEST_DAMPING {
            let mut damped = normal.clone();
            for k in 0..damped.nrows() {
                damped[(k, k)] *= 1.0 + *damping;
            }
            if let Some(step) = damped.cholesky().map(|factor| factor.solve(&gradient)) {
                let moved = self.inside(numbers - step, range);
                let there = self.residuals(&moved);
                if there.norm_squared() < residuals.norm_squared() {
                    return Some((moved, there));
                }
            }
            *damping *= MORE_DAMPING;
        }
        None
    }

    /// Numbers with spatial frequencies between these and harmonics inside their tolerance.
    fn inside(&self, mut numbers: DVector<f64>, range: (f64, f64)) -> DVector<f64> {
        let most = self.spread.share;
        for wave in numbers.as_mut_slice().chunks_mut(NUMBERS) {
            wave[0] = wave[0].clamp(range.0, range.1);
            wave[1 + OWN..].iter_mut().for_each(|share| *share = share.clamp(-most, most));
        }
        numbers
    }

    fn residuals(&self, numbers: &DVector<f64>) -> DVector<f64> {
        let mut force = DVector::zeros(self.basis.places.len());
        let mut priors = Vec::new();
        for wave in numbers.as_slice().chunks(NUMBERS) {
            let (amplitudes, form) = wave[1..].split_at(OWN);
            let first = amplitudes[0].hypot(amplitudes[1]);
            let all = amplitudes.iter().copied().chain(form.iter().map(|share| first * share));
            let columns = self.basis.at_places(wave[0], HARMONICS);
            force += columns * DVector::from_iterator(2 * HARMONICS, all);
            priors
                .extend(wave[1..].iter().zip(self.spread.deviations(first)).map(|(number, sd)| number / sd));
        }
        let data = &self.whitened * force - &self.target;
        DVector::from_iterator(data.len() + priors.len(), data.iter().copied().chain(priors))
    }

    fn jacobian(&self, numbers: &DVector<f64>) -> DMatrix<f64> {
        let places = &self.basis.places;
        let told = self.target.len();
        let waves = numbers.len() / NUMBERS;
        let mut force = DMatrix::zeros(places.len(), numbers.len());
        let mut jacobian = DMatrix::zeros(told + waves * (NUMBERS - 1), numbers.len());
        for (k, wave) in numbers.as_slice().chunks(NUMBERS).enumerate() {
            let (amplitudes, form) = wave[1..].split_at(OWN);
            let first = amplitudes[0].hypot(amplitudes[1]);
            let columns = self.basis.at_places(wave[0], HARMONICS);
            for (row, place) in places.iter().enumerate() {
                let at = |column: usize| columns[(row, column)];
                let size = |column: usize| match column < OWN {
                    true => amplitudes[column],
                    false => first * form[column - OWN],
                };
                let higher: f64 = (0..form.len()).map(|j| form[j] * at(OWN + j)).sum();
                for harmonic in 0..HARMONICS {
                    let (sine, cosine) = (2 * harmonic, 2 * harmonic + 1);
                    let slope = size(sine) * at(cosine) - size(cosine) * at(sine);
                    force[(row, NUMBERS * k)] += TAU * (harmonic + 1) as f64 * place * slope;
                }
                for j in 0..OWN {
                    let of_first = if j < 2 && first > 0.0 { amplitudes[j] / first * higher } else { 0.0 };
                    force[(row, NUMBERS * k + 1 + j)] = at(j) + of_first;
                    force[(row, NUMBERS * k + 1 + OWN + j)] = first * at(OWN + j);
                }
            }
            for (j, sd) in self.spread.deviations(first).into_iter().enumerate() {
                let row = told + k * (NUMBERS - 1) + j;
                jacobian[(row, NUMBERS * k + 1 + j)] = 1.0 / sd;
                // The second harmonic is measured by the first one.
                if (2..OWN).contains(&j) && sd == SECOND * first {
                    for i in 0..2 {
                        jacobian[(row, NUMBERS * k + 1 + i)] =
                            -amplitudes[j] * amplitudes[i] / (sd * first * first);
                    }
                }
            }
        }
        jacobian.rows_mut(0, told).copy_from(&(&self.whitened * force));
        jacobian
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Cogging;
    use crate::effect::Law;

    /// Three pitches with harmonics on a travel shorter than the longest one: from pitches a hundredth off and without the higher harmonics the descent leaves
    /// no more than they themselves do.
    #[test]
    fn exact_waves_are_found_again() {
        let basis = WaveBasis::between(0.0, 0.045).unwrap();
        let truth =
            [[0.0548, -1.7, 1.4, 0.1, 0.1], [0.0304, 1.5, 18.6, -5.0, 1.8], [0.0263, -4.7, -7.4, 0.3, 3.3]];
        let form = [0.04, 0.02, -0.01, 0.015];
        let of = |[period, s, c, s2, c2]: [f64; 5]| Cogging {
            sine_2_n: s2,
            cosine_2_n: c2,
            sine_3: form[0],
            cosine_3: form[1],
            sine_4: form[2],
            cosine_4: form[3],
            ..Cogging::single(period, s, c)
        };
        let force = |x: &f64| truth.iter().map(|wave| of(*wave).push(*x, 0.0)).sum::<f64>();
        let force = DVector::from_iterator(basis.places.len(), basis.places.iter().map(force));
        // Known to a millinewton everywhere, so that what machines have hardly pulls.
        let normal = DMatrix::identity(basis.combined.nrows(), basis.combined.nrows()) * 1e6;
        let right = &normal * (&basis.combined * force);
        let descent =
            WaveDescent::new(&basis, &normal, &right, Spread { share: 0.1, largest: 30.0 }).unwrap();
        let at = |factor: f64| {
            let law = |wave: &[f64; 5]| [&[wave[0] * factor][..], &wave[1..]].concat();
            WaveDescent::begun(&truth.iter().map(law).collect::<Vec<_>>())
        };
        let mut exact = at(1.0);
        for wave in exact.as_mut_slice().chunks_mut(NUMBERS) {
            wave[1 + OWN..].copy_from_slice(&form);
        }
        // What the truth leaves is its priors alone.
        let (of_truth, _) = descent.descend(exact, (10.0, 170.0), 0);
        let (left, numbers) = descent.descend(at(1.01), (10.0, 170.0), 400);
        let found = WaveDescent::waves(&numbers);
        assert!(of_truth < 12.0 && left < of_truth + ARRIVED, "{left} {of_truth} {found:?}");
        for (found, wave) in found.iter().zip(&truth) {
            // The longest one is told least, and its priors pull.
            assert!((found.frequency * wave[0] - 1.0).abs() < 0.01, "{left} {found:?}");
        }
    }
}
