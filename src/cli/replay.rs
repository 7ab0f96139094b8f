//! `slideway replay`: strokes or a recording's commands through a machine's twin, written as a recording; or a recording
//! beside the twin.

mod against;
mod commanded;
mod logger;

use std::io::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{ArgGroup, Args, ValueEnum};
use indicatif::ProgressBar;
use rayon::prelude::*;
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::{Existing, Format, Recording, Role, Run, one_after_another};
use slideway::replay::recording::recorded;
use slideway::replay::{
    Cell, Commands, Figures, Motion, PlantChoice, SETTLING_BAND, Stroke, check_samples, planned_reference,
};
use slideway::report::html;
use slideway::units;

use super::count::{count, seed};
use super::output::{Output, Pictures, command_line, given};
use super::setting::{Setting, lay_over, set};
use super::stability::stability;
use super::standstill::standstill;
use super::table::Table;
use super::{Failure, Plant, Screen};

/// Replays every cell in the machine's closed loop. What is known of the machine goes into --set and into the
/// recording; what --hide changes plays the part of a real machine's unmodelled effect: the recording names it
/// in its note only.
///
/// With --recording, replays its runs along their own references under their own settings instead, from where they
/// begin and with perfect sensors, and shows how far each signal of the twin is off.
///
/// With --commands, tells the machine what the runs of a recording were told, whatever was measured in them: their position
/// references in closed loop, or in open loop their efforts.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("told").args(["recording", "commands"]))]
#[command(
    after_help = "Example:\n  slideway replay --machine models/MACHINE --cell 0.02@8 0.03@16 \\\n      \
                        --hide effect.coulomb_friction.force_n=15 --out /tmp/friction\n  \
                        slideway replay --recording recordings/LOG --figures figures\n  \
                        slideway replay --recording recordings/LOG --machine better --beside models/MACHINE\n  \
                        slideway replay --commands recordings/LOG --plant mujoco --bristles 1e-6 --out /tmp/other"
)]
pub(super) struct Replay {
    /// Recording to hold the twin against, instead of cells: a folder with recording.toml, or such a file
    #[arg(long, value_name = "DIR|FILE", conflicts_with_all = STROKES)]
    recording: Option<PathBuf>,
    /// Second machine along the same runs, as it stands in its file: its errors and curves are shown beside the first's
    #[arg(long, value_name = "DIR", requires = "recording")]
    beside: Option<PathBuf>,
    /// Sweep the twin (that of --beside, where one is given) with sines over this band too, as `identify sweep` does
    #[arg(long, value_name = "F1..F2", requires_all = ["recording", "peak_to_peak"])]
    sweep: Option<String>,
    /// The sines' peak-to-peak control effort in V
    #[arg(long, value_name = "V", requires = "sweep")]
    peak_to_peak: Option<f64>,
    /// Recording whose commands the machine is told, instead of cells; its runs need hold nothing measured
    #[arg(long, value_name = "DIR|FILE", conflicts_with_all = NO_COMMANDS)]
    commands: Option<PathBuf>,
    /// Run of the recording; otherwise all
    #[arg(long, value_name = "NAME", requires = "told")]
    run: Option<String>,
    /// Machine folder, or a machine file [default: the one that the recording names]
    #[arg(long, value_name = "DIR", required_unless_present_any = ["recording", "commands"])]
    machine: Option<PathBuf>,
    /// Strokes at feeds: m@m/min, or rad@rad/s for a turning axis; backwards as --cell=-0.02@8
    #[arg(long = "cell", value_name = "STROKE@FEED", num_args = 1.., required_unless_present_any = ["held_out", "recording", "commands"])]
    cells: Vec<Cell>,
    /// Cells to mark as held out; the others are then for training
    #[arg(long, value_name = "STROKE@FEED", num_args = 1..)]
    held_out: Vec<Cell>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    /// Change of the simulated machine that its twin is not told of; may be given several times
    #[arg(long = "hide", value_name = "KEY=VALUE")]
    hidden: Vec<Setting>,
    /// Plant to simulate on
    #[arg(long, value_enum, default_value = "rapier")]
    plant: Plant,
    /// Dry friction of the simulated machine as bristles that deflect by so much (m or rad) before they slide, and a step
    /// of 31.25 µs: another law of the same levels than the twin's
    #[arg(long, value_name = "DEFLECTION", allow_negative_numbers = true, value_parser = deflection)]
    bristles: Option<f64>,
    /// Signals that are logged beside what moves the axis, by key [default: all that a simulation knows]
    #[arg(long, value_name = "SIGNAL,…", value_delimiter = ',')]
    log: Vec<String>,
    /// Seed of the sensor noise, whose size the machine file states
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = seed)]
    noise: u64,
    /// Perfect sensors: no noise, no rounding
    #[arg(long, conflicts_with_all = ["noise", "repeat"])]
    perfect: bool,
    /// Come back with a second stroke
    #[arg(long = "return")]
    back: bool,
    /// Standstill before the first stroke, in s
    #[arg(long, value_name = "S", default_value = "0.1", allow_negative_numbers = true, value_parser = standstill)]
    lead: f64,
    /// Standstill after each stroke, in s
    #[arg(long, value_name = "S", default_value = "0.6", allow_negative_numbers = true, value_parser = standstill)]
    dwell: f64,
    /// Runs of every cell, each with noise of its own
    #[arg(long, value_name = "N", default_value = "1", value_parser = count)]
    repeat: NonZeroUsize,
    /// File format of the runs
    #[arg(long, value_enum, default_value = "csv")]
    format: FileFormat,
    /// Folder to write the replayed runs to, as a recording
    #[arg(long, value_name = "FOLDER", required_unless_present = "recording")]
    out: Option<PathBuf>,
    /// Put it in the place of a recording that is there
    #[arg(long)]
    replace: bool,
    #[command(flatten)]
    pictures: Pictures,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum FileFormat {
    /// Text
    Csv,
    /// Parquet with 64-bit floats
    Parquet,
    /// MCAP with ROS 2 joint states, for Foxglove, rerun and PlotJuggler
    Mcap,
}

