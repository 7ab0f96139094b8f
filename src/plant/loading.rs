//! What friction may be in proportion to: loads of the bearing sliders, effort through the transmission.

use super::rapier::{Reaction, Supports};
use crate::machine::Machine;
use crate::solid::{GRAVITY_M_PER_S2, Weight};
use nalgebra::{Point3, Vector3};

/// Loads of the sliders A–D reduced from the rigid-body scene, for plants that have no scene.
///
/// # Model
/// The body does not turn, so the guide's reaction balances weight and the couples of motor force and friction about
/// the centre of mass; its distribution on the sliders is linear: `N = N_weight + k_m·F_motor + k_g·F_guide`.
///
/// # Validity
/// As [`Supports`]. Drag attacks where friction does; the payload sits in the centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadModel {
    at_rest: [f64; 4],
    per_motor_force: [f64; 4],
    per_guide_force: [f64; 4],
}

impl LoadModel {
    /// The model of a machine with four sliders; none for any other.
    pub fn of(machine: &Machine) -> Option<Self> {
        let (solid, description) = (machine.solid(), machine.description());
        let sliders: Vec<&str> = description.guide.sliders.iter().map(String::as_str).collect();
        if sliders.len() != 4 {
            return None;
        }
        let supports = Supports::new(solid, &sliders, Vector3::z()).ok()?;
        let centre = Point3::from(solid.moving.mass.centre_m);
        let along = solid.joint.axis.into_inner();
        let lines = description.motor.lines_of_action_m();
        let middle = |points: &[Point3<f64>]| {
            let sum = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
            Point3::from(sum / points.len().max(1) as f64)
        };
        let attack = if lines.is_empty() {
            centre
        } else {
            middle(&lines.iter().map(|p| Point3::from(*p)).collect::<Vec<_>>())
        };
        let loads = |force_n: Vector3<f64>, moment_n_m: Vector3<f64>| -> Option<[f64; 4]> {
            let each = supports.distribute(&Reaction { force_n, moment_n_m });
            each.iter().map(|load| load.vertical_n).collect::<Vec<_>>().try_into().ok()
        };
        // The reaction's moment is the opposite of what the force at `point` exerts about the centre.
        let couple = |point: Point3<f64>| loads(Vector3::zeros(), -(point - centre).cross(&along));
        let constants = machine.constants();
        let mass_kg = constants.moving_mass - constants.rotor_inertia;
        let weight = Vector3::new(0.0, 0.0, mass_kg * GRAVITY_M_PER_S2);
        let weight = solid.joint.origin.rotation.inverse_transform_vector(&weight);
        Some(Self {
            // Along the joint the guide carries nothing: motor and friction do.
            at_rest: loads(weight - along * along.dot(&weight), Vector3::zeros())?,
            per_motor_force: couple(attack)?,
            per_guide_force: couple(middle(supports.points()))?,
        })
    }

    /// Vertical loads in N under a motor and a guide force along the joint.
    pub fn loads(&self, [motor, guide]: [f64; 2]) -> [f64; 4] {
        std::array::from_fn(|k| {
            self.at_rest[k] + self.per_motor_force[k] * motor + self.per_guide_force[k] * guide
        })
    }
}

/// Dry friction in proportion to a load: μ·N, see
/// [`LoadDependentFriction`](crate::effect::LoadDependentFriction).
#[derive(Debug, Clone, PartialEq)]
pub struct LoadFriction {
    coefficient: f64,
    load: Load,
}

impl LoadFriction {
    /// That of a machine; none where it has no such friction.
    pub fn of(machine: &Machine) -> Option<Self> {
        let coefficient = machine.constants().friction.load_coefficient;
        let load = Load::of(machine).filter(|_| coefficient > 0.0)?;
        Some(Self { coefficient, load })
    }

    /// What it is in proportion to.
    pub fn load(&self) -> &Load {
        &self.load
    }

    /// Its level in N or N·m for motion in the positive and in the negative direction; the rest as in [`Load::signed`].
    #[inline]
    pub fn levels(&self, known: Option<[f64; 4]>, forces: [f64; 2], position: f64) -> [f64; 2] {
        let load = self.load.signed(known, forces, position);
        let level = self.coefficient * load.abs();
        match &self.load {
            Load::Sliders(_) => [level; 2],
            Load::Transmitted(transmitted) => {
                let [driving, driven_back] =
                    transmitted.losses(self.coefficient).map(|factor| factor * level);
                if load > 0.0 { [driving, driven_back] } else { [driven_back, driving] }
            }
        }
    }

