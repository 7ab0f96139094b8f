//! The whole plant in MuJoCo: moving part, guide drag, base modes and slider loads, with the motor beside it.

use nalgebra::Vector3;

use super::attack::Attack;
use super::engine::{Efforts, Engine};
use super::linear::Linear;
use super::state::{RiseResponse, State};
use super::{Imported, Integrator, LONGEST_STEP_S, Resonance, scene};
use crate::effect::Constants;
use crate::error::{Error, ErrorKind, Result};
use crate::guide::{Coast, Response, StepForce};
use crate::machine::Machine;
use crate::plant::rapier::{Reaction, Supports};
use crate::plant::{Drive, Plant, WindingState};

/// The machine's moving part and its base as bodies in MuJoCo.
///
/// # Model
/// MuJoCo integrates the driven joint q, the base's modes η_j and the guide's drag as one system:
/// ```text
///   m·q̈   = F_motor + F_guide + W − c·ẋ      x = q − Σ η_j
///   M_j·(η̈_j + 2ζ_j·ω_j·η̇_j + ω_j²·η_j) = −F_motor − F_guide − W + c·ẋ
/// ```
/// W is weight along the joint; MuJoCo has it of the moving body, and the modes, which are counted from where they stand under
/// it, get its opposite. The motor's force attacks at its lines of action, the guide's at the middle of the sliders; what follows across the
/// joint is the [`reaction`](Self::reaction). The winding lies beside the engine ([`WindingState`]).
///
/// The engine holds forces over a step. What a force that rises within it does beside is added to the state after the step:
/// `−h²/12·M⁻¹g·rise` to the coordinates and `+h²/12·M⁻¹·D·M⁻¹g·rise` to the speeds.
///
/// # Validity
/// [`Integrator::RungeKutta`] is of fourth order: a mode of 160 Hz comes out to 1e-6 of its frequency with steps of
/// 62.5 µs. [`Integrator::Euler`] is semi-implicit: its coordinates lead by half a step, and `h·ẋ/2` is taken off the
/// position; its modes are off by some 1e-4. The joint has no end stops: limits of travel are the caller's to keep. A
/// voltage or force that is not finite makes position and velocity NaN until the axis is placed again.
///
/// # Source
/// Todorov, Erez, Tassa (2012), *MuJoCo: A physics engine for model-based control*.
pub struct MujocoRig {
    engine: Engine,
    integrator: Integrator,
    step_s: f64,
    state: State,
    /// Where the last step began.
    earlier: State,
    /// The end of the step that was looked at, driven by the motor alone.
    ahead: State,
    motor: WindingState,
    motor_force: StepForce,
    /// What acted in the last step.
    held: Efforts,
    by_rise: RiseResponse,
    response: Response,
    supports: Option<Supports>,
    imported: Imported,
    linear: Linear,
}

impl MujocoRig {
    /// The machine's plant by Runge and Kutta, with the longest step that divides its sample period and is at most
    /// [`LONGEST_STEP_S`].
    ///
    /// # Errors
    /// See [`MujocoRig::with_step`].
    pub fn new(machine: &Machine) -> Result<Self> {
        let period = machine.constants().sample_period_s;
        let steps = (period / LONGEST_STEP_S - 1e-9).ceil().max(1.0);
        Self::with_step(machine, period / steps, Integrator::RungeKutta)
    }

    /// The machine's plant with a step of its own, which must divide the sample period.
    ///
    /// # Errors
    /// A step that is not positive; a URDF or mesh that MuJoCo does not take (text STL, a body whose moments no body can
    /// have, a mesh that is gone); a library of another version; sliders that hold no body.
    pub fn with_step(machine: &Machine, step_s: f64, integrator: Integrator) -> Result<Self> {
        Self::with_constants(machine, &machine.constants(), step_s, integrator)
    }

    /// The same with constants of the caller's own, of which drag, modes, moving mass and motor matter here.
    ///
    /// # Errors
    /// See [`MujocoRig::with_step`].
    pub fn with_constants(
        machine: &Machine,
        constants: &Constants,
        step_s: f64,
        integrator: Integrator,
    ) -> Result<Self> {
        if !(step_s.is_finite() && step_s > 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key("step_s")
                .found(format!("{step_s}"))
                .expected("a positive step in s")
                .remedy("use 62.5e-6, a quarter of a control period of 250 µs"));
        }
        if let Some(key) = machine.lever_key() {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(machine.file())
                .key(key)
                .found("a payload at a lever")
                .expected("in MuJoCo, only bodies of the URDF off the axis")
                .remedy(
                    "put the mass into the URDF as a link on a fixed joint, or take --plant rapier or axis",
                ));
        }
        let solid = machine.solid();
        let sliders: Vec<&str> = machine.description().guide.sliders.iter().map(String::as_str).collect();
        let supports = match sliders.len() {
            4 => Some(Supports::new(solid, &sliders, Vector3::z())?),
            _ => None,
        };
        let points = supports.as_ref().map_or(&[][..], Supports::points);
        let (model, imported) = scene::build(solid, constants, step_s, integrator)?;
        let mut engine = Engine::new(solid, constants, model, Attack::of(machine, points), integrator)?;
        let linear = Linear::of(&mut engine);
        let state = engine.zero();
        let by_rise = linear.rise_response(step_s);
        Ok(Self {
            integrator,
            step_s,
            ahead: state.clone(),
            earlier: state.clone(),
            state,
            motor: WindingState::new(&constants.circuit, step_s),
            motor_force: StepForce::ZERO,
            held: Efforts::default(),
            response: engine.response(&by_rise),
            by_rise,
            supports,
            imported,
            linear,
            engine,
        })
    }

    /// How the steps are integrated.
    pub fn integrator(&self) -> Integrator {
        self.integrator
    }

    /// What MuJoCo's importer made of URDF and meshes, without payload.
    pub fn imported(&self) -> &Imported {
        &self.imported
    }

    /// What an effort along the joint accelerates by MuJoCo's mass matrix, payload included: kg, or kg·m² about the axis.
    pub fn moving_inertia(&self) -> f64 {
        self.linear.inertia(self.engine.table())
    }

    /// Frequencies and damping ratios of moving part, drag and base together, from MuJoCo's own matrices.
    pub fn resonances(&self) -> Vec<Resonance> {
        self.linear.resonances()
    }

    /// Displacement of the base at the reaction point, in m or rad.
    pub fn base_displacement(&self) -> f64 {
        self.engine.base_displacement(&self.state)
    }

    /// What the base exerts on the moving body through the joint, mean over the last step; after
    /// [`place`](Plant::place), what it exerts without any force of motor and guide.
    ///
    /// # Model
    /// MuJoCo's interaction force half-way between the states at the beginning and at the end of the step, under the motor's
    /// and the guide's mean force of that step: weight, inertia, the couples of both forces, and that of the drag. Drag acts
    /// at the friction point, so its couple is in it and its force along the joint is not.
    pub fn reaction(&mut self) -> Reaction {
        let middle = self.earlier.middle(&self.state);
        self.engine.reaction(&middle, self.held)
    }
}

