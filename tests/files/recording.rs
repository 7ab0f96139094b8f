//! Reading, refusing, writing and splitting recordings.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use crate::support::{self, needs};
use proptest::prelude::*;
use slideway::error::{Error, ErrorKind};
use slideway::recording::{
    Existing, Format, PeriodSource, Recording, Role, Run, Signal, SplitRule, plausibility,
};
use slideway::units::{Dimension, Motion, Unit};
use tempfile::TempDir;

const GOOD: &str = "time_s,position_m,current_a\n0,0.1,1\n0.001,0.2,2\n0.002,0.3,3\n";
const ONE_RUN: &str = "[[run]]\nfile = \"log.csv\"\n";

/// A folder with recording.toml and log.csv.
fn folder(toml: &str, csv: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("recording.toml"), toml).unwrap();
    fs::write(folder.path().join("log.csv"), csv).unwrap();
    folder
}

fn read(toml: &str, csv: &str) -> Result<Recording, Error> {
    Recording::read(folder(toml, csv).path())
}

fn refusal(toml: &str, csv: &str) -> Error {
    let error = read(toml, csv).expect_err("this must be refused");
    assert!(error.remedy_text().is_some_and(|remedy| !remedy.is_empty()), "no remedy: {error}");
    error
}

#[derive(Debug, Default)]
struct Place<'a> {
    file: &'a str,
    row: Option<u64>,
    key: Option<&'a str>,
}

#[track_caller]
fn assert_refused(error: &Error, kind: ErrorKind, place: &Place<'_>, words: &[&str]) {
    let text = error.to_string();
    assert_eq!(error.kind(), kind, "{text}");
    assert_eq!(error.path().and_then(Path::file_name).unwrap(), place.file, "{text}");
    assert_eq!(error.row_number(), place.row, "{text}");
    assert_eq!(error.key_name(), place.key, "{text}");
    for word in words {
        assert!(text.contains(word), "`{word}` is not in: {text}");
    }
}

fn at_csv(row: u64, key: &str) -> Place<'_> {
    Place { file: "log.csv", row: Some(row), key: Some(key) }
}

fn at_toml(row: u64, key: &str) -> Place<'_> {
    Place { file: "recording.toml", row: Some(row), key: Some(key) }
}

// --- reading -------------------------------------------------------------------------------------------------

#[test]
fn exact_canonical_names_need_no_columns() {
    let recording = read(ONE_RUN, GOOD).unwrap();
    let run = &recording.runs()[0];
    assert_eq!(recording.motion(), Motion::Prismatic);
    assert_eq!(recording.sample_period_s(), 0.001);
    assert_eq!(run.name(), "log");
    assert_eq!(run.signal(Signal::Position).unwrap(), [0.1, 0.2, 0.3]);
    assert_eq!(run.signal(Signal::Current).unwrap(), [1.0, 2.0, 3.0]);
    assert_eq!(run.timing.source, PeriodSource::Measured);
    assert!(recording.units_read.is_empty() && run.ignored_columns.is_empty());
}

#[test]
fn exact_columns_units_scales_and_metadata_are_read() {
    let toml = r#"
        sample_period_s = 250e-6
        machine = "../slide"
        note = "after the overhaul"
        [[run]]
        file = "log.csv"
        name = "stroke 1"
        role = "held_out"
        stroke_m = 0.02
        set = { "controller.integral" = 22, drive = { gain = 1.5 } }
        columns = { current_a = { column = "i", unit = "mA" } }
        [columns]
        position_m = { column = "pos", unit = "mm" }
        control_effort_v = { column = "dac", unit = 0.5, scale = -2, offset = 0.25 }
        current_a = "nothing"
    "#;
    let recording = read(toml, "pos,dac,i,temperature\n7.45,1,500,20\n8,2,600,20\n").unwrap();
    let run = recording.run("stroke 1").unwrap();
    assert_eq!(run.signal(Signal::Position).unwrap(), [0.00745, 0.008]);
    assert_eq!(run.signal(Signal::ControlEffort).unwrap(), [-0.75, -1.75]);
    assert_eq!(run.signal(Signal::Current).unwrap(), [0.5, 0.6]);
    assert_eq!(run.role, Some(Role::HeldOut));
    assert_eq!(run.metadata["stroke_m"].as_float(), Some(0.02));
    assert_eq!(run.settings["controller.integral"].as_integer(), Some(22));
    assert_eq!(run.settings["drive.gain"].as_float(), Some(1.5));
    assert_eq!(run.ignored_columns, ["temperature"]);
    assert_eq!(run.timing.source, PeriodSource::Declared);
    assert_eq!(recording.note.as_deref(), Some("after the overhaul"));
    assert!(recording.machine.as_ref().unwrap().ends_with("../slide"));
    let echoed: Vec<_> = recording.units_read.iter().map(ToString::to_string).collect();
    assert!(echoed.contains(&"position_m from column `pos` [mm] × 0.001 m".to_owned()), "{echoed:?}");
    let effort = recording.units_read.iter().find(|read| read.key == "control_effort_v").unwrap();
    assert_eq!((effort.factor, effort.scale, effort.offset), (-1.0, -2.0, 0.25));
}

/// Three samples at 0, 1 and 2 ms: the ranges share ends, not samples.
#[test]
fn exact_time_range_of_a_run_is_used_alone() {
    let parts = "[[run]]\nfile = \"log.csv\"\nname = \"a\"\nto_s = 0.001\nrole = \"training\"\n\
                 [[run]]\nfile = \"log.csv\"\nname = \"b\"\nfrom_s = 1e-3\nrole = \"held_out\"\n";
    let declared = format!("sample_period_s = 1e-3\n{parts}");
    for (toml, csv) in [(declared.as_str(), "position_m\n0.1\n0.2\n0.3\n"), (parts, GOOD)] {
        // One sample does not tell its period.
        let toml = toml.replace("to_s = 0.001", "to_s = 0.002");
        let recording = read(&toml, csv).unwrap();
        let run = |name: &str| recording.run(name).unwrap();
        assert_eq!(run("a").signal(Signal::Position).unwrap(), [0.1, 0.2]);
        assert_eq!(run("b").signal(Signal::Position).unwrap(), [0.2, 0.3]);
        assert_eq!((run("a").start_s, run("b").start_s), (0.0, 0.001));
        assert!(run("a").metadata.is_empty());
        // The sample at 1 ms stands on both sides.
        let error = recording.split(SplitRule::default()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Inconsistent);
    }
    let recording = read(&declared, "position_m\n0.1\n0.2\n0.3\n").unwrap();
    assert_eq!(recording.run("a").unwrap().signal(Signal::Position).unwrap(), [0.1]);
    let (training, held_out) = recording.split(SplitRule::default()).unwrap();
    assert_eq!((training.runs()[0].len(), held_out.runs()[0].len()), (1, 2));
}

/// What stands outside the range is not looked at: here a gap that would be refused.
#[test]
fn exact_faults_outside_the_time_range_do_not_matter() {
    let csv = "time_s,position_m\n0,0.1\n0.001,0.2\n0.002,0.3\n0.003,0.4\n0.004,0.5\n5,0.6\n5.001,0.7\n";
    assert!(refusal(ONE_RUN, csv).to_string().contains("gap"));
    let recording = read(&format!("{ONE_RUN}to_s = 1\n"), csv).unwrap();
    assert_eq!(recording.runs()[0].len(), 5);
    let error = refusal(&format!("{ONE_RUN}from_s = 0.002\n"), csv);
    assert_refused(&error, ErrorKind::Inconsistent, &at_csv(7, "time_s"), &["gap"]);
}

