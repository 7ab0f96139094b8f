//! Forces that repeat along the axis.

use super::periodogram::{Moment, pitches};
use super::{Estimate, Screen};
use crate::effect::{Cogging, ForceRipple, SecondCogging, SecondForceRipple, ThirdCogging};

/// The four columns of a force of two harmonics at `rate = 2π/p`.
fn columns(rate: f64, moment: Moment) -> [f64; 4] {
    let (s, c) = (rate * moment.position).sin_cos();
    [s, c, 2.0 * s * c, 1.0 - 2.0 * s * s]
}

impl Estimate for ForceRipple {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let scaled = |rate: f64, m: Moment| columns(rate, m).map(|column| column * m.drive_force).to_vec();
        let found = pitches(screen, &screen.missing_drive_force, scaled, 3);
        let bounded = |share: f64| share.clamp(-0.5, 0.5);
        found
            .into_iter()
            .map(|pitch| {
                let shares = pitch.coefficients.into_iter().map(bounded);
                std::iter::once(pitch.period).chain(shares).collect()
            })
            .collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        [vec![screen.period_range()], vec![(-0.9, 0.9); 4]].concat()
    }
}

impl Estimate for Cogging {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let found = pitches(screen, &screen.missing_force, |rate, m| columns(rate, m).to_vec(), 3);
        found.into_iter().map(|pitch| [vec![pitch.period], pitch.coefficients].concat()).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let force = screen.largest_force;
        [vec![screen.period_range()], vec![(-force, force); 4]].concat()
    }
}

/// Further pitches are looked for as the first one is.
macro_rules! further {
    ($($name:ident: $law:ident),+ $(,)?) => {
        $(impl Estimate for $name {
            fn start(screen: &Screen) -> Vec<Vec<f64>> {
                <$law as Estimate>::start(screen)
            }

            fn range(screen: &Screen) -> Vec<(f64, f64)> {
                <$law as Estimate>::range(screen)
            }
        })+
    };
}

further! {
    SecondForceRipple: ForceRipple,
    SecondCogging: Cogging,
    ThirdCogging: Cogging,
}
