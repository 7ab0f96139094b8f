//! The experiment that identifies the moving part alone: a pseudo-random force on it, its velocity out.

use nalgebra::{Point3, Vector3};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::PlantChoice;
use crate::effect::Constants;
use crate::error::{Error, ErrorKind, Result};
use crate::guide::StepForce;
use crate::machine::Machine;
use crate::plant::axis::{Axis, LONGEST_STEP_S};
use crate::plant::mujoco::{Integrator, MujocoRig};
use crate::plant::rapier::{STEP_S, Scene};
use crate::plant::{Drive, Plant};
use crate::solid::GRAVITY_M_PER_S2;

/// Share of the joint's travel, speed and effort that the experiment uses at most.
const SHARE_OF_LIMITS: f64 = 0.5;
/// Speed in m/s or rad/s where neither travel nor speed of the joint is limited.
const SPEED_WITHOUT_LIMITS: f64 = 0.1;
/// Levels to each side of zero between which the force jumps.
const LEVELS: i32 = 4;

/// An excitation: how long each force is held, how many there are, and the seed of their sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Excitation {
    /// Time that each force is held, and the period at which velocity is read, in s.
    pub period_s: f64,
    /// Number of periods.
    pub samples: usize,
    /// Seed of the pseudo-random sequence.
    pub seed: u64,
}

/// What the experiment recorded: force `k` is held from sample `k` to `k + 1`.
#[derive(Debug, Clone, PartialEq)]
pub struct Excited {
    /// Force in N (torque in N·m).
    pub force: Vec<f64>,
    /// Velocity at the beginning of each period in m/s (rad/s).
    pub velocity: Vec<f64>,
    /// Time between two samples in s.
    pub period_s: f64,
}

/// Periods of the controller in one excitation at most.
const MOST_PERIODS: f64 = 1e8;

