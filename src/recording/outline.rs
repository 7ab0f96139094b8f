//! The text of a `recording.toml` for bare logs as they were understood.

use std::fmt::Write as _;

use super::columns::ColumnMap;
use super::manifest::Manifest;
use super::signal::TIME_KEY;
use crate::units::Motion;

/// The text, for a folder that holds the logs and the machine.
pub(super) fn text(manifest: &Manifest, machine: &str) -> String {
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let motion = if manifest.motion == Some(Motion::Revolute) { "revolute" } else { "prismatic" };
    let mut text = String::from(
        "#:schema ./recording.schema.json\n# Written by `slideway init`: which files hold the runs, and which column is which signal.\n",
    );
    let _ = writeln!(text, "machine = {}", quoted(machine));
    let _ = writeln!(text, "motion = {}", quoted(motion));
    if let Some(period) = manifest.sample_period_s {
        let _ = writeln!(
            text,
            "sample_period_s = {period:?}  # assumed: --sample-period, as the log has no time"
        );
    }
    if let Some(note) = &manifest.note {
        let _ = writeln!(text, "note = {}", quoted(note));
    }
    let first = manifest.runs.first().map(|run| lines(&run.columns));
    let is_one = manifest.runs.iter().all(|run| Some(lines(&run.columns)) == first);
    let _ = write!(
        text,
        "\n# One file a run. A single run is cut at standstills. Of several some are held out: say which by role = \"training\" or\n\
         # \"held_out\", else whole runs are drawn. from_s and to_s take a part of a file.\n"
    );
    for run in &manifest.runs {
        let file = run.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let _ = writeln!(text, "[[run]]\nfile = {}\nname = {}", quoted(&file), quoted(&run.name));
        if !is_one {
            let _ = writeln!(text, "columns = {{ {} }}", lines(&run.columns).join(", "));
        }
        text.push('\n');
    }
    if let Some(columns) = first.filter(|columns| is_one && !columns.is_empty()) {
        let _ =
            writeln!(text, "# Signal = column and unit of the file; other columns are not read.\n[columns]");
        columns.iter().for_each(|line| text += &format!("{line}\n"));
    }
    text
}

/// `key = { column = …, unit = … }` of every signal whose column does not say it by its name.
fn lines(columns: &ColumnMap) -> Vec<String> {
    let time = columns.time.iter().map(|source| (TIME_KEY, source));
    let all = time.chain(columns.signals.iter().map(|(key, source)| (key.as_str(), source)));
    let quoted = |text: &str| toml::Value::from(text).to_string();
    all.filter_map(|(key, source)| {
        let (column, unit) = source.stated(key)?;
        Some(format!("{key} = {{ column = {}, unit = {} }}", quoted(column), quoted(unit)))
    })
    .collect()
}
