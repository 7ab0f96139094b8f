//! Import of URDF and meshes: mass properties against closed forms, refusals of broken models.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};

use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use slideway::error::{Error, ErrorKind};
use slideway::solid::{MassProperties, Mesh, Side, Solid};
use slideway::units::Motion;
use tempfile::TempDir;

/// Rounding of a few hundred double-precision operations.
const ROUNDING: f64 = 1e-12;
/// Largest difference allowed between a shipped URDF inertial and mesh volume × density.
const SHIPPED_INERTIAL: f64 = 1e-3;
/// What it actually is: both sides integrate the same numbers in double precision; the tensors lose
/// some digits where a part is long and thin.
const SHIPPED_INERTIAL_STRICT: f64 = 1e-9;
/// The moving mass follows from the published transfer function to this share.
const MOVING_MASS_KG: f64 = 51.28;
const MOVING_MASS_SHARE: f64 = 1e-3;

// ---- fixtures ------------------------------------------------------------------------------------

/// A box as the eight corners and twelve outward triangles of an OBJ file.
fn box_obj(size: [f64; 3]) -> String {
    let [x, y, z] = size.map(|s| s / 2.0);
    let mut text = String::new();
    for (sx, sy, sz) in
        [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    {
        text += &format!("v {} {} {}\n", f64::from(sx) * x, f64::from(sy) * y, f64::from(sz) * z);
    }
    text + "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"
}

fn box_mesh(size: [f64; 3]) -> Mesh {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("box.obj");
    fs::write(&path, box_obj(size)).unwrap();
    Mesh::read(&path, Vector3::repeat(1.0)).unwrap()
}

/// An L-profile (a 100 × 100 × 1000 mm block without its quarter of 60 × 60) extruded along z, as STL text.
fn l_profile_stl() -> String {
    let outline = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.04), (0.04, 0.04), (0.04, 0.1), (0.0, 0.1)];
    // Fan about the re-entrant corner, which sees every other corner.
    let fan: Vec<[usize; 3]> =
        (0..5).map(|k| [3, (4 + k) % 6, (5 + k) % 6]).filter(|t| !t[1..].contains(&3)).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in fan {
        triangles.push([a, c, b].map(|i| (outline[i].0, outline[i].1, 0.0)));
        triangles.push([a, b, c].map(|i| (outline[i].0, outline[i].1, 1.0)));
    }
    for i in 0..6 {
        let (p, q) = (outline[i], outline[(i + 1) % 6]);
        triangles.push([(p.0, p.1, 0.0), (q.0, q.1, 0.0), (q.0, q.1, 1.0)]);
        triangles.push([(p.0, p.1, 0.0), (q.0, q.1, 1.0), (p.0, p.1, 1.0)]);
    }
    let mut text = String::from("solid profile\n");
    for corners in triangles {
        text += "facet normal 0 0 0\nouter loop\n";
        for (x, y, z) in corners {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid profile\n"
}

const INERTIAL: &str = r#"<inertial><mass value="10"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>"#;
const SLIDE: &str = r#"<joint name="slide" type="prismatic"><parent link="bed"/><child link="table"/>
  <origin xyz="0 0 0.1"/><axis xyz="1 0 0"/><limit lower="-0.2" upper="0.3" effort="100" velocity="2"/>
  <dynamics damping="7" friction="3"/></joint>"#;

fn link(name: &str, inside: &str) -> String {
    format!("<link name=\"{name}\">{inside}</link>\n")
}

fn mesh_visual(file: &str) -> String {
    format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual>")
}

struct Model {
    folder: TempDir,
}

impl Model {
    fn new(content: &str) -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("machine.urdf"), format!("<robot name=\"axis\">\n{content}</robot>\n"))
            .unwrap();
        Self { folder }
    }

    /// A bed and a table that slides, the table showing `mesh`.
    fn with_table_mesh(file: &str, mesh: &str) -> Self {
        let table = link("table", &(INERTIAL.to_owned() + &mesh_visual(file)));
        let model = Self::new(&(link("bed", INERTIAL) + &table + SLIDE));
        fs::write(model.folder.path().join(file), mesh).unwrap();
        model
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("machine.urdf")
    }

    fn import(&self) -> Solid {
        Solid::import(&self.path()).unwrap()
    }

    fn refusal(&self) -> Error {
        Solid::import(&self.path()).expect_err("a broken model was accepted")
    }
}

