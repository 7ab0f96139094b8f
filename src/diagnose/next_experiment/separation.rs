//! How far an experiment would set two explanations apart.

use super::stage::Stage;
use crate::diagnose::fit::Fit;
use crate::diagnose::hypothesis::Freedom;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use nalgebra::{DMatrix, DVector};

/// Step by which a number is varied, in its scales: above rounding, below curvature.
const DIFFERENCE: f64 = 1e-3;

/// An explanation, and how tightly the runs that are there hold its numbers.
pub(super) struct Rival<'a> {
    /// Its fit.
    pub(super) fit: &'a Fit,
    /// Its weight among the rivals.
    pub(super) weight: f64,
    /// Normal matrix of its numbers on the recorded runs, prior of calibration included, in scales.
    held: DMatrix<f64>,
}

impl<'a> Rival<'a> {
    /// The explanation on the runs that are there.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn new(fit: &'a Fit, weight: f64, machine: &Machine, recorded: &[Stage]) -> Result<Self> {
        let free = &fit.hypothesis.free;
        let prior = DVector::from_fn(free.len(), |k, _| f64::from(free[k].freedom == Freedom::Calibration));
        let mut held = DMatrix::from_diagonal(&prior);
        for stage in recorded {
            let sensitivities = sensitivities(stage, machine, fit, &stage.image(machine, fit, &fit.values)?);
            held += sensitivities.tr_mul(&sensitivities);
        }
        Ok(Self { fit, weight, held })
    }

    /// What an experiment shows of it.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub(super) fn seen(&self, stage: &Stage, base: &Machine) -> Result<Seen> {
        let image = stage.image(base, self.fit, &self.fit.values)?;
        let sensitivities = sensitivities(stage, base, self.fit, &image);
        Ok(Seen { image, sensitivities })
    }
}

/// A prediction and its sensitivities to the explanation's numbers, in scales.
pub(super) struct Seen {
    image: DVector<f64>,
    sensitivities: DMatrix<f64>,
}

fn sensitivities(stage: &Stage, base: &Machine, fit: &Fit, image: &DVector<f64>) -> DMatrix<f64> {
    let free = &fit.hypothesis.free;
    let mut columns = DMatrix::zeros(image.len(), free.len());
    for (k, free) in free.iter().enumerate().filter(|(_, free)| !free.held) {
        let mut varied = fit.values.clone();
        let reach = DIFFERENCE * free.scale;
        let step = if varied[k] + reach <= free.range.1 { reach } else { -reach };
        if varied[k] + step < free.range.0 {
            continue; // no room to vary
        }
        varied[k] += step;
        // A value that the description refuses is one that a fit cannot take either.
        let Ok(moved) = stage.image(base, fit, &varied) else { continue };
        columns.set_column(k, &((moved - image) * (free.scale / step)));
    }
    columns
}

/// Expected difference of log-likelihood between two explanations, in nats, and the signals that tell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Separation {
    pub(super) nats: f64,
    /// Share of each signal.
    pub(super) signals: Vec<(Signal, f64)>,
}

/// How far the experiment sets two explanations apart, whichever is true: the smaller of both cases.
///
/// # Model
/// With δ the difference of the two predictions in weighted units of noise, J the sensitivities of the one that is
/// false and N its normal matrix on the runs recorded so far, a new fit to old and new runs together moves its
/// numbers by Δ = −(JᵀJ + N)⁻¹·Jᵀδ; what it cannot take up is `½·(δᵀδ − δᵀJ·(JᵀJ + N)⁻¹·Jᵀδ)`.
///
/// # Validity
/// Linear in Δ. Two explanations that only the recorded runs hold apart in their numbers stay apart by what those runs
/// would then misfit.
pub(super) fn separation(stage: &Stage, [a, b]: [(&Rival, &Seen); 2]) -> Option<Separation> {
    let [first, second] = [left(stage, a, b)?, left(stage, b, a)?];
    Some(if first.nats <= second.nats { first } else { second })
}

/// What the first explanation, refitted, leaves of data that the second predicts.
fn left(stage: &Stage, (rival, seen): (&Rival, &Seen), (_, truth): (&Rival, &Seen)) -> Option<Separation> {
    let difference = &seen.image - &truth.image;
    let normal = seen.sensitivities.tr_mul(&seen.sensitivities) + &rival.held;
    let gradient = seen.sensitivities.tr_mul(&difference);
    let norm = normal.norm();
    if !(norm.is_finite() && difference.iter().all(|x| x.is_finite())) {
        return None;
    }
    let inverse = normal.pseudo_inverse(1e-12 * norm.max(f64::MIN_POSITIVE)).ok()?;
    let moved = -(&inverse * &gradient);
    let energy = (difference.norm_squared() + gradient.dot(&moved)).max(0.0);
    let residual = difference + &seen.sensitivities * moved;
    let shares = stage.shares(&residual);
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let signals = shares.into_iter().map(|(signal, share)| (signal, share / total.max(f64::MIN_POSITIVE)));
    Some(Separation { nats: 0.5 * energy, signals: signals.collect() })
}
