//! Plants: motor winding, moving part, guide drag and base, with one contract for all of them.
//!
//! - [`axis`]: the reduced-order axis derived from the solid model; the plant that fits run on.
//! - [`rapier`]: the rigid-body scene built from URDF and meshes; the reference for replays.
//! - [`mujoco`]: the same URDF and meshes in MuJoCo, the independent check; built with the feature of that name.

pub mod axis;
mod drive;
mod loading;
pub mod mujoco;
pub mod rapier;
mod resonance;
mod winding;

pub use drive::Drive;
pub use loading::{Load, LoadFriction, LoadModel, Transmitted};
pub use resonance::Resonance;
pub use winding::WindingState;

use crate::guide::{Coast, StepForce};

/// A plant: voltage and guide forces in, current, position and velocity of the moving part relative to the base out.
///
/// Forces are positive along the joint's positive direction; each has its equal and opposite reaction on
/// the base. Weight along the joint is one of them: the base is counted from where it stands under the weight that it holds
/// through motor and guide at rest, so that an axis that holds its weight does not set the base ringing. A step is made by [`coast`](Plant::coast), which looks ahead, then [`advance`](Plant::advance).
pub trait Plant {
    /// Length of one step in s.
    fn step_s(&self) -> f64;

    /// Position of the moving part relative to the base, in m or rad.
    fn position(&self) -> f64;

    /// Velocity of the moving part relative to the base, in m/s or rad/s.
    fn velocity(&self) -> f64;

    /// Current of the motor's winding in A; zero for a motor without one.
    fn current(&self) -> f64;

    /// Sets the current of the motor's winding, in A.
    fn set_current(&mut self, current_a: f64);

    /// How the coming step would end, driven so, without friction and position forces of the guide. Changes nothing
    /// that [`position`](Plant::position), [`velocity`](Plant::velocity) and [`current`](Plant::current) show.
    fn coast(&mut self, drive: Drive) -> Coast;

    /// Makes the step that was last looked at: `motor` is what acts at the motor beside its force in proportion to current (ripple, saturation),
    /// `guide` what acts at the guide.
    fn advance(&mut self, motor: StepForce, guide: StepForce);

    /// Puts the moving part at a position with a velocity, base at rest, without current.
    fn place(&mut self, position: f64, velocity: f64);

    /// Takes the moving part to a position with a velocity while base and current go on; a plant that cannot
    /// tell part and base apart brings the base to rest.
    fn relocate(&mut self, position: f64, velocity: f64) {
        let current_a = self.current();
        self.place(position, velocity);
        self.set_current(current_a);
    }

    /// Everything that moves, as numbers.
    fn snapshot(&self) -> Vec<f64>;

    /// Goes back to a snapshot of the same plant.
    fn restore(&mut self, snapshot: &[f64]);

    /// Whether the plant has the moving part's weight in itself; to one that has not, the twin applies it as a force of the
    /// guide ([`Weight`](crate::solid::Weight)).
    fn carries_weight(&self) -> bool {
        false
    }

    /// Whether [`coast`](Plant::coast) takes the motor's force at the end of the step with the velocity as it goes on from the steps before, which includes what other forces do to it; else
    /// with that of an axis on which only the motor acts.
    fn includes_other_forces(&self) -> bool {
        false
    }

    /// Vertical loads of the bearing sliders A–D in N after the last step, where the plant knows them.
    fn slider_loads(&mut self) -> Option<[f64; 4]> {
        None
    }
}