fn shipped(machine: &str) -> Solid {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(machine).join("machine.urdf");
    Solid::import(&path).unwrap()
}

fn assert_same(actual: &MassProperties, expected: &MassProperties, tolerance: f64) {
    let length = expected.centre_m.norm().max((expected.inertia_kg_m2.trace() / expected.mass_kg).sqrt());
    assert_relative_eq!(actual.mass_kg, expected.mass_kg, max_relative = tolerance);
    assert_abs_diff_eq!(actual.centre_m, expected.centre_m, epsilon = tolerance * length);
    let scale = expected.inertia_kg_m2.norm();
    assert_abs_diff_eq!(actual.inertia_kg_m2, expected.inertia_kg_m2, epsilon = tolerance * scale);
}

// ---- shipped machines ------------------------------------------------------------------------------

#[test]
fn exact_grinder_meshes_times_density_are_the_urdf_inertials() {
    let (steel, cast_iron, magnet_plate) = (7850.0, 7200.0, 7700.0);
    let solid = shipped("grinder");
    assert_eq!(solid.links().count(), 10);
    for (_, link) in solid.links() {
        let density = match link.name.as_str() {
            "base" | "worktable" => cast_iron,
            "magnet_plate_left" | "magnet_plate_right" => magnet_plate,
            _ => steel,
        };
        let from_mesh = link.mass_from_geometry(density);
        assert_same(&from_mesh, &link.mass, SHIPPED_INERTIAL);
        assert_same(&from_mesh, &link.mass, SHIPPED_INERTIAL_STRICT);
    }
}

#[test]
fn exact_grinder_moving_mass_is_the_derived_one() {
    let solid = shipped("grinder");
    assert_eq!((solid.joint.name.as_str(), solid.joint.motion), ("table_slide", Motion::Prismatic));
    assert_eq!((solid.base.link.as_str(), solid.moving.link.as_str()), ("base", "worktable"));
    assert_eq!(solid.moving.links.len(), 7);
    assert_relative_eq!(solid.moving_mass_kg(), MOVING_MASS_KG, max_relative = MOVING_MASS_SHARE);
    assert_eq!(solid.moving_inertia_along_joint(), solid.moving_mass_kg());
    assert_eq!((solid.joint.lower, solid.joint.upper), (-0.35, 0.35));
    let (side, slider) = solid.link("slider_b").unwrap();
    assert_eq!(side, Side::Moving);
    assert_abs_diff_eq!(
        slider.pose_in_body.translation.vector,
        Vector3::new(-0.15, 0.09, -0.026),
        epsilon = ROUNDING
    );
}

#[test]
fn exact_emps_equivalent_mass_is_the_published_one() {
    let solid = shipped("emps");
    assert_eq!(solid.moving_inertia_along_joint(), 95.1089);
    assert_eq!((solid.joint.lower, solid.joint.upper), (-0.05, 0.35));
}

// ---- mass properties --------------------------------------------------------------------------------

#[test]
fn exact_box_mesh_has_the_closed_form() {
    let size = [0.8, 0.6, 0.04];
    let mesh = box_mesh(size);
    mesh.check_closed().unwrap();
    assert_same(
        &MassProperties::from_mesh(&mesh, 7850.0),
        &MassProperties::from_box(Vector3::from(size), 7850.0),
        ROUNDING,
    );
}

#[test]
fn exact_l_profile_has_the_closed_form() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("profile.stl");
    fs::write(&path, l_profile_stl()).unwrap();
    let mesh = Mesh::read(&path, Vector3::repeat(1.0)).unwrap();
    mesh.check_closed().unwrap();
    assert_eq!(mesh.vertices.len(), 12, "welded");
    // The L is the 0.1 m square less the 0.06 m square in its far corner.
    let placed = |size: f64, density: f64| {
        let half = 0.1 - size / 2.0;
        let x = if size == 0.1 { 0.05 } else { half };
        MassProperties::from_box(Vector3::new(size, size, 1.0), density)
            .transformed(&Translation3::new(x, x, 0.5).into())
    };
    let (whole, notch) = (placed(0.1, 7850.0), placed(0.06, 7850.0));
    let cut = MassProperties { mass_kg: -notch.mass_kg, inertia_kg_m2: -notch.inertia_kg_m2, ..notch };
    // STL holds single precision: 0.04 and 0.1 are off by some 1e-8.
    let single_precision = 1e-6;
    assert_same(
        &MassProperties::from_mesh(&mesh, 7850.0),
        &MassProperties::combined(&[whole, cut]),
        single_precision,
    );
}

