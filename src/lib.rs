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
//!  recording ──► identify      models from data alone: ARX, frequency response
//!  recording ──► init          a first machine file: what the log tells, what it cannot tell
//!  recording ──► diagnose ──►  report        twin and recording compared: where, why, how much
//!  machine ──► tune            gains of the controller swept, optimised and re-checked
//!  machine ──► trial           the diagnosis checked on machines whose effect is withheld
//! ```
//!
//! Modules import in one direction: [`error`], [`confine`], [`whole`], [`units`], [`elementary`], [`recording`], [`identify`], [`solid`],
//! [`controller`], [`drive`], [`sensor`], [`base`], [`guide`], [`effect`], [`machine`], [`init`], [`plant`], [`twin`],
//! [`replay`], [`tune`], [`diagnose`], [`trial`], [`report`], then the command line, which belongs to the binary.
//!
//! # Where something new goes
//! **A new effect** (a law that a real machine follows and a twin may leave out) is one file in [`effect`]
//! that implements [`effect::Law`], one line in that module's catalogue, and one [`diagnose::estimate::Estimate`]:
//! where a fit begins. The compiler demands all three. Machine files, fits, diagnosis and reports pick it up; its
//! parameters are key paths such as `effect.coulomb_friction.force_n`.
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

pub mod base;
pub mod confine;
pub mod controller;
pub mod diagnose;
pub mod drive;
pub mod effect;
pub mod elementary;
pub mod error;
pub mod guide;
pub mod identify;
pub mod init;
pub mod machine;
pub mod plant;
pub mod recording;
pub mod replay;
pub mod report;
pub mod sensor;
mod singular;
pub mod solid;
pub mod trial;
pub mod tune;
pub mod twin;
pub mod units;
pub mod whole;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeDoctests;
