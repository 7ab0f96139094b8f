//! The force that the twin lacks, and the law that was fitted to it.

use crate::diagnose::experiment::Experiment;
use crate::diagnose::motion::Motion;
use crate::error::Result;
use crate::machine::Machine;

/// The missing force along all runs, in SI.
#[derive(Debug, Clone, Default)]
pub struct Force {
    /// Time in the first run, in s.
    pub time_s: Vec<f64>,
    /// Position.
    pub position: Vec<f64>,
    /// Velocity.
    pub velocity: Vec<f64>,
    /// Acceleration.
    pub acceleration: Vec<f64>,
    /// What the twin as it is lacks.
    pub before: Vec<f64>,
    /// What the twin with its causes lacks.
    pub after: Vec<f64>,
    /// Samples of the first run, whose name this is.
    pub first: (String, usize),
    /// Of so many samples one is kept.
    pub every: usize,
}

/// The course of a law over a quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Over {
    /// Medians, apart for either direction.
    pub curves: [Vec<[f64; 2]>; 2],
    /// Share of the law's mean square that lies beside them.
    pub beside: f64,
}

/// Samples that are kept at most, evenly chosen.
const MOST: usize = 24_000;
/// Bins of the law over a quantity.
const BINS: usize = 60;
/// A law follows a quantity where less than this share of its mean square lies beside the medians.
const FOLLOWS: f64 = 0.3;
/// Below this share of the largest speed an axis stands still, and friction takes any value.
const STILL: f64 = 0.01;

impl Force {
    /// The missing force of both machines along all runs; none where no signal tells the motor's force.
    ///
    /// # Errors
    /// What a replay refuses.
    pub fn of(experiments: &[&Experiment], [stated, improved]: [&Machine; 2]) -> Result<Option<Self>> {
        let pair = LawPair::of(stated, improved)?;
        let total: usize = experiments.iter().map(|e| e.samples()).sum();
        let every = total.div_ceil(MOST).max(1);
        let mut all = Self { every, ..Self::default() };
        for (place, experiment) in experiments.iter().enumerate() {
            let before = Motion::of(experiment, stated)?;
            if before.missing_force.is_empty() {
                return Ok(None);
            }
            let law = pair.law(experiment)?;
            let period = experiment.run().sample_period_s();
            for k in (0..before.missing_force.len()).step_by(every) {
                all.time_s.push(k as f64 * period);
                all.position.push(before.position[k]);
                all.velocity.push(before.velocity[k]);
                all.acceleration.push(before.acceleration[k]);
                all.before.push(before.missing_force[k]);
                all.after.push(before.missing_force[k] - law[k]);
            }
            if place == 0 {
                all.first = (experiment.run().name().to_owned(), all.before.len());
            }
        }
        Ok(Some(all))
    }

    /// What the causes take up of it: before less after.
    pub fn law(&self) -> impl Iterator<Item = f64> + '_ {
        self.before.iter().zip(&self.after).map(|(before, after)| before - after)
    }

    /// Whether the axis moves at a sample.
    pub fn moves(&self) -> Vec<bool> {
        let most = self.velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        self.velocity.iter().map(|v| v.abs() > STILL * most).collect()
    }

    /// The law over a quantity: median of each bin that holds moving samples, apart for either direction; empty where the
    /// law does not follow the quantity.
    pub fn law_over(&self, quantity: &[f64]) -> [Vec<[f64; 2]>; 2] {
        let law: Vec<f64> = self.law().collect();
        over(self, &law, quantity).map_or_else(Default::default, |over| over.curves)
    }
}

/// The course of a law over a quantity of the motion, moving samples alone; none where in neither direction it follows it.
pub(super) fn over(force: &Force, law: &[f64], quantity: &[f64]) -> Option<Over> {
    let moves = force.moves();
    let (mut sums, mut is_any) = ([0.0, 0.0], false);
    let curves = [1.0, -1.0].map(|direction: f64| {
        let of = |k: &usize| moves[*k] && force.velocity[*k] * direction > 0.0;
        let chosen = (0..law.len().min(quantity.len())).filter(of);
        let Some((curve, [beside, whole])) = binned(chosen.map(|k| [quantity[k], law[k]]).collect()) else {
            return Vec::new();
        };
        (sums[0], sums[1], is_any) = (sums[0] + beside, sums[1] + whole, true);
        curve
    });
    is_any.then(|| Over { curves, beside: if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 } })
}

