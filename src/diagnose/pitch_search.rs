//! Pitches of what repeats along the axis, from what the replays of a fit leave.

use super::care::Sensitivities;
use super::estimate::relax::{Spectrum, is_same, refined, settled, undoubled};
use super::fit::Fit;
use super::hypothesis::{Freedom, paths};
use super::objective::Objective;
use super::score_test::ScoreTest;
use super::wave_sets::WaveSets;
use super::waves::{self, Wave, WaveLaw};
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{Cholesky, DMatrix, DVector};
use std::f64::consts::TAU;

/// Waves whose responses are taken: of 1 to so many halves of a period over the travel.
const HALVES: usize = 16;
/// Share of the basis' highest frequency up to which waves between two of it are told by those around.
const MARGIN: f64 = 0.9;
/// Places at which waves are compared with those of the basis.
const PLACES: usize = 4 * HALVES;
/// Amplitude of a wave while its response is taken, as a share of the largest: small against any friction, large against rounding.
const SHARE: f64 = 1e-5;
/// Spatial frequencies lie this part of the resolution (one over the travel) apart.
const OVERSAMPLING: f64 = 10.0;
/// Sets are looked for on a grid so many times as coarse, a fifth of the resolution: a choice of cost, each wave is refined then.
const COARSE: usize = 2;
/// Peaks that fits start from, and that sets are begun with.
const PEAKS: usize = 3;
/// A frequency is a peak if no better one lies so many grid points around it.
const PEAK_WIDTH: usize = 2;
/// What is added to the diagonal of normal matrices, as a share of their largest entry: waves that others all but make would blow up.
const RIDGE: f64 = 1e-8;

/// The places that runs pass.
#[derive(Debug, Clone, Copy)]
pub struct Travel {
    /// The lowest, in m or rad.
    pub low: f64,
    /// The highest.
    pub high: f64,
    /// The longest pitch that a fit begins with.
    pub longest: f64,
}

/// Laws of what repeats along the axis that are looked for as one: the first, the second, …
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// The laws.
    pub laws: &'static [EffectId],
    /// A wave of them.
    pub wave: WaveLaw,
    /// The largest amplitude of a wave, in what the laws have it in.
    pub largest: f64,
    /// Harmonics of a wave: 1 or 2.
    pub harmonics: usize,
}

/// What the residuals of a fit tell of a wave over place, beside calibration and the other effects of its hypothesis.
///
/// # Model
/// The replay's normalised residuals r change with a wave of amplitude a by R·a, seen through the twin's own loop: the R of sine and cosine of n halves
/// of a period over the travel, n = 1 … 16, are differences of replays, and those of any other wave are combinations of them. With G and b of the
/// [score test](ScoreTest) of these R:
/// ```text
///   gain of waves with the combinations M:  bᵀM·(MᵀGM)⁻¹·Mᵀb
/// ```
/// The gain is by how much a fit of their amplitudes lowers the weighted sum of squares: to first order the best that a fit can do with these
/// periods. Unlike a periodogram of the missing force it weighs every sample by what it tells and takes no derivative of the position.
///
/// # Validity
/// To first order in the amplitudes. Pitches of a seventh of the travel and more, a second harmonic from twice that.
///
/// # Source
/// The score test: C. R. Rao (1948), Math. Proc. Cambridge Philos. Soc. 44:50.
pub struct PitchSearch {
    basis: Basis,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// What the waves of the hypothesis have already, as a combination of the basis.
    known: DVector<f64>,
    frequencies: Vec<f64>,
    spacing: f64,
    family: Family,
}

/// Other waves taken out of the normal equations.
pub struct Beside {
    normal: DMatrix<f64>,
    right: DVector<f64>,
}

