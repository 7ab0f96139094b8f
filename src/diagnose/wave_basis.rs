//! Waves of whole halves of a period over a travel, of which any longer wave is a combination there.

use super::waves::Wave;
use nalgebra::{Cholesky, DMatrix, Dyn};
use std::f64::consts::TAU;

/// Waves of 1 to so many halves of a period over the travel.
const HALVES: usize = 16;
/// Waves of the basis: sine and cosine of each.
pub const WAVES: usize = 2 * HALVES;
/// Share of the basis' highest frequency up to which waves between two of it are told by those around.
const MARGIN: f64 = 0.9;
/// Places at which waves are compared with those of the basis.
const PLACES: usize = 4 * HALVES;
/// What is added to the diagonal of normal matrices, as a share of their largest entry: waves that others all but make would blow up.
pub const RIDGE: f64 = 1e-8;
/// The same where waves of the basis are combined to another one: values are known to rounding, and combinations are right to a few millionths.
const EXACT: f64 = 1e-12;

/// The waves of a travel.
pub struct WaveBasis {
    /// The travel in m or rad.
    pub length: f64,
    /// Places at which a function of place is read.
    pub places: Vec<f64>,
    /// Makes of values at the places the combination of the basis.
    pub combined: DMatrix<f64>,
}

impl WaveBasis {
    /// The basis between two places; none where they are one.
    pub fn between(low: f64, high: f64) -> Option<Self> {
        let length = high - low;
        let place = |k: usize| low + length * (k as f64 + 0.5) / PLACES as f64;
        let places: Vec<f64> = (0..PLACES).map(place).collect();
        let values =
            DMatrix::from_fn(PLACES, WAVES, |row, k| wave(period(length, k / 2 + 1), places[row])[k % 2]);
        let factor = if length > 0.0 { ridged(values.tr_mul(&values), EXACT) } else { None };
        Some(Self { length, combined: factor?.solve(&values.transpose()), places })
    }

    /// Its waves with this amplitude.
    pub fn waves(&self, amplitude: f64) -> impl Iterator<Item = Wave> + use<'_> {
        (1..=HALVES).flat_map(move |halves| Wave::both(period(self.length, halves), amplitude))
    }

    /// The waves of a combination: sine and cosine of one period in one.
    pub fn combination(&self, coefficients: &[f64]) -> Vec<Wave> {
        let wave = |(k, pair): (usize, &[f64])| Wave {
            period: period(self.length, k + 1),
            sine: pair[0],
            cosine: pair[1],
        };
        coefficients.chunks_exact(2).enumerate().map(wave).collect()
    }

    /// The highest spatial frequency of which it makes a wave.
    pub fn highest(&self) -> f64 {
        MARGIN / period(self.length, HALVES)
    }

    /// Sine and cosine of a frequency and of its harmonics at the places, one column each; zero for what the basis does not make.
    pub fn at_places(&self, frequency: f64, harmonics: usize) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(PLACES, 2 * harmonics);
        for (row, place) in self.places.iter().enumerate() {
            let (sine, cosine) = (TAU * frequency * place).sin_cos();
            let (mut s, mut c) = (sine, cosine);
            for harmonic in 0..harmonics {
                if (harmonic + 1) as f64 * frequency > self.highest() {
                    break;
                }
                (all[(row, 2 * harmonic)], all[(row, 2 * harmonic + 1)]) = (s, c);
                (s, c) = (s * cosine + c * sine, c * cosine - s * sine);
            }
        }
        all
    }

    /// The same as combinations of the basis.
    pub fn columns(&self, frequency: f64, harmonics: usize) -> DMatrix<f64> {
        &self.combined * self.at_places(frequency, harmonics)
    }
}

/// Period of a wave with so many halves of one over a length.
fn period(length: f64, halves: usize) -> f64 {
    2.0 * length / halves as f64
}

fn wave(period: f64, x: f64) -> [f64; 2] {
    let (sine, cosine) = (TAU * x / period).sin_cos();
    [sine, cosine]
}

/// A normal matrix with the ridge; none where it cannot be solved.
pub fn solvable(normal: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    ridged(normal, RIDGE)
}

fn ridged(mut normal: DMatrix<f64>, share: f64) -> Option<Cholesky<f64, Dyn>> {
    let ridge = share * normal.diagonal().amax().max(f64::MIN_POSITIVE);
    for k in 0..normal.nrows() {
        normal[(k, k)] += ridge;
    }
    normal.cholesky()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    /// Waves between those of the basis, and those longer than the travel, are combinations of it, at places between those that they were
    /// compared at too.
    #[test]
    fn exact_any_longer_wave_is_a_combination_of_the_basis() {
        let basis = WaveBasis::between(-0.01, 0.05).unwrap();
        // Near the highest one the ends of the travel are made worst.
        const LARGEST: f64 = 5e-3;
        let steps = 200;
        for k in 1..steps {
            let frequency = basis.highest() * f64::from(k) / f64::from(steps);
            let columns = basis.columns(frequency, 2);
            for place in 0..61 {
                let x = -0.01 + 0.001 * f64::from(place);
                let own = basis.waves(1.0).map(|w| {
                    let [sine, cosine] = wave(w.period, x);
                    w.sine * sine + w.cosine * cosine
                });
                let made = columns.tr_mul(&DVector::from_iterator(WAVES, own));
                let [sine, cosine] = wave(1.0 / frequency, x);
                assert!(
                    (made[0] - sine).abs() < LARGEST && (made[1] - cosine).abs() < LARGEST,
                    "{frequency} {x}"
                );
            }
        }
        assert!(WaveBasis::between(0.02, 0.02).is_none());
    }
}
