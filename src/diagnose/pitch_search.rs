//! Pitches of what repeats along the axis, from what the replays of a fit leave.

use super::care::Sensitivities;
use super::estimate::relax::{Spectrum, is_same, refined, undoubled};
use super::fit::Fit;
use super::free::Free;
use super::hypothesis::{path, paths};
use super::nonparametric::{self, Nonparametric};
use super::objective::Objective;
use super::proposals::Together;
use super::score_test::ScoreTest;
use super::wave_basis::{RIDGE, WAVES, WaveBasis, solvable};
use super::wave_descent::{Harmonics, Spread, WaveDescent};
use super::wave_sets::WaveSets;
use super::waves::WaveLaw;
use crate::effect::EffectId;
use crate::error::Result;
use crate::units::Motion;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Spatial frequencies lie this part of the resolution (one over the travel) apart.
const OVERSAMPLING: f64 = 10.0;
/// Sets of the grid that are descended from.
const CANDIDATES: usize = 1000;
/// So many of the best of them go on for so many steps each time: a choice of cost. What a set of the grid leaves tells little of where it leads, and the
/// valleys are long.
const STAGES: [(usize, usize); 4] = [(CANDIDATES, 4), (250, 16), (60, 60), (20, 400)];
/// Places that fits of one wave more start from, and sets that fits of several do, at most: a choice of cost.
const PEAKS: usize = 3;
/// A frequency is a peak if no better one lies so many grid points around it.
const PEAK_WIDTH: usize = 2;

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

/// Where the quadratic form is taken that waves are looked for by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// At the fit: for one wave more.
    Fit,
    /// At the function of place beside the fit that leaves least: for several waves together.
    Nonparametric,
}

