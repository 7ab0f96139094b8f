//! What can be asked of a controller's setting, in the field's terms, and what bounds on it are called in a machine file.

use crate::error::{Error, ErrorKind, Result};
use crate::units::Motion;

/// A figure of merit; the first seven of a stroke, the last three of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Criterion {
    /// Position beyond the end of the stroke, as a share of the stroke.
    PositionOvershoot,
    /// Velocity beyond the feed, as a share of the feed.
    VelocityOvershoot,
    /// Velocity against the stroke's direction, as a share of the feed.
    ReverseVelocity,
    /// Time from the end of the reference's motion until position stays within 2 % of the stroke, s.
    SettlingTime,
    /// Largest distance between reference and position, m or rad.
    FollowingError,
    /// Largest thrust, N or N·m.
    PeakThrust,
    /// Largest effort, V.
    PeakEffort,
    /// Upward gain margin, dB.
    GainMargin,
    /// Phase margin, degrees.
    PhaseMargin,
    /// Least distance of the open loop's response from −1.
    ModulusMargin,
}

impl Criterion {
    /// Every criterion.
    pub const ALL: [Self; 10] = [
        Self::PositionOvershoot,
        Self::VelocityOvershoot,
        Self::ReverseVelocity,
        Self::SettlingTime,
        Self::FollowingError,
        Self::PeakThrust,
        Self::PeakEffort,
        Self::GainMargin,
        Self::PhaseMargin,
        Self::ModulusMargin,
    ];

    /// Those of a stroke come first; so many they are.
    pub const OF_STROKE: usize = 7;

    /// Its word.
    pub fn name(self) -> &'static str {
        match self {
            Self::PositionOvershoot => "position overshoot",
            Self::VelocityOvershoot => "velocity overshoot",
            Self::ReverseVelocity => "reverse velocity",
            Self::SettlingTime => "settling time",
            Self::FollowingError => "following error",
            Self::PeakThrust => "peak thrust",
            Self::PeakEffort => "peak effort",
            Self::GainMargin => "gain margin",
            Self::PhaseMargin => "phase margin",
            Self::ModulusMargin => "modulus margin",
        }
    }

    /// Its key in `[tune.limits]` and after `--limit`, with the unit.
    pub fn key(self, motion: Motion) -> &'static str {
        match (self, motion) {
            (Self::PositionOvershoot, _) => "position_overshoot_percent",
            (Self::VelocityOvershoot, _) => "velocity_overshoot_percent",
            (Self::ReverseVelocity, _) => "reverse_velocity_percent",
            (Self::SettlingTime, _) => "settling_time_s",
            (Self::FollowingError, Motion::Prismatic) => "following_error_m",
            (Self::FollowingError, Motion::Revolute) => "following_error_rad",
            (Self::PeakThrust, Motion::Prismatic) => "peak_thrust_n",
            (Self::PeakThrust, Motion::Revolute) => "peak_torque_nm",
            (Self::PeakEffort, _) => "peak_effort_v",
            (Self::GainMargin, _) => "gain_margin_db",
            (Self::PhaseMargin, _) => "phase_margin_deg",
            (Self::ModulusMargin, _) => "modulus_margin",
        }
    }

    /// What one unit of its key is in the unit of its value.
    pub fn per_key(self) -> f64 {
        match self {
            Self::PositionOvershoot | Self::VelocityOvershoot | Self::ReverseVelocity => 0.01,
            _ => 1.0,
        }
    }

    /// Whether more of it is better.
    pub fn is_margin(self) -> bool {
        self as usize >= Self::OF_STROKE
    }

    /// The criterion with this key, where it may have this bound, in the key's unit.
    ///
    /// # Errors
    /// A key that is none of this kind of axis, or a bound that is not finite and zero or more.
    pub fn bounded(motion: Motion, key: &str, bound: f64) -> Result<Self> {
        let keys = || Self::ALL.map(|criterion| criterion.key(motion)).join(", ");
        let Some(criterion) = Self::ALL.into_iter().find(|criterion| criterion.key(motion) == key) else {
            return Err(Error::new(ErrorKind::UnknownKey)
                .key(key)
                .found("a name that is no criterion")
                .expected(format!("one of {}", keys()))
                .remedy("the unit stands in the name: position_overshoot_percent=0.5"));
        };
        if !(bound.is_finite() && bound >= 0.0) {
            return Err(Error::new(ErrorKind::OutOfRange)
                .key(key)
                .found(bound.to_string())
                .expected("a finite number of zero or more")
                .remedy("write for instance position_overshoot_percent=0.5"));
        }
        Ok(criterion)
    }
}
