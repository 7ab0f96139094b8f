//! Size of a hidden effect: what is asked of the diagnosis for it, and the bands that results are listed by.

use serde::Serialize;

/// Least gap that shows, in standard deviations of the noise.
pub const FLOOR: f64 = 1.0;
/// Gap from which on an effect must be named, in standard deviations of the noise.
pub const MUST: f64 = 3.0;
/// Gap from which on an effect is large, in standard deviations of the noise.
pub const LARGE: f64 = 30.0;

/// What is asked for an effect of one size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Demand {
    /// 3 σ or more: not to name it is a mistake.
    Must,
    /// 1 to 3 σ: it may be named or not.
    May,
    /// Below 1 σ: nothing shows. To name it is not wrong and is not asked for.
    NeedNot,
}

impl Demand {
    /// What a gap, in standard deviations of the noise, asks for.
    ///
    /// ```
    /// use slideway::trial::scoring::size::Demand;
    /// assert_eq!([2.9, 3.0].map(Demand::of), [Demand::May, Demand::Must]);
    /// ```
    pub fn of(gap: f64) -> Self {
        if gap >= MUST {
            Self::Must
        } else if gap >= FLOOR {
            Self::May
        } else {
            Self::NeedNot
        }
    }
}

/// A band of gaps; the lower edge belongs to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Band {
    /// Below 1 σ.
    BelowFloor,
    /// 1 to 3 σ.
    From1To3,
    /// 3 to 30 σ.
    From3To30,
    /// 30 σ and more.
    Above30,
}

impl Band {
    /// Every band, smallest first.
    pub const ALL: [Self; 4] = [Self::BelowFloor, Self::From1To3, Self::From3To30, Self::Above30];

    /// The band of a gap in standard deviations of the noise.
    pub fn of(gap: f64) -> Self {
        match Demand::of(gap) {
            Demand::NeedNot => Self::BelowFloor,
            Demand::May => Self::From1To3,
            Demand::Must if gap < LARGE => Self::From3To30,
            Demand::Must => Self::Above30,
        }
    }

    /// The words of a table.
    pub fn name(self) -> &'static str {
        match self {
            Self::BelowFloor => "below floor",
            Self::From1To3 => "1–3 σ",
            Self::From3To30 => "3–30 σ",
            Self::Above30 => "above 30 σ",
        }
    }
}
