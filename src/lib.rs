//! A multibody twin of a servo-driven machine axis that says why the real machine disagrees with it.
//!
//! Slideway imports the solid model of an axis (URDF and meshes), replays strokes through controller, drive
//! and structure, and compares with a recording of the real machine: where the gap lies on the signal path,
//! which effect causes it, how far it shrinks once the twin has that effect.
//!
//! # The signal path
//! The modules are the blocks of a servo axis, at their places:
//!
//! ```text
//!   stroke
//!     │ replay
//!     ▼
//! ┌────────────┐ effort  ┌───────────┐ voltage ┌─────────┐ force  ┌───────┐       ┌────────────────┐
//! │ controller ├────────►│   drive   ├────────►│  drive  ├───────►│ guide ├──────►│     plant      │
//! │ PDF,       │   V     │ amplifier │    V    │  motor  │   N    │ drag, │       │ solid: moving  │
//! │ cascade    │         └───────────┘         └─────────┘        │ stick │       │ base:  modes   │
//! └────────────┘                                                  └───────┘       └───────┬────────┘
//!     ▲                                                                                   │ motion
//!     │   position, velocity estimate    ┌────────┐                                       │
//!     └──────────────────────────────────┤ sensor │◄──────────────────────────────────────┘
//!                                        └────────┘
//!  effect: laws attached to one of these sites     machine: the file that states all of them
//!  twin: one period of this walk                   replay: the walk for a whole run
//!
//!  recording ──► identify      models from data alone: ARX, frequency response, gain regression
//!  recording ──► diagnose ──►  report        twin and recording compared: where, why, how much
//! ```
//!
//! Modules import in one direction: [`error`], [`units`], [`recording`], [`identify`], [`solid`],
//! [`controller`], [`drive`], [`sensor`], [`base`], [`guide`], [`effect`], [`machine`], [`plant`], [`twin`],
//! [`replay`], then diagnosis, trials, reports and the command line.
//!
//! # Where something new goes
//! **A new effect** (a law that a real machine follows and a twin may leave out) is one file in [`effect`]
//! that implements [`effect::Law`], and one line in that module's catalogue. Machine files, fits, diagnosis and
//! reports pick it up; its parameters are key paths such as `effect.coulomb_friction.force_n`.
//!
//! **A new controller** is one file in [`controller`] and one variant of [`controller::Controller`]. The struct
//! is its own configuration, read from `[controller]` in the machine file; what it remembers between samples
//! lives in [`controller::Memory`].
//!
//! **A new machine** is a new folder below `models` with `machine.toml`, the URDF and meshes it names, and a
//! README that gives the source of every number. Nothing in this crate knows a machine by name.
//!
//! # Conventions
//! - SI inside, always. Serialised fields carry their unit (`resistance_ohm`), and one name serves as struct
//!   field, TOML key, fit parameter and report row. Data are converted once, when they are read.
//! - A machine may be prismatic or revolute: position in m or rad, effort in N or N·m.
//! - Positive voltage, current, force and velocity all point along the joint's positive direction, and each
//!   force on the moving part has its equal and opposite reaction on the base. Position is that of the moving
//!   part relative to the base. A constant force is stated as the load that the motor has to hold.
//! - A replay runs free: it gets the reference and nothing measured after the start, and closes the loop
//!   through the twin's own sensor, so that errors add up as they would on the machine.
//!
//! # Example
//! A stroke from rest to rest: whatever the controller does, the impulse of the motor is what viscous drag
//! takes on the way, c·stroke.
//!
//! ```
//! use slideway::machine::Machine;
//! use slideway::plant::axis::Axis;
//! use slideway::replay::{Motion, Stroke, follow, run};
//! use slideway::twin::{Sensing, Twin};
//! use std::path::Path;
//!
//! let machine = Machine::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder"))?;
//! let constants = machine.constants();
//! let stroke = Stroke::metres_at_metres_per_minute(0.02, 8.0)?;
//! let motion = Motion { strokes: vec![stroke], lead_s: 0.0, dwell_s: 1.0, ramp_s: 0.02 };
//! let reference = motion.reference(constants.sample_period_s);
//!
//! let mut twin = Twin::new(&machine, Axis::of(&constants), Sensing::Perfect);
//! let traces = run(&mut twin, follow(&reference, constants.sample_period_s), |_| ());
//!
//! let impulse: f64 = traces.thrust.iter().sum::<f64>() * constants.sample_period_s;
//! assert!((impulse / (constants.viscous * stroke.stroke) - 1.0).abs() < 1e-3);
//! # Ok::<(), slideway::error::Error>(())
//! ```
pub mod base;
pub mod controller;
pub mod diagnose;
pub mod drive;
pub mod effect;
pub mod error;
pub mod guide;
pub mod identify;
pub mod machine;
pub mod plant;
pub mod recording;
pub mod replay;
pub mod report;
pub mod sensor;
pub mod solid;
pub mod twin;
pub mod units;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
