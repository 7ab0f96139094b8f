//! Machines: every number wrong in every way, keys and tables missing, solid models and meshes that are none.

use super::{Case, file, shipped};

/// A machine with a voltage-fed motor, registers, modes and sensors, without meshes.
const MACHINE: &str = r#"name = "slide"
urdf = "machine.urdf"
joint = "slide"
sample_period_s = 1e-3

[reference]
acceleration_time_s = 0.02

[controller]
law = "pdf"
integral = 19
proportional = 260
integral_gain_per_count = 2.4e-3
proportional_gain_per_count = 2.4e-4
velocity_units_per_si = 1000.0
position_gain_per_s = 20.0
velocity_feedforward = 0.5

[amplifier]
voltage_limit_v = 10.0
delay_s = 1e-4

[motor]
kind = "winding"
resistance_ohm = 3.0
inductance_h = 0.02
force_constant_n_per_a = 80.0
back_emf_v_s_per_m = 1.5

[guide]
viscous_n_s_per_m = 100.0

[base]
[[base.mode]]
frequency_hz = 60.0
mass_kg = 900.0
damping_ratio = 0.02

[encoder]
resolution_m = 5e-8
noise_m = 1e-8
velocity = { kind = "taps", taps = [0.5, 0.0, -0.5] }

[current_sensor]
noise_a = 1e-3

[tolerance]
mass = 0.03

[effect.coulomb_friction]
force_n = 10.0

[effect.loop_delay]
delay_s = 1e-4
"#;
const INSPECT: [&str; 2] = ["inspect", "."];
const REPLAY: [&str; 11] =
    ["replay", "--machine", ".", "--cell", "0.005@8", "--dwell", "0.05", "--plant", "axis", "--out", "out"];

fn solid() -> String {
    shipped("emps/machine.urdf").replace("screw_slide", "slide")
}

fn of(name: &str, text: impl Into<Vec<u8>>, arguments: &[&str]) -> Case {
    let files = vec![file("machine.toml", text), file("machine.urdf", solid())];
    Case::new(format!("machine {name}"), files, arguments, "machine.toml")
}

/// Every number of the file in turn, with what it stands behind.
fn numbers() -> Vec<(String, usize, usize)> {
    let (mut at, mut found, mut table) = (0, Vec::new(), String::new());
    for line in MACHINE.split_inclusive('\n') {
        if line.starts_with('[') {
            table = format!("{} ", line.trim());
        }
        if let Some((key, value)) =
            line.trim_end().split_once(" = ").filter(|(_, value)| value.parse::<f64>().is_ok())
        {
            let from = at + key.len() + 3;
            found.push((format!("{table}{key}"), from, from + value.len()));
        }
        at += line.len();
    }
    found
}

