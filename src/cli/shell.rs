//! `slideway completions` and `slideway man`: what a shell and `man` need to know of the commands.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, CommandFactory as _};
use clap_complete::Shell;
use slideway::error::Error;

use super::{Arguments, Failure, Screen};

/// The name that the program is called by.
const NAME: &str = "slideway";

/// Prints the completions of a shell.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  slideway completions bash > ~/.local/share/bash-completion/completions/slideway\n  \
                        slideway completions zsh > ~/.zfunc/_slideway\n  \
                        slideway completions fish > ~/.config/fish/completions/slideway.fish"
)]
pub(super) struct Completions {
    /// Shell
    shell: Shell,
}

impl Completions {
    /// Shows the script.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        clap_complete::generate(self.shell, &mut Arguments::command(), NAME, &mut screen.out);
        Ok(ExitCode::SUCCESS)
    }
}

/// Prints the manual page of the program, or writes one a command into a folder.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway man | man -l -\n  slideway man --out ~/.local/share/man/man1")]
pub(super) struct Man {
    /// Folder for a page for the program and one for each command
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Man {
    /// Shows or writes the pages.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let mut command = Arguments::command();
        command.build();
        let Some(folder) = &self.out else {
            clap_mangen::Man::new(command).render(&mut screen.out)?;
            return Ok(ExitCode::SUCCESS);
        };
        let told = |error: std::io::Error| {
            Error::io(folder, &error)
                .key("--out")
                .expected("a folder in which files can be made")
                .remedy("name a folder in which you may write")
        };
        std::fs::create_dir_all(folder).map_err(told)?;
        clap_mangen::generate_to(command, folder).map_err(told)?;
        Ok(ExitCode::SUCCESS)
    }
}
