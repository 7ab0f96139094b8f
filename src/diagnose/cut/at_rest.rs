//! The effort at rest: what a control law leaves of it while the reference stands still.

use super::residual::{FORGETTING, controller_residual};
use crate::diagnose::experiment::Experiment;
use crate::diagnose::noise::standstill::settled;
use crate::diagnose::noise::vibration::levelled;
use crate::diagnose::thresholds::ADEQUATE_GAP;
use crate::machine::Machine;
use crate::recording::Signal;

/// Share of the effort that rounding of its computation makes at most.
const ROUNDING: f64 = 1e-9;

/// Sums of squares over all stretches of rest, in V².
#[derive(Debug, Clone, Copy, Default)]
pub struct Rest {
    /// What the law leaves of the effort, about a straight line: the integral part moves the effort along one.
    left: f64,
    /// What it makes of the position, likewise.
    made: f64,
    /// The effort.
    effort: f64,
}

impl Rest {
    /// Adds a run of the machine as it was set in it.
    pub fn add(&mut self, experiment: &Experiment, machine: &Machine) {
        let Some(mut left) = controller_residual(experiment, machine) else { return };
        let Some(effort) = experiment.run().signal(Signal::ControlEffort) else { return };
        // In the unit of the log: a machine whose log is scaled must not scale what is compared.
        let scale = machine.constants().log_scale.effort;
        left.iter_mut().for_each(|sample| *sample *= scale);
        for still in settled(experiment) {
            let from = still.start.max(FORGETTING);
            if from >= still.end {
                continue;
            }
            let left = &left[from - FORGETTING..still.end - FORGETTING];
            let effort = &effort[from..still.end];
            let made: Vec<f64> = effort.iter().zip(left).map(|(effort, left)| effort - left).collect();
            self.left += power(&levelled(left));
            self.made += power(&levelled(&made));
            self.effort += power(effort);
        }
    }

    /// Whether this law leaves more than another one: more than 1.25 times as much, and more than it would make of a log that rounds what the controller
    /// read.
    pub fn leaves_more_than(&self, other: &Self) -> bool {
        let passes_on = if other.made > 0.0 { (self.made / other.made).max(1.0) } else { 1.0 };
        let rounding = ROUNDING * ROUNDING * self.effort;
        self.left > (ADEQUATE_GAP * ADEQUATE_GAP * passes_on * other.left).max(rounding)
    }
}

fn power(samples: &[f64]) -> f64 {
    samples.iter().map(|x| x * x).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever leaves more than rounding leaves more than an exact law; beside one that leaves 1 V, 1.3 V is more and 1.2 V is not, nor is 1.9 V where the
    /// law passes on 1.6 times as much.
    #[test]
    fn exact_a_law_that_leaves_more_at_rest_is_told() {
        let rest = |left: f64, made: f64| Rest { left: left * left, made: made * made, effort: 100.0 };
        let is_more = |one: Rest, other: Rest| one.leaves_more_than(&other);
        assert!(is_more(rest(1e-3, 5.0), rest(0.0, 5.0)) && !is_more(rest(1e-9, 5.0), rest(0.0, 5.0)));
        assert!(is_more(rest(1.3, 5.0), rest(1.0, 5.0)) && !is_more(rest(1.2, 5.0), rest(1.0, 5.0)));
        assert!(!is_more(rest(1.9, 8.0), rest(1.0, 5.0)) && is_more(rest(2.1, 8.0), rest(1.0, 5.0)));
        assert!(!is_more(rest(0.0, 0.0), rest(0.0, 0.0)));
    }
}
