//! What the drive's signals tell of the motor's effort, and of the voltage that it lacks.

use super::experiment::Experiment;
use crate::drive::motor::{Circuit, CircuitStep};
use crate::effect::Constants;
use crate::recording::Signal;
use statrs::statistics::Statistics;

/// The motor's effort in N or N·m, positive along the axis' positive direction, from its current or from the control effort through the drive's
/// model, whichever tells it with less noise; none where neither was logged. `smoothed` is the smoothing that the motion is read with.
///
/// # Model
/// Of two readings of one force, a and b, with noise of variances α and β (what smoothing takes from each), the smoothed difference of samples
/// at which nothing but noise parts them has the variance s·(α + β), with s what smoothing leaves of white noise: a third through the least window
/// of seven samples, so at most half of what it takes. Where it has more than all of that, beside its mean, the drive's model is not right,
/// and the current counts. Else the quieter one does, with the mean of the current.
///
/// # Validity
/// Noise that is white over the window. An error of the drive's model that is smaller than the noise which smoothing takes goes into the force: it is
/// where fits start, not what they are judged by.
///
/// # Source
/// Savitzky, Golay (1964), Anal. Chem. 36:1627, for what the smoothing leaves of white noise.
pub fn drive_force(
    experiment: &Experiment,
    constants: &Constants,
    velocity: &[f64],
    smoothed: &dyn Fn(&[f64]) -> Vec<f64>,
) -> Option<Vec<f64>> {
    let by_effort = effort_force(experiment, constants, velocity);
    let Some(by_current) = current_force(experiment, constants) else { return by_effort };
    let Some(by_effort) = by_effort else { return Some(by_current) };
    let difference: Vec<f64> = by_current.iter().zip(&by_effort).map(|(a, b)| a - b).collect();
    // What smoothing takes of a signal, and what it leaves.
    let split = |signal: &[f64]| {
        let smooth = smoothed(signal);
        let taken = signal.iter().zip(&smooth).map(|(raw, smooth)| raw - smooth).population_variance();
        (taken, smooth.population_variance())
    };
    let [(own, _), (other, _), (taken, left)] =
        [&by_current, &by_effort, &difference].map(|signal| split(signal));
    let mean = difference.mean();
    Some(if other < own && left <= taken {
        by_effort.into_iter().map(|force| force + mean).collect()
    } else {
        by_current
    })
}

/// By the current and the force constant; none where no current was logged.
fn current_force(experiment: &Experiment, constants: &Constants) -> Option<Vec<f64>> {
    let Circuit::Winding { force_constant, .. } = constants.circuit else { return None };
    let current = experiment.run().signal(Signal::Current)?;
    Some(current.iter().map(|i| i / constants.log_scale.current * force_constant).collect())
}

/// By the control effort through the drive's model; none where no effort was logged.
fn effort_force(experiment: &Experiment, constants: &Constants, velocity: &[f64]) -> Option<Vec<f64>> {
    let applied = applied_v(experiment, constants)?;
    if let Circuit::Direct { force_per_volt } = constants.circuit {
        return Some(applied.iter().map(|u| u * force_per_volt).collect());
    }
    let step = CircuitStep::new(&constants.circuit, experiment.run().sample_period_s());
    let mut current = experiment.recorded().start().unscaled(constants.log_scale).current_a(constants);
    let force = |(u, velocity): (&f64, &f64)| {
        let now = current;
        step.advance(&mut current, *u, *velocity);
        now * step.effort_constant()
    };
    Some(applied.iter().zip(velocity).map(force).collect())
}

/// Control effort with what was fed forward, in V as the controller has it; none where none was logged.
pub fn commanded_v(experiment: &Experiment, constants: &Constants) -> Option<Vec<f64>> {
    let effort = experiment.run().signal(Signal::ControlEffort)?;
    let effort: Vec<f64> = effort.iter().map(|u| u / constants.log_scale.effort).collect();
    Some(experiment.recorded().commanded_v(&effort))
}

/// The voltage in V that the current takes more than was commanded, `(R·i + Ke·v)/gain − u`, sample by sample: what an offset of the amplifier adds is
/// positive. The inductance is left out, its voltage is zero on average between standstills; none where not both signals were logged.
pub fn missing_voltage(
    experiment: &Experiment,
    constants: &Constants,
    velocity: &[f64],
    commanded_v: &[f64],
) -> Option<Vec<f64>> {
    let Circuit::Winding { resistance_ohm, back_emf, .. } = constants.circuit else { return None };
    let run = experiment.run();
    let (current, supply) = (run.signal(Signal::Current)?, run.signal(Signal::SupplyVoltage));
    let taken = current.iter().zip(velocity).enumerate().map(|(k, (current, velocity))| {
        let gain = constants.amplifier.gain_under(supply.map(|supply| supply[k]));
        (resistance_ohm * current / constants.log_scale.current + back_emf * velocity) / gain
    });
    Some(taken.zip(commanded_v).map(|(taken, commanded)| taken - commanded).collect())
}

/// Voltage at the motor, limit and dead zone aside: effort with what was fed forward, times the supply of a duty cycle; none where no effort was
/// logged.
fn applied_v(experiment: &Experiment, constants: &Constants) -> Option<Vec<f64>> {
    let supply = experiment.run().signal(Signal::SupplyVoltage);
    let gain = |k: usize| constants.amplifier.gain_under(supply.map(|supply| supply[k]));
    let commanded = commanded_v(experiment, constants)?;
    Some(commanded.iter().enumerate().map(|(k, u)| gain(k) * u).collect())
}
