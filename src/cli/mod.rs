//! The commands, one a file, and what they share: where they write, how they refuse, how they end.
//!
//! Exit codes: 0 done, 2 bad input. A command may return another one of its own.

mod count;
mod crosscheck;
mod diagnose;
mod effects;
mod fold;
mod identify;
mod init;
mod inspect;
mod kinds;
mod ladder;
mod output;
mod refusal;
mod replay;
mod schema;
mod setting;
mod shell;
mod signals;
mod stability;
mod standstill;
mod subject;
mod table;
mod trial;
mod tune;

use std::io::{self, IsTerminal as _, Write};
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use slideway::diagnose::Progress;
use slideway::error::Error;
use slideway::replay::PlantChoice;
use slideway::report::Style;

/// Exit code of every refusal.
const BAD_INPUT: u8 = 2;

/// Time between two pictures of a spinner.
const SPINNER_STEP: Duration = Duration::from_millis(120);

/// Columns of the report where neither the environment variable COLUMNS nor a terminal tells.
const COLUMNS: usize = 88;
/// Lines longer than this nobody reads.
const MOST_COLUMNS: usize = 200;
/// Narrower lines are not folded further.
const LEAST_COLUMNS: usize = 40;

/// A multibody twin of a servo-driven machine axis that says why the real machine disagrees with it.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
pub struct Arguments {
    /// Only errors: no tables, no progress bar
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Folder that machines and recordings may name files in, besides their own; may be given several times
    #[arg(long, global = true, value_name = "DIR")]
    allow_outside: Vec<std::path::PathBuf>,
    #[command(subcommand)]
    command: Command,
}

/// A new command is a file here, a line in this list and one in [`dispatch`].
#[derive(Debug, Subcommand)]
enum Command {
    /// Say where a recording and the machine's twin disagree, and why
    Diagnose(diagnose::Diagnose),
    /// Begin with a log of your own axis: estimate what it tells, write a recording and a machine
    Init(init::Init),
    /// Replay strokes, or a recording, through a machine's twin
    Replay(replay::Replay),
    /// Identify a sampled transfer function, from a machine's solid model or from a recording
    Identify(identify::Identify),
    /// Hold the plants against each other: the same strokes on axis, rigid-body scene and MuJoCo
    Crosscheck(crosscheck::CrosscheckCommand),
    /// Feed a motion forward term by term: what each leaves to the feedback, predicted and measured
    Ladder(ladder::LadderCommand),
    /// List the effects that a diagnosis looks for, or tell what one of them is
    Effects(effects::Effects),
    /// List the signals that a recording may hold, or tell what one of them is
    Signals(signals::Signals),
    /// List the tables of a machine file and their kinds, or the keys of one
    Kinds(kinds::Kinds),
    /// Print the JSON Schema of machine.toml or recording.toml, for editors
    Schema(schema::Schema),
    /// Show what is in a recording or a machine
    Inspect(inspect::Inspect),
    /// Tune a controller in simulation: sweep, optimise, re-check where the machine is off
    Tune(tune::Tune),
    /// Check the diagnosis on machines whose effect is withheld
    Trial(trial::Trial),
    /// Print the completions of a shell
    Completions(shell::Completions),
    /// Print the manual page
    Man(shell::Man),
}

/// How a command ends when it does not end well.
pub enum Failure {
    /// Bad input.
    Refused(Box<Error>),
    /// Standard output does not take any more.
    Output(io::Error),
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Refused(Box::new(error))
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

/// Where a command writes its tables, and whether it may show how far it is.
pub struct Screen {
    /// Shown when the command has come to its end: a refusal stands alone.
    out: Vec<u8>,
    /// Files and folders that were written, named below the tables.
    written: Vec<std::path::PathBuf>,
    quiet: bool,
}

impl Screen {
    /// A progress bar on standard error; nothing where that is no terminal or `--quiet` was given.
    fn progress(&self, total: u64, what: &'static str) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(total).with_message(what);
        if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %  {eta}") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar
    }

    /// The hypotheses of a diagnosis: those fitted, of those asked for so far.
    fn hypotheses(&self) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new(0);
        if let Ok(style) =
            ProgressStyle::with_template("hypotheses [{bar:24}] {pos} of {len} so far, {elapsed}  {wide_msg}")
        {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(SPINNER_STEP);
        bar
    }

