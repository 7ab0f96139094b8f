//! Where the forces of motor and guide attack the moving body.

use nalgebra::{Point3, Vector3};

use crate::machine::Machine;
use crate::units::Motion;

/// Force (N) and moment about the moving body's centre of mass (N·m) of a unit effort along the joint, as MuJoCo
/// takes them: along the axes of the world.
pub(super) type Wrench = [f64; 6];

/// The unit wrenches of a machine.
///
/// # Model
/// A motor's force divides into equal shares on its lines of action: together, the whole of it at their mean. Friction
/// and drag act at the middle of the sliders. Without lines or sliders it is the centre of mass; on a revolute axis all are
/// torques about the joint. The axis has a fixed direction in the world, and a prismatic joint does not turn the body, so
/// the wrenches are constant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Attack {
    pub motor: Wrench,
    pub guide: Wrench,
}

impl Attack {
    /// The wrenches of a machine whose sliders are at `sliders`.
    pub fn of(machine: &Machine, sliders: &[Point3<f64>]) -> Self {
        let solid = machine.solid();
        let centre = Point3::from(solid.moving.mass.centre_m);
        let axis = solid.joint.axis.into_inner();
        let world = solid.joint.origin.rotation;
        let wrench = |point: Point3<f64>| {
            let (force, moment) = match machine.motion() {
                Motion::Prismatic => (axis, (point - centre).cross(&axis)),
                Motion::Revolute => (Vector3::zeros(), axis),
            };
            let (force, moment) = (world * force, world * moment);
            [force.x, force.y, force.z, moment.x, moment.y, moment.z]
        };
        let lines: Vec<Point3<f64>> =
            machine.description().motor.lines_of_action_m().iter().map(|p| Point3::from(*p)).collect();
        Self {
            motor: wrench(middle(&lines).unwrap_or(centre)),
            guide: wrench(middle(sliders).unwrap_or(centre)),
        }
    }
}

fn middle(points: &[Point3<f64>]) -> Option<Point3<f64>> {
    let sum = points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords);
    (!points.is_empty()).then(|| Point3::from(sum / points.len() as f64))
}
