//! The rigid-body scene: a base that stands still, a body that moves, the joint between them.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use rapier3d::dynamics::{ImpulseJointHandle, RigidBodyBuilder, RigidBodyHandle};
use rapier3d::math::Matrix;
use rapier3d::pipeline::PhysicsWorld;

use super::engine::{guide, isometry, nalgebra_vector, pose, vector};
use super::loads::Reaction;
use crate::error::{Error, ErrorKind, Result};
use crate::solid::{Joint, MassProperties, Solid};
use crate::units::Motion;

/// Step that keeps a mode of 160 Hz within 0.05 % in frequency: a quarter of a 250 µs control period.
pub const STEP_S: f64 = 62.5e-6;

/// Two rigid bodies and one joint, stepped with constant effort over each step.
///
/// Efforts, positions and velocities along the joint are in N, m, m/s for a prismatic joint and in
/// N·m, rad, rad/s for a revolute one, positive along (about) the joint's axis.
///
/// # Model
/// Symplectic Euler with one solver iteration per step (more would hold the force over sub-steps and let
/// springs gain energy): v⁺ = v + h·a, q⁺ = q + h·v⁺. The integrated coordinate therefore leads the
/// motion by half a step; [`Scene::position`] takes h·v/2 off it, which makes a constant effort
/// reproduce x = F·t²/2m to rounding. Viscous drag given by [`Scene::drag`] is discretised exactly:
/// velocity follows e^(−c·h/M) at every step size.
///
/// # Validity
/// The base is fixed, the joint has no play, no friction and no compliance. `<dynamics>` of the URDF is
/// not applied here: friction belongs to the laws that the caller applies. There are no colliders:
/// nothing is ever in contact. Finite position limits act as hard, inelastic end stops, passed by at
/// most h·v. A non-finite effort makes position and velocity NaN until the body is placed again.
///
/// A centre of mass off a revolute axis moves along its tangent within the engine's step; the projection back onto the
/// joint would cost a share ½·ω²·h·m·r²/J of the speed every second, and the joint gives way to a load across it by 1e-5 of
/// what that load would do. The scene therefore reads the speed of such a body off its angular momentum about the axis, which
/// no reaction of the joint changes, and seats it anew after every step: turned by what that speed makes, its centre moving
/// along the new tangent.
pub struct Scene {
    pub(super) world: PhysicsWorld,
    pub(super) body: RigidBodyHandle,
    link: ImpulseJointHandle,
    joint: Joint,
    moving: MassProperties,
    payload: f64,
    gravity: Vector3<f64>,
    dt_s: f64,
    /// Whether the centre of mass lies off a revolute axis by more than rounding.
    pub(super) is_off_axis: bool,
    pub(super) pending: Pending,
    pub(super) coordinate: f64,
    speed: f64,
    pub(super) reaction: Reaction,
}

/// What acts on the moving body during the next step, in its frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pending {
    effort: f64,
    force: Vector3<f64>,
    moment: Vector3<f64>,
    drag: f64,
    drag_point: Vector3<f64>,
}

