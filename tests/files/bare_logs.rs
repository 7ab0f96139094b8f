//! Bare logs: columns understood by their headers, refused where they could mean two things.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::error::{Error, ErrorKind};
use slideway::recording::{LogContext, MappedColumn, Recording, Signal};
use slideway::units::Motion;
use std::fmt::Write as _;
use std::path::PathBuf;

const PERIOD_S: f64 = 1e-3;

/// A log with a header, a row of numbers a sample: time in ms, then every column as the sample's number.
fn body(separator: char, columns: usize, comma: bool) -> String {
    let mut text = String::new();
    for k in 0..200 {
        let fields =
            (0..columns).map(|column| if column == 0 { format!("{k}") } else { format!("{}.5", k % 50) });
        let line = fields.collect::<Vec<_>>().join(&separator.to_string());
        writeln!(text, "{}", if comma { line.replace('.', ",") } else { line }).unwrap();
    }
    text
}

fn read(files: &[(&str, String)], maps: &[&str]) -> Result<Recording, Error> {
    let folder = tempfile::tempdir().unwrap();
    let place = |(name, text): &(&str, String)| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let paths: Vec<PathBuf> = files.iter().map(place).collect();
    let maps: Vec<MappedColumn> = maps.iter().map(|map| map.parse().unwrap()).collect();
    Recording::read_logs(
        &paths,
        &LogContext { maps: &maps, motion: Motion::Prismatic, sample_period_s: PERIOD_S },
    )
}

fn log(header: &str, maps: &[&str]) -> Result<Recording, Error> {
    let columns = header.split(',').count();
    read(&[("log.csv", format!("{header}\n{}", body(',', columns, false)))], maps)
}

#[test]
fn exact_columns_are_read_by_header_and_unit() {
    let recording = log("Time [ms],pos_act [mm],ControlEffort [V],following error [mm]", &[]).unwrap();
    let run = &recording.runs()[0];
    assert_eq!(run.name(), "log");
    assert!((run.sample_period_s() - PERIOD_S).abs() < 1e-12);
    assert!((run.signal(Signal::Position).unwrap()[3] - 3.5e-3).abs() < 1e-15);
    assert_eq!(run.signal(Signal::ControlEffort).unwrap()[3], 3.5);
    let note = recording.note.unwrap();
    for told in
        ["pos_act [mm] read as position_m", "Time [ms] read as time_s", "not read: following error", "--map"]
    {
        assert!(note.contains(told), "{told} is not in {note}");
    }
}

#[test]
fn exact_canonical_names_need_nothing_else() {
    let text = format!("current_a,position_m\n{}", body(',', 2, false));
    let recording = read(&[("a.csv", text.clone()), ("b.csv", text)], &[]).unwrap();
    assert_eq!(recording.runs().len(), 2);
    assert_eq!(recording.sample_period_s(), PERIOD_S);
    assert!(recording.note.as_ref().unwrap().contains("no time column"));
    assert_eq!(
        recording.runs()[0].signals().keys().copied().collect::<Vec<_>>(),
        [Signal::Current, Signal::Position]
    );
}

#[test]
fn exact_a_spreadsheet_with_preamble_and_units_row_is_read() {
    let head = "\u{feff}sep=;\nTrace of axis X1\n\nt;Istposition;Sollposition\n[ms];[mm];[mm]\n";
    let recording = read(&[("trace.csv", format!("{head}{}", body(';', 3, true)))], &[]).unwrap();
    let run = &recording.runs()[0];
    assert!((run.signal(Signal::Position).unwrap()[1] - 1.5e-3).abs() < 1e-15);
    assert!(run.signal(Signal::PositionReference).is_some());
}

#[test]
fn exact_a_map_goes_before_the_header() {
    let recording = log("Time [ms],chan1,chan2", &["chan1=position_m:mm", "chan2=current_a:mA"]).unwrap();
    let run = &recording.runs()[0];
    assert!((run.signal(Signal::Position).unwrap()[2] - 2.5e-3).abs() < 1e-15);
    assert!((run.signal(Signal::Current).unwrap()[2] - 2.5e-3).abs() < 1e-15);
    // One of two is chosen; or one is said to be nothing.
    for map in ["pos_meas [mm]=position_m", "pos_act=-"] {
        let recording = log("Time [ms],pos_act [mm],pos_meas [mm]", &[map]).unwrap();
        assert_eq!(recording.runs()[0].signals().len(), 1, "{map}");
    }
}

#[test]
fn exact_what_could_mean_two_things_is_refused_with_the_choices() {
    let refused = |header: &str, maps: &[&str]| log(header, maps).unwrap_err();
    let two = refused("Time [ms],pos_act [mm],pos_meas [mm]", &[]);
    assert_eq!(two.kind(), ErrorKind::Inconsistent);
    for word in ["pos_act [mm], pos_meas [mm]", "--map 'pos_meas [mm]=position_m'", "log.csv"] {
        assert!(two.to_string().contains(word), "{word} is not in {two}");
    }
    let unitless = refused("Time [ms],pos_act", &[]);
    assert_eq!((unitless.kind(), unitless.key_name()), (ErrorKind::Unit, Some("pos_act")));
    assert!(unitless.to_string().contains("mm") && unitless.to_string().contains("--map"), "{unitless}");
    let wrong = refused("Time [ms],pos_act [V]", &[]);
    assert_eq!(wrong.kind(), ErrorKind::Unit);
    let none = refused("Time [ms],chan1 [mm]", &[]);
    assert!(none.to_string().contains("chan1 [mm]") && none.to_string().contains("=position_m:mm"), "{none}");
    let absent = refused("Time [ms],pos_act [mm]", &["pos_akt=position_m:mm"]);
    assert!(absent.to_string().contains("pos_akt") && absent.to_string().contains("pos_act"), "{absent}");
}

#[test]
fn exact_a_folder_of_logs_is_a_run_each() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["b.csv", "a.CSV", "notes.md"] {
        std::fs::write(folder.path().join(name), format!("t [ms],pos [mm]\n{}", body(',', 2, false)))
            .unwrap();
    }
    assert!(Recording::is_bare(folder.path()));
    let context = LogContext { maps: &[], motion: Motion::Prismatic, sample_period_s: PERIOD_S };
    let recording = Recording::read_logs(&[folder.path().to_path_buf()], &context).unwrap();
    let names: Vec<&str> = recording.runs().iter().map(|run| run.name()).collect();
    assert_eq!(names, ["a", "b"]);
    let empty = tempfile::tempdir().unwrap();
    let error = Recording::read_logs(&[empty.path().to_path_buf()], &context).unwrap_err();
    assert!(error.to_string().contains("without logs"), "{error}");
}

#[test]
fn exact_a_map_that_names_no_signal_is_refused() {
    for text in ["pos_act", "pos_act=posit:mm", "=position_m:mm"] {
        let error = text.parse::<MappedColumn>().unwrap_err();
        assert!(error.to_string().contains("--map"), "{error}");
    }
}
