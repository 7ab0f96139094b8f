//! Sampled transfer functions by ARX, from a machine's solid model or from a recording.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{ArgGroup, Args};
use slideway::error::{Error, ErrorKind};
use slideway::identify::arx::{ArxModel, Orders, arx_runs};
use slideway::identify::decimation;
use slideway::identify::excitation::{NotExcited, Outcome};
use slideway::identify::first_order::FirstOrder;
use slideway::identify::frequency_response::{Point, welch};
use slideway::identify::least_squares::Estimate;
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal};
use slideway::replay::PlantChoice;
use slideway::replay::excitation::Excitation;
use slideway::report::sheet::Section;
use slideway::report::{html, printed_equations};
use slideway::units::Motion;

use super::super::count::seed;
use super::super::output::{Pictures, command_line, given};
use super::super::subject::runs_of;
use super::super::table::Table;
use super::super::{Failure, Plant, Screen, style};

/// Frame of a solid modeller's motion study: the first period at which a machine is identified by default.
const MODELLER_FRAME_S: f64 = 0.025;
/// Fit of the one-step prediction from which on residuals are rounding.
const ROUNDING_FIT_PERCENT: f64 = 99.9999;
/// Units of velocity in one SI unit, with which a machine's W(z) is told: mm/s, or rad/s.
const MILLI: f64 = 1000.0;

/// Either a machine's moving part alone (force in, velocity out, on its viscous guide, simulated), or two
/// signals of a recording.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("subject").required(true).args(["recording", "machine"]))]
pub(super) struct Transfer {
    /// Recording: a folder with recording.toml, or such a file
    #[arg(requires_all = ["input", "output"])]
    recording: Option<PathBuf>,
    /// Machine folder: excite its moving part in simulation and identify that
    #[arg(long, value_name = "DIR")]
    machine: Option<PathBuf>,
    /// Input signal, by its column name: thrust_n for instance
    #[arg(long, value_name = "SIGNAL", conflicts_with = "machine")]
    input: Option<String>,
    /// Output signal, by its column name: velocity_m_per_s for instance
    #[arg(long, value_name = "SIGNAL", conflicts_with = "machine")]
    output: Option<String>,
    /// Run of the recording; otherwise all runs together
    #[arg(long, value_name = "NAME", conflicts_with = "machine")]
    run: Option<String>,
    /// Period in s to identify at, several one after the other [default: for a machine 0.025 and the
    /// controller's, for a recording its own]
    #[arg(long = "period", value_name = "S", allow_negative_numbers = true)]
    periods: Vec<f64>,
    /// Coefficients of A(z) behind the leading 1
    #[arg(long, default_value_t = 1)]
    na: usize,
    /// Coefficients of B(z)
    #[arg(long, default_value_t = 1)]
    nb: usize,
    /// Samples by which the input precedes its first effect
    #[arg(long, default_value_t = 1)]
    delay: usize,
    /// Plant to excite
    #[arg(long, value_enum, default_value = "rapier")]
    plant: Plant,
    /// Number of force levels in the excitation
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(10..=1_000_000))]
    samples: u32,
    /// Seed of the excitation
    #[arg(long, default_value_t = 1, value_parser = seed)]
    seed: u64,
    #[command(flatten)]
    pictures: Pictures,
}

