//! What each target does with its bytes: they become a file in a folder of sound files, which is then read as the program reads
//! it. `tests/files/fuzz.rs` does the same with every file of the corpus.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use nalgebra::Vector3;
use slideway::error::Result;
use slideway::machine::Machine;
use slideway::plant::{Plant as _, axis::Axis, rapier::Rig};
use slideway::recording::{Existing, Format, LogContext, Recording, Run, Signal, TableLayout};
use slideway::replay::Commands;
use slideway::solid::Mesh;
use slideway::twin::{LinearLoop, Sensing};
use slideway::units::Motion;

/// A format that is fuzzed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    Recording,
    Machine,
    Csv,
    Parquet,
    Mcap,
    Mat,
    Urdf,
    Obj,
    Stl,
}

/// All of them, with the names of their folders below `corpus`.
#[allow(dead_code, reason = "a target asks for itself only")]
pub const ALL: [(Target, &str); 9] = [
    (Target::Recording, "recording"),
    (Target::Machine, "machine"),
    (Target::Csv, "csv"),
    (Target::Parquet, "parquet"),
    (Target::Mcap, "mcap"),
    (Target::Mat, "mat"),
    (Target::Urdf, "urdf"),
    (Target::Obj, "obj"),
    (Target::Stl, "stl"),
];

/// Bytes of a message at most.
const LONGEST_MESSAGE: usize = 4000;
/// Samples that a machine is walked for.
const WALKED: usize = 20;

/// Machines of both kinds, so that keys of sliding and of turning axes can be right.
const SLIDING: &str = r#"<robot name="r">
<link name="base"><inertial><mass value="60"/><inertia ixx="1" ixy="0" ixz="0" iyy="3" iyz="0" izz="3"/></inertial></link>
<link name="table"><inertial><mass value="9"/><inertia ixx="0.4" ixy="0" ixz="0" iyy="0.4" iyz="0" izz="0.6"/></inertial></link>
SLIDERS
<joint name="slide" type="prismatic"><parent link="base"/><child link="table"/><axis xyz="1 0 0"/>
<limit lower="-0.5" upper="0.5" effort="352" velocity="1.0"/></joint></robot>"#;
const TURNING: &str = r#"<robot name="r">
<link name="housing"><inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="arm"><inertial><origin xyz="0 0.1 0" rpy="0 0 0"/><mass value="0.3"/>
<inertia ixx="0.002" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.002"/></inertial></link>
<joint name="slide" type="continuous"><parent link="housing"/><child link="arm"/><axis xyz="1 0 0"/></joint></robot>"#;
const TETRAHEDRON: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const MACHINE: &str = r#"name = "m"
urdf = "machine.urdf"
sample_period_s = 1e-3
[controller]
law = "p"
position_gain_v_per_m = 100.0
[motor]
kind = "direct"
force_n_per_v = 35.0
[encoder]
resolution_m = 5e-8
noise_m = 0.0
velocity = { kind = "taps", taps = [0.5, 0.0, -0.5] }
"#;

/// Reads the bytes in a folder of this process, in memory where there is such a place, and checks what is said of them.
#[allow(dead_code, reason = "the suite names a folder of its own")]
pub fn fuzz(target: Target, bytes: &[u8]) {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let memory = Path::new("/dev/shm");
        let above = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
        let folder = above.join(format!("slideway-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        prepare(target, &folder);
        folder
    });
    checked(target, folder, bytes);
}

/// Reads the bytes in a folder, in every way there is, and checks what is said of them; whether they were read in one.
pub fn checked(target: Target, folder: &Path, bytes: &[u8]) -> bool {
    let read = read(target, folder, bytes);
    for error in read.iter().filter_map(|read| read.as_ref().err()) {
        let text = error.to_string();
        assert!(!text.is_empty() && text.len() < LONGEST_MESSAGE, "{} bytes: {text}", text.len());
        assert!(!text.chars().any(char::is_control), "{text:?}");
    }
    read.iter().any(Result::is_ok)
}

