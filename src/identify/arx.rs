//! ARX: a sampled transfer function by one linear least-squares fit.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::check;
use super::excitation::{self, Outcome};
use super::least_squares::{Estimate, LeastSquares, Regression};
use super::transfer::TransferFunction;
use super::whiteness::Whiteness;
use crate::error::{Error, ErrorKind, Result};

const REMEDY: &str =
    "drive the axis with an input that keeps changing (random steps, a sweep), or ask for lower orders";

/// How many coefficients an ARX model has, and how late the input acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Orders {
    /// Number of coefficients of A(z) behind the leading 1.
    pub na: usize,
    /// Number of coefficients of B(z).
    pub nb: usize,
    /// Samples by which the input precedes its first effect; 1 for a plant whose input is held over each
    /// sample.
    pub delay: usize,
}

impl Orders {
    fn parameters(self) -> usize {
        self.na + self.nb
    }

    /// First sample whose regressor lies inside its run.
    fn start(self) -> usize {
        self.na.max(self.delay + self.nb - 1)
    }

    fn names(self) -> Vec<String> {
        let past = |signal: &str, lag: usize| {
            if lag == 0 { format!("{signal}(k)") } else { format!("{signal}(k-{lag})") }
        };
        let outputs = (1..=self.na).map(|i| past("y", i));
        outputs.chain((0..self.nb).map(|j| past("u", self.delay + j))).collect()
    }
}

/// An identified ARX model.
///
/// # Model
/// ```text
/// A(z) y(k) = B(z) u(k) + e(k)
/// y(k) = −a₁ y(k−1) − … + b₀ u(k−d) + b₁ u(k−d−1) + … + e(k)
/// ```
/// Linear least squares in a and b, by QR.
///
/// # Validity
/// The noise e must be white as it stands in this equation, that is, it passes through 1/A like a disturbance
/// at the input of the lag. White *measurement* noise on y is not of this kind and pulls poles towards zero;
/// [`whiteness`](Self::whiteness) tells. Estimates are consistent in closed loop too if d ≥ 1 and e is white.
///
/// # Source
/// Ljung, System Identification: Theory for the User, 2nd ed., sections 4.2, 7.3 and 9.
#[derive(Debug, Clone, Serialize)]
pub struct ArxModel {
    /// B(z)/A(z).
    pub transfer: TransferFunction,
    /// What was asked for.
    pub orders: Orders,
    /// a₁, a₂, …
    pub a: Vec<Estimate>,
    /// b₀, b₁, …, the coefficients of z^−d, z^−d−1, …
    pub b: Vec<Estimate>,
    /// Covariance of (a₁, …, b₀, …).
    #[serde(skip)]
    pub covariance: DMatrix<f64>,
    /// Standard deviation of e, in the output's unit.
    pub residual_sd: f64,
    /// Samples minus parameters.
    pub degrees_of_freedom: usize,
    /// Fit of the one-step prediction, % (100 = perfect, 0 = no better than the mean); none for an output
    /// that does not vary.
    pub one_step_fit_percent: Option<f64>,
    /// Fit of the free run, in which only the first outputs of each run are measured, %.
    pub free_run_fit_percent: Option<f64>,
    /// Condition number of the column-scaled regressor.
    pub condition: f64,
    /// Whether the residuals are white, as the intervals suppose.
    pub whiteness: Whiteness,
}

impl ArxModel {
    /// One-step prediction; the first samples, which lack a past, are the measured ones.
    pub fn predict(&self, input: &[f64], output: &[f64]) -> Vec<f64> {
        self.transfer.predict(input, output)
    }

    /// Free run from the given first outputs (none: from rest).
    pub fn simulate(&self, input: &[f64], first_outputs: &[f64]) -> Vec<f64> {
        self.transfer.simulate_from(input, first_outputs)
    }
}

/// Identifies an ARX model from one run.
///
/// ```
/// use slideway::identify::{arx::{Orders, arx}, excitation::Outcome, transfer::TransferFunction};
/// let table = TransferFunction::new(vec![0.0, 0.45], vec![1.0, -0.85], 0.025)?;
/// let orders = Orders { na: 1, nb: 1, delay: 1 };
/// let force: Vec<f64> = (0..100).map(|k| f64::from(k * k % 17)).collect();
/// let Outcome::Identified(model) = arx(&force, &table.simulate(&force), 0.025, orders)? else { unreachable!() };
/// assert_eq!(model.transfer.to_string(), "0.45 z^-1 / (1 - 0.85 z^-1)");
/// // a constant force tells nothing of how the table gets to speed, however long it lasts
/// let constant = [100.0; 1000];
/// assert!(matches!(arx(&constant, &table.simulate(&constant), 0.025, orders)?, Outcome::NotExcited(_)));
/// # Ok::<(), slideway::error::Error>(())
/// ```
///
/// # Errors
/// As [`arx_runs`].
pub fn arx(input: &[f64], output: &[f64], sample_period_s: f64, orders: Orders) -> Result<Outcome<ArxModel>> {
    arx_runs(&[(input, output)], sample_period_s, orders)
}

