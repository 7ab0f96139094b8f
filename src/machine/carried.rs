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

    /// Key path by which weight at a lever is stated; none where the machine carries none.
    pub fn lever_key(&self) -> Option<&'static str> {
        self.lever().map(Payload::lever_key)
    }

    /// The moving body in the joint's frame, with the mass that it carries at a lever; its centre is off by a moment that is
    /// stated without a mass.
    pub fn moving_body(&self) -> MassProperties {
        let own = self.solid.moving.mass;
        let Some((payload, direction)) = self.lever().and_then(|p| Some((p, self.lever_direction(p)?)))
        else {
            return own;
        };
        let carried = MassProperties {
            mass_kg: payload.lever_mass_kg,
            centre_m: payload.lever_m * direction,
            inertia_kg_m2: Matrix3::zeros(),
        };
        let mut body =
            if payload.lever_mass_kg == 0.0 { own } else { MassProperties::combined(&[own, carried]) };
        body.centre_m += direction * (payload.lever_moment_kg_m / body.mass_kg);
        body
    }

    /// Weight of a payload per kg·m of its mass times its lever, as an effort along the joint; none on a prismatic or upright
    /// axis, and where nothing tells the payload's direction.
    pub fn lever_weight(&self) -> Option<Weight> {
        let payload = self.description.effect.payload.clone();
        let direction = match self.motion() {
            Motion::Prismatic => None,
            Motion::Revolute => self.lever_direction(&payload.unwrap_or_default()),
        };
        let unit = |centre_m| MassProperties { mass_kg: 1.0, centre_m, inertia_kg_m2: Matrix3::zeros() };
        Weight::of(&self.solid.joint, &unit(direction?), 1.0).filter(|_| self.gravity_across().is_some())
    }

    /// The solid model with the mass that its moving body carries at a lever.
    pub fn loaded_solid(&self) -> Cow<'_, Solid> {
        if self.lever().is_none() {
            return Cow::Borrowed(&*self.solid);
        }
        let mut solid = Solid::clone(&self.solid);
        solid.moving.mass = self.moving_body();
        Cow::Owned(solid)
    }

    /// Direction of gravity across the axis, in the joint's frame; none where the axis is upright.
    fn gravity_across(&self) -> Option<Vector3<f64>> {
        let (axis, gravity) = (self.solid.joint.axis.into_inner(), self.solid.joint.gravity());
        let across = gravity - axis * gravity.dot(&axis);
        (across.norm() > UPRIGHT * gravity.norm()).then(|| across.normalize())
    }

    /// Direction from the axis to the payload at q = 0; none where nothing tells it.
    fn lever_direction(&self, payload: &Payload) -> Option<Vector3<f64>> {
        let (joint, across) = (&self.solid.joint, self.gravity_across());
        // About an upright axis nothing hangs, and every direction is alike.
        let any = || joint.axis.cross(&Vector3::x()).try_normalize(0.1).unwrap_or_else(Vector3::y);
        let own = || Weight::of(joint, &self.solid.moving.mass, self.solid.moving_inertia_along_joint());
        let hangs_at = match payload.hangs_at_rad {
            Some(angle) => angle,
            None if across.is_some() => own()?.hanging_rad()?,
            None => 0.0,
        };
        Some(UnitQuaternion::from_axis_angle(&joint.axis, -hangs_at) * across.unwrap_or_else(any))
    }

    /// Refuses a lever on a prismatic axis, and one whose direction nothing tells.
    pub(super) fn check_lever(&self) -> Result<()> {
        let told = self.description.effect.payload.as_ref().filter(|payload| payload.tells_of_lever());
        let Some(payload) = told else { return Ok(()) };
        let refused = |kind, found: &str| {
            Error::new(kind).file(&self.file).key(payload.lever_key()).found(found.to_owned())
        };
        if self.motion() == Motion::Prismatic {
            return Err(refused(ErrorKind::Inconsistent, "a payload at a lever on an axis that slides")
                .expected("a lever on an axis that turns")
                .remedy(
                    "state the payload as mass_kg; where it lies makes no difference along a straight axis",
                ));
        }
        if self.lever_direction(payload).is_none() {
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