/// Puts the sound files beside which those of a target stand.
pub fn prepare(target: Target, folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    match target {
        Target::Recording => {
            let recording = Recording::new(vec![run("a", 0.02), run("b", 0.03)]).unwrap();
            recording.write(folder.join("log"), Format::Csv, Existing::Replace).unwrap();
        }
        Target::Machine => {
            let slider = |name| {
                let at = if "ab".contains(name) { "0.1" } else { "-0.1" };
                format!(
                    "<link name=\"slider_{name}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link>\n<joint name=\"to_{name}\" type=\"fixed\"><parent link=\"table\"/><child link=\"slider_{name}\"/><origin xyz=\"{at} {at} 0\" rpy=\"0 0 0\"/></joint>\n"
                )
            };
            let sliders: String = ['a', 'b', 'c', 'd'].map(slider).concat();
            write("machine.urdf", &SLIDING.replace("SLIDERS", &sliders));
            write("turning.urdf", TURNING);
        }
        Target::Urdf => {
            write("machine.toml", MACHINE);
            write("part.obj", TETRAHEDRON);
        }
        _ => {}
    }
}

/// A run of a stroke.
fn run(name: &str, stroke: f64) -> Run {
    let position: Vec<f64> = (0..60).map(|k| stroke * f64::from(k) / 59.0).collect();
    let effort = position.iter().map(|x| 1.0 + x.sin()).collect();
    let signals = [(Signal::Position, position), (Signal::ControlEffort, effort)].into_iter().collect();
    Run::new(name, Motion::Prismatic, 1e-3, signals).unwrap()
}

/// Reads the bytes as a file of the target.
fn read(target: Target, folder: &Path, bytes: &[u8]) -> Vec<Result<()>> {
    let put = |name: &str| {
        let path = folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    match target {
        Target::Recording => {
            put("log/recording.toml");
            vec![recorded(&folder.join("log"))]
        }
        Target::Machine => {
            put("machine.toml");
            vec![machine(folder)]
        }
        Target::Urdf => {
            put("machine.urdf");
            vec![machine(folder)]
        }
        Target::Csv => log(folder, &put("log.csv")),
        Target::Parquet => log(folder, &put("log.parquet")),
        Target::Mcap => log(folder, &put("log.mcap")),
        Target::Mat => log(folder, &put("log.mat")),
        Target::Obj => vec![mesh(&put("part.obj"))],
        Target::Stl => vec![mesh(&put("part.stl"))],
    }
}

fn recorded(folder: &Path) -> Result<()> {
    let recording = Recording::read(folder)?;
    recording.sha256();
    Ok(())
}

fn machine(folder: &Path) -> Result<()> {
    let machine = Machine::read(folder)?;
    Rig::new(&machine)?.slider_loads();
    LinearLoop::warning(&machine);
    let commands = Commands::follow(&machine, &[0.0; WALKED])?;
    commands.walk(&machine, Axis::of(&machine.constants()), Sensing::AsStated { seed: 1 }, 0.0, |_| ())?;
    Ok(())
}

/// A log by itself, and by a manifest that takes its first columns for time, position and current, whatever their names.
fn log(folder: &Path, file: &Path) -> Vec<Result<()>> {
    let layout = match TableLayout::of(file) {
        Ok(layout) => layout,
        Err(error) => return vec![Err(error)],
    };
    let context = LogContext { maps: &[], motion: Motion::Prismatic, sample_period_s: 1e-3 };
    let bare = Recording::read_logs(&[file.to_path_buf()], &context);
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let column = |place: usize| {
        let name = layout.columns.get(place).map_or("", |(name, _)| name);
        toml::Value::from(name).to_string()
    };
    let mapped = |[time, position, current]: [usize; 3], head: &str| {
        let time = if head.is_empty() {
            format!("time_s = {{ column = {}, unit = \"s\" }}\n", column(time))
        } else {
            String::new()
        };
        let text = format!(
            "{head}[[run]]\nfile = \"{name}\"\n[columns]\n{time}position_m = {{ column = {}, unit = \"m\" }}\ncurrent_a = {{ column = {}, unit = \"A\" }}\n",
            column(position),
            column(current)
        );
        std::fs::write(folder.join("recording.toml"), text).unwrap();
        recorded(folder)
    };
    vec![bare.map(drop), mapped([0, 1, 2], ""), mapped([0, 0, 1], "sample_period_s = 1e-3\n")]
}

fn mesh(file: &Path) -> Result<()> {
    let mesh = Mesh::read(file, Vector3::repeat(1.0))?;
    mesh.check_size().and_then(|()| mesh.check_closed())
}