#[test]
fn exact_empty_time_range_is_refused() {
    let cases = [
        ("from_s = 2\nto_s = 1\n", ErrorKind::OutOfRange, "from 2 s to 1 s"),
        ("from_s = 1\nto_s = 1\n", ErrorKind::OutOfRange, "ends after it begins"),
        ("from_s = \"start\"\n", ErrorKind::Syntax, "seconds"),
        ("from_s = nan\n", ErrorKind::Syntax, "seconds"),
    ];
    for (lines, kind, word) in cases {
        let error = refusal(&format!("{ONE_RUN}{lines}"), GOOD);
        assert_refused(&error, kind, &at_toml(3, "run.1.from_s"), &[word]);
    }
    for (line, key) in
        [("from_s = 3\n", "from_s"), ("from_s = 5e-4\nto_s = 6e-4\n", "from_s"), ("to_s = 0\n", "to_s")]
    {
        let error = refusal(&format!("{ONE_RUN}{line}"), GOOD);
        let place = Place { file: "log.csv", row: None, key: Some(key) };
        assert_refused(&error, ErrorKind::TooLittleData, &place, &["no sample", "0 s to 0.002 s"]);
    }
    let slip = refusal(&format!("{ONE_RUN}from = 3\nfrom_S = 1\n"), GOOD);
    assert_refused(&slip, ErrorKind::UnknownKey, &at_toml(4, "run.1.from_S"), &["from_s"]);
}

#[test]
fn exact_motion_follows_the_signals() {
    let revolute = read(ONE_RUN, "time_s,position_rad,torque_nm\n0,0,1\n0.1,1,2\n").unwrap();
    assert_eq!(revolute.motion(), Motion::Revolute);
    assert_eq!(revolute.runs()[0].signal(Signal::Thrust).unwrap(), [1.0, 2.0]);
    let declared =
        read("motion = \"revolute\"\n[[run]]\nfile = \"log.csv\"\n", "time_s,current_a\n0,0\n0.1,1\n");
    assert_eq!(declared.unwrap().motion(), Motion::Revolute);
}

#[test]
fn exact_signals_come_in_signal_path_order_and_missing_ones_are_refused() {
    let recording =
        read(ONE_RUN, "position_m,current_a,position_reference_m,time_s\n0,0,0,0\n0,1,0,0.1\n").unwrap();
    let run = &recording.runs()[0];
    let order: Vec<_> = run.signals().keys().copied().collect();
    assert_eq!(order, [Signal::PositionReference, Signal::Current, Signal::Position]);
    assert_eq!(run.require(Signal::Current).unwrap(), [0.0, 1.0]);
    let error = run.require(Signal::ControlEffort).unwrap_err();
    let place = Place { file: "log.csv", row: None, key: Some("control_effort_v") };
    assert_refused(
        &error,
        ErrorKind::Missing,
        &place,
        &["run `log`", "position_m", "control effort", "[columns]"],
    );
}

#[test]
fn exact_csv_dialects_read_alike() {
    let dialects = [
        GOOD.to_owned(),
        GOOD.replace(',', ";"),
        GOOD.replace(',', ";").replace('.', ","),
        GOOD.replace(',', "\t"),
        GOOD.replace(',', "\t").replace('.', ","),
        format!("\u{feff}{GOOD}"),
        GOOD.replace('\n', "\r\n"),
        format!("# drive 7\n# 4 kHz, gain 3\n\n{GOOD}"),
        GOOD.replace("time_s,position_m,current_a", "\"time_s\",\"position_m\", current_a ")
            .replace(",2\n", ",\"2\"\n"),
        GOOD.trim_end().to_owned(),
        format!("{GOOD}\n\n"),
        GOOD.replace("0.3", " 3.0e-1 ").replace("0.2", "+.2"),
    ];
    for text in dialects {
        let recording = read(ONE_RUN, &text).unwrap_or_else(|error| panic!("{text:?}: {error}"));
        let run = &recording.runs()[0];
        assert_eq!(run.signal(Signal::Position).unwrap(), [0.1, 0.2, 0.3], "{text:?}");
        assert_eq!(run.signal(Signal::Current).unwrap(), [1.0, 2.0, 3.0], "{text:?}");
        assert_eq!(recording.sample_period_s(), 0.001, "{text:?}");
    }
}

#[test]
fn exact_jitter_is_reported_with_its_row() {
    let csv = "time_s,current_a,position_m\n0,0,0\n1e-3,0,0\n2.2e-3,0,0\n3e-3,0,0\n4e-3,0,0\n";
    let recording = read("sample_period_s = 1e-3\n[[run]]\nfile=\"log.csv\"\n", csv).unwrap();
    let timing = &recording.runs()[0].timing;
    assert_eq!(timing.source, PeriodSource::DeclaredAndMeasured);
    assert_eq!(timing.irregular_rows, [4, 5]);
    assert_eq!(timing.irregular_intervals, 2);
    assert!(timing.worst_jitter_row == Some(4) || timing.worst_jitter_row == Some(5));
}

// --- refusals: the TOML file ---------------------------------------------------------------------------------

#[test]
fn exact_missing_recording_file_is_refused() {
    let empty = TempDir::new().unwrap();
    let error = Recording::read(empty.path()).unwrap_err();
    let place = Place { file: "recording.toml", ..Place::default() };
    assert_refused(&error, ErrorKind::Missing, &place, &["no such file", "[[run]]"]);
    let csv = empty.path().join("log.csv");
    fs::write(&csv, GOOD).unwrap();
    let place = Place { file: "log.csv", ..Place::default() };
    assert_refused(
        &Recording::read(&csv).unwrap_err(),
        ErrorKind::Missing,
        &place,
        &["not TOML", "recording.toml"],
    );
}

#[test]
fn exact_toml_syntax_error_is_refused() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\nrole = = 3\n", GOOD);
    assert_refused(&error, ErrorKind::Syntax, &Place { key: error.key_name(), ..at_toml(3, "") }, &["row 3"]);
}

#[test]
fn exact_unknown_top_level_key_is_refused() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\n\n[column]\nposition_m = \"p\"\n", GOOD);
    assert_refused(
        &error,
        ErrorKind::UnknownKey,
        &at_toml(4, "column"),
        &["did you mean `columns`?", "sample_period_s"],
    );
    let error = refusal("sample_peroid_s = 1\n[[run]]\nfile = \"log.csv\"\n", GOOD);
    assert_refused(
        &error,
        ErrorKind::UnknownKey,
        &at_toml(1, "sample_peroid_s"),
        &["did you mean `sample_period_s`?"],
    );
}

#[test]
fn exact_misspelt_run_key_is_refused_and_metadata_is_not() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\nroel = \"training\"\n", GOOD);
    assert_refused(&error, ErrorKind::UnknownKey, &at_toml(3, "run.1.roel"), &["did you mean `role`?"]);
    assert!(read("[[run]]\nfile = \"log.csv\"\ntile = 3\nfeed = 2\nsite = \"B\"\n", GOOD).is_ok());
}

#[test]
fn exact_unknown_signal_in_columns_is_refused() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\n[columns]\npositon_m = \"p\"\n", GOOD);
    let words = ["did you mean `position_m`?", "control_effort_v", "load_position_rad"];
    assert_refused(&error, ErrorKind::UnknownKey, &at_toml(4, "columns.positon_m"), &words);
    let toml = "[[run]]\nfile = \"log.csv\"\n[[run]]\nfile = \"log.csv\"\nname = \"b\"\ncolumns = { curent_a = \"i\" }\n";
    let error = refusal(toml, GOOD);
    assert_refused(&error, ErrorKind::UnknownKey, &at_toml(6, "run.2.columns.curent_a"), &["current_a"]);
}

#[test]
fn exact_unknown_key_of_a_column_is_refused() {
    let error = refusal(
        "[[run]]\nfile = \"log.csv\"\n[columns]\nposition_m = { column = \"p\", units = \"mm\" }\n",
        GOOD,
    );
    assert_refused(
        &error,
        ErrorKind::UnknownKey,
        &at_toml(4, "columns.position_m.units"),
        &["did you mean `unit`?"],
    );
}

#[test]
fn exact_wrong_unit_is_refused() {
    let toml =
        |unit: &str| format!("[[run]]\nfile = \"log.csv\"\n[columns]\nposition_m = {{ unit = {unit} }}\n");
    let error = refusal(&toml("\"V\""), GOOD);
    let words = ["unit `V`, a unit of voltage", "a unit of length", "mm", "µm"];
    assert_refused(&error, ErrorKind::Unit, &at_toml(4, "columns.position_m.unit"), &words);
    let error = refusal(&toml("\"furlong\""), GOOD);
    assert_refused(
        &error,
        ErrorKind::Unit,
        &at_toml(4, "columns.position_m.unit"),
        &["unknown unit `furlong`", "mm"],
    );
    let error = refusal(&toml("-3"), GOOD);
    assert_refused(&error, ErrorKind::Syntax, &at_toml(4, "columns.position_m.unit"), &["-3", "m per count"]);
}

