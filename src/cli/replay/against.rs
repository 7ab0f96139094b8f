//! A recording's own runs through the machine's twin, and how far each signal is off.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use rayon::prelude::*;
use slideway::error::Error;
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal};
use slideway::replay::recording::recorded;
use slideway::replay::{Compared, PlantChoice};
use slideway::report::{compared, html};

use super::super::output::command_line;
use super::super::setting::{Setting, lay_over};
use super::super::subject::{machine_of, runs_of};
use super::super::{Failure, Screen, style};
use super::{Replay, machine_path};

impl Replay {
    /// Replays the runs, writes them where that was asked for, and shows a table a run.
    pub(super) fn against(&self, path: &Path, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let recording = Recording::read(path)?;
        let machine = machine_of(&recording, self.machine.as_ref())?;
        let known: Vec<Setting> = self.settings.iter().map(|setting| setting.on_top_of(&machine)).collect();
        let machine = lay_over(&machine, &known, "--set")?;
        let runs = runs_of(&recording, self.run.as_deref())?;
        let plant = PlantChoice::from(self.plant);
        let progress = screen.progress(runs.len() as u64, "replaying");
        let done = runs
            .par_iter()
            .map(|run| {
                let compared = Compared::of(run, &machine, plant);
                progress.inc(1);
                compared
            })
            .collect::<Result<Vec<_>, Error>>();
        progress.finish_and_clear();
        let done =
            done.map_err(|error| if error.path().is_some() { error } else { error.file(&recording.path) })?;
        write!(screen.out, "{}", compared(&recording, &machine, &done, plant, style()))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::compared(&recording, &machine, &done, plant, &command_line()))?;
        }
        if let Some(out) = &self.out {
            let twins = done.iter().map(|one| twin(one, &machine)).collect::<Result<Vec<Run>, Error>>()?;
            let mut written = Recording::new(twins)?;
            written.note = Some(format!(
                "simulated, not measured: slideway {} on the {plant} of `{}`, perfect sensors, along the runs of {}",
                env!("CARGO_PKG_VERSION"),
                machine.description().name,
                recording.path.display()
            ));
            written.machine = Some(machine_path(&machine));
            self.write(&written, out)?;
            writeln!(screen.out, "  the twin's runs are in {}", out.display())?;
        }
        Ok(ExitCode::SUCCESS)
    }
}

/// The twin's run as a data logger would have made it, with what the recorded one states.
fn twin(one: &Compared, machine: &Machine) -> Result<Run, Error> {
    let reference = one.run.require(Signal::PositionReference)?;
    let mut run = recorded(one.run.name(), machine, reference, one.twin.clone())?;
    run.role = one.run.role;
    run.metadata.clone_from(&one.run.metadata);
    run.settings.clone_from(&one.run.settings);
    Ok(run)
}
