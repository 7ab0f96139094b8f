//! `slideway tune`: numbers of a controller swept and optimised over strokes.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use slideway::error::{Error, ErrorKind};
use slideway::machine::{Machine, TunePlan};
use slideway::replay::Cell;
use slideway::replay::crosscheck::cells_of;
use slideway::report::{Style, html, tuned, tuning_map};
use slideway::tune::{Knob, Limits, Objective, Tuning, Written, WrittenLimit};

use super::output::{Output, Pictures, check_place, command_line, write};
use super::setting::{Setting, set};
use super::standstill::some_standstill;
use super::{Failure, Screen, style};

/// Width that the table of criteria needs.
const WIDTH: usize = 120;
/// Friction to withstand where none is stated, as a share of the peak thrust of the strokes.
const SHARE_OF_THRUST: f64 = 0.1;

/// Replays every setting of a map over all strokes in closed loop, goes on from the best of the map, and re-checks the
/// choice with mass ±20 %, friction, and the base's frequencies ±10 %. Integers stay integers. Settings that keep the
/// limits come first, of these the ones that are on no stroke worse than a mark, then those with the least mean settling
/// time; of settings nearly as good the one that keeps most where the machine is off is chosen.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway tune models/MACHINE --html tune.html\n  \
                        slideway tune models/MACHINE --vary controller.integral=6..65 --vary controller.proportional=100..395:5 \\\n      \
                        --mark 22,220 --cell 0.02@8 0.03@16 --limit position_overshoot_percent=0.2")]
pub(super) struct Tune {
    /// Machine folder, or a machine file; also one that `diagnose --write-machine` saved
    machine: PathBuf,
    /// Number of the controller to vary and its range, as KEY=FROM..TO or KEY=FROM..TO:STEP; several times
    /// [default: those of the machine file's table [tune], otherwise the gains that are turned first]
    #[arg(long, value_name = "KEY=RANGE")]
    vary: Vec<Written>,
    /// Setting to be beaten, numbers in the order of --vary with commas between: 22,220; several times
    #[arg(long = "mark", value_name = "N,N")]
    marks: Vec<String>,
    /// Strokes at feeds: m@m/min, or rad@rad/s for a turning axis [default: those of the tables [tune] or
    /// [crosscheck], otherwise four of the axis' own size]
    #[arg(long = "cell", value_name = "STROKE@FEED", num_args = 1..)]
    cells: Vec<Cell>,
    /// Bound on a criterion, with the unit in its name: position_overshoot_percent=0.2; several times
    #[arg(long = "limit", value_name = "KEY=NUMBER")]
    limits: Vec<WrittenLimit>,
    /// What is made small among settings that keep the limits
    #[arg(long, value_enum, default_value = "settling-time")]
    minimise: Least,
    /// Largest Coulomb friction of the re-check, N or N·m [default: that of the table [tune], otherwise 10 % of
    /// the strokes' peak thrust]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = friction)]
    friction: Option<f64>,
    /// Standstill after each stroke, in s
    #[arg(long, value_name = "S", default_value = "0.6", allow_negative_numbers = true, value_parser = some_standstill)]
    dwell: f64,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    /// Write every setting of the map with its criteria, worst of all strokes, as CSV
    #[arg(long = "map", value_name = "FILE")]
    map_file: Option<PathBuf>,
    #[command(flatten)]
    pictures: Pictures,
}

/// More no axis has, N or N·m.
const MOST_FRICTION: f64 = 1e9;

fn friction(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| (0.0..=MOST_FRICTION).contains(number));
    number.ok_or_else(|| format!("expected a force from 0 to {MOST_FRICTION:e}"))
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Least {
    /// Mean settling time
    SettlingTime,
    /// Mean of the largest following errors
    FollowingError,
    /// Mean peak thrust
    PeakThrust,
}

