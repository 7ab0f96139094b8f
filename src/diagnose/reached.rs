//! How far a search came.

use super::found::Found;

/// How far a search came.
pub enum Reached {
    /// Its end.
    End(Found),
    /// The first effect that leaves little of the gap, whose twin has other noise floors: by these it is judged what else acts.
    OtherFloors(Found),
}

impl Reached {
    /// What was found so far.
    pub fn found(self) -> Found {
        match self {
            Self::End(found) | Self::OtherFloors(found) => found,
        }
    }
}