    /// Work whose end is not known, counted on standard error; nothing where that is no terminal or `--quiet`
    /// was given.
    fn spinner(&self, what: &'static str) -> ProgressBar {
        if self.quiet {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::new_spinner().with_prefix(what);
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {prefix} ({pos} done, {elapsed})  {wide_msg}")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(SPINNER_STEP);
        bar
    }
}

/// Runs a command to its exit code; what went wrong is told on standard error.
pub fn run(arguments: &Arguments) -> ExitCode {
    let quiet = arguments.quiet;
    slideway::confine::allow(arguments.allow_outside.clone());
    let mut screen = Screen { out: Vec::new(), written: Vec::new(), quiet };
    let ended = dispatch(&arguments.command, &mut screen).and_then(|code| {
        if !quiet {
            if !screen.written.is_empty() {
                let names: Vec<String> =
                    screen.written.iter().map(|path| path.display().to_string()).collect();
                writeln!(screen.out, "\nWritten: {}", names.join(", "))?;
            }
            let mut stdout = io::stdout().lock();
            let out = std::mem::take(&mut screen.out);
            stdout.write_all(&shown(&set(&arguments.command, out)))?;
            stdout.flush()?;
        }
        Ok(code)
    });
    match ended {
        Ok(code) => code,
        // The reader of a pipe has seen enough: `slideway inspect … | head`.
        Err(Failure::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(Failure::Output(error)) => refusal::tell(&Error::io("standard output", &error)),
        Err(Failure::Refused(error)) => refusal::tell(&error),
    }
}

/// The text without control characters, but for ends of lines and the colours that this program sets.
fn shown(out: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(out);
    let mut shown = String::with_capacity(text.len());
    let mut rest = &*text;
    while let Some(letter) = rest.chars().next() {
        let behind = &rest[letter.len_utf8()..];
        if letter == '\u{1b}' {
            let inside = behind
                .strip_prefix('[')
                .map(|codes| codes.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';'));
            if let Some(after) = inside.and_then(|codes| codes.strip_prefix('m')) {
                shown += &rest[..rest.len() - after.len()];
                rest = after;
                continue;
            }
        }
        if letter.is_control() && letter != '\n' {
            shown.extend(letter.escape_unicode());
        } else {
            shown.push(letter);
        }
        rest = behind;
    }
    shown.into_bytes()
}

/// Moves the bar of a diagnosis.
fn advance(bar: &ProgressBar, progress: Progress) {
    match progress {
        Progress::Asked(more) => bar.inc_length(more as u64),
        Progress::Fitted(effects) => {
            bar.inc(1);
            bar.set_message(effects.to_owned());
        }
    }
}

fn dispatch(command: &Command, screen: &mut Screen) -> Result<ExitCode, Failure> {
    match command {
        Command::Diagnose(diagnose) => diagnose.run(screen),
        Command::Init(init) => init.run(screen),
        Command::Replay(replay) => replay.run(screen),
        Command::Identify(identify) => identify.run(screen),
        Command::Crosscheck(crosscheck) => crosscheck.run(screen),
        Command::Ladder(ladder) => ladder.run(screen),
        Command::Effects(effects) => effects.run(screen),
        Command::Signals(signals) => signals.run(screen),
        Command::Kinds(kinds) => kinds.run(screen),
        Command::Schema(schema) => schema.run(screen),
        Command::Inspect(inspect) => inspect.run(screen),
        Command::Tune(tune) => tune.run(screen),
        Command::Trial(trial) => trial.run(screen),
        Command::Completions(completions) => completions.run(screen),
        Command::Man(man) => man.run(screen),
    }
}

/// How a report is set on this terminal.
fn style() -> Style {
    let colour = io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    Style { colour, width: told_width().unwrap_or(COLUMNS) }
}

/// Columns that the environment or the terminal states; none where the output goes into a file or another program.
fn told_width() -> Option<usize> {
    let told = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    let of_terminal = || terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| usize::from(width.0));
    Some(told.or_else(of_terminal)?.min(MOST_COLUMNS))
}

/// What is shown of a command: lines that fit, but for what other programs read.
fn set(command: &Command, out: Vec<u8>) -> Vec<u8> {
    let is_text = !matches!(
        command,
        Command::Schema(_)
            | Command::Completions(_)
            | Command::Man(_)
            | Command::Kinds(_)
            | Command::Effects(_)
    );
    match (told_width().filter(|_| is_text), String::from_utf8(out)) {
        (Some(width), Ok(text)) => fold::folded(&text, width.max(LEAST_COLUMNS)).into_bytes(),
        (_, text) => text.map_or_else(|error| error.into_bytes(), String::into_bytes),
    }
}

/// The plant to simulate on.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Plant {
    /// The rigid-body scene built from URDF and meshes; knows the slider loads
    Rapier,
    /// The reduced-order axis derived from the solid model; faster
    Axis,
    /// The same URDF and meshes in MuJoCo, where this program was built with that feature
    Mujoco,
}

impl From<Plant> for PlantChoice {
    fn from(plant: Plant) -> Self {
        match plant {
            Plant::Rapier => Self::Rapier,
            Plant::Axis => Self::Axis,
            Plant::Mujoco => Self::Mujoco,
        }
    }
}