/// Two machines whose missing forces differ by the law.
///
/// # Model
/// Where the base is the same in both, it is left out of both: friction at standstill changes its sign with every grain
/// of noise, and a base driven by that rings on into the motion. What the law itself makes of the base is neglected,
/// the ratio of the moving mass to the modal masses.
pub(super) struct LawPair([Machine; 2]);

impl LawPair {
    pub(super) fn of(stated: &Machine, improved: &Machine) -> Result<Self> {
        let is_same = stated.constants().modes == improved.constants().modes;
        let rigid = |machine: &Machine| match is_same && machine.description().base.is_some() {
            true => machine.with_settings([("base.mode", toml::Value::Array(Vec::new()))]),
            false => Ok(machine.clone()),
        };
        Ok(Self([rigid(stated)?, rigid(improved)?]))
    }

    pub(super) fn law(&self, experiment: &Experiment) -> Result<Vec<f64>> {
        let [before, after] = [Motion::of(experiment, &self.0[0])?, Motion::of(experiment, &self.0[1])?];
        Ok(before.missing_force.iter().zip(&after.missing_force).map(|(b, a)| b - a).collect())
    }
}

/// Medians of evenly spaced bins, with the square sums beside them and of all; bins of few samples are left out.
fn binned(pairs: Vec<[f64; 2]>) -> Option<(Vec<[f64; 2]>, [f64; 2])> {
    let [from, to] = crate::report::figure::axis::extremes(pairs.iter().map(|p| p[0]));
    let width = (to - from) / BINS as f64;
    if pairs.len() < BINS || width <= 0.0 {
        return None;
    }
    let mut bins: Vec<Vec<[f64; 2]>> = vec![Vec::new(); BINS];
    for pair in pairs {
        bins[(((pair[0] - from) / width) as usize).min(BINS - 1)].push(pair);
    }
    let median = |bin: &[[f64; 2]], place: usize| {
        let mut values: Vec<f64> = bin.iter().map(|p| p[place]).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let full: Vec<(&Vec<[f64; 2]>, [f64; 2])> =
        bins.iter().filter(|bin| bin.len() >= 4).map(|bin| (bin, [median(bin, 0), median(bin, 1)])).collect();
    let (mut beside, mut whole) = (0.0, 0.0);
    for (bin, [_, middle]) in &full {
        beside += bin.iter().map(|p| (p[1] - middle).powi(2)).sum::<f64>();
        whole += bin.iter().map(|p| p[1].powi(2)).sum::<f64>();
    }
    let curve = || full.into_iter().map(|(_, point)| point).collect();
    (beside < FOLLOWS * whole).then(|| (curve(), [beside, whole]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force of 3 N against the motion and 2·sin along the position: the first follows velocity and nothing lies beside its
    /// course; the second follows position, and over velocity it follows nothing.
    #[test]
    fn exact_a_law_follows_what_it_depends_on() {
        let count = 12_000;
        let phase = |k: usize| std::f64::consts::TAU * k as f64 / 3000.0;
        let force = Force {
            position: (0..count).map(|k| 0.1 * phase(k).sin()).collect(),
            velocity: (0..count).map(|k| phase(k).cos()).collect(),
            ..Force::default()
        };
        let friction: Vec<f64> = force.velocity.iter().map(|v| -3.0 * v.signum()).collect();
        let found = over(&force, &friction, &force.velocity).unwrap();
        assert!(found.beside < 1e-12, "{}", found.beside);
        assert!(found.curves[0].iter().all(|[v, f]| *v > 0.0 && (f + 3.0).abs() < 1e-12));
        assert!(found.curves[1].iter().all(|[v, f]| *v < 0.0 && (f - 3.0).abs() < 1e-12));
        let cogging: Vec<f64> = force.position.iter().map(|x| 2.0 * (100.0 * x).sin()).collect();
        let found = over(&force, &cogging, &force.position).unwrap();
        assert!(found.beside < 0.02 && found.curves.iter().all(|c| c.len() > 50), "{}", found.beside);
        assert!(over(&force, &cogging, &force.velocity).is_none());
    }
}