pub fn cases() -> Vec<Case> {
    let mut cases = vec![of("good", MACHINE, &REPLAY).sound()];
    for (key, from, to) in numbers() {
        for wrong in ["-", "nan", "inf", "1e300", "-1e300", "\"x\"", "[1]", "true"] {
            let value = if wrong == "-" { format!("-{}", &MACHINE[from..to]) } else { wrong.to_owned() };
            let text = format!("{}{value}{}", &MACHINE[..from], &MACHINE[to..]);
            // A 16-bit register takes the nearest number that it can hold.
            let case = of(&format!("{key} = {value}"), text, &INSPECT);
            let may_be_negative = wrong == "-" && key.ends_with("velocity_feedforward");
            cases.push(if may_be_negative { case.either() } else { case });
        }
    }
    for line in MACHINE.lines().filter(|line| line.contains(" = ")) {
        let key = line.split(' ').next().unwrap();
        let case = of(&format!("without {line}"), MACHINE.replacen(&format!("{line}\n"), "", 1), &INSPECT);
        let needed = [
            "name",
            "urdf",
            "law",
            "kind",
            "resistance_ohm",
            "inductance_h",
            "force_constant_n_per_a",
            "frequency_hz",
            "mass_kg",
            "damping_ratio",
            "integral",
            "proportional",
            "velocity_feedforward",
            "integral_gain_per_count",
            "proportional_gain_per_count",
            "velocity_units_per_si",
            "position_gain_per_s",
        ];
        let both = needed.contains(&key) || line == "sample_period_s = 1e-3" || line == "force_n = 10.0";
        cases.push(if both { case } else { case.either() });
    }
    let edits = [
        ("unknown key", "joint =", "colour = 1\njoint ="),
        ("unknown key in a table", "integral = 19", "integral = 19\nKp = 3"),
        ("unknown law", "\"pdf\"", "\"pid\""),
        ("unknown motor", "\"winding\"", "\"stepper\""),
        ("key of a turning axis", "viscous_n_s_per_m", "viscous_nm_s_per_rad"),
        ("motor of a turning axis", "force_constant_n_per_a", "torque_constant_nm_per_a"),
        ("encoder of a turning axis", "resolution_m", "resolution_rad"),
        ("effect of a turning axis", "force_n = 10.0", "torque_nm = 10.0"),
        ("no such joint", "\"slide\"\nsample", "\"tilt\"\nsample"),
        ("no such URDF", "\"machine.urdf\"", "\"other.urdf\""),
        ("URDF outside", "\"machine.urdf\"", "\"../../../../../../etc/passwd\""),
        ("URDF of the system", "\"machine.urdf\"", "\"/etc/passwd\""),
        ("URDF a folder", "\"machine.urdf\"", "\".\""),
        ("joint a number", "joint = \"slide\"", "joint = 3"),
        ("held joint unknown", "joint =", "held_joints = [\"tilt\"]\njoint ="),
        ("table opened twice", "[guide]", "[motor]\n[guide]"),
        ("bracket missing", "[motor]", "[motor"),
        ("line of action far off", "kind =", "lines_of_action_m = [[0.0, 1e12, 0.0]]\nkind ="),
        ("sliders that are not there", "[guide]", "[guide]\nsliders = [\"a\", \"a\"]"),
        ("delay of 1e9 s", "delay_s = 1e-4\n\n[motor]", "delay_s = 1e9\n\n[motor]"),
        (
            "effect with a delay of 1e9 s",
            "[effect.loop_delay]\ndelay_s = 1e-4",
            "[effect.loop_delay]\ndelay_s = 1e9",
        ),
        ("empty effect", "force_n = 10.0", ""),
        ("unknown effect", "[effect.coulomb_friction]", "[effect.gremlin]"),
        (
            "plan of tuning backwards",
            "[tolerance]",
            "[[tune.vary]]\nkey = \"controller.integral\"\nfrom = 9\nto = 3\n[tolerance]",
        ),
        (
            "plan of tuning with an endless step",
            "[tolerance]",
            "[[tune.vary]]\nkey = \"controller.integral\"\nfrom = 1\nto = 3\nstep = nan\n[tolerance]",
        ),
    ];
    for (name, from, to) in edits {
        assert!(MACHINE.contains(from), "{name}");
        let mut case = of(name, MACHINE.replacen(from, to, 1), &INSPECT);
        if name.starts_with("no such")
            || name.starts_with("URDF a")
            || name.contains("held")
            || name.contains("sliders")
        {
            case.at_fault = "";
        }
        cases.push(case);
    }
    cases.extend(plans());
    cases.push(of("empty", "", &INSPECT));
    cases.push(of("binary", (0..=255).collect::<Vec<u8>>(), &INSPECT));
    cases.push(of("deep", format!("a={}", "[".repeat(20_000)), &INSPECT));
    cases.push(of("deep keys", format!("a{}=1", ".a".repeat(50_000)), &INSPECT));
    cases
}

/// Plans of tuning and cross-checking that no axis or controller suits.
fn plans() -> Vec<Case> {
    let vary = |key: &str, from: &str, to: &str| {
        format!("[[tune.vary]]\nkey = \"controller.{key}\"\nfrom = {from}\nto = {to}\n")
    };
    let registers = vary("integral", "6", "65");
    [
        ("a key that is not there", vary("nope", "1", "2")),
        (
            "a key of another part",
            vary("integral", "1", "2").replace("controller.integral", "guide.viscous_n_s_per_m"),
        ),
        ("a table for a key", vary("integral", "1", "2").replace("controller.integral", "controller")),
        ("half a count", vary("integral", "6.5", "65")),
        ("half a count as step", registers.clone() + "step = 0.5\n"),
        ("beyond a register", vary("integral", "6", "70000")),
        ("a negative gain", vary("position_gain_per_s", "-1.0", "20.0")),
        ("one number twice", registers.clone() + &registers),
        ("marks too long", format!("[tune]\nmarks = [[22, 220]]\n{registers}")),
        ("marks of nothing", "[tune]\nmarks = [[22, 220]]\n".to_owned()),
        ("marks beyond a register", format!("[tune]\nmarks = [[1e300]]\n{registers}")),
        ("a limit of nothing", "[tune.limits]\novershoot = 1\n".to_owned()),
        ("a limit of a turning axis", "[tune.limits]\nfollowing_error_rad = 1.0\n".to_owned()),
        ("a negative limit", "[tune.limits]\nposition_overshoot_percent = -1\n".to_owned()),
        ("a stroke beyond the travel", "[tune]\ncells = [\"3@8\"]\n".to_owned()),
        ("a cross-check beyond the travel", "[crosscheck]\ncells = [\"0.02@8\", \"-3@8\"]\n".to_owned()),
    ]
    .into_iter()
    .map(|(name, plan)| of(&format!("plan with {name}"), format!("{MACHINE}\n{plan}"), &INSPECT))
    .collect()
}

