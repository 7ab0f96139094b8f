//! `slideway inspect`: what is in a recording or a machine.

mod machine;
mod recording;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use slideway::error::{Error, ErrorKind};
use slideway::machine::Machine;
use slideway::recording::Recording;
use slideway::report::html;

use super::output::{Pictures, command_line};
use super::{Failure, Screen};

/// Reads everything, so that whatever is wrong with it is told; with --quiet that is all it does.
#[derive(Debug, Args)]
pub(super) struct Inspect {
    /// Recording or machine: a folder with recording.toml or machine.toml, or such a file
    #[arg(value_name = "RECORDING|MACHINE")]
    path: PathBuf,
    #[command(flatten)]
    pictures: Pictures,
}

impl Inspect {
    /// Reads and shows; a folder that is both is shown as both.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        self.pictures.check_places(&[], &[&self.path])?;
        let (is_machine, is_recording) = kinds(&self.path)?;
        let mut page = None;
        if is_machine {
            let machine = Machine::read(&self.path)?;
            machine::show(&machine, &mut screen.out)?;
            page = self.pictures.are_wanted().then(|| html::machine(&machine, &command_line()));
        }
        if is_machine && is_recording {
            writeln!(screen.out)?;
        }
        if is_recording {
            let recording = Recording::read(&self.path)?;
            recording::show(&recording, &mut screen.out)?;
            // Its machine is drawn where it can be read; a recording stands without one.
            let machine = recording.machine.as_ref().and_then(|path| Machine::read(path).ok());
            let drawn = || html::recording(&recording, machine.as_ref(), &command_line());
            page = self.pictures.are_wanted().then(drawn);
        }
        page.iter().try_for_each(|page| self.pictures.write(page, screen))?;
        Ok(ExitCode::SUCCESS)
    }
}

/// Whether the path leads to a machine, and whether it leads to a recording.
fn kinds(path: &Path) -> Result<(bool, bool), Error> {
    let found = if path.is_dir() {
        (path.join("machine.toml").is_file(), path.join("recording.toml").is_file())
    } else if path.is_file() {
        // A machine names its URDF; everything else is left to the recording's reader to refuse.
        let bytes = std::fs::read(path).map_err(|error| Error::io(path, &error))?;
        let text = String::from_utf8_lossy(&bytes);
        let is_machine = text.lines().any(|line| line.trim_start().starts_with("urdf"));
        (is_machine, !is_machine)
    } else {
        (false, false)
    };
    if found == (false, false) {
        let read = if path.is_dir() { "a folder with neither" } else { "no such file or folder" };
        return Err(Error::new(ErrorKind::Missing)
            .file(path)
            .found(read)
            .expected("a folder with recording.toml or machine.toml, or such a file")
            .remedy("`slideway replay` writes recordings; a machine folder holds machine.toml and a URDF"));
    }
    Ok(found)
}
