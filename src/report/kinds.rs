//! The tables of a machine file in words: all in a list, or one with its keys and an example.

use super::Style;
use super::layout::{INDENT, Ink, labelled};
use super::wrap::columns;
use crate::machine::{FileKey, FileTable};

/// Width of the labels of one table.
const LABEL: usize = 12;
/// Tables as one may write them, with the path and the kind that they show.
const EXAMPLES: [(&str, &str, &str); 27] = [
    ("", "", "name = \"slide\"\nurdf = \"machine.urdf\"\njoint = \"table_slide\"\nsample_period_s = 250e-6"),
    ("reference", "", "[reference]\nacceleration_time_s = 0.02"),
    (
        "controller",
        "pdf",
        "[controller]\nlaw = \"pdf\"\nintegral = 22\nproportional = 220\nintegral_gain_per_count = 6.9e-2\n\
         proportional_gain_per_count = 2.4e-4\nvelocity_units_per_si = 1000.0\nposition_gain_per_s = 6.5\nvelocity_feedforward = 0.7",
    ),
    (
        "controller",
        "cascade",
        "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 200.0\n\
         velocity_integral_per_s = 50.0",
    ),
    (
        "controller",
        "pd",
        "[controller]\nlaw = \"pd\"\nposition_gain_v_per_m = 4000.0\nderivative_gain_v_s_per_m = 60.0",
    ),
    (
        "controller.anti_windup",
        "none",
        "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 200.0\n\
         effort_limit_v = 10.0\nanti_windup = { kind = \"none\" }",
    ),
    (
        "controller.anti_windup",
        "clamping",
        "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 200.0\n\
         velocity_integral_per_s = 50.0\neffort_limit_v = 10.0\nanti_windup = { kind = \"clamping\" }",
    ),
    (
        "controller.anti_windup",
        "back_calculation",
        "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 200.0\n\
         velocity_integral_per_s = 50.0\neffort_limit_v = 10.0\n\
         anti_windup = { kind = \"back_calculation\", tracking_time_s = 0.02 }",
    ),
    (
        "controller.filter",
        "notch",
        "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 200.0\n\
         filter = [{ kind = \"notch\", frequency_hz = 120.0, bandwidth_hz = 20.0, depth = 0.1 }]",
    ),
    (
        "controller.filter",
        "low_pass",
        "[controller]\nlaw = \"cascade\"\nposition_gain_per_s = 20.0\nvelocity_gain_v_s_per_m = 200.0\n\
         filter = [{ kind = \"low_pass\", frequency_hz = 400.0, damping = 0.7 }]",
    ),
    ("amplifier", "", "[amplifier]\nvoltage_limit_v = 150.0\ndelay_s = 250e-6"),
    (
        "motor",
        "winding",
        "[motor]\nkind = \"winding\"\nresistance_ohm = 1.3\ninductance_h = 8e-3\nforce_constant_n_per_a = 83.1\n\
         back_emf_v_s_per_m = 48.0",
    ),
    (
        "motor",
        "current_loop",
        "[motor]\nkind = \"current_loop\"\ncommand_a_per_v = 1.0\ntime_constant_s = 4e-4\nforce_constant_n_per_a = 83.1",
    ),
    ("motor", "direct", "[motor]\nkind = \"direct\"\nforce_n_per_v = 35.15"),
    ("transmission", "", "[transmission]\nratio = 628.3\nrotor_inertia_kg_m2 = 2e-4"),
    ("screw", "", "[screw]\nlead_m = 0.01"),
    ("guide", "", "[guide]\nviscous_n_s_per_m = 200.0"),
    ("base.mode", "", "[[base.mode]]\nfrequency_hz = 86.1\nmass_kg = 1500.0\ndamping_ratio = 0.02"),
    (
        "encoder",
        "",
        "[encoder]\nresolution_m = 50e-9\nnoise_m = 40e-9\n\
         velocity = { kind = \"smoothed_difference\", time_constant_s = 1e-3 }",
    ),
    (
        "encoder.velocity",
        "smoothed_difference",
        "[encoder]\nvelocity = { kind = \"smoothed_difference\", time_constant_s = 1e-3 }",
    ),
    ("encoder.velocity", "taps", "[encoder]\nvelocity = { kind = \"taps\", taps = [1.0, -1.0] }"),
    ("load_sensor", "", "[load_sensor]\nresolution_m = 1e-6"),
    ("current_sensor", "", "[current_sensor]\nnoise_a = 0.01"),
    ("crosscheck", "", "[crosscheck]\ncells = [\"0.02@8\", \"0.05@16\"]"),
    ("tune", "", "[tune]\ncells = [\"0.02@8\"]"),
    ("tune.vary", "", "[[tune.vary]]\nkey = \"controller.integral\"\nfrom = 10.0\nto = 40.0\nstep = 2.0"),
    ("tolerance", "", "[tolerance]\nmass = 0.05\nforce_constant = 0.02"),
];

/// The tables of a machine file with their kinds, and what each is.
pub fn kind_list(tables: &[FileTable], style: Style) -> String {
    let mut out = style.heading("machine.toml", "tables, and the kinds of those that come in several");
    out = out.trim_start_matches('\n').to_owned();
    let width = tables.iter().map(|table| columns(&named(table))).max().unwrap_or_default();
    for table in tables.iter().filter(|table| !table.path.is_empty()) {
        out += &labelled(&named(table), width, &table.description, style);
    }
    out += &labelled("[effect.NAME]", width, "An effect that the twin already has: slideway effects", style);
    out + "\nOne of them: slideway kinds NAME, a table (motor) or a kind (cascade)\n"
}

/// A table as it is headed, with the choice of its kind.
fn named(table: &FileTable) -> String {
    let head = if table.listed { format!("[[{}]]", table.path) } else { format!("[{}]", table.path) };
    match (&table.chosen_by, &table.kind) {
        (Some(key), Some(kind)) => format!("{head} {key} = \"{kind}\""),
        _ => head,
    }
}

/// A table's keys with what they mean, and an example.
pub fn kind_sheet(table: &FileTable, style: Style) -> String {
    let head = if table.path.is_empty() { "top of the file".to_owned() } else { named(table) };
    let mut out = format!("{}\n", style.ink(Ink::Heading, &head));
    out += &labelled("is", LABEL, &table.description, style);
    out += &style.heading("keys", "");
    let width = table.keys.iter().map(|key| columns(&key.name)).max().unwrap_or_default();
    for key in &table.keys {
        out += &labelled(&key.name, width, &said(key), style);
    }
    if table.keys.is_empty() {
        out += &format!("{INDENT}none\n");
    }
    if let Some(example) = kind_example(table) {
        out += &style.heading("example", "");
        out += &example.lines().map(|line| format!("{INDENT}{line}\n")).collect::<String>();
    }
    out
}

fn said(key: &FileKey) -> String {
    match (&key.default, key.required) {
        (_, true) => format!("{} Required.", key.description),
        (Some(default), false) => format!("{} Default {default}.", key.description),
        (None, false) => key.description.clone(),
    }
}

/// A text for a machine file that shows the table.
pub fn kind_example(table: &FileTable) -> Option<&'static str> {
    let kind = table.kind.as_deref().unwrap_or_default();
    EXAMPLES.iter().find(|(path, of, _)| *path == table.path && *of == kind).map(|(.., text)| *text)
}
