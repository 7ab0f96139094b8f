//! Does the motion of the training runs determine mass, friction and weight?

use super::super::experiment::Experiment;
use super::inertia::{FORCE, Inertia};
use super::smoothed::Smoothed;
use super::{Check, Finding};
use crate::identify::excitation::Excitation;
use crate::machine::Machine;
use nalgebra::DMatrix;

/// Condition number of the column-scaled regressor beyond which parameters count as inseparable: an error of
/// 1 % in what explains the force becomes one of 40 % in them.
const LARGEST_CONDITION: f64 = 40.0;
/// Components of the weak direction (columns scaled to length 1) above this belong to the inseparable parameters.
const TAKES_PART: f64 = 0.3;
/// Spread of the speed, in shares of its mean, below which steady motion knows one speed only: viscous friction
/// then differs by less over the run than Coulomb friction does from day to day.
const ONE_SPEED: f64 = 0.1;
/// Change from sample to sample, in shares of the top speed, up to which a reference is steady: rounding.
const STEADY: f64 = 1e-6;
/// Share of the motion that must be steady: a swing is so only where it turns.
const MOSTLY: f64 = 0.5;
/// Standard errors that a mass must be from zero: below, its 95 % interval is wider than ±20 %, and any payload
/// hides in it.
const LEAST_SIGNIFICANCE: f64 = 10.0;
/// Samples used at most.
const SAMPLES: usize = 20_000;

/// What the training runs together leave open.
pub fn excitation(machine: &Machine, training: &[Experiment], runs: &[&Smoothed]) -> Vec<Finding> {
    let total: usize = runs.iter().map(|run| run.moving.len()).sum();
    let every = total.div_ceil(SAMPLES).max(1);
    let motion: Vec<[f64; 2]> = runs
        .iter()
        .flat_map(|run| run.moving.iter().step_by(every).map(|k| [run.acceleration[*k], run.velocity[*k]]))
        .collect();
    let both = motion.iter().any(|[_, v]| *v > 0.0) && motion.iter().any(|[_, v]| *v < 0.0);
    let speeds = |run: &Experiment| run.recorded().commands().iter().map(|c| c.velocity_reference).collect();
    let references: Vec<Vec<f64>> = training.iter().map(speeds).collect();
    let found = no_inertia(machine, runs).or_else(|| one_speed(&references));
    found.or_else(|| inseparable(&motion, both)).into_iter().collect()
}

fn warning(message: impl Into<String>) -> Finding {
    Finding::warning("", Check::WeakExcitation, message)
}

/// References that know one speed only; of reference velocities.
fn one_speed(references: &[Vec<f64>]) -> Option<Finding> {
    let fastest = references.iter().flatten().fold(0.0, |most: f64, v| most.max(v.abs()));
    let moving = references.iter().flatten().filter(|v| **v != 0.0).count();
    let steady: Vec<f64> = references
        .iter()
        .flat_map(|run| run.windows(2))
        .filter(|pair| pair[1] != 0.0 && (pair[1] - pair[0]).abs() <= STEADY * fastest)
        .map(|pair| pair[1].abs())
        .collect();
    let count = steady.len() as f64;
    if count < MOSTLY * moving.max(1) as f64 {
        return None;
    }
    let mean = steady.iter().sum::<f64>() / count;
    let spread = (steady.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count).sqrt();
    (spread < ONE_SPEED * mean).then(|| {
        Finding::note(
            "",
            Check::WeakExcitation,
            "The training runs are commanded at one speed only: viscous and Coulomb friction are told apart by \
             ramps and settling alone. Record strokes at several feeds.",
        )
    })
}

