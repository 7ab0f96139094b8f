//! Frequency response of plant, open loop and closed loop, from a recording or from a machine's twin.

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{ArgGroup, Args, ValueEnum};
use slideway::drive::motor::Motor;
use slideway::error::{Error, ErrorKind};
use slideway::identify::loop_response::{Measured, Part, measured};
use slideway::identify::margins::Margins;
use slideway::identify::modes::{Hold, Modal, modes};
use slideway::machine::Machine;
use slideway::recording::{Recording, Run, Signal};
use slideway::report::html;
use slideway::twin::{LinearLoop, LinearPlant};
use slideway::units::Motion;

use super::super::output::{Pictures, command_line, given};
use super::super::setting::{Setting, set};
use super::super::subject::runs_of;
use super::super::table::Table;
use super::super::{Failure, Plant, Screen};
use super::band::Band;
use super::excited::{self, Excited};
use super::settings::same_settings;

/// From a recording, or from a machine's twin that is excited for it. With a machine, its linear loop is computed
/// exactly and stands beside what was measured.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("subject").required(true).multiple(true).args(["recording", "machine"]))]
#[command(
    after_help = "Examples:\n  slideway identify response --machine models/MACHINE --html response.html\n  \
                        slideway identify response recordings/LOG --of plant"
)]
pub(super) struct Response {
    /// Recording: a folder with recording.toml, or such a file
    recording: Option<PathBuf>,
    /// Machine folder, or a machine file [default: the one that the recording names]
    #[arg(long, value_name = "DIR")]
    machine: Option<PathBuf>,
    /// Machine setting in force, by key path; may be given several times
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<Setting>,
    /// Run of the recording; otherwise all runs together
    #[arg(long, value_name = "NAME", requires = "recording")]
    run: Option<String>,
    /// Response to show
    #[arg(long, value_enum, default_value = "open-loop")]
    of: Of,
    /// How the machine's twin is excited
    #[arg(long, value_enum, default_value = "multisine", conflicts_with = "recording")]
    excitation: excited::Excitation,
    /// Plant to excite
    #[arg(long, value_enum, default_value = "rapier", conflicts_with = "recording")]
    plant: Plant,
    /// Band in Hz
    #[arg(long, value_name = "F1..F2")]
    band: Option<Band>,
    /// Distance of the frequencies in Hz [default: 0.5 where the twin is excited, else by the recording's length]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    resolution: Option<f64>,
    /// Number of modes to fit; 0: none [default: as many as rise above the noise]
    #[arg(long, value_name = "N")]
    modes: Option<usize>,
    #[command(flatten)]
    pictures: Pictures,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Of {
    /// Effort to position
    Plant,
    /// The loop broken at the effort; its margins
    OpenLoop,
    /// Position reference to position
    ClosedLoop,
}

impl From<Of> for Part {
    fn from(of: Of) -> Self {
        match of {
            Of::Plant => Self::Plant,
            Of::OpenLoop => Self::OpenLoop,
            Of::ClosedLoop => Self::ClosedLoop,
        }
    }
}

/// What is looked at.
struct Subject {
    name: String,
    note: Option<String>,
    sha256: Option<String>,
    runs: Vec<Run>,
    machine: Option<Machine>,
}

/// The linear part of the machine, where there is a machine.
struct Computed {
    plant: Option<LinearPlant>,
    looped: Option<LinearLoop>,
}

impl Response {
    /// Measures, fits, prints.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        self.pictures.check_places(&[], &given([&self.recording, &self.machine]))?;
        let Subject { name: subject, note, sha256, runs, machine } = self.subject()?;
        let all: Vec<&Run> = runs.iter().collect();
        let computed = Computed::of(machine.as_ref());
        let (response, how) = self.measured(&all, &computed)?;
        let (structure, modal) = self.modal(&all, machine.as_ref())?;
        let sentence = format!("{}{}", computed.warning(), self.sentence(&response, &all, how));
        let motion = all[0].motion();
        writeln!(screen.out, "{subject}\n{sentence}")?;
        let margins = self.margins(&response, &computed, how.is_empty());
        if !margins.1.is_empty() {
            writeln!(screen.out, "\nMargins")?;
            show(screen, &margins)?;
        }
        let (table, remark) = modes_table(&modal, machine.as_ref(), motion);
        writeln!(screen.out, "\nModes")?;
        if !table.1.is_empty() {
            show(screen, &table)?;
        }
        writeln!(screen.out, "  {remark}")?;
        if self.pictures.are_wanted() {
            let mut responses = vec![self.drawn(&response, &computed, motion)];
            responses.extend(structure.map(|s| drawn_structure(&s, modal.as_ref().ok(), motion)));
            let page = html::Responded {
                subject,
                sentence,
                note,
                motion,
                sha256,
                responses,
                margins,
                modes: table,
                modes_remark: remark,
            };
            self.pictures.write(&html::responded(&page, &command_line()), screen)?;
        }
        Ok(ExitCode::SUCCESS)
    }

