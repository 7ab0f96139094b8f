//! `slideway kinds`: the tables of a machine file and the kinds that they may be of.

use std::io::Write as _;
use std::process::ExitCode;

use clap::Args;
use clap::builder::PossibleValuesParser;
use slideway::machine::file_tables;
use slideway::report::{kind_list, kind_sheet};

use super::{Failure, Screen, style};

/// Lists the tables of machine.toml in the order of the signal path, and the laws and kinds of those that come in several.
/// With a name: the keys of the table with what they mean, and an example.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway kinds\n  slideway kinds motor\n  slideway kinds cascade")]
pub(super) struct Kinds {
    /// Table, or kind of one
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(names()), hide_possible_values = true)]
    name: Option<String>,
}

/// Paths and kinds; they live as long as the program, as its other names do.
fn names() -> Vec<&'static str> {
    let tables = file_tables();
    let paths = tables.iter().map(|table| table.path.clone());
    let mut names: Vec<String> = paths.chain(tables.iter().flat_map(|table| table.kind.clone())).collect();
    names.sort();
    names.dedup();
    names.into_iter().map(|name| &*name.leak()).collect()
}

impl Kinds {
    /// Shows the list, or what the name stands for.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        let tables = file_tables();
        let text = match &self.name {
            None => kind_list(&tables, style()),
            Some(name) => {
                let meant =
                    tables.iter().filter(|table| table.path == *name || table.kind.as_ref() == Some(name));
                meant.map(|table| kind_sheet(table, style())).collect::<Vec<_>>().join("\n")
            }
        };
        write!(screen.out, "{text}")?;
        Ok(ExitCode::SUCCESS)
    }
}
