//! The rigid-body plant: the imported solid as two bodies and a joint in rapier3d (double precision).

mod engine;
pub mod loads;
mod rig;
pub mod scene;
mod snapshot;

pub use self::loads::{Reaction, SupportLoad, Supports};
pub use self::rig::Rig;
pub use self::scene::{STEP_S, Scene};
