//! Where between two signals an effect acts, and what follows of that for a recording.

/// The stretch of the signal path, between signals that a log may hold, in which an effect acts.
///
/// # Design
/// An effect's [`Site`](super::Site) is the part in which it sits; its stretch is where it comes between measured signals. They
/// differ: cogging sits in the motor and adds to a force that is measured before it; the velocity estimate is a sensor's, and what
/// it does is measured as effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stretch {
    /// From reference, reading and velocity estimate to effort: the control law. It shows where the loop is replayed.
    Controller,
    /// From reading to velocity estimate. It shows where the loop is replayed, and in a logged velocity.
    VelocityEstimate,
    /// From effort to current: amplifier and circuit.
    Drive,
    /// From current to motor force: force constant, its ripple and saturation.
    MotorForce,
    /// From motor force to reading: forces on the moving part, structure, drive train, measure of the encoder.
    Mechanics,
    /// From motor force to reading as well, but on the reading's last digits: by them alone it moves nothing, and shows where the
    /// loop is replayed.
    Rounding,
    /// Beside the path: in what the log says of several of its signals. No stretch that is clean rules it out.
    Log,
}
