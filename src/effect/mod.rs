//! The catalogue of effects: what a real machine does that its twin may leave out.
//!
//! Each effect is one law in one file, attached to one [`Site`] of the signal path. To add one, write the
//! file and add its line to the `catalogue!` below: machine files, fits, diagnosis and reports pick it up.
//! An effect in a machine file is a table under its id, for instance
//!
//! ```toml
//! [effect.coulomb_friction]
//! force_n = 15.0
//! ```
//!
//! # Design
//! The catalogue is a closed enum: it can be listed, written to a file and matched exhaustively. A machine
//! holds each effect at most once, so the order in which effects are written or found never matters.

pub mod asymmetric_friction;
mod catalogue;
pub mod constant_force;
pub mod constants;
pub mod coulomb_friction;
pub mod law;
pub mod loop_delay;
pub mod payload;
pub mod screening;
pub mod viscous_friction;

pub use asymmetric_friction::AsymmetricFriction;
pub use constant_force::ConstantForce;
pub use constants::Constants;
pub use coulomb_friction::CoulombFriction;
pub use law::{Law, Parameter, Site};
pub use loop_delay::LoopDelay;
pub use payload::Payload;
pub use screening::Screen;
pub use viscous_friction::ViscousFriction;

catalogue::catalogue! {
    loop_delay: LoopDelay,
    viscous_friction: ViscousFriction,
    coulomb_friction: CoulombFriction,
    asymmetric_friction: AsymmetricFriction,
    constant_force: ConstantForce,
    payload: Payload,
}
