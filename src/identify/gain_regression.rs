//! The gains behind a controller's integers, from its recorded signals.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::check;
use super::excitation::Outcome;
use super::least_squares::{Estimate, Regression};
use super::transfer::TransferFunction;
use crate::error::{Error, ErrorKind, Result};

const REMEDY: &str = "use strokes that accelerate, cruise and reverse, at several feeds; at rest or at constant speed the gains are not visible";
/// Deviation of the coefficient of u(k−1) from 1 that rounding alone explains.
const ROUNDING: f64 = 1e-9;

/// The integers set in the controller while the runs were recorded, and its period.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct IntegerSettings {
    /// Integer of the integral path.
    pub integral: i64,
    /// Integer of the proportional path.
    pub proportional: i64,
    /// Sample period of the controller, s.
    pub sample_period_s: f64,
}

/// The controller's signals in one run, of equal length.
#[derive(Debug, Clone, Copy)]
pub struct ControllerRun<'a> {
    /// e = r − y, in the controller's unit of velocity.
    pub error: &'a [f64],
    /// u, V.
    pub effort_v: &'a [f64],
    /// y, in the controller's unit of velocity.
    pub velocity: &'a [f64],
}

/// Where the third regressor y(k) − y(k−1) is taken from.
#[derive(Debug, Clone, Copy)]
pub enum VelocityChange<'a> {
    /// From the measured velocity, eq. (10).
    Measured,
    /// y(k) predicted by the plant from measured u and y before it, eq. (12).
    Predicted(&'a TransferFunction),
}

/// Gains of a pseudo-derivative-feedback controller.
///
/// # Model
/// With integers Iᵢ, Iₚ and period T:
/// ```text
/// u = u1 − Iₚ·k2·y,  u1(k) = u1(k−1) + Iᵢ·T·k1·e(k)
/// u(k) = [ Iᵢ·T·e(k)   u(k−1)   −Iₚ·(y(k) − y(k−1)) ] · [ k1  1  k2 ]ᵀ
/// ```
/// Sign: velocity is fed back negatively and k2 > 0. The paper prints u = u1 + Iₚ·k2·y, its third regressor
/// therefore without the minus; its printed equation fits the same data with −k2.
///
/// # Validity
/// Linear range: no saturated effort, no clamped integral. Noise that enters y between controller and
/// recorder biases k2. k1 and k2 carry the unit V per unit of y per integer.
///
/// # Source
/// Liu, Lai, Yen, grinding-machine controller identification, eqs. (9), (10), (12).
#[derive(Debug, Clone, Serialize)]
pub struct ControllerGains {
    /// k1, of the integral path.
    pub k1: Estimate,
    /// Coefficient of u(k−1); 1 if the controller integrates as supposed.
    pub previous_effort: Estimate,
    /// k2, of the proportional path.
    pub k2: Estimate,
    /// Condition number of the column-scaled regressor.
    pub condition: f64,
    /// Standard deviation of what remains, V.
    pub residual_sd_v: f64,
    /// Samples minus 3.
    pub degrees_of_freedom: usize,
}

impl ControllerGains {
    /// Whether 1 lies in the interval of the coefficient of u(k−1), up to rounding.
    ///
    /// If not, the controller is not of this form, was saturated, or was recorded late or at another period.
    pub fn integrates(&self) -> bool {
        self.previous_effort.covers(1.0) || (self.previous_effort.value - 1.0).abs() <= ROUNDING
    }

    /// k2 in the sign of the printed equation (8).
    pub fn k2_as_printed(&self) -> f64 {
        -self.k2.value
    }
}

/// Identifies k1 and k2 from runs recorded under one setting of the integers.
///
/// # Errors
/// An integer of 0 (its gain does not act); signals of unequal length; numbers that are not finite; fewer
/// than five usable samples a parameter.
pub fn gain_regression(
    runs: &[ControllerRun<'_>],
    settings: IntegerSettings,
    change: VelocityChange<'_>,
) -> Result<Outcome<ControllerGains>> {
    check::sample_period(settings.sample_period_s)?;
    acts("integral", settings.integral)?;
    acts("proportional", settings.proportional)?;
    for run in runs {
        check::same_length("error", run.error, "effort_v", run.effort_v)?;
        check::same_length("velocity", run.velocity, "effort_v", run.effort_v)?;
        check::finite("error", run.error)?;
        check::finite("effort_v", run.effort_v)?;
        check::finite("velocity", run.velocity)?;
    }
    let solution = match regression(runs, settings, change).solve(REMEDY)? {
        Outcome::Identified(solution) => solution,
        Outcome::NotExcited(why) => return Ok(Outcome::NotExcited(why)),
    };
    Ok(Outcome::Identified(ControllerGains {
        k1: solution.estimates[0],
        previous_effort: solution.estimates[1],
        k2: solution.estimates[2],
        condition: solution.condition,
        residual_sd_v: solution.residual_sd,
        degrees_of_freedom: solution.degrees_of_freedom,
    }))
}

fn acts(key: &str, integer: i64) -> Result<()> {
    if integer != 0 {
        return Ok(());
    }
    Err(Error::new(ErrorKind::OutOfRange)
        .key(key)
        .found("0")
        .expected("an integer other than 0")
        .remedy("identify on runs in which this path of the controller was switched on"))
}

fn regression(
    runs: &[ControllerRun<'_>],
    settings: IntegerSettings,
    change: VelocityChange<'_>,
) -> Regression {
    let start = match change {
        VelocityChange::Measured => 1,
        VelocityChange::Predicted(plant) => plant.memory().max(1),
    };
    let integral = settings.integral as f64 * settings.sample_period_s;
    let proportional = settings.proportional as f64;
    let rows = runs.iter().map(|run| run.effort_v.len().saturating_sub(start)).sum();
    let mut regressor = DMatrix::zeros(rows, 3);
    let mut target = DVector::zeros(rows);
    let mut row = 0;
    for run in runs {
        let ControllerRun { error: e, effort_v: u, velocity: y } = *run;
        let predicted = match change {
            VelocityChange::Measured => None,
            VelocityChange::Predicted(plant) => Some(plant.predict(u, y)),
        };
        let present = predicted.as_deref().unwrap_or(y);
        for k in start..u.len() {
            regressor[(row, 0)] = integral * e[k];
            regressor[(row, 1)] = u[k - 1];
            regressor[(row, 2)] = -proportional * (present[k] - y[k - 1]);
            target[row] = u[k];
            row += 1;
        }
    }
    let names = ["e(k)", "u(k-1)", "y(k)-y(k-1)"].map(String::from).to_vec();
    Regression { names, regressor, target }
}
