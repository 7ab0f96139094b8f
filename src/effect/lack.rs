//! What keeps a machine from having an effect.

/// What a machine lacks to have an effect at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lack {
    /// The part that the effect changes is not there.
    NothingToChange,
    /// The base yields, and no plant has a base that does beside a rotor's inertia.
    RotorTurns,
    /// The effect acts between motor and load, and no signal sees the load.
    LoadUnseen,
    /// A gain of the controller is changed, and none is stated.
    Controller,
    /// The stated control law does not have the gain.
    Gain,
}

impl Lack {
    /// Whether a description of the machine refuses the effect: it would do nothing.
    pub fn is_refused(self) -> bool {
        matches!(self, Self::NothingToChange | Self::RotorTurns)
    }

    /// A sentence that says what to state or log.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::NothingToChange => {
                "The machine, as its file states it, has nothing that this effect could change."
            }
            Self::RotorTurns => {
                "The plant has no mode beside the inertia of a rotor, which the machine file states."
            }
            Self::LoadUnseen => {
                "Nothing sees the load's end of the drive train: log load_position_m or load_position_rad and state [load_sensor]."
            }
            Self::Controller => "The machine file states no controller.",
            Self::Gain => "The stated control law has no such gain.",
        }
    }
}
