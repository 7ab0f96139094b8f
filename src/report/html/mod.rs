//! Reports as pages: one self-contained file that answers the questions in the order in which they are asked.
//!
//! Every figure and number stands in the page without a script; where one may run, traces can be zoomed and the
//! machine moves.

mod budget;
mod checks;
mod compared;
mod crosschecked;
mod data;
mod extent;
mod force;
mod head;
mod hypotheses;
mod identifiability;
mod identified;
mod inspected;
mod next;
mod page;
mod partial;
mod place;
mod polar;
mod provenance;
mod replayed;
mod residual_whiteness;
mod response;
mod scale;
mod scene;
mod sheet;
mod spectrum;
mod traces;
mod unbroken;
mod withheld;

pub use compared::compared;
pub use crosschecked::crosschecked;
pub use identified::{Identified, Model, identified};
pub use inspected::{machine, recording};
pub use page::Page;
pub use replayed::replayed;
pub use response::{Responded, Response, bode, responded};
pub use sheet::sheet;

use super::material::Material;
use crate::diagnose::{Diagnosis, Verdict};
use crate::machine::Machine;
use page::Builder;

/// A diagnosis as a page.
///
/// `command` is what was typed, for the section on where the report comes from.
pub fn diagnosis(diagnosis: &Diagnosis, machine: &Machine, material: &Material, command: &str) -> Page {
    let motion = machine.motion();
    let title = format!("{}: {}", diagnosis.data.machine, head::word(diagnosis));
    let mut page = Builder::new(&title, head::head(diagnosis, motion));
    page.section("changes", "What changed", hypotheses::changes(diagnosis));
    page.section("extent", "How far", extent::part(diagnosis, material));
    page.section("budget", "Gap budget", budget::part(diagnosis, material));
    if diagnosis.verdict != Verdict::NoGap {
        page.section("where", "Where", place::part(diagnosis, material));
    }
    page.section("machine", "The machine", scene::part(&material.shape, true));
    page.section("traces", "Machine against twin", traces::part(material));
    page.section("force", force::title(motion), force::part(diagnosis, material));
    page.section("spectrum", "Spectrum and frequency response", spectrum::part(material));
    page.section("whiteness", "Residual whiteness", residual_whiteness::part(diagnosis));
    page.section("hypotheses", "Hypotheses", hypotheses::part(diagnosis));
    page.section("identifiability", "Identifiability of the parameters", identifiability::part(diagnosis));
    page.section("checks", "What was checked in the data", checks::part(diagnosis));
    page.section("next", "Next experiment", next::part(diagnosis, material));
    page.section("provenance", "Where this comes from", provenance::part(diagnosis, command));
    let mut data = data::of(motion, &material.runs, Some(&material.shape));
    data["before"] = material.baseline.into();
    page.finish(&data)
}