#[test]
fn exact_wrong_values_in_toml_are_refused() {
    let cases = [
        ("sample_period_s = 0\n", ErrorKind::OutOfRange, "sample_period_s", "positive"),
        ("sample_period_s = \"1 ms\"\n", ErrorKind::Syntax, "sample_period_s", "positive"),
        ("motion = \"linear\"\n", ErrorKind::Syntax, "motion", "prismatic"),
        ("note = 3\n", ErrorKind::Syntax, "note", "text"),
        ("columns = 3\n", ErrorKind::Syntax, "columns", "table"),
        ("columns = { position_m = 3 }\n", ErrorKind::Syntax, "columns.position_m", "column name"),
        (
            "columns = { position_m = { scale = 0 } }\n",
            ErrorKind::OutOfRange,
            "columns.position_m.scale",
            "not zero",
        ),
        (
            "columns = { position_m = { offset = nan } }\n",
            ErrorKind::Syntax,
            "columns.position_m.offset",
            "finite",
        ),
    ];
    for (line, kind, key, word) in cases {
        assert_refused(&refusal(&format!("{line}{ONE_RUN}"), GOOD), kind, &at_toml(1, key), &[word]);
    }
}

#[test]
fn exact_wrong_role_is_refused() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\nrole = \"validation\"\n", GOOD);
    let words = ["validation", "\"training\" or \"held_out\""];
    assert_refused(&error, ErrorKind::Syntax, &at_toml(3, "run.1.role"), &words);
}

#[test]
fn exact_recording_without_runs_is_refused() {
    let place = Place { file: "recording.toml", row: None, key: Some("run") };
    assert_refused(&refusal("note = \"x\"\n", GOOD), ErrorKind::Missing, &place, &["[[run]]"]);
    assert_refused(&refusal("run = []\n", GOOD), ErrorKind::Missing, &at_toml(1, "run"), &["[[run]]"]);
    let error = refusal("[[run]]\nrole = \"training\"\n", GOOD);
    assert_refused(&error, ErrorKind::Missing, &at_toml(1, "run.1"), &["`file`"]);
}

#[test]
fn exact_duplicate_run_name_is_refused() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\n\n[[run]]\nfile = \"log.csv\"\n", GOOD);
    assert_refused(&error, ErrorKind::Inconsistent, &at_toml(4, "run.2"), &["`log` a second time", "run 1"]);
}

#[test]
fn exact_run_name_that_cannot_name_a_file_is_refused() {
    let error = refusal("[[run]]\nfile = \"log.csv\"\nname = \"../x\"\n", GOOD);
    let place = Place { file: "log.csv", row: None, key: Some("name") };
    assert_refused(&error, ErrorKind::OutOfRange, &place, &["../x", "slashes"]);
}

// --- refusals: the tables ------------------------------------------------------------------------------------

#[test]
fn exact_missing_run_file_is_refused() {
    let error = refusal("[[run]]\nfile = \"other.csv\"\n", GOOD);
    let place = Place { file: "other.csv", ..Place::default() };
    assert_refused(&error, ErrorKind::Missing, &place, &["no such file", "data_folder"]);
}

#[test]
fn exact_missing_column_is_refused() {
    let toml = format!("{ONE_RUN}[columns]\nposition_m = \"posiiton_m\"\n");
    let place = Place { file: "log.csv", row: None, key: Some("posiiton_m") };
    let words = ["time_s, position_m, current_a", "did you mean `position_m`?", "for `position_m`"];
    assert_refused(&refusal(&toml, GOOD), ErrorKind::Missing, &place, &words);
}

#[test]
fn exact_column_that_stands_twice_is_refused() {
    let place = Place { file: "log.csv", row: None, key: Some("position_m") };
    let error = refusal(ONE_RUN, "time_s,position_m,position_m\n0,1,2\n1e-3,1,2\n");
    assert_refused(&error, ErrorKind::Inconsistent, &place, &["2 columns named `position_m`"]);
}

#[test]
fn exact_one_column_for_two_signals_is_refused() {
    let toml = format!("{ONE_RUN}[columns]\nload_position_m = \"position_m\"\n");
    let place = Place { file: "log.csv", row: None, key: Some("position_m") };
    let words = ["column `position_m`", "`load_position_m` reads too"];
    assert_refused(&refusal(&toml, GOOD), ErrorKind::Inconsistent, &place, &words);
}

#[test]
fn exact_field_that_is_no_number_is_refused() {
    let csv = |field: &str| format!("time_s,position_m,current_a\n0,0,1\n0.001,{field},2\n0.002,0,3\n");
    let cases = [
        ("abc", ErrorKind::Syntax, "`abc`"),
        ("", ErrorKind::Missing, "an empty field"),
        ("NaN", ErrorKind::NotFinite, "`NaN`"),
        ("inf", ErrorKind::NotFinite, "`inf`"),
        ("1e999", ErrorKind::NotFinite, "`1e999`"),
        ("0x1F", ErrorKind::Syntax, "`0x1F`"),
    ];
    for (field, kind, word) in cases {
        assert_refused(
            &refusal(ONE_RUN, &csv(field)),
            kind,
            &at_csv(3, "position_m"),
            &[word, "a finite number"],
        );
    }
    let commented = format!("# drive 7\n{}", csv("abc"));
    assert_refused(&refusal(ONE_RUN, &commented), ErrorKind::Syntax, &at_csv(3, "position_m"), &["abc"]);
}

#[test]
fn exact_thousands_separator_is_refused() {
    let csv = "time_s;position_m\n0;1.234,5\n";
    assert_refused(
        &refusal(ONE_RUN, csv),
        ErrorKind::Syntax,
        &at_csv(2, "position_m"),
        &["1.234,5", "thousands"],
    );
}

#[test]
fn exact_ragged_row_is_refused() {
    for (row, count) in [("0.001,0.2", "2 fields"), ("0.001,0.2,3,4", "4 fields")] {
        let csv = format!("time_s,position_m,current_a\n0,0.1,1\n{row}\n0.002,0.3,3\n");
        let place = Place { file: "log.csv", row: Some(3), key: None };
        assert_refused(&refusal(ONE_RUN, &csv), ErrorKind::Syntax, &place, &[count, "expected 3"]);
    }
}

#[test]
fn exact_empty_line_inside_is_refused() {
    for end in ["\n", "\r\n"] {
        let csv = "time_s,position_m\n0,0\n\n0.001,0\n".replace('\n', end);
        let place = Place { file: "log.csv", row: Some(3), key: None };
        assert_refused(&refusal(ONE_RUN, &csv), ErrorKind::Syntax, &place, &["an empty line"]);
    }
}

#[test]
fn exact_units_below_the_header_must_agree_with_its_names() {
    let error = refusal(ONE_RUN, "time_s,position_m\n[s],[mm]\n0,0\n0.001,0\n");
    let place = Place { file: "log.csv", row: None, key: Some("position_m") };
    assert_refused(&error, ErrorKind::Inconsistent, &place, &["states as mm", "[columns]"]);
    let recording = read(ONE_RUN, "time_s,position_m\n[s],[m]\n0,0.5\n0.001,0.5\n").unwrap();
    assert_eq!(recording.runs()[0].signal(Signal::Position).unwrap(), [0.5, 0.5]);
}

#[test]
fn exact_second_header_line_is_refused() {
    let error = refusal(ONE_RUN, "time_s,position_m\nclock,drive\n0,0\n0.001,0\n");
    let words = ["a second header line (clock, drive)", "[columns]"];
    assert_refused(&error, ErrorKind::Syntax, &Place { key: error.key_name(), ..at_csv(2, "") }, &words);
}

