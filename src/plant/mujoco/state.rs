//! Coordinates and speeds of the scene, and how a force that rises within a step changes them.

/// Coordinates and speeds of the scene: the driven joint and the base's modes, in the order of MuJoCo's degrees of freedom.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct State {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
}

impl State {
    /// Half-way to another state.
    pub fn middle(&self, other: &Self) -> Self {
        let half = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        Self { q: half(&self.q, &other.q), v: half(&self.v, &other.v) }
    }
}

/// Change of coordinates and speeds by a force that rises by a unit within a step at zero mean.
#[derive(Debug, Clone)]
pub(super) struct RiseResponse {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
}
