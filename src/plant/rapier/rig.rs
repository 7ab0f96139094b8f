//! The whole plant on the rigid-body scene: table, guide drag, base modes and slider loads.

use super::{STEP_S, Scene, Supports};
use crate::base::BaseMotion;
use crate::error::Result;
use crate::guide::{Coast, Response, StepForce};
use crate::machine::Machine;
use crate::plant::{Drive, Plant, WindingState};
use crate::solid::GRAVITY_M_PER_S2;
use crate::units::Motion;
use nalgebra::{Point3, Vector3};

/// The machine's moving part as a rigid body on its joint, over a base that answers with its modes.
///
/// # Model
/// The motor's force attacks at its lines of action, friction and drag at the middle of the sliders; the
/// [`Scene`] moves the body. The base chain moves along the joint only and the guide is rigid across it, so the
/// chain meets the scene through one force and one displacement: it is propagated exactly beside the scene
/// ([`BaseMotion`]) under the reaction of every force between table and base, and the encoder reads the table
/// relative to it.
///
/// The engine holds a force over a step, [`WindingState`] and the guide's laws give it as mean and rise. The rise moves the
/// position within each step by `−rise·h²/12·(1/m + Σ 1/M_j)` (Euler and Maclaurin's correction of the trapezoidal rule by
/// which velocity becomes way); the rig adds that to the coordinate it reads off the scene.
///
/// Weight is the scene's own. Of a body off a revolute axis it changes within the step, and the engine takes it where its
/// coordinate stands; the rig adds what the weight's mean over the step, by the scene's mass and centre, differs from that
/// (second order in the step).
///
/// # Validity
/// Drag acts on the velocity relative to the base, the base's part of it explicitly (the base moves
/// micrometres). Steps are at most [`STEP_S`] and divide the sample period.
pub struct Rig {
    scene: Scene,
    base: BaseMotion,
    base_state: Vec<f64>,
    motor: WindingState,
    motor_force: StepForce,
    /// Weight along the joint over the step that was looked at; stays zero where there is none.
    weight: StepForce,
    has_weight: bool,
    /// What the rises of the forces have moved the position by so far.
    shift: f64,
    response: Response,
    /// Change of the table's velocity per unit of force, and c·h/m.
    mobility: f64,
    decay: f64,
    viscous: f64,
    lines_of_action: Vec<Point3<f64>>,
    friction_point: Point3<f64>,
    /// What holds the rotor's inertia against gravity, in the moving body's frame; it is a mass of the scene's body.
    rotor_support: Option<Vector3<f64>>,
    supports: Option<Supports>,
}

impl Rig {
    /// The machine's plant with the finest step that divides its sample period and is at most [`STEP_S`].
    ///
    /// # Errors
    /// What the scene, the base or the sliders refuse.
    pub fn new(machine: &Machine) -> Result<Self> {
        let period = machine.constants().sample_period_s;
        Self::with_step(machine, period / (period / STEP_S - 1e-9).ceil())
    }

    /// The machine's plant with a step of its own, which must divide the sample period.
    ///
    /// # Errors
    /// What the scene, the base or the sliders refuse.
    pub fn with_step(machine: &Machine, step_s: f64) -> Result<Self> {
        let (solid, constants) = (&*machine.loaded_solid(), machine.constants());
        let payload = constants.moving_mass - solid.moving_inertia_along_joint();
        let gravity = Vector3::new(0.0, 0.0, -GRAVITY_M_PER_S2);
        let scene = Scene::new(solid, step_s, gravity)?.with_payload(payload)?;
        let base = BaseMotion::new(&constants.modes, step_s)?;
        let description = machine.description();
        let sliders: Vec<&str> = description.guide.sliders.iter().map(String::as_str).collect();
        let supports = match sliders.len() {
            4 => Some(Supports::new(solid, &sliders, Vector3::z())?),
            _ => None,
        };
        let has_rotor = constants.rotor_inertia > 0.0 && machine.motion() == Motion::Prismatic;
        let down = solid.joint.origin.rotation.inverse_transform_vector(&gravity);
        let rotor_support = has_rotor.then(|| -down * constants.rotor_inertia);
        let centre = Point3::from(solid.moving.mass.centre_m);
        let mut lines: Vec<Point3<f64>> =
            description.motor.lines_of_action_m().iter().map(|p| Point3::from(*p)).collect();
        if lines.is_empty() || machine.motion() == Motion::Revolute {
            lines = vec![centre];
        }
        let friction_point = supports.as_ref().map_or(centre, |s| middle(s.points()));
        let inverse_masses =
            constants.modes.as_slice().iter().fold(1.0 / scene.inertia(), |sum, m| sum + 1.0 / m.mass_kg());
        // What a force changes of the table's velocity; drag is discretised exactly.
        let decay = constants.viscous * step_s / scene.inertia();
        let drag = if decay > 0.0 { -(-decay).exp_m1() / decay } else { 1.0 };
        let mobility = drag * step_s / scene.inertia();
        let response = Response::new(
            mobility + base.velocity_per_force(),
            0.5 * step_s * mobility + base.displacement_per_force(),
            0.0,
            -step_s * step_s / 12.0 * inverse_masses,
        );
        Ok(Self {
            motor: WindingState::new(&constants.circuit, step_s),
            motor_force: StepForce::ZERO,
            weight: StepForce::ZERO,
            has_weight: machine.weight().is_some(),
            shift: 0.0,
            response,
            mobility,
            decay,
            base_state: vec![0.0; base.state_len()],
            scene,
            base,
            viscous: constants.viscous,
            lines_of_action: lines,
            friction_point,
            rotor_support,
            supports,
        })
    }

