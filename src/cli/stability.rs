//! Whether a machine's closed loop is stable, said before anything that was simulated with it.

use slideway::machine::Machine;
use slideway::twin::LinearLoop;

/// Modes of a base up to which the loop is looked at: the effort grows with the third power of their number.
const MOST_MODES: usize = 32;

/// A sentence where the loop is not stable, with a line to itself; nothing where it is, or where no law is stated.
pub(super) fn stability(machine: &Machine) -> String {
    if machine.constants().modes.as_slice().len() > MOST_MODES {
        return String::new();
    }
    match LinearLoop::of(machine) {
        Ok(looped) if !looped.is_stable() => format!(
            "! The closed loop of {} is not stable, or does not hold a position: look at its gains, delays and signs.\n\n",
            machine.description().name
        ),
        _ => String::new(),
    }
}
