//! What the next experiment should show: the chosen explanation and its nearest rival on the proposed motion.

use super::Machines;
use super::events::{Event, events};
use crate::diagnose::Diagnosis;
use crate::diagnose::experiment::Training;
use crate::diagnose::fit::{Care, fit};
use crate::diagnose::hypothesis::{EffectSet, Hypothesis};
use crate::diagnose::motion::screen;
use crate::diagnose::next_experiment::NextExperiment;
use crate::diagnose::noise::Floor;
use crate::diagnose::proposals::Proposals;
use crate::effect::EffectId;
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::{PlantChoice, simulate};
use crate::twin::Sensing;

/// One signal of the proposed motion as two explanations predict it, in SI.
#[derive(Debug, Clone)]
pub struct Predicted {
    /// The signal that tells most.
    pub signal: Signal,
    /// Time from sample to sample in s.
    pub period_s: f64,
    /// The commanded motion.
    pub reference: Vec<f64>,
    /// Its moments.
    pub events: Vec<Event>,
    /// Effects of the chosen explanation and of its rival.
    pub effects: [Vec<String>; 2],
    /// The signal as each predicts it.
    pub traces: [Vec<f64>; 2],
}

impl Predicted {
    /// The prediction; none where nothing is proposed or a replay cannot show it.
    pub(super) fn of(
        machines: &Machines,
        diagnosis: &Diagnosis,
        training: &Training,
        floor: &Floor,
    ) -> Option<Self> {
        let next = diagnosis.next_experiment.as_ref()?;
        let [chosen, rival] = [next.separates.first()?, next.separates.get(1)?];
        let other = rival_machine(&machines.stated, rival, training, floor)?;
        let told = next.signal_to_add.as_ref().or(next.signals.first())?;
        let (signal, _) = Signal::from_key(told)?;
        let reference = next.motion.references(&machines.stated).into_iter().next()?;
        let replay = |machine: &Machine| -> Option<Vec<f64>> {
            let machine = prepared(machine, next, signal)?;
            let traces = simulate(&machine, PlantChoice::Axis, Sensing::Perfect, &reference, |_| ()).ok()?;
            Some(traces.signal(signal)?.to_vec())
        };
        let period_s = machines.stated.description().sample_period_s;
        Some(Self {
            signal,
            period_s,
            events: events(&reference, period_s),
            traces: [replay(&machines.improved)?, replay(&other)?],
            effects: [chosen.clone(), rival.clone()],
            reference,
        })
    }
}

/// The twin with a rival explanation, fitted to the training runs.
fn rival_machine(
    stated: &Machine,
    effects: &[String],
    training: &Training,
    floor: &Floor,
) -> Option<Machine> {
    let set: EffectSet =
        EffectId::ALL.iter().copied().filter(|id| effects.iter().any(|e| e == id.name())).collect();
    let proposals = Proposals::of(&screen(training.runs(), stated).ok()?, set.iter().copied());
    let hypothesis = Hypothesis::new(stated, &set, &proposals, &[])?;
    fit(stated, &hypothesis, training, floor, None, Care::Thorough).ok()?.machine(stated).ok()
}

/// The machine with the mass bolted to it and the sensor added that the plan asks for.
fn prepared(machine: &Machine, next: &NextExperiment, signal: Signal) -> Option<Machine> {
    let mut settings: Vec<(String, f64)> = Vec::new();
    if let Some(mass) = next.motion.added_mass {
        let key = EffectId::Payload.parameters().first()?.key(machine.motion());
        let path = format!("effect.{}.{key}", EffectId::Payload.name());
        settings.push((path.clone(), machine.number(&path).unwrap_or(0.0) + mass));
    }
    if signal == Signal::LoadPosition && machine.description().load_sensor.is_none() {
        let encoder = &machine.description().encoder;
        settings.push(("load_sensor.resolution_m".to_owned(), encoder.resolution_m));
        settings.push(("load_sensor.noise_m".to_owned(), encoder.noise_m));
    }
    machine.with_settings(settings.iter().map(|(path, value)| (path.as_str(), (*value).into()))).ok()
}
