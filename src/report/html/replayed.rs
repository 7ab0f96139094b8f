//! A replay as a page.

use super::page::{Builder, Page, Part};
use super::{data, head, provenance, scene, traces};
use crate::machine::Machine;
use crate::recording::Recording;
use crate::report::material::{MachineShape, RunTraces};
use crate::twin::LinearLoop;

/// Runs whose figures stand in the page; the live view has them all.
const STILL: usize = 3;

/// Simulated strokes as a page: what came out of them, the machine, every signal.
///
/// `heads` and `rows` are the table of figures a run, `remark` says how they are counted.
pub fn replayed(
    recording: &Recording,
    machine: &Machine,
    table: (&[&str], &[Vec<String>], &str),
    command: &str,
) -> Page {
    let (heads, rows, remark) = table;
    let runs: Vec<RunTraces> =
        recording.runs().iter().map(|run| RunTraces::recorded(run, Some(machine))).collect();
    let name = &machine.description().name;
    let count = if runs.len() == 1 { "One run".to_owned() } else { format!("{} runs", runs.len()) };
    let warning = LinearLoop::warning(machine).map_or(String::new(), |text| format!(" {text}"));
    let sentence = format!("{count} replayed through the twin.{warning}");
    let mut page = Builder::new(
        &format!("{name}: replay"),
        head::plain_head(name, "replay", &sentence, recording.note.as_deref()),
    );
    let mut figures = Part::default();
    figures.table(heads, rows).remark(remark);
    page.section("runs", "Figures of the runs", figures);
    let shape = MachineShape::of(machine);
    page.section("machine", "The machine", scene::part(&shape, true));
    page.section("traces", "Signals", recorded(&runs, recording));
    let hash = [("machine", name.clone()), ("SHA-256 of the recording", recording.sha256()), version()];
    page.section("provenance", "Where this comes from", provenance::list(&hash, command));
    page.finish(&data::of(machine.motion(), &runs, Some(&shape)))
}

/// The version as a row.
pub(super) fn version() -> (&'static str, String) {
    ("slideway", env!("CARGO_PKG_VERSION").to_owned())
}

/// Figures of the first runs, and the live view of all.
pub(super) fn recorded(runs: &[RunTraces], recording: &Recording) -> Part {
    let mut part = Part::default();
    let mut still = Part::default();
    for run in runs.iter().take(STILL) {
        still.figure(traces::figure(run, recording.motion(), ""));
    }
    if runs.len() > STILL {
        still.remark(&format!("{} more runs are in the live view.", runs.len() - STILL));
    }
    part.live("traces", still);
    part
}