impl Tune {
    /// Tunes and shows.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let map = Output::file("--map", self.map_file.as_deref());
        self.pictures.check_places(&[map], &[&self.machine])?;
        self.map_file.iter().try_for_each(|file| check_new(file))?;
        let machine = Machine::read(&self.machine)?;
        let machine = set(&machine, &self.settings)?;
        let tuning = self.tuning(&machine)?;
        let progress = screen.progress(tuning.least_settings() as u64, "replaying settings");
        let outcome = tuning.run(&machine, |settings| progress.inc(settings as u64));
        progress.finish_and_clear();
        let outcome = outcome?;
        if let Some(file) = &self.map_file {
            write(file, &tuning_map(&machine, &tuning, &outcome))?;
        }
        let sheet = tuned(&machine, &tuning, &outcome);
        let style = style();
        write!(screen.out, "{}", sheet.text(Style { width: style.width.max(WIDTH), ..style }))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::sheet(&sheet, &command_line()), screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// What is asked here, else what the machine file says, else what is usual.
    fn tuning(&self, machine: &Machine) -> Result<Tuning, Error> {
        let stated = machine.description().tune.clone().unwrap_or_default();
        let in_file = |error: Error| error.file(machine.file());
        let mut limits = Limits::usual(machine);
        for (key, bound) in &stated.limits {
            let named = |error: Error| in_file(error.key(format!("tune.limits.{key}")));
            limits.set(machine.motion(), key, *bound).map_err(named)?;
        }
        for limit in &self.limits {
            let named = |error: Error| error.key(format!("--limit {}", limit.key));
            limits.set(machine.motion(), &limit.key, limit.bound).map_err(named)?;
        }
        let (knobs, marks) = self.knobs(machine, &stated)?;
        let mut tuning = Tuning {
            knobs,
            cells: self.cells(machine, &stated)?,
            dwell_s: self.dwell,
            limits,
            objective: match self.minimise {
                Least::SettlingTime => Objective::SettlingTime,
                Least::FollowingError => Objective::FollowingError,
                Least::PeakThrust => Objective::PeakThrust,
            },
            marks,
            friction: 0.0,
        };
        tuning.friction = match self.friction.or(stated.friction_n) {
            Some(friction) => friction,
            None => SHARE_OF_THRUST * tuning.peak_thrust(machine)?,
        };
        Ok(tuning)
    }

    fn cells(&self, machine: &Machine, stated: &TunePlan) -> Result<Vec<Cell>, Error> {
        if !self.cells.is_empty() {
            return Ok(self.cells.clone());
        }
        if stated.cells.is_empty() {
            return cells_of(machine);
        }
        stated.cells.iter().map(|cell| cell.parse::<Cell>().map_err(|e| e.file(machine.file()))).collect()
    }

    /// What is turned; marks of the file only where its own numbers are turned.
    fn knobs(&self, machine: &Machine, stated: &TunePlan) -> Result<(Vec<Knob>, Vec<Vec<f64>>), Error> {
        let mut marks = self.marks.iter().map(|text| mark(text)).collect::<Result<Vec<_>, _>>()?;
        if !self.vary.is_empty() {
            let knob = |w: &Written| {
                Knob::new(machine, &w.key, w.range, w.step)
                    .map_err(|error| error.typed(format!("--vary {}", w.key)))
            };
            return Ok((self.vary.iter().map(knob).collect::<Result<_, _>>()?, marks));
        }
        if stated.vary.is_empty() {
            return Ok((Knob::usual(machine)?, marks));
        }
        marks.extend(stated.marks.iter().filter(|mark| !marks.contains(mark)).cloned().collect::<Vec<_>>());
        let knobs = stated.vary.iter().map(|v| Knob::new(machine, &v.key, [v.from, v.to], v.step));
        Ok((knobs.collect::<Result<_, _>>()?, marks))
    }
}

/// Refuses a place that cannot be written, or a file that is there already: it may be a log.
fn check_new(file: &Path) -> Result<(), Error> {
    check_place(file, "--map")?;
    if !file.exists() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Io)
        .file(file)
        .key("--map")
        .found("a file that is there already")
        .expected("a new file")
        .remedy("name another file, or delete it first"))
}

fn mark(text: &str) -> Result<Vec<f64>, Error> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|number| number.trim().parse::<f64>()).collect();
    numbers.ok().filter(|numbers| numbers.iter().all(|x| x.is_finite())).ok_or_else(|| {
        Error::new(ErrorKind::Syntax)
            .key("--mark")
            .found(format!("`{text}`"))
            .expected("numbers with commas between")
            .remedy("write them in the order of --vary, as in --mark 22,220")
    })
}
