//! Levenberg–Marquardt between bounds: from a start to where a hypothesis fits best.

use super::bounded;
use super::care::{Care, ROUGH_ITERATIONS};
use super::hypothesis::Free;
use super::objective::{Objective, Undescribed};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// Damping of the first step: small, since what is new in a hypothesis and what is calibrated beside it often compensate
/// each other almost wholly (drag and back-EMF), and a damped step does not leave such a valley's wall.
const FIRST_DAMPING: f64 = 1e-6;
/// Damping below which a step is that of Gauss and Newton, also along a valley in which numbers compensate each other to 10⁻⁶ and
/// the tolerances alone tell them apart.
const SMALLEST_DAMPING: f64 = 1e-14;
/// Damping beyond which a step is a hundredth of that down the gradient, number by number: none that falls is longer.
const LARGEST_DAMPING: f64 = 100.0;
/// What a step that falls makes of the damping, and one that does not: tenfold as D. W. Marquardt (1963), *An algorithm for
/// least-squares estimation of nonlinear parameters*, J. SIAM 11:431, and faster upward, where each trial costs a replay. They
/// change how soon a fit arrives, not where.
const LESS_DAMPING: f64 = 0.1;
const MORE_DAMPING: f64 = 20.0;
/// Smallest element of the diagonal that damps: a parameter that the data do not determine stays where it is.
const SMALLEST_DIAGONAL: f64 = 1e-12;

/// Where a descent ended.
pub(super) struct Arrived {
    pub(super) values: Vec<f64>,
    /// The residuals there.
    pub(super) residuals: DVector<f64>,
    /// Their derivatives, where the last step took them there.
    pub(super) jacobian: Option<DMatrix<f64>>,
}

/// Descends from a start until a step falls no further, at most so many steps.
///
/// # Errors
/// A setting of a run that the machine does not have.
pub(super) fn descend(
    objective: &Objective,
    mut values: Vec<f64>,
    care: Care,
    iterations: usize,
) -> Result<Arrived> {
    let free = &objective.hypothesis.free;
    let mut residuals = objective.residuals(&values)?;
    let mut damping = FIRST_DAMPING;
    if free.is_empty() {
        return Ok(Arrived { values, residuals, jacobian: None });
    }
    let mut last = None;
    let mut undescribed = Undescribed::new();
    for iteration in 0..iterations {
        let latest = objective.undescribed(&residuals);
        // With a variance of its own at each step the sum of squares is another one each time, and a descent may go around in circles. After as many
        // steps as a rough fit has, the variance may only fall: Huber's weights alone majorise one fixed loss, and the descent ends.
        let held = |(signal, variance): (_, f64)| match iteration < ROUGH_ITERATIONS {
            true => (signal, variance),
            false => (signal, variance.min(undescribed[&signal])),
        };
        undescribed = latest.into_iter().map(held).collect();
        let weights = objective.weights_beside(&undescribed, &residuals);
        let cost = objective.cost(&residuals, &weights, &values);
        let jacobian = objective.jacobian(&values, &residuals, care.known())?;
        let (normal, gradient) = objective.normal(&jacobian, &residuals, &weights, &values);
        last = Some(jacobian);
        let model = Model { free, values: &values, normal, gradient };
        let fall = model.step(SMALLEST_DAMPING).map(|step| model.fall(&step));
        if fall.is_some_and(|fall| fall <= care.arrived(cost)) {
            break;
        }
        let begun = damping;
        let mut next = None;
        let mut tried: Option<DVector<f64>> = None;
        while damping < LARGEST_DAMPING {
            let step = model.step(damping);
            let moved = step.as_ref().map(|step| model.moved(step));
            if moved.as_ref() == Some(&values) {
                break;
            }
            // A step that hardly differs from the last one, which did not fall, is not replayed.
            let is_new = |step: &DVector<f64>| tried.as_ref().is_none_or(|last| differs(step, last));
            if let Some((step, moved)) = step.filter(is_new).zip(moved) {
                let trial = objective.residuals(&moved)?;
                let trial_cost = objective.cost(&trial, &weights, &moved);
                if trial_cost < cost {
                    next = Some((moved, trial, cost - trial_cost));
                    break;
                }
                tried = Some(step);
            }
            damping *= MORE_DAMPING;
        }
        let Some((moved, trial, fall)) = next else { break };
        (values, residuals, last) = (moved, trial, None);
        // A narrow valley, in which numbers compensate each other, is walked along only by a step that is hardly
        // damped: a fit has arrived when, that one tried first, none falls further.
        let arrived = fall <= care.arrived(cost);
        if arrived && !(begun > SMALLEST_DAMPING && matches!(care, Care::Thorough)) {
            break;
        }
        damping = if arrived { SMALLEST_DAMPING } else { (damping * LESS_DAMPING).max(SMALLEST_DAMPING) };
    }
    Ok(Arrived { values, residuals, jacobian: last })
}

/// Two steps differ where their difference is longer than this share of either.
const OTHER_STEP: f64 = 0.01;

fn differs(step: &DVector<f64>, last: &DVector<f64>) -> bool {
    (step - last).norm() > OTHER_STEP * step.norm()
}

/// The cost near some values as a quadratic form; steps are in units of the numbers' scales.
struct Model<'a> {
    free: &'a [Free],
    values: &'a [f64],
    normal: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Model<'_> {
    /// The damped step that makes the form smallest inside the ranges.
    fn step(&self, damping: f64) -> Option<DVector<f64>> {
        let mut matrix = self.normal.clone();
        for k in 0..self.free.len() {
            matrix[(k, k)] += damping * matrix[(k, k)].max(SMALLEST_DIAGONAL);
        }
        let bounds = self.free.iter().zip(self.values).map(|(free, value)| match free.held {
            true => (0.0, 0.0),
            false => {
                let (low, high) = free.range;
                (((low - value) / free.scale).min(0.0), ((high - value) / free.scale).max(0.0))
            }
        });
        bounded::minimum(&matrix, &self.gradient, &bounds.collect::<Vec<_>>())
    }

    /// Fall of the cost that the form predicts for a step, twice the Newton decrement for a whole one.
    fn fall(&self, step: &DVector<f64>) -> f64 {
        -2.0 * self.gradient.dot(step) - step.dot(&(&self.normal * step))
    }

    /// Values after a step; what ends on an edge is there exactly.
    fn moved(&self, step: &DVector<f64>) -> Vec<f64> {
        let pairs = self.free.iter().zip(self.values).enumerate();
        pairs
            .map(|(k, (free, value))| match step[k] == 0.0 {
                true => *value,
                false => (value + step[k] * free.scale).clamp(free.range.0, free.range.1),
            })
            .collect()
    }
}
