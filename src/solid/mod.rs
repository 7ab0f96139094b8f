//! The solid model: URDF and meshes to rigid bodies.
