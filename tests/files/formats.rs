//! Logs as programs write them: each layout with a sample, by the program itself where it could be had (`formats/make.py`).
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::support::{self, needs};
use slideway::error::Error;
use slideway::recording::{Existing, Format, Recording, Run, Signal, TableLayout};
use slideway::units::Motion;
use tempfile::TempDir;

fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/formats").join(name)
}

/// Reads a sample through `[columns]`.
fn read_sample(name: &str, toml: &str) -> Result<Recording, Error> {
    let folder = TempDir::new().unwrap();
    std::fs::copy(sample(name), folder.path().join(name)).unwrap();
    recording(&folder, name, toml)
}

/// Reads a log of some bytes.
fn read_bytes(bytes: &[u8], toml: &str) -> Result<Recording, Error> {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join("log.csv"), bytes).unwrap();
    recording(&folder, "log.csv", toml)
}

fn recording(folder: &TempDir, file: &str, toml: &str) -> Result<Recording, Error> {
    let (top, columns) = toml.split_once("[columns]").unwrap_or((toml, ""));
    let text = format!("{top}\n[[run]]\nfile = \"{file}\"\n[columns]\n{columns}");
    std::fs::write(folder.path().join("recording.toml"), text).unwrap();
    Recording::read(folder.path())
}

fn positions(recording: &Recording) -> Vec<f64> {
    recording.runs()[0].signal(Signal::Position).unwrap().to_vec()
}

/// The position that the binary samples hold.
fn sine(k: usize) -> f64 {
    0.1 * (2.0 * std::f64::consts::PI * 5.0 * (k as f64 * 1e-3)).sin()
}

#[track_caller]
fn is_sine(read: &[f64], factor: f64) {
    assert_eq!(read.len(), 50);
    for (k, x) in read.iter().enumerate() {
        assert!((x - factor * sine(k)).abs() < 1e-15, "{k}: {x}");
    }
}

/// The current of the traces' samples: 1.5 A, the other way round every ten samples.
#[track_caller]
fn is_square(read: &[f64]) {
    let wanted = |k: usize| if (k / 10).is_multiple_of(2) { 1.5 } else { -1.5 };
    assert!(read.iter().enumerate().all(|(k, current)| *current == wanted(k)), "{read:?}");
}

#[test]
fn ref_twincat_scope_groups_of_several_rates_are_read_on_one_clock() {
    let toml = "[columns]\nposition_m = { column = \"func_freesample\", unit = \"mm\" }\n\
                current_a = \"func_OS\"\nvelocity_m_per_s = { column = \"func_scaled\", unit = \"mm/s\" }\n";
    let recording = read_sample("twincat_scope.csv", toml).unwrap();
    let run = &recording.runs()[0];
    // Times and values of the slowest channel are equal in ms; the first lies before the others begin.
    assert_eq!(recording.sample_period_s(), 5e-3);
    assert!((run.start_s - 2e-3).abs() < 1e-12);
    let time_ms = |k: usize| 2.0 + 5.0 * k as f64;
    assert!(run.len() > 1);
    for k in 0..run.len() {
        assert!((run.signal(Signal::Position).unwrap()[k] - time_ms(k) * 1e-3).abs() < 1e-12);
        assert!((run.signal(Signal::Current).unwrap()[k] - time_ms(k)).abs() < 1e-9);
        // Scale −1 and offset 1 are in the numbers: they are applied once.
        assert!((run.signal(Signal::Velocity).unwrap()[k] - (1.0 - time_ms(k)) * 1e-3).abs() < 1e-9);
    }
    assert!(run.remarks.iter().any(|remark| remark.contains("TwinCAT Scope")), "{:?}", run.remarks);
    assert!(run.remarks.iter().any(|remark| remark.contains("other time stamps")), "{:?}", run.remarks);
}

#[test]
fn ref_twincat_scope_states_its_units() {
    let layout = TableLayout::of(sample("twincat_scope.csv")).unwrap();
    let unit = |name: &str| layout.columns.iter().find(|(column, _)| column == name).unwrap().1.clone();
    assert_eq!(layout.format, "TwinCAT Scope export");
    assert_eq!(unit("func_units_unscaled").as_deref(), Some("V"));
    assert_eq!(unit("func_units_scaled").as_deref(), Some("dV"));
    assert_eq!(unit("func_OS"), None);
    assert_eq!(unit("test_special([{äöü!?ß$²}])"), None);
    let toml = |column: &str| {
        format!(
            "[columns]\ncontrol_effort_v = \"{column}\"\nposition_m = {{ column = \"func_OS\", unit = \"mm\" }}\n"
        )
    };
    let recording = read_sample("twincat_scope.csv", &toml("func_units_unscaled")).unwrap();
    assert_eq!(recording.runs()[0].signal(Signal::ControlEffort).unwrap()[3], 3.0);
    let error = read_sample("twincat_scope.csv", &toml("func_units_scaled")).unwrap_err().to_string();
    assert!(error.contains("dV") && error.contains("control_effort_v = { column"), "{error}");
}

