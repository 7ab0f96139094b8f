//! A multisine within a machine's limits, written as a run to record.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use slideway::error::{Error, ErrorKind};
use slideway::identify::loop_response::{BAND_KEY, PERIOD_KEY};
use slideway::machine::Machine;
use slideway::recording::Signal;
use slideway::replay::multisine::{Injection, Limits, Multisine, Request, Wave};
use slideway::units::Motion;

use super::super::output;
use super::super::table::Table;
use super::super::{Failure, Screen};
use super::band::Band;
use super::excited::{RESOLUTION_HZ, SHARE};

/// Writes command.csv, to be played to the machine sample by sample, and a recording.toml that names what must be logged. The
/// amplitude is the largest that keeps position, velocity, effort and thrust within the machine's limits, predicted by the
/// linear loop and checked on the twin.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  slideway identify multisine models/MACHINE --band 5..300 --out /tmp/multisine"
)]
pub(super) struct MultisineCommand {
    /// Machine folder, or a machine file
    machine: PathBuf,
    /// Band in Hz
    #[arg(long, value_name = "F1..F2")]
    band: Band,
    /// Folder to write to; it must not be there yet
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Where it enters the loop
    #[arg(long, value_enum, default_value = "voltage")]
    inject: Inject,
    /// Distance of the lines in Hz: one over the period
    #[arg(long, value_name = "HZ", default_value_t = RESOLUTION_HZ, allow_negative_numbers = true)]
    resolution: f64,
    /// Share of the machine's travel, speed, effort and thrust that may be used
    #[arg(long, value_name = "SHARE", default_value_t = SHARE, allow_negative_numbers = true, value_parser = share)]
    share: f64,
    /// Periods to play
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(3..=1000))]
    periods: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Inject {
    /// Added between controller and amplifier: for plant and open loop
    Voltage,
    /// The position reference: for the closed loop
    Reference,
}

fn share(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|share| *share > 0.0 && *share <= 1.0)
        .ok_or_else(|| "expected a share above 0 and up to 1".to_owned())
}

