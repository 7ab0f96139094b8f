//! How far an experiment would set two explanations apart.

use super::stage::{Images, Stage};
use crate::diagnose::fit::Fit;
use crate::diagnose::free::Freedom;
use crate::diagnose::phase::follow;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::singular::decomposed;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Step by which a number is varied, in its scales, or a phase in rad: above rounding, below curvature.
const DIFFERENCE: f64 = 1e-3;

/// What a run shows of an explanation: its prediction, and the sensitivities of that to its numbers, in scales.
#[derive(Clone)]
pub(super) struct Seen {
    image: DVector<f64>,
    sensitivities: DMatrix<f64>,
}

impl Seen {
    /// Replays the run as the explanation has it.
    ///
    /// # Errors
    /// Whatever a replay refuses, and values that the machine's description refuses.
    pub(super) fn of(fit: &Fit, stage: &Stage, base: &Machine) -> Result<Self> {
        // Refused values are named as the description names them.
        fit.machine(base)?;
        let (mut sets, mut steps) = (vec![fit.values.clone()], Vec::new());
        for (k, free) in fit.hypothesis.free.iter().enumerate().filter(|(_, free)| !free.held) {
            let mut varied = fit.values.clone();
            let reach = DIFFERENCE * free.reach(fit.values[k]);
            let step = if varied[k] + reach <= free.range.1 { reach } else { -reach };
            if varied[k] + step < free.range.0 {
                continue; // no room to vary
            }
            varied[k] += step;
            sets.push(varied);
            steps.push((k, free.scale / step));
        }
        let Images { of_sets, advanced } = stage.images(base, fit, &sets, DIFFERENCE)?;
        let mut images = of_sets.into_iter();
        let image = images.next().flatten().unwrap_or_default();
        let mut sensitivities = DMatrix::zeros(image.len(), fit.values.len());
        for ((k, per_step), moved) in steps.into_iter().zip(images) {
            // A value that the description refuses is one that a fit cannot take either.
            let Some(moved) = moved else { continue };
            sensitivities.set_column(k, &((moved - &image) * per_step));
        }
        if let Some(advanced) = advanced {
            // A run's own phase, or place in the play, moves with every number.
            let (even, all) = (DVector::from_element(image.len(), 1.0), 0..image.len());
            follow(&mut sensitivities, &(advanced - &image), &even, &[all]);
        }
        Ok(Self { image, sensitivities })
    }
}

/// Expected difference of log-likelihood between two explanations, in nats, and the signals that tell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Separation {
    pub(super) nats: f64,
    /// Share of each signal.
    pub(super) signals: Vec<(Signal, f64)>,
}

/// One explanation refitted to data that another one predicts: the sums of that least-squares problem.
///
/// # Model
/// With δ the difference of the two predictions in weighted units of noise, J the sensitivities of the one that is
/// false, p the distance of its calibrated constants from their stated values in standard deviations, and W the standard deviations in
/// a step of each number, its new fit moves its numbers by the Δ that minimises `‖δ + J·Δ‖² + ‖p + W·Δ‖² − ‖p‖²`. Half of what is left is what it cannot take up.
///
/// # Validity
/// Linear in Δ; bounds of the numbers are not looked at.
#[derive(Clone)]
struct Refit {
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
    energy: f64,
}

impl Refit {
    fn new(fit: &Fit) -> Self {
        let (weight, gradient) = fit.hypothesis.prior(&fit.values);
        Self { normal: DMatrix::from_diagonal(&weight), gradient, energy: 0.0 }
    }

    fn of((fit, seen): &(Fit, Vec<Seen>), truth: &[Seen]) -> Self {
        let mut refit = Self::new(fit);
        seen.iter().zip(truth).for_each(|(wrong, truth)| refit.add(wrong, truth));
        refit
    }

    fn add(&mut self, wrong: &Seen, truth: &Seen) {
        let difference = &wrong.image - &truth.image;
        self.normal += wrong.sensitivities.tr_mul(&wrong.sensitivities);
        self.gradient += wrong.sensitivities.tr_mul(&difference);
        self.energy += difference.norm_squared();
    }

    /// Nats that are left, and how the numbers move; none where something is not finite.
    fn left(&self) -> Option<(f64, DVector<f64>)> {
        let norm = self.normal.norm();
        if !(norm.is_finite() && self.energy.is_finite()) {
            return None;
        }
        let inverse =
            decomposed(self.normal.clone())?.pseudo_inverse(1e-12 * norm.max(f64::MIN_POSITIVE)).ok()?;
        let moved = -(inverse * &self.gradient);
        Some((0.5 * (self.energy + self.gradient.dot(&moved)).max(0.0), moved))
    }
}

