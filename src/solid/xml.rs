//! A URDF looked through before it is read: well-formed, of bounded size and depth, its numbers numbers.
//!
//! What `urdf_rs` says of a fault names neither line nor link, and deep nesting overflows its stack.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::error::toml_text::line_of;
use crate::error::{Error, ErrorKind, Result};

/// Elements inside one another; a URDF needs five.
const DEEPEST: usize = 32;
/// Elements in all: a hundred for each of the links of a large robot.
const MOST_ELEMENTS: usize = 200_000;
/// Attributes that hold numbers, and how many.
const NUMBERS: [(&str, usize); 22] = [
    ("xyz", 3),
    ("rpy", 3),
    ("scale", 3),
    ("value", 1),
    ("ixx", 1),
    ("ixy", 1),
    ("ixz", 1),
    ("iyy", 1),
    ("iyz", 1),
    ("izz", 1),
    ("radius", 1),
    ("length", 1),
    ("lower", 1),
    ("upper", 1),
    ("effort", 1),
    ("velocity", 1),
    ("damping", 1),
    ("friction", 1),
    ("multiplier", 1),
    ("offset", 1),
    ("rising", 1),
    ("falling", 1),
];
/// Kinds of joints that the format has.
const JOINTS: [&str; 7] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical"];
/// Elements whose numbers are read.
const READ: [&str; 13] = [
    "origin",
    "mass",
    "inertia",
    "axis",
    "limit",
    "dynamics",
    "mesh",
    "box",
    "cylinder",
    "sphere",
    "capsule",
    "mimic",
    "calibration",
];

/// Looks a URDF through.
///
/// # Errors
/// Each with its line, and the link or joint it is in: what is no XML, or no URDF, or larger or deeper than any; entities; a
/// joint that follows another one; text where a number belongs.
pub(super) fn check(text: &str) -> Result<()> {
    let mut reader = Reader::from_str(text);
    reader.config_mut().check_end_names = true;
    let mut walk = Walk { text, open: Vec::new(), part: String::new(), elements: 0 };
    loop {
        let start = reader.buffer_position();
        let event = reader.read_event();
        let at = usize::try_from(start).unwrap_or(0);
        match event {
            Err(error) => {
                let at = usize::try_from(reader.error_position()).unwrap_or(0);
                return Err(walk.refuse(at, ErrorKind::Syntax).found(format!("what is no XML ({error})")).expected(URDF).remedy(
                    "correct that line, or export the URDF again; a URDF of ROS must be expanded with xacro first",
                ));
            }
            Ok(Event::Eof) => return walk.end(),
            Ok(Event::DocType(_)) => {
                return Err(walk
                    .refuse(at, ErrorKind::Syntax)
                    .found("a <!DOCTYPE>")
                    .expected("a URDF without entities of its own")
                    .remedy("take the <!DOCTYPE> out, and write what its entities stand for"));
            }
            Ok(Event::Start(element)) => {
                walk.element(at, &element)?;
                walk.open.push(element.name().as_ref().to_vec());
            }
            Ok(Event::Empty(element)) => walk.element(at, &element)?,
            Ok(Event::End(_)) => drop(walk.open.pop()),
            Ok(_) => {}
        }
    }
}

const URDF: &str = "a URDF: a <robot> of links and joints";

struct Walk<'a> {
    text: &'a str,
    open: Vec<Vec<u8>>,
    /// The link or joint under way.
    part: String,
    elements: usize,
}

