//! A late channel and the sentence for it.

use super::{Check, Finding};
use crate::recording::{Run, Signal};
use crate::units::{Motion, engineering};

/// A channel of a run that does not lie where it should.
#[derive(Debug, Clone, PartialEq)]
pub struct Late {
    /// The channel.
    pub signal: Signal,
    /// Samples by which it lies behind (or, where that is said, ahead).
    pub samples: f64,
    /// Behind what.
    pub what: What,
    /// Whether nothing but a late channel can look like this.
    pub is_certain: bool,
}

/// How sure it is that this channel is the late one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum What {
    /// Behind what the control law commands; with whether a slower velocity estimate would look alike.
    Effort { or_velocity_estimate: bool },
    /// The readings, or the reference, behind what the control law acted on; with whether a quicker velocity
    /// estimate would look alike.
    Input { or_velocity_estimate: bool },
    /// Behind the motion that it causes.
    Force,
    /// Behind the stated estimate from the position.
    Velocity,
    /// Ahead of the stated estimate from the position.
    VelocityAhead,
    /// Behind the force that moves it and the velocity, with no effort to ask.
    Position,
    /// Behind the force that moves it, and nothing tells whether the channel or the mechanics is late.
    Undecided,
    /// The effort does not fit the law, and two channels explain it alike.
    EffortOr(Signal),
    /// Behind the sensor of the axis.
    Load,
}

impl Late {
    /// What to say of it.
    pub fn finding(&self, run: &Run) -> Finding {
        let time = engineering(self.samples * run.sample_period_s(), "s");
        let by = format!("{:.1} samples ({time})", self.samples);
        let sentence = self.sentence(&by, run.motion());
        if matches!(self.what, What::Undecided | What::Load) {
            return Finding::note(run.name(), Check::ChannelDelay, sentence);
        }
        Finding::column(run, Check::ChannelDelay, self.signal, self.is_certain, sentence)
    }

    fn sentence(&self, by: &str, motion: Motion) -> String {
        let word = self.signal.word(motion);
        let rows = match self.samples.round() {
            rows if rows <= 1.0 => "one row".to_owned(),
            rows => format!("{rows} rows"),
        };
        let if_alike = |is_alike: bool, text: &'static str| if is_alike { text } else { "" };
        let remedy = format!("Move its column up by {rows}, or log it without the delay.");
        match self.what {
            What::Force => format!(
                "The {word} channel lies {by} behind the motion that it causes: a delay of that channel, not of \
                 the loop. {remedy}"
            ),
            What::Velocity => format!(
                "The velocity channel lies {by} behind the estimate from the position that the machine states: \
                 a delay or a filter of that channel, not of the loop. {remedy}"
            ),
            What::VelocityAhead => format!(
                "The velocity channel lies {by} ahead of the estimate from the position that the machine states: \
                 it is another estimate than the controller's. Correct [encoder] velocity in machine.toml, or take \
                 the column out."
            ),
            What::Input { or_velocity_estimate } => format!(
                "The {word} channel lies {by} behind what the control law acted on: a delay of that channel, \
                 not of the loop{}. {remedy}",
                if_alike(or_velocity_estimate, " (a velocity estimate quicker than stated would look alike)")
            ),
            What::Effort { or_velocity_estimate } => format!(
                "The control effort channel lies {by} behind what the control law commands from the logged \
                 reference and position: a delay of that channel, not of the loop, or a filter of the controller \
                 that machine.toml does not state{}. A late channel: move its column up by {rows}, or log it \
                 without the delay.",
                if_alike(
                    or_velocity_estimate,
                    " (a velocity estimate that much slower than stated would look alike)"
                )
            ),
            What::EffortOr(other) => format!(
                "The control effort channel lies {by} behind what the control law commands from the logged \
                 reference and position, or the {} channel is late: the signals logged do not tell which. It is \
                 no delay of the loop.",
                other.word(motion)
            ),
            What::Position => format!(
                "The position channel lies {by} behind force and velocity alike: a delay of that channel, not \
                 of the loop. {remedy}"
            ),
            What::Undecided => format!(
                "The position lies {by} behind the force that moves it: that channel is late, or something \
                 yields between motor and sensor; without a control effort that fits the law the signals logged \
                 do not tell which."
            ),
            What::Load => format!(
                "The load position lies {by} behind the position: that channel is late, or something yields \
                 between motor and load."
            ),
        }
    }
}