#[test]
fn ref_mesh_integrals_agree_with_parry() {
    for (_, link) in shipped("grinder").links() {
        for geometry in &link.geometry {
            let slideway::solid::Shape::Mesh { mesh, .. } = &geometry.shape else { panic!("a mesh") };
            let points: Vec<_> =
                mesh.vertices.iter().map(|v| parry3d::math::Vector::new(v.x, v.y, v.z)).collect();
            let other =
                parry3d::mass_properties::MassProperties::from_trimesh(7850.0, &points, &mesh.triangles);
            let ours = MassProperties::from_mesh(mesh, 7850.0);
            assert_relative_eq!(ours.mass_kg, other.mass(), max_relative = ROUNDING);
            let theirs = other.reconstruct_inertia_matrix();
            let theirs = Matrix3::from_fn(|r, c| theirs.col(c)[r]);
            let tolerance = 1e-9 * ours.inertia_kg_m2.norm();
            assert_abs_diff_eq!(ours.inertia_kg_m2, theirs, epsilon = tolerance);
        }
    }
}

#[test]
fn exact_inertial_rotation_turns_the_tensor() {
    let inertial = r#"<inertial><origin xyz="0.1 0.2 0.3" rpy="0 0 1.5707963267948966"/><mass value="2"/>
      <inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.02" iyz="0" izz="0.025"/></inertial>"#;
    let solid = Model::new(&(link("bed", INERTIAL) + &link("table", inertial) + SLIDE)).import();
    // A quarter turn about z: x' = y, y' = -x.
    let expected = Matrix3::new(0.02, -0.001, 0.0, -0.001, 0.01, 0.0, 0.0, 0.0, 0.025);
    assert_abs_diff_eq!(solid.moving.mass.inertia_kg_m2, expected, epsilon = ROUNDING);
    assert_abs_diff_eq!(solid.moving.mass.centre_m, Vector3::new(0.1, 0.2, 0.3), epsilon = ROUNDING);
}

#[test]
fn exact_roll_pitch_yaw_turn_about_fixed_axes() {
    let weight = r#"<joint name="mount" type="fixed"><parent link="table"/><child link="weight"/>
      <origin xyz="0 0 0" rpy="1.5707963267948966 0 1.5707963267948966"/></joint>"#;
    let inertial = r#"<inertial><origin xyz="0 1 0"/><mass value="2"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.025"/></inertial>"#;
    let solid = Model::new(
        &(link("bed", INERTIAL) + &link("table", INERTIAL) + &link("weight", inertial) + SLIDE + weight),
    )
    .import();
    // Rolled first, y becomes z; the yaw about the fixed z leaves it there.
    let (_, link) = solid.link("weight").unwrap();
    let centre = link.pose_in_body * Point3::from(link.mass.centre_m);
    assert_abs_diff_eq!(centre.coords, Vector3::z(), epsilon = ROUNDING);
}

#[test]
fn exact_fixed_links_merge_by_the_parallel_axis_theorem() {
    let mount = r#"<joint name="mount" type="fixed"><parent link="table"/><child link="weight"/><origin xyz="0 0.4 0"/></joint>"#;
    let solid = Model::new(
        &(link("bed", INERTIAL) + &link("table", INERTIAL) + &link("weight", INERTIAL) + SLIDE + mount),
    )
    .import();
    let moving = &solid.moving.mass;
    assert_eq!(solid.moving.links.iter().map(|l| l.name.as_str()).collect::<Vec<_>>(), ["table", "weight"]);
    assert_abs_diff_eq!(moving.centre_m, Vector3::new(0.0, 0.2, 0.0), epsilon = ROUNDING);
    // Two bodies of 10 kg and 0.1 kg·m², each 0.2 m from the common centre along y.
    let across = 2.0 * (0.1 + 10.0 * 0.2 * 0.2);
    assert_abs_diff_eq!(
        moving.inertia_kg_m2,
        Matrix3::from_diagonal(&Vector3::new(across, 0.2, across)),
        epsilon = ROUNDING
    );
    assert_relative_eq!(solid.total_mass_kg(), 30.0);
}

