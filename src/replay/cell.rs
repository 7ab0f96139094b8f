//! A cell of a test plan: a stroke at a feed, as operators write it.

use std::fmt;
use std::str::FromStr;

use super::Stroke;
use crate::error::{Error, ErrorKind, Result};
use crate::recording::Run;
use crate::units::Motion;

/// A stroke at a feed, written `STROKE@FEED`: m and m/min on a sliding axis, rad and rad/s on a turning one.
///
/// ```
/// use slideway::{replay::Cell, units::Motion};
/// let cell: Cell = "0.02@8".parse()?;
/// assert_eq!(cell.name(Motion::Prismatic), "stroke020_feed08");
/// assert!("0.02".parse::<Cell>().is_err());
/// # Ok::<(), slideway::error::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    stroke: f64,
    feed: f64,
}

impl FromStr for Cell {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let numbers = text.split_once('@').and_then(|(stroke, feed)| {
            Some((stroke.trim().parse::<f64>().ok()?, feed.trim().parse::<f64>().ok()?))
        });
        let Some((stroke, feed)) = numbers else {
            return Err(Error::new(ErrorKind::Syntax)
                .key("cell")
                .found(format!("`{text}`"))
                .expected("STROKE@FEED, two numbers")
                .remedy("write for instance 0.02@8 for 20 mm at 8 m/min (a turning axis: rad@rad/s)"));
        };
        Self::new(stroke, feed)
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}@{}", self.stroke, self.feed)
    }
}

impl Cell {
    /// A stroke at a feed, in the units in which cells are written.
    ///
    /// # Errors
    /// A stroke of zero, a feed of zero or less, or anything not finite.
    pub fn new(stroke: f64, feed: f64) -> Result<Self> {
        Stroke::new(stroke, feed)?;
        Ok(Self { stroke, feed })
    }

    /// The stroke in SI.
    ///
    /// # Errors
    /// None in practice: the numbers were checked when the cell was read.
    pub fn stroke(self, motion: Motion) -> Result<Stroke> {
        match motion {
            Motion::Prismatic => Stroke::metres_at_metres_per_minute(self.stroke, self.feed),
            Motion::Revolute => Stroke::new(self.stroke, self.feed),
        }
    }

    /// A name for its run: stroke in mm (or rad) and feed in m/min (or rad/s), filled up with zeros so that
    /// names sort by size.
    pub fn name(self, motion: Motion) -> String {
        let stroke = match motion {
            Motion::Prismatic => 1000.0 * self.stroke,
            Motion::Revolute => self.stroke,
        };
        format!("stroke{}_feed{}", filled(stroke, 3), filled(self.feed, 2))
    }

    /// What a recording keeps of it: `stroke_m` and `feed_m_per_min`, or `stroke_rad` and `feed_rad_per_s`.
    pub fn metadata(self, motion: Motion) -> toml::Table {
        keys(motion).into_iter().map(str::to_owned).zip([self.stroke.into(), self.feed.into()]).collect()
    }

    /// The cell that a recorded run states under the keys of [`metadata`](Self::metadata); none where it states neither.
    ///
    /// # Errors
    /// One of the two keys without the other, anything but a number, a stroke of zero, a feed of zero or less.
    pub fn of_run(run: &Run) -> Result<Option<Self>> {
        let keys = keys(run.motion());
        let refuse = |kind, key: &str, found: String, expected: &str| {
            let error = Error::new(kind).key(format!("{}.{key}", run.name())).found(found).expected(expected);
            let error = error.remedy(format!("state both {} and {} in its [[run]]", keys[0], keys[1]));
            if run.file.as_os_str().is_empty() { error } else { error.file(&run.file) }
        };
        let number = |key: &str| match run.metadata.get(key) {
            None => Ok(None),
            Some(value) => match value.as_float().or_else(|| value.as_integer().map(|n| n as f64)) {
                Some(number) => Ok(Some(number)),
                None => Err(refuse(ErrorKind::Syntax, key, format!("`{value}`"), "a number")),
            },
        };
        match (number(keys[0])?, number(keys[1])?) {
            (None, None) => Ok(None),
            (Some(stroke), Some(feed)) => Self::new(stroke, feed).map(Some).map_err(|_| {
                let found = format!("a stroke of {stroke} at a feed of {feed}");
                refuse(
                    ErrorKind::OutOfRange,
                    keys[0],
                    found,
                    "a stroke that is not zero at a feed above zero",
                )
            }),
            (Some(_), None) => {
                Err(refuse(ErrorKind::Missing, keys[1], "a stroke without its feed".to_owned(), "both"))
            }
            (None, Some(_)) => {
                Err(refuse(ErrorKind::Missing, keys[0], "a feed without its stroke".to_owned(), "both"))
            }
        }
    }
}

/// Keys of stroke and feed in a recording.
const fn keys(motion: Motion) -> [&'static str; 2] {
    match motion {
        Motion::Prismatic => ["stroke_m", "feed_m_per_min"],
        Motion::Revolute => ["stroke_rad", "feed_rad_per_s"],
    }
}

/// To a millionth, without trailing zeros, the whole part filled up to `width` digits.
fn filled(value: f64, width: usize) -> String {
    let text = format!("{:.6}", value.abs());
    let text = text.trim_end_matches('0').trim_end_matches('.');
    let whole = text.split('.').next().map_or(0, str::len);
    let sign = if value < 0.0 { "-" } else { "" };
    format!("{sign}{}{text}", "0".repeat(width.saturating_sub(whole)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_names_sort_by_size_and_keep_decimals() {
        let name = |text: &str| text.parse::<Cell>().unwrap().name(Motion::Prismatic);
        assert_eq!(name("0.0205@8.5"), "stroke020.5_feed08.5");
        assert_eq!(name("-0.3@16"), "stroke-300_feed16");
        assert!(name("0.02@8") < name("0.1@8"));
    }

    #[test]
    fn exact_cell_that_is_none_is_refused() {
        for text in ["", "0.02", "0.02@", "a@b", "0@8", "0.02@0", "0.02@-8", "nan@8", "0.02@inf"] {
            let error = text.parse::<Cell>().unwrap_err();
            assert!(error.remedy_text().is_some(), "{text}: {error}");
        }
    }
}
