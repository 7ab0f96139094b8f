//! For the feature `mujoco` tells programs where its shared library is; does nothing without that feature.
//!
//! The binding names the library when a program is linked, and refuses a build that does not say where it is. It leaves
//! open where a program finds the library when it starts.
#![allow(clippy::print_stdout)]

use std::env;

/// Absolute folder of MuJoCo's shared library; absent where pkg-config knows the library, or where it is linked statically.
const FOLDER: &str = "MUJOCO_DYNAMIC_LINK_DIR";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={FOLDER}");
    let is_wanted = env::var_os("CARGO_FEATURE_MUJOCO").is_some() && env::var_os("CARGO_CFG_UNIX").is_some();
    if let (true, Ok(folder)) = (is_wanted, env::var(FOLDER)) {
        println!("cargo::rustc-link-arg=-Wl,-rpath,{folder}");
    }
}
