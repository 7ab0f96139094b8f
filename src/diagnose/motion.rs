//! Motion read off a recorded run: smoothed velocity, acceleration, and the force that the twin lacks.

use super::drive_force::{commanded_v, drive_force, missing_voltage};
use super::estimate::Screen;
use super::estimate::screening::Series;
use super::experiment::Experiment;
use super::smooth::{HALF_WIDTH_S, smooth, smooth_uneven};
use crate::base::BaseMotion;
use crate::effect::{Constants, EffectId};
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use rayon::prelude::*;
use statrs::statistics::Statistics;

/// Smoothed motion of one run and the missing force along it.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Position in m or rad.
    pub position: Vec<f64>,
    /// Velocity in m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Acceleration in m/s² or rad/s².
    pub acceleration: Vec<f64>,
    /// `m·a + c·v − F_motor − F_weight − F_effects` in N or N·m; empty when no signal tells the motor's effort.
    pub missing_force: Vec<f64>,
    /// Motor effort in N or N·m, smoothed alike.
    pub motor_force: Vec<f64>,
    /// As `missing_force`, with the motor's effort from its current or voltage even where thrust was measured.
    pub missing_drive_force: Vec<f64>,
    /// Motor effort from current or voltage alone.
    pub drive_force: Vec<f64>,
}

/// Force that the base's motion takes: the moving part accelerates with the base beneath it.
struct BaseShare {
    motion: Option<BaseMotion>,
    state: Vec<f64>,
    velocity: f64,
    mass: f64,
    period_s: f64,
}

impl BaseShare {
    fn new(constants: &Constants, period_s: f64) -> Self {
        let motion = BaseMotion::new(&constants.modes, period_s).ok();
        let state = vec![0.0; motion.as_ref().map_or(0, BaseMotion::state_len)];
        Self { motion, state, velocity: 0.0, mass: constants.moving_mass, period_s }
    }

    /// m·Σ η̈ over the coming sample, with `driving` on the moving part and its opposite on the base.
    fn force(&mut self, driving: f64) -> f64 {
        let Some(motion) = &self.motion else { return 0.0 };
        motion.advance(&mut self.state, -driving);
        let before = std::mem::replace(&mut self.velocity, motion.velocity(&self.state));
        self.mass * (self.velocity - before) / self.period_s
    }
}

impl Motion {
    /// Reads a run.
    ///
    /// # Model
    /// A parabola is fitted to each window of 2w + 1 positions (Savitzky–Golay): value, slope and curvature at its
    /// middle. The motor's effort is smoothed with the same window, so no phase comes between them.
    ///
    /// # Errors
    /// A run without position, or a setting that the machine does not have.
    pub fn of(experiment: &Experiment, machine: &Machine) -> Result<Self> {
        let run = experiment.run();
        let machine = experiment.machine(machine)?;
        let constants = machine.constants();
        let period = run.sample_period_s();
        let half = ((HALF_WIDTH_S / period).round() as usize).max(3);
        let smooth = |samples: &[f64]| match run.instants_s() {
            Some(instants_s) => smooth_uneven(samples, instants_s, half),
            None => smooth(samples, half, period),
        };
        let [position, velocity, acceleration] = smooth(run.require(Signal::Position)?);
        let smoothed = |force: Option<Vec<f64>>| -> Vec<f64> {
            force.map(|force| smooth(&force)[0].clone()).unwrap_or_default()
        };
        let raw_drive_force =
            drive_force(experiment, &constants, &velocity, &|force| smooth(force)[0].clone());
        let drive_force = smoothed(raw_drive_force);
        let motor_force = match run.signal(Signal::Thrust) {
            Some(thrust) => smoothed(Some(thrust.to_vec())),
            None => drive_force.clone(),
        };
        let (effects, weight) = (machine.effects(), machine.weight());
        let lacking = |changes: bool, forces: &[f64]| -> Vec<f64> {
            let mut base = BaseShare::new(&constants, period);
            let each = forces.iter().enumerate().map(|(k, force)| {
                let (x, v) = (position[k], velocity[k]);
                let pushed: f64 = effects
                    .iter()
                    .map(|effect| {
                        effect.push(x, v) + if changes { force * effect.motor_change(x, *force) } else { 0.0 }
                    })
                    .sum();
                let time_s = run.begins_s + run.time_s(k);
                let shaken: f64 = effects.iter().map(|effect| effect.shake(time_s)).sum();
                let resistance = constants.friction.resistance_at(v, constants.viscous, x, time_s);
                let own = pushed + shaken - v.signum() * resistance;
                let weight = weight.map_or(0.0, |weight| weight.effort(x));
                let driving = force + own + weight - constants.viscous * v;
                constants.moving_mass * acceleration[k] + base.force(driving) - driving
            });
            each.collect()
        };
        // Thrust that was measured has ripple and saturation of the motor in it already.
        let measured_thrust = run.signal(Signal::Thrust).is_some();
        let missing_force = lacking(!measured_thrust, &motor_force);
        let missing_drive_force = lacking(true, &drive_force);
        Ok(Self {
            position,
            velocity,
            acceleration,
            missing_force,
            motor_force,
            missing_drive_force,
            drive_force,
        })
    }
}

