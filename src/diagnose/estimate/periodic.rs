//! Forces that repeat along the axis.

use super::periodogram::{Moment, Pitch, pitches};
use super::pitch_set::pitch_sets;
use super::{Estimate, Screen};
use crate::effect::{Cogging, ForceRipple, SecondCogging, SecondForceRipple, ThirdCogging};

/// The four columns of a force of two harmonics at `rate = 2π/p`.
fn columns(rate: f64, moment: Moment) -> [f64; 4] {
    let (s, c) = (rate * moment.position).sin_cos();
    [s, c, 2.0 * s * c, 1.0 - 2.0 * s * s]
}

/// Starts of the share of a ripple: no fit begins where the motor pulls backwards.
fn bounded(coefficients: Vec<f64>) -> Vec<f64> {
    coefficients.into_iter().map(|share| share.clamp(-0.5, 0.5)).collect()
}

fn ripple_columns(rate: f64, m: Moment) -> [f64; 4] {
    columns(rate, m).map(|column| column * m.drive_force)
}

/// Pitch and coefficients as a law has them.
fn values(Pitch { period, coefficients, .. }: Pitch) -> Vec<f64> {
    [vec![period], coefficients].concat()
}

impl Estimate for ForceRipple {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let found = pitches(screen, &screen.missing_drive_force, ripple_columns, 3);
        found.into_iter().map(|p| values(Pitch { coefficients: bounded(p.coefficients), ..p })).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        [vec![screen.pitch_range()], vec![(-0.9, 0.9); 4]].concat()
    }
}

impl Estimate for Cogging {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let found = pitches(screen, &screen.missing_force, columns, 3);
        found.into_iter().map(values).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let force = screen.largest_force;
        [vec![screen.pitch_range()], vec![(-force, force); 4]].concat()
    }
}

/// So many pitches of cogging together.
fn coggings(screen: &Screen, count: usize) -> Vec<Vec<Vec<f64>>> {
    let sets = pitch_sets(screen, &screen.missing_force, columns, count);
    sets.into_iter().map(|set| set.into_iter().map(values).collect()).collect()
}

/// So many pitches of force ripple together.
fn ripples(screen: &Screen, count: usize) -> Vec<Vec<Vec<f64>>> {
    let sets = pitch_sets(screen, &screen.missing_drive_force, ripple_columns, count);
    let shares = |p: Pitch| values(Pitch { coefficients: bounded(p.coefficients), ..p });
    sets.into_iter().map(|set| set.into_iter().map(shares).collect()).collect()
}

/// Further pitches are looked for as the first one is, alone and together with those before.
macro_rules! further {
    ($($name:ident: $law:ident, $together:ident of $count:literal),+ $(,)?) => {
        $(impl Estimate for $name {
            fn start(screen: &Screen) -> Vec<Vec<f64>> {
                <$law as Estimate>::start(screen)
            }

            fn range(screen: &Screen) -> Vec<(f64, f64)> {
                <$law as Estimate>::range(screen)
            }

            fn together(screen: &Screen) -> Vec<Vec<Vec<f64>>> {
                $together(screen, $count)
            }
        })+
    };
}

further! {
    SecondForceRipple: ForceRipple, ripples of 2,
    SecondCogging: Cogging, coggings of 2,
    ThirdCogging: Cogging, coggings of 3,
}