impl Transfer {
    /// Identifies and prints.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        self.pictures.check_places(&[], &given([&self.recording, &self.machine]))?;
        let found = match (&self.machine, &self.recording) {
            (Some(machine), _) => Some(self.of_machine(&Machine::read(machine)?, screen)?),
            (None, Some(recording)) => Some(self.of_recording(&Recording::read(recording)?, screen)?),
            (None, None) => None,
        };
        if let (true, Some(found)) = (self.pictures.are_wanted(), found) {
            self.pictures.write(&html::identified(&found, &command_line()), screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn orders(&self) -> Orders {
        Orders { na: self.na, nb: self.nb, delay: self.delay }
    }

    fn of_machine(&self, machine: &Machine, screen: &mut Screen) -> Result<html::Identified, Failure> {
        let own = machine.description().sample_period_s;
        let periods =
            if self.periods.is_empty() { vec![MODELLER_FRAME_S, own] } else { self.periods.clone() };
        let plant = PlantChoice::from(self.plant);
        let (scale, unit) = match machine.motion() {
            Motion::Prismatic => (MILLI, "mm/s per N"),
            Motion::Revolute => (1.0, "rad/s per N·m"),
        };
        let out = &mut screen.out;
        writeln!(out, "{}: moving part alone on the {plant}", machine.description().name)?;
        writeln!(out, "{} random force levels, viscous guide, base rigid; W(z) in {unit}", self.samples)?;
        let (mut models, mut drawn) = (Vec::new(), Vec::new());
        for period_s in periods {
            let excitation = Excitation { period_s, samples: self.samples as usize, seed: self.seed };
            let excited = excitation.run(machine, plant)?;
            let velocity: Vec<f64> = excited.velocity.iter().map(|v| scale * v).collect();
            let outcome = arx_runs(&[(&excited.force, &velocity)], period_s, self.orders())?;
            let model = identified(outcome)?;
            writeln!(out, "\nW(z) at {}", period_text(period_s))?;
            write_model(out, &model)?;
            write_first_order(out, &model, scale, machine.motion())?;
            let title = format!("W(z) at {}", period_text(period_s));
            drawn.push(to_draw(title, &model, &[(&excited.force, &velocity)]));
            models.push(model);
        }
        let equations =
            models.first().map(|model| printed_equations(machine, &model.transfer)).transpose()?;
        let equations: Vec<Section> = equations.flatten().into_iter().collect();
        for section in &equations {
            write!(out, "{}", section.text(style()))?;
        }
        Ok(html::Identified {
            subject: machine.description().name.clone(),
            sentence: format!("The moving part alone on the {plant}: from force to velocity, {unit}."),
            note: None,
            unit: unit.to_owned(),
            motion: machine.motion(),
            sha256: None,
            models: drawn,
            further: equations,
        })
    }

    fn of_recording(&self, recording: &Recording, screen: &mut Screen) -> Result<html::Identified, Failure> {
        let runs = runs_of(recording, self.run.as_deref())?;
        let input = self.input.as_deref().unwrap_or_default();
        let output = self.output.as_deref().unwrap_or_default();
        if input == output {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("--output")
                .found(format!("`{output}`, which is the input too"))
                .expected("another signal, which follows the input")
                .remedy("name the signal that moves the axis as --input, and what it makes of it as --output")
                .into());
        }
        let own = recording.sample_period_s();
        let periods = if self.periods.is_empty() { vec![own] } else { self.periods.clone() };
        let out = &mut screen.out;
        writeln!(out, "{}: {output} from {input}, {} runs", recording.path.display(), runs.len())?;
        let mut drawn = Vec::new();
        for period_s in periods {
            let factor = decimation::factor(own, period_s)?;
            let mut pairs = Vec::with_capacity(runs.len());
            for run in &runs {
                pairs.push(decimation::decimate(samples(run, input)?, samples(run, output)?, factor));
            }
            let pairs: Vec<(&[f64], &[f64])> = pairs.iter().map(|(u, y)| (&u[..], &y[..])).collect();
            let model = identified(arx_runs(&pairs, period_s, self.orders())?)
                .map_err(|error| error.file(&recording.path))?;
            writeln!(out, "\nG(z) at {}", period_text(period_s))?;
            write_model(out, &model)?;
            let signals = [input, output].map(|key| Signal::from_key(key).map(|(signal, _)| signal));
            if signals == [Some(Signal::Thrust), Some(Signal::Velocity)] {
                write_first_order(out, &model, 1.0, recording.motion())?;
            }
            drawn.push(to_draw(format!("G(z) at {}", period_text(period_s)), &model, &pairs));
        }
        let unit = |key: &str| Signal::from_key(key).map_or("1", |(s, _)| s.si_unit(recording.motion()));
        Ok(html::Identified {
            subject: recording.path.display().to_string(),
            sentence: format!("{output} from {input}, {} runs.", runs.len()),
            note: recording.note.clone(),
            unit: format!("{} per {}", unit(output), unit(input)),
            motion: recording.motion(),
            sha256: Some(recording.sha256()),
            models: drawn,
            further: Vec::new(),
        })
    }
}

/// A signal by its canonical name, or an extra column.
fn samples<'a>(run: &'a Run, key: &str) -> Result<&'a [f64], Error> {
    run.require_even("a sampled transfer function")?;
    if let Some(samples) = run.extra_columns().get(key) {
        return Ok(samples);
    }
    match Signal::from_key(key) {
        Some((signal, motion)) if motion.is_none_or(|motion| motion == run.motion()) => {
            if signal == Signal::ControlEffort {
                run.require_whole_effort("a transfer function")?;
            }
            run.require(signal)
        }
        _ => {
            let there = run.signals().keys().map(|signal| signal.key(run.motion()));
            let there: Vec<&str> = there.chain(run.extra_columns().keys().map(String::as_str)).collect();
            Err(Error::new(ErrorKind::Missing)
                .file(&run.file)
                .key(key)
                .found("a name that is not a signal of this run")
                .expected(format!("one of {}", there.join(", ")))
                .remedy("name signals as recording.toml does, with the unit in the name"))
        }
    }
}

/// The model, or the reason why there is none as a refusal.
fn identified(outcome: Outcome<ArxModel>) -> Result<ArxModel, Error> {
    match outcome {
        Outcome::Identified(model) => Ok(model),
        Outcome::NotExcited(NotExcited { condition, weak_direction, remedy }) => {
            let direction: Vec<String> =
                weak_direction.iter().map(|(name, share)| format!("{share:+.2} {name}")).collect();
            Err(Error::new(ErrorKind::Undetermined)
                .key("input")
                .found(format!(
                    "data that do not excite the model (condition {condition:.1e}): {} does not move",
                    direction.join(" ")
                ))
                .expected("an input that keeps changing")
                .remedy(remedy))
        }
    }
}

