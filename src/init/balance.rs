//! What a channel that drives the axis spends on acceleration, drag and dry friction.

use nalgebra::{DMatrix, DVector};

use super::delay;
use super::grid::reading_noise;
use crate::error::Result;
use crate::identify::excitation::Outcome;
use crate::identify::least_squares::{Estimate, Regression};
use crate::recording::{Run, Signal};

/// Half widths of the averaging window that are tried, in samples.
const WIDTHS: [usize; 17] = [4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024];
/// Noise may make up this share of the variance of the acceleration at most: it would pull the mass down by as much.
const MOST_NOISE: f64 = 1e-4;
/// A window may be as wide as leaves this share of the variance that the narrowest one shows.
const LEAST_LEFT: f64 = 0.9;
/// Below this share of the highest speed the direction of dry friction is not sure.
const LEAST_SPEED: f64 = 0.03;
/// Rows in one half width of the window.
const ROWS_A_WIDTH: usize = 4;
/// Late by so many samples at most.
const MOST_DELAY: usize = 12;
const REMEDY: &str = "record strokes in both directions that accelerate, at two feeds at least";

/// A force balance in the unit of the channel that drives: V, A, N or N·m.
///
/// # Model
/// ```text
///   y(t − delay) = inertia·a + viscous·v + coulomb·sgn v + constant
/// ```
/// by least squares, every term averaged over the same triangle of half width w. Its average of the acceleration is exactly
/// `(x(t+w) − 2·x(t) + x(t−w))/w²`, so nothing is differentiated. Windows in which the axis is slow or turns back are left out.
/// Intervals as of [`Regression::with_correlated_residual`].
///
/// # Validity
/// Rigid below 1/w; friction that is not Coulomb and viscous enters the intervals, not the law.
#[derive(Debug, Clone, Copy)]
pub struct Balance {
    /// The channel.
    pub driver: Signal,
    /// Per m/s² or rad/s²: moving mass over the force that one unit of the channel makes.
    pub inertia: Estimate,
    /// Per m/s or rad/s.
    pub viscous: Estimate,
    /// Level of dry friction.
    pub coulomb: Estimate,
    /// What is spent alike in both directions.
    pub constant: Estimate,
    /// Time from the channel to its force, in s.
    pub delay: Estimate,
    /// Share of the channel's variance that the balance explains.
    pub explained: f64,
    /// w in s.
    pub window_s: f64,
}

impl Balance {
    /// In another unit: that of the channel times the factor's.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            inertia: self.inertia.times(factor),
            viscous: self.viscous.times(factor),
            coulomb: self.coulomb.times(factor),
            constant: self.constant.times(factor),
            ..*self
        }
    }
}

/// Rows of the balance with the channel as many samples late.
struct Rows {
    columns: Vec<[f64; 4]>,
    targets: Vec<f64>,
    lengths: Vec<usize>,
}

/// The balance of a channel over all runs.
///
/// # Errors
/// Too few moving samples.
pub fn balance(runs: &[Run], driver: Signal) -> Result<Outcome<Balance>> {
    let period_s = runs.first().map_or(1.0, Run::sample_period_s);
    let width = width(runs, period_s);
    let fit = |delay: usize| -> Result<Outcome<(f64, Balance)>> {
        let rows = rows(runs, driver, width, delay);
        rows.solve(driver, width as f64 * period_s)
    };
    let first = match fit(0)? {
        Outcome::Identified(found) => found,
        Outcome::NotExcited(why) => return Ok(Outcome::NotExcited(why)),
    };
    if driver != Signal::ControlEffort {
        return Ok(Outcome::Identified(first.1));
    }
    let mut fits = vec![first];
    for delay in 1..=MOST_DELAY {
        match fit(delay)? {
            Outcome::Identified(found) => fits.push(found),
            Outcome::NotExcited(_) => break,
        }
    }
    let costs: Vec<f64> = fits.iter().map(|(cost, _)| *cost).collect();
    let best = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(k, _)| k);
    let mut found = fits[best].1;
    found.delay = delay::of_costs(&costs, best, period_s);
    Ok(Outcome::Identified(found))
}

/// The half width at which noise is small and the motion still shows.
fn width(runs: &[Run], period_s: f64) -> usize {
    let noise = reading_noise(runs);
    let shortest = runs.iter().map(Run::len).min().unwrap_or_default();
    let mut narrowest = None;
    let mut chosen = WIDTHS[0];
    for width in WIDTHS.into_iter().filter(|width| 8 * width < shortest) {
        let variance = spread(runs, width, period_s);
        let of_noise = 6.0 * noise.powi(2) / (width as f64 * period_s).powi(4);
        if of_noise > MOST_NOISE * variance && narrowest.is_none() {
            chosen = width;
            continue;
        }
        let first = *narrowest.get_or_insert(variance);
        if variance < LEAST_LEFT * first {
            break;
        }
        chosen = width;
    }
    chosen
}

/// Mean square of the averaged acceleration.
fn spread(runs: &[Run], width: usize, period_s: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    let square = (width as f64 * period_s).powi(2);
    for position in runs.iter().filter_map(|run| run.signal(Signal::Position)) {
        for k in (width..position.len().saturating_sub(width)).step_by(width.div_ceil(ROWS_A_WIDTH)) {
            sum += ((position[k + width] - 2.0 * position[k] + position[k - width]) / square).powi(2);
            count += 1.0;
        }
    }
    sum / count.max(1.0)
}

