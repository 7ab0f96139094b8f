//! MuJoCo's state and one step of it.

use mujoco_rs::prelude::{MjData, MjModel, MjtObjBase};
use nalgebra::{Matrix3, Vector3};

use super::Integrator;
use super::attack::{Attack, Wrench};
use super::scene::{missing, mode_name, refusal};
use super::state::{RiseResponse, State};
use crate::effect::Constants;
use crate::error::Result;
use crate::guide::Response;
use crate::plant::rapier::Reaction;
use crate::solid::{Solid, Weight};
use crate::units::Motion;

/// Coordinate or speed (m, rad, per s) from which on a motion is not stepped any further. MuJoCo's own bound is 1e10; it
/// writes a file into the working folder when that is passed.
const FURTHEST: f64 = 1e6;
/// The same for the acceleration by the applied force, in m/s² or rad/s².
const STRONGEST: f64 = 1e9;

/// Efforts along the joint, held over a step: N or N·m.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Efforts {
    pub motor: f64,
    pub guide: f64,
}

/// A compiled scene with its state.
pub(super) struct Engine {
    data: MjData<Box<MjModel>>,
    body: usize,
    table: usize,
    attack: Attack,
    inverse_mass: f64,
    /// Weight along the joint, for the base's share of it.
    weight: Option<Weight>,
    /// Time by which the engine's coordinates lead the motion.
    lead_s: f64,
}

impl Engine {
    /// The scene at its zero, with the machine's payload.
    ///
    /// A payload of a prismatic axis sits in the centre of mass of the moving body; that of a revolute one is an inertia
    /// about the axis. The rotor of a transmission is the joint's armature.
    pub fn new(
        solid: &Solid,
        constants: &Constants,
        mut model: MjModel,
        attack: Attack,
        integrator: Integrator,
    ) -> Result<Self> {
        let body = super::import::body(solid, &model)?;
        let dof = |name: &str| -> Result<usize> {
            let joint =
                model.name_to_id(MjtObjBase::mjOBJ_JOINT, name).ok_or_else(|| missing(solid, name))?;
            usize::try_from(model.jnt_dofadr()[joint]).map_err(|_| missing(solid, name))
        };
        let table = dof(&solid.joint.name)?;
        for number in 0..constants.modes.len() {
            dof(&mode_name(number))?;
        }
        let payload = constants.moving_mass - solid.moving_inertia_along_joint();
        match solid.joint.motion {
            Motion::Prismatic => {
                model.body_mass_mut()[body] += payload - constants.rotor_inertia;
                model.dof_armature_mut()[table] += constants.rotor_inertia;
            }
            Motion::Revolute => model.dof_armature_mut()[table] += payload,
        }
        let lead_s = match integrator {
            Integrator::RungeKutta => 0.0,
            Integrator::Euler => 0.5 * model.opt().timestep,
        };
        let weighing = constants.moving_mass - constants.rotor_inertia;
        let weight = Weight::of(&solid.joint, &solid.moving.mass, weighing);
        let mut data = MjData::try_new(Box::new(model)).map_err(|e| refusal(solid, &e.to_string()))?;
        // What the compiler derived from the masses is derived anew.
        data.set_const();
        Ok(Self { data, body, table, attack, inverse_mass: 1.0 / constants.moving_mass, weight, lead_s })
    }

    /// Rest at zero.
    pub fn zero(&self) -> State {
        let size = self.data.qvel().len();
        State { q: vec![0.0; size], v: vec![0.0; size] }
    }

    /// Place of the driven joint in the state.
    pub fn table(&self) -> usize {
        self.table
    }

    /// Time by which the engine's coordinates lead the motion.
    pub fn lead_s(&self) -> f64 {
        self.lead_s
    }

    /// Position of the moving part relative to the base.
    pub fn position(&self, State { q, v }: &State) -> f64 {
        self.relative(q) - self.lead_s * self.relative(v)
    }

    /// Velocity of the moving part relative to the base.
    pub fn velocity(&self, state: &State) -> f64 {
        self.relative(&state.v)
    }

    /// Sum of the modes' coordinates.
    pub fn base_displacement(&self, state: &State) -> f64 {
        state.q[self.table] - self.lead_s * state.v[self.table] - self.position(state)
    }

    /// Difference of the driven joint's value and all others: the axis coordinate, or its speed.
    fn relative(&self, values: &[f64]) -> f64 {
        values.iter().enumerate().map(|(dof, value)| self.sign(dof) * value).sum()
    }

    /// Generalised force per unit effort between table and base: 1 on the driven joint, −1 on every mode.
    pub fn sign(&self, dof: usize) -> f64 {
        if dof == self.table { 1.0 } else { -1.0 }
    }

