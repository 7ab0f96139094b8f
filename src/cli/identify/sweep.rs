//! `slideway identify sweep`: a transfer function from sines of rising frequency.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;

use clap::{ArgGroup, Args, Parser, ValueEnum};
use slideway::error::{Error, ErrorKind};
use slideway::identify::continuous::{self, Compared, Structure, Weights};
use slideway::identify::excitation::Outcome;
use slideway::identify::stepped_sine::{self, sines};
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal};
use slideway::replay::sine_sweep::SineSweep;
use slideway::report::{html, swept};

use super::super::output::{Pictures, command_line, given};
use super::super::setting::{Setting, set};
use super::super::{Failure, Plant, Screen};
use super::band::Band;

/// Highest over lowest frequency by default: up to a twentieth of the sampling rate.
const BAND_RATIO: f64 = 300.0;
const HIGHEST_SHARE: f64 = 0.02;

/// From a recording with one sine a run, or from a machine's twin whose velocity and position loops are off while sines enter in
/// place of the control effort. Gain from the settled peaks, phase from the fundamental; a transfer function of the asked
/// order is fitted to the points.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("subject").required(true).args(["recording", "machine"]))]
#[command(
    after_help = "Examples:\n  slideway identify sweep --machine models/MACHINE --band 0.2..60rad/s --peak-to-peak 0.2\n  \
                        slideway identify sweep recordings/LOG --poles 2 --zeros 1 --html sweep.html"
)]
pub(in super::super) struct Sweep {
    /// Recording: a folder with recording.toml, or such a file; each run one sine
    recording: Option<PathBuf>,
    /// Machine folder, or a machine file, whose twin is excited
    #[arg(long, value_name = "DIR")]
    machine: Option<PathBuf>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "recording")]
    settings: Vec<Setting>,
    /// Plant to excite
    #[arg(long, value_enum, default_value = "axis", conflicts_with = "recording")]
    plant: Plant,
    /// Band in Hz, or in rad/s with that unit behind it
    #[arg(long, value_name = "F1..F2")]
    band: Option<AnyBand>,
    /// Frequencies of the twin's sweep, evenly over its decades
    #[arg(long, value_name = "N", default_value_t = 30, conflicts_with = "recording")]
    points: usize,
    /// The sines' peak-to-peak control effort in V (of a current command with 1 A/V, in A)
    #[arg(long, value_name = "V", required_unless_present = "recording", conflicts_with = "recording")]
    peak_to_peak: Option<f64>,
    /// Signal that is the input [default: current, where there is one, else control effort]
    #[arg(long, value_name = "SIGNAL")]
    input: Option<String>,
    /// Signal that is the output [default: velocity]
    #[arg(long, value_name = "SIGNAL")]
    output: Option<String>,
    /// Poles of the transfer function
    #[arg(long, value_name = "N", default_value_t = 1)]
    poles: usize,
    /// Zeros of the transfer function
    #[arg(long, value_name = "N", default_value_t = 0)]
    zeros: usize,
    /// Delay of the transfer function in s; `free`: it is found
    #[arg(long, value_name = "S|free", default_value = "free", allow_hyphen_values = true)]
    delay: Delay,
    /// Compare gains only; the delay is then 0 where none is stated
    #[arg(long)]
    gain_only: bool,
    /// What a gain is taken from
    #[arg(long, value_enum, default_value = "peaks")]
    gain: Gain,
    /// How much each point counts
    #[arg(long, value_enum, default_value = "equal")]
    weights: Weight,
    #[command(flatten)]
    pictures: Pictures,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Gain {
    /// Peaks of the settled periods
    Peaks,
    /// The component at the sine's frequency
    Fundamental,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Weight {
    /// A relative error counts the same at every frequency
    Equal,
    /// By each point's own noise
    Noise,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Delay(continuous::Delay);

impl FromStr for Delay {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "free" {
            return Ok(Self(continuous::Delay::Free));
        }
        let number = text.parse::<f64>().ok().filter(|delay| delay.is_finite() && *delay >= 0.0);
        let refused = || format!("`{text}` is no delay; write seconds, 0 or more, or `free`");
        number.map(|delay| Self(continuous::Delay::Known(delay))).ok_or_else(refused)
    }
}

/// A band in Hz, read from Hz or rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
struct AnyBand([f64; 2]);

impl FromStr for AnyBand {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.strip_suffix("rad/s") {
            Some(angular) => angular.parse().map(|Band(ends)| Self(ends.map(|w| w / std::f64::consts::TAU))),
            None => text.parse().map(|Band(ends)| Self(ends)),
        }
    }
}

/// What is looked at.
struct Subject {
    name: String,
    note: Option<String>,
    runs: Vec<Run>,
    machine: Option<Machine>,
}

/// The command by itself, to be given its options from inside the program.
#[derive(Debug, Parser)]
struct Alone {
    #[command(flatten)]
    sweep: Sweep,
}