#[test]
fn exact_revolute_inertia_is_about_the_joint_axis() {
    let inertial = r#"<inertial><origin xyz="0 0.3 0.5"/><mass value="4"/>
      <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>"#;
    let joint = r#"<joint name='shaft' type='continuous'><parent link="bed"/><child link="table"/><axis xyz="0 0 2"/></joint>"#;
    let solid = Model::new(&(link("bed", INERTIAL) + &link("table", inertial) + joint)).import();
    assert_eq!(solid.joint.motion, Motion::Revolute);
    assert_relative_eq!(solid.moving_inertia_along_joint(), 0.1 + 4.0 * 0.3 * 0.3, max_relative = ROUNDING);
    assert_eq!((solid.joint.lower, solid.joint.upper), (f64::NEG_INFINITY, f64::INFINITY));
}

#[test]
fn exact_primitives_carry_their_closed_forms() {
    let shapes = r#"<visual><origin xyz="0 0 1"/><geometry><cylinder radius="0.1" length="0.5"/></geometry></visual>
      <visual><geometry><sphere radius="0.2"/></geometry></visual><visual><geometry><box size="1 2 3"/></geometry></visual>"#;
    let solid =
        Model::new(&(link("bed", INERTIAL) + &link("table", &(INERTIAL.to_owned() + shapes)) + SLIDE))
            .import();
    let pi = std::f64::consts::PI;
    let (cylinder, sphere, block) = (pi * 0.01 * 0.5, pi * 0.008 * 4.0 / 3.0, 6.0);
    let all = solid.moving.links[0].mass_from_geometry(1000.0);
    assert_relative_eq!(all.mass_kg, 1000.0 * (cylinder + sphere + block), max_relative = ROUNDING);
    assert_relative_eq!(all.centre_m.z, cylinder / (cylinder + sphere + block), max_relative = ROUNDING);
    let izz = 0.5 * cylinder * 0.01 + 0.4 * sphere * 0.04 + block * 5.0 / 12.0;
    assert_relative_eq!(all.inertia_kg_m2[(2, 2)], 1000.0 * izz, max_relative = ROUNDING);
}

#[test]
fn exact_joint_keeps_limits_dynamics_and_origin() {
    let joint = Model::with_table_mesh("table.obj", &box_obj([0.2, 0.2, 0.1])).import().joint;
    assert_eq!((joint.lower, joint.upper, joint.effort, joint.velocity), (-0.2, 0.3, 100.0, 2.0));
    assert_eq!((joint.damping, joint.friction), (7.0, 3.0));
    assert_eq!(joint.origin, Isometry3::translation(0.0, 0.0, 0.1));
    assert_eq!(joint.axis, Vector3::x_axis());
}

#[test]
fn exact_named_joint_moves_and_the_other_is_held() {
    let tilt = r#"<joint name="tilt" type="revolute"><parent link="table"/><child link="head"/>
      <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"#;
    let model = Model::new(
        &(link("bed", INERTIAL) + &link("table", INERTIAL) + &link("head", INERTIAL) + SLIDE + tilt),
    );
    let refused = model.refusal();
    assert!(refused.to_string().contains("2 joints that move: slide, tilt"), "{refused}");
    let solid = Solid::import_with_joint(&model.path(), Some("tilt")).unwrap();
    assert_eq!((solid.base.links.len(), solid.moving.links.len()), (2, 1));
    assert_eq!(solid.joint.origin, Isometry3::translation(0.0, 0.0, 0.1));
    let refused = Solid::import_with_joint(&model.path(), Some("lift")).unwrap_err();
    assert!(refused.to_string().contains("expected one of slide, tilt"), "{refused}");
}

