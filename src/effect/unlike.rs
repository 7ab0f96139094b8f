//! What machines of blind trials do otherwise than a law.

/// What a machine of a blind trial does otherwise than the law, which the diagnosis would meet again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unlike {
    /// Nothing: the machine has the effect by its law.
    Nothing,
    /// Dry friction by bristles of another kind.
    Bristles,
    /// More harmonics of a force along the axis, from period and amplitude of the first.
    ForceHarmonics {
        /// Period in m or rad.
        period: f64,
        /// Amplitude of the first harmonic in N or N·m.
        first: f64,
    },
    /// More harmonics of the motor's relative force along the axis, from period and amplitude of the first.
    RippleHarmonics {
        /// Period in m or rad.
        period: f64,
        /// Amplitude of the first harmonic.
        first: f64,
    },
}
