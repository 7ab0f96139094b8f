//! Where the gap lies: by segment of the signal path, phase of the motion, frequency, position and speed.

use super::experiment::Experiment;
use super::noise::Floor;
use super::place::{Band, Share, Where};
use super::segments::segments;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::twin::Sensing;
use realfft::RealFftPlanner;

/// Localises the gap of the twin as it is on the held-out runs.
///
/// # Model
/// *Segments.* The path is cut at every logged signal, see [`segments`](super::segments::segments). `machines` are the
/// twin as it is and the twin with what was found, which tells what noise alone leaves.
///
/// *Phase, frequency, position, speed.* Shares of the squared normalised residual of the free-run replay.
///
/// # Errors
/// Whatever a replay refuses.
pub fn locate(machines: [&Machine; 2], experiments: &[Experiment], floor: &Floor) -> Result<Where> {
    let mut energy = Energy::default();
    let span = Span::of(experiments);
    for experiment in experiments {
        let predicted = experiment.predict(machines[0], Sensing::Perfect)?;
        let phases = phases(experiment);
        let position = experiment.run().require(Signal::Position)?;
        for &signal in experiment.signals() {
            let residual = floor.normalised(experiment, signal, &predicted);
            energy.add(&residual, &phases, position, experiment, &span);
        }
    }
    Ok(Where {
        site: Vec::new(),
        segment: segments(machines, experiments, floor)?,
        phase: shares(&PHASES, &energy.phase),
        frequency_hz: bands(&frequency_edges(experiments), &energy.frequency),
        position: bands(&span.position_edges(), &energy.position),
        speed: bands(&span.speed_edges(), &energy.speed),
    })
}

/// Phases of a motion, as the reference tells them.
const PHASES: [&str; 6] = ["dwell", "accelerate", "cruise", "decelerate", "reverse", "settle"];
const DWELL: usize = 0;
const ACCELERATE: usize = 1;
const CRUISE: usize = 2;
const DECELERATE: usize = 3;
const REVERSE: usize = 4;
const SETTLE: usize = 5;
/// A stop or reversal colours so many seconds around it.
const AROUND_S: f64 = 0.03;
/// The axis settles for so long after the reference stops, in s.
const SETTLING_S: f64 = 0.4;

fn phases(experiment: &Experiment) -> Vec<usize> {
    let commands = experiment.recorded().commands();
    let period = experiment.run().sample_period_s();
    let velocity: Vec<f64> = commands.iter().map(|c| c.velocity_reference).collect();
    let most = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
    let steepest = velocity.windows(2).fold(0.0, |most: f64, w| most.max((w[1] - w[0]).abs()));
    let mut last_move = None;
    let mut phases: Vec<usize> = (0..velocity.len())
        .map(|k| {
            let (v, next) = (velocity[k], velocity.get(k + 1).copied().unwrap_or(velocity[k]));
            if v.abs() <= 1e-6 * most {
                let settling = last_move.is_some_and(|at: usize| (k - at) as f64 * period < SETTLING_S);
                return if settling { SETTLE } else { DWELL };
            }
            last_move = Some(k);
            let change = (next - v) * v.signum();
            if change > 0.02 * steepest {
                ACCELERATE
            } else if change < -0.02 * steepest {
                DECELERATE
            } else {
                CRUISE
            }
        })
        .collect();
    let around = (AROUND_S / period).round() as usize;
    for k in 1..velocity.len() {
        if velocity[k - 1] * velocity[k] < 0.0 {
            let to = (k + around).min(phases.len());
            phases[k.saturating_sub(around)..to].fill(REVERSE);
        }
    }
    phases
}

const BINS: usize = 10;

/// Range of positions and speeds over all runs.
struct Span {
    position: (f64, f64),
    speed: f64,
}