#[test]
fn exact_package_path_is_found_beside_the_urdf() {
    let table = link("table", &(INERTIAL.to_owned() + &mesh_visual("package://axis/meshes/table.obj")));
    let model = Model::new(&(link("bed", INERTIAL) + &table + SLIDE));
    let refused = model.refusal();
    assert_eq!((refused.kind(), refused.key_name()), (ErrorKind::Missing, Some("table")));
    assert!(refused.to_string().contains("package://axis/meshes/table.obj"), "{refused}");
    fs::create_dir(model.folder.path().join("meshes")).unwrap();
    fs::write(model.folder.path().join("meshes/table.obj"), box_obj([0.2, 0.2, 0.1])).unwrap();
    assert_eq!(model.import().moving.links[0].geometry.len(), 1);
}

#[test]
fn exact_split_vertices_of_an_obj_are_welded() {
    let split: String = {
        let (mut vertices, mut faces) = (String::new(), String::new());
        for (k, triangle) in box_mesh([1.0, 1.0, 1.0]).corners().enumerate() {
            triangle.iter().for_each(|p| vertices += &format!("v {} {} {}\n", p.x, p.y, p.z));
            faces += &format!("o part{k}\nf {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3);
        }
        vertices + &faces
    };
    let model = Model::with_table_mesh("table.obj", &split);
    assert_relative_eq!(
        model.import().moving.links[0].mass_from_geometry(1.0).mass_kg,
        1.0,
        max_relative = ROUNDING
    );
}

// ---- refusals ---------------------------------------------------------------------------------------

fn assert_names(error: &Error, kind: ErrorKind, file: &str, key: &str, words: &[&str]) {
    let text = error.to_string();
    assert_eq!(error.kind(), kind, "{text}");
    assert_eq!(error.path().unwrap().file_name().unwrap(), file, "{text}");
    assert_eq!(error.key_name(), Some(key), "{text}");
    assert!(error.remedy_text().is_some(), "{text}");
    words.iter().for_each(|word| assert!(text.contains(word), "\"{word}\" not in: {text}"));
}

#[test]
fn exact_mesh_with_a_missing_triangle_is_refused() {
    let holed = box_obj([0.2, 0.2, 0.1]).replace("f 5 6 7 8\n", "f 5 6 7\n");
    let refused = Model::with_table_mesh("table.obj", &holed).refusal();
    assert_names(
        &refused,
        ErrorKind::OpenMesh,
        "table.obj",
        "table",
        &["3 open edges", "0.100000", "fill the hole"],
    );
}

#[test]
fn exact_mesh_with_one_flipped_triangle_is_refused() {
    let flipped = box_obj([0.2, 0.2, 0.1]).replace("f 5 6 7 8\n", "f 5 6 7\nf 5 8 7\n");
    let refused = Model::with_table_mesh("table.obj", &flipped).refusal();
    assert_names(&refused, ErrorKind::OpenMesh, "table.obj", "table", &["3 open edges", "same orientation"]);
}

#[test]
fn exact_mesh_turned_inside_out_is_refused() {
    let inward: String = box_obj([0.2, 0.2, 0.1])
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(face) => format!("f {}\n", face.split(' ').rev().collect::<Vec<_>>().join(" ")),
            None => format!("{line}\n"),
        })
        .collect();
    let refused = Model::with_table_mesh("table.obj", &inward).refusal();
    assert_names(&refused, ErrorKind::OpenMesh, "table.obj", "table", &["facing inwards", "flip"]);
}

#[test]
fn exact_doubled_mesh_is_refused() {
    let once = box_obj([0.2, 0.2, 0.1]);
    let faces: String = once.lines().filter(|l| l.starts_with('f')).map(|l| format!("{l}\n")).collect();
    let refused = Model::with_table_mesh("table.obj", &(once + &faces)).refusal();
    assert_names(&refused, ErrorKind::OpenMesh, "table.obj", "table", &["exactly two triangles"]);
}

#[test]
fn exact_mesh_in_mm_without_scale_is_refused() {
    let refused = Model::with_table_mesh("table.obj", &box_obj([200.0, 200.0, 100.0])).refusal();
    assert_names(&refused, ErrorKind::Unit, "table.obj", "table", &["200.0000 m long", "0.001 0.001 0.001"]);
    // Small enough to pass for a large part in m, but far too light for its volume.
    let refused = Model::with_table_mesh("table.obj", &box_obj([20.0, 20.0, 10.0])).refusal();
    assert_names(&refused, ErrorKind::Unit, "table.obj", "table", &["4.000e3 m³", "0.001 0.001 0.001"]);
}

