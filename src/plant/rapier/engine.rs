//! The joint and the vectors and poses of the scene in rapier's own types.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::dynamics::{GenericJoint, GenericJointBuilder, JointAxesMask, JointAxis};
use rapier3d::math::{Pose, Rotation, Vector};

use crate::solid::Joint;
use crate::units::Motion;

/// The joint as rapier's impulse joint: its X axis along the URDF's axis, contacts off.
pub(super) fn guide(joint: &Joint) -> GenericJoint {
    let basis = Pose::from_rotation(GenericJoint::complete_ang_frame(vector(&joint.axis)));
    let (mask, free) = match joint.motion {
        Motion::Prismatic => (JointAxesMask::LOCKED_PRISMATIC_AXES, JointAxis::LinX),
        Motion::Revolute => (JointAxesMask::LOCKED_REVOLUTE_AXES, JointAxis::AngX),
    };
    let mut guide = GenericJointBuilder::new(mask)
        .local_frame1(pose(&joint.origin) * basis)
        .local_frame2(basis)
        .contacts_enabled(false)
        .build();
    if joint.lower.is_finite() && joint.upper.is_finite() {
        guide.set_limits(free, [joint.lower, joint.upper]);
    }
    guide
}

pub(super) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn nalgebra_vector(v: Vector) -> Vector3<f64> {
    Vector3::new(v.x, v.y, v.z)
}

pub(super) fn pose(p: &Isometry3<f64>) -> Pose {
    let q = p.rotation.quaternion();
    Pose::from_parts(vector(&p.translation.vector), Rotation::from_xyzw(q.i, q.j, q.k, q.w))
}

pub(super) fn isometry(p: &Pose) -> Isometry3<f64> {
    let r = p.rotation;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(r.w, r.x, r.y, r.z));
    Isometry3::from_parts(Translation3::from(nalgebra_vector(p.translation)), rotation)
}