    /// μ times a load that is [usual](Load::usual), in N or N·m.
    pub fn usual(&self) -> f64 {
        self.coefficient * self.load.usual()
    }
}

/// What friction in proportion to a load is in proportion to.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    /// The sum of the magnitudes of the sliders' loads; the model of them, where the plant does not know them.
    Sliders(LoadModel),
    /// The effort through the transmission.
    Transmitted(Transmitted),
}

/// The effort through a transmission, see [`Transmission`](crate::drive::transmission::Transmission).
#[derive(Debug, Clone, PartialEq)]
pub struct Transmitted {
    /// The rotor's share of the inertia at the joint.
    rotor_share: f64,
    weight: Option<Weight>,
    /// Inertial effort at an acceleration of 9.80665 m/s² (rad/s² of a revolute axis), N or N·m.
    inertial: f64,
}

impl Load {
    /// The sliders of a machine that has four of them, else its transmission, if any.
    pub fn of(machine: &Machine) -> Option<Self> {
        let constants = machine.constants();
        if let Some(model) = LoadModel::of(machine).filter(|_| constants.has_slider_loads) {
            return Some(Self::Sliders(model));
        }
        constants.has_transmission.then(|| {
            Self::Transmitted(Transmitted {
                rotor_share: constants.rotor_inertia / constants.moving_mass,
                weight: machine.weight(),
                inertial: GRAVITY_M_PER_S2 * constants.moving_mass,
            })
        })
    }

    /// The load in N or N·m at a position, under the motor's and the guide's force; `known` are the sliders' loads of a plant
    /// that has them. That of sliders is not negative, the effort through a transmission has the sign of the joint's direction.
    #[inline]
    pub fn signed(&self, known: Option<[f64; 4]>, forces: [f64; 2], position: f64) -> f64 {
        match self {
            Self::Sliders(model) => {
                known.unwrap_or_else(|| model.loads(forces)).iter().map(|load| load.abs()).sum()
            }
            Self::Transmitted(transmitted) => transmitted.effort(forces[0], position),
        }
    }

    /// A load that is usual for the machine, in N or N·m: that of the sliders at rest; the largest weight, or without weight the
    /// inertial effort at 9.80665 m/s² (rad/s²).
    pub fn usual(&self) -> f64 {
        match self {
            Self::Sliders(_) => self.signed(None, [0.0; 2], 0.0),
            Self::Transmitted(transmitted) => {
                transmitted.weight.as_ref().map_or(transmitted.inertial, Weight::largest)
            }
        }
    }
}

impl Transmitted {
    /// N per |F_t| while the motor drives and while it is driven back. N is the effort that comes in, F_t the effort without
    /// friction: friction slows the rotor too, and what its inertia takes is less by that.
    ///
    /// # Model
    /// With s = sgn(v), friction R, s_r = J·n²/(m + J·n²) and F_t without friction, the effort at the motor's side is
    /// `F_m = F_t + s_r·s·R`, that at the load's side `F_l = F_m − s·R`:
    /// ```text
    ///   driving,     s·F_t > 0:  R = μ·|F_m|  ⇒  R = μ·|F_t|/(1 − μ·s_r)
    ///   driven back, s·F_t < 0:  R = μ·|F_l|  ⇒  R = μ·|F_t|/(1 − μ·(1 − s_r))
    /// ```
    /// At rest a motor that exerts F lifts a load L from F·(1 − μ) > L on and is driven back from F < L·(1 − μ) on.
    #[inline]
    fn losses(&self, coefficient: f64) -> [f64; 2] {
        [self.rotor_share, 1.0 - self.rotor_share].map(|share| 1.0 / (1.0 - coefficient * share))
    }

    /// Effort through the transmission in N or N·m, friction left aside, while the motor exerts `motor` at a position.
    #[inline]
    pub fn effort(&self, motor: f64, position: f64) -> f64 {
        let weight = self.weight.as_ref().map_or(0.0, |weight| weight.effort(position));
        (1.0 - self.rotor_share) * motor - self.rotor_share * weight
    }
}
