//! A recording's own runs through the machine's twin, and how far each signal is off.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use rayon::prelude::*;
use slideway::error::Error;
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal};
use slideway::replay::recording::{logged, recorded};
use slideway::replay::{Compared, PlantChoice};
use slideway::report::{Comparison, compared, html};

use super::super::identify::sweep::Sweep;
use super::super::output::command_line;
use super::super::setting::set;
use super::super::subject::{machine_of, runs_of};
use super::super::{Failure, Screen, style};
use super::{Replay, machine_path};

impl Replay {
    /// Replays the runs, writes them where that was asked for, and shows a table a run.
    pub(super) fn against(&self, path: &Path, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let recording = Recording::read(path)?;
        let machine = machine_of(&recording, self.machine.as_ref())?;
        let machine = set(&machine, &self.settings)?;
        let beside = match &self.beside {
            Some(path) => Some(machine_of(&recording, Some(path))?),
            None => None,
        };
        let sweep = match (&self.sweep, self.peak_to_peak) {
            (Some(band), Some(peak_to_peak)) => {
                let swept = beside.as_ref().unwrap_or(&machine).file();
                Some(Sweep::of_twin(swept, band, peak_to_peak, self.pictures.figures())?)
            }
            _ => None,
        };
        let runs = runs_of(&recording, self.run.as_deref())?;
        let done = self.replayed(&recording, &runs, &machine, screen)?;
        let others = match &beside {
            Some(other) => Some(self.replayed(&recording, &runs, other, screen)?),
            None => None,
        };
        let plant = PlantChoice::from(self.plant);
        let comparison = Comparison {
            recording: &recording,
            machine: &machine,
            runs: &done,
            beside: beside.as_ref().zip(others.as_deref()),
            plant,
        };
        write!(screen.out, "{}", compared(&comparison, style()))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::compared(&comparison, &command_line()), screen)?;
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
        match sweep {
            Some(sweep) => {
                writeln!(screen.out)?;
                sweep.run(screen)
            }
            None => Ok(ExitCode::SUCCESS),
        }
    }

    /// What a machine makes of the runs.
    fn replayed(
        &self,
        recording: &Recording,
        runs: &[&Run],
        machine: &Machine,
        screen: &Screen,
    ) -> Result<Vec<Compared>, Error> {
        let plant = PlantChoice::from(self.plant);
        let progress = screen.progress(runs.len() as u64, "replaying");
        let one = |run: &&Run| {
            let compared = Compared::of(run, machine, plant);
            progress.inc(1);
            compared
        };
        let done = runs.par_iter().map(one).collect::<Result<Vec<_>, Error>>();
        progress.finish_and_clear();
        done.map_err(|error| if error.path().is_some() { error } else { error.file(&recording.path) })
    }
}

/// The twin's run as a data logger would have made it, with what the recorded one states.
fn twin(one: &Compared, machine: &Machine) -> Result<Run, Error> {
    let told =
        |(signal, samples): (&Signal, &Vec<f64>)| (!signal.is_measured()).then(|| (*signal, samples.clone()));
    let told: BTreeMap<Signal, Vec<f64>> = one.run.signals().iter().filter_map(told).collect();
    let mut run = match told.get(&Signal::PositionReference) {
        Some(reference) => recorded(one.run.name(), machine, reference, one.twin.clone())?,
        None => logged(one.run.name(), machine, told, one.twin.clone())?,
    };
    run.role = one.run.role;
    run.metadata.clone_from(&one.run.metadata);
    run.settings.clone_from(&one.run.settings);
    Ok(run)
}
