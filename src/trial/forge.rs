//! Forging: machines with hidden effects, their truth sealed, their recordings simulated.

use super::draw::{Cases, Outcome};
use super::engine::Engine;
use super::equals::equals;
use super::folder::{Announcement, SCHEMA, Skipped, Terms, Trial, sha256};
use super::gauge::as_logged;
use super::plan::{Planned, plan};
use super::seal::{Sealed, is_open};
use super::seed::Seed;
use super::tier::Tier;
use super::truth::{self, TrueCase, Truth};
use crate::effect::EffectId;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::recording::{Existing, Format, Recording, Signal};
use crate::twin::Sensing;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// What to forge.
#[derive(Debug, Clone)]
pub struct Order<'a> {
    /// The machine; any that a diagnosis can replay in closed loop.
    pub machine: &'a Machine,
    /// Seed.
    pub seed: Seed,
    /// Tiers, mixed in one folder.
    pub tiers: &'a [Tier],
    /// Cases of each tier; none: the tier's own number.
    pub cases: Option<usize>,
    /// Engine to simulate on.
    pub engine: Engine,
    /// Folder of the trial.
    pub folder: &'a Path,
}

/// Who is told how forging goes on.
pub struct Progress<'a> {
    /// Told how many cases there are to draw.
    pub drawing: &'a (dyn Fn(usize) + Sync),
    /// Told once, before anything is simulated: the truth is sealed.
    pub sealed: &'a (dyn Fn(&Trial) + Sync),
    /// Told after every case that was drawn, and after every one that was simulated.
    pub done: &'a (dyn Fn() + Sync),
}

/// Forges a trial, or goes on with one that was left unfinished.
///
/// The truth is drawn and sealed first; only then are recordings simulated, each written whole or not at all. A trial
/// that is there must be the one ordered, and its truth must come out with the same hash.
///
/// # Errors
/// A folder that holds another trial or anything else, a machine without a controller, or whatever the file system
/// refuses.
pub fn forge(order: &Order, progress: &Progress) -> Result<Trial> {
    let machine = order.machine;
    check_place(order)?;
    if machine.description().controller.is_none() {
        return Err(machine
            .lacks_controller()
            .expected("the table [controller]: forged machines follow strokes in closed loop")
            .remedy("state the control law"));
    }
    std::fs::create_dir_all(order.folder)
        .map_err(|error| Error::io(order.folder, &error).expected("a folder"))?;
    let _lock = crate::whole::lock(order.folder)?;
    let logged = logged(machine);
    let (effects, mut skipped) = forgeable(machine);
    let equal = |a: EffectId, b: EffectId| equals(a, machine, &logged).contains(&b);
    let planned = plan(order.seed, order.tiers, order.cases, &effects, &logged, &equal);
    (progress.drawing)(planned.len());
    let all = Cases { seed: order.seed, machine, engine: order.engine, logged: &logged };
    let draw = |one: &Planned| {
        let outcome = all.draw(one);
        (progress.done)();
        outcome
    };
    let outcomes: Vec<Outcome> = planned.par_iter().map(draw).collect::<Result<_>>()?;
    let mut cases: Vec<TrueCase> = Vec::new();
    for outcome in outcomes {
        match outcome {
            Outcome::Drawn(case) => cases.push(TrueCase { case: cases.len() + 1, ..*case }),
            Outcome::Skipped(effect, reason) if skipped.iter().all(|s| s.effect != effect) => {
                skipped.push(Skipped { effect, reason });
            }
            Outcome::Skipped(..) => {}
        }
    }
    skipped.sort_by_key(|skipped| skipped.effect);
    let trial = announce(order, cases.clone(), skipped)?;
    (progress.sealed)(&trial);
    let simulate = |case: &TrueCase| {
        let simulated = simulate(&trial, machine, case, &logged);
        (progress.done)();
        simulated
    };
    cases.par_iter().map(simulate).collect::<Result<Vec<()>>>()?;
    Ok(trial)
}

/// Refuses a folder with something in it that is no trial.
fn check_place(order: &Order) -> Result<()> {
    let folder = order.folder;
    if !folder.exists() || Trial::is_at(folder) {
        return Ok(());
    }
    let refuse = |found: &str| {
        Err(Error::new(ErrorKind::Io)
            .file(folder)
            .found(found)
            .expected("a new or empty folder, or an unfinished trial")
            .remedy("name another folder"))
    };
    if !folder.is_dir() {
        return refuse("a file");
    }
    let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
    // A seal without announcement is what a kill between the two leaves; it is drawn again, the same.
    let foreign =
        entries.flatten().any(|entry| entry.file_name() != "sealed" && entry.file_name() != ".lock");
    if foreign { refuse("a folder with files in it that is no trial") } else { Ok(()) }
}

/// The signals that a forged machine logs: what its sensors and its drive say. Force is not among them: no sensor
/// measures it.
pub fn logged(machine: &Machine) -> Vec<Signal> {
    let mut logged =
        vec![Signal::PositionReference, Signal::ControlEffort, Signal::Position, Signal::Velocity];
    if machine.description().motor.has_current() {
        logged.push(Signal::Current);
    }
    if machine.description().load_sensor.is_some() {
        logged.push(Signal::LoadPosition);
    }
    logged
}

/// Effects that can act on a machine, and those that cannot.
fn forgeable(machine: &Machine) -> (Vec<EffectId>, Vec<Skipped>) {
    let constants = machine.constants();
    let (mut effects, mut skipped) = (Vec::new(), Vec::new());
    for &effect in EffectId::ALL {
        let reason = if !effect.applies(&constants) {
            "the machine, as its file states it, has nothing that this effect could change"
        } else if machine.description().effect.contains(effect) {
            "the machine's file has it already"
        } else {
            effects.push(effect);
            continue;
        };
        skipped.push(Skipped { effect, reason: reason.to_owned() });
    }
    (effects, skipped)
}

