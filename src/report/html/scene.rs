//! The machine from its own meshes.

use super::page::Part;
use crate::report::figure::{Figure, Panel, View};
use crate::report::material::MachineShape;

/// The section; with a recording, the live view plays it.
pub(super) fn part(shape: &MachineShape, plays: bool) -> Part {
    let mut part = Part::default();
    if shape.surfaces.is_empty() {
        part.paragraph("The URDF names no shape that could be drawn.");
        return part;
    }
    let mut caption =
        "The machine from its URDF; what the joint moves is blue, the arrow is its positive direction."
            .to_owned();
    if !shape.sliders.is_empty() {
        caption += " Letters mark the bearing sliders.";
    }
    let mut still = Part::default();
    still.figure(Figure::new("machine", caption, vec![Panel::View(View { shape: shape.clone() })]));
    if plays {
        still.raw(
            "<p class=\"hint\">With scripts allowed, this view turns, and plays the recorded motion.</p>\n",
        );
    }
    part.live("scene", still);
    part
}
