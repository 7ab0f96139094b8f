//! The closed list of signals that an axis can log, with their canonical names.

use std::fmt;

use crate::units::{Dimension, Motion};

/// The canonical name of the time column, in s.
pub const TIME_KEY: &str = "time_s";

/// A signal of the axis, ordered along the signal path: command, controller, amplifier, motor, sensor.
///
/// Positive values act or count along positive position, throughout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Signal {
    /// The position that the axis was told to have at this sample.
    PositionReference,
    /// The velocity that the axis was told to have at this sample.
    VelocityReference,
    /// 1 while the drive is enabled, 0 while its bridge is open and the motor exerts nothing.
    TorqueEnabled,
    /// Voltage injected between controller and amplifier, as an experimenter's disturbance.
    DisturbanceVoltage,
    /// The command given to the amplifier, in V, **with an injected disturbance voltage included**:
    /// that is what logs show. What the controller alone asked for is this less [`Signal::DisturbanceVoltage`].
    ControlEffort,
    /// Supply voltage of an amplifier that is commanded by a duty cycle.
    SupplyVoltage,
    /// Current of the motor; for a synchronous motor the force-producing (quadrature) one.
    Current,
    /// Force (N) or torque (N·m) of the motor on the moving part, before friction.
    Thrust,
    /// Force or torque injected at the moving part from outside.
    DisturbanceForce,
    /// What the axis' own sensor (the motor encoder) reads, expressed as the axis coordinate.
    Position,
    /// Velocity as measured by, or derived in the drive from, the axis' own sensor.
    Velocity,
    /// What a second sensor at the load (a linear scale, say) reads.
    LoadPosition,
}

