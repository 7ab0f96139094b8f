//! What depends on place, whatever its course: estimated beside a fit without a law for it.

use super::fit::Fit;
use super::free::Free;
use super::objective::Objective;
use super::sandwich::inverted;
use super::score_test::ScoreTest;
use super::wave_basis::{WAVES, WaveBasis, solvable};
use super::waves::{self, PROBE, Wave, WaveLaw};
use crate::error::Result;
use crate::machine::Machine;
use nalgebra::{DMatrix, DVector};

/// Steps at most: a loop answers a force nearly linearly, and each step leaves the square of what the one before left.
const STEPS: usize = 6;
/// A step that lowers the sum of squares by less than this share is the last one: the next one would lower it by about the square of that.
const ARRIVED: f64 = 0.01;
/// A step that does not fall is halved so many times at most: a choice of cost.
const HALVINGS: i32 = 4;

/// A function of place that acts beside a fit, with what the data tell of it.
pub struct Nonparametric {
    /// Its coefficients, in the order of the [basis](WaveBasis): in N or N·m where the law is a force, without unit where it is a share of one.
    pub coefficients: DVector<f64>,
    /// Values of the fit's numbers beside it.
    pub values: Vec<f64>,
    /// Normal equations of changes of the coefficients.
    pub test: ScoreTest,
}

/// A fit, and the functions of place that may act beside it.
pub struct Beside<'a> {
    /// The objective of the fit.
    pub objective: &'a Objective<'a>,
    /// The fit.
    pub fit: &'a Fit,
    /// Derivatives of its residuals by its numbers.
    pub jacobian: &'a DMatrix<f64>,
    /// Whether a number stays as it is.
    pub held: &'a dyn Fn(&Free) -> bool,
    /// The law by which a wave of the function acts.
    pub wave: WaveLaw,
    /// The largest amplitude of a wave.
    pub largest: f64,
    /// The basis of the functions.
    pub basis: &'a WaveBasis,
}

/// Where a fit and the function beside it have gone.
struct Place {
    values: Vec<f64>,
    coefficients: DVector<f64>,
    residuals: DVector<f64>,
}

/// Derivatives of the residuals.
struct Derivatives {
    /// By the numbers of the fit, zero for those that are held.
    jacobian: DMatrix<f64>,
    /// By the coefficients.
    responses: DMatrix<f64>,
}