/// A mass that even the best force channel leaves open.
fn no_inertia(machine: &Machine, runs: &[&Smoothed]) -> Option<Finding> {
    let known = |signal| {
        let inertias: Vec<Inertia> =
            runs.iter().filter_map(|run| Inertia::of(machine, run, signal)).collect();
        // Runs tell independently: their significances add as squares.
        let squares: f64 = inertias.iter().map(|inertia| inertia.mass.significance().powi(2)).sum();
        (!inertias.is_empty()).then(|| squares.sqrt())
    };
    let best = FORCE
        .into_iter()
        .filter_map(known)
        .fold(None, |best: Option<f64>, s| Some(best.map_or(s, |b| b.max(s))))?;
    (best < LEAST_SIGNIFICANCE).then(|| {
        warning(format!(
            "The training runs hardly accelerate: the moving mass (a payload) is known no better than to \
             ±{:.0} %. Record strokes with harder ramps.",
            200.0 / best.max(1e-3)
        ))
    })
}

/// Parameters whose columns nearly repeat each other.
fn inseparable(motion: &[[f64; 2]], both: bool) -> Option<Finding> {
    // Without a reversal direction and constant are one: that is said elsewhere.
    let names: &[&str] = if both {
        &["mass", "viscous friction", "Coulomb friction", "a constant force"]
    } else {
        &["mass", "viscous friction", "Coulomb friction with a constant force"]
    };
    let entry = |row: usize, column: usize| {
        let [a, v] = motion[row];
        [a, v, v.signum(), 1.0][column]
    };
    let regressor = DMatrix::from_fn(motion.len(), names.len(), entry);
    let excitation = Excitation::of(&regressor).ok()?;
    if excitation.condition() <= LARGEST_CONDITION {
        return None;
    }
    let weak = excitation.weak_direction();
    let parts: Vec<&str> =
        names.iter().zip(weak).filter(|(_, share)| share.abs() > TAKES_PART).map(|(name, _)| *name).collect();
    let message = match &parts[..] {
        [] | [_] => {
            format!("The training runs do not determine {}.", parts.first().unwrap_or(&"every parameter"))
        }
        [first @ .., last] => format!(
            "The training runs do not separate {} from {last}: in this motion they make the same force. Record \
             strokes with other ramps and feeds.",
            first.join(", ")
        ),
    };
    Some(warning(message))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trapezoids there and back at the given speeds.
    fn trapezoids(speeds: &[f64]) -> Vec<[f64; 2]> {
        let ramp = 80;
        let stroke = |speed: f64| {
            (0..1000).map(move |k: i32| {
                let from_end = k.min(999 - k);
                let v = speed * f64::from(from_end.min(ramp)) / f64::from(ramp);
                let a = if from_end >= ramp { 0.0 } else { speed / 0.02 * if k < 500 { 1.0 } else { -1.0 } };
                [a, v]
            })
        };
        speeds.iter().flat_map(|v| stroke(*v).chain(stroke(-v))).filter(|[_, v]| *v != 0.0).collect()
    }

    #[test]
    fn exact_one_speed_is_noticed_and_two_are_not() {
        let speeds = |list: &[f64]| vec![trapezoids(list).iter().map(|[_, v]| *v).collect::<Vec<f64>>()];
        assert!(one_speed(&speeds(&[0.1])).is_some());
        assert!(one_speed(&speeds(&[0.1, 0.2])).is_none());
        let swing: Vec<f64> = (0..2000).map(|k| (f64::from(k) * 0.01).sin()).collect();
        assert!(one_speed(&[swing]).is_none() && one_speed(&[vec![0.0; 100]]).is_none());
        assert!(inseparable(&trapezoids(&[0.1, 0.2]), true).is_none());
    }

    #[test]
    fn exact_columns_that_repeat_each_other_are_named() {
        // Speed and direction in proportion: nothing but one speed, without ramps.
        let steps: Vec<[f64; 2]> =
            (0..400).map(|k| [f64::from(k % 7) - 3.0, if k < 200 { 0.1 } else { -0.1 }]).collect();
        let finding = inseparable(&steps, true).unwrap();
        assert!(finding.message.contains("viscous friction from Coulomb friction"), "{}", finding.message);
    }
}
