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
        &["diagnos", "full"],
        &["diagnose", "full", "--jsn", "x"],
    ] {
        cases.push(case(words));
    }
    cases
}