    /// Steps from `from` to `to` under efforts held over the step.
    ///
    /// A state or an effort that is not finite, or beyond what any axis can have, makes `to` NaN without a step.
    pub fn step(&mut self, from: &State, efforts: Efforts, to: &mut State) {
        if !self.can_step(from, efforts) {
            to.q.fill(f64::NAN);
            to.v.fill(f64::NAN);
            return;
        }
        self.set(from, efforts);
        self.data.step();
        to.q.copy_from_slice(self.data.qpos());
        to.v.copy_from_slice(self.data.qvel());
    }

    fn can_step(&self, from: &State, Efforts { motor, guide }: Efforts) -> bool {
        // NaN passes no comparison.
        (motor.abs() + guide.abs()) * self.inverse_mass < STRONGEST
            && from.q.iter().chain(&from.v).all(|value| value.abs() < FURTHEST)
    }

    fn set(&mut self, state: &State, efforts: Efforts) {
        self.data.qpos_mut().copy_from_slice(&state.q);
        self.data.qvel_mut().copy_from_slice(&state.v);
        let Attack { motor, guide, .. } = self.attack;
        let wrench: Wrench = std::array::from_fn(|k| motor[k] * efforts.motor + guide[k] * efforts.guide);
        self.data.xfrc_applied_mut()[self.body] = wrench;
        // The reaction, as a generalised force: a mode's joint points along the axis, its body turns or moves nothing else.
        let table = self.table;
        let weight = self.weight.map_or(0.0, |weight| weight.effort(state.q[table]));
        for (dof, force) in self.data.qfrc_applied_mut().iter_mut().enumerate() {
            *force = if dof == table { 0.0 } else { -(efforts.motor + efforts.guide + weight) };
        }
    }

    /// Adds to the state after a step what a force's rise within it does beside its mean.
    pub fn add_rise(&self, state: &mut State, by_rise: &RiseResponse, rise: f64) {
        for (dof, (q, v)) in by_rise.q.iter().zip(&by_rise.v).enumerate() {
            state.q[dof] += rise * (q + self.lead_s * v);
            state.v[dof] += rise * v;
        }
    }

    /// What a force of the guide changes: steps from rest with and without a unit of it, and its rise.
    pub fn response(&mut self, by_rise: &RiseResponse) -> Response {
        let zero = self.zero();
        let mut ends = [zero.clone(), zero.clone()];
        for (guide, end) in [0.0, 1.0].into_iter().zip(&mut ends) {
            self.step(&zero, Efforts { motor: 0.0, guide }, end);
        }
        let [free, pushed] = &ends;
        Response::new(
            self.velocity(pushed) - self.velocity(free),
            self.position(pushed) - self.position(free),
            self.relative(&by_rise.v),
            self.relative(&by_rise.q),
        )
    }

    /// Mass matrix at a state, row by row.
    pub fn mass_matrix(&mut self, state: &State) -> Vec<f64> {
        self.set(state, Efforts::default());
        self.data.forward();
        let size = state.q.len();
        let mut matrix = vec![0.0; size * size];
        // The buffer has the size that is asked for.
        let filled = self.data.full_m(&mut matrix);
        debug_assert!(filled.is_ok());
        matrix
    }

    /// Forces of springs and dampers at a state.
    pub fn passive_forces(&mut self, state: &State) -> Vec<f64> {
        self.set(state, Efforts::default());
        self.data.forward();
        self.data.qfrc_passive().to_vec()
    }

    /// What the base exerts on the moving body through the joint at a state under these efforts.
    ///
    /// # Model
    /// MuJoCo's interaction force of the moving body (recursive Newton–Euler with the accelerations just found) balances
    /// inertia, weight and applied wrench. It contains what the drag exerts, as a pure effort along the joint; that is taken
    /// off where drag really acts, at the friction point.
    pub fn reaction(&mut self, state: &State, efforts: Efforts) -> Reaction {
        if !self.can_step(state, efforts) {
            let unknown = Vector3::repeat(f64::NAN);
            return Reaction { force_n: unknown, moment_n_m: unknown };
        }
        self.set(state, efforts);
        self.data.forward();
        self.data.rne_post_constraint();
        let body = self.body;
        let root = usize::try_from(self.data.model().body_rootid()[body]).unwrap_or(body);
        let [mx, my, mz, fx, fy, fz] = self.data.cfrc_int()[body];
        let force = Vector3::new(fx, fy, fz);
        let centre = Vector3::from(self.data.xipos()[body]);
        let about = Vector3::from(self.data.subtree_com()[root]);
        let moment = Vector3::new(mx, my, mz) + (about - centre).cross(&force);
        // Row by row, from the body's frame to the world's.
        let turned = Matrix3::from_row_slice(&self.data.xmat()[body]);
        let drag = self.data.qfrc_passive()[self.table];
        let [ax, ay, az, bx, by, bz] = self.attack.guide.map(|part| part * drag);
        Reaction {
            force_n: turned.transpose() * (force - Vector3::new(ax, ay, az)),
            moment_n_m: turned.transpose() * (moment - Vector3::new(bx, by, bz)),
        }
    }
}
