//! One run of the estimate: what was recorded, and the twin's replay of it for given numbers.

use super::super::compared::{as_set, check};
use super::super::start::Start;
use super::super::{Recorded, Traces};
use super::profile::{Profile, Strokes};
use super::{Numbers, refused};
use crate::drive::motor::Circuit;
use crate::effect::EffectId;
use crate::error::{ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::axis::Axis;
use crate::plant::rapier::Rig;
use crate::recording::{Run, Signal};
use crate::twin::Sensing;
use crate::units::Motion;

/// Replays with noise from which the noise of every sample is told.
pub(super) const DRAWS: u64 = 24;
/// Noise is averaged over so long to each side, in s.
const PROFILE_S: f64 = 5e-3;
/// σ of normal noise over the median of its magnitude.
const MEDIAN_TO_SIGMA: f64 = 1.4826;
/// Noise of a signal for a first fit, as a share of its range: position must not drown force.
const ROUGH: [f64; 2] = [1e-3, 1e-2];

/// A run, the machine as it was set in it, and the noise of the signals that are compared.
pub(super) struct Subject {
    pub(super) run: Run,
    pub(super) profile: Profile,
    /// Position, and the force or what stands for it.
    pub(super) signals: [Signal; 2],
    machine: Machine,
    start: Start,
    /// σ of each signal at each sample.
    sigma: [Vec<f64>; 2],
    /// Whether the commanded voltage at the start matters: where it is logged and the controller has an integrator to hold it.
    has_start_effort: bool,
}

impl Subject {
    pub(super) fn of(run: &Run, machine: &Machine) -> Result<Self> {
        check(run, machine)?;
        if machine.description().controller.is_none() {
            return Err(refused(run, ErrorKind::Missing, "controller")
                .found(format!("the machine {} without a control law", machine.file().display()))
                .expected("the table [controller]: the loop is replayed closed")
                .remedy("state the control law; where it is not known, `slideway diagnose` finds friction from the recorded effort"));
        }
        let position = run.require(Signal::Position)?;
        let has_current = machine.description().motor.has_current();
        let forces = [Signal::Thrust, Signal::Current, Signal::ControlEffort].into_iter();
        let mut forces = forces.filter(|signal| *signal != Signal::Current || has_current);
        let force = forces.find(|signal| run.signal(*signal).is_some()).ok_or_else(|| {
            refused(run, ErrorKind::Missing, Signal::ControlEffort.key(run.motion()))
                .found("a run without effort, current or force")
                .expected("one of them beside the position")
                .remedy("log the effort; position alone does not tell friction from the rest")
        })?;
        let machine = as_set(run, machine)?;
        let profile = Profile::of(run, machine.description().reference.acceleration_time_s)?;
        let reference = match &profile {
            Profile::Logged(reference) => reference.clone(),
            Profile::Strokes(strokes) => {
                let ramp_s = machine.description().reference.acceleration_time_s;
                strokes.reference(strokes.read_s.unwrap_or(ramp_s), &strokes.start_s, strokes.base, run)
            }
        };
        let start = Start::of(run, &reference, position);
        let signals = [Signal::Position, force];
        let mut subject = Self {
            run: run.clone(),
            profile,
            signals,
            machine,
            start,
            sigma: [Vec::new(), Vec::new()],
            has_start_effort: false,
        };
        subject.has_start_effort = subject.start_effort_matters()?;
        subject.sigma = [0, 1].map(|k| vec![(ROUGH[k] * range(subject.recorded(k))).max(1e-12); run.len()]);
        Ok(subject)
    }

    /// The strokes whose start is not known.
    pub(super) fn unknown(&self) -> Option<&Strokes> {
        match &self.profile {
            Profile::Strokes(strokes) if strokes.read_s.is_none() => Some(strokes),
            _ => None,
        }
    }

    pub(super) fn recorded(&self, k: usize) -> &[f64] {
        self.run.signal(self.signals[k]).unwrap_or_default()
    }

    /// Whether the commanded voltage at the start can be off.
    pub(super) fn has_start_effort(&self) -> bool {
        self.has_start_effort
    }

    /// Whether another voltage at the start changes the replay.
    fn start_effort_matters(&self) -> Result<bool> {
        let Some(effort_v) = self.start.effort_v else { return Ok(false) };
        let (starts, base) = match &self.profile {
            Profile::Strokes(strokes) => (strokes.start_s.clone(), strokes.base),
            Profile::Logged(_) => (Vec::new(), 0.0),
        };
        let ramp_s = self.machine.description().reference.acceleration_time_s;
        let mut numbers = Numbers { ramp_s, coulomb: 0.0, viscous: None, starts, base, start_off: [0.0; 2] };
        let as_shown = self.replay(&numbers, Sensing::Perfect)?;
        numbers.start_off[1] = 1e-3 * effort_v.abs().max(1.0);
        let other = self.replay(&numbers, Sensing::Perfect)?;
        Ok(as_shown.signal(self.signals[1]) != other.signal(self.signals[1]))
    }

    /// The machine with the numbers of a replay.
    fn set(&self, numbers: &Numbers) -> Result<Machine> {
        let path = |effect| path(effect, self.run.motion());
        let mut settings = vec![(path(EffectId::CoulombFriction), numbers.coulomb)];
        settings.extend(numbers.viscous.map(|viscous| (path(EffectId::ViscousFriction), viscous)));
        self.machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), (*value).into())))
    }

    /// Commands and start of a replay.
    fn commands(&self, numbers: &Numbers, machine: &Machine) -> Result<Recorded> {
        let reference = match &self.profile {
            Profile::Logged(reference) => reference.clone(),
            Profile::Strokes(strokes) => {
                strokes.reference(numbers.ramp_s, &numbers.starts, numbers.base, &self.run)
            }
        };
        let mut start = self.start;
        start.position += numbers.start_off[0];
        if let Some(effort_v) = &mut start.effort_v {
            *effort_v += numbers.start_off[1];
            start.resting_effort_v = start.resting_effort_v.map(|resting_v| resting_v + numbers.start_off[1]);
            if let Circuit::Winding { resistance_ohm, .. } = machine.constants().circuit {
                start.current = start.current.map(|current| current + numbers.start_off[1] / resistance_ohm);
            }
        }
        Recorded::from(&self.run, &reference, start, &self.machine)
    }

    /// What the twin makes of the run.
    pub(super) fn replay(&self, numbers: &Numbers, sensing: Sensing) -> Result<Traces> {
        let machine = self.set(numbers)?;
        Ok(self.commands(numbers, &machine)?.replay(&machine, Axis::of(&machine.constants()), sensing))
    }

    /// By how much residuals change, in units of noise, on the rigid-body scene.
    pub(super) fn change_on_scene(&self, numbers: &Numbers) -> Result<Vec<f64>> {
        let as_fitted = self.replay(numbers, Sensing::Perfect)?;
        let machine = self.set(numbers)?;
        let commands = self.commands(numbers, &machine)?;
        let scene = commands.replay(&machine, Rig::new(&machine)?, Sensing::Perfect);
        Ok(self.difference(&as_fitted, &scene))
    }

    /// One prediction less another, in units of noise.
    fn difference(&self, one: &Traces, other: &Traces) -> Vec<f64> {
        let of = |k: usize| {
            let [one, other] = [one, other].map(|traces| traces.signal(self.signals[k]).unwrap_or_default());
            let pairs = one.iter().zip(other).zip(&self.sigma[k]);
            pairs.map(|((one, other), sigma)| (one - other) / sigma).collect::<Vec<f64>>()
        };
        [of(0), of(1)].concat()
    }

    /// Recorded less predicted in units of noise: position first, then force.
    pub(super) fn residuals(&self, numbers: &Numbers) -> Result<Vec<f64>> {
        let traces = self.replay(numbers, Sensing::Perfect)?;
        let mut residuals = Vec::with_capacity(2 * self.run.len());
        for k in 0..2 {
            let predicted = traces.signal(self.signals[k]).unwrap_or_default();
            let triples = self.recorded(k).iter().zip(predicted).zip(&self.sigma[k]);
            residuals.extend(triples.map(|((r, p), sigma)| (r - p) / sigma));
        }
        Ok(residuals)
    }

    /// What the sensors' stated noise makes of both signals through the closed loop, one draw after the other, in SI.
    pub(super) fn noise(&self, numbers: &Numbers) -> Result<Vec<[Vec<f64>; 2]>> {
        let clean = self.replay(numbers, Sensing::Perfect)?;
        let draw = |seed| {
            let noisy = self.replay(numbers, Sensing::AsStated { seed })?;
            Ok(self.signals.map(|signal| {
                let both = |traces: &Traces| traces.signal(signal).unwrap_or_default().to_vec();
                both(&noisy).iter().zip(both(&clean)).map(|(noisy, clean)| noisy - clean).collect()
            }))
        };
        (1..=DRAWS).map(draw).collect()
    }

    /// Takes the noise of every sample from draws, and beside it what the twin leaves of the recording anyway.
    ///
    /// # Model
    /// σ(t)² = mean over draws and ±5 ms of the noise's square, + S²; S² = (1.4826·median|residual|)² − (the same of the
    /// noise)², not below 0.
    pub(super) fn weigh(&mut self, numbers: &Numbers, draws: &[[Vec<f64>; 2]]) -> Result<()> {
        let traces = self.replay(numbers, Sensing::Perfect)?;
        let half = ((PROFILE_S / self.run.sample_period_s()).round() as usize).max(1);
        for k in 0..2 {
            let predicted = traces.signal(self.signals[k]).unwrap_or_default();
            let left = self.recorded(k).iter().zip(predicted).map(|(r, p)| (r - p).abs()).collect();
            let noise = draws.iter().flat_map(|draw| draw[k].iter().map(|e| e.abs())).collect();
            let structure = (spread(left).powi(2) - spread(noise).powi(2)).max(0.0);
            let least = 1e-9 * range(self.recorded(k)).max(1e-12);
            let profile = smooth_square(draws, k, half);
            self.sigma[k] =
                profile.into_iter().map(|square| (square + structure).sqrt().max(least)).collect();
        }
        Ok(())
    }

    /// A draw of noise in units of σ, as residuals stand.
    pub(super) fn normalised<'a>(&'a self, draw: &'a [Vec<f64>; 2]) -> impl Iterator<Item = f64> + 'a {
        (0..2).flat_map(move |k| draw[k].iter().zip(&self.sigma[k]).map(|(e, sigma)| e / sigma))
    }
}