impl Plant for MujocoRig {
    fn step_s(&self) -> f64 {
        self.step_s
    }

    fn position(&self) -> f64 {
        self.engine.position(&self.state)
    }

    fn velocity(&self) -> f64 {
        self.engine.velocity(&self.state)
    }

    fn current(&self) -> f64 {
        self.motor.current()
    }

    fn set_current(&mut self, current_a: f64) {
        self.motor.set_current(current_a);
    }

    fn coast(&mut self, drive: Drive) -> Coast {
        let velocity = self.velocity();
        let (force, ends) = self.motor.look_ahead(drive, velocity);
        self.motor_force = force;
        self.engine.step(&self.state, Efforts { motor: force.mean, guide: 0.0 }, &mut self.ahead);
        self.engine.add_rise(&mut self.ahead, &self.by_rise, force.rise);
        Coast {
            velocity,
            free_velocity: self.engine.velocity(&self.ahead),
            free_travel: self.engine.position(&self.ahead) - self.position(),
            motor_force: ends,
            response: self.response,
        }
    }

    fn advance(&mut self, motor: StepForce, guide: StepForce) {
        self.held = Efforts { motor: self.motor_force.mean + motor.mean, guide: guide.mean };
        let rise = motor.rise + guide.rise;
        if motor.mean == 0.0 && guide.mean == 0.0 {
            self.engine.add_rise(&mut self.ahead, &self.by_rise, rise);
        } else {
            self.engine.step(&self.state, self.held, &mut self.ahead);
            self.engine.add_rise(&mut self.ahead, &self.by_rise, self.motor_force.rise + rise);
        }
        std::mem::swap(&mut self.earlier, &mut self.state);
        std::mem::swap(&mut self.state, &mut self.ahead);
        self.motor.advance();
    }

    fn place(&mut self, position: f64, velocity: f64) {
        let table = self.engine.table();
        self.state.q.fill(0.0);
        self.state.v.fill(0.0);
        self.state.q[table] = position + self.engine.lead_s() * velocity;
        self.state.v[table] = velocity;
        self.earlier.clone_from(&self.state);
        self.held = Efforts::default();
        self.motor.place(velocity);
    }

    fn relocate(&mut self, position: f64, velocity: f64) {
        let (table, current_a) = (self.engine.table(), self.current());
        let by = [position - self.position(), velocity - self.velocity()];
        if !by.iter().all(|change| change.is_finite()) {
            self.place(position, velocity);
        } else {
            self.state.q[table] += by[0] + self.engine.lead_s() * by[1];
            self.state.v[table] += by[1];
            self.earlier.clone_from(&self.state);
            self.motor.place(velocity);
        }
        self.set_current(current_a);
    }

    fn snapshot(&self) -> Vec<f64> {
        let mut all = vec![self.held.motor, self.held.guide];
        all.extend(self.motor.snapshot());
        for State { q, v } in [&self.earlier, &self.state] {
            all.extend(q);
            all.extend(v);
        }
        all
    }

    fn restore(&mut self, snapshot: &[f64]) {
        let size = self.state.q.len();
        // A snapshot of the same plant always fits; another plant's is a mistake of the caller.
        let fits = snapshot.len() == 4 + 4 * size;
        debug_assert!(fits, "snapshot of another plant");
        if let Some((&[motor, guide, current_a, earlier_velocity], states)) = snapshot.split_first_chunk()
            && fits
        {
            self.held = Efforts { motor, guide };
            self.motor.restore([current_a, earlier_velocity]);
            let mut numbers = states.chunks_exact(size);
            for state in [&mut self.earlier, &mut self.state] {
                for values in [&mut state.q, &mut state.v] {
                    values.copy_from_slice(numbers.next().unwrap_or_default());
                }
            }
        }
    }

    fn includes_other_forces(&self) -> bool {
        true
    }

    fn carries_weight(&self) -> bool {
        true
    }

    fn slider_loads(&mut self) -> Option<[f64; 4]> {
        self.supports.as_ref()?;
        let reaction = self.reaction();
        let loads = self.supports.as_ref()?.distribute(&reaction);
        let vertical: Vec<f64> = loads.iter().map(|load| load.vertical_n).collect();
        vertical.try_into().ok()
    }
}