/// What the residuals of a fit tell of waves over place, beside calibration and the other effects of its hypothesis.
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
/// Several waves are looked for about the [function of place](Nonparametric) that explains most, whatever its course: about the fit itself the form is
/// not right enough to tell sets of waves apart that differ by a thousandth of what they explain, and which of them come near each other on a travel of few periods.
///
/// # Validity
/// To first order in the amplitudes, of several waves in what they differ by from that function. Pitches of a seventh of the travel and more, a second harmonic from twice that.
///
/// # Source
/// The score test: C. R. Rao (1948), Math. Proc. Cambridge Philos. Soc. 44:50.
pub struct PitchSearch {
    basis: WaveBasis,
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// What the waves of the hypothesis have already, as a combination of the basis.
    known: DVector<f64>,
    frequencies: Vec<f64>,
    spacing: f64,
    family: Family,
    /// The other numbers of the fit beside a function of place.
    others: BTreeMap<String, f64>,
    motion: Motion,
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
        about: About,
    ) -> Result<Option<Self>> {
        let basis = WaveBasis::between(travel.low, travel.high).filter(|_| family.largest > 0.0);
        let Some(basis) = basis else { return Ok(None) };
        let (wave, largest, jacobian) = (family.wave, family.largest, &sensitivities.columns);
        // The waves of the family itself may go elsewhere.
        let own = &fit.hypothesis.effects;
        let held = &|free: &Free| family.laws.contains(&free.effect) && own.contains(&free.effect);
        let beside = nonparametric::Beside { objective, fit, jacobian, held, wave, largest, basis: &basis };
        let Nonparametric { coefficients, test, values } = match about {
            About::Fit => beside.zero()?,
            About::Nonparametric => beside.best()?,
        };
        let ScoreTest { normal, right } = test;
        let right = right + &normal * coefficients;
        let (from, spacing) = (1.0 / travel.longest, 1.0 / (OVERSAMPLING * basis.length));
        let count = ((basis.highest() - from) / spacing).max(0.0) as usize;
        let frequencies = (0..count).map(|k| from + k as f64 * spacing).collect();
        let others =
            fit.hypothesis.free.iter().zip(values).filter(|(free, _)| !family.laws.contains(&free.effect));
        let others = others.map(|(free, value)| (free.path.clone(), value)).collect();
        let known = DVector::zeros(WAVES);
        let motion = objective.machine.motion();
        let mut search = Self { basis, normal, right, known, frequencies, spacing, family, others, motion };
        for effect in family.laws.iter().filter(|effect| fit.hypothesis.effects.contains(effect)) {
            search.know(fit, *effect);
        }
        Ok(Some(search))
    }

    /// Takes note of a wave that the hypothesis has.
    fn know(&mut self, fit: &Fit, effect: EffectId) {
        let values = paths(effect, self.motion).map(|path| fit.hypothesis.value(&path, &fit.values));
        let values: Option<Vec<f64>> = values.collect();
        let Some([period, amplitudes @ ..]) = values.as_deref() else { return };
        let amplitudes = &amplitudes[..self.columns()];
        let form = effect.form().iter().map(|form| path(effect, form.parameter.key(self.motion)));
        let form = form.map(|path| fit.hypothesis.value(&path, &fit.values).unwrap_or(0.0));
        let first = amplitudes[0].hypot(amplitudes[1]);
        let all: Vec<f64> = amplitudes.iter().copied().chain(form.map(|share| first * share)).collect();
        self.known += self.basis.columns(1.0 / period, all.len() / 2) * DVector::from_vec(all);
    }

    /// Waves that explain most beside those of the hypothesis: pitch and amplitudes as a law has them, best first.
    pub fn pitches(&self) -> Vec<Vec<f64>> {
        let beside = Beside { normal: self.normal.clone(), right: self.right.clone() };
        let all = self.peaks(&beside).into_iter().filter_map(|f| self.laws(&[f], &beside));
        all.flatten().collect()
    }

    /// Where these effects of the family may begin together, in the place of the waves that the hypothesis has: at the sets of waves that explain most.
    /// From the best sets of a grid all numbers of a set are descended from together.
    pub fn sets(&self, members: &[EffectId]) -> Vec<Together> {
        let whole = self.beside(&[]);
        let shares = members.iter().flat_map(|effect| effect.form()).map(|form| form.tolerance);
        let spread = Spread { share: shares.fold(0.0, f64::max), largest: self.family.largest };
        let descent = WaveDescent::new(&self.basis, &whole.normal, &whole.right, spread);
        let Some(descent) = descent else { return Vec::new() };
        let waves: Vec<DMatrix<f64>> = self.frequencies.iter().map(|f| self.wave(*f)).collect();
        let grid = WaveSets::new(&waves, &whole.normal, &whole.right, RIDGE).best(members.len(), CANDIDATES);
        let begun = |set: Vec<usize>| {
            let frequencies: Vec<f64> = set.into_iter().map(|k| self.frequencies[k]).collect();
            self.laws(&frequencies, &whole).map(|laws| WaveDescent::begun(&laws))
        };
        let mut sets: Vec<DVector<f64>> = grid.into_iter().filter_map(begun).collect();
        let range = (self.frequencies.first().copied().unwrap_or(0.0), self.basis.highest());
        for (most, steps) in STAGES {
            sets.truncate(most);
            let descend = |set| descent.descend(set, range, steps);
            let mut left: Vec<(f64, DVector<f64>)> = sets.into_par_iter().map(descend).collect();
            left.sort_by(|a, b| a.0.total_cmp(&b.0));
            sets = left.into_iter().map(|(_, set)| set).collect();
        }
        let distinct = self.distinct(sets.iter().map(WaveDescent::waves));
        distinct.into_iter().map(|set| self.together(members, set)).collect()
    }

    /// The first ones of sets that are not like an earlier one.
    fn distinct(&self, sets: impl Iterator<Item = Vec<Harmonics>>) -> Vec<Vec<Harmonics>> {
        let frequencies = |set: &[Harmonics]| set.iter().map(|wave| wave.frequency).collect::<Vec<f64>>();
        let mut distinct: Vec<Vec<Harmonics>> = Vec::new();
        for mut set in sets {
            set.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
            let is_like = |other: &Vec<Harmonics>| is_same(self, &frequencies(other), &frequencies(&set));
            if distinct.len() < PEAKS && !distinct.iter().any(is_like) {
                distinct.push(set);
            }
        }
        distinct
    }

    /// Waves as the laws of these effects, the largest one as the first.
    fn together(&self, members: &[EffectId], mut set: Vec<Harmonics>) -> Together {
        let size = |wave: &Harmonics| wave.own.iter().map(|c| c * c).sum::<f64>();
        set.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let mut beside = self.others.clone();
        let mut own = BTreeMap::new();
        for (effect, wave) in members.iter().zip(set) {
            own.insert(*effect, [vec![1.0 / wave.frequency], wave.own].concat());
            let form = effect.form().iter().map(|form| path(*effect, form.parameter.key(self.motion)));
            beside.extend(form.zip(wave.form));
        }
        Together { own, beside }
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
        DMatrix::from_fn(WAVES, own * blocks.len(), |row, k| blocks[k / own][(row, k % own)])
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
