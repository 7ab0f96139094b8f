//! One run on which rivals are compared: recorded, or simulated as it would be recorded.

use super::plan::Plan;
use crate::diagnose::beginnings::has_own_beginnings;
use crate::diagnose::experiment::Experiment;
use crate::diagnose::fit::Fit;
use crate::diagnose::noise::Floor;
use crate::diagnose::play;
use crate::effect::EffectId;
use crate::error::Result;
use crate::machine::Machine;
use crate::plant::axis::LONGEST_STEP_S;
use crate::recording::{Run, Signal};
use crate::replay::recording::recorded;
use crate::replay::{PlantChoice, Traces, simulate};
use crate::twin::Sensing;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// A sensor that nobody has bought yet errs by this share of what it measures.
const SENSOR_ERROR: f64 = 0.01;

/// Key path of the mass that an operator can bolt on.
pub(super) fn payload_path(machine: &Machine) -> String {
    let parameter = &EffectId::Payload.parameters()[0];
    format!("effect.{}.{}", EffectId::Payload.name(), parameter.key(machine.motion()))
}

/// What the setting of the payload has to be for a known mass more than the machine has.
pub(super) fn payload(machine: &Machine, added: f64) -> f64 {
    let path = payload_path(machine);
    let stated = machine.stated_before(&path).unwrap_or_else(|| machine.number(&path));
    stated.unwrap_or(0.0) + added
}

/// A run in which two explanations differ by less does not tell them apart, in nats: a tenth of what settles a question.
const LEAST_NATS: f64 = 1.0;

/// How residuals are counted in a log-likelihood.
pub(super) struct Measure<'a> {
    /// Noise floor of the recording.
    pub(super) floor: &'a Floor,
    /// What a squared normalised residual of a signal counts.
    pub(super) deflation: &'a dyn Fn(Signal) -> f64,
    /// Signals that the recording has, in signal-path order.
    pub(super) logged: &'a [Signal],
    /// Effort that a planned run may take, in V.
    pub(super) largest_effort_v: f64,
}

/// A planned run may take so many times the largest recorded effort: what has been recorded is known to be safe, and a little
/// more is tried.
const MORE_EFFORT: f64 = 3.0;

/// The effort that a further run of recorded ones may take, in V; no limit where none was logged.
pub(super) fn largest_effort_v(runs: &[Experiment]) -> f64 {
    let commanded = |e: &Experiment| Some(e.recorded().commanded_v(e.run().signal(Signal::ControlEffort)?));
    let largest =
        runs.iter().filter_map(commanded).flatten().fold(0.0_f64, |most, effort| most.max(effort.abs()));
    if largest > 0.0 { MORE_EFFORT * largest } else { f64::INFINITY }
}

/// A run with the weight of each sample of each of its signals.
pub(super) struct Stage {
    experiment: Experiment,
    /// √weight/σ of each sample.
    channels: Vec<(Signal, Vec<f64>)>,
}

impl Stage {
    /// A recorded run.
    pub(super) fn recorded(experiment: &Experiment, measure: &Measure) -> Self {
        let channels = measure.logged.iter().map(|&signal| {
            let sigma = measure.floor.sigma(signal);
            let sigmas = profiled(measure.floor, experiment, signal, |wider| sigma * wider);
            (signal, measure.scales(signal, measure.logged.len(), &sigmas))
        });
        Self { experiment: experiment.clone(), channels: channels.collect() }
    }

    /// A drafted run as it would be recorded, with one signal more where `extra` names it.
    ///
    /// # Errors
    /// What a replay refuses.
    pub(super) fn planned(
        Draft { experiment, truth }: Draft,
        extra: Option<Signal>,
        measure: &Measure,
    ) -> Result<Self> {
        let own = Floor::estimate(&truth, &[&experiment])?;
        let signals: Vec<Signal> = measure.logged.iter().copied().chain(extra).collect();
        let channels = signals.iter().map(|&signal| {
            let level = own.sigma(signal);
            let least = if Some(signal) != extra {
                measure.floor.sigma(signal)
            } else if matches!(signal, Signal::Position | Signal::LoadPosition) {
                0.0 // its noise is stated, or that of the encoder
            } else {
                SENSOR_ERROR * root_mean_square(experiment.run().signal(signal).unwrap_or_default())
            };
            // The noise of the loop in this motion, and at least that of the recording.
            let sigmas = profiled(&own, &experiment, signal, |wider| (level * wider).max(least));
            (signal, measure.scales(signal, signals.len(), &sigmas))
        });
        let channels = channels.collect();
        Ok(Self { experiment, channels })
    }

