//! A machine that is told what the runs of a recording were told.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use indicatif::ProgressBar;
use rayon::prelude::*;
use slideway::error::Error;
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal};
use slideway::replay::Commands;
use slideway::replay::compared::{DrivenBy, as_set};
use slideway::replay::recording::logged;
use slideway::units::Motion;

use super::super::setting::{lay_over, set};
use super::super::subject::{machine_of, runs_of};
use super::super::table::Table;
use super::super::{Failure, Screen};
use super::{Replay, machine_path};

impl Replay {
    /// Simulates, writes, and shows a table with a row a run.
    pub(super) fn commanded(&self, path: &Path, screen: &mut Screen) -> Result<ExitCode, Failure> {
        // It is there: the parser asks for it where nothing is to be compared.
        let out = self.out.as_deref().unwrap_or(Path::new("."));
        let commands = Recording::read_commands(path)?;
        let machine = machine_of(&commands, self.machine.as_ref())?;
        let stated = set(&machine, &self.settings)?;
        let simulated = lay_over(&stated, &self.hidden, "--hide")?;
        let runs = runs_of(&commands, self.run.as_deref())?;
        let samples: usize = runs.iter().map(|run| run.len()).sum();
        let progress = screen.progress(samples as u64, "simulating");
        let done = runs.par_iter().map(|run| self.run_told(run, &simulated, &progress));
        let done = done.collect::<Result<Vec<_>, Error>>();
        progress.finish_and_clear();
        let done = done.map_err(|error| if error.path().is_some() { error } else { error.file(path) })?;
        let (runs, ways): (Vec<Run>, Vec<DrivenBy>) = done.into_iter().unzip();
        let mut recording = Recording::new(runs)?;
        recording.note = Some(self.note(&stated));
        recording.machine = Some(machine_path(&machine));
        self.write(&recording, out)?;
        self.show_told(&recording, &ways, out, screen)?;
        Ok(ExitCode::SUCCESS)
    }

    fn run_told(
        &self,
        run: &Run,
        simulated: &Machine,
        progress: &ProgressBar,
    ) -> Result<(Run, DrivenBy), Error> {
        let simulated = as_set(run, simulated)?;
        let commands = Commands::of(run, &simulated)?;
        let traces = self.told(&simulated, run.name(), &commands, progress)?;
        let told = commands.signals(run.sample_period_s());
        let mut done = self.logged(logged(run.name(), &simulated, told, traces)?, commands.driven_by)?;
        done.role = run.role;
        done.metadata.clone_from(&run.metadata);
        done.settings = self.settings.iter().map(|s| (s.path.clone(), s.value.clone())).collect();
        done.settings.extend(run.settings.clone());
        Ok((done, commands.driven_by))
    }

    fn show_told(
        &self,
        recording: &Recording,
        ways: &[DrivenBy],
        folder: &Path,
        screen: &mut Screen,
    ) -> Result<(), Failure> {
        let turning = recording.motion() == Motion::Revolute;
        let heads = match turning {
            true => ["run", "moved by", "s", "travel rad", "peak rad/s", "peak effort V"],
            false => ["run", "moved by", "s", "travel mm", "peak mm/s", "peak effort V"],
        };
        let out = &mut screen.out;
        let count = if recording.runs().len() == 1 { "run" } else { "runs" };
        writeln!(out, "{} {count} in {}", recording.runs().len(), folder.display())?;
        writeln!(out, "{}\n", recording.note.as_deref().unwrap_or_default())?;
        let mut table = Table::new(heads).left(2);
        for (run, driven_by) in recording.runs().iter().zip(ways) {
            table.row(row(run, *driven_by, if turning { 1.0 } else { 1e3 }));
        }
        table.write(out)?;
        Ok(())
    }
}

fn row(run: &Run, driven_by: DrivenBy, per_si: f64) -> [String; 6] {
    let ends = |signal: Signal| {
        let samples = run.signal(signal)?;
        let highest = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some([samples.iter().copied().fold(f64::INFINITY, f64::min), highest])
    };
    let shown = |number: Option<f64>| number.map_or_else(|| "-".to_owned(), |number| format!("{number:.3}"));
    let peak = |signal, scale: f64| ends(signal).map(|[low, high]| scale * high.max(-low));
    [
        run.name().to_owned(),
        if driven_by == DrivenBy::Reference { "reference" } else { "effort" }.to_owned(),
        format!("{:.2}", run.duration_s()),
        shown(ends(Signal::Position).map(|[low, high]| per_si * (high - low))),
        shown(peak(Signal::Velocity, per_si)),
        shown(peak(Signal::ControlEffort, 1.0)),
    ]
}
