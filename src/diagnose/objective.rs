//! What a fit minimises.

use super::beginnings::has_own_beginnings;
use super::care::{Care, Sensitivities};
use super::evidence::{LARGEST, finite};
use super::experiment::Experiment;
use super::hypothesis::Hypothesis;
use super::noise::Floor;
use super::phase;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::axis::LONGEST_STEP_S;
use crate::recording::Signal;
use crate::replay::Traces;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Finite-difference step in units of a number's scale. Numbers that compensate each other leave a change that is 10⁻⁴ to 10⁻⁶ of
/// what each makes alone, and the curvature of the step must stay below that; rounding is below 10⁻⁸ still.
const DIFFERENCE: f64 = 1e-6;

/// Residuals beyond so many robust standard deviations count linearly, not squared: moments at which the twin is
/// structurally wrong (a reversal, a jump of the command) must not set its constants. White noise stays untouched.
const GUARD: f64 = 3.0;

/// What longer steps of the plant may change of residuals, as a share of their norm, where a fit only has to show which explanations come near. A choice of
/// cost: the mean square changes by 6 % then, and rough fits are told apart by factors of two; fits end, and explanations are judged, in the fine steps.
const COARSE: f64 = 0.03;

/// Variance of what a hypothesis does not describe, S², in units of each signal's noise variance.
pub(super) type Undescribed = BTreeMap<Signal, f64>;

/// What a fit minimises: normalised residuals of closed-loop replays, and calibration's distance from its
/// stated values in tolerances.
pub struct Objective<'a> {
    pub(super) machine: &'a Machine,
    pub(super) hypothesis: &'a Hypothesis,
    pub(super) experiments: &'a [Experiment],
    pub(super) floor: &'a Floor,
    /// Every so many samples one counts.
    pub(super) stride: usize,
    /// Longest step of the plant in s.
    pub(super) longest_step_s: f64,
    /// What is added to the residuals of these steps: those in finer steps less these, at one place (defect correction).
    pub(super) defect: Option<&'a DVector<f64>>,
}

impl<'a> Objective<'a> {
    /// The objective of a hypothesis on these runs.
    pub fn new(
        machine: &'a Machine,
        hypothesis: &'a Hypothesis,
        experiments: &'a [Experiment],
        floor: &'a Floor,
    ) -> Self {
        Self {
            machine,
            hypothesis,
            experiments,
            floor,
            stride: 1,
            longest_step_s: LONGEST_STEP_S,
            defect: None,
        }
    }

    /// The same objective on samples thinned, and in steps lengthened, for a fit of this care.
    pub(super) fn for_care(mut self, care: Care) -> Self {
        if let Care::Rough(known) = care {
            self.stride = known.stride;
            self.longest_step_s = known.longest_step_s;
        }
        self
    }

    /// The same objective in steps of the plant of at most `longest_step_s`, in s.
    pub(super) fn in_steps(&self, longest_step_s: f64) -> Self {
        Self { longest_step_s, ..*self }
    }

    /// Rows that one signal of a run takes.
    pub(super) fn rows(&self, experiment: &Experiment) -> usize {
        experiment.samples().div_ceil(self.stride)
    }

