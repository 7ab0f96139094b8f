//! What the runs of a case tell: what calibration makes up for, and which effects nobody could tell apart.

use super::gauge::Gauge;
use super::real::{Acting, Real};
use crate::effect::{EffectId, Machinery, Prior};
use crate::singular::decomposed;
use nalgebra::{DMatrix, DVector};

/// Constants inside their tolerances, linearised at the case's machine.
///
/// # Model
/// Moving constants φ by shares of their tolerances changes the runs by C·φ, C from differences of replays. Of a change d, calibration
/// leaves d + C·φ with the φ, each from −1 to 1, at which that is least.
pub struct Calibration {
    columns: Vec<DVector<f64>>,
}

/// Share of a tolerance by which a constant is moved for its column.
const STEP: f64 = 0.02;
/// An effect that leaves less than this of another one, in standard deviations of what all samples together tell, is its equal.
const TOLD_APART: f64 = 3.0;
/// An effect that leaves less than this share of another one is tried in its place.
const NEARLY: f64 = 0.05;
/// Steps of Gauss and Newton for that, and the share that each must leave at most.
const STEPS_IN_PLACE: usize = 4;
const FAST: f64 = 0.1;
/// Changes along the size of an effect are taken at so much information: small enough to be linear, large enough to be no rounding.
const PROBE: f64 = 1.0;
/// Largest share of an effect's size for that.
const LARGEST_PROBE: f64 = 1e-2;
/// A column of which others leave less than this share is theirs.
const LEAST_OWN: f64 = 1e-9;
const SWEEPS: usize = 200;

impl Calibration {
    /// The constants of a machine that have a tolerance, and the numbers of effects that its twin states.
    pub fn new(gauge: &Gauge, real: &Real, hidden: &[Acting]) -> Self {
        let moved = real.moved(STEP).into_iter();
        let columns = moved.filter_map(|moved| Some(gauge.change(&moved.with(hidden).ok()?)? / STEP));
        Self { columns: columns.filter(|column| column.norm_squared() > 0.0).collect() }
    }

    /// What calibration leaves of a change, where effects may take any size along their columns.
    fn leaves(&self, change: &DVector<f64>, free: &[DVector<f64>]) -> DVector<f64> {
        let base = orthonormal(free);
        let beyond =
            |column: &DVector<f64>| base.iter().fold(column.clone(), |rest, b| &rest - b * b.dot(&rest));
        let rest = beyond(change);
        let columns: Vec<DVector<f64>> = self.columns.iter().map(beyond).collect();
        bounded(&rest, &columns)
    }

    /// How much of each of these columns makes up for a change, calibration of any size beside them.
    fn amounts(&self, change: &DVector<f64>, free: &[DVector<f64>]) -> Vec<f64> {
        let columns: Vec<&DVector<f64>> = free.iter().chain(&self.columns).collect();
        let gram = DMatrix::from_fn(columns.len(), columns.len(), |a, b| columns[a].dot(columns[b]));
        let right = DVector::from_fn(columns.len(), |a, _| -columns[a].dot(change));
        solved(&gram, &right, &vec![None; columns.len()]).iter().take(free.len()).copied().collect()
    }

    /// What calibration leaves of a change.
    pub fn beyond(&self, change: &DVector<f64>) -> DVector<f64> {
        self.leaves(change, &[])
    }
}

/// Orthonormal columns of the same span; what is left of a column that others span is dropped.
fn orthonormal(columns: &[DVector<f64>]) -> Vec<DVector<f64>> {
    let mut base: Vec<DVector<f64>> = Vec::new();
    for column in columns {
        let mut own = column.clone();
        // Twice is enough for rounding.
        for _ in 0..2 {
            own = base.iter().fold(own, |rest, b| &rest - b * b.dot(&rest));
        }
        let size = own.norm();
        if size > LEAST_OWN * column.norm() {
            base.push(own / size);
        }
    }
    base
}