/// Segments of a frequency response: long enough to resolve, many enough to average.
const SEGMENTS: usize = 8;
const LONGEST_SEGMENT: usize = 1024;

/// A model for the page, beside the frequency response of the longest run.
fn to_draw(title: String, model: &ArxModel, pairs: &[(&[f64], &[f64])]) -> html::Model {
    let period_s = model.transfer.sample_period_s();
    let longest = pairs.iter().max_by_key(|(input, _)| input.len());
    let measured: Vec<Point> = longest
        .and_then(|(input, output)| {
            let length = (input.len() / SEGMENTS).min(LONGEST_SEGMENT);
            welch(input, output, period_s, length).ok()
        })
        .unwrap_or_default();
    let rows = coefficients(model)
        .map(|(name, estimate)| {
            let [from, to] = estimate.ci95;
            vec![name, digits(estimate.value), digits(from), digits(to)]
        })
        .collect();
    html::Model { title, transfer: model.transfer.clone(), rows, fit: fit_text(model), measured }
}

/// Coefficients by name.
fn coefficients(model: &ArxModel) -> impl Iterator<Item = (String, &Estimate)> {
    let delay = model.orders.delay;
    let a = model.a.iter().enumerate().map(|(i, a)| (format!("a{}  (z^-{})", i + 1, i + 1), a));
    let b = model.b.iter().enumerate().map(move |(j, b)| (format!("b{j}  (z^-{})", delay + j), b));
    a.chain(b)
}

/// How well a model fits.
fn fit_text(model: &ArxModel) -> String {
    let percent = |fit: Option<f64>| fit.map_or("-".to_owned(), |fit| format!("{fit:.3} %"));
    format!(
        "fit: one step {}, free run {}; condition {:.3}; {} degrees of freedom",
        percent(model.one_step_fit_percent),
        percent(model.free_run_fit_percent),
        model.condition,
        model.degrees_of_freedom
    )
}

fn period_text(period_s: f64) -> String {
    let (value, unit) = if period_s < 1e-3 { (period_s * 1e6, "µs") } else { (period_s * 1e3, "ms") };
    format!("{} {unit}", (value * 1e6).round() / 1e6)
}

fn write_model(out: &mut dyn Write, model: &ArxModel) -> Result<(), Failure> {
    writeln!(out, "  {}", model.transfer)?;
    let mut table = Table::new(["coefficient", "value", "95 % from", "to"]);
    for (name, estimate) in coefficients(model) {
        estimate_row(&mut table, name, estimate);
    }
    table.write(out)?;
    writeln!(out, "  {}", fit_text(model))?;
    // Without noise the residuals are rounding, which is never white and never matters.
    let is_rounding = model.one_step_fit_percent.is_some_and(|fit| fit > ROUNDING_FIT_PERCENT);
    if !model.whiteness.is_white() && !is_rounding {
        writeln!(out, "  residuals are not white: the intervals are too narrow, the model lacks something")?;
    }
    Ok(())
}

fn estimate_row(table: &mut Table, name: String, estimate: &Estimate) {
    let [from, to] = estimate.ci95;
    table.row([name, digits(estimate.value), digits(from), digits(to)]);
}

/// Six significant digits.
fn digits(value: f64) -> String {
    let scientific = format!("{value:.5e}");
    if value != 0.0 && value.abs() < 1e-3 {
        return scientific;
    }
    scientific.parse::<f64>().unwrap_or(value).to_string()
}

fn write_first_order(
    out: &mut dyn Write,
    model: &ArxModel,
    output_units_per_si: f64,
    motion: Motion,
) -> Result<(), Failure> {
    if (model.a.len(), model.b.len()) != (1, 1) {
        return Ok(());
    }
    let lag = match FirstOrder::of(model, output_units_per_si) {
        Ok(lag) => lag,
        Err(error) => {
            writeln!(out, "  not read as inertia with viscous drag: {}", error.statement())?;
            return Ok(());
        }
    };
    let (mass, drag) = match motion {
        Motion::Prismatic => ("moving mass, kg", "viscous coefficient, N·s/m"),
        Motion::Revolute => ("inertia, kg·m²", "viscous coefficient, N·m·s/rad"),
    };
    let mut table = Table::new(["read as inertia with viscous drag", "value", "95 % from", "to"]);
    estimate_row(&mut table, mass.to_owned(), &lag.inertia);
    estimate_row(&mut table, drag.to_owned(), &lag.viscous_coefficient);
    estimate_row(&mut table, "decay rate, 1/s".to_owned(), &lag.decay_rate_per_s);
    table.write(out)?;
    Ok(())
}
