//! Levenberg–Marquardt between bounds: from a start to where a hypothesis fits best.

use super::bounded;
use super::care::{ARRIVED, Care, ROUGH_ITERATIONS, ROUGHLY_ARRIVED};
use super::free::Free;
use super::objective::{Objective, Undescribed};
use super::sandwich::scatter;
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

/// Where a descent begins.
#[derive(Clone)]
pub(super) struct InitialGuess {
    pub(super) values: Vec<f64>,
    /// The residuals there.
    pub(super) residuals: DVector<f64>,
}

impl InitialGuess {
    /// At these values of an objective.
    ///
    /// # Errors
    /// A setting of a run that the machine does not have.
    pub(super) fn at(objective: &Objective, values: Vec<f64>) -> Result<Self> {
        let residuals = objective.residuals(&values)?;
        Ok(Self { values, residuals })
    }
}

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
    InitialGuess { mut values, mut residuals }: InitialGuess,
    care: Care,
    iterations: usize,
) -> Result<Arrived> {
    let free = &objective.hypothesis.free;
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
        let model = Model { free, values: &values, normal, gradient };
        let here = Here { residuals: &residuals, jacobian: &jacobian, weights: &weights, iteration };
        let step = model.step(SMALLEST_DAMPING);
        let little = match care {
            Care::Rough(_) => ROUGHLY_ARRIVED * cost,
            Care::Thorough => {
                ARRIVED * step.as_ref().map_or(1.0, |step| here.inflation(objective, &model, step))
            }
        };
        if step.is_some_and(|step| model.fall(&step) <= little) {
            last = Some(jacobian);
            break;
        }
        let begun = damping;
        let tried = |values: &[f64]| {
            let there = objective.residuals(values)?;
            let fall = cost - objective.cost(&there, &weights, values);
            Ok((there, fall))
        };
        let Some(next) = here.next(&model, &mut damping, little, &tried)? else {
            last = Some(jacobian);
            break;
        };
        (values, residuals, last) = (next.values, next.residuals, None);
        // A narrow valley, in which numbers compensate each other, is walked along only by a step that is hardly
        // damped: a fit has arrived when none falls further after that one was tried.
        let arrived = next.fall <= little;
        if arrived && !(begun > SMALLEST_DAMPING && matches!(care, Care::Thorough)) {
            break;
        }
        damping = if arrived { SMALLEST_DAMPING } else { (damping * LESS_DAMPING).max(SMALLEST_DAMPING) };
    }
    Ok(Arrived { values, residuals, jacobian: last })
}

/// Where a step is taken from.
struct Here<'a> {
    residuals: &'a DVector<f64>,
    jacobian: &'a DMatrix<f64>,
    weights: &'a DVector<f64>,
    iteration: usize,
}

/// Where a step leads that falls.
struct Next {
    values: Vec<f64>,
    residuals: DVector<f64>,
    fall: f64,
}

/// The first correction of a step is trusted up to this share of it, half of 0.75 (Transtrum and Sethna, whose ratio is of the whole second
/// derivative), each further one up to this share of the one before.
const MOST_CORRECTION: f64 = 0.375;
/// Corrections of one step at most, each of which costs a replay.
const CORRECTIONS: usize = 4;