impl Sweep {
    /// The sweep of a machine's twin over a band, all else as by default; its figures go into a folder.
    ///
    /// # Errors
    /// A band that is none.
    pub(in super::super) fn of_twin(
        machine: &Path,
        band: &str,
        peak_to_peak: f64,
        figures: Option<&Path>,
    ) -> Result<Self, Error> {
        let mut words: Vec<OsString> = vec!["sweep".into(), "--machine".into(), machine.into()];
        words.extend([
            "--band".into(),
            band.into(),
            "--peak-to-peak".into(),
            peak_to_peak.to_string().into(),
        ]);
        words.extend(figures.into_iter().flat_map(|folder| ["--figures".into(), folder.into()]));
        Alone::try_parse_from(words).map(|alone| alone.sweep).map_err(|_| {
            Error::new(ErrorKind::OutOfRange)
                .key("--sweep")
                .found(band)
                .expected("a band of frequencies in Hz or rad/s")
                .remedy("write two frequencies, for instance --sweep 0.2..60rad/s")
        })
    }

    /// Measures, fits, prints.
    pub(in super::super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        self.pictures.check_places(&[], &given([&self.recording, &self.machine]))?;
        let structure = self.structure()?;
        let Subject { name, note, runs, machine } = self.subject(screen)?;
        let runs: Vec<&Run> = runs.iter().collect();
        let first = *runs.first().ok_or_else(|| {
            Error::new(ErrorKind::TooLittleData).key("run").found("no run").expected("runs of one sine each")
        })?;
        let fallback =
            if first.signal(Signal::Current).is_some() { Signal::Current } else { Signal::ControlEffort };
        let input = signal(self.input.as_deref(), "--input", fallback)?;
        let output = signal(self.output.as_deref(), "--output", Signal::Velocity)?;
        let gain = match self.gain {
            Gain::Peaks => stepped_sine::Gain::Peaks,
            Gain::Fundamental => stepped_sine::Gain::Fundamental,
        };
        let mut sines = sines(&runs, input, output, gain)?;
        if let (Some(AnyBand([from, to])), Some(_)) = (self.band, &self.recording) {
            sines.retain(|sine| (from..=to).contains(&sine.point.frequency_hz));
        }
        let points: Vec<_> = sines.iter().map(|sine| sine.point).collect();
        let fit = match continuous::fit(&points, structure)? {
            Outcome::Identified(fit) => fit,
            Outcome::NotExcited(why) => {
                return Err(Error::new(ErrorKind::Undetermined)
                    .key("points")
                    .found(why.to_string())
                    .expected("points that determine every coefficient")
                    .remedy(why.remedy)
                    .into());
            }
        };
        let swept =
            swept::Swept { subject: name, note, motion: first.motion(), input, output, sines, fit, machine };
        let sheet = swept::sheet(&swept);
        write!(screen.out, "{}", sheet.text(super::super::style()))?;
        if self.pictures.are_wanted() {
            self.pictures.write(&html::sheet(&sheet, &command_line()), screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn structure(&self) -> Result<Structure, Error> {
        let delay = match (self.delay.0, self.gain_only) {
            (continuous::Delay::Free, true) => continuous::Delay::Known(0.0),
            (delay, _) => delay,
        };
        Ok(Structure {
            zeros: self.zeros,
            poles: self.poles,
            delay,
            compared: if self.gain_only { Compared::Gain } else { Compared::GainAndPhase },
            weights: if self.weights == Weight::Equal { Weights::Equal } else { Weights::ByNoise },
        })
    }

    fn subject(&self, screen: &Screen) -> Result<Subject, Error> {
        let Some(path) = &self.recording else { return self.twin(screen) };
        let recording = Recording::read(path)?;
        Ok(Subject {
            name: recording.path.display().to_string(),
            note: recording.note.clone(),
            runs: recording.runs().to_vec(),
            // One that the recording names may be elsewhere.
            machine: recording.machine.as_ref().and_then(|place| Machine::read(place).ok()),
        })
    }

    fn twin(&self, screen: &Screen) -> Result<Subject, Error> {
        let machine = Machine::read(&self.machine.clone().unwrap_or_default())?;
        let machine = set(&machine, &self.settings)?;
        let highest = HIGHEST_SHARE / machine.description().sample_period_s;
        let AnyBand(band_hz) = self.band.unwrap_or(AnyBand([highest / BAND_RATIO, highest]));
        let peak_to_peak = self.peak_to_peak.unwrap_or_default();
        let sweep = SineSweep::logarithmic(band_hz, self.points, 0.5 * peak_to_peak)?;
        let bar = screen.progress(self.points as u64, "sines");
        let runs = sweep.runs(&machine, self.plant.into(), |done| bar.set_position(done as u64));
        bar.finish_and_clear();
        let plant: slideway::replay::PlantChoice = self.plant.into();
        let note = format!(
            "simulated, not measured: {} sines of {peak_to_peak} V peak to peak on the {plant}, velocity and position loops off, sensors as stated",
            self.points
        );
        Ok(Subject {
            name: machine.description().name.clone(),
            note: Some(note),
            runs: runs?,
            machine: Some(machine),
        })
    }
}

fn signal(key: Option<&str>, option: &str, fallback: Signal) -> Result<Signal, Error> {
    let Some(key) = key else { return Ok(fallback) };
    Signal::from_key(key).map(|(signal, _)| signal).ok_or_else(|| {
        Error::new(ErrorKind::UnknownKey)
            .key(option)
            .found(format!("`{key}`"))
            .expected(format!("one of {}", Signal::keys(None).join(", ")))
            .remedy("name a signal by its canonical key")
    })
}
