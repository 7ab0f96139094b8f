//! What the controller had before it at each sample, from the log alone.

use super::experiment::Experiment;
use crate::controller::{Input, ReferenceDelay};
use crate::effect::Constants;
use crate::machine::Machine;
use crate::sensor::{VelocityEstimate, VelocityMemory};
use crate::twin::Command;

/// The controller's inputs along a run: the reference as late as the machine states it, and the stated velocity estimate from the logged position.
pub struct LoggedInput {
    delay: Option<ReferenceDelay>,
    estimate: VelocityEstimate,
    velocity: VelocityMemory,
    period_s: f64,
}

impl LoggedInput {
    /// At the beginning of a run; `constants` are the machine's.
    pub fn of(experiment: &Experiment, machine: &Machine, constants: &Constants) -> Self {
        let (period_s, start) = (experiment.run().sample_period_s(), experiment.recorded().start());
        Self {
            delay: ReferenceDelay::new(machine.description().reference.delay_s, period_s),
            estimate: constants.velocity.clone(),
            velocity: VelocityMemory::moving(start.position, start.velocity, period_s),
            period_s,
        }
    }

    /// The inputs of the next sample: `position` is what the velocity is estimated from, `controlled` what the position loop is closed by.
    pub fn next(&mut self, command: &Command, position: f64, controlled: f64) -> Input {
        let [position_reference, velocity_reference] = match &mut self.delay {
            Some(delay) => delay.pass(command.position_reference, command.velocity_reference),
            None => [command.position_reference, command.velocity_reference],
        };
        let velocity = self.estimate.update(&mut self.velocity, position, self.period_s);
        Input { position_reference, velocity_reference, position: controlled, velocity }
    }
}