impl Here<'_> {
    /// Ratio of the variance that autocorrelated and uneven residuals give the numbers along a step s to that of white ones, `sᵀ(B + P)s / sᵀHs`; at
    /// least 1. B is the scatter of the gradient, H the normal matrix, P the prior's part of it.
    fn inflation(&self, objective: &Objective, model: &Model, step: &DVector<f64>) -> f64 {
        let (prior, _) = objective.hypothesis.prior(model.values);
        let scatter = scatter(objective, self.jacobian, &self.weights.component_mul(self.residuals));
        let robust = scatter + DMatrix::from_diagonal(&prior);
        (step.dot(&(robust * step)) / step.dot(&(&model.normal * step))).max(1.0)
    }

    /// The first step that falls, ever more damped; none where not even a short one does, or one that would fall by little more than nothing. `tried` gives the residuals
    /// at some values, and by how much the cost falls on the way there.
    fn next(
        &self,
        model: &Model,
        damping: &mut f64,
        little: f64,
        tried: &impl Fn(&[f64]) -> Result<(DVector<f64>, f64)>,
    ) -> Result<Option<Next>> {
        let mut last: Option<DVector<f64>> = None;
        while *damping < LARGEST_DAMPING {
            let step = model.step(*damping);
            let moved = step.as_ref().map(|step| model.moved(step));
            if moved.as_deref() == Some(model.values) {
                break;
            }
            // More damping promises less still.
            if last.is_some() && step.as_ref().is_some_and(|step| model.fall(step) <= little) {
                break;
            }
            // A step that hardly differs from the last one, which did not fall, is not replayed.
            let is_new = |step: &DVector<f64>| last.as_ref().is_none_or(|last| model.differ(step, last));
            if let Some((step, moved)) = step.filter(is_new).zip(moved) {
                if let Some(next) = self.corrected(model, &step, moved, *damping, tried)? {
                    return Ok(Some(next));
                }
                last = Some(step);
            }
            *damping *= MORE_DAMPING;
        }
        Ok(None)
    }

    /// Where a step leads that falls, itself or after second-order corrections; none where it does not fall.
    ///
    /// # Model
    /// A step v that does not fall shows how the residuals depart from the linear model on its way: `b = r(θ + v) − r(θ) − J·v`. The step s that
    /// would lead to the least `‖r + b + J·s‖²` is tried next, and corrected again as long as that converges: in a curved valley it is as long as v, and a damped step is
    /// short. The first steps of a descent find a valley, and are not corrected.
    ///
    /// # Source
    /// M. K. Transtrum, J. P. Sethna (2012), *Improvements to the Levenberg–Marquardt algorithm for nonlinear least-squares minimization*,
    /// arXiv:1201.5885, geodesic acceleration; here the curvature is taken over the whole step, which costs no replay of its own.
    fn corrected(
        &self,
        model: &Model,
        step: &DVector<f64>,
        mut moved: Vec<f64>,
        damping: f64,
        tried: &impl Fn(&[f64]) -> Result<(DVector<f64>, f64)>,
    ) -> Result<Option<Next>> {
        let corrections = if self.iteration < ROUGH_ITERATIONS { 0 } else { CORRECTIONS };
        let (mut way, mut trusted) = (step.clone(), MOST_CORRECTION * model.length(step));
        for correction in 0..=corrections {
            let (residuals, fall) = tried(&moved)?;
            if fall > 0.0 {
                return Ok(Some(Next { values: moved, residuals, fall }));
            }
            if correction == corrections {
                break;
            }
            let curvature = residuals - self.residuals - self.jacobian * &way;
            let pull = self.jacobian.tr_mul(&curvature.component_mul(self.weights));
            let Some(next) = model.least(&(&model.gradient + pull), damping) else { break };
            let change = model.length(&(&next - &way));
            if change <= 0.0 || change > trusted {
                break;
            }
            trusted = MOST_CORRECTION * change;
            moved = model.moved(&next);
            way = next;
        }
        Ok(None)
    }
}

/// Two steps differ where their difference changes the residuals by more than this share of what either does.
const OTHER_STEP: f64 = 0.01;

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
        self.least(&self.gradient, damping)
    }

    /// Length of a step in the metric of the damping.
    fn length(&self, step: &DVector<f64>) -> f64 {
        step.component_mul(&self.normal.diagonal().map(f64::sqrt)).norm()
    }

    /// Whether two steps differ, each number in proportion to what it changes of the residuals.
    fn differ(&self, step: &DVector<f64>, last: &DVector<f64>) -> bool {
        self.length(&(step - last)) > OTHER_STEP * self.length(step)
    }

    /// The damped step that makes the form with this gradient smallest inside the ranges.
    fn least(&self, gradient: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
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
        bounded::minimum(&matrix, gradient, &bounds.collect::<Vec<_>>())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::free::tests::number;
    use crate::effect::EffectId;

    /// On the floor of Rosenbrock's valley, r = (100·(y − x²), 1 − x), the undamped step ends far up its wall. Corrected once it ends in the
    /// minimum: the second derivative of a parabola is the same everywhere.
    #[test]
    fn exact_a_curved_valley_is_followed_to_its_end() {
        let residuals = |at: &[f64]| DVector::from_vec(vec![100.0 * (at[1] - at[0] * at[0]), 1.0 - at[0]]);
        let free = ["x", "y"].map(|name| number(EffectId::Cogging, name));
        let values = [0.5, 0.25];
        let begun = residuals(&values);
        let jacobian = DMatrix::from_row_slice(2, 2, &[-100.0, 100.0, -1.0, 0.0]);
        let (normal, gradient) = (jacobian.tr_mul(&jacobian), jacobian.tr_mul(&begun));
        let model = Model { free: &free, values: &values, normal, gradient };
        let weights = DVector::from_element(2, 1.0);
        let tried = |at: &[f64]| {
            let there = residuals(at);
            let fall = begun.norm_squared() - there.norm_squared();
            Ok((there, fall))
        };
        let from = |iteration: usize| {
            let here = Here { residuals: &begun, jacobian: &jacobian, weights: &weights, iteration };
            let mut damping = SMALLEST_DAMPING;
            here.next(&model, &mut damping, 0.0, &tried).ok().flatten().map(|next| (next, damping))
        };
        let (next, damping) = from(ROUGH_ITERATIONS).unwrap_or_else(|| unreachable!());
        assert!(next.residuals.norm() < 1e-6 && damping == SMALLEST_DAMPING, "{:?}", next.values);
        // Without corrections only a damped step falls.
        let (next, damping) = from(0).unwrap_or_else(|| unreachable!());
        assert!(next.residuals.norm() > 0.1 && damping > SMALLEST_DAMPING, "{:?}", next.values);
    }
}