/// What tells which strokes to make and how, and has no place where a recording tells it.
const STROKES: [&str; 11] =
    ["cells", "held_out", "hidden", "noise", "perfect", "back", "repeat", "lead", "dwell", "bristles", "log"];
/// What tells which strokes to make or draws them, and has no place where commands tell what to do.
const NO_COMMANDS: [&str; 8] = ["cells", "held_out", "back", "repeat", "lead", "dwell", "html", "figures"];

/// One run before it is simulated.
struct Plan {
    name: String,
    cell: Cell,
    role: Option<Role>,
    motion: Motion,
    reference: Vec<f64>,
    /// When it begins within the session, in s.
    begins_s: f64,
}

/// Below any encoder's step, to a tenth of a stroke.
const DEFLECTIONS: std::ops::RangeInclusive<f64> = 1e-12..=0.1;

fn deflection(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|deflection| DEFLECTIONS.contains(deflection));
    found.ok_or_else(|| "expected a deflection in m or rad from 1e-12 to 0.1".to_owned())
}

impl Replay {
    /// Simulates, writes, and shows a table with a row a run; or compares.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let inputs = given([&self.machine, &self.recording, &self.commands, &self.beside]);
        self.pictures.check_places(&[Output::whole("--out", self.out.as_deref())], &inputs)?;
        if let Some(out) = &self.out {
            Recording::check_place(out, self.existing()).map_err(|error| error.key("--out"))?;
        }
        match (&self.recording, &self.commands) {
            (Some(recording), _) => self.against(recording, screen),
            (None, Some(commands)) => self.commanded(commands, screen),
            (None, None) => self.strokes(screen),
        }
    }

    fn strokes(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        // Both are there: the parser asks for them where no recording is named.
        let [machine, out] = [&self.machine, &self.out].map(|path| path.as_deref().unwrap_or(Path::new(".")));
        let machine = Machine::read(machine)?;
        let stated = set(&machine, &self.settings)?;
        let simulated = lay_over(&stated, &self.hidden, "--hide")?;
        let plans = self.plans(&stated)?;
        write!(screen.out, "{}", stability(&simulated))?;
        let samples: usize = plans.iter().map(|plan| plan.reference.len()).sum();
        let progress = screen.progress(samples as u64, "simulating");
        let done = plans
            .par_iter()
            .map(|plan| self.simulate(&stated, &simulated, plan, &progress))
            .collect::<Result<Vec<_>, Error>>();
        progress.finish_and_clear();
        let (runs, figures): (Vec<Run>, Vec<Figures>) = done?.into_iter().unzip();
        let mut recording = Recording::new(runs)?;
        recording.note = Some(self.note(&stated));
        recording.machine = Some(machine_path(&machine));
        self.write(&recording, out)?;
        let rows = rows(&recording, &plans, &figures);
        self.show(&recording, &rows, out, screen)?;
        if self.pictures.are_wanted() {
            let rows: Vec<Vec<String>> = rows.into_iter().map(|row| row.to_vec()).collect();
            let heads = heads(&recording).map(|head| match head {
                "run" | "role" => head.to_owned(),
                number => format!(">{number}"),
            });
            let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
            let page = html::replayed(&recording, &stated, (&heads, &rows, &counted()), &command_line());
            self.pictures.write(&page, screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn existing(&self) -> Existing {
        if self.replace { Existing::Replace } else { Existing::Refuse }
    }

    fn write(&self, recording: &Recording, out: &Path) -> Result<(), Error> {
        let format = match self.format {
            FileFormat::Csv => Format::Csv,
            FileFormat::Parquet => Format::Parquet,
            FileFormat::Mcap => Format::Mcap,
        };
        recording.write(out, format, self.existing())
    }

    fn plans(&self, machine: &Machine) -> Result<Vec<Plan>, Error> {
        let only_held_out = self.held_out.iter().filter(|cell| !self.cells.contains(*cell));
        let cells: Vec<Cell> = self.cells.iter().chain(only_held_out).copied().collect();
        if let Some((_, twice)) = cells.iter().enumerate().find(|(at, cell)| cells[..*at].contains(*cell)) {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("--cell")
                .found(format!("the cell {} twice", twice.name(machine.motion())))
                .expected("each cell once")
                .remedy("use --repeat for several runs of each cell"));
        }
        for cell in &cells {
            check_samples(
                machine,
                &self.motion(machine, *cell)?,
                self.repeat.get().saturating_mul(cells.len()),
            )
            .map_err(|error| error.key("--cell"))?;
        }
        let mut plans = Vec::new();
        for cell in cells {
            for repeat in 1..=self.repeat.get() {
                plans.push(self.plan(machine, cell, repeat)?);
            }
        }
        let period_s = machine.description().sample_period_s;
        let lengths_s: Vec<f64> = plans.iter().map(|plan| plan.reference.len() as f64 * period_s).collect();
        plans
            .iter_mut()
            .zip(one_after_another(lengths_s))
            .for_each(|(plan, begins_s)| plan.begins_s = begins_s);
        Ok(plans)
    }

    fn motion(&self, machine: &Machine, cell: Cell) -> Result<Motion, Error> {
        let stroke = cell.stroke(machine.motion())?;
        let back = self.back.then_some(Stroke { stroke: -stroke.stroke, feed: stroke.feed });
        Ok(Motion {
            strokes: [stroke].into_iter().chain(back).collect(),
            lead_s: self.lead,
            dwell_s: self.dwell,
            ramp_s: machine.description().reference.acceleration_time_s,
        })
    }

    fn plan(&self, machine: &Machine, cell: Cell, repeat: usize) -> Result<Plan, Error> {
        let name = cell.name(machine.motion());
        let name = if self.repeat.get() > 1 { format!("{name}_run{repeat}") } else { name };
        let role = if self.held_out.contains(&cell) { Role::HeldOut } else { Role::Training };
        let motion = self.motion(machine, cell)?;
        Ok(Plan {
            name,
            cell,
            role: (!self.held_out.is_empty()).then_some(role),
            reference: planned_reference(machine, &motion)?,
            motion,
            begins_s: 0.0,
        })
    }

    fn simulate(
        &self,
        stated: &Machine,
        simulated: &Machine,
        plan: &Plan,
        progress: &ProgressBar,
    ) -> Result<(Run, Figures), Error> {
        let commands = Commands::follow(simulated, &plan.reference)?.beginning(plan.begins_s);
        let traces = self.told(simulated, &plan.name, &commands, progress)?;
        let figures = Figures::of(&plan.motion, stated.description().sample_period_s, &traces);
        let mut run =
            self.logged(recorded(&plan.name, simulated, &plan.reference, traces)?, commands.driven_by)?;
        run.role = plan.role;
        run.metadata = plan.cell.metadata(stated.motion());
        run.settings = self.settings.iter().map(|s| (s.path.clone(), s.value.clone())).collect();
        Ok((run, figures))
    }

    /// Where the data come from, in words.
    fn note(&self, machine: &Machine) -> String {
        let noise = match self.perfect {
            true => "perfect sensors without noise or rounding".to_owned(),
            false => format!("sensor noise and resolution as the machine file states, seed {}", self.noise),
        };
        let hidden = match &self.hidden[..] {
            [] => "nothing hidden".to_owned(),
            hidden => {
                let list: Vec<String> = hidden.iter().map(Setting::to_string).collect();
                format!("hidden: {}", list.join(", "))
            }
        };
        let bristles = self.bristles.map_or(String::new(), |deflection| {
            format!("; dry friction as bristles that slide after {deflection:e} m or rad, steps of 31.25 µs")
        });
        format!(
            "simulated, not measured: slideway {} on the {} of `{}`; {noise}; thrust without a sensor; {hidden}{bristles}",
            env!("CARGO_PKG_VERSION"),
            PlantChoice::from(self.plant),
            machine.description().name,
        )
    }

    fn show(
        &self,
        recording: &Recording,
        rows: &[[String; 8]],
        folder: &Path,
        screen: &mut Screen,
    ) -> Result<(), Failure> {
        let out = &mut screen.out;
        let count = recording.runs().len();
        let runs = if count == 1 { "run" } else { "runs" };
        writeln!(out, "{count} {runs} in {}", folder.display())?;
        writeln!(out, "{}\n", recording.note.as_deref().unwrap_or_default())?;
        let mut table = Table::new(heads(recording)).left(2);
        rows.iter().for_each(|row| table.row(row.clone()));
        table.write(out)?;
        writeln!(out, "\n{}", counted())?;
        Ok(())
    }
}

fn heads(recording: &Recording) -> [&'static str; 8] {
    let force = match recording.motion() {
        units::Motion::Prismatic => "peak thrust N",
        units::Motion::Revolute => "peak torque N·m",
    };
    ["run", "role", "overshoot %", "over feed %", "lowest speed %", force, "peak effort V", "settling ms"]
}

/// How the figures of a run are counted.
fn counted() -> String {
    format!(
        "overshoot in % of the stroke; speeds in % of the feed; settling into ±{:.0} % of the stroke, \
         counted from the end of the commanded motion",
        100.0 * SETTLING_BAND
    )
}

/// A row of figures a run.
fn rows(recording: &Recording, plans: &[Plan], figures: &[Figures]) -> Vec<[String; 8]> {
    let turning = recording.motion() == units::Motion::Revolute;
    let row = |(plan, f): (&Plan, &Figures)| {
        [
            plan.name.clone(),
            plan.role.map_or("-".to_owned(), |role| role.to_string()),
            format!("{:.1}", 100.0 * f.overshoot),
            format!("{:+.1}", 100.0 * f.peak_velocity),
            // No "-0.0": a machine that does not run back has none.
            format!("{:.1}", (1000.0 * f.most_negative_velocity).round() / 10.0 + 0.0),
            if turning { format!("{:.3}", f.peak_thrust) } else { format!("{:.0}", f.peak_thrust) },
            format!("{:.2}", f.peak_effort_v),
            f.settling_s.map_or("not settled".to_owned(), |s| format!("{:.0}", 1000.0 * s)),
        ]
    };
    plans.iter().zip(figures).map(row).collect()
}

/// The machine's folder, or its file where that has a name of its own.
fn machine_path(machine: &Machine) -> PathBuf {
    let file = machine.file();
    match file.parent() {
        Some(folder) if file.file_name().is_some_and(|name| name == "machine.toml") => {
            if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder.to_path_buf() }
        }
        _ => file.to_path_buf(),
    }
}