impl Beside<'_> {
    /// The function that is zero.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn zero(&self) -> Result<Nonparametric> {
        let (place, derivatives) = self.begun()?;
        Ok(self.told(&place, &derivatives))
    }

    /// The function that leaves least.
    ///
    /// # Model
    /// Gauss and Newton's method over the coefficients k of the basis and the numbers of the fit together. Near the function found, k̂, the residuals are linear
    /// in what a law would have else, `r = r̂ + R·(k − k̂)`: where no other cause is missing, laws are compared by one quadratic form, however large the
    /// force is. About the fit itself that form is right to first order in the whole force only.
    ///
    /// # Validity
    /// What of a hypothesis' other faults follows place, as bristles at reversals do, is taken up too, and the form is too sharp by that.
    ///
    /// # Source
    /// Nocedal, Wright (2006), *Numerical Optimization*, section 10.3.
    ///
    /// # Errors
    /// Whatever a replay refuses.
    pub fn best(&self) -> Result<Nonparametric> {
        let (mut place, mut derivatives) = self.begun()?;
        for _ in 0..STEPS {
            let Some((next, share)) = self.step(&place, &derivatives)? else { break };
            place = next;
            if share < ARRIVED {
                break;
            }
            derivatives = self.derivatives(&place)?;
        }
        Ok(self.told(&place, &derivatives))
    }

    fn begun(&self) -> Result<(Place, Derivatives)> {
        let values = self.fit.values.clone();
        let residuals = self.objective.residuals(&values)?;
        let place = Place { values, coefficients: DVector::zeros(WAVES), residuals };
        let responses = self.responses(&place)?;
        Ok((place, Derivatives { jacobian: self.free(self.jacobian.clone()), responses }))
    }

    fn derivatives(&self, place: &Place) -> Result<Derivatives> {
        let machine = self.acting(self.objective.machine.clone(), &place.coefficients);
        let objective = Objective { machine: &machine, ..*self.objective };
        let jacobian = self.free(objective.jacobian(&place.values, &place.residuals, None)?);
        Ok(Derivatives { jacobian, responses: self.responses(place)? })
    }

    /// Derivatives without those by the numbers that are held.
    fn free(&self, mut jacobian: DMatrix<f64>) -> DMatrix<f64> {
        let numbers = self.fit.hypothesis.free.iter().enumerate();
        numbers.filter(|(_, free)| (self.held)(free)).for_each(|(k, _)| jacobian.column_mut(k).fill(0.0));
        jacobian
    }

    fn told(&self, place: &Place, derivatives: &Derivatives) -> Nonparametric {
        let Place { values, coefficients, residuals } = place;
        let Derivatives { jacobian, responses } = derivatives;
        let test = ScoreTest::of(self.objective, values, residuals, jacobian, responses);
        Nonparametric { coefficients: coefficients.clone(), values: values.clone(), test }
    }

    /// The machine of the fit with these values and the function beside them.
    fn machine(&self, values: &[f64], coefficients: &DVector<f64>) -> Result<Machine> {
        Ok(self.acting(self.fit.hypothesis.machine(self.objective.machine, values)?, coefficients))
    }

    /// A machine with the function beside what it has.
    fn acting(&self, machine: Machine, coefficients: &DVector<f64>) -> Machine {
        let acts = |wave: &Wave| wave.sine != 0.0 || wave.cosine != 0.0;
        let all = self.basis.combination(coefficients.as_slice()).into_iter().filter(acts);
        all.fold(machine, |machine, wave| machine.with_probe((self.wave)(wave)))
    }

    /// Derivatives of the residuals by the coefficients.
    fn responses(&self, place: &Place) -> Result<DMatrix<f64>> {
        let amplitude = PROBE * self.largest;
        let machine = self.machine(&place.values, &place.coefficients)?;
        let machines = waves::machines(&machine, self.wave, self.basis.waves(amplitude));
        let changed = self.objective.residuals_at(&machines)?;
        let all = changed.into_iter().map(|changed| (changed - &place.residuals) / amplitude);
        Ok(DMatrix::from_columns(&all.collect::<Vec<DVector<f64>>>()))
    }

    /// One step, with the share of the sum of squares that it takes off; none where not even a short one falls.
    fn step(&self, place: &Place, derivatives: &Derivatives) -> Result<Option<(Place, f64)>> {
        let Place { values, coefficients, residuals } = place;
        let Derivatives { jacobian, responses } = derivatives;
        let ScoreTest { normal, right } = self.told(place, derivatives).test;
        let Some(step) = solvable(normal).map(|factor| factor.solve(&right)) else { return Ok(None) };
        let weights = self.objective.weights(residuals);
        let (own, gradient) = self.objective.normal(jacobian, residuals, &weights, values);
        let change = (responses * &step).component_mul(&weights);
        let way = -inverted(&own) * (gradient + jacobian.tr_mul(&change));
        let cost = self.objective.cost(residuals, &weights, values);
        for halvings in 0..=HALVINGS {
            let share = 0.5f64.powi(halvings);
            let moved = |(k, free): (usize, &Free)| {
                (values[k] + share * way[k] * free.scale).clamp(free.range.0, free.range.1)
            };
            let values: Vec<f64> = self.fit.hypothesis.free.iter().enumerate().map(moved).collect();
            let coefficients = coefficients + &step * share;
            // Values that the machine's description refuses fall nowhere.
            let Ok(machine) = self.machine(&values, &coefficients) else { continue };
            let residuals = self.objective.residuals_at(&[machine])?.remove(0);
            let fall = cost - self.objective.cost(&residuals, &weights, &values);
            if fall > 0.0 {
                return Ok(Some((Place { values, coefficients, residuals }, fall / cost)));
            }
        }
        Ok(None)
    }
}