#[test]
fn exact_table_without_header_or_rows_is_refused() {
    let place = Place { file: "log.csv", row: None, key: Some("time_s") };
    let words = ["the columns column_1, column_2", "a time column"];
    assert_refused(&refusal(ONE_RUN, "0,1\n1,2\n"), ErrorKind::Missing, &place, &words);
    let place = Place { file: "log.csv", ..Place::default() };
    assert_refused(&refusal(ONE_RUN, ""), ErrorKind::TooLittleData, &place, &["an empty file"]);
    let error = refusal(ONE_RUN, "time_s,position_m\n");
    assert_refused(&error, ErrorKind::TooLittleData, &place, &["a header without rows"]);
}

#[test]
fn exact_file_without_signals_is_refused() {
    let place = Place { file: "log.csv", row: None, key: Some("columns") };
    let error = refusal(ONE_RUN, "time_s,pos\n0,0\n0.001,0\n");
    assert_refused(&error, ErrorKind::Missing, &place, &["time_s, pos", "position_m", "[columns]"]);
    let error = refusal(ONE_RUN, "time_s,position_reference_m\n0,0\n0.001,0\n");
    let place = Place { file: "log.csv", row: None, key: Some("log") };
    assert_refused(&error, ErrorKind::Missing, &place, &["without any measured signal", "position_m"]);
}

#[test]
fn exact_mixed_motion_is_refused() {
    let place = Place { file: "log.csv", row: None, key: Some("torque_nm") };
    let error = refusal(ONE_RUN, "time_s,position_m,torque_nm\n0,0,0\n0.001,0,0\n");
    assert_refused(&error, ErrorKind::Inconsistent, &place, &["position_m", "prismatic", "revolute"]);
    let error = refusal(&format!("motion = \"revolute\"\n{ONE_RUN}"), GOOD);
    let place = Place { file: "log.csv", row: None, key: Some("motion") };
    assert_refused(&error, ErrorKind::Inconsistent, &place, &["prismatic", "revolute", "recording.toml"]);
    let error = refusal(ONE_RUN, "time_s,current_a\n0,0\n0.001,0\n");
    let place = Place { file: "recording.toml", row: None, key: Some("motion") };
    assert_refused(&error, ErrorKind::Missing, &place, &["slides or turns"]);
}

// --- refusals: time ------------------------------------------------------------------------------------------

fn times(times: &[f64]) -> String {
    times.iter().fold("time_s,position_m\n".to_owned(), |text, time| text + &format!("{time},0\n"))
}

#[test]
fn exact_recording_without_time_is_refused() {
    let place = Place { file: "log.csv", row: None, key: Some("time_s") };
    let error = refusal(ONE_RUN, "t_s,position_m\n0,0\n");
    assert_refused(
        &error,
        ErrorKind::Missing,
        &place,
        &["t_s, position_m", "sample_period_s", "did you mean `t_s`?"],
    );
    assert_refused(&refusal(ONE_RUN, &times(&[0.0])), ErrorKind::TooLittleData, &place, &["single sample"]);
}

#[test]
fn exact_time_that_does_not_increase_is_refused() {
    for (fault, word) in [(0.001, "0.001 s after 0.001 s"), (0.0005, "0.0005 s after 0.001 s")] {
        let error = refusal(ONE_RUN, &times(&[0.0, 0.001, fault, 0.003]));
        assert_refused(&error, ErrorKind::Inconsistent, &at_csv(4, "time_s"), &[word, "increases"]);
    }
}

#[test]
fn exact_gap_is_refused() {
    let error = refusal(ONE_RUN, &times(&[0.0, 0.001, 0.002, 0.003, 0.004, 0.011, 0.012, 0.013]));
    let words = ["a gap of 7 periods", "split the run there or resample"];
    assert_refused(&error, ErrorKind::Inconsistent, &at_csv(7, "time_s"), &words);
}

#[test]
fn exact_period_that_the_time_column_contradicts_is_refused() {
    for period in ["1", "0.00101", "250e-6"] {
        let error =
            refusal(&format!("sample_period_s = {period}\n{ONE_RUN}"), &times(&[0.0, 0.001, 0.002, 0.003]));
        let place = Place { file: "log.csv", row: None, key: Some("time_s") };
        assert_refused(&error, ErrorKind::Inconsistent, &place, &["0.001 s", "sample_period_s declares"]);
    }
}

#[test]
fn exact_renamed_time_column_is_named_in_refusals() {
    let toml = format!("{ONE_RUN}[columns]\ntime_s = {{ column = \"t_ms\", unit = \"ms\" }}\n");
    let recording = read(&toml, "t_ms,position_m\n0,0\n0.25,0\n0.5,0\n").unwrap();
    assert_eq!(recording.sample_period_s(), 250e-6);
    let error = refusal(&toml, "t_ms,position_m\n0,0\n0.25,0\n0.2,0\n");
    assert_refused(&error, ErrorKind::Inconsistent, &at_csv(4, "t_ms"), &["0.0002 s after 0.00025 s"]);
}

#[test]
fn exact_runs_of_different_period_are_refused() {
    let folder = folder("[[run]]\nfile = \"log.csv\"\n[[run]]\nfile = \"slow.csv\"\n", GOOD);
    fs::write(folder.path().join("slow.csv"), times(&[0.0, 0.002, 0.004])).unwrap();
    let error = Recording::read(folder.path()).unwrap_err();
    let place = Place { file: "slow.csv", row: None, key: Some("slow") };
    assert_refused(&error, ErrorKind::Inconsistent, &place, &["0.002 s", "0.001 s, as in `log`"]);
}

// --- refusals: units that cannot be right --------------------------------------------------------------------

/// A sinusoidal stroke; each signal multiplied by a factor.
fn stroke(motion: Motion, position: f64, velocity: f64, reference: f64) -> Run {
    const PERIOD_S: f64 = 1e-3;
    let angle = |k: i32| f64::from(k) * PERIOD_S * 3.0;
    let signals = BTreeMap::from([
        (Signal::PositionReference, (0..5000).map(|k| 0.1 * angle(k).sin() * reference).collect()),
        (Signal::Position, (0..5000).map(|k| (0.3 + 0.0999 * (angle(k) - 0.002).sin()) * position).collect()),
        (Signal::Velocity, (0..5000).map(|k| 0.3 * angle(k).cos() * velocity).collect()),
    ]);
    Run::new("stroke", motion, PERIOD_S, signals).unwrap()
}

#[test]
fn exact_right_units_are_plausible() {
    for motion in [Motion::Prismatic, Motion::Revolute] {
        assert_eq!(plausibility(&stroke(motion, 1.0, 1.0, 1.0)), []);
        // A wrong sign or gear is a matter for diagnosis, not for units.
        assert_eq!(plausibility(&stroke(motion, 1.0, -1.0, 1.0)), []);
        assert_eq!(plausibility(&stroke(motion, 2.0, 1.0, 1.0)), []);
    }
}

#[test]
fn exact_forgotten_units_are_found() {
    let cases = [
        (Motion::Prismatic, [1e3, 1.0, 1e3], "velocity_m_per_s", "1/1000"),
        (Motion::Prismatic, [1.0, 1e3, 1.0], "velocity_m_per_s", "1000 ×"),
        (Motion::Prismatic, [1.0, 60.0, 1.0], "velocity_m_per_s", "60.0 ×"),
        (Motion::Prismatic, [1.0, 1.0, 1e3], "position_m", "1/1000"),
        (Motion::Prismatic, [1e3, 1e3, 1.0], "position_m", "1000 ×"),
        (Motion::Revolute, [1.0, 57.295_779_513, 1.0], "velocity_rad_per_s", "57.3 ×"),
        (Motion::Revolute, [1.0, 9.549_296_585, 1.0], "velocity_rad_per_s", "9.5 ×"),
        (Motion::Revolute, [1.0, 1.0, 57.295_779_513], "position_rad", "1/57.3"),
    ];
    for (motion, [position, velocity, reference], key, factor) in cases {
        let findings = plausibility(&stroke(motion, position, velocity, reference));
        let found = findings.iter().any(|finding| finding.key == key && finding.found.contains(factor));
        assert!(found, "{key} {factor}: {findings:?}");
    }
}