impl Walk<'_> {
    fn refuse(&self, at: usize, kind: ErrorKind) -> Error {
        // A position before an element may stand at the end of the line before.
        let blank = self
            .text
            .as_bytes()
            .get(at..)
            .unwrap_or_default()
            .iter()
            .take_while(|b| b.is_ascii_whitespace())
            .count();
        let error = Error::new(kind).row(line_of(self.text, at + blank));
        if self.part.is_empty() { error } else { error.key(self.part.clone()) }
    }

    fn end(&self) -> Result<()> {
        let last = self.text.len().saturating_sub(1);
        if let Some(open) = self.open.last() {
            return Err(self
                .refuse(last, ErrorKind::Syntax)
                .found(format!("the end of the file inside <{}>", String::from_utf8_lossy(open)))
                .expected(URDF)
                .remedy("the file was cut off: export or copy it again"));
        }
        if self.elements == 0 {
            let found = if self.text.trim().is_empty() { "an empty file" } else { "a text without elements" };
            return Err(Error::new(ErrorKind::Syntax)
                .row(1)
                .found(found)
                .expected(URDF)
                .remedy("name the URDF of the machine"));
        }
        Ok(())
    }

    fn element(&mut self, at: usize, element: &BytesStart<'_>) -> Result<()> {
        let name = String::from_utf8_lossy(element.name().as_ref()).into_owned();
        self.elements += 1;
        if self.elements > MOST_ELEMENTS || self.open.len() >= DEEPEST {
            return Err(self
                .refuse(at, ErrorKind::OutOfRange)
                .found(format!("{} elements, {} inside one another", self.elements, self.open.len() + 1))
                .expected(format!("at most {MOST_ELEMENTS}, {DEEPEST} inside one another"))
                .remedy("leave out what does not describe this axis"));
        }
        if self.open.is_empty() && name != "robot" {
            return Err(self
                .refuse(at, ErrorKind::Syntax)
                .found(format!("the element <{name}> at the root"))
                .expected(URDF)
                .remedy(if name == "sdf" {
                    "convert the SDF to a URDF"
                } else {
                    "name the URDF of the machine"
                }));
        }
        if self.open.len() == 1 {
            self.part = String::new();
        }
        for attribute in element.attributes() {
            let attribute = attribute.map_err(|error| {
                let error = self
                    .refuse(at, ErrorKind::Syntax)
                    .found(format!("<{name}> with an attribute that is none ({error})"));
                error.expected("attributes such as name=\"…\", each once").remedy("correct that line")
            })?;
            let key = String::from_utf8_lossy(attribute.key.as_ref()).into_owned();
            let value = attribute.unescape_value().map_err(|error| {
                let error =
                    self.refuse(at, ErrorKind::Syntax).found(format!("{key}=\"…\" with an entity ({error})"));
                error.expected("plain text").remedy("write what the entity stands for")
            })?;
            self.attribute(at, &name, &key, &value)?;
        }
        if name == "mimic" && self.is_joint() {
            return Err(self
                .refuse(at, ErrorKind::Inconsistent)
                .found("a joint that follows another one, <mimic>")
                .expected("joints that move by themselves or not at all")
                .remedy("make the joint fixed, or take <mimic> out: the twin moves one joint"));
        }
        Ok(())
    }

    fn is_joint(&self) -> bool {
        self.open.len() == 2 && self.open.last().is_some_and(|name| name == b"joint")
    }

    fn attribute(&mut self, at: usize, element: &str, key: &str, value: &str) -> Result<()> {
        if self.open.len() == 1 && key == "name" {
            self.part = value.to_owned();
        }
        if element == "joint" && self.open.len() == 1 && key == "type" && !JOINTS.contains(&value) {
            return Err(self
                .refuse(at, ErrorKind::UnknownKey)
                .found(format!("a joint of type \"{value}\""))
                .expected(format!("one of {}", JOINTS.join(", ")))
                .remedy("correct the type of the joint"));
        }
        let expected = match (element, key) {
            ("box", "size") => 3,
            (element, key) if READ.contains(&element) => {
                NUMBERS.iter().find(|(name, _)| *name == key).map_or(0, |(_, count)| *count)
            }
            _ => 0,
        };
        if expected == 0 {
            return Ok(());
        }
        let parts: Vec<&str> = value.split_whitespace().collect();
        if parts.len() == expected && parts.iter().all(|part| part.parse::<f64>().is_ok()) {
            return Ok(());
        }
        let comma = value.contains(',');
        let numbers = if expected == 1 {
            "one number".to_owned()
        } else {
            format!("{expected} numbers, separated by blanks")
        };
        Err(self
            .refuse(at, ErrorKind::Syntax)
            .found(format!("{key}=\"{value}\" in <{element}>"))
            .expected(numbers)
            .remedy(if comma { "write numbers with a decimal point" } else { "correct that line" }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> Error {
        check(text).unwrap_err()
    }

    #[test]
    fn exact_faults_are_told_with_line_and_part() {
        let head = "<robot name=\"x\">\n<link name=\"a\"/>\n";
        let cases = [
            (
                format!("{head}<link name=\"b\"><inertial>\n<mass value=\"4,5\"/></inertial></link></robot>"),
                4,
                Some("b"),
                "4,5",
            ),
            (format!("{head}<joint name=\"j\" type=\"slippery\"/></robot>"), 3, Some("j"), "slippery"),
            (
                format!("{head}<joint name=\"j\" type=\"fixed\">\n<mimic joint=\"k\"/></joint></robot>"),
                4,
                Some("j"),
                "mimic",
            ),
            (
                format!("{head}<joint name=\"j\" type=\"fixed\"><axis xyz=\"1 0\"/></joint></robot>"),
                3,
                Some("j"),
                "1 0",
            ),
            (format!("{head}<link name=\"b\">"), 3, Some("b"), "end of the file"),
            ("<sdf/>".to_owned(), 1, None, "<sdf>"),
            ("<!DOCTYPE r []>\n<robot/>".to_owned(), 1, None, "DOCTYPE"),
            (String::new(), 1, None, "empty"),
            ("hello".to_owned(), 1, None, "without elements"),
        ];
        for (text, row, part, word) in cases {
            let error = refused(&text);
            assert_eq!((error.row_number(), error.key_name()), (Some(row), part), "{error}");
            assert!(error.to_string().contains(word), "{error}");
        }
    }

    #[test]
    fn exact_depth_and_size_are_bounded() {
        let deep = format!("<robot>{}", "<a>".repeat(100_000));
        assert_eq!(refused(&deep).kind(), ErrorKind::OutOfRange);
        let wide = format!("<robot>{}</robot>", "<a/>".repeat(MOST_ELEMENTS));
        assert_eq!(refused(&wide).kind(), ErrorKind::OutOfRange);
        assert!(check("<robot name=\"x\"><link name=\"a\"/></robot>").is_ok());
    }
}
