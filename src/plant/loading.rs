//! Loads of the bearing sliders as a linear function of the forces along the joint.

use super::rapier::{Reaction, Supports};
use crate::machine::Machine;
use crate::solid::GRAVITY_M_PER_S2;
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
        let weight = Vector3::new(0.0, 0.0, machine.constants().moving_mass * GRAVITY_M_PER_S2);
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