    fn subject(&self) -> Result<Subject, Error> {
        let Some(path) = &self.recording else { return self.twin() };
        let recording = Recording::read(path)?;
        let machine = match (&self.machine, &recording.machine) {
            (Some(place), _) => Some(Machine::read(place)?),
            // One that only the recording names may be elsewhere.
            (None, Some(place)) => Machine::read(place).ok(),
            (None, None) => None,
        };
        let runs: Vec<Run> = runs_of(&recording, self.run.as_deref())?.into_iter().cloned().collect();
        let machine = machine.map(|machine| self.set(&machine)).transpose()?;
        let part = Part::from(self.of);
        let machine = same_settings(&runs, machine.as_ref(), part).map_err(|e| e.file(&recording.path))?;
        Ok(Subject {
            name: recording.path.display().to_string(),
            note: recording.note.clone(),
            sha256: Some(recording.sha256()),
            runs,
            machine,
        })
    }

    /// The machine's twin, excited.
    fn twin(&self) -> Result<Subject, Error> {
        let place = self.machine.clone().unwrap_or_default();
        let machine = self.set(&Machine::read(&place)?)?;
        let plan = excited::Plan {
            excitation: self.excitation,
            plant: self.plant.into(),
            by_reference: self.of == Of::ClosedLoop,
            band: self.band,
            resolution_hz: self.resolution,
        };
        let Excited { runs, note } = excited::excited(&machine, &plan)?;
        let name = machine.description().name.clone();
        Ok(Subject { name, note: Some(note), sha256: None, runs, machine: Some(machine) })
    }

    /// The response that was asked for; of an open loop into which no voltage was injected, the plant in series with the
    /// feedback of the machine's controller.
    fn measured(&self, runs: &[&Run], computed: &Computed) -> Result<(Measured, &'static str), Error> {
        let direct = measured(runs, self.of.into(), self.resolution);
        let (response, how) = match (direct, &computed.looped) {
            (Err(error), Some(looped)) if self.of == Of::OpenLoop && error.kind() == ErrorKind::Missing => {
                let plant = measured(runs, Part::Plant, self.resolution)
                    .map_err(|own| if own.kind() == ErrorKind::OutOfRange { own } else { error })?;
                (plant.times(|f| looped.feedback(f)), ", plant measured, controller as stated")
            }
            (direct, _) => (direct?, ""),
        };
        Ok((self.within(response), how))
    }

    fn set(&self, machine: &Machine) -> Result<Machine, Error> {
        set(machine, &self.settings)
    }

    /// The points in the band that was asked for.
    fn within(&self, mut response: Measured) -> Measured {
        if let Some(Band([from, to])) = self.band {
            response.points.retain(|p| (from..=to).contains(&p.frequency_hz));
        }
        response
    }

