//! Command lines: numbers out of range, places that cannot be written, names of nothing.

use super::{Case, file, shipped};

fn case(arguments: &[&str]) -> Case {
    let files = vec![
        file("machine/machine.toml", shipped("emps/machine.toml")),
        file("machine/machine.urdf", shipped("emps/machine.urdf")),
        file("notes.txt", "my notes\n"),
        file("page.html", "<p>mine</p>\n"),
        file("full/keep.txt", "my notes\n"),
    ];
    Case::new(format!("words {}", arguments.join(" ")), files, arguments, "")
}

fn replay(further: &[&str]) -> Case {
    let default = |option: &'static str, value: &'static str| -> Vec<&str> {
        if further.contains(&option) { Vec::new() } else { vec![option, value] }
    };
    let common =
        [vec!["replay", "--machine", "machine"], default("--plant", "axis"), default("--dwell", "0.05")]
            .concat();
    let out: &[&str] = if further.contains(&"--out") { &[] } else { &["--out", "out"] };
    let cell: &[&str] =
        if further.iter().any(|word| word.starts_with("--cell")) { &[] } else { &["--cell=0.005@8"] };
    case(&[&common, cell, out, further].concat())
}

pub fn cases() -> Vec<Case> {
    let mut cases = vec![replay(&[]).sound()];
    for cell in [
        "abc",
        "0.02",
        "0.02@",
        "@8",
        "0.02@0",
        "0@8",
        "0.02@-8",
        "nan@8",
        "0.02@nan",
        "inf@8",
        "0.02@inf",
        "1e300@8",
        "10@8",
        "0.02@1e10",
        "0.02@1e-9",
        "0.02@1e-300",
        "0.02@8@9",
        "0,02@8",
        "20mm@8",
        "",
    ] {
        cases.push(replay(&[&format!("--cell={cell}")]));
    }
    for further in [
        ["--dwell", "-1"],
        ["--dwell", "nan"],
        ["--dwell", "1e9"],
        ["--lead", "inf"],
        ["--repeat", "0"],
        ["--repeat", "-1"],
        ["--repeat", "1000000"],
        ["--repeat", "100000000"],
        ["--noise", "x"],
        ["--plant", "foo"],
        ["--format", "xlsx"],
        ["--set", "foo"],
        ["--set", "foo=1"],
        ["--set", "controller.position_gain_per_s=x"],
        ["--set", "controller.position_gain_per_s=-3"],
        ["--set", "controller.position_gain_per_s=1e300"],
        ["--set", "amplifier.delay_s=1e9"],
        ["--set", "effect.loop_delay.delay_s=1e9"],
        ["--set", "reference.acceleration_time_s=1e300"],
        ["--set", "sample_period_s=1e-9"],
        ["--set", "sample_period_s=0"],
        ["--set", "name=3"],
        ["--set", "=3"],
        ["--hide", "effect.nothing.x=1"],
        ["--hide", "effect.coulomb_friction.force_n=-1"],
        ["--hide", "effect.coulomb_friction.force_n=nan"],
        ["--hide", "effect.coulomb_friction.force_n=1e300"],
        ["--hide", "effect.backlash.width_m=1e9"],
        ["--out", "full"],
        ["--out", "notes.txt"],
        ["--out", "notes.txt/x"],
        ["--out", "/proc/x"],
        ["--out", ""],
        ["--out", "machine"],
        ["--html", "out"],
        ["--html", "notes.txt"],
        ["--html", "page.html"],
        ["--html", "machine/machine.toml"],
        ["--html", "full"],
        ["--html", "none/page.html"],
        ["--html", ""],
        ["--html", "/dev/full"],
        ["--figures", "notes.txt"],
        ["--figures", "notes.txt/x"],
        ["--figures", "/proc/x"],
    ] {
        cases.push(replay(&further));
    }
    cases.extend(places());
    for words in [
        &["replay", "--machine", "none", "--cell", "0.02@8", "--out", "out"][..],
        &["replay", "--machine", "notes.txt", "--cell", "0.02@8", "--out", "out"],
        &["replay", "--machine", "", "--cell", "0.02@8", "--out", "out"],
        &["diagnose", "none"],
        &["diagnose", ""],
        &["diagnose", "notes.txt"],
        &["diagnose", "full"],
        &["inspect", "none"],
        &["inspect", "notes.txt"],
        &["inspect", "/dev/zero"],
        &["inspect", "machine", "--html", "notes.txt"],
        &["identify", "none"],
        &["identify", "--machine", "machine", "--plant", "axis", "--period", "1e9"],
        &[
            "identify",
            "--machine",
            "machine",
            "--plant",
            "axis",
            "--period",
            "0.025",
            "--samples",
            "2000000000",
        ],
        &["identify", "--machine", "machine", "--plant", "axis", "--period", "0.025", "--seed", "1.5"],
        &["trial", "forge", "--machine", "machine", "--seed", "7", "--cases", "0", "--out", "trial"],
        &["trial", "forge", "--machine", "machine", "--seed", "x", "--out", "trial"],
        &["trial", "forge", "--machine", "machine", "--seed", "7", "--tier", "foo", "--out", "trial"],
        &["trial", "forge", "--machine", "machine", "--seed", "7", "--out", "full"],
        &["trial", "run", "none"],
        &["trial", "run", "full"],
        &["trial", "run", "notes.txt"],
        &["trial", "score", "none"],
        &["trial", "run", "full", "--jobs", "0"],
        &["frobnicate"],
        &["trial", "forge", "--machine", "machine", "--seed", "7", "--jobs", "100000000", "--out", "trial"],
        &[
            "trial",
            "forge",
            "--machine",
            "machine",
            "--seed",
            "7",
            "--cases",
            "99999999999",
            "--out",
            "trial",
        ],
        &["trial", "run", "full", "--jobs", "100000000"],
        &[
            "replay",
            "--machine",
            "machine",
            "--cell",
            "0.02@8",
            "--set",
            "urdf=\"other.urdf\"",
            "--out",
            "out",
        ],
        &["replay", "--machine", "machine", "--cell", "0.02@8", "--hide", "joint=\"tilt\"", "--out", "out"],
        &["replay", "--machine", "machine", "--cell", "0.02@8", "--set", "controller=3", "--out", "out"],
        &["tune", "machine", "--friction", "1e300"],
        &["tune", "machine", "--vary", "guide.viscous_n_s_per_m=1..2"],
        &["tune", "machine", "--mark", "1,2,3,4,5"],
        &["man", "--out", "notes.txt"],
        &["crosscheck", "machine", "--cell", "9@8"],
        &["diagnos", "full"],
        &["diagnose", "full", "--jsn", "x"],
    ] {
        cases.push(case(words));
    }
    cases
}