fn solid_of(name: &str, urdf: impl Into<Vec<u8>>) -> Case {
    let files = vec![file("machine.toml", MACHINE), file("machine.urdf", urdf)];
    Case::new(format!("solid {name}"), files, &INSPECT, "machine.urdf")
}

pub fn solids() -> Vec<Case> {
    let sound = solid();
    let mut cases = Vec::new();
    let edits = [
        ("another root", "<robot name=\"emps\">", "<sdf name=\"emps\">"),
        ("mass zero", "value=\"95.1089\"", "value=\"0\""),
        ("mass negative", "value=\"95.1089\"", "value=\"-95\""),
        ("mass NaN", "value=\"95.1089\"", "value=\"nan\""),
        ("mass 1e300", "value=\"95.1089\"", "value=\"1e300\""),
        ("mass 1e-300", "value=\"95.1089\"", "value=\"1e-300\""),
        ("mass a word", "value=\"95.1089\"", "value=\"heavy\""),
        ("mass with a comma", "value=\"95.1089\"", "value=\"95,1\""),
        ("inertia negative", "ixx=\"0.40342\"", "ixx=\"-1\""),
        ("inertia of no body", "ixx=\"0.40342\"", "ixx=\"100\""),
        ("inertia NaN", "ixx=\"0.40342\"", "ixx=\"nan\""),
        ("inertia 1e300", "ixx=\"0.40342\"", "ixx=\"1e300\""),
        ("axis zero", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"0 0 0\"/>"),
        ("axis NaN", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"nan 0 0\"/>"),
        ("axis of two", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0\"/>"),
        ("axis missing", "<axis xyz=\"1 0 0\"/>", ""),
        ("mimic", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0 0\"/><mimic joint=\"x\"/>"),
        ("planar joint", "type=\"prismatic\"", "type=\"planar\""),
        ("unknown joint", "type=\"prismatic\"", "type=\"slippery\""),
        ("fixed joint", "type=\"prismatic\"", "type=\"fixed\""),
        ("limits reversed", "lower=\"-0.05\" upper=\"0.35\"", "lower=\"0.35\" upper=\"-0.05\""),
        ("limit NaN", "lower=\"-0.05\"", "lower=\"nan\""),
        ("origin 1e300", "xyz=\"0 0 0.02\"", "xyz=\"0 1e300 0.02\""),
        ("origin NaN", "xyz=\"0 0 0.02\"", "xyz=\"0 nan 0.02\""),
        ("child missing", "<child link=\"carriage\"/>", "<child link=\"nope\"/>"),
        ("two links of a name", "<link name=\"carriage\">", "<link name=\"base\">"),
        ("box of no size", "size=\"0.16 0.22 0.05\"", "size=\"0 0 0\""),
        ("box of two sides", "size=\"0.16 0.22 0.05\"", "size=\"0.16 0.22\""),
        ("link without an end", "</link>", ""),
        ("entity", "name=\"emps\"", "name=\"&lol;\""),
        (
            "second joint",
            "</robot>",
            "<link name=\"b\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><joint name=\"tilt\" type=\"revolute\"><parent link=\"carriage\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/><limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>",
        ),
        (
            "ring of joints",
            "</robot>",
            "<joint name=\"ring\" type=\"fixed\"><parent link=\"carriage\"/><child link=\"base\"/></joint></robot>",
        ),
    ];
    for (name, from, to) in edits {
        assert!(sound.contains(from), "{name}");
        cases.push(solid_of(name, sound.replacen(from, to, 1)));
    }
    let turning = sound.replace("type=\"prismatic\"", "type=\"continuous\"");
    let mut case = solid_of("turning joint with keys of a sliding one", turning);
    case.at_fault = "machine.toml";
    cases.push(case);
    cases.push(solid_of("empty", ""));
    cases.push(solid_of("no XML", "hello"));
    cases.push(solid_of("cut off", &sound.as_bytes()[..1500]));
    cases.push(solid_of("binary", (0..3000_u32).map(|k| ((k * 7919) >> 3) as u8).collect::<Vec<u8>>()));
    cases.push(solid_of(
        "UTF-16",
        [&[0xFF, 0xFE][..], &sound.bytes().flat_map(|b| [b, 0]).collect::<Vec<u8>>()].concat(),
    ));
    cases.push(solid_of(
        "deep",
        format!("<robot name=\"x\">{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000)),
    ));
    cases.push(solid_of("deep and open", format!("<robot name=\"x\">{}", "<a>".repeat(20_000))));
    let laughs: String =
        (1..10).map(|k| format!("<!ENTITY l{k} \"{}\">", format!("&l{};", k - 1).repeat(10))).collect();
    cases.push(solid_of("bomb", format!("<!DOCTYPE r [<!ENTITY l0 \"ha\">{laughs}]><robot name=\"&l9;\"/>")));
    cases.push(solid_of(
        "entity from a file",
        "<!DOCTYPE r [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><robot name=\"&x;\"/>",
    ));
    cases
}

/// A closed tetrahedron of 0.1 m.
const OBJ: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn mesh(name: &str, path: &str, at_fault: &'static str, mesh: Option<(&str, Vec<u8>)>) -> Case {
    let shape = format!("<mesh filename=\"{path}\"/>");
    let urdf = solid().replacen("<box size=\"0.16 0.22 0.05\"/>", &shape, 1);
    let mut files = vec![file("machine.toml", MACHINE), file("machine.urdf", urdf), file("meshes/keep", "")];
    files.extend(mesh.map(|(name, bytes)| file(name, bytes)));
    Case::new(format!("mesh {name}"), files, &INSPECT, at_fault)
}

pub fn meshes() -> Vec<Case> {
    let mut cases = vec![mesh("good", "bad.obj", "", Some(("bad.obj", OBJ.into()))).sound()];
    let texts = [
        ("empty", String::new()),
        ("garbage", "\u{7}\u{1b}[31m\n".repeat(50)),
        ("vertex NaN", OBJ.replacen("v 0 0 0", "v nan 0 0", 1)),
        ("vertex 1e400", OBJ.replacen("v 0 0 0", "v 1e400 0 0", 1)),
        ("vertex 1e300", OBJ.replacen("v 0 0 0", "v 1e300 0 0", 1)),
        ("index beyond", OBJ.replacen("f 1 3 2", "f 1 3 99", 1)),
        ("index zero", OBJ.replacen("f 1 3 2", "f 0 3 2", 1)),
        ("index far back", OBJ.replacen("f 1 3 2", "f -90 3 2", 1)),
        ("no faces", "v 0 0 0\nv 1 0 0\n".to_owned()),
        ("one triangle", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n".to_owned()),
        ("hole", OBJ.replacen("f 1 3 2\n", "", 1)),
        (
            "inside out",
            OBJ.replace("f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4", "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1"),
        ),
        ("in mm", OBJ.replace("0.1", "100")),
    ];
    for (name, text) in texts {
        cases.push(mesh(&format!("OBJ {name}"), "bad.obj", "bad.obj", Some(("bad.obj", text.into()))));
    }
    let head = |count: u32| [&[0_u8; 80][..], &count.to_le_bytes()].concat();
    let stls = [
        ("empty", Vec::new()),
        ("short", vec![0; 60]),
        ("counted too many", head(u32::MAX)),
        ("no triangle", head(0)),
        ("cut off", [head(2), vec![0; 70]].concat()),
        ("NaN", [head(1), f32::NAN.to_le_bytes().repeat(12), vec![0; 2]].concat()),
        ("text cut off", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n".to_vec()),
        ("page", b"<html>404</html>".to_vec()),
    ];
    for (name, bytes) in stls {
        cases.push(mesh(&format!("STL {name}"), "bad.stl", "bad.stl", Some(("bad.stl", bytes))));
    }
    let paths = [
        ("missing", "none.obj"),
        ("outside", "../../../../../../etc/passwd"),
        ("of the system", "/etc/passwd"),
        ("of the system as a file", "file:///etc/passwd"),
        ("a folder", "meshes"),
        ("a device", "/dev/zero"),
        ("no name", ""),
        ("from the net", "http://127.0.0.1/x.stl"),
        ("a package outside", "package://../../../../etc/passwd"),
    ];
    cases.extend(paths.map(|(name, path)| mesh(&format!("path {name}"), path, "machine.urdf", None)));
    cases.push(mesh("ending", "a.dae", "a.dae", Some(("a.dae", b"<x/>".to_vec()))));
    cases
}
