//! `slideway diagnose`: where a recording and the machine's twin disagree, which effect causes it, how far the
//! gap shrinks.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use slideway::diagnose::decide::Limits;
use slideway::diagnose::{Diagnosis, MOST_SAMPLES, Options, Progress, Verdict, compare, diagnose, improved};
use slideway::effect::EffectId;
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::{Existing, MappedColumn, Recording, Run};
use slideway::report::figure::svg;
use slideway::report::material::Material;
use slideway::report::{html, sentence, terminal};

use super::effects::{Named, named};
use super::output::{Output, Pictures, check_place, command_line, write};
use super::setting::{Setting, lay_over};
use super::subject::{check_motion, machine_of, read};
use super::{Failure, Screen, advance, style};

/// Exit code with `--exit-code` when there is a gap, as `diff` has it.
const GAP_FOUND: u8 = 1;

/// Replays the recorded runs through the machine's twin, locates where they disagree, fits every effect of the
/// catalogue to the training runs and compares them on the held-out runs.
#[derive(Debug, Args)]
#[command(
    after_help = "Exit codes: 0 done, 2 bad input; with --exit-code 1 when there is a gap.\n\nExamples:\n  \
                        slideway diagnose recordings/LOG\n  \
                        slideway diagnose log.csv --machine models/MACHINE --map 'pos_act=position_m:mm'\n  \
                        slideway diagnose recordings/AFTER --reference recordings/BEFORE\n  \
                        slideway diagnose recordings/LOG --machine models/MACHINE --json verdict.json"
)]
pub(super) struct Diagnose {
    /// Recording: a folder with recording.toml, or such a file; or with --machine bare logs: CSV or Parquet files, or a folder of them
    #[arg(required_unless_present = "named", value_name = "RECORDING|LOG")]
    recordings: Vec<PathBuf>,
    /// The recording again, by name: --reference BEFORE --recording AFTER
    #[arg(long = "recording", id = "named", value_name = "DIR|FILE", conflicts_with = "recordings")]
    named: Option<PathBuf>,
    /// What a column of a bare log holds, where its header does not tell or is misread; - for nothing; may be given several times
    #[arg(long = "map", value_name = "COLUMN=SIGNAL:UNIT")]
    maps: Vec<MappedColumn>,
    /// Recording of the same machine before: the causes are then what changed since
    #[arg(long, value_name = "DIR|FILE")]
    reference: Option<PathBuf>,
    /// Machine folder, or a machine file [default: the one that the recording names]
    #[arg(long, value_name = "DIR|FILE")]
    machine: Option<PathBuf>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    /// Effect, or group of effects, that the machine cannot have, struck from the catalogue; may be given several times
    #[arg(long, value_name = "EFFECT", value_parser = named())]
    without: Vec<Named>,
    /// Work on at most about so many samples: of more, the stretches that hold most of the motion
    #[arg(long, value_name = "N", default_value_t = MOST_SAMPLES, value_parser = most_samples)]
    most_samples: usize,
    /// Write the verdict as JSON, schema slideway-diagnosis/1; - for standard output instead of the report
    #[arg(long, value_name = "FILE|-")]
    json: Option<PathBuf>,
    /// Draw where the gap lies and how far it shrinks, as SVG
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    #[command(flatten)]
    pictures: Pictures,
    /// Write the machine with the named causes in it as a folder of its own, with where its values come from
    #[arg(long, value_name = "DIR")]
    write_machine: Option<PathBuf>,
    /// Overwrite a machine that --write-machine wrote before, also where it was changed by hand since
    #[arg(long, requires = "write_machine")]
    replace: bool,
    /// Exit with 1 when there is a gap
    #[arg(long)]
    exit_code: bool,
}

/// Where the JSON goes.
enum Destination<'a> {
    Nowhere,
    Stdout,
    File(&'a Path),
}

