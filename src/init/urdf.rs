//! A solid model of one body on one joint.

use crate::units::Motion;

/// Density of the box that stands for the moving part, in kg/m³: a hollow machine part. Only what it looks like.
const DENSITY_KG_PER_M3: f64 = 2000.0;
/// The fixed part weighs so many times the moving one; without modes of the base nothing depends on it.
const BASE_TIMES: f64 = 10.0;
/// Mass of a turning part in kg whose inertia is all that counts.
const TURNING_KG: f64 = 1.0;

/// The URDF of an axis: mass in kg along x, or inertia in kg·m² about z.
pub fn one_body(motion: Motion, mass: f64, stroke: Option<[f64; 2]>, words: &str) -> String {
    let (kind, axis, kilograms, inertia) = match motion {
        Motion::Prismatic => ("prismatic", "1 0 0", mass, mass * edge(mass).powi(2) / 6.0),
        Motion::Revolute => ("revolute", "0 0 1", TURNING_KG, mass),
    };
    let side = edge(kilograms);
    let travel = stroke.map_or(1.0, |[from, to]| (to - from).abs());
    let length = if motion == Motion::Prismatic { travel + side } else { 2.0 * side };
    let base = BASE_TIMES * kilograms;
    let [across, along] = [base * (length * length + side * side) / 12.0, base * side * side / 6.0];
    let (kind, limit) = match (motion, stroke) {
        (_, Some([from, to])) => {
            (kind, format!("\n    <limit lower=\"{from}\" upper=\"{to}\" effort=\"0\" velocity=\"0\"/>"))
        }
        (Motion::Revolute, None) => ("continuous", String::new()),
        (Motion::Prismatic, None) => (kind, String::new()),
    };
    // A comment of XML has no two dashes in a row.
    let words = words.replace("--", "flag ");
    format!(
        "<?xml version=\"1.0\"?>\n\
         <!-- One body on one joint, written by `slideway init`. {words}\n     \
         All shapes and the base are assumed: they are what a picture shows. The axis lies level. -->\n\
         <robot name=\"axis\">\n  \
         <link name=\"base\">\n    \
         <inertial><origin xyz=\"0 0 {below:.6}\"/><mass value=\"{base}\"/>\
         <inertia ixx=\"{along:.6e}\" ixy=\"0\" ixz=\"0\" iyy=\"{across:.6e}\" iyz=\"0\" izz=\"{across:.6e}\"/></inertial>\n    \
         <visual><origin xyz=\"0 0 {below:.6}\"/><geometry><box size=\"{length:.6} {side:.6} {side:.6}\"/></geometry></visual>\n  \
         </link>\n  \
         <link name=\"moving\">\n    \
         <inertial><origin xyz=\"0 0 0\"/><mass value=\"{kilograms}\"/>\
         <inertia ixx=\"{inertia:e}\" ixy=\"0\" ixz=\"0\" iyy=\"{inertia:e}\" iyz=\"0\" izz=\"{inertia:e}\"/></inertial>\n    \
         <visual><geometry><box size=\"{side:.6} {side:.6} {side:.6}\"/></geometry></visual>\n  \
         </link>\n  \
         <joint name=\"axis\" type=\"{kind}\">\n    \
         <parent link=\"base\"/>\n    <child link=\"moving\"/>\n    <axis xyz=\"{axis}\"/>{limit}\n  \
         </joint>\n\
         </robot>\n",
        below = -side
    )
}

fn edge(kilograms: f64) -> f64 {
    (kilograms / DENSITY_KG_PER_M3).cbrt()
}