/// What several runs show of an explanation.
///
/// # Errors
/// Whatever a replay refuses.
pub(super) fn on_all(fit: &Fit, stages: &[Stage], machine: &Machine) -> Result<Vec<Seen>> {
    stages.par_iter().map(|stage| Seen::of(fit, stage, machine)).collect()
}

/// Refits at most.
const MOST_REFITS: usize = 8;
/// So many in a row that come no closer end it: one may overshoot, and the next one comes back then or not at all.
const MOST_FRUITLESS: usize = 2;
/// A misfit of so many nats is none.
const ARRIVED: f64 = 0.1;

/// The explanation refitted to what another one predicts for the recorded runs.
///
/// Two explanations may say the same with far different numbers (a scale here, a constant there), farther than
/// sensitivities reach: they are compared where they come closest.
///
/// # Errors
/// Whatever a replay refuses.
pub(super) fn refitted(
    fit: &Fit,
    truth: &[Seen],
    stages: &[Stage],
    machine: &Machine,
) -> Result<(Fit, Vec<Seen>)> {
    let mut now = (fit.clone(), on_all(fit, stages, machine)?);
    let mut best = now.clone();
    let mut fruitless = 0;
    for _ in 0..MOST_REFITS {
        let Some((_, moved)) = Refit::of(&now, truth).left() else { break };
        let mut next = now.0.clone();
        for (k, free) in fit.hypothesis.free.iter().enumerate() {
            next.values[k] += moved[k] * free.scale;
            // Calibration is drawn back by its tolerance: stopped at its edge on the way it would distort the step.
            if free.freedom == Freedom::Cause {
                next.values[k] = next.values[k].clamp(free.range.0, free.range.1);
            }
        }
        let Ok(seen) = on_all(&next, stages, machine) else { break };
        // A far step along a curved valley overshoots first; the next one comes back to its floor.
        now = (next, seen);
        let gain = misfit(&best, truth) - misfit(&now, truth);
        if gain > 0.0 {
            best = now.clone();
        }
        fruitless = if gain > 0.0 { 0 } else { fruitless + 1 };
        if (0.0..ARRIVED).contains(&gain) || fruitless == MOST_FRUITLESS {
            break;
        }
    }
    Ok(best)
}

/// Half the squared distance of two explanations' predictions in weighted units of noise: what telling them apart as they
/// stand is worth, in nats.
pub(super) fn distance(a: &[Seen], b: &[Seen]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (&a.image - &b.image).norm_squared()).sum::<f64>()
}

/// Misfit of an explanation to what another predicts, its calibration's distance from the stated values included,
/// in nats.
fn misfit((fit, seen): &(Fit, Vec<Seen>), truth: &[Seen]) -> f64 {
    distance(seen, truth) + fit.hypothesis.strain(&fit.values)
}

/// Two explanations on the runs recorded so far: each refitted to what the other predicts for all of them.
pub(super) struct Pair {
    refits: [Refit; 2],
}

impl Pair {
    /// The pair on the recorded runs, each shown as both explanations have it.
    pub(super) fn new([a, b]: [&Fit; 2], recorded: [&[Seen]; 2]) -> Self {
        let mut refits = [Refit::new(a), Refit::new(b)];
        for (a, b) in recorded[0].iter().zip(recorded[1]) {
            refits[0].add(a, b);
            refits[1].add(b, a);
        }
        Self { refits }
    }

    /// How far the recorded runs set the two apart, whichever is true, in nats.
    pub(super) fn known(&self) -> f64 {
        let left = |refit: &Refit| refit.left().map_or(f64::INFINITY, |(nats, _)| nats);
        left(&self.refits[0]).min(left(&self.refits[1]))
    }

    /// How far a further run sets them apart, whichever is true: the smaller of both cases.
    pub(super) fn further(&self, stage: &Stage, [a, b]: [&Seen; 2]) -> Option<Separation> {
        let case = |refit: &Refit, wrong: &Seen, truth: &Seen| {
            let (before, _) = refit.left()?;
            let mut more = refit.clone();
            more.add(wrong, truth);
            let (after, moved) = more.left()?;
            let residual = &wrong.image - &truth.image + &wrong.sensitivities * moved;
            let shares = stage.shares(&residual);
            let total: f64 = shares.iter().map(|(_, share)| share).sum();
            let share = |(signal, share): (Signal, f64)| (signal, share / total.max(f64::MIN_POSITIVE));
            Some(Separation {
                nats: (after - before).max(0.0),
                signals: shares.into_iter().map(share).collect(),
            })
        };
        let [first, second] = [case(&self.refits[0], a, b)?, case(&self.refits[1], b, a)?];
        Some(if first.nats <= second.nats { first } else { second })
    }
}
