//! Whether a machine's closed loop is stable, said before anything that was simulated with it.

use slideway::machine::Machine;
use slideway::twin::LinearLoop;

/// A sentence where the loop is not stable, with a line to itself; nothing where it is, or where no law is stated.
pub(super) fn stability(machine: &Machine) -> String {
    LinearLoop::warning(machine).map_or(String::new(), |warning| format!("! {warning}\n\n"))
}