impl Scene {
    /// The scene at joint position zero, at rest. `gravity` is in the base's frame.
    ///
    /// # Errors
    /// A step that is not positive, or gravity that is not finite.
    pub fn new(solid: &Solid, dt_s: f64, gravity_m_per_s2: Vector3<f64>) -> Result<Self> {
        if !(dt_s.is_finite() && dt_s > 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("dt_s")
                .found(format!("{dt_s}"))
                .expected("a positive step in s")
                .remedy("use 62.5e-6, a quarter of the control period"));
        }
        if !gravity_m_per_s2.iter().all(|g| g.is_finite()) {
            return Err(Error::new(ErrorKind::NotFinite)
                .key("gravity_m_per_s2")
                .found(format!("{gravity_m_per_s2:?}"))
                .expected("three finite numbers")
                .remedy("use (0, 0, -9.81) for an upright machine"));
        }
        let mut world = PhysicsWorld::new();
        world.gravity = vector(&gravity_m_per_s2);
        world.integration_parameters.dt = dt_s;
        world.integration_parameters.num_solver_iterations = 1;
        // No colliders: there is nothing to fly through. (The stabilisation pass stays: without it the joint
        // makes up for its first step in the second, whose reaction is then too large by 6e-6.)
        world.integration_parameters.max_ccd_substeps = 0;
        let base = world.insert_body(RigidBodyBuilder::fixed());
        let joint = solid.joint.clone();
        let is_off_axis = is_off_axis(solid);
        // The engine would turn the spin of a body that is seated anew as if the body had turned with it.
        let moving = RigidBodyBuilder::dynamic()
            .pose(pose(&joint.origin))
            .can_sleep(false)
            .gyroscopic_forces_enabled(!is_off_axis);
        let body = world.insert_body(moving);
        let link = world.insert_impulse_joint(base, body, guide(&joint));
        let mut scene = Self {
            world,
            body,
            link,
            joint,
            moving: solid.moving.mass,
            payload: 0.0,
            gravity: gravity_m_per_s2,
            dt_s,
            is_off_axis,
            pending: Pending::default(),
            coordinate: 0.0,
            speed: 0.0,
            reaction: Reaction::default(),
        };
        scene.set_mass();
        scene.place(0.0, 0.0);
        Ok(scene)
    }

    /// The same scene with `payload` more (or, if negative, less) to accelerate than the solid model says:
    /// kg at the moving body's centre of mass, or kg·m² about a revolute joint's axis. It replaces an
    /// earlier payload.
    ///
    /// # Errors
    /// A payload that leaves nothing to move.
    pub fn with_payload(mut self, payload: f64) -> Result<Self> {
        let bare = self.inertia() - self.payload;
        if !payload.is_finite() || bare + payload <= 0.0 {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("payload")
                .found(format!("{payload}"))
                .expected(format!("more than {}, the moving inertia", -bare))
                .remedy("correct the payload or the solid model"));
        }
        self.payload = payload;
        self.set_mass();
        self.place(self.position(), self.velocity());
        Ok(self)
    }

    /// Step, in s.
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// What an effort accelerates, payload included: kg, or kg·m² about the joint's axis.
    pub fn inertia(&self) -> f64 {
        let axis = self.joint.axis.into_inner();
        let bare = match self.joint.motion {
            Motion::Prismatic => self.moving.mass_kg,
            Motion::Revolute => axis.dot(&(self.moving.inertia_about(Vector3::zeros()) * axis)),
        };
        bare + self.payload
    }

    /// Centre of mass of the moving body, in its frame, in m.
    pub fn centre(&self) -> Point3<f64> {
        Point3::from(self.moving.centre_m)
    }

    /// Direction of positive motion, in the joint's frame.
    pub fn axis(&self) -> Vector3<f64> {
        self.joint.axis.into_inner()
    }

    /// Position along the joint at the end of the last step.
    pub fn position(&self) -> f64 {
        self.coordinate - 0.5 * self.dt_s * self.speed
    }

    /// Velocity along the joint at the end of the last step.
    pub fn velocity(&self) -> f64 {
        self.speed
    }

    /// What the base exerts on the moving body through the joint, mean over the last step; before the
    /// first step (and after [`Scene::place`]), what it exerts at rest.
    ///
    /// The engine's joint answers a jump of the load to 1e-5 of it in the same step, and in full in the next.
    pub fn reaction(&self) -> Reaction {
        self.reaction
    }

    /// Pose of the moving body's frame in the base's frame.
    pub fn pose(&self) -> Isometry3<f64> {
        isometry(self.world.bodies[self.body].position())
    }

    /// Adds an effort along the joint for the next step; a force acts at the point `at` of the moving
    /// body's frame, a torque (revolute joint) has no point.
    pub fn apply(&mut self, effort: f64, at: Point3<f64>) {
        let axis = self.joint.axis.into_inner();
        self.pending.effort += effort;
        match self.joint.motion {
            Motion::Prismatic => self.add_force(axis * effort, at),
            Motion::Revolute => self.pending.moment += axis * effort,
        }
    }

    /// Adds a force in any direction (moving body's frame, N) at the point `at` of that frame.
    pub fn apply_force(&mut self, force_n: Vector3<f64>, at: Point3<f64>) {
        let axis = self.joint.axis.into_inner();
        self.pending.effort += match self.joint.motion {
            Motion::Prismatic => force_n.dot(&axis),
            Motion::Revolute => at.coords.cross(&force_n).dot(&axis),
        };
        self.add_force(force_n, at);
    }

    /// Adds viscous drag −c·v for the next step, acting at `at` (ignored by a revolute joint).
    ///
    /// # Model
    /// With z = c·h/M the exact response to an effort E held over the step is
    /// v⁺ = e^(−z)·v + (1 − e^(−z))·E/c; it is reached by applying (1 − e^(−z))/z · (E − c·v), E being all
    /// other efforts of the step, gravity included.
    pub fn drag(&mut self, coefficient: f64, at: Point3<f64>) {
        self.pending.drag += coefficient;
        self.pending.drag_point += at.coords * coefficient;
    }

    /// An effort and viscous drag, both acting at the centre of mass.
    pub fn drive(&mut self, effort: f64, drag_coefficient: f64) {
        let centre = Point3::from(self.moving.centre_m);
        self.apply(effort, centre);
        self.drag(drag_coefficient, centre);
    }

    /// Advances by one step under what was applied since the last one.
    pub fn step(&mut self) {
        self.resolve_drag();
        let Pending { force, moment, .. } = std::mem::take(&mut self.pending);
        if !(force.sum() + moment.sum()).is_finite() {
            (self.coordinate, self.speed) = (f64::NAN, f64::NAN);
        }
        if self.coordinate.is_nan() {
            return;
        }
        let angle_before = match self.joint.motion {
            Motion::Prismatic => 0.0,
            Motion::Revolute => self.angle(),
        };
        let body = &mut self.world.bodies[self.body];
        let rotation = isometry(body.position()).rotation;
        // Forces persist from step to step, and rapier's own centre of mass is stale after a placement:
        // force and torque about our centre are set anew every time.
        body.reset_forces(false);
        body.reset_torques(false);
        body.add_force(vector(&(rotation * force)), false);
        body.add_torque(vector(&(rotation * moment)), false);
        let before = (nalgebra_vector(body.linvel()), nalgebra_vector(body.angvel()));
        self.world.step();
        if self.is_off_axis {
            self.speed = self.momentum(rotation) / self.inertia();
            self.coordinate += self.dt_s * self.speed;
            self.seat(self.coordinate, self.speed);
        } else {
            self.read_joint(angle_before);
        }
        let body = &self.world.bodies[self.body];
        let change = (
            rotation.inverse_transform_vector(&(nalgebra_vector(body.linvel()) - before.0)) / self.dt_s,
            rotation.inverse_transform_vector(&(nalgebra_vector(body.angvel()) - before.1)) / self.dt_s,
        );
        let spin = rotation.inverse_transform_vector(&before.1);
        let weight = rotation.inverse_transform_vector(&self.gravity) * self.mass_kg();
        let inertia = self.inertia_about_centre();
        // Newton and Euler in the body's frame: what is missing from the momentum balance came through the joint.
        self.reaction = Reaction {
            force_n: change.0 * self.mass_kg() - force - weight,
            moment_n_m: inertia * change.1 + spin.cross(&(inertia * spin)) - moment,
        };
    }

    /// Places the moving body at a joint position with a velocity along the joint.
    pub fn place(&mut self, position: f64, velocity: f64) {
        self.coordinate = position + 0.5 * self.dt_s * velocity;
        self.speed = velocity;
        self.seat(self.coordinate, velocity);
        self.pending = Pending::default();
        self.read_speed();
        self.reaction = self.reaction_at_rest();
    }

    /// Puts the engine's body where the joint holds it at a coordinate with a velocity.
    fn seat(&mut self, coordinate: f64, velocity: f64) {
        let axis = self.joint.axis;
        let along = axis.into_inner();
        let (motion, linear, angular) = match self.joint.motion {
            Motion::Prismatic => {
                let motion = Isometry3::from(Translation3::from(along * coordinate));
                (motion, along * velocity, Vector3::zeros())
            }
            Motion::Revolute => {
                let turned = UnitQuaternion::from_axis_angle(&axis, coordinate);
                let linear = turned * (along * velocity).cross(&self.moving.centre_m);
                (Isometry3::from_parts(Translation3::identity(), turned), linear, along * velocity)
            }
        };
        let rotation = self.joint.origin.rotation;
        let body = &mut self.world.bodies[self.body];
        body.set_position(pose(&(self.joint.origin * motion)), true);
        body.set_linvel(vector(&(rotation * linear)), true);
        body.set_angvel(vector(&(rotation * angular)), true);
    }

    fn mass_kg(&self) -> f64 {
        match self.joint.motion {
            Motion::Prismatic => self.moving.mass_kg + self.payload,
            Motion::Revolute => self.moving.mass_kg,
        }
    }

    fn inertia_about_centre(&self) -> Matrix3<f64> {
        let axis = self.joint.axis.into_inner();
        match self.joint.motion {
            Motion::Prismatic => self.moving.inertia_kg_m2,
            Motion::Revolute => self.moving.inertia_kg_m2 + axis * axis.transpose() * self.payload,
        }
    }

    fn set_mass(&mut self) {
        let inertia = self.inertia_about_centre();
        let columns = [0, 1, 2].map(|c| vector(&inertia.column(c).into_owned()));
        let properties = rapier3d::dynamics::MassProperties::with_inertia_matrix(
            vector(&self.moving.centre_m),
            self.mass_kg(),
            Matrix::from_cols(columns[0], columns[1], columns[2]),
        );
        self.world.bodies[self.body].set_additional_mass_properties(properties, true);
    }

    fn add_force(&mut self, force: Vector3<f64>, at: Point3<f64>) {
        self.pending.force += force;
        self.pending.moment += (at.coords - self.moving.centre_m).cross(&force);
    }

    /// Turns drag into the force that makes the step's velocity exact.
    fn resolve_drag(&mut self) {
        let c = self.pending.drag;
        if c == 0.0 {
            return;
        }
        let other = self.pending.effort + self.gravity_effort();
        let z = c * self.dt_s / self.inertia();
        let share = -(-z).exp_m1() / z;
        let at = Point3::from(self.pending.drag_point / c);
        self.apply(share * (other - c * self.speed) - other, at);
    }

    /// Effort of gravity along the joint where the engine takes it in the coming step: at the integrated coordinate.
    pub fn gravity_effort(&self) -> f64 {
        self.gravity_along(self.pose().rotation)
    }

    /// Effort of gravity along the joint at a position.
    pub fn gravity_effort_at(&self, position: f64) -> f64 {
        let turned = match self.joint.motion {
            Motion::Prismatic => UnitQuaternion::identity(),
            Motion::Revolute => UnitQuaternion::from_axis_angle(&self.joint.axis, position),
        };
        self.gravity_along(self.joint.origin.rotation * turned)
    }

    fn gravity_along(&self, rotation: UnitQuaternion<f64>) -> f64 {
        let axis = self.joint.origin.rotation * self.joint.axis.into_inner();
        let weight = self.gravity * self.mass_kg();
        match self.joint.motion {
            Motion::Prismatic => weight.dot(&axis),
            Motion::Revolute => (rotation * self.moving.centre_m).cross(&weight).dot(&axis),
        }
    }

    fn reaction_at_rest(&self) -> Reaction {
        let axis = self.joint.axis.into_inner();
        let weight = self.pose().rotation.inverse_transform_vector(&self.gravity) * self.mass_kg();
        // What the joint cannot carry is held by the drive: force or torque along the axis.
        match self.joint.motion {
            Motion::Prismatic => {
                Reaction { force_n: axis * axis.dot(&weight) - weight, moment_n_m: Vector3::zeros() }
            }
            Motion::Revolute => Reaction { force_n: -weight, moment_n_m: axis * self.gravity_effort() },
        }
    }

    /// Angular momentum about the joint's axis, in N·m·s, of a body turned so when it got its velocities.
    fn momentum(&self, rotation: UnitQuaternion<f64>) -> f64 {
        let body = &self.world.bodies[self.body];
        let [linear, angular] = [body.linvel(), body.angvel()]
            .map(|velocity| rotation.inverse_transform_vector(&nalgebra_vector(velocity)));
        let moment = self.moving.centre_m.cross(&linear) * self.mass_kg();
        self.joint.axis.dot(&(self.inertia_about_centre() * angular + moment))
    }

    /// Reads coordinate and speed along the joint after a step that began at the angle `angle_before`.
    fn read_joint(&mut self, angle_before: f64) {
        match self.joint.motion {
            Motion::Prismatic => self.coordinate = self.travel(),
            Motion::Revolute => {
                let turned = (self.angle() - angle_before + PI).rem_euclid(TAU) - PI;
                // Rapier turns by 2·atan(ω·h/2) instead of ω·h.
                self.coordinate += 2.0 * (0.5 * turned).tan();
            }
        }
        self.read_speed();
    }

    pub(super) fn read_speed(&mut self) {
        let body = &self.world.bodies[self.body];
        let velocity = match self.joint.motion {
            Motion::Prismatic => body.linvel(),
            Motion::Revolute => body.angvel(),
        };
        self.speed =
            nalgebra_vector(velocity).dot(&(self.joint.origin.rotation * self.joint.axis.into_inner()));
    }

    /// Distance along the joint from its zero, of the body as integrated.
    fn travel(&self) -> f64 {
        let position = nalgebra_vector(self.world.bodies[self.body].position().translation);
        let axis = self.joint.origin.rotation * self.joint.axis.into_inner();
        (position - self.joint.origin.translation.vector).dot(&axis)
    }

    /// Angle about the joint from its zero, up to whole turns, of the body as integrated.
    fn angle(&self) -> f64 {
        let turned = self.joint.origin.rotation.inverse() * self.pose().rotation;
        2.0 * turned.imag().dot(&self.joint.axis).atan2(turned.w)
    }

    /// Impulses of the joint's six rows in the last step as rapier keeps them (N·s, then angular), in the
    /// joint frame turned so that X is the joint's axis, as exerted on the base.
    ///
    /// The linear rows of a prismatic joint are the reaction force times the step. The angular rows are not
    /// its moment: they count half angles, and rapier orthogonalises the rows of a joint, which mixes the
    /// linear ones into them unless the centre of mass lies above the joint's frame. [`Scene::reaction`] is
    /// therefore taken from the momentum.
    pub fn row_impulses(&self) -> [f64; 6] {
        self.world.impulse_joints.get(self.link).map_or([0.0; 6], |j| std::array::from_fn(|i| j.impulses[i]))
    }
}

/// Share of the radius of gyration by which a centre of mass may lie off a revolute axis and count as on it.
const CENTRED: f64 = 1e-12;

/// Whether a body turns about another axis than through its centre of mass.
fn is_off_axis(solid: &Solid) -> bool {
    let (body, axis) = (&solid.moving.mass, solid.joint.axis.into_inner());
    let across_m = axis.cross(&body.centre_m).norm();
    let gyration_m = (solid.moving_inertia_along_joint() / body.mass_kg).sqrt();
    solid.joint.motion == Motion::Revolute && across_m > CENTRED * gyration_m
}
