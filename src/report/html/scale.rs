//! Units of the screen, mm and µm, m/min, N, Hz, and the values that an axis has to hold.

use crate::recording::Signal;
use crate::report::number::engineering_unit;
use crate::units::{Dimension, Motion};

/// A unit of the screen: what an SI value is multiplied by, and its symbol.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    pub(super) factor: f64,
    pub(super) unit: String,
}

impl Scale {
    /// The unit in which the largest of some values is a handy number.
    pub(super) fn of<'a>(si_unit: &str, values: impl IntoIterator<Item = &'a f64>) -> Self {
        let finite = values.into_iter().filter(|v| v.is_finite());
        let largest = finite.fold(0.0, |most: f64, v| most.max(v.abs()));
        let (size, unit) = engineering_unit(largest, si_unit);
        Self { factor: 1.0 / size, unit }
    }

    /// The unit of a signal's values: feeds are in m/min as operators state them, positions in mm.
    pub(super) fn signal<'a>(
        signal: Signal,
        motion: Motion,
        values: impl IntoIterator<Item = &'a f64>,
    ) -> Self {
        match signal.dimension(motion) {
            Dimension::Velocity => Self::feed(),
            Dimension::Length => Self::length(),
            _ => Self::of(signal.si_unit(motion), values),
        }
    }

    /// m/min.
    pub(super) fn feed() -> Self {
        Self { factor: 60.0, unit: "m/min".to_owned() }
    }

    /// mm.
    pub(super) fn length() -> Self {
        Self { factor: 1000.0, unit: "mm".to_owned() }
    }

    /// Position along the axis.
    pub(super) fn position<'a>(motion: Motion, values: impl IntoIterator<Item = &'a f64>) -> Self {
        match motion {
            Motion::Prismatic => Self::length(),
            Motion::Revolute => Self::of("rad", values),
        }
    }

    /// Speed of the axis.
    pub(super) fn speed<'a>(motion: Motion, values: impl IntoIterator<Item = &'a f64>) -> Self {
        match motion {
            Motion::Prismatic => Self::feed(),
            Motion::Revolute => Self::of("rad/s", values),
        }
    }

    /// Force or torque of the axis.
    pub(super) fn force<'a>(motion: Motion, values: impl IntoIterator<Item = &'a f64>) -> Self {
        Self::of(if motion == Motion::Prismatic { "N" } else { "N·m" }, values)
    }

    /// A value in this unit.
    pub(super) fn to(&self, si: f64) -> f64 {
        self.factor * si
    }

    /// "position in mm".
    pub(super) fn label(&self, word: &str) -> String {
        if self.unit.is_empty() { word.to_owned() } else { format!("{word} in {}", self.unit) }
    }
}

/// What the axis' speed is called: feed, or speed of turning.
pub(super) fn speed_word(motion: Motion) -> &'static str {
    if motion == Motion::Prismatic { "speed" } else { "speed of rotation" }
}

/// Force or torque.
pub(super) fn force_word(motion: Motion) -> &'static str {
    if motion == Motion::Prismatic { "force" } else { "torque" }
}

/// Values without the outermost half per cent on either side: one spike does not decide the axis.
pub(super) fn robust(mut values: Vec<f64>) -> Vec<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let cut = values.len() / 200;
    let end = values.len() - cut;
    values.drain(cut..end).collect()
}

/// The same for a quantity whose zero tells.
pub(super) fn with_zero(values: Vec<f64>) -> Vec<f64> {
    robust(values).into_iter().chain([0.0]).collect()
}
