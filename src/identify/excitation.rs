//! Does the signal move enough to determine what is asked?

use crate::singular::decomposed;
use nalgebra::DMatrix;
use serde::Serialize;

use super::check;
use crate::error::{Error, ErrorKind, Result};

/// Condition number of a column-scaled regressor above which its parameters count as not determined.
///
/// Rounding reaches the parameters multiplied by this number: beyond 1e8 half of the digits of an `f64` are
/// gone, and so is every digit of a measurement.
pub const CONDITION_LIMIT: f64 = 1e8;
/// Components of the weak direction below this share are left out of the sentence.
const NEGLIGIBLE_COMPONENT: f64 = 0.05;

/// What an identifier answers: the model, or that these data cannot tell.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome<Model> {
    /// The data determine the model.
    Identified(Model),
    /// The data leave a direction of the parameters open.
    NotExcited(NotExcited),
}

impl<Model> Outcome<Model> {
    /// The model, if there is one.
    pub fn identified(self) -> Option<Model> {
        match self {
            Self::Identified(model) => Some(model),
            Self::NotExcited(_) => None,
        }
    }
}

/// Why data do not determine a model, and what would.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NotExcited {
    /// Condition number of the column-scaled regressor; infinite where a column vanishes.
    pub condition: f64,
    /// The combination of regressors that hardly moves: name and component of the unit vector (columns scaled
    /// to length 1).
    pub weak_direction: Vec<(String, f64)>,
    /// What to do about it.
    pub remedy: String,
}

impl std::fmt::Display for NotExcited {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let named = self.weak_direction.iter().filter(|(_, share)| share.abs() > NEGLIGIBLE_COMPONENT);
        let direction: Vec<_> = named.map(|(name, share)| format!("{share:+.2} {name}")).collect();
        write!(
            f,
            "not excited: condition {:.1e}, limit {CONDITION_LIMIT:.0e}; {} does not move; {}",
            self.condition,
            direction.join(" "),
            self.remedy
        )
    }
}

/// How well the columns of a regressor can be told apart.
///
/// # Model
/// Each column is divided by its length; σ₁ ≥ … ≥ σₙ are the singular values of what results.
/// Condition number σ₁/σₙ; rank = number of σ above σ₁ / [`CONDITION_LIMIT`]; weak direction = right singular
/// vector of σₙ.
#[derive(Debug, Clone, PartialEq)]
pub struct Excitation {
    singular_values: Vec<f64>,
    weak_direction: Vec<f64>,
}

impl Excitation {
    /// Of a regressor with one row a sample and one column a parameter.
    ///
    /// # Errors
    /// Fewer rows than columns; entries that are not finite.
    pub fn of(regressor: &DMatrix<f64>) -> Result<Self> {
        check::finite("regressor", regressor.as_slice())?;
        check::enough_rows(regressor.nrows(), regressor.ncols().max(1), regressor.ncols())?;
        let (scaled, _) = scale_columns(regressor);
        Self::of_triangle(scaled.qr().r())
    }

    /// Of the triangle R of a QR decomposition of an already scaled regressor, which has its singular values.
    pub(super) fn of_triangle(triangle: DMatrix<f64>) -> Result<Self> {
        let failed =
            || Error::new(ErrorKind::Undetermined).found("a regressor whose singular values do not converge");
        let svd = decomposed(triangle).ok_or_else(failed)?;
        let directions = svd.v_t.ok_or_else(failed)?;
        let weak_direction = directions.row(directions.nrows() - 1).iter().copied().collect();
        Ok(Self { singular_values: svd.singular_values.iter().copied().collect(), weak_direction })
    }

    /// Ratio of largest to smallest singular value; infinite where a column vanishes or repeats exactly.
    pub fn condition(&self) -> f64 {
        match (self.singular_values.first(), self.singular_values.last()) {
            (Some(&largest), Some(&smallest)) if smallest > 0.0 => largest / smallest,
            _ => f64::INFINITY,
        }
    }

    /// Number of directions that the data determine.
    pub fn rank(&self) -> usize {
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        self.singular_values.iter().filter(|s| **s > 0.0 && **s * CONDITION_LIMIT >= largest).count()
    }

    /// Whether the data determine every direction.
    pub fn is_full_rank(&self) -> bool {
        self.rank() == self.singular_values.len()
    }

    /// Singular values of the column-scaled regressor, largest first.
    pub fn singular_values(&self) -> &[f64] {
        &self.singular_values
    }

    /// Unit vector, in scaled columns, along which the regressor moves least.
    pub fn weak_direction(&self) -> &[f64] {
        &self.weak_direction
    }

    /// The outcome for data that are not exciting.
    pub(super) fn refusal(&self, names: &[String], remedy: impl Into<String>) -> NotExcited {
        let weak_direction = names.iter().cloned().zip(self.weak_direction.iter().copied()).collect();
        NotExcited { condition: self.condition(), weak_direction, remedy: remedy.into() }
    }
}

/// Columns divided by their lengths, and the lengths (1 for a column of zeros, which stays one).
pub(super) fn scale_columns(regressor: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
    let mut scaled = regressor.clone();
    let lengths = scaled
        .column_iter_mut()
        .map(|mut column| {
            let length = column.norm();
            let length = if length > 0.0 { length } else { 1.0 };
            column /= length;
            length
        })
        .collect();
    (scaled, lengths)
}

/// Excitation of order n by a signal: of the regressor [u(k), u(k−1), …, u(k−n+1)].
///
/// # Model
/// The signal is persistently exciting of order n when this regressor has full rank: a constant has order 1,
/// a sine 2, m sines 2m, white noise any.
///
/// # Source
/// Ljung, System Identification: Theory for the User, 2nd ed., section 13.2.
///
/// # Errors
/// Order 0, fewer samples than the order needs, samples that are not finite.
pub fn persistence(runs: &[&[f64]], order: usize) -> Result<Excitation> {
    if order == 0 {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key("order")
            .found("0")
            .expected("an order of at least 1")
            .remedy("ask for the number of parameters that the input must determine"));
    }
    let rows: usize = runs.iter().map(|run| run.len().saturating_sub(order - 1)).sum();
    check::enough_rows(rows, order, order)?;
    let mut regressor = DMatrix::zeros(rows, order);
    let mut row = 0;
    for run in runs {
        for window in run.windows(order) {
            for (column, sample) in window.iter().rev().enumerate() {
                regressor[(row, column)] = *sample;
            }
            row += 1;
        }
    }
    Excitation::of(&regressor)
}

/// The highest order, up to `largest`, of which the signal is persistently exciting.
///
/// # Errors
/// As [`persistence`].
pub fn persistence_order(signal: &[f64], largest: usize) -> Result<usize> {
    for order in 1..=largest {
        if !persistence(&[signal], order)?.is_full_rank() {
            return Ok(order - 1);
        }
    }
    Ok(largest)
}