impl Span {
    fn of(experiments: &[Experiment]) -> Self {
        let mut span = Self { position: (f64::MAX, f64::MIN), speed: 0.0 };
        for experiment in experiments {
            for x in experiment.run().signal(Signal::Position).unwrap_or_default() {
                span.position = (span.position.0.min(*x), span.position.1.max(*x));
            }
            let most = experiment.recorded().commands().iter().map(|c| c.velocity_reference.abs());
            span.speed = most.fold(span.speed, f64::max);
        }
        span
    }

    fn position_edges(&self) -> Vec<f64> {
        let (from, to) = self.position;
        (0..=BINS).map(|k| from + (to - from) * k as f64 / BINS as f64).collect()
    }

    fn speed_edges(&self) -> Vec<f64> {
        (0..=BINS).map(|k| self.speed * k as f64 / BINS as f64).collect()
    }
}

/// Upper edges of the frequency bands in Hz, up to half the sample rate.
fn frequency_edges(experiments: &[Experiment]) -> Vec<f64> {
    let rate = experiments.first().map_or(1.0, |e| 1.0 / e.run().sample_period_s());
    let mut edges: Vec<f64> = [0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0]
        .into_iter()
        .filter(|f| *f < 0.5 * rate)
        .collect();
    edges.push(0.5 * rate);
    edges
}

/// Squared normalised residuals, gathered by place.
#[derive(Default)]
struct Energy {
    phase: Vec<f64>,
    frequency: Vec<f64>,
    position: Vec<f64>,
    speed: Vec<f64>,
}

impl Energy {
    fn add(
        &mut self,
        residual: &[f64],
        phases: &[usize],
        position: &[f64],
        experiment: &Experiment,
        span: &Span,
    ) {
        self.phase.resize(PHASES.len(), 0.0);
        self.position.resize(BINS, 0.0);
        self.speed.resize(BINS, 0.0);
        let (from, to) = span.position;
        let bin = |fraction: f64| ((fraction * BINS as f64) as usize).min(BINS - 1);
        let commands = experiment.recorded().commands();
        for (k, r) in residual.iter().enumerate() {
            let square = r * r;
            self.phase[phases[k]] += square;
            self.position[bin((position[k] - from) / (to - from).max(f64::MIN_POSITIVE))] += square;
            let speed = commands[k].velocity_reference.abs();
            self.speed[bin(speed / span.speed.max(f64::MIN_POSITIVE))] += square;
        }
        self.add_spectrum(residual, experiment);
    }

    fn add_spectrum(&mut self, residual: &[f64], experiment: &Experiment) {
        let edges = frequency_edges(std::slice::from_ref(experiment));
        self.frequency.resize(edges.len() - 1, 0.0);
        let mut planner = RealFftPlanner::<f64>::new();
        let transform = planner.plan_fft_forward(residual.len());
        let mut spectrum = transform.make_output_vec();
        if transform.process(&mut residual.to_vec(), &mut spectrum).is_err() {
            return;
        }
        let resolution = 1.0 / (residual.len() as f64 * experiment.run().sample_period_s());
        for (k, value) in spectrum.iter().enumerate() {
            let frequency = k as f64 * resolution;
            let band = edges[1..].iter().position(|edge| frequency < *edge).unwrap_or(edges.len() - 2);
            // Every line but the first and last stands for two.
            let twice = if k == 0 || 2 * k == residual.len() { 1.0 } else { 2.0 };
            self.frequency[band] += twice * value.norm_sqr() / residual.len() as f64;
        }
    }
}

fn shares(names: &[&str], energy: &[f64]) -> Vec<Share> {
    let total: f64 = energy.iter().sum();
    names
        .iter()
        .zip(energy)
        .map(|(name, e)| Share {
            name: (*name).to_string(),
            share: if total > 0.0 { e / total } else { 0.0 },
        })
        .collect()
}

fn bands(edges: &[f64], energy: &[f64]) -> Vec<Band> {
    let total: f64 = energy.iter().sum();
    edges
        .windows(2)
        .zip(energy)
        .map(|(w, e)| Band { from: w[0], to: w[1], share: if total > 0.0 { e / total } else { 0.0 } })
        .collect()
}