#[test]
fn exact_noise_and_standstill_are_plausible() {
    // A fixed linear congruential sequence: noise that is the same in every run of the test.
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut samples = |size: f64| (0..5000).map(|_| size * noise()).collect::<Vec<f64>>();
    let signals = BTreeMap::from([
        (Signal::PositionReference, vec![0.1; 5000]),
        (Signal::Position, samples(1e-7)),
        (Signal::Velocity, samples(1e-1)),
        (Signal::LoadPosition, samples(1e-4)),
    ]);
    assert_eq!(plausibility(&Run::new("dwell", Motion::Prismatic, 1e-3, signals).unwrap()), []);
}

#[test]
fn exact_implausible_units_are_refused_at_the_door() {
    let csv = |run: &Run| {
        let (q, v) = (run.signal(Signal::Position).unwrap(), run.signal(Signal::Velocity).unwrap());
        let rows = q.iter().zip(v).map(|(q, v)| format!("{q},{v}\n"));
        rows.fold("position_m,velocity_m_per_s\n".to_owned(), |text, row| text + &row)
    };
    let toml = format!("sample_period_s = 1e-3\n{ONE_RUN}");
    let place = |key| Place { file: "log.csv", row: None, key: Some(key) };
    let error = refusal(&toml, &csv(&stroke(Motion::Prismatic, 1.0, 1e3, 1.0)));
    let words = ["`velocity_m_per_s` about 1000 × the derivative of `position_m`", "unit = \"mm/s\""];
    assert_refused(&error, ErrorKind::Unit, &place("velocity_m_per_s"), &words);
    let error = refusal(&toml, &csv(&stroke(Motion::Prismatic, 1e3, 1e3, 1.0)));
    assert_refused(&error, ErrorKind::Unit, &place("position_m"), &["a travel of 200 m", "unit = \"mm\""]);
    let error = refusal(ONE_RUN, "time_s,position_m\n0,0\n1,0\n2,0\n");
    assert_refused(&error, ErrorKind::Unit, &place("time_s"), &["one sample every 1 s", "unit = \"ms\""]);
    let error = refusal(&toml, "velocity_m_per_s\n5000\n0\n");
    assert_refused(&error, ErrorKind::Unit, &place("velocity_m_per_s"), &["5000 m/s", "unit = \"mm/s\""]);
}

// --- Parquet -------------------------------------------------------------------------------------------------

mod parquet_files {
    use super::*;
    use parquet::column::writer::ColumnWriter;
    use parquet::data_type::ByteArray;
    use parquet::file::metadata::KeyValue;
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;
    use std::sync::Arc;

    /// Numbers, or what is none, of a column and the type that the file states for it.
    enum Stored {
        Double(Vec<Option<f64>>),
        Float(Vec<f32>),
        Int32(Vec<i32>),
        Int64(Vec<i64>),
        Text(Vec<&'static str>),
    }

    fn folder_with(columns: Vec<(&str, Stored)>) -> TempDir {
        folder_told(columns, None)
    }

    /// A file with columns `TYPE name`, and what pandas says about them.
    fn folder_told(columns: Vec<(&str, Stored)>, pandas: Option<&str>) -> TempDir {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("recording.toml"), "[[run]]\nfile = \"log.parquet\"\n").unwrap();
        let fields: String = columns.iter().map(|(field, _)| format!("OPTIONAL {field};\n")).collect();
        let schema = Arc::new(parse_message_type(&format!("message schema {{ {fields} }}")).unwrap());
        let told = pandas.map(|told| vec![KeyValue::new("pandas".to_owned(), told.to_owned())]);
        let properties = Arc::new(WriterProperties::builder().set_key_value_metadata(told).build());
        let file = fs::File::create(folder.path().join("log.parquet")).unwrap();
        let mut writer = SerializedFileWriter::new(file, schema, properties).unwrap();
        let mut group = writer.next_row_group().unwrap();
        for (_, stored) in columns {
            let mut column = group.next_column().unwrap().unwrap();
            match (column.untyped(), stored) {
                (ColumnWriter::DoubleColumnWriter(to), Stored::Double(values)) => {
                    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
                    let values: Vec<f64> = values.into_iter().flatten().collect();
                    to.write_batch(&values, Some(&levels), None).unwrap();
                }
                (ColumnWriter::FloatColumnWriter(to), Stored::Float(values)) => {
                    to.write_batch(&values, Some(&vec![1; values.len()]), None).unwrap();
                }
                (ColumnWriter::Int32ColumnWriter(to), Stored::Int32(values)) => {
                    to.write_batch(&values, Some(&vec![1; values.len()]), None).unwrap();
                }
                (ColumnWriter::Int64ColumnWriter(to), Stored::Int64(values)) => {
                    to.write_batch(&values, Some(&vec![1; values.len()]), None).unwrap();
                }
                (ColumnWriter::ByteArrayColumnWriter(to), Stored::Text(values)) => {
                    let values: Vec<ByteArray> = values.into_iter().map(ByteArray::from).collect();
                    to.write_batch(&values, Some(&vec![1; values.len()]), None).unwrap();
                }
                _ => panic!("a column of another type"),
            }
            column.close().unwrap();
        }
        group.close().unwrap();
        writer.close().unwrap();
        folder
    }

    fn time() -> (&'static str, Stored) {
        ("DOUBLE time_s", Stored::Double([0.0, 0.001, 0.002].map(Some).to_vec()))
    }

    fn at(row: u64) -> Place<'static> {
        Place { file: "log.parquet", row: Some(row), key: Some("position_m") }
    }

    #[test]
    fn exact_integer_and_single_precision_columns_are_read() {
        let current = ("INT32 current_a", Stored::Int32(vec![1, -2, 3]));
        let thrust = ("INT32 thrust_n (UINT_8)", Stored::Int32(vec![0, 200, 255]));
        let effort = ("INT64 control_effort_v (UINT_64)", Stored::Int64(vec![0, 5, 7]));
        let position = ("FLOAT position_m", Stored::Float(vec![0.5, 0.25, 0.125]));
        let folder = folder_with(vec![current, time(), thrust, effort, position]);
        let recording = Recording::read(folder.path()).unwrap();
        let run = &recording.runs()[0];
        assert_eq!(run.signal(Signal::Current).unwrap(), [1.0, -2.0, 3.0]);
        assert_eq!(run.signal(Signal::Thrust).unwrap(), [0.0, 200.0, 255.0]);
        assert_eq!(run.signal(Signal::ControlEffort).unwrap(), [0.0, 5.0, 7.0]);
        assert_eq!(run.signal(Signal::Position).unwrap(), [0.5, 0.25, 0.125]);
    }

    #[test]
    fn exact_null_is_refused() {
        let position = ("DOUBLE position_m", Stored::Double(vec![Some(0.0), None, Some(1.0)]));
        let error = Recording::read(folder_with(vec![time(), position]).path()).unwrap_err();
        assert_refused(&error, ErrorKind::Missing, &at(2), &["null", "a finite number"]);
    }

    #[test]
    fn exact_nan_is_refused() {
        let position = ("DOUBLE position_m", Stored::Double([0.0, 1.0, f64::NAN].map(Some).to_vec()));
        let error = Recording::read(folder_with(vec![time(), position]).path()).unwrap_err();
        assert_refused(&error, ErrorKind::NotFinite, &at(3), &["NaN"]);
    }

    #[test]
    fn exact_columns_without_numbers_are_refused() {
        let refused = |position: (&str, Stored), pandas: Option<&str>, word: &str| {
            let error = Recording::read(folder_told(vec![time(), position], pandas).path()).unwrap_err();
            let place = Place { row: None, ..at(0) };
            assert_refused(&error, ErrorKind::Syntax, &place, &[word, "a column of numbers"]);
        };
        let counts = || Stored::Int64(vec![1, 2, 3]);
        refused(("BYTE_ARRAY position_m (UTF8)", Stored::Text(vec!["a", "b", "c"])), None, "text");
        refused(("INT64 position_m (TIMESTAMP_MICROS)", counts()), None, "time stamps");
        refused(("INT64 position_m (TIMESTAMP(NANOS,true))", counts()), None, "time stamps");
        refused(("INT64 position_m (DECIMAL(9,2))", counts()), None, "decimals");
        refused(("INT32 position_m (DATE)", Stored::Int32(vec![1, 2, 3])), None, "dates");
        // Durations are bare integers in the file; pandas says what they are.
        let told = r#"{"columns": [{"name": "position_m", "pandas_type": "timedelta", "numpy_type": "timedelta64[ns]"}]}"#;
        refused(("INT64 position_m", counts()), Some(told), "durations");
    }

    #[test]
    fn exact_empty_or_foreign_file_is_refused() {
        let none = || Stored::Double(Vec::new());
        let folder = folder_with(vec![("DOUBLE time_s", none()), ("DOUBLE position_m", none())]);
        let place = Place { file: "log.parquet", ..Place::default() };
        let error = Recording::read(folder.path()).unwrap_err();
        assert_refused(&error, ErrorKind::TooLittleData, &place, &["without rows"]);
        fs::write(folder.path().join("log.parquet"), GOOD).unwrap();
        let error = Recording::read(folder.path()).unwrap_err();
        assert_refused(&error, ErrorKind::Syntax, &place, &["Parquet", "pandas"]);
    }
}