    /// Normalised residuals of all runs, run after run, signal after signal.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn residuals(&self, values: &[f64]) -> Result<DVector<f64>> {
        Ok(self.residuals_of(&[values.to_vec()])?.remove(0))
    }

    /// The same for several sets of values, replayed in one pass.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub fn residuals_of(&self, sets: &[Vec<f64>]) -> Result<Vec<DVector<f64>>> {
        self.replayed(sets.iter().map(|values| self.fitted(values)).collect())
    }

    /// The same objective in the longest steps of the plant, up to a control period, that change these residuals of these values by no more than
    /// [`COARSE`] of their norm, and its residuals; none where no longer steps do.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub(super) fn lengthened(
        &self,
        values: &[f64],
        fine: &DVector<f64>,
    ) -> Result<Option<(Self, DVector<f64>)>> {
        let period_s = self.machine.constants().sample_period_s;
        let shares = [1.0, 0.5, 0.25].map(|share| share * period_s);
        for longest_step_s in shares.into_iter().filter(|step_s| *step_s > LONGEST_STEP_S) {
            let coarse = self.in_steps(longest_step_s);
            let residuals = coarse.residuals(values)?;
            if (&residuals - fine).norm() <= COARSE * fine.norm() {
                return Ok(Some((coarse, residuals)));
            }
        }
        Ok(None)
    }

    /// The machine with these values; none where its description refuses one.
    fn fitted(&self, values: &[f64]) -> Option<Machine> {
        self.hypothesis.machine(self.machine, values).ok()
    }

    fn replayed(&self, machines: Vec<Option<Machine>>) -> Result<Vec<DVector<f64>>> {
        let valid: Vec<Machine> = machines.iter().flatten().cloned().collect();
        let mut all = self.residuals_at(&valid)?.into_iter();
        let rows = || self.experiments.iter().map(|e| self.rows(e) * e.signals().len()).sum();
        // A value that the description refuses (no mass left, say) explains nothing.
        let refused = || DVector::from_element(rows(), LARGEST);
        let of =
            |machine: &Option<Machine>| machine.as_ref().and_then(|_| all.next()).unwrap_or_else(refused);
        Ok(machines.iter().map(of).collect())
    }

    /// The same for several machines.
    ///
    /// # Errors
    /// A setting of a run that a machine does not have.
    pub(super) fn residuals_at(&self, machines: &[Machine]) -> Result<Vec<DVector<f64>>> {
        self.residuals_by(machines.len(), |experiment| {
            experiment.predict_together(machines, self.longest_step_s)
        })
    }

    /// Normalised residuals of so many replays of each run.
    fn residuals_by(
        &self,
        count: usize,
        replay: impl Fn(&Experiment) -> Result<Vec<Traces>> + Sync,
    ) -> Result<Vec<DVector<f64>>> {
        let of_run = |experiment: &Experiment| -> Result<Vec<Vec<f64>>> {
            Ok(replay(experiment)?.iter().map(|traces| self.of_run(experiment, traces)).collect())
        };
        let runs: Vec<Vec<Vec<f64>>> = self.experiments.par_iter().map(of_run).collect::<Result<_>>()?;
        let of = |k: usize| {
            let mut all = Vec::with_capacity(runs.iter().map(|run| run[k].len()).sum());
            runs.iter().for_each(|run| all.extend_from_slice(&run[k]));
            let residuals = DVector::from_vec(all);
            match self.defect {
                Some(defect) => residuals + defect,
                None => residuals,
            }
        };
        Ok((0..count).map(of).collect())
    }

    /// Normalised residuals of what was predicted for the runs, one prediction a run.
    pub(super) fn residuals_from(&self, traces: &[Traces]) -> DVector<f64> {
        let runs = self.experiments.iter().zip(traces);
        let runs: Vec<Vec<f64>> = runs.map(|(run, traces)| self.of_run(run, traces)).collect();
        DVector::from_vec(runs.concat())
    }

    /// Normalised residuals of one run, signal after signal.
    fn of_run(&self, experiment: &Experiment, predicted: &Traces) -> Vec<f64> {
        let of = |&signal: &Signal| self.floor.normalised_every(experiment, signal, predicted, self.stride);
        let mut all = experiment.signals().iter().map(of).collect::<Vec<_>>().concat();
        all.iter_mut().for_each(|residual| *residual = finite(*residual));
        all
    }

    /// Derivatives of the residuals by the numbers in units of their scale; columns that `known` has are taken from
    /// there.
    ///
    /// They are those of the machine without effects that make noise: the steps of a reading jump where a number moves by a millionth of its scale,
    /// and on average over the steps the reading follows the motion (a dithered quantiser is linear).
    pub(super) fn jacobian(
        &self,
        values: &[f64],
        residuals: &DVector<f64>,
        known: Option<&Sensitivities>,
    ) -> Result<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(residuals.len(), values.len());
        let (mut varied, mut steps) = (Vec::new(), Vec::new());
        for (k, free) in self.hypothesis.free.iter().enumerate() {
            // The columns of what begins elsewhere were taken at another place.
            let known = known.filter(|_| !self.hypothesis.elsewhere.contains(&free.effect));
            if let Some(column) = known.and_then(|known| known.column(free)) {
                jacobian.set_column(k, &column);
                continue;
            }
            if free.held {
                continue;
            }
            let reach = DIFFERENCE * free.reach(values[k]);
            let step = if values[k] + reach <= free.range.1 { reach } else { -reach };
            if values[k] + step < free.range.0 {
                continue; // no room to vary: the data leave this number where it is
            }
            let mut set = values.to_vec();
            set[k] += step;
            varied.push(set);
            // In units of the number's scale, so that columns are comparable.
            steps.push((k, free.scale / step));
        }
        let is_noisy = |effect: &EffectId| effect.makes_noise() && self.has(*effect);
        let noisy: Vec<EffectId> = EffectId::ALL.iter().copied().filter(is_noisy).collect();
        if !noisy.is_empty() {
            varied.push(values.to_vec());
        }
        let even = |machine: Machine| noisy.iter().try_fold(machine, |m, of| m.without_effect(*of)).ok();
        let machines: Vec<Option<Machine>> =
            varied.iter().map(|set| self.fitted(set).and_then(even)).collect();
        let near = self.fitted(values).and_then(even).filter(has_own_beginnings);
        let valid: Option<Vec<Machine>> = machines.iter().cloned().collect();
        let nuisance = near.zip(valid).filter(|(_, varied)| !varied.is_empty());
        let mut changed = match &nuisance {
            Some((near, varied)) => self.residuals_near(near, varied)?,
            None => self.replayed(machines)?,
        };
        let by_nuisance = nuisance.and_then(|_| changed.pop());
        let own = if noisy.is_empty() { None } else { changed.pop() };
        let own = own.as_ref().unwrap_or(residuals);
        for ((k, per_step), changed) in steps.into_iter().zip(changed) {
            jacobian.set_column(k, &((changed - own) * per_step));
        }
        if let Some(by_nuisance) = by_nuisance {
            phase::follow(&mut jacobian, &(by_nuisance - own), &self.weights(residuals), &self.run_rows());
        }
        Ok(jacobian)
    }

    /// Residuals of machines near one with a vibration or a play, all with the phases, and the places in the play, that suit that one; last, those of that
    /// one with each phase advanced by [`DIFFERENCE`] rad, or each place by that share.
    fn residuals_near(&self, near: &Machine, machines: &[Machine]) -> Result<Vec<DVector<f64>>> {
        let advanced = machines.iter().map(|machine| (machine, 0.0)).chain([(near, DIFFERENCE)]);
        let all: Vec<(&Machine, f64)> = advanced.collect();
        self.residuals_by(all.len(), |experiment| experiment.predict_near(near, &all, self.longest_step_s))
    }

    /// Rows of each run.
    fn run_rows(&self) -> Vec<Range<usize>> {
        let lengths = self.experiments.iter().map(|e| self.rows(e) * e.signals().len());
        lengths
            .scan(0, |end, length| {
                let begin = *end;
                *end += length;
                Some(begin..*end)
            })
            .collect()
    }

    /// The columns of the numbers whose sensitivities are known, zero for the others.
    pub(super) fn known_columns(&self, known: &Sensitivities) -> DMatrix<f64> {
        let free = &self.hypothesis.free;
        let mut columns = DMatrix::zeros(known.columns.nrows(), free.len());
        for (k, free) in
            free.iter().enumerate().filter(|(_, f)| !self.hypothesis.elsewhere.contains(&f.effect))
        {
            if let Some(column) = known.column(free) {
                columns.set_column(k, &column);
            }
        }
        columns
    }

    /// Whether the machine of the hypothesis has an effect.
    fn has(&self, effect: EffectId) -> bool {
        self.hypothesis.effects.contains(&effect) || self.machine.description().effect.contains(effect)
    }

    /// Normal matrix and gradient of the weighted sum of squares.
    pub(super) fn normal(
        &self,
        jacobian: &DMatrix<f64>,
        residuals: &DVector<f64>,
        weights: &DVector<f64>,
        values: &[f64],
    ) -> (DMatrix<f64>, DVector<f64>) {
        let (weight, mut gradient) = self.hypothesis.prior(values);
        let mut normal = DMatrix::from_diagonal(&weight);
        for a in 0..normal.nrows() {
            let weighted = jacobian.column(a).component_mul(weights);
            // It is symmetric.
            for b in 0..=a {
                normal[(a, b)] += weighted.dot(&jacobian.column(b));
                normal[(b, a)] = normal[(a, b)];
            }
            gradient[a] += weighted.dot(residuals);
        }
        (normal, gradient)
    }

    pub(super) fn cost(&self, residuals: &DVector<f64>, weights: &DVector<f64>, values: &[f64]) -> f64 {
        let squares: f64 = residuals.iter().zip(weights).map(|(r, w)| w * r * r).sum();
        squares + 2.0 * self.hypothesis.strain(values)
    }

    /// Weights of the squared normalised residuals.
    ///
    /// # Model
    /// What is left of a signal is noise, of variance p² (its profile over time), and what the hypothesis does not
    /// describe, of variance S² (the same at all times); all in units of the signal's noise level. The scale of both is that of
    /// Huber's proposal 2: residuals cut at [`GUARD`] standard deviations have the mean square of normal ones that are cut there.
    /// What is missed for more than a ninth (1/`GUARD`²) of the time is part of the scale. The median of the residuals would take
    /// the twin to be right for half of the time, and such a fit follows that half. Each sample weighs by the inverse of both
    /// together, times Huber's weight beyond [`GUARD`] standard deviations, so that no signal drowns the others.
    pub(super) fn weights(&self, residuals: &DVector<f64>) -> DVector<f64> {
        self.weights_beside(&self.undescribed(residuals), residuals)
    }

    /// S² of each signal; see [`Self::weights`].
    pub(super) fn undescribed(&self, residuals: &DVector<f64>) -> Undescribed {
        let variance = |rows: &Vec<Rows>| {
            let levelled = rows.iter().flat_map(|part| part.levelled(residuals));
            (robust_variance(&levelled.map(|(_, e, _)| e * e).collect::<Vec<f64>>()) - 1.0).max(0.0)
        };
        self.signal_rows().iter().map(|(&signal, rows)| (signal, variance(rows))).collect()
    }

    /// [`Self::weights`] with S² as given.
    pub(super) fn weights_beside(&self, undescribed: &Undescribed, residuals: &DVector<f64>) -> DVector<f64> {
        let mut weights = DVector::from_element(residuals.len(), 1.0);
        for (signal, rows) in self.signal_rows() {
            let structure = undescribed.get(&signal).copied().unwrap_or(0.0);
            for (row, e, profile) in rows.iter().flat_map(|part| part.levelled(residuals)) {
                let noise = profile * profile;
                let spread = (noise + structure).sqrt();
                let huber = GUARD * spread / e.abs().max(GUARD * spread);
                weights[row] = huber * noise / (noise + structure);
            }
        }
        weights
    }

    /// Size of residuals by which fits from different starts are compared: logarithms of the signals' mean squares, so
    /// that none drowns the others, whatever its noise.
    pub(super) fn size(&self, residuals: &DVector<f64>) -> f64 {
        self.signal_rows()
            .values()
            .map(|rows| {
                let levelled = || rows.iter().flat_map(|part| part.levelled(residuals));
                let squares: f64 = levelled().map(|(_, e, profile)| (e / profile).powi(2)).sum();
                let count = rows.iter().map(|part| part.samples).sum::<usize>() as f64;
                (1.0 + squares / count).ln()
            })
            .sum()
    }

    /// Mean square of residuals, every signal weighing the same.
    pub(super) fn mean_square(&self, residuals: &DVector<f64>) -> f64 {
        let signals = self.signal_rows();
        let of = |rows: &Vec<Rows>| {
            let part = |part: &Rows| residuals.rows(part.offset, part.samples).norm_squared();
            let count: usize = rows.iter().map(|part| part.samples).sum();
            rows.iter().map(part).sum::<f64>() / count.max(1) as f64
        };
        signals.values().map(of).sum::<f64>() / signals.len().max(1) as f64
    }

    /// Rows of one signal, a range for each run that has it.
    pub(super) fn rows_of(&self, signal: Signal) -> Vec<Range<usize>> {
        let rows = self.signal_rows().remove(&signal).unwrap_or_default();
        rows.into_iter().map(|part| part.offset..part.offset + part.samples).collect()
    }

    /// Rows of each signal, over all runs.
    fn signal_rows(&self) -> BTreeMap<Signal, Vec<Rows<'_>>> {
        let mut rows: BTreeMap<Signal, Vec<Rows>> = BTreeMap::new();
        let mut offset = 0;
        for experiment in self.experiments {
            for &signal in experiment.signals() {
                let profile = self.floor.profile(experiment, signal);
                let samples = self.rows(experiment);
                rows.entry(signal).or_default().push(Rows { offset, samples, stride: self.stride, profile });
                offset += samples;
            }
        }
        rows
    }
}

