//! The real ball-screw axis whose parameters are published, diagnosed from its logs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use slideway::diagnose::{Diagnosis, Options, diagnose};
use slideway::machine::Machine;
use slideway::recording::Recording;
use std::path::Path;

fn run(machine: &str) -> Diagnosis {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let recording = Recording::read(root.join("models/emps/recording.toml")).unwrap();
    let machine = Machine::read(&root.join(machine)).unwrap();
    diagnose(&machine, &recording, &Options { progress: &|s| println!("fitted {s}"), ..Options::default() })
        .unwrap()
}

#[test]
fn ref_probe() {
    for m in ["models/emps", "models/emps/symmetric.toml"] {
        let d = run(m);
        println!("{}", serde_json::to_string_pretty(&d).unwrap());
    }
}
