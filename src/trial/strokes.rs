//! The strokes of a forged case: like those of an acceptance test, never twice the same.

use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::recording::{Role, one_after_another};
use crate::replay::{Motion, Stroke};
use crate::units;
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};

/// One run of a case, in SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Strokes {
    /// Name of the run.
    pub name: String,
    /// Distance there and back in m or rad.
    pub stroke: f64,
    /// Feed in m/s or rad/s.
    pub feed: f64,
    /// Standstill after each stroke in s.
    pub dwell_s: f64,
    /// Whether for training or held out.
    pub role: Role,
    /// When it begins within the session, in s.
    #[serde(default)]
    pub begins_s: f64,
}

/// Standstill before the first stroke, in s.
const LEAD_S: f64 = 0.1;
/// Feeds of prismatic axes in m/s (4, 8 and 16 m/min), and their strokes in m.
const FEEDS_M_PER_S: [f64; 3] = [4.0 / 60.0, 8.0 / 60.0, 16.0 / 60.0];
const STROKES_M: (f64, f64) = (0.025, 0.055);
/// Feeds of revolute axes in rad/s, and their strokes in rad.
const FEEDS_RAD_PER_S: [f64; 3] = [2.5, 5.0, 10.0];
const STROKES_RAD: (f64, f64) = (1.0, 6.5);
/// Feeds lie within this share of the listed ones.
const FEED_SPREAD: f64 = 0.12;
/// Strokes use at most so much of the joint's travel on their side of zero.
const MOST_TRAVEL: f64 = 0.8;
/// What a stroke asks of the drive stays below this share of its voltage limit.
const MOST_VOLTAGE: f64 = 0.6;

impl Strokes {
    /// The motion: there and back.
    pub fn motion(&self, machine: &Machine) -> Motion {
        let there = Stroke { stroke: self.stroke, feed: self.feed };
        let back = Stroke { stroke: -self.stroke, ..there };
        let ramp_s = machine.description().reference.acceleration_time_s;
        Motion { strokes: vec![there, back], lead_s: LEAD_S, dwell_s: self.dwell_s, ramp_s }
    }

    /// The position reference, sampled.
    pub fn reference(&self, machine: &Machine) -> Vec<f64> {
        self.motion(machine).reference(machine.description().sample_period_s)
    }

    /// What a recording keeps of it.
    pub fn metadata(&self, machine: &Machine) -> toml::Table {
        let (stroke, feed) = match machine.motion() {
            units::Motion::Prismatic => (("stroke_m", self.stroke), ("feed_m_per_min", 60.0 * self.feed)),
            units::Motion::Revolute => (("stroke_rad", self.stroke), ("feed_rad_per_s", self.feed)),
        };
        [stroke, feed].into_iter().map(|(key, value)| (key.to_owned(), value.into())).collect()
    }
}

/// Draws the runs of a case: three to five for training, with every feed among them, two held out, one of which may
/// use a feed and stroke between those of training.
///
/// # Errors
/// An axis that cannot move far enough for a stroke.
pub fn draw(machine: &Machine, random: &mut StdRng) -> Result<Vec<Strokes>> {
    let joint = &machine.solid().joint;
    let (feeds, strokes) = match machine.motion() {
        units::Motion::Prismatic => (FEEDS_M_PER_S, STROKES_M),
        units::Motion::Revolute => (FEEDS_RAD_PER_S, STROKES_RAD),
    };
    let room = joint.upper.max(-joint.lower);
    let side = if joint.upper >= -joint.lower { 1.0 } else { -1.0 };
    let shrink = (MOST_TRAVEL * room / strokes.1).min(1.0);
    if room.is_nan() || room <= 0.0 {
        return Err(Error::new(ErrorKind::OutOfRange)
            .file(&machine.solid().path)
            .key(joint.name.clone())
            .found(format!("positions from {} to {}", joint.lower, joint.upper))
            .expected("room for a stroke from position zero")
            .remedy("correct the joint's limits in the URDF"));
    }
    let slower = voltage_share(machine, feeds[2]);
    let training = random.random_range(3..=5);
    let mut runs = Vec::new();
    for k in 0..training + 2 {
        let held_out = k >= training;
        let feed = match (held_out, k) {
            (false, 0..3) => feeds[k],
            (true, _) if k == training => feeds[2],
            _ => feeds[random.random_range(0..3)],
        };
        let spread = random.random_range(1.0 - FEED_SPREAD..1.0 + FEED_SPREAD);
        let stroke = shrink * random.random_range(strokes.0..strokes.1);
        runs.push(Strokes {
            name: format!("run{:02}", k + 1),
            stroke: side * rounded(stroke),
            feed: rounded(feed * spread * slower),
            dwell_s: (100.0 * random.random_range(0.22..0.38_f64)).round() / 100.0,
            role: if held_out { Role::HeldOut } else { Role::Training },
            begins_s: 0.0,
        });
    }
    let period_s = machine.description().sample_period_s;
    let length_s = |run: &Strokes| run.reference(machine).len() as f64 * period_s;
    let lengths_s: Vec<f64> = runs.iter().map(length_s).collect();
    runs.iter_mut().zip(one_after_another(lengths_s)).for_each(|(run, begins_s)| run.begins_s = begins_s);
    Ok(runs)
}

/// Four digits: a stroke that an operator could have typed.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// The largest feed that the drive of a machine can accelerate to in its acceleration time, in m/s or rad/s; 16 m/min or 10 rad/s where it
/// has force to spare.
pub fn largest_feed(machine: &Machine) -> f64 {
    let feed = match machine.motion() {
        units::Motion::Prismatic => FEEDS_M_PER_S[2],
        units::Motion::Revolute => FEEDS_RAD_PER_S[2],
    };
    feed * voltage_share(machine, feed)
}

/// By how much feeds must be lower for accelerating to stay below the amplifier's limit.
fn voltage_share(machine: &Machine, feed: f64) -> f64 {
    let constants = machine.constants();
    let ramp_s = machine.description().reference.acceleration_time_s.max(constants.sample_period_s);
    let needed_v =
        (constants.moving_mass * feed / ramp_s + constants.viscous * feed) / constants.force_per_volt();
    let limit_v = constants.effort_limit_v().unwrap_or(f64::INFINITY);
    (MOST_VOLTAGE * limit_v / needed_v).min(1.0)
}
