//! How a report on a terminal is set: colour and width.

/// Tables need this width.
pub(super) const NARROWEST: usize = 80;

/// How a report is set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// Whether colours may be used.
    pub colour: bool,
    /// Columns of a line; taken as 80 where less.
    pub width: usize,
}

impl Default for Style {
    /// Without colour, 80 columns.
    fn default() -> Self {
        Self { colour: false, width: NARROWEST }
    }
}