    fn sentence(&self, response: &Measured, runs: &[&Run], more: &str) -> String {
        let coherent = response.coherent();
        let how = if response.is_periodic { "whole periods averaged" } else { "Welch's averaged segments" };
        let band = match (coherent.first(), coherent.last()) {
            (Some(a), Some(b)) => format!("coherent from {:.2} to {:.1} Hz", a.frequency_hz, b.frequency_hz),
            _ => "nowhere coherent".to_owned(),
        };
        let count = if runs.len() == 1 { "1 run".to_owned() } else { format!("{} runs", runs.len()) };
        format!(
            "{} from {count}{more}, {} as instrument, {how}; {band}",
            capitalised(Part::from(self.of).word()),
            response.instrument.key(runs[0].motion()),
        )
    }

    /// Modes from motor force to position, where the runs hold the force.
    fn modal(
        &self,
        runs: &[&Run],
        machine: Option<&Machine>,
    ) -> Result<(Option<Measured>, Result<Modal, String>), Error> {
        if self.modes == Some(0) {
            return Ok((None, Err("not asked for".to_owned())));
        }
        let direct = machine.is_some_and(|m| matches!(m.description().motor, Motor::Direct(_)));
        let hold = if direct { Hold::Zero } else { Hold::Linear };
        let found =
            measured(runs, Part::Structure, self.resolution).map(|m| self.within(m)).and_then(|response| {
                let fitted = modes(response.coherent(), runs[0].sample_period_s(), hold, self.modes);
                Ok((response, fitted?))
            });
        match (found, self.modes) {
            (Ok((response, modal)), _) => Ok((Some(response), Ok(modal))),
            // What was asked for by number and cannot be had is a refusal; otherwise a remark.
            (Err(error), Some(_)) => Err(error.key("--modes")),
            (Err(error), None) => Ok((None, Err(self.without_modes(&error, runs)))),
        }
    }

    /// Why no mode is shown, as a sentence.
    fn without_modes(&self, error: &Error, runs: &[&Run]) -> String {
        let force = Signal::Thrust.key(runs[0].motion());
        match error.kind() {
            ErrorKind::Undetermined => {
                let band = measured(runs, Part::Structure, self.resolution).map(|m| self.within(m));
                let coherent = band.as_ref().map(Measured::coherent).unwrap_or_default();
                match (coherent.first(), coherent.last()) {
                    (Some(a), Some(b)) => format!(
                        "No resonance stands out between {:.2} and {:.1} Hz.",
                        a.frequency_hz, b.frequency_hz
                    ),
                    _ => "No resonance stands out.".to_owned(),
                }
            }
            ErrorKind::TooLittleData => {
                "Too few coherent frequencies from motor force to position to look for resonances.".to_owned()
            }
            ErrorKind::Missing => {
                format!(
                    "Resonances are looked for from motor force to position, and the runs do not log {force}."
                )
            }
            _ => format!("Resonances could not be looked for: {}.", error.statement()),
        }
    }

    /// Heads and rows of the margins: of the linear loop and of the measured open loop.
    ///
    /// Distances to instability exist for a stable loop only: one that is not has none, whether computed or measured through
    /// the same controller.
    fn margins(
        &self,
        response: &Measured,
        computed: &Computed,
        is_direct: bool,
    ) -> (Vec<String>, Vec<Vec<String>>) {
        let points: Vec<_> = response.coherent().iter().map(|p| (p.frequency_hz, p.response())).collect();
        let is_sound = self.of == Of::OpenLoop && (is_direct || computed.stable().is_some());
        let measured = is_sound.then(|| Margins::of(&points).ok()).flatten();
        let stated = computed.stable().map(LinearLoop::margins);
        let columns: Vec<(&str, Margins)> = [("linear loop", stated), ("measured", measured)]
            .into_iter()
            .filter_map(|(w, m)| Some((w, m?)))
            .collect();
        let mut heads = vec![String::new()];
        for (word, _) in &columns {
            heads.extend([format!(">{word}"), ">at Hz".to_owned()]);
        }
        if columns.is_empty() {
            return (heads, Vec::new());
        }
        let mut rows = Vec::new();
        for (k, name) in MARGINS.iter().enumerate() {
            let cells = columns.iter().flat_map(|(_, margins)| {
                margin(margins, k)
                    .map_or(["none".to_owned(), "-".to_owned()], |(value, at)| [value, format!("{at:.2}")])
            });
            rows.push(std::iter::once((*name).to_owned()).chain(cells).collect());
        }
        (heads, rows)
    }

