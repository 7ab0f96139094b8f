//! Minimum of a quadratic form between bounds: the step of a fit whose parameters have ranges.

use nalgebra::{DMatrix, DVector};

/// Active sets looked at, as a multiple of the parameters; each is better than the one before, few are needed.
const SETS_PER_PARAMETER: usize = 8;

/// The s between these bounds, each from at most zero to at least zero, at which `gᵀs + ½·sᵀMs` is smallest; none where M is not
/// positive definite.
///
/// # Model
/// A bound is active, and its parameter stays on it, or the parameter is free. The free ones go from where they are to the minimum
/// over them, and on the way the first one that comes to a bound stays there; where all arrive, the bound whose multiplier is largest
/// against it is released. The form falls with every active set, so that the step falls too wherever it ends; parameters that are
/// cut off at their bounds one by one may make it rise.
///
/// # Source
/// P. B. Stark, R. L. Parker (1995), *Bounded-variable least-squares*, Computational Statistics 10:129.
pub fn minimum(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    bounds: &[(f64, f64)],
) -> Option<DVector<f64>> {
    let count = bounds.len();
    let mut step = DVector::zeros(count);
    let mut active: Vec<bool> = bounds.iter().map(|(low, high)| *low >= 0.0 || *high <= 0.0).collect();
    // What is released and comes back at once is on its bound: the multiplier was rounding.
    let mut stays = vec![false; count];
    let mut released = None;
    for _ in 0..SETS_PER_PARAMETER * count + 1 {
        let target = free_minimum(matrix, gradient, &step, &active)?;
        if let Some(Stop { share, parameter, bound }) = first_stop(&step, &target, bounds, &active) {
            step += (target - &step) * share;
            step[parameter] = bound;
            active[parameter] = true;
            if released == Some(parameter) && share <= 0.0 {
                stays[parameter] = true;
            } else {
                stays.fill(false);
            }
            continue;
        }
        step = target;
        let slope = gradient + matrix * &step;
        let inward = |k: usize| {
            let (low, high) = bounds[k];
            let into = if step[k] <= low { -slope[k] } else { slope[k] };
            (low < high).then(|| into / matrix[(k, k)].sqrt()).filter(|fall| *fall > 0.0)
        };
        let held = (0..count).filter(|&k| active[k] && !stays[k]);
        let best = held.filter_map(|k| Some((k, inward(k)?))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((k, _)) = best else { break };
        active[k] = false;
        released = Some(k);
    }
    Some(step)
}

/// Where the way to a target first meets a bound.
struct Stop {
    /// Share of the way.
    share: f64,
    parameter: usize,
    bound: f64,
}

/// The first bound of a free parameter on the way to a target; none where the target is inside all of them.
fn first_stop(
    step: &DVector<f64>,
    target: &DVector<f64>,
    bounds: &[(f64, f64)],
    active: &[bool],
) -> Option<Stop> {
    let free = (0..bounds.len()).filter(|&k| !active[k]);
    let stops = free.filter_map(|k| {
        let bound = target[k].clamp(bounds[k].0, bounds[k].1);
        let share = ((bound - step[k]) / (target[k] - step[k])).clamp(0.0, 1.0);
        (bound != target[k]).then_some(Stop { share, parameter: k, bound })
    });
    stops.min_by(|a, b| a.share.total_cmp(&b.share))
}

/// Minimum over the free parameters, the others where they are.
fn free_minimum(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    step: &DVector<f64>,
    active: &[bool],
) -> Option<DVector<f64>> {
    let free: Vec<usize> = (0..active.len()).filter(|&k| !active[k]).collect();
    let held: Vec<usize> = (0..active.len()).filter(|&k| active[k]).collect();
    let part = DMatrix::from_fn(free.len(), free.len(), |r, c| matrix[(free[r], free[c])]);
    let right = DVector::from_fn(free.len(), |r, _| {
        let pushed: f64 = held.iter().map(|&c| matrix[(free[r], c)] * step[c]).sum();
        -gradient[free[r]] - pushed
    });
    let solved = part.cholesky()?.solve(&right);
    let mut target = step.clone();
    for (place, &k) in free.iter().enumerate() {
        target[k] = solved[place];
    }
    Some(target)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::rngs::StdRng;
    use rand::{RngExt, SeedableRng};

    fn value(matrix: &DMatrix<f64>, gradient: &DVector<f64>, step: &DVector<f64>) -> f64 {
        gradient.dot(step) + 0.5 * step.dot(&(matrix * step))
    }

    /// Minimum over every choice of parameters that are on their lower or upper bound or free.
    fn by_enumeration(matrix: &DMatrix<f64>, gradient: &DVector<f64>, bounds: &[(f64, f64)]) -> f64 {
        let count = bounds.len() as u32;
        let mut smallest = f64::INFINITY;
        for choice in 0..3_usize.pow(count) {
            let place = |k: usize| choice / 3_usize.pow(k as u32) % 3;
            let active: Vec<bool> = (0..bounds.len()).map(|k| place(k) < 2).collect();
            let step = DVector::from_fn(bounds.len(), |k, _| [bounds[k].0, bounds[k].1, 0.0][place(k)]);
            let Some(step) = free_minimum(matrix, gradient, &step, &active) else { continue };
            let inside = step.iter().zip(bounds).all(|(s, (low, high))| *low <= *s && *s <= *high);
            if inside {
                smallest = smallest.min(value(matrix, gradient, &step));
            }
        }
        smallest
    }

    /// Parameters that compensate each other to 10⁻³, some on a bound, some held: the minimum is that of all active sets.
    #[test]
    fn exact_minimum_between_bounds_is_that_of_the_best_active_set() {
        let mut draw = StdRng::seed_from_u64(5);
        for _ in 0..300 {
            let columns = DMatrix::from_fn(8, 4, |_, _| draw.random_range(-1.0..1.0));
            let common = DVector::from_fn(8, |_, _| draw.random_range(-1.0..1.0));
            let alike = DMatrix::from_fn(8, 4, |r, c| common[r] + 1e-3 * columns[(r, c)]);
            let matrix = alike.tr_mul(&alike);
            let gradient = alike.tr_mul(&DVector::from_fn(8, |_, _| draw.random_range(-1.0..1.0)));
            let mut edge = || if draw.random_range(0..3) == 0 { 0.0 } else { draw.random_range(0.0..2.0) };
            let bounds: Vec<(f64, f64)> = (0..4).map(|_| (-edge(), edge())).collect();
            let step = minimum(&matrix, &gradient, &bounds).unwrap();
            let inside = step.iter().zip(&bounds).all(|(s, (low, high))| *low <= *s && *s <= *high);
            let (own, best) = (value(&matrix, &gradient, &step), by_enumeration(&matrix, &gradient, &bounds));
            assert!(inside && own <= best + 1e-9 * best.abs().max(1e-6), "{own} {best} {bounds:?}");
        }
    }

    #[test]
    fn exact_what_is_held_stays_and_what_is_singular_is_refused() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let gradient = DVector::from_vec(vec![-3.0, -3.0]);
        let step = minimum(&matrix, &gradient, &[(0.0, 0.0), (-9.0, f64::INFINITY)]).unwrap();
        assert!(step[0] == 0.0 && (step[1] - 1.5).abs() < 1e-12, "{step}");
        let singular = DMatrix::from_element(2, 2, 1.0) * -1.0;
        assert!(minimum(&singular, &gradient, &[(-1.0, 1.0); 2]).is_none());
    }
}
