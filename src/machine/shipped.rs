//! The machines that are shipped, for tests of the library.

use super::Machine;
use std::path::Path;

/// Every shipped machine, by the names of their folders.
pub(crate) fn shipped() -> impl Iterator<Item = Machine> {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let mut folders: Vec<_> = std::fs::read_dir(models).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    folders.into_iter().filter_map(|folder| Machine::read(&folder).ok())
}
