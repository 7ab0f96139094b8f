//! Dry friction of the guide: one law of named features.

use super::{Bristle, Level};
use crate::elementary::sin_cos_turns;

/// What the guide opposes to motion beside its mean viscous drag, as one law.
///
/// # Model
/// With the direction s = sgn(v) of the motion, the level at which the guide slides
/// ```text
///   g(s, |v|, N, x, t) = [F_c·(a·s + e(v)) + μ·N·e(v)]·(1 + r·t) + F_l·b((x − x_l)/w)
///   e(v) = 1 + (p − 1)·exp(−(v/v_s)²)
///   b(u) = ½·(1 + cos 2πu) for |u| < ½, else 0
/// ```
/// (never below zero; t is the time of the session)
/// and the drag by which the directions differ, `−b·c·|v|`, beside the mean drag `−c·v` of the linear dynamics:
/// ```text
///   without bristles:  F ∈ −g·Sgn(v) − b·c·|v|
///   behind bristles:   LuGre with g, see [`Bristle`]
/// ```
/// Each effect of dry friction sets its own numbers of this one law: Coulomb friction F_c, asymmetric friction a and b, Stribeck
/// friction p and v_s, friction in proportion to load μ, local friction F_l, x_l and w, drift r, presliding the bristles.
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
    /// Friction of one place of the travel.
    pub local: Option<Local>,
    /// r in 1/s: by which share of its level friction grows in a second of the session.
    pub drift_per_s: f64,
    /// What deflects before the guide slides.
    pub bristle: Option<Bristle>,
}

/// The peak of the Stribeck curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    /// p; at least 1.
    pub peak_ratio: f64,
    /// v_s in m/s or rad/s; more than zero.
    pub velocity: f64,
}

/// Friction of one place of the travel: a worn or a tight spot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Local {
    /// F_l in N or N·m; below zero where the spot runs easier.
    pub force: f64,
    /// x_l in m or rad.
    pub centre: f64,
    /// w in m or rad; more than zero.
    pub width: f64,
}

impl Local {
    /// F_l·b in N or N·m at a position.
    #[inline]
    pub fn at(&self, position: f64) -> f64 {
        self.force * Self::shape((position - self.centre) / self.width)
    }

    /// b(u).
    #[inline]
    pub fn shape(u: f64) -> f64 {
        if u.abs() < 0.5 { 0.5 * (1.0 + sin_cos_turns(u)[1]) } else { 0.0 }
    }
}

impl DryFriction {
    /// Whether the level depends on place or time.
    #[inline]
    pub fn has_place_or_time(&self) -> bool {
        self.local.is_some() || self.drift_per_s != 0.0
    }

    /// What a level in N or N·m becomes at a position and a time of the session in s; not negative.
    #[inline]
    pub fn level_at(&self, level: f64, position: f64, time_s: f64) -> f64 {
        let drifted = level * (1.0 + self.drift_per_s * time_s).max(0.0);
        (drifted + self.local.map_or(0.0, |local| local.at(position))).max(0.0)
    }

    /// Whether the level depends on speed.
    pub fn varies(&self) -> bool {
        self.stribeck.is_some()
    }

    /// g in N or N·m at standstill in the direction that holds more, without the part of the load.
    pub fn at_rest(&self) -> f64 {
        self.at_rest_under(0.0)
    }

    /// The same with the part of the load, see [`level_under`](Self::level_under).
    pub fn at_rest_under(&self, loaded: f64) -> f64 {
        self.level_under(loaded, 1.0, 0.0).max(self.level_under(loaded, -1.0, 0.0))
    }

    /// g in N or N·m in a direction (±1) at a speed ≥ 0, without the part of the load.
    #[inline]
    pub fn level(&self, direction: f64, speed: f64) -> f64 {
        self.level_under(0.0, direction, speed)
    }

    /// The same with the part of the load, which is `loaded` at speeds well above those of the Stribeck curve.
    #[inline]
    pub fn level_under(&self, loaded: f64, direction: f64, speed: f64) -> f64 {
        self.level_over([loaded; 2], None).at(direction, speed)
    }

    /// The level over one step, in whose middle position and time of the session are these, with the part of the load in the positive and the
    /// negative direction.
    #[inline]
    pub fn level_over(&self, [forward, backward]: [f64; 2], place_and_time: Option<[f64; 2]>) -> Level {
        let base = [
            self.coulomb * (1.0 + self.asymmetry) + forward,
            self.coulomb * (1.0 - self.asymmetry) + backward,
        ];
        let (peak, velocity) = match &self.stribeck {
            None => ([0.0; 2], f64::INFINITY),
            Some(Stribeck { peak_ratio, velocity }) => {
                ([forward, backward].map(|loaded| (self.coulomb + loaded) * (peak_ratio - 1.0)), *velocity)
            }
        };
        let (factor, local) = place_and_time.map_or((1.0, 0.0), |[position, time_s]| {
            let factor = (1.0 + self.drift_per_s * time_s).max(0.0);
            (factor, self.local.map_or(0.0, |local| local.at(position)))
        });
        Level { base, peak, velocity, factor, local }
    }

    /// b·c in N·s/m or N·m·s/rad, of the mean coefficient `viscous`: drag that the positive direction has more than the mean.
    pub fn drag(&self, viscous: f64) -> f64 {
        self.viscous_asymmetry * viscous
    }

    /// Level and drag by which the directions differ, in N or N·m: what the guide opposes to motion in a direction (±1) at a
    /// speed beside its mean drag of `viscous`, without the part of the load, at the session's beginning and apart from places.
    pub fn resistance(&self, direction: f64, speed: f64, viscous: f64) -> f64 {
        self.level(direction, speed) + direction * self.drag(viscous) * speed
    }

    /// The same at a position and a time of the session in s.
    pub fn resistance_at(&self, velocity: f64, viscous: f64, position: f64, time_s: f64) -> f64 {
        let (direction, speed) = (velocity.signum(), velocity.abs());
        let level = self.level_at(self.level(direction, speed), position, time_s);
        level + direction * self.drag(viscous) * speed
    }
}