#[test]
fn ref_real_twincat_exports_read_alike() {
    let data = needs!(support::data("twincat_scope/semicolon.csv")).join("twincat_scope");
    let mut all: Vec<Vec<f64>> = Vec::new();
    for name in ["decimal_comma", "grouped_times", "semicolon", "time_per_channel"] {
        let folder = TempDir::new().unwrap();
        std::fs::copy(data.join(format!("{name}.csv")), folder.path().join("log.csv")).unwrap();
        let toml = "[columns]\nposition_m = { column = \"func_timeshift\", unit = \"mm\" }\nvelocity_m_per_s = { column = \"func_OS\", unit = \"mm/s\" }\n";
        let recording = recording(&folder, "log.csv", toml).unwrap_or_else(|error| panic!("{name}: {error}"));
        let run = &recording.runs()[0];
        assert_eq!((run.len(), recording.sample_period_s()), (1000, 1e-3), "{name}");
        all.push(run.signal(Signal::Position).unwrap().to_vec());
    }
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn exact_filetime_stamps_keep_their_digits() {
    let header = "Name\taxis\nStarttime of export\t132959733843760000\tMonday\n\nName\tx\n\
                  SampleTime[ms]\t0.25\nUnit\tmm (Length)\n\n";
    let rows: String =
        (0..20).map(|k| format!("{}\t{k}\n", 132_959_733_843_760_000_u64 + 2500 * k)).collect();
    let recording =
        read_bytes(format!("{header}{rows}EOF\n").as_bytes(), "[columns]\nposition_m = \"x\"\n").unwrap();
    assert_eq!(recording.sample_period_s(), 250e-6);
    assert_eq!(positions(&recording)[19], 0.019);
}

#[test]
fn ref_halsampler_without_header_is_read_by_column_numbers() {
    let rows: String = (0..40)
        .map(|k| {
            let overrun = if k == 20 { "overrun\n" } else { "" };
            format!("{overrun}{k} {:.6} {:.6} \n", 0.001 * f64::from(k), 2.5)
        })
        .collect();
    let toml = "sample_period_s = 1e-3\n[columns]\nposition_m = { column = \"column_2\", unit = \"mm\" }\n";
    let recording = read_bytes(rows.as_bytes(), toml).unwrap();
    assert!((positions(&recording)[39] - 39e-6).abs() < 1e-18);
    assert!(recording.runs()[0].remarks.iter().any(|remark| remark.contains("1 overruns")));
}

/// The layout is that of `write_log_file` in LinuxCNC's `src/hal/utils/scope_files.c` up to version 2.8: a name before every
/// value, a channel that is off called `(null)`, and one row from behind the buffer at the end.
#[test]
fn ref_halscope_logs_name_every_value() {
    let toml = "[columns]\nposition_m = { column = \"joint.0.motor-pos-fb\", unit = \"mm\" }\n\
                thrust_n = \"joint.0.torque-cmd\"\n";
    let recording = read_sample("halscope_2_8.log", toml).unwrap();
    assert_eq!(recording.sample_period_s(), 1e-3);
    is_sine(&positions(&recording), 1.0);
    let run = &recording.runs()[0];
    assert!(run.signal(Signal::Thrust).unwrap().iter().all(|n| *n == 2.5));
    assert!(run.remarks.iter().any(|remark| remark.contains("halscope")), "{:?}", run.remarks);
    let whole = std::fs::read_to_string(sample("halscope_2_8.log")).unwrap();
    let cut: Vec<&str> =
        whole.lines().enumerate().map(|(n, line)| if n == 20 { &line[..60] } else { line }).collect();
    let error = read_bytes(cut.join("\n").as_bytes(), toml).unwrap_err().to_string();
    assert!(error.contains("fields"), "{error}");
}

/// From version 2.9 on halscope writes CSV with semicolons and decimal points whatever the locale, one column a channel
/// (LinuxCNC pull request 1500); the period is not among the columns and is stated. The row of names is an assumption of this sample:
/// what that version calls its columns is not documented.
#[test]
fn ref_halscope_csv_is_read_with_its_period_stated() {
    let toml = "sample_period_s = 1e-3\n[columns]\nposition_m = { column = \"joint.0.motor-pos-fb\", unit = \"mm\" }\n";
    let recording = read_sample("halscope_2_9.csv", toml).unwrap();
    is_sine(&positions(&recording), 1.0);
    let error = read_sample("halscope_2_9.csv", toml.split_once('\n').unwrap().1).unwrap_err().to_string();
    assert!(error.contains("sample_period_s"), "{error}");
}

/// The layout is the one that independent public readers of these files agree on: signals with an identifier each, records that
/// leave out what did not change and what is sampled more slowly. Units are those of the control's settings, so they are stated.
#[test]
fn ref_sinumerik_traces_leave_out_what_does_not_change() {
    let position = "Position actual value measuring system 1";
    let toml = format!(
        "[columns]\nposition_m = {{ column = \"{position}\", unit = \"mm\" }}\ncurrent_a = \"Torque-producing current i(q)\"\n"
    );
    let recording = read_sample("sinumerik_trace.xml", &toml).unwrap();
    assert_eq!(recording.sample_period_s(), 1e-3);
    is_sine(&positions(&recording), 1.0);
    let run = &recording.runs()[0];
    is_square(run.signal(Signal::Current).unwrap());
    assert!(run.remarks.iter().any(|remark| remark.contains("SINUMERIK")), "{:?}", run.remarks);
    let whole = std::fs::read_to_string(sample("sinumerik_trace.xml")).unwrap();
    let refused = |text: &str| read_bytes(text.as_bytes(), &toml).unwrap_err().to_string();
    let error = refused(&whole.replace("time=\"0.02\"", "time=\"later\""));
    assert!(error.contains("time=\"later\"") && error.contains("33"), "{error}");
    let error = refused(whole.split_once("   <rec time=\"0.03\"").unwrap().0);
    assert!(error.contains("cut off"), "{error}");
    let error = refused(&whole.replace("</dataFrame>", "</dataFrame><dataFrame>"));
    assert!(error.contains("second data frame"), "{error}");
}

/// The layout is the one of a public reader of these files; its tests hold bytes that a controller recorded.
#[test]
fn ref_tia_portal_recordings_state_names_units_and_times() {
    let toml = "[columns]\nposition_m = { column = \"Axis.ActualPosition\", unit = \"mm\" }\n\
                current_a = { column = \"Drive.axis_1.Current\", unit = \"mA\" }\n";
    let recording = read_sample("tia_trace.ttrecx", toml).unwrap();
    assert_eq!(recording.sample_period_s(), 1e-3);
    is_sine(&positions(&recording), 1.0);
    let run = &recording.runs()[0];
    is_square(run.signal(Signal::Current).unwrap());
    assert!(run.remarks.iter().any(|remark| remark.contains("TIA Portal")), "{:?}", run.remarks);
    let layout = TableLayout::of(sample("tia_trace.ttrecx")).unwrap();
    let columns = layout.columns.iter().map(|(name, unit)| (name.as_str(), unit.as_deref()));
    assert_eq!(
        columns.collect::<Vec<_>>(),
        [
            ("time_s", None),
            ("Axis.ActualPosition", Some("mm")),
            ("Drive.axis_1.Current", Some("mA")),
            ("Axis.StatusWord.Enabled", None),
        ]
    );
    let whole = std::fs::read(sample("tia_trace.ttrecx")).unwrap();
    let error = read_bytes(&whole[..whole.len() - 40], toml).unwrap_err().to_string();
    assert!(error.contains("ZIP"), "{error}");
    // A workbook is a ZIP archive too.
    let mut other = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    other.start_file("xl/workbook.xml", zip::write::SimpleFileOptions::default()).unwrap();
    let error = read_bytes(&other.finish().unwrap().into_inner(), toml).unwrap_err().to_string();
    assert!(error.contains("entry Signals") && error.contains("as CSV"), "{error}");
}

#[test]
fn exact_german_excel_in_windows_1252_is_read_with_its_units() {
    let mut text = "sep=;\r\nZeit;Position;Strom\r\nms;µm;A\r\n".to_owned();
    for k in 0..30 {
        text += &format!("{k};{},5;0,{k}\r\n", k);
    }
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let toml = "[columns]\ntime_s = \"Zeit\"\nposition_m = \"Position\"\ncurrent_a = \"Strom\"\n";
    for bytes in [latin, text.encode_utf16().flat_map(u16::to_le_bytes).collect(), text.clone().into_bytes()]
    {
        let recording = read_bytes(&bytes, toml).unwrap();
        assert_eq!(recording.sample_period_s(), 1e-3);
        assert_eq!(positions(&recording)[29], 29.5e-6);
    }
}

#[test]
fn exact_lines_above_the_header_are_left_out() {
    let mut text = "Trace;Axis_1\nDevice;Drive 7\nCycle;1 ms\n\nTime [ms];s_act;i_q\n".to_owned();
    for k in 0..20 {
        text += &format!("{k};{};1\n", 2 * k);
    }
    let toml = "[columns]\ntime_s = { column = \"Time [ms]\", unit = \"ms\" }\nposition_m = { column = \"s_act\", unit = \"mm\" }\n";
    let recording = read_bytes(text.as_bytes(), toml).unwrap();
    assert_eq!((recording.sample_period_s(), positions(&recording)[19]), (1e-3, 0.038));
    assert!(recording.runs()[0].remarks.iter().any(|remark| remark.contains("3 lines above the header")));
}

#[test]
fn exact_plotjuggler_columns_of_two_rates_are_read_on_the_slower_clock() {
    let mut text = "__time,/axis/position,/axis/current\n".to_owned();
    for k in 0..100 {
        let slow = if k % 4 == 0 { format!("{}", 2 * k) } else { String::new() };
        text += &format!("{},{slow},{}\n", 100.0 + 0.0025 * f64::from(k), 3 * k);
    }
    let toml = "[columns]\nposition_m = { column = \"/axis/position\", unit = \"µm\" }\ncurrent_a = { column = \"/axis/current\", unit = \"mA\" }\n";
    let recording = read_bytes(text.as_bytes(), toml).unwrap();
    let run = &recording.runs()[0];
    assert_eq!((run.len(), recording.sample_period_s()), (25, 0.01));
    assert!((run.signal(Signal::Current).unwrap()[3] - 36e-3).abs() < 1e-15);
}

#[test]
fn exact_lost_samples_and_lost_values_are_filled_in_and_reported() {
    let row = |k: usize, value: String| format!("{},{value},1\n", k as f64 * 1e-3);
    let text: String =
        (0..200).filter(|k| ![50, 51].contains(k)).map(|k| row(k, (2 * k).to_string())).collect();
    let recording = read_bytes(format!("time_s,position_m,current_a\n{text}").as_bytes(), "").unwrap_err();
    assert!(recording.to_string().contains("unit"), "implausible metres: {recording}");
    let toml = "[columns]\nposition_m = { unit = \"µm\" }\n";
    let recording = read_bytes(format!("time_s,position_m,current_a\n{text}").as_bytes(), toml).unwrap();
    assert_eq!(recording.runs()[0].len(), 200);
    assert!((positions(&recording)[51] - 102e-6).abs() < 1e-15);
    assert!(recording.runs()[0].remarks[0].contains("2 lost samples filled in"));
    let holed: String =
        (0..200).map(|k| row(k, if k == 70 { String::new() } else { (2 * k).to_string() })).collect();
    let recording = read_bytes(format!("time_s,position_m,current_a\n{holed}").as_bytes(), toml).unwrap();
    assert!((positions(&recording)[70] - 140e-6).abs() < 1e-15);
}

#[test]
fn ref_mat_files_of_scipy_and_of_hdf5_are_read() {
    for (name, format) in [
        ("scipy_v5.mat", "MAT file, version 5"),
        ("scipy_v7.mat", "MAT file, version 5"),
        ("matlab_v73.mat", "7.3"),
    ] {
        let layout = TableLayout::of(sample(name)).unwrap();
        assert!(layout.format.contains(format), "{name}: {}", layout.format);
        assert!(!layout.columns.iter().any(|(column, _)| column == "Ts"));
        for (column, factor) in [("pos", 1.0), ("both(:,2)", 2.0)] {
            let toml = format!(
                "[columns]\ntime_s = \"t\"\nposition_m = \"{column}\"\ncurrent_a = {{ column = \"cur\", unit = \"mA\" }}\n"
            );
            let recording = read_sample(name, &toml).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(recording.sample_period_s(), 1e-3);
            is_sine(&positions(&recording), factor);
            assert_eq!(recording.runs()[0].signal(Signal::Current).unwrap()[0], 1.0);
        }
    }
}

#[test]
fn ref_mcap_of_ros_2_is_read() {
    let toml = "[columns]\nposition_m = \"/joint_states/slide/position\"\ncurrent_a = { column = \"/current/data\", unit = \"mA\" }\n";
    let recording = read_sample("ros2.mcap", toml).unwrap();
    assert_eq!(recording.sample_period_s(), 1e-3);
    is_sine(&positions(&recording), 1.0);
    assert_eq!(recording.runs()[0].signal(Signal::Current).unwrap()[0], 1.0);
}

#[test]
fn ref_mcap_compressed_with_lz4_is_read() {
    let folder = TempDir::new().unwrap();
    let packed = std::fs::File::create(folder.path().join("ros2.mcap")).unwrap();
    let options = mcap::WriteOptions::new().compression(Some(mcap::Compression::Lz4));
    let mut writer = mcap::Writer::with_options(packed, options).unwrap();
    for message in mcap::io::MessageReader::new(std::fs::File::open(sample("ros2.mcap")).unwrap()) {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    let manifest =
        "[[run]]\nfile = \"ros2.mcap\"\n[columns]\nposition_m = \"/joint_states/slide/position\"\n";
    std::fs::write(folder.path().join("recording.toml"), manifest).unwrap();
    is_sine(&positions(&Recording::read(folder.path()).unwrap()), 1.0);
}

/// A chunk of one record that says it is 2⁶¹ bytes long.
#[test]
fn exact_a_length_that_a_file_states_is_not_believed() {
    let record =
        |opcode: u8, content: &[u8]| [&[opcode][..], &(content.len() as u64).to_le_bytes(), content].concat();
    let text = |text: &str| [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let inside = [&[5_u8][..], &(1_u64 << 61).to_le_bytes(), &[0; 32]].concat();
    let size = (inside.len() as u64).to_le_bytes();
    let chunk = [&[0_u8; 16][..], &size, &[0; 4], &text(""), &size, &inside].concat();
    let header = record(1, &[text("ros2"), text("")].concat());
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("long.mcap");
    std::fs::write(&file, [b"\x89MCAP0\r\n".to_vec(), header, record(6, &chunk)].concat()).unwrap();
    let error = TableLayout::of(&file).unwrap_err();
    assert!(error.path().is_some() && error.to_string().contains("2305843009213693952"), "{error}");
}

#[test]
fn exact_gzip_is_read_as_what_it_packs() {
    is_sine(&positions(&read_sample("log.csv.gz", "").unwrap()), 1.0);
}

#[test]
fn exact_damaged_files_are_refused_with_a_remedy() {
    let folder = TempDir::new().unwrap();
    for name in ["scipy_v5.mat", "scipy_v7.mat", "matlab_v73.mat", "ros2.mcap", "log.csv.gz"] {
        let bytes = std::fs::read(sample(name)).unwrap();
        std::fs::write(folder.path().join(name), &bytes[..bytes.len() / 2]).unwrap();
        let error = TableLayout::of(folder.path().join(name)).unwrap_err();
        assert!(error.remedy_text().is_some() && error.path().is_some(), "{name}: {error}");
    }
}

#[test]
fn exact_written_mcap_reads_back() {
    let samples = |f: &dyn Fn(f64) -> f64| (0..60).map(|k| f(f64::from(k))).collect::<Vec<f64>>();
    let signals = BTreeMap::from([
        (Signal::PositionReference, samples(&|k| 1e-3 * k)),
        (Signal::ControlEffort, samples(&|k| 0.1 * k)),
        (Signal::Thrust, samples(&|k| (k * 0.1).cos())),
        (Signal::Position, samples(&|k| 1e-3 * k - 1e-5)),
        (Signal::Velocity, samples(&|_| 4.0)),
    ]);
    let run = Run::new("stroke", Motion::Prismatic, 250e-6, signals.clone()).unwrap();
    let written = Recording::new(vec![run]).unwrap();
    let folder = TempDir::new().unwrap();
    let place = folder.path().join("out");
    written.write(&place, Format::Mcap, Existing::Refuse).unwrap();
    let read = Recording::read(&place).unwrap();
    assert_eq!(read.sample_period_s(), 250e-6);
    assert_eq!(read.runs()[0].signals(), &signals);
    let layout = TableLayout::of(place.join("stroke.mcap")).unwrap();
    let names: Vec<&str> = layout.columns.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.contains(&"/machine/joint_states/axis/effort"), "{names:?}");
    assert!(names.contains(&"/machine/control_effort_v/data"), "{names:?}");
}
