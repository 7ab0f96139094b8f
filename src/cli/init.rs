//! `slideway init`: from a log to a first recording and machine.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use slideway::error::{Error, ErrorKind};
use slideway::init::{Draft, Item, Logs, Mark, Sheet, check_place, findings, write as write_draft};
use slideway::recording::{LogContext, MappedColumn, Recording};
use slideway::report::wrap;
use slideway::solid::{Movable, Solid, movable_joints};
use slideway::units::Motion;

use super::output::command_line;
use super::table::Table;
use super::{BAD_INPUT, Failure, Screen, style};

/// Sample period that stands in until it is known that no log has a time.
const NO_PERIOD_S: f64 = 1e-3;

/// Estimates from the log what it tells of the axis: control law and gains, velocity estimate, moving mass, friction, winding,
/// delays, noise, each with its interval. What no log tells is taken by flag; all that is missing is listed at once. Writes a
/// recording with the machine in it; for a log that is a recording already, the machine alone.
#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 written, 2 something is missing or wrong, and nothing was written.\n\nExamples:\n  \
                        slideway init log.csv\n  \
                        slideway init log.csv --force-constant 83.1 --mass 44.7 --out my_axis\n  \
                        slideway init recordings/LOG --urdf robot.urdf --joint slide --out models/MACHINE"
)]
pub(super) struct Init {
    /// Logs of one axis, a folder of them, or a recording
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// New folder to write [default: the log's name with _axis; for a recording the machine folder that it names]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// What a column holds, where its header does not tell or is misread; - for nothing; may be given several times
    #[arg(long = "map", value_name = "COLUMN=SIGNAL:UNIT")]
    maps: Vec<MappedColumn>,
    /// The axis slides
    #[arg(long, conflicts_with = "revolute")]
    prismatic: bool,
    /// The axis turns
    #[arg(long)]
    revolute: bool,
    /// Sample period of a log without time, in s
    #[arg(long, value_name = "S", value_parser = positive)]
    sample_period: Option<f64>,
    /// What the machine is called
    #[arg(long)]
    name: Option<String>,
    /// Solid model of the axis; without it one body on one joint is written
    #[arg(long, value_name = "FILE")]
    urdf: Option<PathBuf>,
    /// The driven joint, where the URDF has several that move
    #[arg(long, value_name = "NAME", requires = "urdf")]
    joint: Option<String>,
    /// Moving mass in kg
    #[arg(long, value_name = "KG", value_parser = positive, conflicts_with = "urdf")]
    mass: Option<f64>,
    /// Inertia about the axis in kg·m², all that turns with it
    #[arg(long, value_name = "KG_M2", value_parser = positive, conflicts_with_all = ["urdf", "mass"])]
    inertia: Option<f64>,
    /// Force constant of the motor in N/A (N·m/A for an axis that turns)
    #[arg(long, value_name = "N/A", visible_alias = "torque-constant", value_parser = positive)]
    force_constant: Option<f64>,
    /// Force for one volt of control effort in N/V (N·m/V), where force follows the effort at once
    #[arg(long, value_name = "N/V", visible_alias = "torque-per-volt", value_parser = positive)]
    force_per_volt: Option<f64>,
    /// Resistance of the winding in Ω
    #[arg(long, value_name = "OHM", value_parser = positive)]
    resistance: Option<f64>,
    /// Inductance of the winding in H
    #[arg(long, value_name = "H", value_parser = positive)]
    inductance: Option<f64>,
    /// Limit of the control effort in V
    #[arg(long, value_name = "V", value_parser = positive)]
    voltage_limit: Option<f64>,
    /// Ends of the travel in m, or rad
    #[arg(long, value_name = "FROM..TO", value_parser = ends, allow_hyphen_values = true)]
    stroke: Option<[f64; 2]>,
}

/// Beyond any machine, whatever the unit.
const LARGEST: f64 = 1e9;

