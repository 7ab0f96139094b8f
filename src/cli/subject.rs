//! The machine that a recording is of.

use std::path::{Path, PathBuf};

use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::{LogContext, MappedColumn, Recording, Run};

/// A recording, or bare logs of a machine with their columns mapped.
pub(super) fn read(
    paths: &[PathBuf],
    machine: Option<&Path>,
    maps: &[MappedColumn],
) -> Result<Recording, Error> {
    let is_manifest =
        |path: &Path| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    if let Some(path) = paths.iter().find(|path| !path.exists() && !is_manifest(path)) {
        return Err(Error::new(ErrorKind::Missing)
            .file(path)
            .found("no such file or folder")
            .expected(
                "a folder with recording.toml, such a file, or a log (CSV, Parquet, MCAP, MAT, HDF5, TTRECX)",
            )
            .remedy("check the path"));
    }
    let are_bare = paths.len() > 1 || paths.iter().any(|path| Recording::is_bare(path));
    if !are_bare {
        if let Some(path) = paths.first().filter(|_| !maps.is_empty()) {
            return Err(Error::new(ErrorKind::Inconsistent)
                .file(path)
                .key("--map")
                .found("a recording, which says itself what its columns hold")
                .expected("a bare log")
                .remedy("map the columns under [columns] of its recording.toml"));
        }
        return Recording::read(paths.first().map_or(Path::new("."), PathBuf::as_path));
    }
    if let Some(path) = paths.iter().find(|path| !Recording::is_bare(path) && path.exists()) {
        return Err(Error::new(ErrorKind::Inconsistent)
            .file(path)
            .found("a recording beside other files")
            .expected("one recording, or bare logs alone")
            .remedy("name one of them, or put all files into one recording.toml"));
    }
    let Some(folder) = machine else {
        return Err(Error::new(ErrorKind::Missing)
            .file(paths.first().map_or(Path::new("."), PathBuf::as_path))
            .key("--machine")
            .found("a bare log, which names no machine")
            .expected("a machine folder, which says whether the axis slides or turns")
            .remedy(
                "give --machine DIR, or let `slideway init LOG` make a machine and a recording.toml of it",
            ));
    };
    let machine = Machine::read(folder)?;
    let context =
        LogContext { maps, motion: machine.motion(), sample_period_s: machine.description().sample_period_s };
    Recording::read_logs(paths, &context)
}

/// The machine that was named, else the one that the recording names; of the recording's kind of motion.
pub(super) fn machine_of(recording: &Recording, named: Option<&PathBuf>) -> Result<Machine, Error> {
    let Some(path) = named.or(recording.machine.as_ref()) else {
        return Err(Error::new(ErrorKind::Missing)
            .file(&recording.path)
            .key("machine")
            .found("a recording that names no machine")
            .expected("a machine folder")
            .remedy("give --machine DIR, or put machine = \"DIR\" at the head of the file"));
    };
    if named.is_none() && !path.exists() {
        return Err(Error::new(ErrorKind::Missing)
            .file(&recording.path)
            .key("machine")
            .found(format!("{}, which is not there", path.display()))
            .expected("a machine folder (with machine.toml) or a machine file")
            .remedy("correct the path, which is relative to this file, or give --machine DIR"));
    }
    let machine = Machine::read(path)?;
    check_motion(&machine, recording)?;
    check_settings(&machine, recording)?;
    Ok(machine)
}

/// Refuses settings of a run that the machine has no place for, where they stand.
fn check_settings(machine: &Machine, recording: &Recording) -> Result<(), Error> {
    for run in recording.runs() {
        let settings = run.settings.iter().map(|(path, value)| (path.as_str(), value.clone()));
        if let Err(error) = machine.with_settings(settings) {
            let keys: Vec<&str> = run.settings.keys().map(String::as_str).collect();
            let key = format!("{}.set: {}", run.name(), keys.join(", "));
            let remedy = "correct `set` of this [[run]]: key paths and values as in the machine file";
            return Err(error.moved_to(&recording.path, key).remedy(remedy));
        }
    }
    Ok(())
}

/// Refuses a recording of an axis of another kind.
pub(super) fn check_motion(machine: &Machine, recording: &Recording) -> Result<(), Error> {
    if machine.motion() == recording.motion() {
        return Ok(());
    }
    Err(Error::new(ErrorKind::Inconsistent)
        .file(&recording.path)
        .key("motion")
        .found(format!("a {} axis", recording.motion()))
        .expected(format!("a {} one, as is the machine {}", machine.motion(), machine.file().display()))
        .remedy("name the machine that was recorded, or correct the signals' names"))
}

/// The runs of a recording, or the one of a name.
pub(super) fn runs_of<'a>(recording: &'a Recording, name: Option<&str>) -> Result<Vec<&'a Run>, Error> {
    let Some(name) = name else { return Ok(recording.runs().iter().collect()) };
    let run = recording.run(name).ok_or_else(|| {
        let names: Vec<&str> = recording.runs().iter().map(Run::name).collect();
        Error::new(ErrorKind::Missing)
            .file(&recording.path)
            .key("--run")
            .found(format!("`{name}`"))
            .expected(format!("one of {}", names.join(", ")))
            .remedy("name a run of the recording, or leave --run out for all")
    })?;
    Ok(vec![run])
}
