//! Units that cannot be right, found without knowing the machine.
//!
//! # Model
//! Over windows of a run the change of a position must equal the integral of its velocity, and a position must
//! follow its reference one to one. The least-squares slope of one on the other is compared with the factors
//! that forgotten units leave behind: 1000 (mm), 60 (per minute), 180/π (degrees), 2π (revolutions) and so on.
//!
//! # Validity
//! Says nothing unless the two go together closely (squared correlation of 0.95) over enough windows; a log of a
//! standstill or of noise passes. Quantities that are wrong by the same factor throughout pass too, unless
//! they are absurdly large.

use std::f64::consts::TAU;
use std::fmt;

use super::run::Run;
use super::signal::{Signal, TIME_KEY};
use crate::error::{Error, ErrorKind};
use crate::units::Motion;

/// A slope within this fraction of a unit factor is taken for it.
const SLOPE_TOLERANCE: f64 = 0.05;
/// Squared correlation from which two signals are taken to tell the same motion.
const CORRELATION: f64 = 0.95;
/// Windows into which a run is cut, and the fewest that count.
const WINDOWS: usize = 200;
const FEWEST_WINDOWS: usize = 20;
/// No sliding axis moves further, or faster, than this.
const LONGEST_TRAVEL_M: f64 = 100.0;
const FASTEST_M_PER_S: f64 = 100.0;
/// A million revolutions a minute.
const FASTEST_RAD_PER_S: f64 = 1e5;
/// A servo axis sampled more slowly than this shows none of its dynamics; 1 s is a clock in ms read as s.
const LONGEST_PERIOD_S: f64 = 0.2;

/// Something about the units of a run that cannot be right.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The canonical name of the signal in doubt (or `time_s`).
    pub key: &'static str,
    /// What was found.
    pub found: String,
    /// What would be right.
    pub expected: String,
    /// What to do about it.
    pub remedy: String,
    /// Whether two signals that tell the same motion differ by the factor of a unit; else a number is only beyond what axes do.
    pub is_unit_factor: bool,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.key, self.found)
    }
}

impl From<Finding> for Error {
    fn from(finding: Finding) -> Self {
        Self::new(ErrorKind::Unit)
            .key(finding.key)
            .found(finding.found)
            .expected(finding.expected)
            .remedy(finding.remedy)
    }
}

/// Everything implausible about the units of a run; empty when nothing is.
pub fn plausibility(run: &Run) -> Vec<Finding> {
    let mut findings: Vec<Finding> = [period(run), travel(run)].into_iter().flatten().collect();
    for (position, velocity) in
        [(Signal::Position, Signal::Velocity), (Signal::PositionReference, Signal::VelocityReference)]
    {
        findings.extend(derivative(run, position, velocity));
    }
    for (follower, leader) in [
        (Signal::Position, Signal::PositionReference),
        (Signal::Velocity, Signal::VelocityReference),
        (Signal::LoadPosition, Signal::Position),
    ] {
        findings.extend(following(run, follower, leader));
    }
    findings.extend(speed(run));
    findings
}

fn period(run: &Run) -> Option<Finding> {
    let period = run.sample_period_s();
    (period > LONGEST_PERIOD_S).then(|| Finding {
        key: TIME_KEY,
        found: format!("one sample every {period} s"),
        expected: format!("a period of {LONGEST_PERIOD_S} s at most"),
        remedy: "give the unit of the time column, unit = \"ms\" perhaps, or correct sample_period_s"
            .to_owned(),
        is_unit_factor: false,
    })
}

fn travel(run: &Run) -> Option<Finding> {
    if run.motion() == Motion::Revolute {
        return None;
    }
    let positions = [Signal::Position, Signal::LoadPosition, Signal::PositionReference];
    positions.into_iter().find_map(|signal| {
        let samples = run.signal(signal)?;
        let (low, high) = samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), sample| {
            (low.min(*sample), high.max(*sample))
        });
        let key = signal.key(run.motion());
        (high - low > LONGEST_TRAVEL_M).then(|| Finding {
            key,
            found: format!("a travel of {} m", three_digits(high - low)),
            expected: format!("{LONGEST_TRAVEL_M} m at most"),
            remedy: format!(
                "give the unit of the column, `{key} = {{ column = \"…\", unit = \"mm\" }}` perhaps"
            ),
            is_unit_factor: false,
        })
    })
}

fn speed(run: &Run) -> Option<Finding> {
    let (limit, example) = match run.motion() {
        Motion::Prismatic => (FASTEST_M_PER_S, "mm/s"),
        Motion::Revolute => (FASTEST_RAD_PER_S, "deg/s"),
    };
    [Signal::Velocity, Signal::VelocityReference].into_iter().find_map(|signal| {
        let fastest = run.signal(signal)?.iter().fold(0.0_f64, |fastest, sample| fastest.max(sample.abs()));
        let (key, unit) = (signal.key(run.motion()), signal.si_unit(run.motion()));
        (fastest > limit).then(|| Finding {
            key,
            found: format!("{} {unit}", three_digits(fastest)),
            expected: format!("{limit} {unit} at most"),
            remedy: format!(
                "give the unit of the column, `{key} = {{ column = \"…\", unit = \"{example}\" }}` perhaps"
            ),
            is_unit_factor: false,
        })
    })
}