impl MultisineCommand {
    /// Designs, writes, says what to expect.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        if self.out.exists() {
            return Err(Error::new(ErrorKind::Io)
                .file(&self.out)
                .key("--out")
                .found("a file or folder that is there already")
                .expected("a new folder")
                .remedy("name another folder")
                .into());
        }
        let machine = Machine::read(&self.machine)?;
        let injection = match self.inject {
            Inject::Voltage => Injection::Voltage,
            Inject::Reference => Injection::Reference,
        };
        let limits = Limits::of(&machine, self.share);
        let Band(band_hz) = self.band;
        let request =
            Request { band_hz, resolution_hz: self.resolution, injection, wave: Wave::Multisine, limits };
        request.check_length(self.periods as usize, machine.description().sample_period_s)?;
        let design = Multisine::design(&machine, &request)?;
        self.write(&machine, &design)?;
        self.show(&machine, &design, &limits, screen)
    }

    fn signal(&self) -> Signal {
        match self.inject {
            Inject::Voltage => Signal::DisturbanceVoltage,
            Inject::Reference => Signal::PositionReference,
        }
    }

    /// Both files in a folder of a temporary name, which is then renamed.
    fn write(&self, machine: &Machine, design: &Multisine) -> Result<(), Error> {
        let told = |path: &Path, error: &std::io::Error| {
            Error::io(path, error).key("--out").remedy("name a folder in which you may write")
        };
        let parent = self.out.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder =
            tempfile::Builder::new().prefix(".slideway-").tempdir_in(parent).map_err(|e| told(parent, &e))?;
        let mut csv = format!("time_s,{}\n", self.signal().key(machine.motion()));
        for (k, value) in design.command(self.periods as usize).iter().enumerate() {
            let _ = writeln!(csv, "{},{value:e}", rounded(k as f64 * design.sample_period_s));
        }
        output::write(&folder.path().join("command.csv"), &csv)?;
        output::write(&folder.path().join("recording.toml"), &self.template(machine, design))?;
        #[cfg(unix)]
        std::fs::set_permissions(folder.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755))
            .map_err(|e| told(&self.out, &e))?;
        std::fs::rename(folder.path(), &self.out).map_err(|e| told(&self.out, &e))?;
        // It is there under its own name now: nothing is left to be removed.
        let _ = folder.keep();
        Ok(())
    }

    fn template(&self, machine: &Machine, design: &Multisine) -> String {
        let motion = machine.motion();
        let Band([from, to]) = self.band;
        let own = self.signal();
        let wanted = match self.inject {
            Inject::Voltage => vec![Signal::ControlEffort, Signal::Position],
            Inject::Reference => vec![Signal::Position, Signal::ControlEffort],
        };
        let useful = [Signal::Current, Signal::Thrust, Signal::Velocity];
        let list = |signals: &[Signal]| {
            signals
                .iter()
                .map(|s| format!("#   {:<24} {}\n", s.key(motion), s.word(motion)))
                .collect::<String>()
        };
        let place = machine.file().canonicalize().unwrap_or_else(|_| machine.file().to_path_buf());
        format!(
            "# A multisine to be recorded: {from} to {to} Hz, {periods} periods of {period} s.\n\
             # Before it the axis stands under control at {centre} {unit}, the middle of its travel.\n\
             # Play command.csv to the machine, one row a sample period, and log into measured.csv, one row a sample:\n\
             #   {key:<24} the command itself, as it was played\n{compulsory}\
             # Useful besides:\n{more}\
             # Then: slideway identify response THIS_FOLDER --of {of}\n\n\
             machine = {machine}\nsample_period_s = {sample:?}\n\n\
             [[run]]\nfile = \"measured.csv\"\n{PERIOD_KEY} = {period:?}\n{BAND_KEY} = [{from:?}, {to:?}]\n",
            centre = rounded(design.centre),
            unit = if motion == Motion::Prismatic { "m" } else { "rad" },
            periods = self.periods,
            period = rounded(design.duration_s()),
            key = own.key(motion),
            compulsory = list(&wanted),
            more = list(&useful),
            of = if self.inject == Inject::Voltage { "open-loop" } else { "closed-loop" },
            machine = toml::Value::String(place.display().to_string()),
            sample = design.sample_period_s,
        )
    }

    fn show(
        &self,
        machine: &Machine,
        design: &Multisine,
        limits: &Limits,
        screen: &mut Screen,
    ) -> Result<ExitCode, Failure> {
        let turning = machine.motion() == Motion::Revolute;
        let out = &mut screen.out;
        let frequencies = design.frequencies_hz();
        let ends = [frequencies.first(), frequencies.last()].map(|f| f.copied().unwrap_or_default());
        let [largest, unit] =
            [design.peak(), if self.inject == Inject::Voltage || turning { 1.0 } else { 1e3 }];
        let word = match (self.inject, turning) {
            (Inject::Voltage, _) => "V",
            (Inject::Reference, true) => "rad",
            (Inject::Reference, false) => "mm",
        };
        writeln!(
            out,
            "{}: {} lines from {} to {} Hz, {} periods of {} s in {}",
            machine.description().name,
            frequencies.len(),
            rounded(ends[0]),
            rounded(ends[1]),
            self.periods,
            rounded(design.duration_s()),
            self.out.display()
        )?;
        let allowed = limits.injected_v.filter(|_| self.inject == Inject::Voltage);
        let allowed = allowed.map_or(String::new(), |limit| format!(" of {limit:.4} V allowed"));
        let crest = design.crest_factor();
        writeln!(out, "peak {:.4} {word}{allowed}, crest factor {crest:.2}", largest * unit)?;
        let place = rounded(design.centre);
        let length = if turning { "rad" } else { "m" };
        writeln!(out, "the axis stands at {place} {length} before it, the middle of its travel\n")?;
        let (p, s) = (design.predicted, design.simulated);
        let milli = if turning { 1.0 } else { 1e3 };
        let names = match turning {
            true => ["position from there, rad", "velocity, rad/s", "effort, V", "torque, N·m"],
            false => ["position from there, mm", "velocity, mm/s", "effort, V", "thrust, N"],
        };
        let rows = [
            (milli, p.position, s.position, limits.position),
            (milli, p.velocity, s.velocity, limits.velocity),
            (1.0, p.effort_v, s.effort_v, limits.effort_v),
            (1.0, p.thrust, s.thrust, limits.thrust),
        ];
        let mut table = Table::new(["peak", "linear loop, steady", "twin, from standstill", "allowed"]);
        for (name, (unit, predicted, simulated, limit)) in names.iter().zip(rows) {
            let limit = limit.map_or("not limited".to_owned(), |limit| format!("{:.4}", unit * limit));
            table.row([
                (*name).to_owned(),
                format!("{:.4}", unit * predicted),
                format!("{:.4}", unit * simulated),
                limit,
            ]);
        }
        table.write(out)?;
        writeln!(out, "\nrecording.toml in that folder names what to log")?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Without the digits that are rounding.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