// --- made in memory ------------------------------------------------------------------------------------------

fn plain_run(name: &str, samples: Vec<f64>) -> Run {
    Run::new(name, Motion::Prismatic, 250e-6, BTreeMap::from([(Signal::Position, samples)])).unwrap()
}

#[test]
fn exact_faulty_run_in_memory_is_refused() {
    let make = |name: &str, period: f64, position: Vec<f64>, current: Vec<f64>| {
        let signals = BTreeMap::from([(Signal::Position, position), (Signal::Current, current)]);
        Run::new(name, Motion::Prismatic, period, signals).unwrap_err()
    };
    let (two, three) = (vec![0.0; 2], vec![0.0; 3]);
    assert_eq!(make("", 1e-3, two.clone(), two.clone()).kind(), ErrorKind::OutOfRange);
    assert_eq!(make("a", 0.0, two.clone(), two.clone()).kind(), ErrorKind::OutOfRange);
    assert_eq!(make("a", 1e-3, two.clone(), three).kind(), ErrorKind::Inconsistent);
    assert_eq!(make("a", 1e-3, vec![], vec![]).kind(), ErrorKind::TooLittleData);
    let error = make("a", 1e-3, two, vec![0.0, f64::NAN]);
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::NotFinite, Some("current_a")));
    assert!(error.to_string().contains("sample 1"));
}

#[test]
fn exact_faulty_recording_in_memory_is_refused() {
    assert_eq!(Recording::new(vec![]).unwrap_err().kind(), ErrorKind::TooLittleData);
    let twice = vec![plain_run("a", vec![0.0]), plain_run("a", vec![1.0])];
    assert_eq!(Recording::new(twice).unwrap_err().key_name(), Some("a"));
    let turning = Run::new("b", Motion::Revolute, 250e-6, BTreeMap::from([(Signal::Position, vec![0.0])]));
    let mixed = vec![plain_run("a", vec![0.0]), turning.unwrap()];
    assert_eq!(Recording::new(mixed).unwrap_err().kind(), ErrorKind::Inconsistent);
}

// --- writing -------------------------------------------------------------------------------------------------

fn sample_recording() -> Recording {
    let mut first = plain_run("feed0.8", vec![0.1, -0.0, 1e-300, f64::MAX, 1.0 / 3.0]);
    first.role = Some(Role::Training);
    first.start_s = 12.5;
    first.metadata.insert("stroke_m".into(), 0.02.into());
    first.metadata.insert("tool".into(), "none".into());
    first.settings.insert("controller.integral".into(), 22.into());
    let mut recording = Recording::new(vec![first, plain_run("second", vec![5e-324, 2.0])]).unwrap();
    recording.note = Some("simulated".into());
    recording
}

fn assert_same(read: &Recording, written: &Recording) {
    assert_eq!(read.motion(), written.motion());
    assert_eq!(read.sample_period_s(), written.sample_period_s());
    assert_eq!(read.note, written.note);
    assert_eq!(read.runs().len(), written.runs().len());
    for (read, written) in read.runs().iter().zip(written.runs()) {
        assert_eq!(read.name(), written.name());
        assert_eq!(read.role, written.role);
        assert_eq!(read.start_s.to_bits(), written.start_s.to_bits());
        assert_eq!(read.metadata, written.metadata);
        assert_eq!(read.settings, written.settings);
        let bits = |run: &Run| -> Vec<(Signal, Vec<u64>)> {
            run.signals().iter().map(|(s, x)| (*s, x.iter().map(|x| x.to_bits()).collect())).collect()
        };
        assert_eq!(bits(read), bits(written));
    }
}

/// A refused unit would hide the round trip: positions of the sample are absurd on purpose.
fn small(recording: Recording) -> Recording {
    let runs = recording.runs().iter().map(|run| {
        let clipped = run.signal(Signal::Position).unwrap().iter().map(|x| x.clamp(-1.0, 1.0)).collect();
        let mut small = plain_run(run.name(), clipped);
        small.role = run.role;
        small.start_s = run.start_s;
        small.metadata.clone_from(&run.metadata);
        small.settings.clone_from(&run.settings);
        small
    });
    let mut clipped = Recording::new(runs.collect()).unwrap();
    clipped.note = recording.note;
    clipped
}

#[test]
fn exact_written_recording_reads_back() {
    let recording = small(sample_recording());
    let place = TempDir::new().unwrap();
    for (name, format) in [("csv", Format::Csv), ("parquet", Format::Parquet)] {
        let folder = place.path().join("deep").join(name);
        recording.write(&folder, format, Existing::Refuse).unwrap();
        let read = Recording::read(&folder).unwrap();
        assert_same(&read, &recording);
        assert!(read.units_read.is_empty());
    }
    let left: Vec<_> = fs::read_dir(place.path().join("deep")).unwrap().flatten().collect();
    assert_eq!(left.len(), 2, "something half-written was left: {left:?}");
}

#[test]
fn exact_machine_is_named_relative_to_the_recording() {
    let place = TempDir::new().unwrap();
    let machine = place.path().join("models").join("slide");
    fs::create_dir_all(&machine).unwrap();
    let mut recording = small(sample_recording());
    recording.machine = Some(machine.clone());
    let folder = place.path().join("runs").join("monday");
    recording.write(&folder, Format::Csv, Existing::Refuse).unwrap();
    let text = fs::read_to_string(folder.join("recording.toml")).unwrap();
    assert!(text.contains("machine = \"../../models/slide\""), "{text}");
    let read = Recording::read(&folder).unwrap().machine.unwrap();
    assert_eq!(read.canonicalize().unwrap(), machine.canonicalize().unwrap());
}

#[test]
fn exact_writing_over_something_is_refused() {
    let recording = small(sample_recording());
    let place = TempDir::new().unwrap();
    let folder = place.path().join("out");
    fs::create_dir(&folder).unwrap();
    recording.write(&folder, Format::Csv, Existing::Refuse).unwrap();
    let error = recording.write(&folder, Format::Parquet, Existing::Refuse).unwrap_err();
    let at = Place { file: "out", ..Place::default() };
    assert_refused(&error, ErrorKind::Io, &at, &["a recording", "replace"]);
    recording.write(&folder, Format::Parquet, Existing::Replace).unwrap();
    assert!(folder.join("second.parquet").exists() && !folder.join("second.csv").exists());

    fs::write(folder.join("thesis.txt"), "years of work").unwrap();
    let error = recording.write(&folder, Format::Csv, Existing::Replace).unwrap_err();
    assert_refused(&error, ErrorKind::Io, &at, &["`thesis.txt`", "would delete it"]);
    fs::remove_file(folder.join("recording.toml")).unwrap();
    let error = recording.write(&folder, Format::Csv, Existing::Replace).unwrap_err();
    assert_refused(&error, ErrorKind::Io, &at, &["not a recording"]);
    assert!(folder.join("thesis.txt").exists() && folder.join("second.parquet").exists());

    let file = place.path().join("file");
    fs::write(&file, "").unwrap();
    let at = Place { file: "file", ..Place::default() };
    assert_refused(
        &recording.write(&file, Format::Csv, Existing::Replace).unwrap_err(),
        ErrorKind::Io,
        &at,
        &["a file"],
    );
    let left = fs::read_dir(place.path()).unwrap().count();
    assert_eq!(left, 2, "something half-written was left");
}