    /// What a hypothesis predicts with several sets of values, all near the first one; the squared distance of two predictions is twice a difference of
    /// log-likelihood. Of a machine with a vibration or a play all have the phase, or the place in the play where the run begins, that suits the first; `advance` is by
    /// how much that is varied, in rad or as a share of half the play.
    ///
    /// # Errors
    /// A setting of the run that the machine does not have.
    pub(super) fn images(
        &self,
        base: &Machine,
        fit: &Fit,
        sets: &[Vec<f64>],
        advance: f64,
    ) -> Result<Images> {
        let machines: Vec<Option<Machine>> =
            sets.iter().map(|values| fit.hypothesis.machine(base, values).ok()).collect();
        let sound: Vec<Machine> = machines.iter().flatten().cloned().collect();
        let near = machines.first().and_then(Option::as_ref).filter(|machine| has_own_beginnings(machine));
        let mut predicted = match near {
            None => self.experiment.predict_together(&sound, LONGEST_STEP_S)?,
            Some(near) => {
                let advanced = sound.iter().map(|machine| (machine, 0.0)).chain([(near, advance)]);
                self.experiment.predict_near(near, &advanced.collect::<Vec<_>>(), LONGEST_STEP_S)?
            }
        };
        let advanced = near.and_then(|_| Some(self.image(&predicted.pop()?)));
        let mut predicted = predicted.iter();
        let image = |machine: Option<Machine>| machine.and_then(|_| Some(self.image(predicted.next()?)));
        Ok(Images { of_sets: machines.into_iter().map(image).collect(), advanced })
    }

    fn image(&self, predicted: &Traces) -> DVector<f64> {
        let mut image = Vec::with_capacity(self.channels.len() * self.experiment.samples());
        for (signal, scales) in &self.channels {
            let trace = predicted.signal(*signal).unwrap_or_default();
            image.extend(trace.iter().zip(scales).map(|(value, scale)| value * scale));
        }
        DVector::from_vec(image)
    }

    /// Sum of squares of each signal in a difference of images.
    pub(super) fn shares(&self, difference: &DVector<f64>) -> Vec<(Signal, f64)> {
        let samples = self.experiment.samples();
        let parts = self.channels.iter().enumerate();
        parts
            .map(|(k, (signal, _))| (*signal, difference.rows(k * samples, samples).norm_squared()))
            .collect()
    }
}

/// What a hypothesis predicts, all signals one after the other in weighted units of noise.
pub(super) struct Images {
    /// With each of several sets of values; none of a set that the machine's description refuses.
    pub(super) of_sets: Vec<Option<DVector<f64>>>,
    /// With the first one and a little of the phase, or of the place in the play, that is each run's own; none where there is neither.
    pub(super) advanced: Option<DVector<f64>>,
}

/// The first run of a plan, before its noise is known.
pub(super) struct Draft {
    experiment: Experiment,
    /// The machine that is in it.
    truth: Machine,
}

impl Draft {
    /// The run as the machine that `truth` says would make it. None where the axis would need more force than it has, or far more effort than
    /// was ever recorded.
    ///
    /// # Errors
    /// What a replay refuses: a stroke beyond the joint's limits, say.
    pub(super) fn of(
        plan: &Plan,
        base: &Machine,
        truth: &Fit,
        settings: &BTreeMap<String, toml::Value>,
        measure: &Measure,
    ) -> Result<Option<Self>> {
        let reference = plan.references(base).swap_remove(0);
        let mut settings = settings.clone();
        if let Some(mass) = plan.added_mass {
            settings.insert(payload_path(base), payload(base, mass).into());
        }
        let named = |mut run: Run| {
            run.settings.clone_from(&settings);
            Experiment::new(&run, base)
        };
        // The settings of a run are the experiment's business: a run without content asks it for the machine.
        let still = [Signal::PositionReference, Signal::Position].map(|signal| (signal, reference.clone()));
        let period_s = base.description().sample_period_s;
        let still = Run::new("planned", base.motion(), period_s, still.into_iter().collect())?;
        let truth = truth.machine(base)?;
        let real = play::from_middle(named(still)?.machine(&truth)?)?;
        let traces = simulate(&real, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ())?;
        let limit = base.solid().joint.effort;
        let within = |samples: &[f64], limit: f64| samples.iter().all(|x| x.is_finite() && x.abs() <= limit);
        if !(within(&traces.thrust, limit) && within(&traces.effort_v, measure.largest_effort_v)) {
            return Ok(None);
        }
        let experiment = named(recorded("planned", base, &reference, traces)?)?;
        Ok(Some(Self { experiment, truth }))
    }