/// target + columns·φ with the φ from −1 to 1 at which it is least: the free solution where that lies inside, else those beyond a bound
/// are put on it, the farthest first, and the rest is solved again; then coordinate by coordinate.
fn bounded(target: &DVector<f64>, columns: &[DVector<f64>]) -> DVector<f64> {
    let count = columns.len();
    let gram = DMatrix::from_fn(count, count, |a, b| columns[a].dot(&columns[b]));
    let right = DVector::from_fn(count, |a, _| -columns[a].dot(target));
    let mut fixed: Vec<Option<f64>> = vec![None; count];
    let mut solution = DVector::zeros(count);
    for _ in 0..=count {
        solution = solved(&gram, &right, &fixed);
        let farthest = (0..count).max_by(|&a, &b| solution[a].abs().total_cmp(&solution[b].abs()));
        match farthest.filter(|&k| solution[k].abs() > 1.0 && fixed[k].is_none()) {
            Some(k) => fixed[k] = Some(solution[k].signum()),
            None => break,
        }
    }
    for _ in 0..SWEEPS {
        for k in 0..count {
            if gram[(k, k)] > 0.0 {
                let slope = gram.row(k).dot(&solution.transpose()) - right[k];
                solution[k] = (solution[k] - slope / gram[(k, k)]).clamp(-1.0, 1.0);
            }
        }
    }
    columns.iter().zip(solution.iter()).fold(target.clone(), |rest, (column, phi)| rest + column * *phi)
}

/// The free unknowns of normal equations whose others are fixed.
fn solved(gram: &DMatrix<f64>, right: &DVector<f64>, fixed: &[Option<f64>]) -> DVector<f64> {
    let free: Vec<usize> = (0..fixed.len()).filter(|&k| fixed[k].is_none()).collect();
    let mut solution = DVector::from_fn(fixed.len(), |k, _| fixed[k].unwrap_or(0.0));
    if free.is_empty() {
        return solution;
    }
    // A column of nothing stays nothing.
    let scale = |k: usize| if gram[(k, k)] > 0.0 { gram[(k, k)].sqrt() } else { 1.0 };
    let own = DMatrix::from_fn(free.len(), free.len(), |a, b| {
        gram[(free[a], free[b])] / (scale(free[a]) * scale(free[b]))
    });
    let held = |k: usize| (0..fixed.len()).filter_map(|j| Some(gram[(k, j)] * fixed[j]?)).sum::<f64>();
    let wanted = DVector::from_fn(free.len(), |a, _| (right[free[a]] - held(free[a])) / scale(free[a]));
    // Columns that are one another's multiples share what they explain.
    let sound = wanted.iter().all(|x| x.is_finite());
    let parts = sound.then(|| decomposed(own)).flatten();
    if let Some(Ok(found)) = parts.map(|parts| parts.solve(&wanted, 1e-13)) {
        free.iter().zip(found.iter()).for_each(|(&k, value)| solution[k] = value / scale(k));
    }
    solution
}

/// Effects that do what a hidden one does on these runs, as far as their noise can tell.
///
/// # Model
/// Fisher information, linearised at the truth: d is the change along the size of the hidden effect, taken over its whole size; another
/// effect changes the runs along columns J, one for each number that is zero without it. It is an equal where min |d + J·θ + C·φ| over any
/// θ and calibrations φ inside their tolerances, over all samples in standard deviations of their noise, is below 3: less than a test
/// that knows both answers could tell.
///
/// What has a pitch or a frequency is tried with the hidden effect's own.
///
/// An effect that nearly does what a planned one does is tried in its place too, with the numbers that suit best (Gauss and Newton):
/// two laws may say the same and their tangents at the truth, where both act at once, differ in the second order of a large effect.
pub struct Equals<'a> {
    gauge: &'a Gauge<'a>,
    real: &'a Real<'a>,
    hidden: &'a [Acting],
    calibration: &'a Calibration,
    /// The other effects with what they do to the runs.
    others: Vec<(EffectId, Vec<f64>)>,
}

impl<'a> Equals<'a> {
    /// With the other effects of a catalogue as a machine may have them.
    pub fn new(
        gauge: &'a Gauge<'a>,
        real: &'a Real<'a>,
        hidden: &'a [Acting],
        calibration: &'a Calibration,
        machinery: &Machinery,
        prior: &mut Prior,
    ) -> Self {
        let applies = |effect: &EffectId| effect.applies(&machinery.constants);
        let others = EffectId::ALL.iter().copied().filter(applies);
        let others = others.map(|effect| (effect, effect.draw(machinery, prior))).collect();
        Self { gauge, real, hidden, calibration, others }
    }

    /// The equals of a hidden effect, itself not among them; `change` is what it makes.
    pub fn of(&self, own: &Acting, change: &DVector<f64>) -> Vec<EffectId> {
        let Some(along) = self.along(own, change.norm()) else { return Vec::new() };
        let is_hidden = |effect: EffectId| self.hidden.iter().any(|acting| acting.effect == effect);
        let others = self.others.iter().filter(|(effect, _)| !is_hidden(*effect));
        let equal = others.filter(|(other, values)| {
            let values = self.matched(*other, values, own);
            let (numbers, columns): (Vec<usize>, Vec<DVector<f64>>) =
                self.columns(*other, &values).into_iter().unzip();
            if columns.is_empty() {
                return false;
            }
            let left = self.calibration.leaves(&along, &columns).norm();
            let amounts = || self.calibration.amounts(&along, &columns);
            left < TOLD_APART
                || own.planned
                    && left < NEARLY * along.norm()
                    && self.leaves_in_place(own, *other, &values, &numbers, &amounts()) < TOLD_APART
        });
        equal.map(|(effect, _)| *effect).collect()
    }

