//! What drives one step of a plant.

/// What drives the coming step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    /// Voltage at the motor: `earlier_v` for the share `switch` of the step, `now_v` after it.
    Voltage {
        /// V, until the switch.
        earlier_v: f64,
        /// V, from the switch on.
        now_v: f64,
        /// Share of the step before the switch: 0 (`now_v` all along) to 1 (`earlier_v` all along).
        switch: f64,
    },
    /// Force or torque in the motor's place, N or N·m, held over the step; the winding takes no part.
    Force(f64),
}

impl Drive {
    /// One voltage over the whole step.
    pub const fn voltage(voltage_v: f64) -> Self {
        Self::Voltage { earlier_v: voltage_v, now_v: voltage_v, switch: 0.0 }
    }
}