/// Key, unit and word of a signal: `(prismatic key, revolute key, prismatic, revolute, word)`.
type Row = (&'static str, &'static str, Dimension, Dimension, &'static str);

impl Signal {
    /// Every signal, in signal-path order.
    pub const ALL: [Self; 12] = [
        Self::PositionReference,
        Self::VelocityReference,
        Self::TorqueEnabled,
        Self::DisturbanceVoltage,
        Self::ControlEffort,
        Self::SupplyVoltage,
        Self::Current,
        Self::Thrust,
        Self::DisturbanceForce,
        Self::Position,
        Self::Velocity,
        Self::LoadPosition,
    ];

    const fn row(self) -> Row {
        use Dimension::{Angle, AngularVelocity, Current, Force, Length, Ratio, Torque, Velocity, Voltage};
        match self {
            Self::PositionReference => {
                ("position_reference_m", "position_reference_rad", Length, Angle, "position reference")
            }
            Self::VelocityReference => (
                "velocity_reference_m_per_s",
                "velocity_reference_rad_per_s",
                Velocity,
                AngularVelocity,
                "velocity reference",
            ),
            Self::TorqueEnabled => ("torque_enabled", "torque_enabled", Ratio, Ratio, "torque enable"),
            Self::SupplyVoltage => {
                ("supply_voltage_v", "supply_voltage_v", Voltage, Voltage, "supply voltage")
            }
            Self::DisturbanceVoltage => {
                ("disturbance_v", "disturbance_v", Voltage, Voltage, "disturbance voltage")
            }
            Self::ControlEffort => {
                ("control_effort_v", "control_effort_v", Voltage, Voltage, "control effort")
            }
            Self::Current => ("current_a", "current_a", Current, Current, "current"),
            Self::Thrust => ("thrust_n", "torque_nm", Force, Torque, "thrust"),
            Self::DisturbanceForce => ("disturbance_n", "disturbance_nm", Force, Torque, "disturbance force"),
            Self::Position => ("position_m", "position_rad", Length, Angle, "position"),
            Self::Velocity => {
                ("velocity_m_per_s", "velocity_rad_per_s", Velocity, AngularVelocity, "velocity")
            }
            Self::LoadPosition => ("load_position_m", "load_position_rad", Length, Angle, "load position"),
        }
    }

    /// The canonical column name, with the unit in it.
    ///
    /// ```
    /// use slideway::{recording::Signal, units::Motion};
    /// assert_eq!(Signal::Thrust.key(Motion::Prismatic), "thrust_n");
    /// assert_eq!(Signal::Thrust.key(Motion::Revolute), "torque_nm");
    /// ```
    pub const fn key(self, motion: Motion) -> &'static str {
        let row = self.row();
        match motion {
            Motion::Prismatic => row.0,
            Motion::Revolute => row.1,
        }
    }

    /// What the signal measures.
    pub const fn dimension(self, motion: Motion) -> Dimension {
        let row = self.row();
        match motion {
            Motion::Prismatic => row.2,
            Motion::Revolute => row.3,
        }
    }

    /// What it is, in a sentence or two; positive values act or count along positive position.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::PositionReference => "The position that the axis was told to have at this sample.",
            Self::VelocityReference => "The velocity that the axis was told to have at this sample.",
            Self::TorqueEnabled => {
                "1 while the drive is enabled, 0 while its bridge is open and the motor exerts nothing."
            }
            Self::DisturbanceVoltage => {
                "Voltage injected between controller and amplifier, as an experimenter's disturbance."
            }
            Self::ControlEffort => {
                "The command given to the amplifier, with an injected disturbance voltage included."
            }
            Self::SupplyVoltage => "Supply voltage of an amplifier that is commanded by a duty cycle.",
            Self::Current => {
                "Current of the motor; for a synchronous motor the force-producing (quadrature) one."
            }
            Self::Thrust => "Force or torque of the motor on the moving part, before friction.",
            Self::DisturbanceForce => "Force or torque injected at the moving part from outside.",
            Self::Position => "What the axis' own sensor reads, expressed as the axis coordinate.",
            Self::Velocity => "Velocity as measured by, or derived in the drive from, the axis' own sensor.",
            Self::LoadPosition => "What a second sensor at the load (a linear scale, say) reads.",
        }
    }

    /// The SI unit in which it is kept.
    pub fn si_unit(self, motion: Motion) -> &'static str {
        self.dimension(motion).si_symbol()
    }

    /// The word for it in reports; a thrust of a revolute axis is a torque.
    pub const fn word(self, motion: Motion) -> &'static str {
        match (self, motion) {
            (Self::Thrust, Motion::Revolute) => "torque",
            (Self::DisturbanceForce, Motion::Revolute) => "disturbance torque",
            _ => self.row().4,
        }
    }

    /// Whether it tells what the machine did, rather than what it was told or disturbed with.
    pub const fn is_measured(self) -> bool {
        matches!(
            self,
            Self::ControlEffort
                | Self::Current
                | Self::Thrust
                | Self::Position
                | Self::Velocity
                | Self::LoadPosition
        )
    }

    /// The signal of a canonical name, and the motion that the name implies, where it implies one.
    pub fn from_key(key: &str) -> Option<(Self, Option<Motion>)> {
        Self::ALL.into_iter().find_map(|signal| {
            match (key == signal.key(Motion::Prismatic), key == signal.key(Motion::Revolute)) {
                (true, true) => Some((signal, None)),
                (true, false) => Some((signal, Some(Motion::Prismatic))),
                (false, true) => Some((signal, Some(Motion::Revolute))),
                (false, false) => None,
            }
        })
    }

    /// Every canonical column name of one motion, or of both.
    pub fn keys(motion: Option<Motion>) -> Vec<&'static str> {
        let motions = match motion {
            Some(motion) => vec![motion],
            None => vec![Motion::Prismatic, Motion::Revolute],
        };
        let mut keys = vec![TIME_KEY];
        for signal in Self::ALL {
            for &motion in &motions {
                if !keys.contains(&signal.key(motion)) {
                    keys.push(signal.key(motion));
                }
            }
        }
        keys
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.row().4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_keys_lead_back_to_their_signal() {
        for signal in Signal::ALL {
            for motion in [Motion::Prismatic, Motion::Revolute] {
                let (found, implied) = Signal::from_key(signal.key(motion)).unwrap();
                assert_eq!(found, signal);
                assert!(implied.is_none_or(|implied| implied == motion));
            }
        }
        assert_eq!(Signal::from_key("position"), None);
    }

    #[test]
    fn exact_order_is_the_order_of_the_list() {
        assert!(Signal::ALL.is_sorted());
    }
}