#[test]
fn exact_mesh_scaled_twice_is_refused() {
    let refused = Model::with_table_mesh("table.obj", &box_obj([2e-4, 2e-4, 1e-4])).refusal();
    assert_names(&refused, ErrorKind::Unit, "table.obj", "table", &["remove the scale"]);
    let refused = Model::with_table_mesh("table.obj", &box_obj([5e-5, 5e-5, 1e-5])).refusal();
    assert_names(&refused, ErrorKind::Unit, "table.obj", "table", &["remove the scale"]);
}

#[test]
fn exact_missing_mesh_is_refused() {
    let table = link("table", &(INERTIAL.to_owned() + &mesh_visual("meshes/table.obj")));
    let refused = Model::new(&(link("bed", INERTIAL) + &table + SLIDE)).refusal();
    assert_names(
        &refused,
        ErrorKind::Missing,
        "machine.urdf",
        "table",
        &["meshes/table.obj", "does not exist"],
    );
}

#[test]
fn exact_malformed_meshes_are_refused() {
    for (file, content, kind) in [
        ("table.stl", "solid x\nfacet normal 0 0", ErrorKind::Syntax),
        ("table.obj", "v 1 2 x\n", ErrorKind::Syntax),
        ("table.obj", "v 1 2 3\n", ErrorKind::TooLittleData),
        ("table.dae", "<COLLADA/>", ErrorKind::Syntax),
        ("table.obj", &box_obj([f64::NAN, 1.0, 1.0]), ErrorKind::NotFinite),
    ] {
        let refused = Model::with_table_mesh(file, content).refusal();
        assert_names(&refused, kind, file, "table", &[]);
    }
}

#[test]
fn exact_link_without_inertia_is_refused() {
    let refused = Model::new(&(link("bed", INERTIAL) + &link("table", "") + SLIDE)).refusal();
    assert_names(&refused, ErrorKind::Missing, "machine.urdf", "table", &["no <inertial>"]);
    let refused = Model::new(&(link("bed", "") + &link("table", INERTIAL) + SLIDE)).refusal();
    assert_names(&refused, ErrorKind::Missing, "machine.urdf", "bed", &["no <inertial>"]);
}

#[test]
fn exact_inertia_of_no_real_body_is_refused() {
    for (values, kind) in [
        (["1", "0.1", "0.1", "0.5"], ErrorKind::Inconsistent),
        (["1", "0.1", "0.1", "-0.1"], ErrorKind::OutOfRange),
        (["-1", "0.1", "0.1", "0.1"], ErrorKind::OutOfRange),
        (["1", "0.1", "0.1", "nan"], ErrorKind::NotFinite),
    ] {
        let [m, x, y, z] = values;
        let inertial = format!(
            r#"<inertial><mass value="{m}"/><inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/></inertial>"#
        );
        let refused = Model::new(&(link("bed", INERTIAL) + &link("table", &inertial) + SLIDE)).refusal();
        assert_names(&refused, kind, "machine.urdf", "table", &[]);
    }
}

#[test]
fn exact_broken_joints_are_refused() {
    let links = link("bed", INERTIAL) + &link("table", INERTIAL);
    for (from, to, kind, word) in [
        ("prismatic", "planar", ErrorKind::OutOfRange, "joint type planar"),
        ("prismatic", "floating", ErrorKind::OutOfRange, "joint type floating"),
        ("xyz=\"1 0 0\"", "xyz=\"0 0 0\"", ErrorKind::OutOfRange, "0 0 0"),
        ("<axis xyz=\"1 0 0\"/>", "", ErrorKind::OutOfRange, "no <axis>"),
        ("<axis xyz=\"1 0 0\"/>", "<!-- <axis xyz=\"1 0 0\"/> -->", ErrorKind::OutOfRange, "no <axis>"),
        ("upper=\"0.3\"", "upper=\"-0.3\"", ErrorKind::OutOfRange, "lower below upper"),
        ("damping=\"7\"", "damping=\"-7\"", ErrorKind::OutOfRange, "damping"),
        ("0 0 0.1", "0 0 nan", ErrorKind::NotFinite, "origin"),
    ] {
        let refused = Model::new(&(links.clone() + &SLIDE.replace(from, to))).refusal();
        assert_names(&refused, kind, "machine.urdf", "slide", &[word]);
    }
    let refused = Model::new(&(links.clone() + &SLIDE.replace("prismatic", "fixed"))).refusal();
    assert_names(&refused, ErrorKind::Missing, "machine.urdf", "joint", &["no joint that moves"]);
}

