//! The links and joints of a URDF as a tree, and its cut at the moving joint.

use std::collections::{HashMap, HashSet};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use urdf_rs::{JointType, Robot};

use crate::error::{Error, ErrorKind, Result};

/// Farther than this no part of a machine stands from another, in m.
const FARTHEST_M: f64 = 1e3;
/// Larger than this no angle is stated, in rad: degrees of many turns.
const LARGEST_RAD: f64 = 1e4;

/// A checked tree: one root, every link reached exactly once.
pub(super) struct Tree<'a> {
    robot: &'a Robot,
    root: &'a str,
    children: HashMap<&'a str, Vec<&'a urdf_rs::Joint>>,
}

/// A link and its frame in the frame of the link the walk began at.
pub(super) type PlacedLink<'a> = (&'a urdf_rs::Link, Isometry3<f64>);

impl<'a> Tree<'a> {
    pub(super) fn new(robot: &'a Robot) -> Result<Self> {
        check_unique("link", robot.links.iter().map(|l| l.name.as_str()))?;
        check_unique("joint", robot.joints.iter().map(|j| j.name.as_str()))?;
        let names: HashSet<&str> = robot.links.iter().map(|l| l.name.as_str()).collect();
        let mut parent_of: HashMap<&str, &str> = HashMap::new();
        let mut children: HashMap<&str, Vec<&urdf_rs::Joint>> = HashMap::new();
        for joint in &robot.joints {
            for link in [&joint.parent.link, &joint.child.link] {
                if !names.contains(link.as_str()) {
                    return Err(not_a_tree(&joint.name, format!("link \"{link}\", which is not defined")));
                }
            }
            let (parent, child) = (joint.parent.link.as_str(), joint.child.link.as_str());
            if let Some(other) = parent_of.insert(child, parent) {
                return Err(not_a_tree(
                    &joint.name,
                    format!("link \"{child}\" under \"{other}\" and \"{parent}\""),
                ));
            }
            children.entry(parent).or_default().push(joint);
        }
        let mut roots = robot.links.iter().map(|l| l.name.as_str()).filter(|n| !parent_of.contains_key(n));
        let root = roots.next().ok_or_else(|| {
            not_a_tree(&robot.name, if names.is_empty() { "no link" } else { "a ring of joints" })
        })?;
        if let Some(second) = roots.next() {
            return Err(not_a_tree(second, format!("two links without parent, \"{root}\" and \"{second}\"")));
        }
        let tree = Self { robot, root, children };
        let reached: HashSet<&str> = tree.walk(root, None)?.iter().map(|(l, _)| l.name.as_str()).collect();
        match robot.links.iter().find(|l| !reached.contains(l.name.as_str())) {
            Some(lost) => Err(not_a_tree(&lost.name, "a ring of joints")),
            None => Ok(tree),
        }
    }