    /// What is left of the hidden effect where another one acts in its place: of the numbers `amounts` times their `values`, and from there
    /// on what suits best.
    fn leaves_in_place(
        &self,
        own: &Acting,
        other: EffectId,
        values: &[f64],
        numbers: &[usize],
        amounts: &[f64],
    ) -> f64 {
        let absent = self.real.absent(other);
        let moved = |from: &[f64], amounts: &[f64]| {
            let mut moved = from.to_vec();
            for (&k, amount) in numbers.iter().zip(amounts) {
                moved[k] += amount * (values[k] - absent[k]);
            }
            moved
        };
        let change = |values: &[f64]| -> Option<DVector<f64>> {
            let rest = self.hidden.iter().filter(|acting| acting.effect != own.effect).cloned();
            let hidden: Vec<Acting> = rest.chain([Acting::attendant(other, values.to_vec())]).collect();
            self.gauge.change(&self.real.with(&hidden).ok()?)
        };
        // What is infinite without it has no size to go by.
        if numbers.iter().any(|&k| !absent[k].is_finite()) {
            return f64::INFINITY;
        }
        let none: Vec<f64> =
            (0..values.len()).map(|k| if numbers.contains(&k) { absent[k] } else { values[k] }).collect();
        let mut now = moved(&none, amounts);
        let mut least = f64::INFINITY;
        for _ in 0..STEPS_IN_PLACE {
            let Some(here) = change(&now) else { break };
            let left = self.calibration.beyond(&here).norm();
            // Steps of Gauss and Newton to what is exact converge fast, or go nowhere.
            let converges = left < FAST * least;
            least = least.min(left);
            if least < TOLD_APART || !converges {
                break;
            }
            let unit =
                |k: usize| (0..numbers.len()).map(|j| if j == k { LARGEST_PROBE } else { 0.0 }).collect();
            let column = |k: usize| -> Option<DVector<f64>> {
                let step: Vec<f64> = unit(k);
                Some((change(&moved(&now, &step))? - &here) / LARGEST_PROBE)
            };
            let Some(columns) = (0..numbers.len()).map(column).collect::<Option<Vec<_>>>() else { break };
            now = moved(&now, &self.calibration.amounts(&here, &columns));
        }
        least
    }

    /// The change along the size of a hidden effect, over its whole size.
    fn along(&self, own: &Acting, information: f64) -> Option<DVector<f64>> {
        let share = (PROBE / information.max(f64::MIN_POSITIVE)).min(LARGEST_PROBE);
        let absent = self.real.absent(own.effect);
        let less = Acting { values: sized(&absent, &own.values, 1.0 - share), ..own.clone() };
        let rest = self.hidden.iter().filter(|acting| acting.effect != own.effect).cloned();
        let machine = self.real.with(&rest.chain([less]).collect::<Vec<_>>()).ok()?;
        Some(self.gauge.change(&machine)? / share)
    }

    /// Values of another effect with the pitches and frequencies of a hidden one, where both have such.
    fn matched(&self, other: EffectId, values: &[f64], own: &Acting) -> Vec<f64> {
        let absent = self.real.absent(other);
        let open = |k: usize| absent[k].is_nan();
        let like = |k: usize| {
            let name = other.parameters()[k].name;
            let place = own.effect.parameters().iter().position(|p| p.name == name)?;
            own.values.get(place).copied()
        };
        (0..values.len()).map(|k| if open(k) { like(k).unwrap_or(values[k]) } else { values[k] }).collect()
    }

