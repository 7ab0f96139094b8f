//! The machine's URDF as MuJoCo's importer gets it: a copy in memory; the file stays as it is.

use std::ops::Range;

use crate::error::{Error, ErrorKind, Result};
use crate::solid::Solid;

/// What MuJoCo makes of the links and their shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reading {
    /// Every link a body, every mesh read: what the file says.
    AsWritten,
    /// Links that move together made one body, shapes left out (nothing is ever in contact): what is stepped.
    Merged,
}

/// The text of the URDF with what MuJoCo has to be told beside it.
///
/// # Model
/// A `<mujoco><compiler/></mujoco>` element says where the meshes are and that inertia comes from `<inertial>` as it
/// stands, without a balance or a lower bound; one that the file has already is left out. Joints other than the driven
/// one are fixed, as in [`Solid`]. Mesh names that only ROS resolves (`package://`, `file://`) become paths.
pub(super) fn text_for(solid: &Solid, reading: Reading) -> Result<String> {
    let text = std::fs::read_to_string(&solid.path).map_err(|e| Error::io(&solid.path, &e))?;
    prepared(&text, solid, reading).map_err(|e| e.file(&solid.path))
}

fn prepared(text: &str, solid: &Solid, reading: Reading) -> Result<String> {
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    let mut foreign: Option<usize> = None;
    let mut has_root = false;
    for tag in tags(text) {
        let markup = &text[tag.clone()];
        let shifted = |range: Range<usize>| tag.start + range.start..tag.start + range.end;
        match element(markup) {
            "/mujoco" => {
                let begin = foreign.take().unwrap_or(tag.start);
                edits.push((begin..tag.end, String::new()));
            }
            "mujoco" if markup.ends_with("/>") => edits.push((tag, String::new())),
            "mujoco" => foreign = Some(tag.start),
            _ if foreign.is_some() => (),
            "robot" if !has_root => {
                has_root = true;
                edits.push((tag.end..tag.end, compiler(solid, reading)?));
            }
            "joint" => {
                let is_driven = attribute(markup, "name").is_some_and(|at| markup[at] == solid.joint.name);
                if let Some(at) = attribute(markup, "type").filter(|_| !is_driven) {
                    edits.push((shifted(at), "fixed".to_owned()));
                }
            }
            "mesh" => {
                let named = attribute(markup, "filename").map(|at| (markup[at.clone()].to_owned(), at));
                if let Some((name, at)) = named.filter(|(name, _)| name.contains("://")) {
                    let file = solid.mesh_file(&name)?;
                    let file = file.canonicalize().map_err(|e| Error::io(&file, &e))?;
                    edits.push((shifted(at), escaped(&file)?));
                }
            }
            _ => (),
        }
    }
    let mut edited = text.to_owned();
    for (range, by) in edits.into_iter().rev() {
        edited.replace_range(range, &by);
    }
    Ok(edited)
}

fn compiler(solid: &Solid, reading: Reading) -> Result<String> {
    let folder = solid.path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(std::path::Path::new("."));
    let meshes = escaped(&folder.canonicalize().map_err(|e| Error::io(folder, &e))?)?;
    let is_merged = reading == Reading::Merged;
    Ok(format!(
        "<mujoco><compiler meshdir=\"{meshes}\" strippath=\"false\" fusestatic=\"{is_merged}\" \
         discardvisual=\"{is_merged}\" inertiafromgeom=\"false\" balanceinertia=\"false\" boundmass=\"0\" \
         boundinertia=\"0\" usethread=\"false\"/></mujoco>"
    ))
}

/// A path as the value of an XML attribute.
fn escaped(path: &std::path::Path) -> Result<String> {
    let text = path.to_str().ok_or_else(|| {
        Error::new(ErrorKind::Syntax)
            .file(path)
            .found("a path that is not UTF-8")
            .expected("a path that can stand in a URDF")
            .remedy("move the machine folder")
    })?;
    Ok(text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;"))
}

/// Every tag outside comments, from `<` to `>`.
fn tags(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(begin) = text[at..].find('<').map(|k| at + k) {
        let rest = &text[begin..];
        at = begin
            + if rest.starts_with("<!--") {
                rest.find("-->").map_or(rest.len(), |k| k + "-->".len())
            } else {
                let length = tag_length(rest);
                found.push(begin..begin + length);
                length
            };
    }
    found
}

/// Length of the tag at the beginning of `text`; a `>` in a quoted value does not end it.
fn tag_length(text: &str) -> usize {
    let mut quote = None;
    for (k, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return k + 1,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => (),
        }
    }
    text.len()
}

/// Name of a tag's element; `/name` for a closing tag.
fn element(tag: &str) -> &str {
    let inside = tag.trim_start_matches('<');
    let end = inside.char_indices().skip(1).find(|(_, c)| c.is_whitespace() || matches!(c, '>' | '/'));
    &inside[..end.map_or(inside.len(), |(k, _)| k)]
}

/// Where the value of an attribute stands in its tag, without the quotes.
fn attribute(tag: &str, name: &str) -> Option<Range<usize>> {
    let mut at = 0;
    while let Some(equals) = tag[at..].find('=').map(|k| at + k) {
        let open = equals + 1 + tag[equals + 1..].find(['"', '\''])?;
        let quote = char::from(tag.as_bytes()[open]);
        let close = open + 1 + tag[open + 1..].find(quote)?;
        if tag[at..equals].split_whitespace().last() == Some(name) {
            return Some(open + 1..close);
        }
        at = close + 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_tags_stand_outside_comments_and_end_outside_quotes() {
        let text = "<?xml version=\"1.0\"?><!-- <robot> --><robot name='a>b'><link/></robot>";
        let found: Vec<&str> = tags(text).into_iter().map(|tag| &text[tag]).collect();
        assert_eq!(found, ["<?xml version=\"1.0\"?>", "<robot name='a>b'>", "<link/>", "</robot>"]);
        assert_eq!(found.map_elements(), ["?xml", "robot", "link", "/robot"]);
    }

    trait Elements {
        fn map_elements(&self) -> Vec<&str>;
    }

    impl Elements for Vec<&str> {
        fn map_elements(&self) -> Vec<&str> {
            self.iter().map(|tag| element(tag)).collect()
        }
    }

    #[test]
    fn exact_attributes_are_found_by_their_whole_name() {
        let tag = "<joint retype=\"no\" name = 'slide' type=\"prismatic\">";
        let value = |name| attribute(tag, name).map(|at| &tag[at]);
        assert_eq!((value("type"), value("name"), value("axis")), (Some("prismatic"), Some("slide"), None));
    }
}