/// Compares a velocity with the change of its position.
fn derivative(run: &Run, position: Signal, velocity: Signal) -> Option<Finding> {
    let (q, v) = (run.signal(position)?, run.signal(velocity)?);
    let period = run.sample_period_s();
    let width = (q.len() / WINDOWS).max(1);
    // Trapezoidal integral of the velocity, and the change of position, over windows of `width` samples.
    let windows: Vec<(f64, f64)> = (0..q.len().saturating_sub(1) / width)
        .map(|window| {
            let (from, to) = (window * width, (window + 1) * width);
            let inner: f64 = v[from..=to].iter().sum::<f64>() - (v[from] + v[to]) / 2.0;
            (q[to] - q[from], inner * period)
        })
        .collect();
    let slope = slope(&windows)?;
    unit_finding(run, slope, velocity, position, "the derivative of ")
}

/// Compares a signal with the one that it follows.
fn following(run: &Run, follower: Signal, leader: Signal) -> Option<Finding> {
    let (y, x) = (run.signal(follower)?, run.signal(leader)?);
    if y.len() < FEWEST_WINDOWS {
        return None;
    }
    let (mean_y, mean_x) = (mean(y), mean(x));
    let pairs: Vec<(f64, f64)> = x.iter().zip(y).map(|(x, y)| (x - mean_x, y - mean_y)).collect();
    let slope = slope(&pairs)?;
    unit_finding(run, slope, follower, leader, "")
}

fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

/// The slope of the second on the first, where they go together closely.
fn slope(pairs: &[(f64, f64)]) -> Option<f64> {
    let (xx, xy, yy) =
        pairs.iter().fold((0.0, 0.0, 0.0), |(xx, xy, yy), (x, y)| (xx + x * x, xy + x * y, yy + y * y));
    let excited = pairs.len() >= FEWEST_WINDOWS && xx > 0.0 && yy > 0.0;
    (excited && xy * xy >= CORRELATION * xx * yy).then(|| xy / xx)
}

/// A factor that a forgotten unit leaves, with that unit of a position and of a velocity (where it has one).
type UnitFactor = (f64, Option<&'static str>, &'static str);

const PRISMATIC: &[UnitFactor] = &[
    (1e3, Some("mm"), "mm/s"),
    (1e6, Some("µm"), "µm/s"),
    (1.0 / 0.0254, Some("in"), "in/s"),
    (60.0, None, "m/min"),
    (6e4, None, "mm/min"),
];
const REVOLUTE: &[UnitFactor] = &[
    (360.0 / TAU, Some("deg"), "deg/s"),
    (1.0 / TAU, Some("rev"), "rev/s"),
    (1e3, Some("mrad"), "mrad/s"),
    (60.0 / TAU, None, "rpm"),
];

/// The finding that `signal` is a unit factor times (`of`) `other`, or the other way round.
fn unit_finding(run: &Run, slope: f64, signal: Signal, other: Signal, of: &str) -> Option<Finding> {
    let motion = run.motion();
    let factors = match motion {
        Motion::Prismatic => PRISMATIC,
        Motion::Revolute => REVOLUTE,
    };
    let is_rate = |signal| matches!(signal, Signal::Velocity | Signal::VelocityReference);
    let near = |factor: f64| (slope.abs() / factor - 1.0).abs() < SLOPE_TOLERANCE;
    let (factor, suspect, innocent, (_, position_unit, rate_unit)) = factors
        .iter()
        .filter(|(_, position_unit, _)| position_unit.is_some() || is_rate(signal))
        .find_map(|row| match (near(row.0), near(1.0 / row.0)) {
            (true, _) => Some((row.0, signal, other, *row)),
            (_, true) => Some((1.0 / row.0, other, signal, *row)),
            _ => None,
        })?;
    let times =
        if factor >= 1.0 { three_digits(factor) } else { format!("1/{}", three_digits(1.0 / factor)) };
    let (key, other_key) = (signal.key(motion), other.key(motion));
    let (suspect_key, innocent_key) = (suspect.key(motion), innocent.key(motion));
    let unit = if is_rate(suspect) { Some(rate_unit) } else { position_unit };
    let remedy = match unit {
        Some(unit) => format!(
            "one of the two units in [columns] is wrong: give `{suspect_key}` unit = \"{unit}\", or correct the unit of `{innocent_key}`"
        ),
        None => format!("correct the unit given for `{innocent_key}` in [columns]"),
    };
    Some(Finding {
        key,
        found: format!("`{key}` about {times} × {of}`{other_key}`"),
        expected: "1 ×".to_owned(),
        remedy,
        is_unit_factor: true,
    })
}

fn three_digits(value: f64) -> String {
    if value.abs() >= 100.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}
