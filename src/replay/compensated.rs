//! Replay of a recorded run with a feed-forward in the place of its own.

use super::feedforward::Course;
use super::{Feedforward, Recorded, Traces};
use crate::machine::Machine;
use crate::plant::Plant;
use crate::twin::{Command, Sensing};

/// A replay with a feed-forward: the traces, and what was fed forward beside the effort.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// What the replay yields; the effort is what the controller's feedback was left to command.
    pub traces: Traces,
    /// What was fed forward in V, a number a sample.
    pub feedforward_v: Vec<f64>,
}

impl Compensated {
    /// The voltage commanded to the amplifier, in V.
    pub fn whole_v(&self) -> Vec<f64> {
        self.traces.effort_v.iter().zip(&self.feedforward_v).map(|(own, forward)| own + forward).collect()
    }
}

impl Feedforward {
    /// Replays a recorded run in closed loop on a plant, with this feed-forward in the place of the one that it states.
    pub fn replay<P: Plant>(
        &self,
        recorded: &Recorded,
        machine: &Machine,
        plant: P,
        sensing: Sensing,
    ) -> Compensated {
        let commands = recorded.commands();
        let course = Course::of(*self, commands, machine);
        let mut measured = recorded.start().velocity;
        let mut twin = recorded.twin_fed(machine, plant, sensing, course.voltage(0, measured));
        let mut traces = Traces::with_capacity(commands.len());
        let mut fed_v = Vec::with_capacity(commands.len());
        for (k, &command) in commands.iter().enumerate() {
            let feedforward_v = course.voltage(k, measured);
            let sample = twin.step(Command { feedforward_v, ..command });
            measured = sample.velocity;
            traces.push(sample);
            fed_v.push(feedforward_v);
        }
        Compensated { traces, feedforward_v: fed_v }
    }
}