fn positive(text: &str) -> Result<f64, String> {
    let number =
        text.parse::<f64>().map_err(|error| format!("{error}; expected a number in the unit of the flag"))?;
    match number > 0.0 && number <= LARGEST {
        true => Ok(number),
        false => Err(format!("expected more than zero, at most {LARGEST:e}")),
    }
}

fn ends(text: &str) -> Result<[f64; 2], String> {
    let expected = "expected FROM..TO, such as -0.05..0.35, the lower end first";
    let (from, to) = text.split_once("..").ok_or(expected)?;
    let [from, to] = [from, to].map(|end| end.trim().parse::<f64>().ok().filter(|end| end.is_finite()));
    match (from, to) {
        (Some(from), Some(to)) if from < to => Ok([from, to]),
        _ => Err(expected.to_owned()),
    }
}

/// What is read.
struct Subject {
    recording: Recording,
    /// Of bare logs.
    logs: Option<Logs>,
    /// Whether the log has times.
    is_timed: bool,
    /// Whether a flag has to say the sample period.
    lacks_period: bool,
}

impl Init {
    /// Estimates, writes and shows.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let solid = self.solid()?;
        let subject = self.read(solid.as_ref().map(|solid| solid.joint.motion))?;
        self.check_motion(subject.recording.motion())?;
        let place = self.place(&subject)?;
        check_place(&place)?;
        let spinner = screen.spinner("estimating");
        let found = findings(&subject.recording, self.voltage_limit);
        spinner.finish_and_clear();
        let found = found.map_err(|error| {
            if error.path().is_some() {
                error
            } else {
                error.file(self.logs.first().map_or(Path::new("."), PathBuf::as_path))
            }
        })?;
        let mut draft = Draft::of(&subject.recording, &found, &self.sheet(), solid.as_ref());
        if subject.lacks_period {
            draft.lacks.insert(0, Draft::period_lack());
        } else if !subject.is_timed {
            draft.state_period();
        }
        let recording = &subject.recording;
        let samples: usize = recording.runs().iter().map(slideway::recording::Run::len).sum();
        let out = &mut screen.out;
        writeln!(
            out,
            "{} run(s), {samples} samples, one every {} s, {} axis",
            recording.runs().len(),
            recording.sample_period_s(),
            recording.motion()
        )?;
        if let Some(note) = recording.note.as_ref().filter(|_| subject.logs.is_some()) {
            wrapped(out, "", note)?;
        }
        writeln!(out)?;
        // Without a time nothing that was estimated means anything.
        if !subject.lacks_period {
            self.show(&draft, screen)?;
        }
        if !draft.lacks.is_empty() {
            self.missing(&draft, screen)?;
            return Ok(ExitCode::from(BAD_INPUT));
        }
        let written = write_draft(&draft, solid.as_ref(), subject.logs.as_ref(), &place)?;
        let names: Vec<String> = written.iter().map(|file| file.display().to_string()).collect();
        wrapped(&mut screen.out, "written  ", &format!("{}: {}", place.display(), names.join(", ")))?;
        let next = match &subject.logs {
            Some(_) => format!("slideway diagnose {}", place.display()),
            None => format!("slideway diagnose {} --machine {}", self.logs[0].display(), place.display()),
        };
        writeln!(screen.out, "next     {next}")?;
        Ok(ExitCode::SUCCESS)
    }

    fn sheet(&self) -> Sheet {
        Sheet {
            name: self.name.clone(),
            urdf: self.urdf.clone(),
            joint: self.joint.clone(),
            mass: self.mass.or(self.inertia),
            force_constant: self.force_constant,
            force_per_volt: self.force_per_volt,
            resistance: self.resistance,
            inductance: self.inductance,
            voltage_limit: self.voltage_limit,
            stroke: self.stroke,
        }
    }

    /// The URDF with its driven joint, where one was named.
    fn solid(&self) -> Result<Option<Solid>, Error> {
        let Some(path) = &self.urdf else { return Ok(None) };
        let joints = movable_joints(path)?;
        if self.joint.is_none() && joints.len() > 1 {
            let listed: Vec<String> =
                joints.iter().map(|Movable { name, kind }| format!("{name} ({kind})")).collect();
            return Err(Error::new(ErrorKind::Missing)
                .file(path)
                .key("--joint")
                .found(format!("{} joints that could be driven: {}", joints.len(), listed.join(", ")))
                .expected("the one that the log is of")
                .remedy(format!(
                    "choose: {}; the others are held at zero",
                    joints
                        .iter()
                        .map(|joint| format!("--joint {}", joint.name))
                        .collect::<Vec<_>>()
                        .join(" or ")
                )));
        }
        Solid::import_with_joint(path, self.joint.as_deref()).map(Some)
    }

    /// The motion that flags say.
    fn motion(&self) -> Option<Motion> {
        match (self.prismatic, self.revolute) {
            (true, _) => Some(Motion::Prismatic),
            (_, true) => Some(Motion::Revolute),
            _ => None,
        }
    }

    /// Reads the logs; where nothing says whether the axis slides or turns, the units of the columns do.
    fn read(&self, of_urdf: Option<Motion>) -> Result<Subject, Error> {
        let is_bare = self.logs.len() > 1 || self.logs.iter().all(|path| Recording::is_bare(path));
        if !is_bare {
            let recording = Recording::read(self.logs.first().map_or(Path::new("."), PathBuf::as_path))?;
            return Ok(Subject { recording, logs: None, is_timed: true, lacks_period: false });
        }
        let by_flag = self.inertia.map(|_| Motion::Revolute).or(self.mass.map(|_| Motion::Prismatic));
        if let Some(motion) = self.motion().or(of_urdf).or(by_flag) {
            return self.read_as(motion);
        }
        match (self.read_as(Motion::Prismatic), self.read_as(Motion::Revolute)) {
            (Ok(subject), Err(_)) | (Err(_), Ok(subject)) => Ok(subject),
            (Err(error), Err(_)) => Err(error),
            (Ok(_), Ok(_)) => Err(Error::new(ErrorKind::Missing)
                .file(&self.logs[0])
                .key("--prismatic")
                .found("columns that do not tell whether the axis slides or turns")
                .expected("--prismatic or --revolute")
                .remedy("give one of the two")),
        }
    }

    fn read_as(&self, motion: Motion) -> Result<Subject, Error> {
        let sample_period_s = self.sample_period.unwrap_or(NO_PERIOD_S);
        let context = LogContext { maps: &self.maps, motion, sample_period_s };
        let recording = Recording::read_logs(&self.logs, &context)?;
        let (outline, files) = Recording::outline_of_logs(&self.logs, &context, "machine")?;
        let is_timed = !outline.contains("\nsample_period_s = ");
        Ok(Subject {
            recording,
            logs: Some(Logs { outline, files }),
            is_timed,
            lacks_period: !is_timed && self.sample_period.is_none(),
        })
    }

    fn check_motion(&self, motion: Motion) -> Result<(), Error> {
        let stated =
            self.motion().or(self.inertia.map(|_| Motion::Revolute)).or(self.mass.map(|_| Motion::Prismatic));
        match stated.filter(|stated| *stated != motion) {
            None => Ok(()),
            Some(stated) => Err(Error::new(ErrorKind::Inconsistent)
                .file(&self.logs[0])
                .found(format!("a {motion} axis, by log or URDF"))
                .expected(format!("a {stated} one, as the flags say"))
                .remedy("an axis that slides has --mass, one that turns has --inertia")),
        }
    }

    /// Where the folder goes.
    fn place(&self, subject: &Subject) -> Result<PathBuf, Error> {
        if let Some(out) = &self.out {
            return Ok(out.clone());
        }
        let first = self.logs.first().map_or(Path::new("log"), PathBuf::as_path);
        if subject.logs.is_some() {
            let stem = first
                .file_stem()
                .map_or_else(|| "log".to_owned(), |stem| stem.to_string_lossy().into_owned());
            return Ok(PathBuf::from(format!("{stem}_axis")));
        }
        subject.recording.machine.clone().ok_or_else(|| {
            Error::new(ErrorKind::Missing)
                .file(first)
                .key("--out")
                .found("a recording that names no machine folder")
                .expected("a folder for the machine")
                .remedy("give --out DIR, and put machine = \"DIR\" at the head of recording.toml")
        })
    }

    /// The numbers with their marks, and what is to be said.
    fn show(&self, draft: &Draft, screen: &mut Screen) -> Result<(), Failure> {
        let out = &mut screen.out;
        numbers(draft).write(out)?;
        if !draft.notes.is_empty() {
            writeln!(out)?;
        }
        for note in &draft.notes {
            wrapped(out, "note     ", note)?;
        }
        let count = |mark: Mark| draft.items.iter().filter(|item| item.mark == mark).count();
        let [measured, assumed, missing] = [Mark::Measured, Mark::Assumed, Mark::Missing].map(count);
        writeln!(out, "\n{measured} measured, {assumed} assumed, {missing} missing")?;
        Ok(())
    }

    /// All that is missing, and the command to copy.
    fn missing(&self, draft: &Draft, screen: &mut Screen) -> Result<(), Failure> {
        let out = &mut screen.out;
        writeln!(out, "\nNothing was written. No log tells these; look them up in the data sheets:")?;
        for lack in &draft.lacks {
            wrapped(out, &format!("  {} {}  ", lack.flag, lack.unit), &lack.why)?;
        }
        let flags: Vec<String> =
            draft.lacks.iter().map(|lack| format!("{} {}", lack.flag, lack.unit)).collect();
        writeln!(out, "\nthen  {} {}", command_line(), flags.join(" "))?;
        Ok(())
    }
}