#[test]
fn exact_links_that_are_no_tree_are_refused() {
    let links = link("bed", INERTIAL) + &link("table", INERTIAL);
    let back = r#"<joint name="back" type="fixed"><parent link="table"/><child link="bed"/></joint>"#;
    let again = r#"<joint name="again" type="fixed"><parent link="bed"/><child link="table"/></joint>"#;
    let ghost = r#"<joint name="ghost" type="fixed"><parent link="table"/><child link="lamp"/></joint>"#;
    for (content, key, word) in [
        (links.clone() + SLIDE + back, "axis", "ring"),
        (links.clone() + SLIDE + again, "again", "under \"bed\" and \"bed\""),
        (links.clone() + SLIDE + ghost, "ghost", "\"lamp\", which is not defined"),
        (links.clone() + &link("lamp", INERTIAL) + SLIDE, "lamp", "two links without parent"),
        (links.clone() + &link("bed", INERTIAL) + SLIDE, "bed", "two links named"),
        (links.clone() + SLIDE + SLIDE, "slide", "two joints named"),
        (String::new(), "axis", "no link"),
    ] {
        assert_names(&Model::new(&content).refusal(), ErrorKind::Inconsistent, "machine.urdf", key, &[word]);
    }
}

#[test]
fn exact_broken_xml_and_missing_urdf_are_refused() {
    let model = Model::new("<link name=\"bed\">");
    assert_eq!(model.refusal().kind(), ErrorKind::Syntax);
    let refused = Solid::import(&model.folder.path().join("absent.urdf")).unwrap_err();
    assert_eq!(refused.kind(), ErrorKind::Io);
    assert!(refused.to_string().contains("absent.urdf"));
}

#[test]
fn exact_unknown_link_name_is_refused_with_the_known_ones() {
    let refused = shipped("emps").link("table").unwrap_err();
    assert_names(&refused, ErrorKind::Missing, "machine.urdf", "table", &["base, carriage"]);
}

// ---- invariants --------------------------------------------------------------------------------------

fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    ([-2.0..2.0, -2.0..2.0, -2.0..2.0], [-3.0..3.0, -1.5..1.5, -3.0..3.0]).prop_map(
        |([x, y, z], [r, p, w])| {
            Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(r, p, w))
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exact_moving_the_mesh_moves_its_mass_properties(pose in poses(), size in [0.01..1.0, 0.01..1.0, 0.01..1.0]) {
        let mesh = box_mesh(size);
        let moved = Mesh { vertices: mesh.vertices.iter().map(|v| pose * v).collect(), ..mesh.clone() };
        let expected = MassProperties::from_mesh(&mesh, 7850.0).transformed(&pose);
        // A part of 10 mm some metres away is known to 1e-16 · (3 m / 10 mm)².
        assert_same(&MassProperties::from_mesh(&moved, 7850.0), &expected, 1e-10);
    }

    #[test]
    fn exact_combining_does_not_depend_on_order_or_frame(a in poses(), b in poses(), frame in poses()) {
        let part = MassProperties::from_box(Vector3::new(0.1, 0.2, 0.3), 7850.0);
        let (first, second) = (part.transformed(&a), part.transformed(&b));
        let combined = MassProperties::combined(&[first, second]);
        assert_same(&MassProperties::combined(&[second, first]), &combined, ROUNDING);
        let elsewhere = MassProperties::combined(&[first.transformed(&frame), second.transformed(&frame)]);
        assert_same(&elsewhere, &combined.transformed(&frame), ROUNDING);
        prop_assert!(combined.check().is_ok());
    }

    #[test]
    fn exact_moving_there_and_back_is_the_identity(pose in poses()) {
        let part = MassProperties::from_cylinder(0.1, 0.7, 7850.0).transformed(&Isometry3::translation(0.3, 0.0, 0.1));
        assert_same(&part.transformed(&pose).transformed(&pose.inverse()), &part, ROUNDING);
    }
}