/// A machine, recordings of it, and what several options would write; the message names the place at fault.
fn recorded(arguments: &[&str], at_fault: &'static str) -> Case {
    let row = |k: u32| {
        let time = f64::from(k) * 1e-3;
        format!("{time},{},{}\n", 0.1 * (1.0 - (5.0 * time).cos()), (5.0 * time).sin())
    };
    let rows: String = (0..3000).map(row).collect();
    let mut case = case(arguments);
    for folder in ["log", "before"] {
        case.files.push(file(&format!("{folder}/recording.toml"), "[[run]]\nfile = \"a.csv\"\n"));
        case.files
            .push(file(&format!("{folder}/a.csv"), format!("time_s,position_m,control_effort_v\n{rows}")));
    }
    case.files.push(file("drawings/mine.svg", "<svg/>"));
    Case { at_fault, ..case }
}

/// Outputs in one another's place, or in that of an input.
fn places() -> Vec<Case> {
    let diagnoses = [
        (&["--json", "x.json", "--figure", "x.json"][..], "`--figure`"),
        (&["--json", "x.json", "--html", "full/../x.json"], "the place that --html writes"),
        (&["--figure", "x", "--figures", "x"], "the place that --figures writes"),
        (&["--figures", "full", "--figure", "full/path.svg"], "not apart from that of --figures"),
        (&["--figures", "drawings"], "drawings/mine.svg"),
        (&["--write-machine", "new", "--figures", "new/figures"], "not apart from that of --figures"),
        (&["--write-machine", "new", "--figures", "new"], "the place that --figures writes"),
        (&["--write-machine", "machine", "--replace"], "the place of machine, which is read"),
        (&["--write-machine", "log", "--replace"], "the place of log, which is read"),
        (&["--write-machine", ".", "--replace"], "which is read"),
        (&["--reference", "log"], "in both recordings"),
        (&["--reference", "before"], "in both recordings"),
    ];
    let replays = [
        (&["--commands", "log", "--out", "log", "--replace"][..], "the place of log, which is read"),
        (&["--commands", "log", "--out", "out", "--html", "p.html"], "cannot be used with"),
        (&["--recording", "log", "--out", "log", "--replace"], "the place of log, which is read"),
        (&["--recording", "log", "--out", "before"], "before, `--out`"),
        (&["--recording", "log", "--figures", "drawings"], "drawings/mine.svg"),
        (&["--cell=0.005@8", "--out", "out", "--figures", "out/figures"], "not apart from that of --figures"),
        (&["--cell=0.005@8", "--out", "out", "--html", "out"], "the place that --html writes"),
    ];
    let others = [
        (&["identify", "log", "--input", "position_m", "--output", "position_m"][..], "the input too"),
        (&["tune", "machine", "--map", "x", "--html", "x"], "the place that --html writes"),
        (&["tune", "machine", "--map", "x/a.svg", "--figures", "x"], "not apart from that of --figures"),
        (&["inspect", "machine", "--html", "x", "--figures", "x"], "the place that --html writes"),
        (&["trial", "score", "full", "--json", "x", "--figure", "x"], "the place that --json writes"),
        (&["trial", "score", "full", "--json", "full/verdicts/0.json"], "among those of the trial"),
    ];
    let begun = |words: &[&'static str], (further, at_fault): (&[&'static str], &'static str)| {
        recorded(&[words, further].concat(), at_fault)
    };
    let diagnoses = diagnoses.map(|case| begun(&["diagnose", "log", "--machine", "machine"], case));
    let replays = replays.map(|case| begun(&["replay", "--machine", "machine", "--plant", "axis"], case));
    diagnoses.into_iter().chain(replays).chain(others.map(|case| begun(&[], case))).collect()
}
