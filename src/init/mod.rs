//! From a log to a first machine file: what the log tells of the axis, with intervals, and what it cannot tell.
//!
//! An estimate a file: control law and velocity estimate, force balance, winding, grid and noise of the readings. What no log
//! tells comes as a [`Sheet`]. [`Draft`] puts the two together; each of its numbers is measured, assumed or missing.

mod balance;
mod delay;
mod draft;
mod folder;
mod grid;
mod item;
mod law;
mod motor;
mod names;
mod urdf;
mod velocity;
mod winding;

use std::path::PathBuf;

pub use balance::Balance;
pub use draft::Draft;
pub use folder::{Logs, check_place, write};
pub use item::{Item, Mark};
pub use law::{Form, FoundLaw, LawFound};
pub use names::Lack;
pub use winding::FoundWinding;

use crate::error::Result;
use crate::identify::excitation::Outcome;
use crate::identify::least_squares::Estimate;
use crate::recording::{Recording, Run, Signal};

/// What no log tells, in SI.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sheet {
    /// What the machine is called.
    pub name: Option<String>,
    /// A solid model, instead of one body.
    pub urdf: Option<PathBuf>,
    /// The driven joint of it.
    pub joint: Option<String>,
    /// Moving mass in kg, or inertia in kg·m².
    pub mass: Option<f64>,
    /// N/A or N·m/A.
    pub force_constant: Option<f64>,
    /// N/V or N·m/V, from the control effort.
    pub force_per_volt: Option<f64>,
    /// Ω.
    pub resistance: Option<f64>,
    /// H.
    pub inductance: Option<f64>,
    /// Limit of the effort in V.
    pub voltage_limit: Option<f64>,
    /// Ends of the travel in m or rad.
    pub stroke: Option<[f64; 2]>,
}

/// What a log tells.
#[derive(Debug, Clone)]
pub struct Findings {
    /// The law.
    pub law: LawFound,
    /// Force balances by channel, of those that are logged and excited.
    pub balances: Vec<Balance>,
    /// Effort to current.
    pub winding: Option<FoundWinding>,
    /// Logged thrust over another channel, in N or N·m per its unit.
    pub thrust_per: Option<(Signal, Estimate)>,
    /// Step of the positions.
    pub step: Option<f64>,
    /// σ of the positions, step and noise together.
    pub reading_noise: f64,
    /// σ of the current in A.
    pub current_noise: Option<f64>,
    /// Effort at which it stays.
    pub limit: Option<f64>,
    /// Lowest and highest position.
    pub range: [f64; 2],
    /// What was not looked for, and why.
    pub silent: Vec<String>,
}

/// Channels of which a force balance is made.
const DRIVERS: [Signal; 3] = [Signal::Current, Signal::ControlEffort, Signal::Thrust];

/// Looks through a recording; `limit_v` is the limit of the effort, where it is known.
///
/// # Errors
/// Uneven time stamps; a run without a position.
pub fn findings(recording: &Recording, limit_v: Option<f64>) -> Result<Findings> {
    let runs = recording.runs();
    for run in runs {
        run.require_even("estimating mass, friction and control law")?;
        run.require(Signal::Position)?;
    }
    let has = |signal: Signal| runs.iter().all(|run| run.signal(signal).is_some());
    let limit = grid::limit(runs);
    let mut silent = Vec::new();
    let mut balances = Vec::new();
    for driver in DRIVERS.into_iter().filter(|driver| has(*driver)) {
        match balance::balance(runs, driver) {
            Ok(Outcome::Identified(found)) => balances.push(found),
            Ok(Outcome::NotExcited(why)) => silent.push(format!(
                "no force balance from {}: the runs do not tell its terms apart (condition {:.0e}); {}",
                driver.key(recording.motion()),
                why.condition,
                why.remedy
            )),
            Err(error) => {
                silent.push(format!("no force balance from {}: {error}", driver.key(recording.motion())));
            }
        }
    }
    let law = match has(Signal::ControlEffort) {
        true => law::law(runs, limit_v.or(limit))?,
        false => LawFound::None("the control effort is not logged".to_owned()),
    };
    let positions = || runs.iter().filter_map(|run| run.signal(Signal::Position)).flatten();
    Ok(Findings {
        law,
        balances,
        winding: if has(Signal::Current) { winding::winding(runs) } else { None },
        thrust_per: thrust_per(runs, &has),
        step: grid::step(runs),
        reading_noise: grid::reading_noise(runs),
        current_noise: has(Signal::Current).then(|| grid::scatter(runs, Signal::Current)),
        limit,
        range: positions()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]),
        silent,
    })
}

/// Logged thrust over current, else over effort, by least squares through zero.
fn thrust_per(runs: &[Run], has: &dyn Fn(Signal) -> bool) -> Option<(Signal, Estimate)> {
    let over = [Signal::Current, Signal::ControlEffort].into_iter().find(|signal| has(*signal))?;
    if !has(Signal::Thrust) {
        return None;
    }
    let pairs = || {
        runs.iter()
            .filter_map(|run| Some(run.signal(over)?.iter().zip(run.signal(Signal::Thrust)?)))
            .flatten()
    };
    let power: f64 = pairs().map(|(x, _)| x * x).sum();
    let value = pairs().map(|(x, y)| x * y).sum::<f64>() / power;
    let left: f64 = pairs().map(|(x, y)| (y - value * x).powi(2)).sum();
    let all: f64 = pairs().map(|(_, y)| y * y).sum();
    let standard_error = (left / pairs().count().max(2) as f64 / power).sqrt();
    /// A thrust that is not the channel times a number leaves more.
    const MOST_LEFT: f64 = 0.02;
    let is_told = power > 0.0 && value.is_finite() && value > 0.0 && left < MOST_LEFT * all;
    is_told.then(|| (over, Estimate::of_many(value, standard_error)))
}

impl Findings {
    /// The balance of a channel.
    pub fn balance(&self, driver: Signal) -> Option<&Balance> {
        self.balances.iter().find(|balance| balance.driver == driver)
    }
}