    fn drawn(&self, response: &Measured, computed: &Computed, motion: Motion) -> html::Response {
        let frequencies = || computed.frequencies(&response.points);
        let curve = |of: &dyn Fn(f64) -> nalgebra::Complex<f64>| frequencies().map(|f| (f, of(f))).collect();
        let computed_curve: Vec<_> = match (self.of, &computed.looped, &computed.plant) {
            (Of::Plant, _, Some(plant)) => curve(&|f| plant.plant(f)),
            (Of::OpenLoop, Some(looped), _) => curve(&|f| looped.open_loop(f)),
            (Of::ClosedLoop, Some(looped), _) => curve(&|f| looped.closed_loop(f)),
            _ => Vec::new(),
        };
        let margins = computed.stable().filter(|_| self.of == Of::OpenLoop).map(LinearLoop::margins);
        let marked = margins.iter().flat_map(|m| {
            let phase = m.phase.map(|p| (p.frequency_hz, format!("phase margin {:.0}°", p.margin_deg)));
            let gain = m.gain.map(|g| (g.frequency_hz, format!("gain margin {:.1} dB", g.margin_db)));
            phase.into_iter().chain(gain)
        });
        html::Response {
            name: "response".to_owned(),
            title: Part::from(self.of).word().to_owned(),
            unit: if self.of == Of::Plant { format!("{}/V", length(motion)) } else { String::new() },
            measured: response.points.clone(),
            computed: computed_curve,
            computed_word: "linear loop".to_owned(),
            marked: marked.collect(),
        }
    }
}

impl Computed {
    fn of(machine: Option<&Machine>) -> Self {
        Self { plant: machine.map(LinearPlant::of), looped: machine.and_then(|m| LinearLoop::of(m).ok()) }
    }

    /// The loop, where it is stable.
    fn stable(&self) -> Option<&LinearLoop> {
        self.looped.as_ref().filter(|looped| looped.is_stable())
    }

    /// What has to be said first.
    fn warning(&self) -> &'static str {
        match (&self.looped, self.stable()) {
            (Some(_), None) => {
                "THE LINEAR LOOP OF THE MACHINE IS NOT STABLE WITH THESE SETTINGS: it has no margins.\n"
            }
            _ => "",
        }
    }

    /// Frequencies of the computed curve: the plant's own where they lie in the measured band.
    fn frequencies(
        &self,
        measured: &[slideway::identify::frequency_response::Point],
    ) -> impl Iterator<Item = f64> {
        let ends = [measured.first(), measured.last()].map(|p| p.map_or(0.0, |p| p.frequency_hz));
        let own: Vec<f64> =
            self.plant.iter().flat_map(|plant| plant.frequencies_hz().collect::<Vec<_>>()).collect();
        own.into_iter().filter(move |f| (0.999 * ends[0]..=1.001 * ends[1]).contains(f))
    }
}

fn drawn_structure(response: &Measured, modal: Option<&Modal>, motion: Motion) -> html::Response {
    let force = match motion {
        Motion::Prismatic => "N",
        Motion::Revolute => "N·m",
    };
    let band = response.coherent();
    html::Response {
        name: "structure".to_owned(),
        title: "structure, motor force to position".to_owned(),
        unit: format!("{}/{force}", length(motion)),
        measured: response.points.clone(),
        computed: modal.map_or(Vec::new(), |m| {
            band.iter().map(|p| (p.frequency_hz, m.response(p.frequency_hz))).collect()
        }),
        computed_word: "fitted modes".to_owned(),
        marked: modal.map_or(Vec::new(), |m| {
            m.modes
                .iter()
                .map(|mode| (mode.frequency_hz.value, format!("{:.2}", mode.frequency_hz.value)))
                .collect()
        }),
    }
}

fn length(motion: Motion) -> &'static str {
    match motion {
        Motion::Prismatic => "m",
        Motion::Revolute => "rad",
    }
}