impl Excitation {
    /// Drives the moving part on its viscous guide with random force levels from standstill in the middle of its travel.
    ///
    /// # Model
    /// m·dv/dt = F − c·v with m and c of the machine, effects that alter them included; F jumps between nine
    /// equally spaced levels. Its size is chosen so that the exact solution of this equation stays within half of
    /// the joint's travel, speed and effort.
    ///
    /// # Validity
    /// The base is rigid and friction other than viscous is left out: what is identified is the linear moving
    /// part, as a solid modeller's frame-by-frame simulation yields it.
    ///
    /// # Errors
    /// A period that is not finite and > 0; an axis that weight drives along its joint; what the scene refuses.
    pub fn run(&self, machine: &Machine, plant: PlantChoice) -> Result<Excited> {
        if !(self.period_s.is_finite() && self.period_s > 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("period")
                .found(self.period_s.to_string())
                .expected("a finite number of seconds > 0")
                .remedy("give for instance 0.025"));
        }
        let periods = self.samples as f64 * self.period_s / machine.description().sample_period_s;
        if periods > MOST_PERIODS {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("period")
                .found(format!("{} samples every {:e} s", self.samples, self.period_s))
                .expected(format!("at most {MOST_PERIODS:.0e} periods of the controller in all"))
                .remedy("ask for a shorter period or fewer samples"));
        }
        if let Some(weight) = machine.weight() {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(machine.file())
                .key(&machine.solid().joint.name)
                .found(format!("weight along the joint, up to {:.4} N or N·m", weight.largest()))
                .expected("a level guide or a part balanced about its axis: it would fall under a force of mean zero")
                .remedy("identify it in closed loop (slideway identify response), or level the joint in the URDF"));
        }
        let constants = machine.constants();
        let mut random = StdRng::seed_from_u64(self.seed);
        let level = |_| f64::from(random.random_range(-LEVELS..=LEVELS)) / f64::from(LEVELS);
        let unit: Vec<f64> = (0..self.samples).map(level).collect();
        let size = self.size(machine, &constants, &unit);
        let force: Vec<f64> = unit.into_iter().map(|level| size * level).collect();
        let velocity = match plant {
            PlantChoice::Rapier => self.on_scene(machine, &constants, &force)?,
            PlantChoice::Axis => self.on_axis(machine, constants, &force),
            PlantChoice::Mujoco => self.on_mujoco(machine, constants, &force)?,
        };
        Ok(Excited { force, velocity, period_s: self.period_s })
    }

    /// Force whose exact response stays within the limits, the equation being linear.
    fn size(&self, machine: &Machine, constants: &Constants, unit: &[f64]) -> f64 {
        let joint = &machine.solid().joint;
        let (m, c, h) = (constants.moving_mass, constants.viscous, self.period_s);
        let z = c * h / m;
        let decay = (-z).exp();
        // (1 − e^−z)/z, 1 without drag
        let mean = if z > 0.0 { -(-z).exp_m1() / z } else { 1.0 };
        let (mut speed, mut fastest, mut place, mut farthest) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
        for force in unit {
            let next = decay * speed + mean * h / m * force;
            // Between two samples the speed is monotonic: the larger end bounds the way.
            place += 0.5 * h * (speed + next);
            speed = next;
            fastest = fastest.max(speed.abs());
            farthest = farthest.max(place.abs());
        }
        let limits = [joint.effort, joint.velocity / fastest, joint.half_travel() / farthest];
        let size = limits.into_iter().filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min) * SHARE_OF_LIMITS;
        if size.is_finite() { size } else { SPEED_WITHOUT_LIMITS / fastest.max(f64::MIN_POSITIVE) }
    }

    fn on_scene(&self, machine: &Machine, constants: &Constants, force: &[f64]) -> Result<Vec<f64>> {
        let steps = (self.period_s / STEP_S - 1e-9).ceil().max(1.0);
        let solid = &*machine.loaded_solid();
        let gravity = Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2);
        let payload = constants.moving_mass - solid.moving_inertia_along_joint();
        let mut scene = Scene::new(solid, self.period_s / steps, gravity)?.with_payload(payload)?;
        scene.place(solid.joint.middle(), 0.0);
        let centre = Point3::from(solid.moving.mass.centre_m);
        let mut velocity = Vec::with_capacity(force.len());
        for &force in force {
            velocity.push(scene.velocity());
            for _ in 0..steps as usize {
                scene.apply(force, centre);
                scene.drag(constants.viscous, centre);
                scene.step();
            }
        }
        Ok(velocity)
    }

    fn on_axis(&self, machine: &Machine, mut constants: Constants, force: &[f64]) -> Vec<f64> {
        let steps = (self.period_s / LONGEST_STEP_S - 1e-9).ceil().max(1.0);
        constants.modes = crate::base::Modes::default();
        let axis = Axis::new(&constants, self.period_s / steps);
        Self::pushed(machine, axis, steps as usize, force)
    }

    fn on_mujoco(&self, machine: &Machine, mut constants: Constants, force: &[f64]) -> Result<Vec<f64>> {
        let steps = (self.period_s / STEP_S - 1e-9).ceil().max(1.0);
        constants.modes = crate::base::Modes::default();
        let step_s = self.period_s / steps;
        let rig = MujocoRig::with_constants(machine, &constants, step_s, Integrator::RungeKutta)?;
        Ok(Self::pushed(machine, rig, steps as usize, force))
    }

    /// Velocity at the beginning of each period, in which a plant makes `steps` steps under one force.
    fn pushed(machine: &Machine, mut plant: impl Plant, steps: usize, force: &[f64]) -> Vec<f64> {
        plant.place(machine.solid().joint.middle(), 0.0);
        let mut velocity = Vec::with_capacity(force.len());
        for &force in force {
            velocity.push(plant.velocity());
            for _ in 0..steps {
                plant.coast(Drive::Force(force));
                plant.advance(StepForce::ZERO, StepForce::ZERO);
            }
        }
        velocity
    }
}
