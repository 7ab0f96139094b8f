//! What keeps a machine from having an effect.

/// What a machine lacks to have an effect at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lack {
    /// The part that the effect changes is not there.
    NothingToChange,
    /// The effect acts between motor and load, and no signal sees the load.
    LoadUnseen,
    /// A gain of the controller is changed, and none is stated.
    Controller,
    /// The stated control law does not have the gain.
    Gain,
}

impl Lack {
    /// A sentence that says what to state or log.
    pub fn sentence(self) -> &'static str {
        match self {
            Self::NothingToChange => {
                "The machine, as its file states it, has nothing that this effect could change."
            }
            Self::LoadUnseen => {
                "Nothing sees the load's end of the drive train: log load_position_m or load_position_rad and state [load_sensor]."
            }
            Self::Controller => "The machine file states no controller.",
            Self::Gain => "The stated control law has no such gain.",
        }
    }
}
