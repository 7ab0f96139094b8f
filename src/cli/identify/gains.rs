//! `slideway identify gains`: the gains that a controller ran with.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::controller::regression::{ControllerGains, gain_regression};
use slideway::controller::regressor::Unknown;
use slideway::error::{Error, ErrorKind};
use slideway::identify::excitation::Outcome;
use slideway::recording::Recording;
use slideway::replay::gain_table::GainTable;
use slideway::replay::{PlantChoice, controller_run};
use slideway::report::sheet::Sheet;
use slideway::report::{gain_table, gains, html};

use super::super::count::seed;
use super::super::output::{Pictures, command_line, given};
use super::super::setting::{Setting, set};
use super::super::subject::{machine_of, runs_of};
use super::super::{Failure, Plant, Screen, style};

/// The control law is that of the machine file; its gains are identified from reference, position, velocity and
/// control effort, by linear least squares. What the runs do not excite is refused.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway identify gains recordings/LOG --machine models/MACHINE\n  \
                        slideway identify gains --table models/MACHINE/table.toml")]
pub(in super::super) struct Gains {
    /// Recording: a folder with recording.toml, or such a file
    #[arg(required_unless_present = "table")]
    recording: Option<PathBuf>,
    /// Machine folder or file; otherwise the one that the recording names
    #[arg(long, value_name = "DIR", conflicts_with = "table")]
    machine: Option<PathBuf>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "table")]
    settings: Vec<Setting>,
    /// Run of the recording; otherwise all runs together
    #[arg(long, value_name = "NAME", conflicts_with = "table")]
    run: Option<String>,
    /// Identify the position loop's gain and the velocity feed-forward too
    #[arg(long, conflicts_with = "table")]
    position_loop: bool,
    /// A table of published gains by stroke: replays every stroke with its gains and finds them again
    #[arg(long, value_name = "FILE", conflicts_with = "recording")]
    table: Option<PathBuf>,
    /// Plant on which the table's strokes are replayed
    #[arg(long, value_enum, default_value = "rapier", requires = "table")]
    plant: Plant,
    /// Seed of the sensor noise in the table's strokes
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "table", value_parser = seed)]
    noise: u64,
    #[command(flatten)]
    pictures: Pictures,
}

impl Gains {
    /// Identifies and prints.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        self.pictures.check_places(&[], &given([&self.recording, &self.machine, &self.table]))?;
        let sheet = match (&self.table, &self.recording) {
            (Some(table), _) => self.of_table(&GainTable::read(table)?, screen)?,
            (None, Some(recording)) => self.of_recording(&Recording::read(recording)?)?,
            (None, None) => return Ok(ExitCode::SUCCESS),
        };
        write!(screen.out, "{}", sheet.text(style()))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::sheet(&sheet, &command_line()), screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn of_recording(&self, recording: &Recording) -> Result<Sheet, Error> {
        let machine = machine_of(recording, self.machine.as_ref())?;
        let machine = set(&machine, &self.settings)?;
        let runs = runs_of(recording, self.run.as_deref())?;
        let seen = runs.iter().map(|run| controller_run(&machine, run)).collect::<Result<Vec<_>, _>>()?;
        let unknown = if self.position_loop { Unknown::BothLoops } else { Unknown::VelocityLoop };
        let found = identified(gain_regression(&seen, unknown)?).map_err(|e| e.file(&recording.path))?;
        Ok(gains(&found, &machine, recording, runs.len()))
    }

    fn of_table(&self, table: &GainTable, screen: &Screen) -> Result<Sheet, Error> {
        let machine = table.machine()?;
        let spinner = screen.spinner("replaying strokes");
        let plant = PlantChoice::from(self.plant);
        let recovered = table.recover(&machine, plant, self.noise);
        spinner.finish_and_clear();
        Ok(gain_table(&recovered?, &machine, &plant.to_string(), self.noise))
    }
}

/// The gains, or the reason why there are none as a refusal.
fn identified(outcome: Outcome<ControllerGains>) -> Result<ControllerGains, Error> {
    match outcome {
        Outcome::Identified(gains) => Ok(gains),
        Outcome::NotExcited(why) => Err(Error::new(ErrorKind::Undetermined)
            .key("control_effort_v")
            .found(format!("runs that do not excite the gains (condition {:.1e})", why.condition))
            .expected("motion in which every gain shows in the effort")
            .remedy(why.remedy)),
    }
}
