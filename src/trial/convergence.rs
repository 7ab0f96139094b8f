//! Whether a forged run is that of the machine and not of the integrator.

use super::engine::{Engine, STEP_S};
use super::gauge::{Gauge, as_logged};
use super::laws::Otherwise;
use super::runs::TrialRun;
use crate::diagnose::evidence::residuals;
use crate::diagnose::experiment::Experiment;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;

/// Halvings of the step before a case is left as it is.
const MOST_HALVINGS: usize = 2;

/// A step, and how far the run is from that of an infinitely fine one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Converged {
    /// Longest step of the plant in s.
    pub step_s: f64,
    /// Error of the run; see [`converged`].
    pub error: f64,
}

/// The longest step, from [`STEP_S`] down, at which the longest run of a case has converged.
///
/// # Model
/// The run is simulated with perfect sensors at the step h and at h/2. Of a method of first order at least, the error at h is at most
/// twice their difference. It is taken RMS over samples, of the signal where it is largest, in standard deviations of the noise over √N with
/// N samples: an error of one is what all samples together could just tell. It has converged where that is at most one. After two halvings
/// the case stays as it is, with its error in the truth.
///
/// # Errors
/// What the plant refuses.
pub fn converged(
    engine: Engine,
    real: &Machine,
    otherwise: &Otherwise,
    run: &TrialRun,
    logged: &[Signal],
    gauge: &Gauge,
) -> Result<Converged> {
    let reference = run.reference(real);
    let at =
        |step_s: f64| engine.simulate(real, otherwise, Sensing::Perfect, &reference, run.begins_s, step_s);
    let mut step_s = STEP_S;
    let mut coarse = at(step_s)?;
    let mut halvings = 0;
    loop {
        let fine = at(0.5 * step_s)?;
        let experiment = Experiment::new(&as_logged(run, real, &reference, fine.clone(), logged)?, real)?;
        let of = residuals(&experiment, &coarse, gauge.floor());
        // √N·RMS is the root of the sum of squares.
        let error = of.iter().map(|r| 2.0 * r.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max);
        if error <= 1.0 || halvings == MOST_HALVINGS {
            return Ok(Converged { step_s, error });
        }
        (step_s, coarse) = (0.5 * step_s, fine);
        halvings += 1;
    }
}