/// W·J: each row of a Jacobian by its weight.
pub(super) fn weighted(jacobian: &DMatrix<f64>, weights: &DVector<f64>) -> DMatrix<f64> {
    let mut weighted = jacobian.clone();
    weighted.column_iter_mut().for_each(|mut column| column.component_mul_assign(weights));
    weighted
}

/// Mean of z², at most [`GUARD`]², of a standard normal variable z: `2Φ(g) − 1 − 2g·φ(g) + 2g²·(1 − Φ(g))`.
const GUARDED_SQUARE: f64 = 0.995_007;
/// A scale is known when a round changes it by less than this share.
const SETTLED: f64 = 1e-3;
/// Rounds at most; near the share of a ninth they converge slowly, and the last one counts.
const MOST_ROUNDS: usize = 50;

/// Variance of residuals with these squares, few of which may be anything: T² with `mean(min(e², (g·T)²)) = c·T²`, c the same of
/// a normal variable; 0 of none.
///
/// # Source
/// Huber (1981), *Robust Statistics*, section 6.4, proposal 2.
fn robust_variance(squares: &[f64]) -> f64 {
    let count = squares.len().max(1) as f64;
    let mut variance = squares.iter().sum::<f64>() / count;
    for _ in 0..MOST_ROUNDS {
        let most = GUARD * GUARD * variance;
        let cut = squares.iter().map(|square| square.min(most)).sum::<f64>() / (count * GUARDED_SQUARE);
        let settled = (variance - cut).abs() <= SETTLED * variance;
        variance = cut;
        if settled {
            break;
        }
    }
    variance
}

