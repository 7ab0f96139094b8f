//! Files and folders that are there whole or not at all, whatever is killed when.

mod file;
mod folder;
mod lock;

pub use file::{probe_file, write, write_all};
pub(crate) use folder::{Build, probe};
pub use lock::{Lock, lock};
