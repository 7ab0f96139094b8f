//! `slideway identify`: what a recording or a machine's solid model tells of the axis, one identifier a file.

mod band;
mod excited;
mod friction;
mod gains;
mod multisine;
mod response;
mod settings;
pub(super) mod sweep;
mod transfer;

use std::process::ExitCode;

use clap::{Args, Subcommand};

use super::{Failure, Screen};

/// A transfer function by ARX, or one of the other identifiers by its name.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "Examples:\n  slideway identify --machine models/MACHINE\n  \
                        slideway identify recordings/LOG --input thrust_n --output velocity_m_per_s --period 0.025")]
pub(super) struct Identify {
    #[command(subcommand)]
    kind: Option<Kind>,
    #[command(flatten)]
    transfer: transfer::Transfer,
}

/// A new identifier is a file here, a line in this list and one in [`Identify::run`].
#[derive(Debug, Subcommand)]
enum Kind {
    /// The gains that a controller ran with, from its recorded signals
    Gains(gains::Gains),
    /// Dry friction of the guide and acceleration time of the reference, through the machine's twin
    Friction(friction::FrictionCommand),
    /// Frequency response of plant, open loop and closed loop, margins and modes
    Response(response::Response),
    /// Transfer function of a drive from runs of one sine each, its loops open
    Sweep(Box<sweep::Sweep>),
    /// Write a multisine within the machine's limits as a run to record
    Multisine(multisine::MultisineCommand),
}

impl Identify {
    /// Identifies and prints.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        match &self.kind {
            Some(Kind::Gains(gains)) => gains.run(screen),
            Some(Kind::Friction(friction)) => friction.run(screen),
            Some(Kind::Response(response)) => response.run(screen),
            Some(Kind::Sweep(sweep)) => sweep.run(screen),
            Some(Kind::Multisine(multisine)) => multisine.run(screen),
            None => self.transfer.run(screen),
        }
    }
}