fn rows(runs: &[Run], driver: Signal, width: usize, delay: usize) -> Rows {
    let mut rows = Rows { columns: Vec::new(), targets: Vec::new(), lengths: Vec::new() };
    let fastest = runs.iter().map(|run| fastest(run, WIDTHS[0])).fold(0.0, f64::max);
    for run in runs {
        let before = rows.targets.len();
        let (Some(position), Some(channel)) = (run.signal(Signal::Position), run.signal(driver)) else {
            continue;
        };
        let disturbance = run.signal(Signal::DisturbanceVoltage).filter(|_| driver == Signal::ControlEffort);
        let is_held = driver == Signal::ControlEffort;
        let span = width as f64 * run.sample_period_s();
        let from = width + delay;
        let slides = Sliding::of(position, LEAST_SPEED * fastest * run.sample_period_s());
        for k in (from..position.len().saturating_sub(width)).step_by(width.div_ceil(ROWS_A_WIDTH)) {
            if !slides.all(k - width..k + width + 1) {
                continue;
            }
            let ahead = (position[k + width] - position[k]) / span;
            let behind = (position[k] - position[k - width]) / span;
            let side = |from: usize| mean(&position[from..=from + width]);
            let velocity = (side(k) - side(k - width)) / span;
            rows.columns.push([(ahead - behind) / span, velocity, velocity.signum(), 1.0]);
            let at = k - delay;
            rows.targets.push(
                averaged(channel, at, width, is_held)
                    - disturbance.map_or(0.0, |of| averaged(of, k, width, true)),
            );
        }
        rows.lengths.push(rows.targets.len() - before);
    }
    rows
}

/// Where the axis slides in one direction.
struct Sliding {
    /// Sample at which the stretch of one direction that holds this sample ends; none where the axis is slow.
    until: Vec<Option<usize>>,
}

impl Sliding {
    /// `least` is the way in one period below which it is slow.
    fn of(position: &[f64], least: f64) -> Self {
        let half = WIDTHS[0];
        let way = |k: usize| {
            let (from, to) = (k.saturating_sub(half), (k + half).min(position.len() - 1));
            let way = (position[to] - position[from]) / (to - from).max(1) as f64;
            if way.abs() < least { 0.0 } else { way.signum() }
        };
        let ways: Vec<f64> = (0..position.len()).map(way).collect();
        let mut until: Vec<Option<usize>> = vec![None; ways.len()];
        for k in (0..ways.len()).rev() {
            let goes_on = until.get(k + 1).copied().flatten().filter(|_| ways[k] == ways[k + 1]);
            until[k] = (ways[k] != 0.0).then(|| goes_on.unwrap_or(k));
        }
        Self { until }
    }

    fn all(&self, samples: std::ops::Range<usize>) -> bool {
        self.until[samples.start].is_some_and(|until| until + 1 >= samples.end)
    }
}

fn fastest(run: &Run, width: usize) -> f64 {
    let span = width as f64 * run.sample_period_s();
    let position = run.signal(Signal::Position).unwrap_or_default();
    position.windows(width + 1).map(|w| ((w[width] - w[0]) / span).abs()).fold(0.0, f64::max)
}

/// Mean of a line through the samples.
fn mean(samples: &[f64]) -> f64 {
    let ends = 0.5 * (samples[0] + samples[samples.len() - 1]);
    (samples.iter().sum::<f64>() - ends) / (samples.len() - 1) as f64
}

/// The channel under the triangle about a sample: held over each period, or as seen at its instant.
fn averaged(channel: &[f64], at: usize, width: usize, is_held: bool) -> f64 {
    let square = (width * width) as f64;
    let weight = |from: f64| (width as f64 - from.abs()) / square;
    let from = at - width;
    let shift = if is_held { 0.5 } else { 0.0 };
    channel[from..at + width]
        .iter()
        .enumerate()
        .map(|(j, y)| y * weight(j as f64 - width as f64 + shift))
        .sum()
}

impl Rows {
    fn solve(&self, driver: Signal, window_s: f64) -> Result<Outcome<(f64, Balance)>> {
        let names = ["acceleration", "velocity", "direction", "constant"].map(str::to_owned).to_vec();
        let regressor = DMatrix::from_fn(self.targets.len(), 4, |row, column| self.columns[row][column]);
        let regression = Regression { names, regressor, target: DVector::from_column_slice(&self.targets) };
        let solution = match regression.solve(REMEDY)? {
            Outcome::Identified(solution) => solution,
            Outcome::NotExcited(why) => return Ok(Outcome::NotExcited(why)),
        };
        let left: f64 = solution.residuals.iter().map(|e| e * e).sum();
        let middle = self.targets.iter().sum::<f64>() / self.targets.len() as f64;
        let power: f64 = self.targets.iter().map(|y| (y - middle).powi(2)).sum();
        let robust = regression.with_correlated_residual(&solution, &self.lengths)?;
        let of = |column: usize| robust.estimates[column];
        let balance = Balance {
            driver,
            inertia: of(0),
            viscous: of(1),
            coulomb: of(2),
            constant: of(3),
            delay: Estimate::exact(0.0),
            explained: if power > 0.0 { 1.0 - left / power } else { 0.0 },
            window_s,
        };
        Ok(Outcome::Identified((left / self.targets.len() as f64, balance)))
    }
}