    /// Whether the run may tell another explanation, with the numbers that make it most alike on the recorded runs, from the one that is in it, by what was
    /// logged: whether they differ by a nat at the least noise that its signals can have, that of the recording.
    ///
    /// # Errors
    /// What a replay refuses.
    pub(super) fn may_tell(&self, base: &Machine, other: &Fit, measure: &Measure) -> Result<bool> {
        let predicted =
            self.experiment.predict_together(&[self.truth.clone(), other.machine(base)?], LONGEST_STEP_S)?;
        let [own, other] = &predicted[..] else { return Ok(true) };
        let squares = |&signal: &Signal| {
            let [Some(own), Some(other)] = [own, other].map(|traces| traces.signal(signal)) else {
                return 0.0;
            };
            let scale = measure.scales(signal, measure.logged.len(), &[measure.floor.sigma(signal)])[0];
            own.iter().zip(other).map(|(a, b)| ((a - b) * scale).powi(2)).sum()
        };
        let nats = 0.5 * measure.logged.iter().map(squares).sum::<f64>();
        // What is not a number is no proof.
        Ok(nats.is_nan() || nats >= LEAST_NATS)
    }
}

impl Measure<'_> {
    fn scales(&self, signal: Signal, signals: usize, sigmas: &[f64]) -> Vec<f64> {
        // What is not logged yet is taken to be as correlated as the most correlated signal that is.
        let deflation = if self.logged.contains(&signal) {
            (self.deflation)(signal)
        } else {
            self.logged.iter().map(|s| (self.deflation)(*s)).fold(1.0, f64::min)
        };
        let weight = (deflation / signals as f64).sqrt();
        sigmas.iter().map(|sigma| weight / sigma).collect()
    }
}

fn profiled(floor: &Floor, experiment: &Experiment, signal: Signal, sigma: impl Fn(f64) -> f64) -> Vec<f64> {
    match floor.profile(experiment, signal) {
        Some(profile) => profile.iter().map(|wider| sigma(*wider)).collect(),
        None => vec![sigma(1.0); experiment.samples()],
    }
}

fn root_mean_square(samples: &[f64]) -> f64 {
    (samples.iter().map(|x| x * x).sum::<f64>() / samples.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hypothesis::{EffectSet, Hypothesis};
    use crate::machine::shipped;
    use crate::units::Motion;
    use nalgebra::DMatrix;

    /// What was recorded is known to be safe: three times its effort may be asked for and no more, whatever the amplifier can do.
    #[test]
    fn exact_planned_runs_stay_within_three_times_the_recorded_effort() {
        // A linear machine that is far from its own limits: one that rides on sliders.
        let machine = shipped().find(|machine| machine.constants().has_slider_loads).unwrap();
        let effects = EffectSet::new();
        let hypothesis = Hypothesis {
            effects: effects.clone(),
            free: vec![],
            starts: vec![],
            building: 0,
            inherited: 0,
            elsewhere: EffectSet::new(),
        };
        let truth = Fit {
            hypothesis,
            values: vec![],
            size: 0.0,
            mean_square: 0.0,
            standard_errors: vec![],
            covariance: DMatrix::zeros(0, 0),
            shown: effects,
        };
        let plan = |feed: f64| Plan {
            motion: Motion::Prismatic,
            strokes: vec![0.03; 2],
            feeds: vec![feed; 2],
            dwell_s: 0.1,
            added_mass: None,
        };
        let reference = plan(4.0).references(&machine).swap_remove(0);
        let traces = simulate(&machine, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).unwrap();
        let largest = traces.effort_v.iter().fold(0.0_f64, |most, effort| most.max(effort.abs()));
        let run = recorded("slow", &machine, &reference, traces).unwrap();
        let runs = [Experiment::new(&run, &machine).unwrap()];
        let limit = largest_effort_v(&runs);
        assert!((limit / (3.0 * largest) - 1.0).abs() < 1e-12, "{limit} {largest}");

        let floor = Floor::estimate(&machine, &[&runs[0]]).unwrap();
        let logged = [Signal::ControlEffort, Signal::Position];
        let measure =
            Measure { floor: &floor, deflation: &|_| 1.0, logged: &logged, largest_effort_v: limit };
        let is_planned = |feed: f64| {
            Draft::of(&plan(feed), &machine, &truth, &BTreeMap::new(), &measure).unwrap().is_some()
        };
        // Effort goes with the feed: the loop is linear here.
        assert!(is_planned(4.0) && is_planned(11.9) && !is_planned(12.1));
    }

    /// Where no effort was logged nobody knows what is safe; the joint's own limits hold.
    #[test]
    fn exact_without_effort_there_is_no_limit_of_effort() {
        assert_eq!(largest_effort_v(&[]), f64::INFINITY);
    }
}
