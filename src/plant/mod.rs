//! Plants: the moving part on its guide and base, with one contract for all of them.
//!
//! - [`axis`]: the reduced-order axis derived from the solid model; the plant that fits run on.
//! - [`rapier`]: the rigid-body scene built from URDF and meshes; the reference for replays.

pub mod axis;
mod loading;
pub mod rapier;

pub use loading::LoadModel;

use crate::guide::stick_slip::Coast;

/// A plant: forces in, position and velocity of the moving part relative to the base out.
///
/// Forces are positive along the joint's positive direction; each has its equal and opposite reaction on
/// the base. A step is made by [`coast`](Plant::coast), which looks ahead, then [`advance`](Plant::advance).
pub trait Plant {
    /// Length of one step in s.
    fn step_s(&self) -> f64;

    /// Position of the moving part relative to the base, in m or rad.
    fn position(&self) -> f64;

    /// Velocity of the moving part relative to the base, in m/s or rad/s.
    fn velocity(&self) -> f64;

    /// How the coming step would end under `force` (N or N·m, held over the step) without guide friction.
    fn coast(&mut self, force: f64) -> Coast;

    /// Makes the step that was looked at, under the motor's and the guide's force held over it.
    fn advance(&mut self, motor_force: f64, guide_force: f64);

    /// Puts the moving part at a position with a velocity, the base at rest.
    fn place(&mut self, position: f64, velocity: f64);

    /// Takes the moving part to a position with a velocity while the base goes on as it moves; a plant that cannot
    /// tell the two apart brings the base to rest.
    fn relocate(&mut self, position: f64, velocity: f64) {
        self.place(position, velocity);
    }

    /// Everything that moves, as numbers.
    fn snapshot(&self) -> Vec<f64>;

    /// Goes back to a snapshot of the same plant.
    fn restore(&mut self, snapshot: &[f64]);

    /// Vertical loads of the bearing sliders A–D in N after the last step, where the plant knows them.
    fn slider_loads(&self) -> Option<[f64; 4]> {
        None
    }
}