/// Values longer than this stand among the words.
const LONGEST_VALUE: usize = 26;
/// Columns that the words have at least.
const LEAST_ROOM: usize = 16;

/// The numbers by table of the machine file, as wide as the terminal.
fn numbers(draft: &Draft) -> Table {
    let mut table = Table::of(["number", "value", "", "where from"].map(str::to_owned).to_vec()).left(4);
    let shown = draft.items.iter().filter(|item| !matches!(item.key, "name" | "urdf" | "joint"));
    let items: Vec<&Item> = shown.chain(draft.coulomb.iter()).collect();
    let name = |item: &Item| format!("{}{}", if item.table.is_empty() { "" } else { "  " }, item.key);
    let value =
        |item: &Item| format!("{} {}", item.value.as_deref().unwrap_or("-"), item.unit).trim().to_owned();
    let is_long = |text: &str| text.chars().count() > LONGEST_VALUE;
    let widest =
        |texts: &mut dyn Iterator<Item = String>| texts.map(|text| text.chars().count()).max().unwrap_or(0);
    let names = widest(&mut items.iter().map(|item| name(item)));
    let values = widest(&mut items.iter().map(|item| value(item)).filter(|text| !is_long(text)));
    let marks = Mark::Measured.word().len();
    // Two columns before each of the four.
    let room = style().width.saturating_sub(names + values + marks + 8).max(LEAST_ROOM);
    let mut head = "";
    for item in items {
        if item.table != head {
            head = item.table;
            table.cells(vec![head.to_owned()]);
        }
        let text = value(item);
        let (text, words) = match is_long(&text) {
            true => (String::new(), format!("{text}; {}", item.words)),
            false => (text, item.words.clone()),
        };
        let mut lines = wrap(&words, room).into_iter();
        table.cells(vec![name(item), text, item.mark.word().to_owned(), lines.next().unwrap_or_default()]);
        lines.for_each(|line| table.cells(vec![String::new(), String::new(), String::new(), line]));
    }
    table
}

/// A paragraph with something before its first line.
fn wrapped(out: &mut Vec<u8>, before: &str, text: &str) -> std::io::Result<()> {
    let indent = before.chars().count();
    for (k, line) in wrap(text, style().width.saturating_sub(indent).max(24)).iter().enumerate() {
        let margin = if k == 0 { before.to_owned() } else { " ".repeat(indent) };
        writeln!(out, "{margin}{line}")?;
    }
    Ok(())
}
