//! Dry friction of the guide: one law of named features.

use super::Bristle;

/// What the guide opposes to motion beside its mean viscous drag, as one law.
///
/// # Model
/// With the direction s = sgn(v) of the motion, the level at which the guide slides
/// ```text
///   g(s, |v|, N) = F_c·(1 + a·s + (p − 1)·exp(−(v/v_s)²)) + μ·N
/// ```
/// and the drag by which the directions differ, `−b·c·|v|`, beside the mean drag `−c·v` of the linear dynamics:
/// ```text
///   without bristles:  F ∈ −g·Sgn(v) − b·c·|v|
///   behind bristles:   LuGre with g, see [`Bristle`]
/// ```
/// Each effect of dry friction sets its own numbers of this one law: Coulomb friction F_c, asymmetric friction a and b, Stribeck
/// friction p and v_s, friction in proportion to load μ, presliding the bristles.
///
/// # Validity
/// |a|, |b| ≤ 1 and p ≥ 1: the level and the drag are not negative.
///
/// # Source
/// Armstrong-Hélouvry, Dupont, Canudas de Wit (1994), *A survey of models, analysis tools and compensation methods for the
/// control of machines with friction*, section 3 and eq. 5 with exponent 2.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DryFriction {
    /// F_c in N or N·m.
    pub coulomb: f64,
    /// a: by which share of F_c the positive direction slides harder, and the negative one lighter.
    pub asymmetry: f64,
    /// b: by which share of the viscous coefficient c the positive direction drags more, and the negative one less.
    pub viscous_asymmetry: f64,
    /// The peak of the Stribeck curve.
    pub stribeck: Option<Stribeck>,
    /// μ.
    pub load_coefficient: f64,
    /// What deflects before the guide slides.
    pub bristle: Option<Bristle>,
}

/// The peak of the Stribeck curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    /// p = F_s/F_c; at least 1.
    pub peak_ratio: f64,
    /// v_s in m/s or rad/s; more than zero.
    pub velocity: f64,
}

impl DryFriction {
    /// Whether the level depends on speed.
    pub fn varies(&self) -> bool {
        self.stribeck.is_some()
    }

    /// g in N or N·m in a direction (±1) at a speed ≥ 0, without the part of the load.
    #[inline]
    pub fn level(&self, direction: f64, speed: f64) -> f64 {
        let level = self.coulomb * (1.0 + self.asymmetry * direction);
        match self.stribeck {
            None => level,
            Some(Stribeck { peak_ratio, velocity }) => {
                let ratio = speed / velocity;
                level + self.coulomb * (peak_ratio - 1.0) * (-ratio * ratio).exp()
            }
        }
    }

    /// b·c in N·s/m or N·m·s/rad, of the mean coefficient `viscous`: drag that the positive direction has more than the mean.
    pub fn drag(&self, viscous: f64) -> f64 {
        self.viscous_asymmetry * viscous
    }

    /// Level and drag by which the directions differ, in N or N·m: what the guide opposes to motion in a direction (±1) at a
    /// speed beside its mean drag of `viscous`, without the part of the load.
    pub fn resistance(&self, direction: f64, speed: f64, viscous: f64) -> f64 {
        self.level(direction, speed) + direction * self.drag(viscous) * speed
    }
}