impl PitchSearch {
    /// Looks at what a fit leaves of the training runs, for waves of one family of laws; none where the travel is none.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn of(
        objective: &Objective,
        fit: &Fit,
        sensitivities: &Sensitivities,
        family: Family,
        travel: Travel,
    ) -> Result<Option<Self>> {
        let fitted = fit.machine(objective.machine)?;
        let amplitude = SHARE * family.largest;
        let Some(basis) = Basis::over(travel).filter(|_| amplitude > 0.0) else { return Ok(None) };
        let machines = waves::machines(&fitted, family.wave, basis.waves(amplitude));
        let residuals = objective.residuals(&fit.values)?;
        let changed = objective.residuals_at(&machines)?;
        let responses: Vec<DVector<f64>> =
            changed.into_iter().map(|changed| (changed - &residuals) / amplitude).collect();
        let responses = DMatrix::from_columns(&responses);
        // The waves of the family itself may go elsewhere.
        let mut jacobian = sensitivities.columns.clone();
        for (k, free) in fit.hypothesis.free.iter().enumerate() {
            if free.freedom == Freedom::Cause && family.laws.contains(&free.effect) {
                jacobian.column_mut(k).fill(0.0);
            }
        }
        let ScoreTest { normal, right } =
            ScoreTest::of(objective, &fit.values, &residuals, &jacobian, &responses);
        let (from, spacing) = (1.0 / travel.longest, 1.0 / (OVERSAMPLING * basis.length));
        let count = ((basis.highest() - from) / spacing).max(0.0) as usize;
        let frequencies = (0..count).map(|k| from + k as f64 * spacing).collect();
        let known = DVector::zeros(2 * HALVES);
        let mut search = Self { basis, normal, right, known, frequencies, spacing, family };
        for effect in family.laws.iter().filter(|effect| fit.hypothesis.effects.contains(effect)) {
            search.know(fit, *effect, objective.machine);
        }
        Ok(Some(search))
    }

    /// Takes note of a wave that the hypothesis has.
    fn know(&mut self, fit: &Fit, effect: EffectId, machine: &Machine) {
        let values = paths(effect, machine.motion()).map(|path| fit.hypothesis.value(&path, &fit.values));
        let values: Option<Vec<f64>> = values.collect();
        if let Some([period, amplitudes @ ..]) = values.as_deref() {
            let own = &amplitudes[..self.columns()];
            self.known += self.wave(1.0 / period) * DVector::from_column_slice(own);
        }
    }

    /// Waves that explain most beside those of the hypothesis: pitch and amplitudes as a law has them, best first.
    pub fn pitches(&self) -> Vec<Vec<f64>> {
        let beside = Beside { normal: self.normal.clone(), right: self.right.clone() };
        let all = self.peaks(&beside).into_iter().filter_map(|f| self.laws(&[f], &beside));
        all.flatten().collect()
    }

    /// Sets of so many waves that explain most in the place of those that the hypothesis has, the largest wave of a set first: of all sets of a
    /// coarse grid those that explain most, each wave estimated beside the others then.
    pub fn sets(&self, count: usize) -> Vec<Vec<Vec<f64>>> {
        let whole = self.beside(&[]);
        let grid: Vec<f64> = self.frequencies.iter().copied().step_by(COARSE).collect();
        let waves: Vec<DMatrix<f64>> = grid.iter().map(|f| self.wave(*f)).collect();
        let all = WaveSets::new(&waves, &whole.normal, &whole.right, RIDGE);
        let mut sets: Vec<Vec<f64>> = Vec::new();
        for best in all.best(count, PEAKS) {
            let mut set = settled(self, best.into_iter().map(|k| grid[k]).collect());
            set.sort_by(f64::total_cmp);
            if !sets.iter().any(|other| is_same(self, other, &set)) {
                sets.push(set);
            }
        }
        let size = |values: &Vec<f64>| values[1..].iter().map(|c| c * c).sum::<f64>();
        let sorted = |mut set: Vec<Vec<f64>>| {
            set.sort_by(|a, b| size(b).total_cmp(&size(a)));
            set
        };
        sets.iter().filter_map(|set| self.laws(set, &whole)).map(sorted).collect()
    }

    /// The frequencies that stand out, best first.
    fn peaks(&self, beside: &Beside) -> Vec<f64> {
        let gains = self.gains(beside);
        let is_peak = |k: usize| {
            let around = k.saturating_sub(PEAK_WIDTH)..(k + PEAK_WIDTH + 1).min(gains.len());
            gains[k] > 0.0 && around.into_iter().all(|j| gains[j] <= gains[k])
        };
        let mut peaks: Vec<usize> = (0..gains.len()).filter(|&k| is_peak(k)).collect();
        peaks.sort_by(|&a, &b| gains[b].total_cmp(&gains[a]));
        let at = |k: usize| refined(self, self.frequencies[k], beside);
        // Only a wave of two harmonics takes the place of another one.
        let single = |f: f64| if self.family.harmonics > 1 { undoubled(self, f, beside) } else { f };
        peaks.into_iter().take(PEAKS).map(at).map(single).collect()
    }

    /// Periods and amplitudes of waves, all estimated together.
    fn laws(&self, frequencies: &[f64], beside: &Beside) -> Option<Vec<Vec<f64>>> {
        let (_, amplitudes) = self.estimated(&self.block(frequencies), beside)?;
        let bounded = |a: &f64| a.clamp(-self.family.largest, self.family.largest);
        let law = |(f, own): (&f64, &[f64])| {
            [1.0 / f].into_iter().chain(own.iter().map(bounded)).collect::<Vec<f64>>()
        };
        Some(frequencies.iter().zip(amplitudes.as_slice().chunks(self.columns())).map(law).collect())
    }

    /// What waves explain beside others, and their amplitudes.
    fn estimated(&self, block: &DMatrix<f64>, beside: &Beside) -> Option<(f64, DVector<f64>)> {
        let right = block.tr_mul(&beside.right);
        let amplitudes = solvable(block.tr_mul(&(&beside.normal * block)))?.solve(&right);
        Some((amplitudes.dot(&right), amplitudes))
    }

    fn block(&self, frequencies: &[f64]) -> DMatrix<f64> {
        let blocks: Vec<DMatrix<f64>> = frequencies.iter().map(|f| self.wave(*f)).collect();
        let own = self.columns();
        DMatrix::from_fn(2 * HALVES, own * blocks.len(), |row, k| blocks[k / own][(row, k % own)])
    }

    /// Amplitudes of a wave.
    fn columns(&self) -> usize {
        2 * self.family.harmonics
    }

    /// A wave of the family as combinations of the basis, one an amplitude.
    fn wave(&self, frequency: f64) -> DMatrix<f64> {
        self.basis.columns(frequency, self.family.harmonics)
    }
}