/// Distance of frequencies, as a share, within which a mode found stands beside a stated one.
const SAME_MODE: f64 = 0.1;

const MARGINS: [&str; 5] =
    ["gain margin, dB", "gain margin downward, dB", "phase margin, °", "modulus margin", "delay margin, ms"];

/// Value and frequency of the margin in that row.
fn margin(margins: &Margins, row: usize) -> Option<(String, f64)> {
    match row {
        0 => margins.gain.map(|g| (format!("{:.2}", g.margin_db), g.frequency_hz)),
        1 => margins.gain_down.map(|g| (format!("{:.2}", g.margin_db), g.frequency_hz)),
        2 => margins.phase.map(|p| (format!("{:.2}", p.margin_deg), p.frequency_hz)),
        3 => margins.modulus.map(|m| (format!("{:.3}", m.margin), m.frequency_hz)),
        _ => margins.delay.map(|d| (format!("{:.3}", 1e3 * d.margin_s), d.frequency_hz)),
    }
}

fn capitalised(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Heads and rows of the modes found beside those stated, and a remark.
fn modes_table(
    modal: &Result<Modal, String>,
    machine: Option<&Machine>,
    motion: Motion,
) -> ((Vec<String>, Vec<Vec<String>>), String) {
    let modal = match modal {
        Ok(modal) => modal,
        Err(why) => return ((Vec::new(), Vec::new()), why.clone()),
    };
    let mass = if motion == Motion::Prismatic { ">mass kg" } else { ">inertia kg·m²" };
    let heads = ["mode", ">Hz", ">95 % ±", ">stated Hz", ">damping", ">95 % ±", ">stated", mass, ">95 % ±"];
    let stated = machine.map(Machine::constants).map(|c| c.modes.as_slice().to_vec()).unwrap_or_default();
    let row = |(k, mode): (usize, &slideway::identify::modes::FoundMode)| {
        let nearest = stated.iter().min_by(|a, b| {
            let far = |m: &&slideway::base::Mode| (m.frequency_hz() - mode.frequency_hz.value).abs();
            far(a).total_cmp(&far(b))
        });
        let is_it =
            |m: &&slideway::base::Mode| (m.frequency_hz() / mode.frequency_hz.value - 1.0).abs() < SAME_MODE;
        let nearest = nearest.filter(is_it);
        let half = |e: &slideway::identify::least_squares::Estimate| 0.5 * (e.ci95[1] - e.ci95[0]);
        vec![
            (k + 1).to_string(),
            format!("{:.3}", mode.frequency_hz.value),
            format!("{:.3}", half(&mode.frequency_hz)),
            nearest.map_or("-".to_owned(), |m| m.frequency_hz().to_string()),
            format!("{:.5}", mode.damping_ratio.value),
            format!("{:.5}", half(&mode.damping_ratio)),
            nearest.map_or("-".to_owned(), |m| m.damping_ratio().to_string()),
            format!("{:.0}", mode.mass.value),
            format!("{:.0}", half(&mode.mass)),
        ]
    };
    let rows = modal.modes.iter().enumerate().map(row).collect();
    let units = match motion {
        Motion::Prismatic => ["kg", "N·s/m"],
        Motion::Revolute => ["kg·m²", "N·m·s/rad"],
    };
    let remark = format!(
        "on a rigid part of {:.4} {} and a viscous coefficient of {:.1} {}; residual {:.2} times its stated deviation{}, {} points",
        modal.moving_mass.value,
        units[0],
        modal.viscous.value,
        units[1],
        modal.residual,
        if modal.residual > 1.0 { ", intervals widened as much" } else { "" },
        modal.points
    );
    ((heads.map(str::to_owned).to_vec(), rows), remark)
}

fn show(screen: &mut Screen, (heads, rows): &(Vec<String>, Vec<Vec<String>>)) -> Result<(), Failure> {
    let mut table = Table::of(heads.iter().map(|head| head.trim_start_matches('>').to_owned()).collect());
    rows.iter().for_each(|row| table.cells(row.clone()));
    table.write(&mut screen.out)?;
    Ok(())
}
