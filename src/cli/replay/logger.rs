//! A simulated machine under commands, and what its logger keeps.

use indicatif::ProgressBar;
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::{Run, Signal};
use slideway::replay::compared::DrivenBy;
use slideway::replay::{Commands, PlantChoice, Traces, commands, run_seed};
use slideway::trial::Engine;
use slideway::trial::laws::Otherwise;
use slideway::twin::Sensing;

use super::Replay;

/// Samples between two moves of the progress bar.
const PROGRESS_STRIDE: usize = 512;
/// Damping ratio of bristles.
const BRISTLE_DAMPING: f64 = 0.7;

impl Replay {
    /// The machine under these commands, its sensors as asked for.
    pub(super) fn told(
        &self,
        machine: &Machine,
        name: &str,
        commands: &Commands,
        progress: &ProgressBar,
    ) -> Result<Traces, Error> {
        let sensing = match self.perfect {
            true => Sensing::Perfect,
            false => Sensing::AsStated { seed: run_seed(self.noise, name) },
        };
        let count = |done: usize| {
            if done.is_multiple_of(PROGRESS_STRIDE) {
                progress.inc(PROGRESS_STRIDE as u64);
            }
        };
        let plant = PlantChoice::from(self.plant);
        let Some(bristle_deflection) = self.bristles else {
            return commands.simulate(machine, plant, sensing, count);
        };
        let engine = match plant {
            PlantChoice::Rapier => Engine::Rapier,
            PlantChoice::Axis => Engine::Axis,
            PlantChoice::Mujoco => Engine::Mujoco,
        };
        let otherwise = Otherwise::bristles(bristle_deflection, BRISTLE_DAMPING);
        engine.told(machine, &otherwise, sensing, commands, commands::STOOD_S, count)
    }

    /// The run with the signals that are to be logged, and with those that move the axis in any case.
    pub(super) fn logged(&self, run: Run, driven_by: DrivenBy) -> Result<Run, Error> {
        if self.log.is_empty() {
            return Ok(run);
        }
        let motion = run.motion();
        let moved_by = match driven_by {
            DrivenBy::Reference => Signal::PositionReference,
            DrivenBy::Effort => Signal::ControlEffort,
        };
        let known = |key: &str| Signal::ALL.into_iter().find(|signal| signal.key(motion) == key);
        if let Some(unknown) = self.log.iter().find(|key| known(key).is_none()) {
            let keys: Vec<&str> = run.signals().keys().map(|signal| signal.key(motion)).collect();
            return Err(Error::new(ErrorKind::Missing)
                .key("--log")
                .found(format!("`{unknown}`"))
                .expected(format!("some of {}", keys.join(", ")))
                .remedy("name signals that the simulated machine has, or leave --log out for all"));
        }
        let is_kept =
            |signal: &Signal| *signal == moved_by || self.log.iter().any(|key| key == signal.key(motion));
        let kept = run.signals().iter().filter(|(signal, _)| is_kept(signal));
        let kept = kept.map(|(signal, samples)| (*signal, samples.clone())).collect();
        Run::new(run.name(), motion, run.sample_period_s(), kept)
    }
}