    /// The joint that moves: the named one, else the only one that is not fixed.
    pub(super) fn moving_joint(&self, name: Option<&str>) -> Result<&'a urdf_rs::Joint> {
        let movable = || self.robot.joints.iter().filter(|j| j.joint_type != JointType::Fixed);
        for joint in movable() {
            let supported = matches!(
                joint.joint_type,
                JointType::Prismatic | JointType::Revolute | JointType::Continuous
            );
            if !supported {
                return Err(Error::new(ErrorKind::OutOfRange)
                    .key(&joint.name)
                    .found(format!("joint type {}", format!("{:?}", joint.joint_type).to_lowercase()))
                    .expected("fixed, prismatic, revolute or continuous")
                    .remedy("describe the axis by one of these joints"));
            }
        }
        let names = || movable().map(|j| j.name.as_str()).collect::<Vec<_>>().join(", ");
        match (name, movable().count()) {
            (Some(name), _) => movable().find(|j| j.name == name).ok_or_else(|| {
                Error::new(ErrorKind::Missing)
                    .key(name)
                    .found("no movable joint of that name")
                    .expected(format!("one of {}", names()))
                    .remedy("correct the name of the driven joint")
            }),
            (None, 1) => movable().next().ok_or_else(|| Error::new(ErrorKind::Missing)),
            (None, 0) => Err(Error::new(ErrorKind::Missing)
                .key("joint")
                .found("no joint that moves")
                .expected("one prismatic, revolute or continuous joint")
                .remedy("make the driven joint of the machine one of these")),
            (None, count) => Err(Error::new(ErrorKind::Inconsistent)
                .key("joint")
                .found(format!("{count} joints that move: {}", names()))
                .expected("one")
                .remedy("name the driven joint; the others are then held at zero")),
        }
    }

    /// Refuses joints that could move besides the driven one, unless the machine says that they are held.
    pub(super) fn check_held(&self, driven: &str, held: &[String]) -> Result<()> {
        let names: Vec<&str> = self.robot.joints.iter().map(|joint| joint.name.as_str()).collect();
        if let Some(unknown) = held.iter().find(|name| !names.contains(&name.as_str())) {
            return Err(Error::new(ErrorKind::Missing)
                .key(unknown)
                .found("no joint of that name, which held_joints of the machine file has")
                .expected(format!("one of {}", names.join(", ")))
                .remedy("correct held_joints"));
        }
        let is_free = |joint: &&urdf_rs::Joint| {
            joint.joint_type != JointType::Fixed && joint.name != driven && !held.contains(&joint.name)
        };
        match self.robot.joints.iter().find(is_free) {
            None => Ok(()),
            Some(free) => Err(Error::new(ErrorKind::Inconsistent)
                .key(&free.name)
                .found(format!("a second joint that moves, beside the driven one, {driven}"))
                .expected("fixed joints besides the driven one")
                .remedy(format!(
                    "make it fixed, or hold it at zero: held_joints = [\"{}\"] at the head of the machine file",
                    free.name
                ))),
        }
    }

    /// Links of the base body: all that is reached from the root without `moving`.
    pub(super) fn base_links(&self, moving: &str) -> Result<Vec<PlacedLink<'a>>> {
        self.walk(self.root, Some(moving))
    }

    /// Links of the moving body: the subtree that begins at `link`.
    pub(super) fn moving_links(&self, link: &'a str) -> Result<Vec<PlacedLink<'a>>> {
        self.walk(link, None)
    }

    fn walk(&self, start: &'a str, without_joint: Option<&str>) -> Result<Vec<PlacedLink<'a>>> {
        let mut placed = Vec::new();
        let mut pending = vec![(start, Isometry3::identity())];
        while let Some((name, pose)) = pending.pop() {
            let found = self.robot.links.iter().find(|l| l.name == name);
            placed.extend(found.map(|link| (link, pose)));
            let joints = self.children.get(name).map(Vec::as_slice).unwrap_or_default();
            // Popped from the end: pushed in reverse, the links come out in the order of the file.
            for joint in joints.iter().rev().filter(|j| Some(j.name.as_str()) != without_joint) {
                pending.push((joint.child.link.as_str(), pose * isometry(&joint.origin, &joint.name)?));
            }
        }
        Ok(placed)
    }
}

/// A URDF pose: fixed-axis roll, pitch, yaw, i.e. R = Rz(yaw)·Ry(pitch)·Rx(roll).
pub(super) fn isometry(pose: &urdf_rs::Pose, key: &str) -> Result<Isometry3<f64>> {
    if !pose.xyz.iter().chain(pose.rpy.iter()).all(|x| x.is_finite()) {
        return Err(Error::new(ErrorKind::NotFinite)
            .key(key)
            .found(format!("origin xyz {:?} rpy {:?}", pose.xyz.0, pose.rpy.0))
            .expected("finite numbers")
            .remedy("correct this <origin>"));
    }
    if pose.xyz.iter().any(|x| x.abs() > FARTHEST_M) || pose.rpy.iter().any(|x| x.abs() > LARGEST_RAD) {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key(key)
            .found(format!("origin xyz {:?} rpy {:?}", pose.xyz.0, pose.rpy.0))
            .expected(format!("at most {FARTHEST_M} m and {LARGEST_RAD} rad"))
            .remedy("correct this <origin>: lengths in m, angles in rad"));
    }
    let [roll, pitch, yaw] = pose.rpy.0;
    let translation = Translation3::from(Vector3::from(pose.xyz.0));
    Ok(Isometry3::from_parts(translation, UnitQuaternion::from_euler_angles(roll, pitch, yaw)))
}

fn check_unique<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<()> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(not_a_tree(name, format!("two {what}s named \"{name}\"")));
        }
    }
    Ok(())
}

fn not_a_tree(key: &str, found: impl Into<String>) -> Error {
    Error::new(ErrorKind::Inconsistent)
        .key(key)
        .found(found)
        .expected("links and joints that form one tree with one root")
        .remedy("correct the <parent> and <child> of the joints and the names of the links")
}
