//! An oscillation of the assembled system.

/// An oscillation of the assembled system: moving part, drag and base together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// Undamped natural frequency |λ|/2π, in Hz.
    pub frequency_hz: f64,
    /// Damping ratio −Re λ/|λ|.
    pub damping_ratio: f64,
}