/// Seals the truth, then announces the trial; one that is announced already must be the same.
fn announce(order: &Order, cases: Vec<TrueCase>, skipped: Vec<Skipped>) -> Result<Trial> {
    let machine = order.machine;
    if cases.is_empty() {
        let why = skipped.first().map_or("no tiers were named", |s| s.reason.as_str());
        return Err(Error::new(ErrorKind::TooLittleData)
            .file(machine.file())
            .found("nothing to forge")
            .expected("at least one case")
            .remedy(format!("ask for more cases or other tiers ({why})")));
    }
    let count = cases.len();
    let truth = Truth {
        schema: truth::SCHEMA.to_owned(),
        seed: order.seed.number(),
        nonce: format!("{:016x}{:016x}", order.seed.derived("nonce 1"), order.seed.derived("nonce 2")),
        machine: machine.description().name.clone(),
        engine: order.engine,
        cases,
    };
    let file = std::fs::read(machine.file()).map_err(|error| Error::io(machine.file(), &error))?;
    let announcement = Announcement {
        schema: SCHEMA.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: order.seed.number(),
        purpose: order.seed.kind().to_owned(),
        tiers: order.tiers.to_vec(),
        cases: count,
        machine: machine.description().name.clone(),
        machine_sha256: sha256(&file),
        engine: order.engine,
        truth_sha256: Sealed::hash(&truth)?,
        skipped,
    };
    if Trial::is_at(order.folder) {
        let there = Trial::read(order.folder)?;
        if there.announcement != announcement {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(order.folder.join("trial.toml"))
                .found(difference(&there.announcement, &announcement))
                .expected("the trial that is ordered")
                .remedy("name another folder, or order the same trial to go on with it"));
        }
        return Ok(there);
    }
    Sealed::close(&truth, &Trial::truth_file(order.folder))?;
    Trial::announce(order.folder, announcement)
}

/// In what an announced trial differs from the ordered one.
fn difference(there: &Announcement, ordered: &Announcement) -> String {
    let of = |a: &Announcement| {
        let tiers: Vec<&str> = a.tiers.iter().map(|tier| tier.name()).collect();
        [
            ("seed", a.seed.to_string()),
            ("tiers", tiers.join(", ")),
            ("cases", a.cases.to_string()),
            ("machine", a.machine.clone()),
            ("machine file", a.machine_sha256.clone()),
            ("engine", a.engine.to_string()),
            ("version", a.version.clone()),
            ("truth", a.truth_sha256.clone()),
        ]
    };
    let differ = of(there).into_iter().zip(of(ordered)).find(|(a, b)| a != b);
    match differ {
        Some(((what, there), (_, ordered))) => {
            format!("a trial with {what} {there} where {ordered} is ordered")
        }
        None => "a trial with other skipped effects".to_owned(),
    }
}

/// Simulates a case and writes it, unless it is there.
fn simulate(trial: &Trial, machine: &Machine, case: &TrueCase, logged: &[Signal]) -> Result<()> {
    if trial.is_forged(case.case) {
        return Ok(());
    }
    if is_open(trial) {
        return Err(Error::new(ErrorKind::Inconsistent)
            .file(trial.case_folder(case.case))
            .found("no recording in a trial whose seal is open")
            .expected("a trial as it was scored")
            .remedy("forge a trial with another seed"));
    }
    let logged: Vec<Signal> = logged
        .iter()
        .copied()
        .filter(|s| !case.missing.iter().any(|key| key == s.key(machine.motion())))
        .collect();
    if case.tier == Tier::Change {
        let before = recording(trial, case, (machine, &case.machine_before(machine)?), "before", &logged)?;
        before.write(trial.reference_folder(case.case), Format::Parquet, Existing::Replace)?;
    }
    let now = recording(trial, case, (machine, &case.machine(machine)?), "noise", &logged)?;
    now.write(trial.case_folder(case.case), Format::Parquet, Existing::Replace)?;
    trial.state(case.case, &Terms { without: case.struck.clone(), twin: case.twin.clone() })
}

/// The runs of a case as a machine makes them, with noise of its own.
fn recording(
    trial: &Trial,
    case: &TrueCase,
    (machine, real): (&Machine, &Machine),
    noise: &str,
    logged: &[Signal],
) -> Result<Recording> {
    let mut runs = Vec::new();
    for strokes in &case.runs {
        let reference = strokes.reference(machine);
        let seed = trial.seed.derived(&format!("{noise} {} {}", case.case, strokes.name));
        let engine = trial.announcement.engine;
        let sensing = Sensing::AsStated { seed };
        let real = begun(real, trial.seed.derived(&format!("play {noise} {} {}", case.case, strokes.name)))?;
        let traces =
            engine.simulate(&real, &case.otherwise, sensing, &reference, strokes.begins_s, case.step_s)?;
        let run = as_logged(strokes, machine, &reference, traces, logged)?;
        runs.push(case.otherwise.logged(run, machine)?);
    }
    let mut recording = Recording::new(runs)?;
    recording.machine = Some(machine_path(machine));
    recording.note =
        Some(format!("simulated, not measured: case {} of a blind trial, seed {}", case.case, trial.seed));
    Ok(recording)
}

/// The machine with its drive train anywhere in its play: before a run, anything may have moved.
fn begun(machine: &Machine, seed: u64) -> Result<Machine> {
    if machine.description().effect.backlash.is_none() {
        return Ok(machine.clone());
    }
    let share: f64 = StdRng::seed_from_u64(seed).random_range(-1.0..=1.0);
    machine.with_settings([("effect.backlash.initial_share", share.into())])
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
