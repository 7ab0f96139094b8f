//! The state of a scene as one row of numbers.

use nalgebra::Vector3;
use rapier3d::math::{Pose, Rotation, Vector};

use super::loads::Reaction;
use super::scene::{Pending, Scene};
use crate::error::{Error, ErrorKind, Result};

/// Numbers of a snapshot: pose 7, velocity 6, joint coordinate 1, reaction 6.
const SNAPSHOT_LEN: usize = 20;

impl Scene {
    /// Everything that the next step depends on; efforts applied since the last step are not part of it.
    pub fn snapshot(&self) -> Vec<f64> {
        let body = &self.world.bodies[self.body];
        let Pose { translation, rotation, .. } = *body.position();
        let mut numbers = Vec::with_capacity(SNAPSHOT_LEN);
        numbers.extend(translation.to_array());
        numbers.extend(rotation.to_array());
        numbers.extend(body.linvel().to_array());
        numbers.extend(body.angvel().to_array());
        numbers.push(self.coordinate);
        numbers.extend(self.reaction.force_n.iter().chain(self.reaction.moment_n_m.iter()));
        numbers
    }

    /// Returns to a state taken by [`Scene::snapshot`] of a scene of the same solid, step and payload;
    /// the motion goes on as it did then, to the last bit. Efforts not yet stepped are dropped.
    ///
    /// # Errors
    /// A snapshot of another length.
    pub fn restore(&mut self, snapshot: &[f64]) -> Result<()> {
        let &[x, y, z, i, j, k, w, vx, vy, vz, wx, wy, wz, q, fx, fy, fz, mx, my, mz] = snapshot else {
            return Err(Error::new(ErrorKind::Inconsistent)
                .key("snapshot")
                .found(format!("{} numbers", snapshot.len()))
                .expected(format!("{SNAPSHOT_LEN} numbers of a rigid-body scene"))
                .remedy("restore only what this scene's snapshot gave"));
        };
        let body = &mut self.world.bodies[self.body];
        body.set_position(Pose::from_parts(Vector::new(x, y, z), Rotation::from_xyzw(i, j, k, w)), true);
        body.set_linvel(Vector::new(vx, vy, vz), true);
        body.set_angvel(Vector::new(wx, wy, wz), true);
        self.pending = Pending::default();
        self.coordinate = q;
        self.read_speed();
        self.reaction = Reaction { force_n: Vector3::new(fx, fy, fz), moment_n_m: Vector3::new(mx, my, mz) };
        Ok(())
    }
}
