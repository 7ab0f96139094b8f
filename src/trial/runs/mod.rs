//! The runs of a forged case, as users record them: acceptance strokes, one run, three runs, jogs, sines, multisines,
//! production. Never twice the same.
//!
//! # Sessions
//! A session is what one case records; [`Layout`] says how it is made up. A diagnosis that were tried on acceptance strokes
//! alone would be tuned to them.
//!
//! | layout | share | runs | roles |
//! |---|---|---|---|
//! | acceptance strokes | 40 % | 3 to 5 for training, with every feed among them, and 2 held out | stated |
//! | single run | 15 % | one: slow and fast strokes, jogs, in half of the cases a sine, standstills between | none: nobody states one |
//! | three runs | 15 % | strokes at three feeds, or three of jogs, or strokes, jogs and a sine | stated in half of the cases |
//! | jogs and sine | 10 % | 2 of jogs and 1 or 2 sines; held out one of each | stated |
//! | multisine and strokes | 10 % | 1 or 2 multisines and 2 or 3 of strokes; held out one of each | stated |
//! | production | 10 % | 8 to 14 pieces of one production, the last quarter held out | stated |
//!
//! # Ranges
//! Prismatic (revolute) axes, each range shrunk where joint or drive allow less, see [`Bounds`]:
//!
//! ```text
//! feeds          4, 8 and 16 m/min (2.5, 5 and 10 rad/s), each within 12 %
//! strokes        25 to 55 mm (1 to 6.5 rad), at most 2 s at the slowest feed; from zero to the side with more room
//! jogs           4 to 7 moves of 5 to 60 % of a stroke, in either direction, standstills of 0.15 to 0.35 s
//! sine           0.8 to 5 Hz, 3 to 12 periods, 30 to 100 % of half a stroke, about the middle of it
//! multisine      4 to 8 frequencies from 0.8 to 12 Hz, 2 to 3.5 s, amplitudes as 1/f, random phases, the peak as the sine's
//! production     2 or 3 part programs of 3 to 6 positions at a feed each, standstills of 0.25 to 0.8 s, mixed for 2 to 5 min
//! ```
//! Sine and multisine fade in and out: over a period, over a quarter of their length. Both stay within the speed and the
//! acceleration of strokes at the fastest feed.
//!
//! # Limits
//! - A session of tests lasts at most [`MOST_SESSION_S`], strokes are shortened until it does; one of production at most
//!   [`MOST_PRODUCTION_S`], of which a diagnosis works on the stretches that hold most of the motion.
//! - Runs begin and end at rest: simulating one begins at a standstill. Production is cut at standstills.
//! - A single run is recorded as it is: the diagnosis cuts it at standstills.

mod bounds;
mod movement;
mod roles;
mod session;

pub use bounds::Bounds;
pub use movement::{Line, Move, Movement};
pub use roles::shared_out;
pub use session::{Layout, MOST_PRODUCTION_S, MOST_SESSION_S, Session, draw};

use crate::machine::Machine;
use crate::recording::Role;
use crate::units::Motion;
use serde::{Deserialize, Serialize};

/// Standstill before the first movement of a run, in s.
const LEAD_S: f64 = 0.1;

/// One run of a case, in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialRun {
    /// Name of the run.
    pub name: String,
    /// Whether for training or held out, where the user stated it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// When it begins within the session, in s.
    pub begins_s: f64,
    /// Where the axis stands before it, in m or rad.
    pub from: f64,
    /// What the axis is told.
    pub movement: Movement,
}

impl TrialRun {
    /// The position reference in m or rad, sampled.
    pub fn reference(&self, machine: &Machine) -> Vec<f64> {
        let period_s = machine.description().sample_period_s;
        let lead = (LEAD_S / period_s).round() as usize;
        let ramp_s = machine.description().reference.acceleration_time_s;
        let moved = self.movement.samples(period_s, ramp_s);
        std::iter::repeat_n(0.0, lead).chain(moved).map(|x| self.from + x).collect()
    }

    /// What a recording keeps of it.
    pub fn metadata(&self, machine: &Machine) -> toml::Table {
        self.movement.metadata(machine.motion())
    }

    /// Position of the reference that is farthest from zero, in m or rad, signed.
    pub fn travel(&self, machine: &Machine) -> f64 {
        let farther = |most: f64, x: f64| if x.abs() > most.abs() { x } else { most };
        self.reference(machine).into_iter().fold(0.0, farther)
    }

    /// Largest speed of the reference, in m/s or rad/s.
    pub fn speed(&self, machine: &Machine) -> f64 {
        let rise = |pair: &[f64]| (pair[1] - pair[0]).abs();
        let most = self.reference(machine).windows(2).map(rise).fold(0.0, f64::max);
        most / machine.description().sample_period_s
    }

    /// From the first sample to one after the last, in s.
    pub fn length_s(&self, machine: &Machine) -> f64 {
        self.reference(machine).len() as f64 * machine.description().sample_period_s
    }
}

/// Unit suffix of lengths and of feeds in metadata, and by how much a feed in SI is multiplied for it.
fn suffixes(motion: Motion) -> (&'static str, &'static str, f64) {
    match motion {
        Motion::Prismatic => ("m", "m_per_min", 60.0),
        Motion::Revolute => ("rad", "rad_per_s", 1.0),
    }
}
