//! Recordings: files that are none, columns that mean nothing, samples that no axis has.

use super::{Case, file};

const HEAD: &str = "time_s,position_reference_m,position_m,control_effort_v,current_a";
const MANIFEST: &str = "sample_period_s = 1e-3\n[[run]]\nfile = \"a.csv\"\nrole = \"training\"\n[[run]]\nfile = \"b.csv\"\nrole = \"held_out\"\n";
const ROWS: usize = 1200;
const INSPECT: [&str; 2] = ["inspect", "."];

/// A stroke that its axis follows, with noise of its own.
fn rows(seed: usize, stroke: f64) -> Vec<[f64; 5]> {
    let noise = |k: usize| {
        (((k + seed * 7919) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40) as f64 * 1e-8 - 0.08
    };
    (0..ROWS)
        .map(|k| {
            let share = ((k as f64 - 100.0) / 800.0).clamp(0.0, 1.0);
            let (reference, speed) =
                (stroke * share * share * (3.0 - 2.0 * share), stroke * 6.0 * share * (1.0 - share));
            let effort = 8.0 * speed + 0.01 * noise(3 * k);
            [
                k as f64 * 1e-3,
                reference,
                reference + 1e-5 * noise(k),
                effort,
                0.4 * effort + 1e-3 * noise(5 * k),
            ]
        })
        .collect()
}

fn text(rows: &[[f64; 5]]) -> String {
    let lines = rows.iter().map(|row| row.map(|x| format!("{x:?}")).join(","));
    [HEAD.to_owned()].into_iter().chain(lines).collect::<Vec<_>>().join("\n") + "\n"
}

fn sound() -> (String, String) {
    (text(&rows(1, 0.02)), text(&rows(2, 0.03)))
}

fn manifest(name: &str, toml: impl Into<Vec<u8>>) -> Case {
    let (a, b) = sound();
    let files = vec![file("recording.toml", toml), file("a.csv", a), file("b.csv", b), file("sub/keep", "")];
    Case::new(format!("recording {name}"), files, &INSPECT, "recording.toml")
}

fn csv(name: &str, bytes: impl Into<Vec<u8>>) -> Case {
    let files = vec![file("recording.toml", MANIFEST), file("a.csv", bytes), file("b.csv", sound().1)];
    Case::new(format!("csv {name}"), files, &INSPECT, "a.csv")
}

fn manifests() -> Vec<Case> {
    let run = |line: &str| format!("sample_period_s = 1e-3\n[[run]]\n{line}\n");
    let mut cases = vec![
        manifest("good", MANIFEST).sound(),
        manifest("empty", ""),
        manifest("without runs", "sample_period_s = 1e-3\n"),
        manifest("runs a list of nothing", "run = []\n"),
        manifest("run a table", "[run]\nfile = \"a.csv\"\n"),
        manifest("run a text", "run = \"a.csv\"\n"),
        manifest("unknown key", format!("colour = 1\n{MANIFEST}")),
        manifest("motion", format!("motion = \"spiral\"\n{MANIFEST}")),
        manifest("another motion", format!("motion = \"revolute\"\n{MANIFEST}")).either(),
        manifest("binary", (0..=255).collect::<Vec<u8>>()),
        manifest("deep", format!("a = {}", "[".repeat(20_000))),
        manifest("key twice", format!("sample_period_s = 1e-3\n{MANIFEST}")),
        manifest("bracket", MANIFEST.replacen("[[run]]", "[[run]", 1)),
        manifest("UTF-16", MANIFEST.bytes().flat_map(|b| [b, 0]).collect::<Vec<u8>>()),
    ];
    for period in ["\"fast\"", "-1e-3", "0", "nan", "inf", "1e300", "1e-300", "[1]"] {
        cases.push(manifest(&format!("period {period}"), MANIFEST.replacen("1e-3", period, 1)));
    }
    let outside = "data_folder = \"../../../../../../../etc\"\n[[run]]\nfile = \"passwd\"\n";
    cases.push(manifest("a data folder of the system", outside));
    // Where the file is at fault, it is named.
    for (name, line, at_fault) in [
        ("no file", "role = \"training\"", "recording.toml"),
        ("file missing", "file = \"nope.csv\"", "nope.csv"),
        ("file a number", "file = 3", "recording.toml"),
        ("file empty", "file = \"\"", "recording.toml"),
        ("file a folder", "file = \"sub\"", "sub"),
        ("file itself a folder", "file = \".\"", ""),
        ("file outside", "file = \"../../../../../../etc/passwd\"", "recording.toml"),
        ("file of the system", "file = \"/etc/passwd\"", "recording.toml"),
        ("file a device", "file = \"/dev/zero\"", "recording.toml"),
        ("file of the net", "file = \"https://example.com/a.csv\"", "a.csv"),
        ("file with a zero byte", "file = \"a\\u0000.csv\"", ""),
        ("role", "file = \"a.csv\"\nrole = \"test\"", "recording.toml"),
        ("role a number", "file = \"a.csv\"\nrole = 1", "recording.toml"),
        ("slip of a key", "file = \"a.csv\"\nroel = \"training\"", "recording.toml"),
        ("unit of a run", "file = \"a.csv\"\nunit = \"mm\"", "recording.toml"),
        ("period of a run", "file = \"a.csv\"\nsample_period_s = 1e-3", "recording.toml"),
        ("machine of a run", "file = \"a.csv\"\nmachine = \"x\"", "recording.toml"),
        ("settings no table", "file = \"a.csv\"\nset = 3", "recording.toml"),
        ("range backwards", "file = \"a.csv\"\nfrom_s = 2\nto_s = 1", "recording.toml"),
        ("range behind the end", "file = \"a.csv\"\nfrom_s = 200", ""),
        ("extra column missing", "file = \"a.csv\"\nextra_columns = [\"x\"]", "a.csv"),
        ("extra columns no list", "file = \"a.csv\"\nextra_columns = \"x\"", "recording.toml"),
        ("the same run twice", "file = \"a.csv\"\n[[run]]\nfile = \"a.csv\"", "recording.toml"),
    ] {
        let case = manifest(name, run(line));
        cases.push(Case { at_fault, ..case });
    }
    let columns = [
        "foo_m = \"position_m\"",
        "position_m = \"pos\"",
        "position_m = { unit = \"furlong\" }",
        "position_m = { unit = \"V\" }",
        "position_m = { scale = 0 }",
        "position_m = { scale = nan }",
        "position_m = { scale = \"x\" }",
        "position_m = { unt = \"m\" }",
        "position_m = [\"position_m\"]",
        "position_m = { unit = -3 }",
        "current_a = { unit = \"A\", scale = 1e300 }",
        "position_m = { unit = \"m\", scale = 1e9 }",
        "position_reference_m = \"position_m\"",
    ];
    for line in columns {
        let case = manifest(&format!("columns {line}"), format!("{MANIFEST}[columns]\n{line}\n"));
        cases.push(Case { at_fault: "", ..case });
    }
    cases
}

fn tables() -> Vec<Case> {
    let (a, _) = sound();
    let rows = rows(1, 0.02);
    let mut cases = Vec::new();
    for value in [
        "NaN",
        "inf",
        "-inf",
        "",
        "1e308",
        "-1e308",
        "1e309",
        "abc",
        "0x10",
        "NULL",
        "#DIV/0!",
        "１２",
        "−1.5",
        "--1",
        "1.2.3",
        "99999999999999999999999999",
    ] {
        let lines: Vec<String> = a.lines().map(str::to_owned).collect();
        let mut lines = lines;
        let mut fields: Vec<&str> = lines[500].split(',').collect();
        fields[2] = value;
        lines[500] = fields.join(",");
        let case = csv(&format!("value {value}"), lines.join("\n") + "\n");
        // A single lost value is filled in and told.
        cases.push(if value.is_empty() { case.either() } else { case });
    }
    let cut = |count: usize| text(&rows[..count]);
    let mapped = |place: usize, f: &dyn Fn(f64) -> f64| {
        let mut rows = rows.clone();
        rows.iter_mut().for_each(|row| row[place] = f(row[place]));
        text(&rows)
    };
    let lines: Vec<&str> = a.lines().collect();
    let join = |parts: &[&[&str]]| parts.concat().join("\n") + "\n";
    cases.extend([
        csv("empty", ""),
        csv("empty lines", "\n\n\n"),
        csv("header only", format!("{HEAD}\n")),
        csv("one row", cut(1)).either(),
        csv("two rows", cut(2)).either(),
        csv("no header", lines[1..].join("\n")),
        csv("ragged", a.replacen(lines[700], "1,2", 1)),
        csv("too many fields", a.replacen(lines[700], &format!("{},1", lines[700]), 1)),
        csv("cut off", a.as_bytes()[..a.len() - 30].to_vec()),
        csv("zeros", vec![0; 10_000]),
        csv("picture", [&b"\x89PNG\r\n\x1a\n"[..], &[7; 400]].concat()),
        csv("control characters", "\u{1b}[31mRED\u{1b}]0;x\u{7},b\n1,2\n3,4\n"),
        csv("page", "<html>404</html>\n"),
        csv("JSON", "{\"a\": [1, 2]}\n"),
        csv("long field", a.replacen(&format!("{:?}", rows[10][2]), &"1".repeat(1_000_000), 1)),
        csv("long header", format!("{}\n1\n", "a".repeat(3_000_000))),
        csv("open quote", a.replacen('\n', "\n\"", 1)),
        csv(
            "many columns",
            format!("{}\n1\n", (0..20_000).map(|k| format!("c{k}")).collect::<Vec<_>>().join(",")),
        ),
        csv("two separators", a.replacen(',', ";", 6000).replacen(';', ",", 4)),
        csv("two tables", join(&[&lines[..600], &[""], &lines[600..]])),
        csv("row twice", join(&[&lines[..600], &lines[599..]])),
        csv("clock set back", join(&[&lines[..600], &lines[200..]])),
        csv("gap", join(&[&lines[..600], &lines[900..]])).either(),
        csv("clock stands", mapped(0, &|_| 0.0)),
        csv("clock in ms", mapped(0, &|x| 1e3 * x)),
        csv("clock of 1e308", mapped(0, &|x| 1e305 * x)),
        csv("position in mm", mapped(2, &|x| 1e3 * x)),
        csv("position × 1e300", mapped(2, &|x| 1e300 * x)),
        csv("position stands", mapped(2, &|_| 0.0)),
        csv("current × 1e302", mapped(4, &|x| 1e302 * x)),
        csv("current × 1e3", mapped(4, &|x| 1e3 * x)),
        csv("effort × 1e3", mapped(3, &|x| 1e3 * x)),
    ]);
    cases
}

/// Recordings that are read, and refused when they are split.
fn splits() -> Vec<Case> {
    let (a, b) = sound();
    let lines: Vec<&str> = a.lines().collect();
    let part = |from: usize, to: usize| [&lines[..1], &lines[from..to]].concat().join("\n") + "\n";
    let joined = [&b.lines().take(500).collect::<Vec<_>>()[..], &lines[400..]].concat();
    // Stamps go on: the overlap is one of contents.
    let joined: String = joined
        .iter()
        .enumerate()
        .map(|(k, line)| match (k, line.split_once(',')) {
            (1.., Some((_, rest))) => format!("{:?},{rest}\n", (k - 1) as f64 * 1e-3),
            _ => format!("{line}\n"),
        })
        .collect();
    let machine = |held_out: String, name: &str| {
        let toml = format!("machine = \"machine\"\n{MANIFEST}");
        let files = vec![
            file("recording.toml", toml),
            file("a.csv", a.clone()),
            file("b.csv", held_out),
            file("machine/machine.toml", super::shipped("emps/machine.toml")),
            file("machine/machine.urdf", super::shipped("emps/machine.urdf")),
        ];
        Case::new(format!("split {name}"), files, &["diagnose", "."], "recording.toml")
    };
    let role = |role: &str| {
        let mut case = machine(b.clone(), role);
        case.files[0].1 = format!(
            "machine = \"machine\"\n{}",
            MANIFEST.replace("training", role).replace("held_out", role)
        )
        .into();
        case
    };
    let mut missing = machine(b.clone(), "machine missing");
    missing.files.retain(|(name, _)| !name.starts_with("machine/"));
    let set = |name: &str, setting: &str| {
        let mut case = machine(b.clone(), name);
        case.files[0].1 = format!("machine = \"machine\"\n{MANIFEST}set = {{ {setting} }}\n").into();
        case
    };
    vec![
        machine(a.clone(), "a copy"),
        machine(part(1, 1000), "the first part"),
        machine(part(200, 1201), "the last part"),
        machine(joined, "an overlap"),
        role("training"),
        role("held_out"),
        missing,
        set("an unknown setting", "\"controller.foo\" = 3"),
        set("a setting of a wrong kind", "\"controller.position_gain_per_s\" = \"x\""),
        set("a setting of 1e300", "\"controller.position_gain_per_s\" = 1e300"),
        dead_reference(),
    ]
}

/// A reference that does not move, while the position does, where the loop would be closed.
fn dead_reference() -> Case {
    let machine = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models/grinder");
    let quick = |rows: Vec<[f64; 5]>, told: f64| {
        let row = |[t, reference, x, u, i]: [f64; 5]| [0.25 * t, told * reference, x, u, i];
        text(&rows.into_iter().map(row).collect::<Vec<_>>())
    };
    let toml = MANIFEST.replacen("1e-3", "250e-6", 1);
    let files = vec![
        file("recording.toml", format!("machine = {:?}\n{toml}", machine.display().to_string())),
        file("a.csv", quick(rows(1, 0.02), 0.0)),
        file("b.csv", quick(rows(2, 0.03), 1.0)),
    ];
    Case::new("split dead reference", files, &["diagnose", "."], "a.csv")
}

fn parquets() -> Vec<Case> {
    let toml = MANIFEST.replace("a.csv", "a.parquet");
    let case = |name: &str, bytes: Vec<u8>| {
        let files =
            vec![file("recording.toml", toml.clone()), file("a.parquet", bytes), file("b.csv", sound().1)];
        Case::new(format!("parquet {name}"), files, &INSPECT, "a.parquet")
    };
    let footer = |length: u32| {
        [b"PAR1".to_vec(), vec![0; 40], length.to_le_bytes().to_vec(), b"PAR1".to_vec()].concat()
    };
    vec![
        case("empty", Vec::new()),
        case("magic only", b"PAR1".to_vec()),
        case("magic twice", b"PAR1PAR1".to_vec()),
        case("long footer", footer(u32::MAX / 2)),
        case("no footer", footer(0)),
        case("footer of zeros", footer(40)),
        case("a CSV", sound().0.into()),
    ]
}

pub fn cases() -> Vec<Case> {
    [manifests(), tables(), splits(), parquets()].into_iter().flatten().collect()
}