/// Identifies one ARX model from several runs of (input, output); no regressor reaches from one run into
/// another.
///
/// Answers [`Outcome::NotExcited`] when the input is not persistently exciting of order na + nb (a constant
/// never is), even where a transient of the output would make the equations solvable: a fit that leans on one
/// transient predicts that transient.
///
/// # Errors
/// No coefficient asked for in B(z); signals of unequal length; numbers that are not finite; fewer than five
/// usable samples a parameter.
pub fn arx_runs(
    runs: &[(&[f64], &[f64])],
    sample_period_s: f64,
    orders: Orders,
) -> Result<Outcome<ArxModel>> {
    check::sample_period(sample_period_s)?;
    if orders.nb == 0 {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key("nb")
            .found("0")
            .expected("at least one coefficient of the input")
            .remedy("a model without input cannot be driven; ask for nb = 1"));
    }
    for (input, output) in runs {
        check::same_length("input", input, "output", output)?;
        check::finite("input", input)?;
        check::finite("output", output)?;
    }
    let regression = regression(runs, orders);
    let solved = regression.solve(REMEDY)?;
    let inputs: Vec<&[f64]> = runs.iter().map(|(input, _)| *input).collect();
    let persistence = excitation::persistence(&inputs, orders.parameters())?;
    if !persistence.is_full_rank() {
        let names: Vec<_> = (0..orders.parameters()).map(|lag| format!("u(k-{lag})")).collect();
        return Ok(Outcome::NotExcited(persistence.refusal(&names, REMEDY)));
    }
    match solved {
        Outcome::NotExcited(why) => Ok(Outcome::NotExcited(why)),
        Outcome::Identified(solution) => {
            model(runs, sample_period_s, orders, solution).map(Outcome::Identified)
        }
    }
}

fn regression(runs: &[(&[f64], &[f64])], orders: Orders) -> Regression {
    let start = orders.start();
    let rows = runs.iter().map(|(_, output)| output.len().saturating_sub(start)).sum();
    let mut regressor = DMatrix::zeros(rows, orders.parameters());
    let mut target = DVector::zeros(rows);
    let mut row = 0;
    for (input, output) in runs {
        for k in start..output.len() {
            for i in 0..orders.na {
                regressor[(row, i)] = -output[k - 1 - i];
            }
            for j in 0..orders.nb {
                regressor[(row, orders.na + j)] = input[k - orders.delay - j];
            }
            target[row] = output[k];
            row += 1;
        }
    }
    Regression { names: orders.names(), regressor, target }
}

fn model(
    runs: &[(&[f64], &[f64])],
    sample_period_s: f64,
    orders: Orders,
    solution: LeastSquares,
) -> Result<ArxModel> {
    let (a, b) = solution.estimates.split_at(orders.na);
    let values = |estimates: &[Estimate]| estimates.iter().map(|e| e.value).collect::<Vec<_>>();
    let numerator = [vec![0.0; orders.delay], values(b)].concat();
    let transfer = TransferFunction::new(numerator, [vec![1.0], values(a)].concat(), sample_period_s)?;
    let start = orders.start();
    let by_run =
        runs_of(&solution.residuals, runs.iter().map(|(_, output)| output.len().saturating_sub(start)));
    let whiteness = Whiteness::of(&by_run);
    let predicted = runs.iter().flat_map(|(u, y)| transfer.predict(u, y).split_off(start.min(y.len())));
    let free = runs.iter().flat_map(|(u, y)| {
        let start = start.min(y.len());
        transfer.simulate_from(u, &y[..start]).split_off(start)
    });
    let measured: Vec<f64> = runs.iter().flat_map(|(_, y)| y[start.min(y.len())..].iter().copied()).collect();
    let one_step_fit_percent = fit_percent(&measured, predicted);
    let free_run_fit_percent = fit_percent(&measured, free);
    Ok(ArxModel {
        orders,
        a: a.to_vec(),
        b: b.to_vec(),
        covariance: solution.covariance,
        residual_sd: solution.residual_sd,
        degrees_of_freedom: solution.degrees_of_freedom,
        one_step_fit_percent,
        free_run_fit_percent,
        condition: solution.condition,
        whiteness,
        transfer,
    })
}

/// The rows of all runs cut back into runs.
fn runs_of(rows: &[f64], lengths: impl Iterator<Item = usize>) -> Vec<&[f64]> {
    let mut rest = rows;
    lengths
        .map(|length| {
            let (run, behind) = rest.split_at(length);
            rest = behind;
            run
        })
        .collect()
}

/// Normalised fit in %: 100·(1 − ‖y − ŷ‖/‖y − mean y‖); none where y does not vary or ŷ runs away beyond all
/// numbers.
pub fn fit_percent(measured: &[f64], modelled: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let spread: f64 = measured.iter().map(|y| (y - mean).powi(2)).sum();
    let error: f64 = measured.iter().zip(modelled).map(|(y, model)| (y - model).powi(2)).sum();
    let fit = 100.0 * (1.0 - (error / spread).sqrt());
    fit.is_finite().then_some(fit)
}