#[test]
fn exact_hash_tells_data_apart_and_ignores_the_order() {
    let place = TempDir::new().unwrap();
    let write = |name: &str, last: f64| {
        let runs = vec![plain_run("a", vec![0.0, last]), plain_run("b", vec![1.0])];
        let folder = place.path().join(name);
        Recording::new(runs).unwrap().write(&folder, Format::Csv, Existing::Refuse).unwrap();
        Recording::read(&folder).unwrap().sha256()
    };
    let (one, same, other) = (write("one", 1.0), write("same", 1.0), write("other", 2.0));
    assert_eq!(one, same);
    assert_ne!(one, other);
    assert_eq!(one.len(), 64);
    let forward = Recording::new(vec![plain_run("a", vec![0.0]), plain_run("b", vec![1.0])]).unwrap();
    let backward = Recording::new(vec![plain_run("b", vec![1.0]), plain_run("a", vec![0.0])]).unwrap();
    assert_eq!(forward.sha256(), backward.sha256());
}

// --- splitting -----------------------------------------------------------------------------------------------

fn names(runs: &[Run]) -> Vec<String> {
    runs.iter().map(|run| run.name().to_owned()).collect()
}

fn numbered(count: usize) -> Vec<Run> {
    let run = |k: usize| {
        let mut run = plain_run(&format!("run{k:02}"), vec![k as f64, 1.0]);
        run.metadata.insert("feed_m_per_min".into(), ((k % 4) as i64).into());
        run
    };
    (0..count).map(run).collect()
}

#[test]
fn exact_declared_roles_are_respected() {
    let mut runs = numbered(6);
    runs[0].role = Some(Role::HeldOut);
    runs[5].role = Some(Role::Training);
    let (training, held_out) = Recording::new(runs).unwrap().split(SplitRule::default()).unwrap();
    assert!(names(held_out.runs()).contains(&"run00".into()));
    assert!(names(training.runs()).contains(&"run05".into()));
    assert_eq!(held_out.runs().len(), 2);
}

#[test]
fn exact_split_spreads_over_the_metadata() {
    let recording = Recording::new(numbered(32)).unwrap();
    let (_, held_out) = recording.split(SplitRule::default()).unwrap();
    let feeds: std::collections::BTreeSet<_> =
        held_out.runs().iter().map(|run| run.metadata["feed_m_per_min"].as_integer()).collect();
    assert_eq!((held_out.runs().len(), feeds.len()), (8, 4));
}

#[test]
fn exact_one_sided_split_is_refused() {
    let split = |runs: Vec<Run>| Recording::new(runs).unwrap().split(SplitRule::default());
    let error = split(numbered(1)).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::TooLittleData);
    assert!(error.to_string().contains("record a longer run"), "{error}");
    let mut single = numbered(1);
    single[0].role = Some(Role::Training);
    assert!(split(single).unwrap_err().to_string().contains("leave `role` out"));
    for role in [Role::Training, Role::HeldOut] {
        let mut runs = numbered(3);
        runs.iter_mut().for_each(|run| run.role = Some(role));
        let error = split(runs).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::TooLittleData);
        assert!(error.to_string().contains("runs only"), "{error}");
        let mut runs = numbered(2);
        runs[0].role = Some(role);
        assert!(split(runs).is_ok());
    }
}

#[test]
fn exact_training_data_among_the_held_out_are_refused() {
    let runs = vec![plain_run("a", vec![1.0, 2.0]), plain_run("copy", vec![1.0, 2.0])];
    let error = Recording::new(runs).unwrap().split(SplitRule::default()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Inconsistent);
    assert!(error.to_string().contains("byte for byte"), "{error}");
}

#[test]
fn exact_cross_validation_stays_inside_the_training_runs() {
    let (training, _) = Recording::new(numbered(8)).unwrap().split(SplitRule::default()).unwrap();
    let (rest, left_out) = training.leaving_out(2).unwrap();
    assert_eq!(rest.runs().len() + 1, training.runs().len());
    assert_eq!(left_out.runs()[0].name(), training.runs()[2].name());
    assert!(training.leaving_out(99).is_none());
}

proptest! {
    // Failures are printed in full; no files are left beside the tests.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn exact_split_is_whole_disjoint_and_blind_to_order(
        (count, order) in (2_usize..24).prop_flat_map(|count| {
            (Just(count), Just((0..count).collect::<Vec<_>>()).prop_shuffle())
        }),
        one_in in 1_usize..8,
    ) {
        let rule = SplitRule::one_in(NonZeroUsize::new(one_in).unwrap());
        let sorted = numbered(count);
        let shuffled = order.iter().map(|k| sorted[*k].clone()).collect();
        let (training, held_out) = Recording::new(sorted.clone()).unwrap().split(rule).unwrap();
        let (again, held_again) = Recording::new(shuffled).unwrap().split(rule).unwrap();
        prop_assert_eq!(names(training.runs()), names(again.runs()));
        prop_assert_eq!(names(held_out.runs()), names(held_again.runs()));
        let mut all = [names(training.runs()), names(held_out.runs())].concat();
        all.sort();
        prop_assert_eq!(all, names(&sorted));
        prop_assert!(!training.runs().is_empty() && !held_out.runs().is_empty());
        for run in training.runs().iter().chain(held_out.runs()) {
            let whole = sorted.iter().find(|whole| whole.name() == run.name()).unwrap();
            prop_assert_eq!(run.signals(), whole.signals());
        }
        if one_in >= 2 {
            prop_assert!(held_out.runs().len() <= count / 2 + 1);
        }
    }

    #[test]
    fn exact_round_trip_keeps_every_bit(
        samples in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 2..40)
            .prop_map(|samples| samples.into_iter().map(|x| if x.abs() > 1e7 { x.recip() } else { x }).collect::<Vec<f64>>()),
        start_s in -1e3..1e3_f64,
        period_s in 1e-5..0.1_f64,
        csv in any::<bool>(),
    ) {
        // Of a current any number of a magnitude that some axis has must pass.
        let signals = BTreeMap::from([(Signal::Current, samples)]);
        let mut run = Run::new("x", Motion::Revolute, period_s, signals).unwrap();
        run.start_s = start_s;
        let recording = Recording::new(vec![run]).unwrap();
        let place = TempDir::new().unwrap();
        let folder = place.path().join("r");
        let format = if csv { Format::Csv } else { Format::Parquet };
        recording.write(&folder, format, Existing::Refuse).unwrap();
        assert_same(&Recording::read(&folder).unwrap(), &recording);
    }

    #[test]
    fn exact_units_convert_there_and_back(reading in -1e6..1e6_f64, place in 0_usize..1000) {
        // Two multiplications and two divisions, half a unit in the last place each.
        const ROUNDING: f64 = 4.0 * f64::EPSILON;
        let all: Vec<_> = [
            Dimension::Time, Dimension::Length, Dimension::Angle, Dimension::Velocity,
            Dimension::AngularVelocity, Dimension::Voltage, Dimension::Current, Dimension::Force, Dimension::Torque,
        ].into_iter().flat_map(|dimension| dimension.symbols().into_iter().map(move |s| (s, dimension))).collect();
        let (symbol, dimension) = all[place % all.len()];
        let unit = Unit::parse_as(symbol, dimension).unwrap();
        let back = unit.from_si(unit.to_si(reading));
        prop_assert!((back - reading).abs() <= ROUNDING * reading.abs(), "{symbol}: {reading} → {back}");
        let by_factor = reading * unit.factor();
        prop_assert!((unit.to_si(reading) - by_factor).abs() <= ROUNDING * by_factor.abs());
    }
}

// --- units ---------------------------------------------------------------------------------------------------

