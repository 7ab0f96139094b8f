//! The moving body with what it carries at a lever.

use super::Machine;
use crate::effect::Payload;
use crate::error::{Error, ErrorKind, Result};
use crate::solid::{MassProperties, Solid, Weight};
use crate::units::Motion;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use std::borrow::Cow;

/// Share of gravity across the axis below which nothing hangs: the axis is upright.
const UPRIGHT: f64 = 1e-9;

impl Machine {
    fn lever(&self) -> Option<&Payload> {
        self.description.effect.payload.as_ref().filter(|payload| payload.has_lever())
    }

    /// Whether the machine carries a mass at a lever.
    pub fn has_lever(&self) -> bool {
        self.lever().is_some()
    }

    /// The moving body in the joint's frame, with the mass that it carries at a lever.
    pub fn moving_body(&self) -> MassProperties {
        let own = self.solid.moving.mass;
        match self.lever().and_then(|payload| self.carried(payload)) {
            Some(carried) => MassProperties::combined(&[own, carried]),
            None => own,
        }
    }

    /// The solid model with the mass that its moving body carries at a lever.
    pub fn loaded_solid(&self) -> Cow<'_, Solid> {
        if !self.has_lever() {
            return Cow::Borrowed(&*self.solid);
        }
        let mut solid = Solid::clone(&self.solid);
        solid.moving.mass = self.moving_body();
        Cow::Owned(solid)
    }

    /// The mass at its lever, at q = 0; none where nothing tells its direction.
    fn carried(&self, payload: &Payload) -> Option<MassProperties> {
        let joint = &self.solid.joint;
        let (axis, gravity) = (joint.axis, joint.gravity());
        let across = gravity - axis.into_inner() * gravity.dot(&axis);
        // About an upright axis nothing hangs, and every direction is alike.
        let down = if across.norm() > UPRIGHT * gravity.norm() {
            across.normalize()
        } else {
            axis.cross(&Vector3::x()).try_normalize(0.1).unwrap_or_else(Vector3::y)
        };
        let own = || Weight::of(joint, &self.solid.moving.mass, self.solid.moving_inertia_along_joint());
        let hangs_at = match payload.hangs_at_rad {
            Some(angle) => angle,
            None if across.norm() > UPRIGHT * gravity.norm() => own()?.hanging_rad()?,
            None => 0.0,
        };
        let direction = UnitQuaternion::from_axis_angle(&axis, -hangs_at) * down;
        Some(MassProperties {
            mass_kg: payload.lever_mass_kg,
            centre_m: payload.lever_m * direction,
            inertia_kg_m2: Matrix3::zeros(),
        })
    }

    /// Refuses a lever on a prismatic axis, and one whose direction nothing tells.
    pub(super) fn check_lever(&self) -> Result<()> {
        let Some(payload) = self.lever() else { return Ok(()) };
        let refused = |kind, found: &str| {
            Error::new(kind).file(&self.file).key("effect.payload.lever_m").found(found.to_owned())
        };
        if self.motion() == Motion::Prismatic {
            return Err(refused(ErrorKind::Inconsistent, "a payload at a lever on an axis that slides")
                .expected("a lever on an axis that turns")
                .remedy(
                    "state the payload as mass_kg; where it lies makes no difference along a straight axis",
                ));
        }
        if self.carried(payload).is_none() {
            return Err(refused(
                ErrorKind::Missing,
                "a payload at a lever on a part that is balanced about its axis",
            )
            .expected(
                "hangs_at_rad beside it: the position of the joint at which the payload hangs below the axis",
            )
            .remedy("turn the axis until the payload hangs, and state the position that the encoder shows"));
        }
        let mass_kg = self.moving_body().mass_kg;
        if mass_kg.is_nan() || mass_kg <= 0.0 {
            return Err(refused(ErrorKind::OutOfRange, "a payload that leaves the moving part no mass")
                .expected("more than zero after the payload is added")
                .remedy("a negative lever_mass_kg must be smaller than the solid model's mass"));
        }
        Ok(())
    }
}