/// Key path of an effect's first number.
pub(super) fn path(effect: EffectId, motion: Motion) -> String {
    format!("effect.{}.{}", effect.name(), effect.parameters()[0].key(motion))
}

/// Largest less smallest value.
pub(super) fn range(samples: &[f64]) -> f64 {
    let (low, high) =
        samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    (high - low).max(0.0)
}

/// σ from the median of magnitudes.
fn spread(mut magnitudes: Vec<f64>) -> f64 {
    let middle = magnitudes.len() / 2;
    if magnitudes.is_empty() {
        return 0.0;
    }
    MEDIAN_TO_SIGMA * *magnitudes.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Mean square of a signal's noise over draws and `half` samples to each side.
fn smooth_square(draws: &[[Vec<f64>; 2]], k: usize, half: usize) -> Vec<f64> {
    let count = draws.first().map_or(0, |draw| draw[k].len());
    let mut sums = vec![0.0];
    for sample in 0..count {
        let square = draws.iter().map(|draw| draw[k][sample].powi(2)).sum::<f64>() / draws.len() as f64;
        sums.push(sums[sample] + square);
    }
    let window = |j: usize| (j.saturating_sub(half), (j + half + 1).min(count));
    (0..count)
        .map(|j| {
            let (from, to) = window(j);
            (sums[to] - sums[from]).max(0.0) / (to - from) as f64
        })
        .collect()
}
