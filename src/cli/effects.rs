//! `slideway effects`: the catalogue of effects, or one of them.

use std::io::Write as _;
use std::process::ExitCode;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use slideway::effect::EffectId;
use slideway::report::{effect_list, effect_sheet};

use super::{Failure, Screen, style};

/// Lists the effects that a diagnosis looks for, in the order of the signal path. With a name: the effect's equation, keys
/// with units and allowed values, what shows it, what it is confusable with, and a table for a machine file.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  slideway effects\n  slideway effects coulomb_friction")]
pub(super) struct Effects {
    /// Effect, or group of effects
    #[arg(value_name = "NAME", value_parser = named(), hide_possible_values = true)]
    effect: Option<Named>,
}

/// An effect by its name, or all of a group.
#[derive(Debug, Clone)]
pub(super) struct Named(String);

impl Named {
    /// Whether the effect is meant.
    pub(super) fn holds(&self, effect: EffectId) -> bool {
        effect.name() == self.0 || effect.group() == Some(self.0.as_str())
    }
}

/// Reads the name of an effect or of a group.
pub(super) fn named() -> impl TypedValueParser<Value = Named> {
    let mut names: Vec<&str> =
        EffectId::ALL.iter().flat_map(|e| e.group().into_iter().chain([e.name()])).collect();
    let mut seen = std::collections::BTreeSet::new();
    names.retain(|name| seen.insert(*name));
    PossibleValuesParser::new(names).map(Named)
}

impl Effects {
    /// Shows the list, or what the name stands for.
    pub(super) fn run(&self, screen: &mut Screen) -> Result<ExitCode, Failure> {
        match &self.effect {
            None => write!(screen.out, "{}", effect_list(style()))?,
            Some(named) => {
                // A further pitch is in the group of the first one, which has a sheet of its own.
                let own = EffectId::named(&named.0);
                let group = EffectId::ALL.iter().filter(|effect| own.is_none() && named.holds(**effect));
                let sheets: Vec<String> = own
                    .into_iter()
                    .chain(group.copied())
                    .map(|effect| effect_sheet(effect, style()))
                    .collect();
                write!(screen.out, "{}", sheets.join("\n"))?;
            }
        }
        Ok(ExitCode::SUCCESS)
    }
}
