//! What a position is read wrong by.

use super::periodogram::{Moment, Pitch, pitches};
use super::{Estimate, Screen};
use crate::effect::{EncoderPeriodicError, EncoderResolution, ScrewError};

/// The largest amplitude of a periodic error that a fit looks at, as a share of the travel. A screw or an encoder is a hundred times better (estimate):
/// this only keeps a fit from errors that would turn the reading back.
const LARGEST: f64 = 0.05;

/// The largest amplitude of a periodic error that a fit looks at, in m or rad.
pub fn largest(screen: &Screen) -> f64 {
    LARGEST * screen.travel()
}

impl Estimate for ScrewError {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        if screen.load_difference.is_empty() {
            return inverse(screen).into_iter().map(|start| [start, vec![0.0]].concat()).collect();
        }
        let found = pitches(screen, &screen.load_difference, columns, 3);
        // What only one flank does shows with half its size over both directions.
        let flanks = [(0.0, 1.0), (1.0, 2.0), (-1.0, 2.0)];
        let start = |pitch: &Pitch, (flank, share): (f64, f64)| {
            let sizes = pitch.coefficients.iter().map(|size| share * size);
            std::iter::once(pitch.period).chain(sizes).chain([flank]).collect()
        };
        found.iter().flat_map(|pitch| flanks.map(|flank| start(pitch, flank))).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let most = largest(screen);
        [vec![screen.period_range()], vec![(-most, most); 2], vec![(-1.0, 1.0)]].concat()
    }
}

impl Estimate for EncoderPeriodicError {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        inverse(screen)
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let most = largest(screen);
        [vec![screen.period_range()], vec![(-most, most); 2]].concat()
    }
}

impl Estimate for EncoderResolution {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let stated = screen.constants.as_ref().map_or(0.0, |c| c.encoder_step);
        // As fine as stated: nothing to explain, and a fit without a start is left out.
        screen.reading_step.filter(|step| *step > 1.5 * stated).map(|step| vec![step]).into_iter().collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, screen.travel())]
    }
}

/// The two columns of a periodic error of a position at `rate = 2π/p`.
fn columns(rate: f64, moment: Moment) -> [f64; 2] {
    let (s, c) = (rate * moment.position).sin_cos();
    [s, c]
}

/// Starting values (pitch, s, c) from the missing force.
///
/// # Model
/// A reading `x + e(x)` makes the inverse dynamics `m·a + c·v` wrong by `m·(e″·v² + e′·a) + c·e′·v`.
fn inverse(screen: &Screen) -> Vec<Vec<f64>> {
    let (mass, viscous) = (screen.moving_mass(), screen.viscous());
    let force = |rate: f64, m: Moment| {
        let (s, c) = (rate * m.position).sin_cos();
        let of = |slope: f64, curvature: f64| {
            mass * (curvature * m.velocity * m.velocity + slope * m.acceleration)
                + viscous * slope * m.velocity
        };
        [of(rate * c, -rate * rate * s), of(-rate * s, -rate * rate * c)]
    };
    let found = pitches(screen, &screen.missing_force, force, 4);
    let most = largest(screen);
    found
        .into_iter()
        .map(|pitch| {
            let sizes = pitch.coefficients.into_iter().map(|size| size.clamp(-most, most));
            std::iter::once(pitch.period).chain(sizes).collect()
        })
        .collect()
}