    /// What each number of an effect that is zero without it does to the runs, by itself, with the number's place.
    fn columns(&self, effect: EffectId, values: &[f64]) -> Vec<(usize, DVector<f64>)> {
        let absent = self.real.absent(effect);
        let numbers = (0..values.len()).filter(|&k| !absent[k].is_nan() && values[k] != absent[k]);
        let column = |k: usize| {
            let at = |share: f64| -> Option<DVector<f64>> {
                let all = sized(&absent, values, share);
                let one = |j: usize| if j == k || absent[j].is_nan() { all[j] } else { absent[j] };
                let acting = Acting::attendant(effect, (0..all.len()).map(one).collect());
                let hidden: Vec<Acting> = self.hidden.iter().cloned().chain([acting]).collect();
                Some(self.gauge.change(&self.real.with(&hidden).ok()?)? / share)
            };
            let wide = at(LARGEST_PROBE)?;
            let share = PROBE / wide.norm().max(f64::MIN_POSITIVE);
            if share < LARGEST_PROBE { at(share) } else { Some(wide) }
        };
        numbers
            .filter_map(|k| Some((k, column(k)?)))
            .filter(|(_, column)| column.norm_squared() > 0.0)
            .collect()
    }
}

/// Values on the way from those without an effect to its own. What has no value without it is open, and stays; what is infinite without it
/// is divided.
fn sized(absent: &[f64], values: &[f64], share: f64) -> Vec<f64> {
    let one = |(absent, value): (&f64, &f64)| match absent {
        absent if absent.is_nan() => *value,
        absent if absent.is_infinite() => value / share,
        absent => absent + share * (value - absent),
    };
    absent.iter().zip(values).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A change along a constant is made up for as far as its tolerance goes, and no farther.
    #[test]
    fn exact_calibration_ends_at_its_tolerance() {
        let calibration = Calibration { columns: vec![DVector::from_vec(vec![1.0, 0.0, 0.0])] };
        let left = calibration.beyond(&DVector::from_vec(vec![0.6, 2.0, 0.0]));
        assert!((left - DVector::from_vec(vec![0.0, 2.0, 0.0])).norm() < 1e-12);
        let left = calibration.beyond(&DVector::from_vec(vec![-3.5, 0.0, 1.0]));
        assert!((left - DVector::from_vec(vec![-2.5, 0.0, 1.0])).norm() < 1e-12);
    }

    /// With two columns of which the free solution leaves the box, the least is on its edge, not at the clamped free solution.
    #[test]
    fn exact_least_change_on_the_edge_of_the_box() {
        let columns = [DVector::from_vec(vec![1.0, 0.0]), DVector::from_vec(vec![1.0, 1.0])];
        // Free: φ₂ = −1.5, φ₁ = −0.5; with φ₂ at −1 the first becomes −1.
        let left = bounded(&DVector::from_vec(vec![2.0, 1.5]), &columns);
        assert!((left - DVector::from_vec(vec![0.0, 0.5])).norm() < 1e-9);
    }

    /// A column that does nothing takes no share and leaves the others theirs; one that is no number ends in none.
    #[test]
    fn exact_a_column_of_nothing_makes_up_for_nothing() {
        let calibration = Calibration { columns: vec![DVector::from_vec(vec![1.0, 1.0, 0.0])] };
        let own = DVector::from_vec(vec![0.0, 1.0, 2.0]);
        let change = &own * -2.0;
        let amounts = calibration.amounts(&change, &[DVector::zeros(3), own]);
        assert!(amounts[0] == 0.0 && (amounts[1] - 2.0).abs() < 1e-12, "{amounts:?}");
        let amounts = calibration.amounts(&change, &[DVector::from_element(3, f64::NAN)]);
        assert_eq!(amounts, [0.0]);
    }

    /// Of a change of twice a column and three times a constant, the column makes up for its own part.
    #[test]
    fn exact_amounts_are_those_beside_calibration() {
        let calibration = Calibration { columns: vec![DVector::from_vec(vec![1.0, 1.0, 0.0])] };
        let own = DVector::from_vec(vec![0.0, 1.0, 2.0]);
        let change = &own * -2.0 - &calibration.columns[0] * 3.0;
        let amounts = calibration.amounts(&change, &[own]);
        assert!(amounts.len() == 1 && (amounts[0] - 2.0).abs() < 1e-12, "{amounts:?}");
    }

    /// An effect of any size leaves nothing along its own columns.
    #[test]
    fn exact_free_columns_are_not_bounded() {
        let calibration = Calibration { columns: Vec::new() };
        let along = DVector::from_vec(vec![500.0, 500.0, 1.0]);
        let left = calibration.leaves(&along, &[DVector::from_vec(vec![1.0, 1.0, 0.0])]);
        assert!((left.norm() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn exact_sizes_between_absent_and_whole() {
        let absent = [0.0, f64::NAN, f64::INFINITY, 1.0];
        assert_eq!(sized(&absent, &[4.0, 7.0, 2.0, 3.0], 0.5), [2.0, 7.0, 4.0, 2.0]);
    }
}
