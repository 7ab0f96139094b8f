//! What the recorded signals can show at all: effects that leave no trace in any replay are left out of the search.

use super::check::{Check, Finding, Severity};
use super::experiment::Experiment;
use crate::effect::{EffectId, Lack, Stretch};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::windows::Input;
use serde::{Deserialize, Serialize};

/// An effect that could not be looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct NotExamined {
    /// Effect id.
    pub effect: String,
    /// Why, and what would have to be logged, as a sentence.
    pub reason: String,
}

impl NotExamined {
    /// Whether the machine could have the effect: it was not looked at for want of a signal, a statement or a plant.
    pub fn could_act(&self) -> bool {
        self.reason != Lack::NothingToChange.sentence()
    }
}

/// A catalogue divided into what a search can look at and what it cannot.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// Effects that leave a trace.
    pub catalogue: Vec<EffectId>,
    /// The others.
    pub not_examined: Vec<NotExamined>,
}

impl View {
    /// What these runs of a machine can show of a catalogue.
    pub fn of(machine: &Machine, experiments: &[Experiment], catalogue: &[EffectId]) -> Self {
        let mut view = Self::default();
        for &effect in catalogue {
            match unseen(effect, machine, experiments) {
                None => view.catalogue.push(effect),
                Some(reason) => {
                    let effect = effect.name().to_string();
                    view.not_examined.push(NotExamined { effect, reason: reason.to_string() });
                }
            }
        }
        view
    }
}

/// Why an effect leaves no trace in any of these runs; none where it does.
pub fn unseen(effect: EffectId, machine: &Machine, experiments: &[Experiment]) -> Option<&'static str> {
    // What another effect has brought (a mode, say) is no part that the machine file states: its description refuses the effect.
    let refused = || effect.lacks(&machine.stated_constants()).filter(|lack| lack.is_refused());
    if let Some(lacking) = effect.lacks(&machine.constants()).or_else(refused) {
        return Some(lacking.sentence());
    }
    let reasons: Option<Vec<&'static str>> =
        experiments.iter().map(|experiment| hidden(effect, experiment)).collect();
    reasons?.first().copied()
}

/// Why an effect leaves no trace in one run; none where it does.
///
/// # Model
/// A replay in closed loop shows everything. One in windows shows what lies between its input and the signals that it
/// is compared with: nothing before the input, and nothing that acts through the loop only.
fn hidden(effect: EffectId, experiment: &Experiment) -> Option<&'static str> {
    let input = experiment.input()?;
    let logged = |signal| experiment.run().signal(signal).is_some();
    match (effect.stretch(), input) {
        (Stretch::Controller, _) => {
            Some("The control loop cannot be replayed: state [controller] and log the position reference.")
        }
        (Stretch::VelocityEstimate, _) if logged(Signal::Velocity) => None,
        (Stretch::VelocityEstimate | Stretch::Rounding, _) => Some(
            "It acts through the control loop, which cannot be replayed: state [controller] and log the position reference.",
        ),
        (Stretch::Drive, Input::Current | Input::Thrust) => {
            Some("It acts before the first signal that is known: log the control effort.")
        }
        (Stretch::MotorForce, Input::Thrust) if !logged(Signal::Current) => Some(
            "It acts before the first signal that is known: log the motor's current or the control effort.",
        ),
        (Stretch::Drive | Stretch::MotorForce | Stretch::Mechanics | Stretch::Log, _) => None,
    }
}

/// How the runs are replayed, in words, where it is not in closed loop.
pub fn findings(experiments: &[Experiment]) -> Vec<Finding> {
    let sentence = |experiment: &Experiment| {
        let (run, input) = (experiment.run(), experiment.input()?);
        Some(Finding {
            run: run.name().to_string(),
            check: Check::MissingSignal,
            severity: Severity::Note,
            signal: None,
            message: format!(
                "Controller or position reference are not known: replayed in windows, driven by the measured {}, each from the measured state.",
                input.signal().word(run.motion())
            ),
        })
    };
    experiments.iter().filter_map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::shipped;

    /// A mode that is stated as an effect is no mode of the base, which could be off its stated value.
    #[test]
    fn exact_a_further_mode_makes_no_base() {
        let is_bare = |machine: &Machine| {
            let constants = machine.constants();
            constants.modes.is_empty() && EffectId::FlexibleMode.applies(&constants)
        };
        let bare = shipped().find(is_bare).unwrap();
        let mode = [("frequency_hz", 40.0), ("mass_kg", 100.0), ("damping_ratio", 0.02)];
        let set = mode.map(|(key, value)| (format!("effect.flexible_mode.{key}"), toml::Value::Float(value)));
        let machine = bare.with_settings(set.iter().map(|(path, v)| (path.as_str(), v.clone()))).unwrap();
        assert!(EffectId::BaseModeShift.applies(&machine.constants()));
        assert!(unseen(EffectId::BaseModeShift, &machine, &[]).is_some());
    }
}
