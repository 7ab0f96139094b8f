//! What the recorded signals can show at all: effects that leave no trace in any replay are left out of the search.

use super::check::{Check, Finding, Severity};
use super::experiment::Experiment;
use crate::effect::{CONTROLLER_GAIN, EffectId, Site};
use crate::machine::Machine;
use crate::recording::Signal;
use crate::replay::windows::Input;
use serde::Serialize;

/// An effect that could not be looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NotExamined {
    /// Effect id.
    pub effect: String,
    /// Why, and what would have to be logged, as a sentence.
    pub reason: String,
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
    if !effect.applies(&machine.constants()) {
        return Some(match effect {
            _ if effect.group() == Some(CONTROLLER_GAIN) && machine.constants().controller.is_none() => {
                "The machine file states no controller."
            }
            _ if effect.group() == Some(CONTROLLER_GAIN) => "The stated control law has no such gain.",
            EffectId::Backlash | EffectId::ScrewError => {
                "Nothing sees the load's end of the drive train: log load_position_m or load_position_rad and state [load_sensor]."
            }
            _ => "The machine, as its file states it, has nothing that this effect could change.",
        });
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
    match effect {
        EffectId::VelocityFilter if logged(Signal::Velocity) => return None,
        EffectId::VelocityFilter | EffectId::EncoderResolution => {
            return Some(
                "It acts through the control loop, which cannot be replayed: state [controller] and log the position reference.",
            );
        }
        EffectId::Cogging => return None,
        _ => {}
    }
    match (effect.site(), input) {
        (Site::Controller, _) => {
            Some("The control loop cannot be replayed: state [controller] and log the position reference.")
        }
        (Site::Amplifier, Input::Current | Input::Thrust) => {
            Some("It acts before the first signal that is known: log the control effort.")
        }
        (Site::Motor, Input::Thrust) if logged(Signal::Current) && acts_behind_current(effect) => None,
        (Site::Motor, Input::Current) if acts_behind_current(effect) => None,
        (Site::Motor, Input::Thrust) if acts_behind_current(effect) => Some(
            "It acts before the first signal that is known: log the motor's current or the control effort.",
        ),
        (Site::Motor, Input::Current | Input::Thrust) => {
            Some("It acts before the first signal that is known: log the control effort.")
        }
        _ => None,
    }
}

/// Whether an effect of the motor lies between its current and its force.
fn acts_behind_current(effect: EffectId) -> bool {
    matches!(effect, EffectId::ForceConstant | EffectId::ForceRipple)
}

/// How the runs are replayed, in words, where it is not in closed loop.
pub fn findings(experiments: &[Experiment]) -> Vec<Finding> {
    let sentence = |experiment: &Experiment| {
        let (run, input) = (experiment.run(), experiment.input()?);
        Some(Finding {
            run: run.name().to_string(),
            check: Check::MissingSignal,
            severity: Severity::Note,
            message: format!(
                "Controller or position reference are not known: replayed in windows, driven by the measured {}, each from the measured state.",
                input.signal().word(run.motion())
            ),
        })
    };
    experiments.iter().filter_map(sentence).collect()
}
