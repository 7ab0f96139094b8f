//! `slideway identify friction`: what is hard to measure on a machine, from a recording through its twin.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use slideway::error::{Error, ErrorKind};
use slideway::identify::least_squares::Estimate;
use slideway::machine::Machine;
use slideway::recording::{Recording, Run};
use slideway::replay::friction::{Friction, Held, held, identify};
use slideway::units::{Motion, engineering};

use super::super::setting::{Setting, set};
use super::super::subject::{machine_of, runs_of};
use super::super::table::Table;
use super::super::{Failure, Screen};

/// Replays the runs in closed loop on the reduced axis and finds the Coulomb friction of the guide and the acceleration time
/// of the reference generator that suit the measured position and force best, with 95 % intervals. The reference need not
/// be logged where each run states its stroke and feed.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  slideway identify friction recordings/LOG --machine models/MACHINE")]
pub(super) struct FrictionCommand {
    /// Recording: a folder with recording.toml, or such a file
    recording: PathBuf,
    /// Machine folder, or a machine file [default: the one that the recording names]
    #[arg(long, value_name = "DIR|FILE")]
    machine: Option<PathBuf>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    /// Run of the recording; otherwise all runs together
    #[arg(long, value_name = "NAME")]
    run: Option<String>,
    /// Find the viscous coefficient too, instead of taking the machine's [where the machine states none: always]
    #[arg(long)]
    viscous: bool,
}

impl FrictionCommand {
    /// Identifies and prints.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let recording = Recording::read(&self.recording)?;
        let machine = machine_of(&recording, self.machine.as_ref())?;
        let machine = set(&machine, &self.settings)?;
        let runs = runs_of(&recording, self.run.as_deref())?;
        let spinner = screen.spinner("fitting");
        let found = self.identified(&runs, &machine);
        let found = found.and_then(|(found, drag)| Ok((held(&runs, &machine, &found)?, found, drag)));
        spinner.finish_and_clear();
        let (held, found, drag) = found
            .map_err(|error| if error.path().is_some() { error } else { error.file(&recording.path) })?;
        warn(&found, &machine, screen)?;
        show(&found, &recording, &machine, screen)?;
        if let Some(drag) = drag {
            writeln!(screen.out, "{drag}\n")?;
        }
        writeln!(screen.out, "{INTERVALS}\n")?;
        held_constants(&held, machine.motion()).write(&mut screen.out)?;
        Ok(ExitCode::SUCCESS)
    }

    /// The numbers, and what is to be said of viscous drag: a machine that states none has some nevertheless, and what is taken
    /// as 0 would count as dry friction.
    fn identified(
        &self,
        runs: &[&Run],
        machine: &Machine,
    ) -> Result<(Friction, Option<&'static str>), Error> {
        if self.viscous || machine.constants().viscous != 0.0 {
            return Ok((identify(runs, machine, self.viscous)?, None));
        }
        match identify(runs, machine, true) {
            Ok(found) => Ok((found, Some(DRAG_FOUND))),
            Err(error) if error.kind() == ErrorKind::Undetermined => {
                Ok((identify(runs, machine, false)?, Some(DRAG_NOT_TOLD)))
            }
            Err(error) => Err(error),
        }
    }
}

const DRAG_FOUND: &str =
    "the machine states no viscous drag: its coefficient was estimated too; state one to hold it";
const DRAG_NOT_TOLD: &str = "the machine states no viscous drag, and these runs do not tell it from dry friction: it is taken as 0, \
                             and F_c holds what drag there is; record strokes at several feeds";
const INTERVALS: &str = "intervals are of noise; constants are held as stated; at the upper end of its tolerance each would move the \
                         numbers:";

/// What has to be said before the numbers.
fn warn(found: &Friction, machine: &Machine, screen: &mut Screen) -> Result<(), Failure> {
    let out = &mut screen.out;
    if let Some(misfit) = found.misfit.filter(|_| found.is_misfit()) {
        writeln!(
            out,
            "THE TWIN DOES NOT FIT: residuals are {misfit:.1} times what the stated sensor noise makes of them. The numbers lean on a \
             twin that is wrong elsewhere, and their intervals do not hold that error.\n"
        )?;
    }
    let ramps = found.other_ramps(machine.description().sample_period_s);
    if let (Some(run), Some(time)) = (ramps.first(), &found.acceleration_time_s) {
        let count = if ramps.len() == 1 { "1 run".to_owned() } else { format!("{} runs", ramps.len()) };
        writeln!(
            out,
            "THE ACCELERATION TIMES DISAGREE: {} ms from the measured signals, {} ms on the logged reference of {} ({count} so), which \
             lies outside the interval: loop, delay or mass of the twin are not the machine's.\n",
            significant(1e3 * time.value, 4),
            significant(1e3 * run.reference_acceleration_time_s.unwrap_or_default(), 4),
            run.name
        )?;
    }
    Ok(())
}