/// Where one signal of one run stands among the residuals, and its noise profile.
struct Rows<'a> {
    offset: usize,
    samples: usize,
    stride: usize,
    profile: Option<&'a [f64]>,
}

impl Rows<'_> {
    /// Row, residual in units of the signal's noise level, and noise profile of each sample.
    pub(super) fn levelled(&self, residuals: &DVector<f64>) -> impl Iterator<Item = (usize, f64, f64)> {
        (0..self.samples).map(|k| {
            let profile = self.profile.map_or(1.0, |profile| profile[k * self.stride]);
            (self.offset + k, residuals[self.offset + k] * profile, profile)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of normal residuals it is the variance. A fiftieth of jumps hardly counts; a fifth is no short moment, and is the scale.
    #[test]
    fn exact_robust_variance() {
        assert_eq!(robust_variance(&[]), 0.0);
        let normal = statrs::distribution::Normal::standard();
        let beyond = statrs::distribution::ContinuousCDF::sf(&normal, GUARD);
        let density = statrs::distribution::Continuous::pdf(&normal, GUARD);
        let cut = 1.0 - 2.0 * beyond - 2.0 * GUARD * density + 2.0 * GUARD * GUARD * beyond;
        assert!((cut - GUARDED_SQUARE).abs() < 1e-6, "{cut}");
        let quantiles = (0..10_000).map(|k| (f64::from(k) + 0.5) / 10_000.0);
        let squares: Vec<f64> =
            quantiles.map(|q| statrs::distribution::ContinuousCDF::inverse_cdf(&normal, q).powi(2)).collect();
        assert!((robust_variance(&squares) - 1.0).abs() < 3e-3, "{}", robust_variance(&squares));
        // Of ones and a share w of jumps: T² = (1 − w)/(c − 9·w) where that is positive and small, else all of them.
        let beside = |jumps: usize| [vec![1.0; 1000 - jumps], vec![1e6; jumps]].concat();
        let few = robust_variance(&beside(20));
        assert!((few / (0.98 / (GUARDED_SQUARE - 9.0 * 0.02)) - 1.0).abs() < 1e-2, "{few}");
        let many = robust_variance(&beside(200));
        assert!((many / (0.2e6 / GUARDED_SQUARE) - 1.0).abs() < 1e-2, "{many}");
    }
}