/// Dry friction of the whole guide.
const DRY: [EffectId; 2] = [EffectId::CoulombFriction, EffectId::LoadDependentFriction];
/// Samples that screening uses at most, over all runs.
const SCREEN_SAMPLES: usize = 6000;

/// Gathers what fits need to start from the training runs.
///
/// # Errors
/// Whatever reading the motion refuses.
pub fn screen(experiments: &[Experiment], machine: &Machine) -> Result<Screen> {
    let total: usize = experiments.iter().map(Experiment::samples).sum();
    let every = total.div_ceil(SCREEN_SAMPLES).max(1);
    let constants = machine.constants();
    let both_ends = constants.sees_both_ends;
    let mut screen = Screen {
        motion: machine.motion(),
        constants: Some(constants),
        has_dry_friction: DRY.iter().any(|effect| machine.description().has(*effect)),
        lever_weight: machine.lever_weight(),
        ..Screen::default()
    };
    let (mut steps, mut voltages) = (Vec::new(), Vec::new());
    let motions: Vec<Motion> =
        experiments.par_iter().map(|experiment| Motion::of(experiment, machine)).collect::<Result<_>>()?;
    for (experiment, motion) in experiments.iter().zip(motions) {
        let run_constants = experiment.machine(machine)?.constants();
        let run = experiment.run();
        let thin = |samples: &[f64]| samples.iter().step_by(every).copied().collect::<Vec<f64>>();
        let clock_s: Vec<f64> = (0..run.len()).map(|k| run.begins_s + run.time_s(k)).collect();
        screen.clock_s.extend(thin(&clock_s));
        screen.position.extend(thin(&motion.position));
        screen.velocity.extend(thin(&motion.velocity));
        screen.acceleration.extend(thin(&motion.acceleration));
        screen.missing_force.extend(thin(&motion.missing_force));
        screen.motor_force.extend(thin(&motion.motor_force));
        screen.drive_force.extend(thin(&motion.drive_force));
        screen.missing_drive_force.extend(thin(&motion.missing_drive_force));
        if let (true, Some(load), Some(position)) =
            (both_ends, run.signal(Signal::LoadPosition), run.signal(Signal::Position))
        {
            let difference: Vec<f64> = load.iter().zip(position).map(|(l, p)| l - p).collect();
            let zero = difference.iter().sum::<f64>() / difference.len() as f64;
            screen.load_difference.extend(thin(&difference).iter().map(|d| d - zero));
        }
        let commanded = commanded_v(experiment, &run_constants).unwrap_or_default();
        screen.largest_effort_v = commanded.iter().fold(screen.largest_effort_v, |most, u| most.max(u.abs()));
        voltages.extend(
            missing_voltage(experiment, &run_constants, &motion.velocity, &commanded).unwrap_or_default(),
        );
        let most = motion.motor_force.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        screen.largest_force = screen.largest_force.max(most);
        steps.push(grid_step(run.require(Signal::Position)?));
        let Motion { velocity, acceleration, motor_force, missing_force, .. } = motion;
        let period_s = run.sample_period_s();
        screen.runs.push(Series { period_s, velocity, acceleration, motor_force, missing_force });
    }
    // Of no voltages the mean is no number.
    screen.missing_voltage = Some(voltages.mean()).filter(|volts| volts.is_finite());
    screen.reading_step = steps.into_iter().collect::<Option<Vec<f64>>>().and_then(common_step);
    if screen.largest_force == 0.0 {
        // No signal tells the motor's effort: what the recorded motion itself must have taken.
        let constants = machine.constants();
        let weight = machine.weight().map_or(0.0, |weight| weight.largest());
        let need =
            |(a, v): (&f64, &f64)| weight + (constants.moving_mass * a).abs() + (constants.viscous * v).abs();
        let most = screen.acceleration.iter().zip(&screen.velocity).map(need).fold(0.0, f64::max);
        screen.largest_force = most;
    }
    Ok(screen)
}

/// Readings may miss the grid by this share of its step: rounding of the log.
const OFF_GRID: f64 = 0.02;

/// Step of the grid on which all samples lie, if there is one: the smallest change of the reading, where every
/// reading is a whole number of those away from the first.
fn grid_step(samples: &[f64]) -> Option<f64> {
    let largest = samples.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let changes = samples.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 1e-12 * largest);
    let smallest = changes.fold(f64::INFINITY, f64::min);
    let whole = |x: &f64| {
        let steps = (x - samples[0]) / smallest;
        (steps - steps.round()).abs() < OFF_GRID
    };
    // Few steps over the whole run are a coincidence of any numbers with few digits.
    (smallest.is_finite() && samples.iter().all(whole)).then_some(smallest)
}

/// The step that several runs share.
fn common_step(steps: Vec<f64>) -> Option<f64> {
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let multiple = |step: &f64| ((step / least) - (step / least).round()).abs() < OFF_GRID;
    (least.is_finite() && steps.iter().all(multiple)).then_some(least)
}