/// A number to so many significant digits.
fn significant(number: f64, digits: i32) -> String {
    let decade = number.abs().log10().floor();
    if !decade.is_finite() {
        return number.to_string();
    }
    let places = (digits - 1 - decade as i32).max(0) as usize;
    if places > 9 { format!("{number:.*e}", digits as usize - 1) } else { format!("{number:.places$}") }
}

/// A change to three significant digits, with its sign.
fn change(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let sign = if number < 0.0 { "-" } else { "+" };
    format!("{sign}{}", significant(number.abs(), 3))
}

fn show(
    found: &Friction,
    recording: &Recording,
    machine: &Machine,
    screen: &mut Screen,
) -> Result<(), Failure> {
    let out = &mut screen.out;
    let count = found.runs.len();
    let runs = if count == 1 { "1 run".to_owned() } else { format!("{count} runs") };
    writeln!(out, "{}: {runs} through the twin of {}", recording.path.display(), machine.description().name)?;
    if let Some(note) = &recording.note {
        writeln!(out, "{note}")?;
    }
    writeln!(
        out,
        "closed loop on the reduced axis; {} residuals, worth {:.0} independent ones for the friction; condition {:.3}\n",
        found.samples, found.effective_samples, found.condition
    )?;
    numbers(found, machine.motion()).write(out)?;
    writeln!(out)?;
    by_run(found, machine.motion()).write(out)?;
    writeln!(out)?;
    if let Some(force) = found.normal_force_n {
        writeln!(
            out,
            "N = {force:.1} N, the weight on the sliders; a preloaded guide presses harder, and its coefficient is smaller"
        )?;
    }
    Ok(())
}

fn numbers(found: &Friction, motion: Motion) -> Table {
    let mut table = Table::new(["number", "value", "95 % from", "to", "unit"]);
    let mut row = |word: &str, unit: &str, estimate: &Estimate, factor: f64| {
        let Estimate { value, standard_error, ci95: [from, to] } = *estimate;
        // Two digits of the standard error.
        let places = (1.0 - (factor * standard_error).abs().max(1e-12).log10().floor()).clamp(0.0, 9.0);
        let text = |number: f64| format!("{:.1$}", factor * number, places as usize);
        table.row([word.to_owned(), text(value), text(from), text(to), unit.to_owned()]);
    };
    let (force, drag) = match motion {
        Motion::Prismatic => ("N", "N·s/m"),
        Motion::Revolute => ("N·m", "N·m·s/rad"),
    };
    if let Some(time) = &found.acceleration_time_s {
        row("acceleration time, from the measured signals", "ms", time, 1e3);
    }
    row("Coulomb friction F_c", force, &found.coulomb, 1.0);
    if let Some(viscous) = &found.viscous {
        row("viscous coefficient", drag, viscous, 1.0);
    }
    if let Some(coefficient) = &found.coefficient {
        row("friction coefficient F_c/N", "", coefficient, 1.0);
    }
    table
}

fn held_constants(held: &[Held], motion: Motion) -> Table {
    let force = if motion == Motion::Prismatic { "F_c by N" } else { "F_c by N·m" };
    let mut table = Table::new(["constant", "tolerance", force, "acceleration time by ms"]);
    for Held { constant, tolerance, coulomb, acceleration_time_s } in held {
        table.row([
            (*constant).to_owned(),
            format!("+{:.1} %", 100.0 * tolerance),
            change(*coulomb),
            acceleration_time_s.map_or_else(|| "-".to_owned(), |s| change(1e3 * s)),
        ]);
    }
    table
}

fn by_run(found: &Friction, motion: Motion) -> Table {
    let mut table = Table::new(["run", "starts at s", "ramp of the logged reference ms", "twin off by, RMS"]);
    for run in &found.runs {
        let starts: Vec<String> = run.starts_s.iter().map(|start| format!("{start:.5}")).collect();
        let off = run.agreement.iter().map(|a| engineering(a.rms, a.signal.si_unit(motion)));
        table.row([
            run.name.clone(),
            if starts.is_empty() { "as logged".to_owned() } else { starts.join(", ") },
            run.reference_acceleration_time_s.map_or_else(|| "-".to_owned(), |s| format!("{:.4}", 1e3 * s)),
            off.collect::<Vec<_>>().join(", "),
        ]);
    }
    table
}
