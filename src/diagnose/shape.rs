//! What is left of the gap, and what it looks like: in time, frequency, position and speed, and what it follows.

use super::estimate::Screen;
use super::estimate::periodogram::{Moment, pitches};
use super::experiment::Experiment;
use super::json;
use super::locate::locate;
use super::motion;
use super::noise::Floor;
use super::place::{Band, Where};
use crate::error::Result;
use crate::machine::Machine;
use crate::units::{Motion, engineering};
use serde::{Deserialize, Serialize};

/// The shape of what no named effect explains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shape {
    /// Shares of the residual that is left, as for the gap itself.
    #[serde(rename = "where")]
    pub place: Where,
    /// Shares of the missing force's mean square that follow from acceleration, velocity, direction, position or a
    /// constant alone; empty where no signal tells the motor's effort.
    pub follows: Vec<Follows>,
    /// The pitch in m or rad at which the missing force repeats along the axis, with its share, if it does.
    pub repeats_every: Option<Repeats>,
    /// All of it in a sentence.
    pub sentence: String,
}

/// How much of the missing force one quantity accounts for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Follows {
    /// The quantity.
    pub quantity: String,
    /// Share of the mean square, 0 to 1.
    #[serde(deserialize_with = "json::number")]
    pub share: f64,
}

/// A pitch in the missing force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Pitch in m or rad.
    #[serde(deserialize_with = "json::number")]
    pub pitch: f64,
    /// Share of the mean square that repeats with it, 0 to 1.
    #[serde(deserialize_with = "json::number")]
    pub share: f64,
}

/// Below this share a pitch or a quantity is not worth a word.
const NOTABLE: f64 = 0.2;
/// A band that holds this many times its even share stands out.
const CONCENTRATED: f64 = 2.0;

/// Describes what `machine`, the twin with all that was found, leaves open on these runs, which are called `runs`.
///
/// # Errors
/// Whatever a replay refuses.
pub fn shape(machine: &Machine, experiments: &[Experiment], runs: &str, floor: &Floor) -> Result<Shape> {
    let place = locate([machine, machine], experiments, floor)?;
    let screen = motion::screen(experiments, machine)?;
    let follows = follows(&screen);
    let wave = |rate: f64, m: Moment| {
        let (s, c) = (rate * m.position).sin_cos();
        [s, c]
    };
    let found = pitches(&screen, &screen.missing_force, wave, 1);
    let best = found.into_iter().max_by(|a, b| a.share.total_cmp(&b.share));
    let repeats_every =
        best.filter(|p| p.share >= NOTABLE).map(|p| Repeats { pitch: p.period, share: p.share });
    let parts = parts(&place, &follows, repeats_every.as_ref(), machine.motion());
    let sentence = format!("What is left of the {runs} runs: {}.", parts.join("; "));
    Ok(Shape { place, follows, repeats_every, sentence })
}

fn follows(screen: &Screen) -> Vec<Follows> {
    let force = &screen.missing_force;
    let total: f64 = force.iter().map(|f| f * f).sum();
    if total <= 0.0 {
        return Vec::new();
    }
    let middle = screen.middle();
    let columns: [(&'static str, Vec<f64>); 5] = [
        ("acceleration", screen.acceleration.clone()),
        ("velocity", screen.velocity.clone()),
        ("direction", screen.directions()),
        ("position", screen.position.iter().map(|x| x - middle).collect()),
        ("constant", vec![1.0; force.len()]),
    ];
    let share = |column: &[f64]| {
        let product: f64 = column.iter().zip(force).map(|(c, f)| c * f).sum();
        let size: f64 = column.iter().map(|c| c * c).sum();
        if size > 0.0 { product * product / (size * total) } else { 0.0 }
    };
    let mut list: Vec<Follows> = columns
        .iter()
        .map(|(quantity, column)| Follows { quantity: (*quantity).to_owned(), share: share(column) })
        .collect();
    list.sort_by(|a, b| b.share.total_cmp(&a.share));
    list
}

fn parts(place: &Where, follows: &[Follows], repeats: Option<&Repeats>, motion: Motion) -> Vec<String> {
    let (length, speed) = match motion {
        Motion::Prismatic => ("m", "m/s"),
        Motion::Revolute => ("rad", "rad/s"),
    };
    let mut parts = Vec::new();
    if let Some(top) = place.phase.iter().max_by(|a, b| a.share.total_cmp(&b.share)) {
        parts.push(format!("{:.0} % of it in the phase \"{}\"", 100.0 * top.share, top.name));
    }
    let mut band = |bands: &[Band], unit: &str, what: &str| {
        let top = bands.iter().max_by(|a, b| a.share.total_cmp(&b.share));
        if let Some(top) = top.filter(|top| top.share * bands.len() as f64 >= CONCENTRATED) {
            let (from, to) = (engineering(top.from, unit), engineering(top.to, unit));
            parts.push(format!("{:.0} % {what} {from} to {to}", 100.0 * top.share));
        }
    };
    band(&place.frequency_hz, "Hz", "between");
    band(&place.position, length, "at positions from");
    band(&place.speed, speed, "at speeds from");
    if let Some(top) = follows.first().filter(|f| f.share >= NOTABLE) {
        let what = if top.quantity == "constant" { "a constant" } else { &top.quantity };
        parts.push(format!("{:.0} % of the missing force follows {what}", 100.0 * top.share));
    }
    if let Some(repeats) = repeats {
        let pitch = engineering(repeats.pitch, length);
        parts.push(format!("{:.0} % of the missing force repeats every {pitch}", 100.0 * repeats.share));
    }
    parts
}