impl Spectrum for PitchSearch {
    type Beside = Beside;

    fn frequencies(&self) -> &[f64] {
        &self.frequencies
    }

    fn spacing(&self) -> f64 {
        self.spacing
    }

    /// In the place of the waves that the hypothesis has.
    fn beside(&self, frequencies: &[f64]) -> Beside {
        let right = &self.right + &self.normal * &self.known;
        let block = self.block(frequencies);
        let taken = &self.normal * &block;
        let factor = if frequencies.is_empty() { None } else { solvable(block.tr_mul(&taken)) };
        let Some(factor) = factor else { return Beside { normal: self.normal.clone(), right } };
        let normal = &self.normal - &taken * factor.solve(&taken.transpose());
        let right = &right - &taken * factor.solve(&block.tr_mul(&right));
        Beside { normal, right }
    }

    fn gain(&self, frequency: f64, beside: &Beside) -> f64 {
        self.estimated(&self.wave(frequency), beside).map_or(0.0, |(gain, _)| gain)
    }
}

/// Waves of 1, 2, … halves of a period over a travel, of which any longer wave is a combination there.
struct Basis {
    length: f64,
    places: Vec<f64>,
    /// The combination for values at the places.
    combined: DMatrix<f64>,
}

impl Basis {
    /// The basis over a travel; none where that has no length.
    fn over(travel: Travel) -> Option<Self> {
        let length = travel.high - travel.low;
        let place = |k: usize| travel.low + length * (k as f64 + 0.5) / PLACES as f64;
        let places: Vec<f64> = (0..PLACES).map(place).collect();
        let values = DMatrix::from_fn(PLACES, 2 * HALVES, |row, k| {
            wave(period(length, k / 2 + 1), places[row])[k % 2]
        });
        let factor = if length > 0.0 { solvable(values.tr_mul(&values)) } else { None };
        Some(Self { length, combined: factor?.solve(&values.transpose()), places })
    }

    /// Its waves with this amplitude.
    fn waves(&self, amplitude: f64) -> impl Iterator<Item = Wave> + use<'_> {
        (1..=HALVES).flat_map(move |halves| Wave::both(period(self.length, halves), amplitude))
    }

    /// The highest spatial frequency of which it makes a wave.
    fn highest(&self) -> f64 {
        MARGIN / period(self.length, HALVES)
    }

    /// The waves of a frequency and of its harmonics as combinations of the basis: sine, cosine, sine, cosine.
    fn columns(&self, frequency: f64, harmonics: usize) -> DMatrix<f64> {
        let at = |row: usize, column: usize| {
            let frequency = (1 + column / 2) as f64 * frequency;
            // What the basis does not make is left out.
            if frequency > self.highest() { 0.0 } else { wave(1.0 / frequency, self.places[row])[column % 2] }
        };
        &self.combined * DMatrix::from_fn(PLACES, 2 * harmonics, at)
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

fn solvable(mut normal: DMatrix<f64>) -> Option<Cholesky<f64, nalgebra::Dyn>> {
    let ridge = RIDGE * normal.diagonal().amax().max(f64::MIN_POSITIVE);
    for k in 0..normal.nrows() {
        normal[(k, k)] += ridge;
    }
    normal.cholesky()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waves between those of the basis, and those longer than the travel, are combinations of it, at places between those that they were
    /// compared at too.
    #[test]
    fn exact_any_longer_wave_is_a_combination_of_the_basis() {
        let basis = Basis::over(Travel { low: -0.01, high: 0.05, longest: 0.09 }).unwrap();
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
                let made = columns.tr_mul(&DVector::from_iterator(2 * HALVES, own));
                let [sine, cosine] = wave(1.0 / frequency, x);
                assert!((made[0] - sine).abs() < 0.02 && (made[1] - cosine).abs() < 0.02, "{frequency} {x}");
            }
        }
        assert!(Basis::over(Travel { low: 0.02, high: 0.02, longest: 0.09 }).is_none());
    }
}
