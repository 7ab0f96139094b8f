//! The machine that a recording is about.

use std::path::Path;

use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::Recording;

use super::setting::{Setting, lay_over};

/// The machine named here or by the recording, with its settings, and of the recording's motion.
pub(super) fn machine_of(
    recording: &Recording,
    named: Option<&Path>,
    settings: &[Setting],
) -> Result<Machine, Error> {
    let Some(path) = named.or(recording.machine.as_deref()) else {
        return Err(Error::new(ErrorKind::Missing)
            .file(&recording.path)
            .key("machine")
            .found("a recording that names no machine")
            .expected("a machine folder")
            .remedy("give --machine DIR, or put machine = \"DIR\" at the head of the file"));
    };
    let machine = Machine::read(path)?;
    check_motion(&machine, recording)?;
    lay_over(&machine, settings, "--set")
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