    /// The rigid-body scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Displacement of the base at the reaction point in m.
    pub fn base_displacement(&self) -> f64 {
        self.base.displacement(&self.base_state)
    }

    /// Weight over the step that the motor alone would end so, along the way that it leaves.
    ///
    /// Its rise is on the speed for less of the drag than its mean is: z/12 of it, z = c·h/m, counts as mean (to first order
    /// in z).
    fn weight_over(&self, coast: Coast) -> StepForce {
        let (position, step_s) = (self.position(), self.step_s());
        let over =
            |coast: Coast| coast.force_over(position, step_s, |place| self.scene.gravity_effort_at(place));
        let StepForce { mean, rise } = over(coast.under(over(coast)));
        let along = self.scene.axis();
        let support = self.rotor_support.map_or(0.0, |force| force.dot(&along));
        StepForce { mean: mean + rise * self.decay / 12.0 + support, rise }
    }

    fn base_velocity(&self) -> f64 {
        self.base.velocity(&self.base_state)
    }
}

fn middle(points: &[Point3<f64>]) -> Point3<f64> {
    let sum = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
    Point3::from(sum / points.len().max(1) as f64)
}

impl Plant for Rig {
    fn step_s(&self) -> f64 {
        self.scene.dt_s()
    }

    fn position(&self) -> f64 {
        self.scene.position() - self.base_displacement() + self.shift
    }

    fn velocity(&self) -> f64 {
        self.scene.velocity() - self.base_velocity()
    }

    fn current(&self) -> f64 {
        self.motor.current()
    }

    fn set_current(&mut self, current_a: f64) {
        self.motor.set_current(current_a);
    }

    fn coast(&mut self, drive: Drive) -> Coast {
        let (velocity, step_s) = (self.velocity(), self.step_s());
        let (motor_force, ends) = self.motor.look_ahead(drive, velocity);
        self.motor_force = motor_force;
        let force = motor_force.mean;
        let table = self.scene.velocity() * (-self.decay).exp()
            + self.mobility * (force + self.viscous * self.base_velocity());
        let on_base = self.viscous * velocity - force;
        let base = self.base.free_velocity(&self.base_state) + self.base.velocity_per_force() * on_base;
        let moved = self.base.free_displacement(&self.base_state)
            + self.base.displacement_per_force() * on_base
            - self.base_displacement();
        let coast = Coast {
            velocity,
            free_velocity: table - base,
            free_travel: 0.5 * step_s * (self.scene.velocity() + table) - moved
                + self.response.rise_travel * motor_force.rise,
            motor_force: ends,
            response: self.response,
        };
        if !self.has_weight {
            return coast;
        }
        self.weight = self.weight_over(coast);
        Coast { motor_force: ends, ..coast.under(self.weight) }
    }

    fn advance(&mut self, motor: StepForce, guide: StepForce) {
        let before = self.velocity();
        let motor = self.motor_force + motor;
        let share = motor.mean / self.lines_of_action.len() as f64;
        for point in &self.lines_of_action {
            self.scene.apply(share, *point);
        }
        self.scene.apply(guide.mean + self.viscous * self.base_velocity(), self.friction_point);
        if self.scene.is_off_axis {
            self.scene.apply(self.weight.mean - self.scene.gravity_effort(), self.friction_point);
        }
        if let Some(force) = self.rotor_support {
            self.scene.apply_force(force, self.scene.centre());
        }
        self.scene.drag(self.viscous, self.friction_point);
        self.scene.step();
        // Mean drag of the step, from the velocities at its two ends.
        let after = self.scene.velocity() - self.base_velocity();
        let drag = self.viscous * 0.5 * (before + after);
        let StepForce { mean, rise } = self.weight;
        self.base.advance(&mut self.base_state, drag - motor.mean - guide.mean - mean);
        self.shift += self.response.rise_travel * (motor.rise + guide.rise + rise);
        self.motor.advance();
    }

    fn place(&mut self, position: f64, velocity: f64) {
        self.scene.place(position, velocity);
        self.base_state.fill(0.0);
        self.shift = 0.0;
        self.motor.place(velocity);
    }

    fn snapshot(&self) -> Vec<f64> {
        let mut all = self.base_state.clone();
        all.push(self.shift);
        all.extend(self.motor.snapshot());
        all.extend(self.scene.snapshot());
        all
    }

    fn restore(&mut self, snapshot: &[f64]) {
        let (base, rest) = snapshot.split_at(self.base_state.len());
        self.base_state.copy_from_slice(base);
        // A snapshot of the same plant always fits; another plant's is a mistake of the caller.
        let fits = if let [shift, current_a, earlier_velocity, scene @ ..] = rest {
            self.shift = *shift;
            self.motor.restore([*current_a, *earlier_velocity]);
            self.scene.restore(scene).is_ok()
        } else {
            false
        };
        debug_assert!(fits, "snapshot of another plant");
    }

    fn includes_other_forces(&self) -> bool {
        true
    }

    fn carries_weight(&self) -> bool {
        true
    }

    fn slider_loads(&mut self) -> Option<[f64; 4]> {
        let loads = self.supports.as_ref()?.distribute(&self.scene.reaction());
        let vertical: Vec<f64> = loads.iter().map(|load| load.vertical_n).collect();
        vertical.try_into().ok()
    }
}
