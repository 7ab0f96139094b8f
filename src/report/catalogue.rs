//! The catalogue of effects in words: all in a list, or one with what its law says of itself.

use super::Style;
use super::layout::{INDENT, Ink, labelled};
use super::wrap::columns;
use crate::effect::{Degree, EffectId, Likeness, Parameter, Site, Usual};
use crate::units::{Motion, engineering};

/// Width of the labels of one effect.
const LABEL: usize = 12;

/// Every effect with its phrase, site by site in the order of the signal path.
pub fn effect_list(style: Style) -> String {
    let width = EffectId::ALL.iter().map(|effect| columns(effect.name())).max().unwrap_or_default();
    let mut out = String::new();
    for site in Site::ALL {
        out += style.heading(site.name(), "").trim_start_matches('\n');
        for effect in EffectId::ALL.iter().filter(|effect| effect.site() == site) {
            out += &format!("{INDENT}{:<width$}  {}\n", effect.name(), effect.phrase());
        }
        out.push('\n');
    }
    out + "One of them: slideway effects NAME\n"
}

/// What an effect's law says of itself, with a table for a machine file.
pub fn effect_sheet(effect: EffectId, style: Style) -> String {
    let mut out = format!("{}  {}\n", style.ink(Ink::Heading, effect.name()), effect.phrase());
    let mut row = |label: &str, text: &str| out += &labelled(label, LABEL, text, style);
    row("site", effect.site().name());
    if let Some(group) = effect.group() {
        row("group", group);
    }
    for (k, case) in effect.equation().lines().enumerate() {
        row(if k == 0 { "equation" } else { "" }, case);
    }
    row("source", effect.source());
    row("shown by", effect.shown_by());
    for parameter in effect.parameters() {
        let Some(usual) = parameter.usual else { continue };
        let name = parameter.name;
        let range = match usual {
            Usual::Factor(factor) => format!("within a factor {factor:.2} of what is stated"),
            Usual::Range { prismatic, revolute } => format!(
                "between {} and {} ({} and {} on a revolute axis)",
                engineering(prismatic.0, parameter.unit),
                engineering(prismatic.1, parameter.unit),
                engineering(revolute.0, parameter.revolute_unit),
                engineering(revolute.1, parameter.revolute_unit)
            ),
        };
        row("prior", &format!("{name}: 95 % of machines {range}; farther off, it is a less probable cause"));
    }
    if !effect.modifies().is_empty() {
        let modified: Vec<&str> = effect.modifies().iter().map(|other| other.name()).collect();
        row("modifies", &format!("{}; without it the effect does nothing", modified.join(" or ")));
    }
    for (k, likeness) in effect.likenesses().iter().enumerate() {
        row(if k == 0 { "confusable" } else { "" }, &words(likeness));
    }
    out += &style.heading("keys", "");
    out += &keys(effect);
    out += &style.heading("in a machine file", "");
    out + &example(effect)
        .lines()
        .map(|line| format!("{}\n", format!("{INDENT}{line}").trim_end()))
        .collect::<String>()
}

/// Tables of a machine file that state the effect, and before it what it modifies.
pub fn example(effect: EffectId) -> String {
    let values = effect.parameters().iter().zip(effect.example());
    let rows: String = values.map(|(parameter, value)| format!("{} = {value:?}\n", parameter.name)).collect();
    let modified = effect.modifies().first().map(|modified| example(*modified) + "\n");
    format!("{}[effect.{}]\n{rows}", modified.unwrap_or_default(), effect.name())
}

fn words(likeness: &Likeness) -> String {
    let degree = match likeness.degree {
        Degree::Equal(_) => "exactly equal",
        Degree::StandIn(_) => "stands in for it",
        Degree::Similar => "similar",
    };
    format!("{}: {degree} {}", likeness.other.name(), likeness.place)
}

/// Symbol, key, unit and allowed values, for either kind of axis where they differ.
fn keys(effect: EffectId) -> String {
    let numbers = effect.parameters().iter().chain(effect.further());
    let numbers = numbers.chain(effect.form().iter().map(|form| &form.parameter));
    let numbers = effect.symbols().iter().zip(numbers);
    let rows: Vec<[String; 4]> = numbers.flat_map(|(symbol, parameter)| rows(symbol, parameter)).collect();
    let width = |column: usize| rows.iter().map(|row| columns(&row[column])).max().unwrap_or_default();
    let (sign, key, unit) = (width(0), width(1), width(2));
    let line = |[symbol, name, of, allowed]: &[String; 4]| {
        format!("{INDENT}{symbol:<sign$}  {name:<key$}  {of:<unit$}  {allowed}\n")
    };
    rows.iter().map(line).collect()
}

fn rows(symbol: &str, parameter: &Parameter) -> Vec<[String; 4]> {
    let row = |motion: Motion, remark: &str| {
        let allowed = format!("{}{remark}", parameter.allowed());
        let (key, unit) = (parameter.key(motion).to_owned(), parameter.unit(motion).to_owned());
        [symbol.to_owned(), key, unit, allowed]
    };
    let differs = parameter.name != parameter.revolute_name || parameter.unit != parameter.revolute_unit;
    if differs {
        vec![row(Motion::Prismatic, ""), row(Motion::Revolute, ", on a revolute axis")]
    } else {
        vec![row(Motion::Prismatic, "")]
    }
}
