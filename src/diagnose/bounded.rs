//! The least of a quadratic form between bounds: the step of a fit whose numbers have ranges.

use nalgebra::{DMatrix, DVector};

/// Active sets looked at, as a multiple of the numbers; each is better than the one before, few are needed.
const SETS_PER_NUMBER: usize = 8;

/// The s between these bounds, each from at most zero to at least zero, at which `gᵀs + ½·sᵀMs` is least; none where M is not
/// positive definite.
///
/// # Model
/// Numbers are on an edge or free. The free ones go from where they are to the least of the form, and on the way the first one that
/// comes to its edge stays there; where all arrive, the number whose multiplier speaks most for the inside is freed. The form falls
/// with every set, so that the step falls too wherever it ends; numbers that are cut off at their edges one by one may make it rise.
///
/// # Source
/// P. B. Stark, R. L. Parker (1995), *Bounded-variable least-squares*, Computational Statistics 10:129.
pub fn least(matrix: &DMatrix<f64>, gradient: &DVector<f64>, bounds: &[(f64, f64)]) -> Option<DVector<f64>> {
    let count = bounds.len();
    let mut step = DVector::zeros(count);
    let mut on_edge: Vec<bool> = bounds.iter().map(|(low, high)| *low >= 0.0 || *high <= 0.0).collect();
    // What is freed and comes back at once is on its edge: the multiplier was rounding.
    let mut stays = vec![false; count];
    let mut freed = None;
    for _ in 0..SETS_PER_NUMBER * count + 1 {
        let target = least_of_free(matrix, gradient, &step, &on_edge)?;
        let (share, edge) = way(&step, &target, bounds, &on_edge);
        step = if share < 1.0 { &step + (&target - &step) * share } else { target };
        if let Some(k) = edge {
            step[k] = step[k].clamp(bounds[k].0, bounds[k].1);
            if freed == Some(k) && share <= 0.0 {
                stays[k] = true;
            } else {
                stays.fill(false);
            }
            step[k] = nearer(step[k], bounds[k]);
            on_edge[k] = true;
            continue;
        }
        let slope = gradient + matrix * &step;
        let inward = |k: usize| {
            let (low, high) = bounds[k];
            let into = if step[k] <= low { -slope[k] } else { slope[k] };
            (low < high).then(|| into / matrix[(k, k)].sqrt()).filter(|fall| *fall > 0.0)
        };
        let open = (0..count).filter(|&k| on_edge[k] && !stays[k]);
        let best = open.filter_map(|k| Some((k, inward(k)?))).max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((k, _)) = best else { break };
        on_edge[k] = false;
        freed = Some(k);
    }
    Some(step)
}

/// The edge nearer to a value.
fn nearer(value: f64, (low, high): (f64, f64)) -> f64 {
    if (value - low).abs() <= (high - value).abs() { low } else { high }
}

/// Share of the way to a target that is inside the bounds of the free numbers, and the number that ends it.
fn way(
    step: &DVector<f64>,
    target: &DVector<f64>,
    bounds: &[(f64, f64)],
    on_edge: &[bool],
) -> (f64, Option<usize>) {
    let mut first = (1.0, None);
    for k in (0..bounds.len()).filter(|&k| !on_edge[k]) {
        let inside = target[k].clamp(bounds[k].0, bounds[k].1);
        if inside == target[k] {
            continue;
        }
        let share = ((inside - step[k]) / (target[k] - step[k])).clamp(0.0, 1.0);
        if first.1.is_none() || share < first.0 {
            first = (share, Some(k));
        }
    }
    first
}

/// The least of the form with the numbers on an edge where they are.
fn least_of_free(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    step: &DVector<f64>,
    on_edge: &[bool],
) -> Option<DVector<f64>> {
    let free: Vec<usize> = (0..on_edge.len()).filter(|&k| !on_edge[k]).collect();
    let edge: Vec<usize> = (0..on_edge.len()).filter(|&k| on_edge[k]).collect();
    let part = DMatrix::from_fn(free.len(), free.len(), |r, c| matrix[(free[r], free[c])]);
    let right = DVector::from_fn(free.len(), |r, _| {
        let pushed: f64 = edge.iter().map(|&c| matrix[(free[r], c)] * step[c]).sum();
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

    /// The least over every choice of numbers that are on their lower or upper edge or free.
    fn by_enumeration(matrix: &DMatrix<f64>, gradient: &DVector<f64>, bounds: &[(f64, f64)]) -> f64 {
        let count = bounds.len() as u32;
        let mut least = f64::INFINITY;
        for choice in 0..3_usize.pow(count) {
            let place = |k: usize| choice / 3_usize.pow(k as u32) % 3;
            let on_edge: Vec<bool> = (0..bounds.len()).map(|k| place(k) < 2).collect();
            let step = DVector::from_fn(bounds.len(), |k, _| [bounds[k].0, bounds[k].1, 0.0][place(k)]);
            let Some(step) = least_of_free(matrix, gradient, &step, &on_edge) else { continue };
            let inside = step.iter().zip(bounds).all(|(s, (low, high))| *low <= *s && *s <= *high);
            if inside {
                least = least.min(value(matrix, gradient, &step));
            }
        }
        least
    }

    /// Numbers that compensate each other to 10⁻³, some on an edge, some held: the least is that of all active sets.
    #[test]
    fn exact_least_between_bounds_is_that_of_the_best_active_set() {
        let mut draw = StdRng::seed_from_u64(5);
        for _ in 0..300 {
            let columns = DMatrix::from_fn(8, 4, |_, _| draw.random_range(-1.0..1.0));
            let common = DVector::from_fn(8, |_, _| draw.random_range(-1.0..1.0));
            let alike = DMatrix::from_fn(8, 4, |r, c| common[r] + 1e-3 * columns[(r, c)]);
            let matrix = alike.tr_mul(&alike);
            let gradient = alike.tr_mul(&DVector::from_fn(8, |_, _| draw.random_range(-1.0..1.0)));
            let mut edge = || if draw.random_range(0..3) == 0 { 0.0 } else { draw.random_range(0.0..2.0) };
            let bounds: Vec<(f64, f64)> = (0..4).map(|_| (-edge(), edge())).collect();
            let step = least(&matrix, &gradient, &bounds).unwrap();
            let inside = step.iter().zip(&bounds).all(|(s, (low, high))| *low <= *s && *s <= *high);
            let (own, best) = (value(&matrix, &gradient, &step), by_enumeration(&matrix, &gradient, &bounds));
            assert!(inside && own <= best + 1e-9 * best.abs().max(1e-6), "{own} {best} {bounds:?}");
        }
    }

    #[test]
    fn exact_what_is_held_stays_and_what_is_singular_is_refused() {
        let matrix = DMatrix::from_row_slice(2, 2, &[2.0, 1.0, 1.0, 2.0]);
        let gradient = DVector::from_vec(vec![-3.0, -3.0]);
        let step = least(&matrix, &gradient, &[(0.0, 0.0), (-9.0, f64::INFINITY)]).unwrap();
        assert!(step[0] == 0.0 && (step[1] - 1.5).abs() < 1e-12, "{step}");
        let singular = DMatrix::from_element(2, 2, 1.0) * -1.0;
        assert!(least(&singular, &gradient, &[(-1.0, 1.0); 2]).is_none());
    }
}