#[test]
fn exact_units_of_the_trade() {
    use std::f64::consts::{PI, TAU};
    let cases = [
        ("ms", Dimension::Time, 1e-3),
        ("us", Dimension::Time, 1e-6),
        ("µs", Dimension::Time, 1e-6),
        ("μm", Dimension::Length, 1e-6),
        ("nm", Dimension::Length, 1e-9),
        ("in", Dimension::Length, 0.0254),
        ("°", Dimension::Angle, PI / 180.0),
        ("rev", Dimension::Angle, TAU),
        ("mrad", Dimension::Angle, 1e-3),
        ("m/min", Dimension::Velocity, 1.0 / 60.0),
        ("mm/min", Dimension::Velocity, 1e-3 / 60.0),
        ("in/min", Dimension::Velocity, 0.0254 / 60.0),
        ("rpm", Dimension::AngularVelocity, TAU / 60.0),
        ("min^-1", Dimension::AngularVelocity, TAU / 60.0),
        ("deg/s", Dimension::AngularVelocity, PI / 180.0),
        ("mV", Dimension::Voltage, 1e-3),
        ("mA", Dimension::Current, 1e-3),
        ("kN", Dimension::Force, 1e3),
        ("N·m", Dimension::Torque, 1.0),
        ("Nm", Dimension::Torque, 1.0),
        ("N.m", Dimension::Torque, 1.0),
        ("N*m", Dimension::Torque, 1.0),
        ("N m", Dimension::Torque, 1.0),
        ("mNm", Dimension::Torque, 1e-3),
        ("[mN·m]", Dimension::Torque, 1e-3),
    ];
    for (text, dimension, factor) in cases {
        let unit = Unit::parse(text).unwrap();
        assert_eq!(unit.dimension(), dimension, "{text}");
        assert!((unit.factor() / factor - 1.0).abs() < 2.0 * f64::EPSILON, "{text}: {}", unit.factor());
    }
}

#[test]
fn exact_unknown_unit_is_refused() {
    let error = Unit::parse_as("mmm", Dimension::Length).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unit);
    for word in ["unknown unit `mmm`", "a unit of length: m, cm, mm, µm, nm, in"] {
        assert!(error.to_string().contains(word), "{error}");
    }
    let error = Unit::parse("MM").unwrap_err();
    assert!(error.to_string().contains("`mm` was probably meant"), "{error}");
    let error = Unit::parse_as("N", Dimension::Torque).unwrap_err();
    assert!(
        error.to_string().contains("unit `N`, a unit of force, expected a unit of torque: N·m"),
        "{error}"
    );
}

// --- real logs -----------------------------------------------------------------------------------------------

fn toml_in(folder: &TempDir, text: &str) -> PathBuf {
    let path = folder.path().join("recording.toml");
    fs::write(&path, text).unwrap();
    path
}

#[test]
fn ref_emps_logs_are_read() {
    needs!(support::data("emps/emps_estimation.csv"));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/emps/recording.toml");
    let recording = Recording::read(path).unwrap();
    assert_eq!(recording.sample_period_s(), 1e-3);
    assert_eq!(recording.motion(), Motion::Prismatic);
    let estimation = recording.run("estimation").unwrap();
    assert_eq!((estimation.len(), estimation.role), (24_841, Some(Role::Training)));
    assert_eq!(estimation.signal(Signal::Position).unwrap()[..3], [7.45e-6, 1.43e-5, 2.185e-5]);
    assert_eq!(estimation.ignored_columns, ["force_cmd_N"]);
    assert_eq!(estimation.timing.irregular_intervals, 0);
    let pulses = recording.run("pulses").unwrap();
    let strongest = pulses.signal(Signal::DisturbanceVoltage).unwrap().iter().copied().fold(0.0, f64::max);
    assert!((strongest - 5.0695).abs() < 1e-12, "5 V × 1.0139, got {strongest}");
    let (training, held_out) = recording.split(SplitRule::default()).unwrap();
    assert_eq!(
        (names(training.runs()), names(held_out.runs())),
        (vec!["estimation".into()], vec!["pulses".into()])
    );
}

/// `[[run]]` tables for every Parquet file of a folder.
fn parquet_runs(folder: &Path) -> String {
    let files = fs::read_dir(folder).unwrap().flatten().map(|entry| entry.path());
    let tables = files.filter(|file| file.extension().is_some_and(|ending| ending == "parquet"));
    tables.map(|file| format!("\n[[run]]\nfile = {file:?}\n")).collect()
}

#[test]
fn ref_servo_logs_in_parquet_are_read() {
    const COLUMNS: &str = "columns = { time_s = \"t_s\", torque_nm = \"tau_fb_Nm\", \
        position_rad = \"pos_rad\", velocity_rad_per_s = \"vel_rad_s\", \
        position_reference_rad = \"pos_cmd_rad\", velocity_reference_rad_per_s = \"vel_cmd_rad_s\" }";
    let data = needs!(support::data("delta_a3/S1_noFF_1.parquet"));
    let folder = TempDir::new().unwrap();
    let runs = parquet_runs(&data.join("delta_a3"));
    let recording = Recording::read(toml_in(&folder, &format!("{COLUMNS}\n{runs}"))).unwrap();
    assert_eq!((recording.motion(), recording.sample_period_s()), (Motion::Revolute, 1e-3));
    let run = recording.run("S1_noFF_1").unwrap();
    assert_eq!((run.len(), run.signals().len()), (10_002, 5));
    // 120 rad of travel, as the source of the data states.
    let furthest = run.signal(Signal::PositionReference).unwrap().iter().copied().fold(0.0, f64::max);
    assert!((furthest - 120.0).abs() < 0.01, "{furthest}");
    // Velocities declared in rpm although they are in rad/s.
    let wrong = COLUMNS.replace("\"vel_rad_s\"", "{ column = \"vel_rad_s\", unit = \"rpm\" }");
    let error = Recording::read(toml_in(&folder, &format!("{wrong}\n{runs}"))).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unit, "{error}");
    assert_eq!(error.key_name(), Some("velocity_rad_per_s"));
    assert!(error.to_string().contains("1/9.5 × the derivative of `position_rad`"), "{error}");
}

#[test]
fn ref_grinder_logs_in_parquet_are_read() {
    const COLUMNS: &str = "columns = { time_s = \"t_s\", current_a = \"motor_current_A\", \
        position_reference_m = { column = \"pos_cmd_mm\", unit = \"mm\" }, \
        position_m = { column = \"pos_motor_enc_mm\", unit = \"mm\" }, \
        load_position_m = { column = \"pos_scale_mm\", unit = \"mm\" } }";
    let data = needs!(support::data("grinder_yaxis/normal_1.parquet"));
    let folder = TempDir::new().unwrap();
    let runs = parquet_runs(&data.join("grinder_yaxis"));
    let recording = Recording::read(toml_in(&folder, &format!("{COLUMNS}\n{runs}"))).unwrap();
    assert_eq!(recording.sample_period_s(), 2e-3);
    for run in recording.runs() {
        let position = run.signal(Signal::Position).unwrap();
        assert!(position.iter().all(|x| (1.79..1.91).contains(x)), "{}", run.name());
    }
    let wrong = COLUMNS.replace("\"pos_cmd_mm\", unit = \"mm\"", "\"pos_cmd_mm\", unit = \"m\"");
    let error = Recording::read(toml_in(&folder, &format!("{wrong}\n{runs}"))).unwrap_err();
    assert_eq!((error.kind(), error.key_name()), (ErrorKind::Unit, Some("position_m")), "{error}");
    assert!(error.to_string().contains("give `position_reference_m` unit = \"mm\""), "{error}");
}

#[test]
fn ref_pyarrow_reads_what_was_written() {
    let mut python = needs!(support::python("pyarrow"));
    let place = TempDir::new().unwrap();
    let folder = place.path().join("r");
    Recording::new(vec![plain_run("a", vec![0.1, 0.2, 0.3])])
        .unwrap()
        .write(&folder, Format::Parquet, Existing::Refuse)
        .unwrap();
    let script = "import sys, pyarrow.parquet as p; t = p.read_table(sys.argv[1]); \
                  assert t.column_names == ['time_s', 'position_m'], t.column_names; \
                  assert t['position_m'].to_pylist() == [0.1, 0.2, 0.3]; \
                  assert t['time_s'].to_pylist() == [0.0, 250e-6, 500e-6]";
    let output = python.args(["-c", script]).arg(folder.join("a.parquet")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
