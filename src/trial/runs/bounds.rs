//! What the runs of a machine may ask of its joint and of its drive.

use crate::drive::motor::Circuit;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::units::Motion;

/// Feeds of prismatic axes in m/s (4, 8 and 16 m/min), and their strokes in m.
const FEEDS_M_PER_S: [f64; 3] = [4.0 / 60.0, 8.0 / 60.0, 16.0 / 60.0];
const STROKES_M: (f64, f64) = (0.025, 0.055);
/// Feeds of revolute axes in rad/s, and their strokes in rad.
const FEEDS_RAD_PER_S: [f64; 3] = [2.5, 5.0, 10.0];
const STROKES_RAD: (f64, f64) = (1.0, 6.5);
/// Feeds lie within this share of the listed ones.
pub(super) const FEED_SPREAD: f64 = 0.12;
/// Positions use at most so much of the joint's travel on their side of zero.
const MOST_TRAVEL: f64 = 0.8;
/// Movements ask at most for this share of what a limit leaves beside the weight.
const MOST_DRIVE: f64 = 0.6;
/// A limit leaves at least this share beside the weight: nothing moves an axis that its drive cannot hold.
const LEAST_LEFT: f64 = 0.1;
/// A stroke at the slowest feed lasts at most so long, in s.
const LONGEST_STROKE_S: f64 = 2.0;

/// What the runs of a machine may ask of its joint and of its drive.
///
/// # Model
/// Speed v and acceleration a of the reference, both at their largest at once, stay below 60 % of what each limit leaves
/// beside the machine's weight W:
///
/// ```text
/// force     m·a + c·v              joint's effort
/// voltage   (m·a + c·v)/k + Ke·v   the lowest of controller's, amplifier's and current loop's limit, k force per volt
/// speed     v                      joint's velocity
/// ```
/// Where there are none, a is that of a ramp to v, the fastest feed. Positions lie between zero and 80 % of the joint's travel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Shortest and longest stroke in m or rad.
    pub strokes: (f64, f64),
    /// The side of zero with more room: +1 or −1.
    pub side: f64,
    /// Slow, middle and fast feed in m/s or rad/s, before their spread.
    pub feeds: [f64; 3],
    /// Largest speed in m/s or rad/s.
    pub speed: f64,
    /// Largest acceleration in m/s² or rad/s².
    pub acceleration: f64,
}

impl Bounds {
    /// The bounds of a machine.
    ///
    /// # Errors
    /// A joint without room on either side of zero.
    pub fn of(machine: &Machine) -> Result<Self> {
        let (feeds, strokes) = match machine.motion() {
            Motion::Prismatic => (FEEDS_M_PER_S, STROKES_M),
            Motion::Revolute => (FEEDS_RAD_PER_S, STROKES_RAD),
        };
        let description = machine.description();
        let ramp_s = description.reference.acceleration_time_s.max(description.sample_period_s);
        let fastest = feeds[2] * (1.0 + FEED_SPREAD);
        let slower = allowed(machine, fastest, fastest / ramp_s);
        let feeds = feeds.map(|feed| slower * feed);
        let (side, room) = room(machine)?;
        let longest = (MOST_TRAVEL * room).min(LONGEST_STROKE_S * feeds[0]);
        let shrink = (longest / strokes.1).min(1.0);
        Ok(Self {
            strokes: (shrink * strokes.0, shrink * strokes.1),
            side,
            feeds,
            speed: slower * fastest,
            acceleration: slower * fastest / ramp_s,
        })
    }

    /// The same with strokes that are so many times as long.
    #[must_use]
    pub(super) fn with_strokes(self, factor: f64) -> Self {
        Self { strokes: (factor * self.strokes.0, factor * self.strokes.1), ..self }
    }
}

/// The side of zero with more room, and the room.
fn room(machine: &Machine) -> Result<(f64, f64)> {
    let joint = &machine.solid().joint;
    let room = joint.upper.max(-joint.lower);
    if room.is_nan() || room <= 0.0 {
        return Err(Error::new(ErrorKind::OutOfRange)
            .file(&machine.solid().path)
            .key(joint.name.clone())
            .found(format!("positions from {} to {}", joint.lower, joint.upper))
            .expected("room for a stroke from position zero")
            .remedy("correct the joint's limits in the URDF"));
    }
    Ok((if joint.upper >= -joint.lower { 1.0 } else { -1.0 }, room))
}

/// The share of a speed and an acceleration that the machine may be asked for: at most one.
fn allowed(machine: &Machine, speed: f64, acceleration: f64) -> f64 {
    let (constants, joint) = (machine.constants(), &machine.solid().joint);
    let force = constants.moving_mass * acceleration + constants.viscous * speed;
    let weight = machine.weight().map_or(0.0, |weight| weight.largest());
    let back_emf_v = match constants.circuit {
        Circuit::Winding { back_emf, .. } => (back_emf * speed / constants.amplifier.gain()).abs(),
        Circuit::Direct { .. } => 0.0,
    };
    let per_volt = constants.force_per_volt().abs();
    let share = |limit: f64, held: f64, asked: f64| {
        MOST_DRIVE * (limit - held).max(LEAST_LEFT * limit) / asked.max(f64::MIN_POSITIVE)
    };
    [
        constants
            .effort_limit_v()
            .map(|limit_v| share(limit_v, weight / per_volt, force / per_volt + back_emf_v)),
        Some(share(joint.effort, weight, force)),
        Some(share(joint.velocity, 0.0, speed)),
    ]
    .into_iter()
    .flatten()
    .filter(|share| *share > 0.0)
    .fold(1.0, f64::min)
}