impl Diagnose {
    /// Diagnoses, writes the JSON, and shows the report.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let destination = self.destination()?;
        self.figure.iter().try_for_each(|path| check_place(path, "--figure"))?;
        let verdict_file = if let Destination::File(path) = destination { Some(path) } else { None };
        let written = Output::whole("--write-machine", self.write_machine.as_deref());
        let places =
            [Output::file("--json", verdict_file), Output::file("--figure", self.figure.as_deref()), written];
        let named = [&self.named, &self.reference].into_iter().flatten();
        let inputs: Vec<&Path> = self.recordings.iter().chain(named).map(PathBuf::as_path).collect();
        self.pictures.check_places(&places, &inputs)?;
        // A machine that was written before may be written again in its place: `--replace` and its hashes guard it.
        let machine: Vec<&Path> = self.machine.iter().map(PathBuf::as_path).collect();
        self.pictures.check_places(&places[..2], &machine)?;
        self.write_machine.iter().try_for_each(|folder| Machine::check_place(folder, self.existing()))?;
        let named: Vec<PathBuf> = self.named.iter().cloned().collect();
        let paths = if self.recordings.is_empty() { &named } else { &self.recordings };
        let recording = read(paths, self.machine.as_deref(), &self.maps)?;
        let machine = self.machine(&recording)?;
        let before = self.reference.as_ref();
        let before = before.map(|path| read(std::slice::from_ref(path), self.machine.as_deref(), &self.maps));
        let reference = before.transpose()?;
        if let Some(reference) = &reference {
            check_motion(&machine, reference)?;
            check_another(reference, &recording)?;
        }
        let diagnosis = self.diagnose(&machine, reference.as_ref(), &recording, screen)?;
        match destination {
            Destination::Stdout => {
                let mut stdout = io::stdout().lock();
                stdout.write_all(json(&diagnosis)?.as_bytes())?;
                stdout.flush()?;
            }
            Destination::File(path) => {
                write(path, &json(&diagnosis)?)?;
                screen.written.push(path.to_owned());
            }
            Destination::Nowhere => {}
        }
        if let Some(path) = &self.figure {
            write(path, &svg(&diagnosis, &sentence(&diagnosis, machine.motion())))?;
            screen.written.push(path.clone());
        }
        self.draw(&machine, &recording, &diagnosis, screen)?;
        let written = self.write_improved(&diagnosis, &machine)?;
        if matches!(destination, Destination::Stdout) {
            // The JSON stands alone.
            screen.written.clear();
        } else {
            write!(screen.out, "{}{written}", terminal(&diagnosis, machine.motion(), style()))?;
        }
        let is_gap = diagnosis.verdict != Verdict::NoGap;
        Ok(if self.exit_code && is_gap { ExitCode::from(GAP_FOUND) } else { ExitCode::SUCCESS })
    }

    /// Writes the page and its figures where they were asked for.
    fn draw(
        &self,
        machine: &Machine,
        recording: &Recording,
        diagnosis: &Diagnosis,
        screen: &mut Screen,
    ) -> Result<(), Error> {
        if !self.pictures.are_wanted() {
            return Ok(());
        }
        let spinner = screen.spinner("drawing the report");
        let material = Material::of(machine, recording, diagnosis);
        spinner.finish_and_clear();
        self.pictures.write(&html::diagnosis(diagnosis, machine, &material?, &command_line()), screen)
    }

    fn existing(&self) -> Existing {
        if self.replace { Existing::Replace } else { Existing::Refuse }
    }

    /// Writes the improved machine where one was asked for; a sentence about it.
    fn write_improved(&self, diagnosis: &Diagnosis, machine: &Machine) -> Result<String, Error> {
        let Some(folder) = &self.write_machine else { return Ok(String::new()) };
        let place = folder.display();
        Ok(match improved(diagnosis, machine)? {
            Some((better, provenance)) => {
                better.write(folder, provenance, self.existing())?;
                format!("\nImproved machine written to {place}; diagnose again with --machine {place}\n")
            }
            None => format!("\nNo machine written to {place}: there is no decided cause to put into it.\n"),
        })
    }

    /// Where the JSON goes, made sure of before the work begins.
    fn destination(&self) -> Result<Destination<'_>, Error> {
        let Some(path) = &self.json else { return Ok(Destination::Nowhere) };
        if path.as_os_str() == "-" {
            return Ok(Destination::Stdout);
        }
        check_place(path, "--json")?;
        Ok(Destination::File(path))
    }

    /// The machine named here or by the recording, with its settings, and of the recording's motion.
    fn machine(&self, recording: &Recording) -> Result<Machine, Error> {
        let machine = machine_of(recording, self.machine.as_ref())?;
        lay_over(&machine, &self.settings, "--set")
    }

    fn diagnose(
        &self,
        machine: &Machine,
        reference: Option<&Recording>,
        recording: &Recording,
        screen: &Screen,
    ) -> Result<Diagnosis, Error> {
        let is_struck = |effect: &EffectId| self.without.iter().any(|struck| struck.holds(*effect));
        let catalogue: Vec<EffectId> =
            EffectId::ALL.iter().copied().filter(|effect| !is_struck(effect)).collect();
        let bar = screen.hypotheses();
        let progress = |progress: Progress| advance(&bar, progress);
        let (most_samples, limits) = (self.most_samples, Limits::default());
        let options = Options { catalogue: &catalogue, progress: &progress, most_samples, limits };
        let ended = match reference {
            Some(reference) => compare(machine, reference, recording, &options),
            None => diagnose(machine, recording, &options),
        };
        bar.finish_and_clear();
        ended.map_err(|error| error.file(&recording.path))
    }
}

/// Refuses a reference that is the recording itself: nothing would have changed, whatever the machine did.
fn check_another(reference: &Recording, recording: &Recording) -> Result<(), Error> {
    // Two stretches of one file are two recordings.
    let is_same = |a: &Run, b: &Run| {
        !a.sha256().is_empty() && (a.sha256(), a.start_s, a.len()) == (b.sha256(), b.start_s, b.len())
    };
    let is_twice = |run: &&Run| recording.runs().iter().any(|other| is_same(run, other));
    let Some(run) = reference.runs().iter().find(is_twice) else { return Ok(()) };
    Err(Error::new(ErrorKind::Inconsistent)
        .file(&run.file)
        .key("--reference")
        .found(format!("the samples of run `{}` in both recordings", run.name()))
        .expected("a recording from before the change, and another one from after it")
        .remedy("name the recording of the healthy machine as --reference"))
}

/// Fewer samples hold no motion and its counterpart.
const FEWEST_SAMPLES: usize = 2_000;

fn most_samples(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().map_err(|error| error.to_string())?;
    match number >= FEWEST_SAMPLES {
        true => Ok(number),
        false => Err(format!("expected at least {FEWEST_SAMPLES}")),
    }
}

fn json(diagnosis: &Diagnosis) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(diagnosis).map_err(|error| {
        Error::new(ErrorKind::Syntax)
            .key("--json")
            .found(error.to_string())
            .expected("a verdict that can be written as JSON")
    })?;
    Ok(text + "\n")
}
