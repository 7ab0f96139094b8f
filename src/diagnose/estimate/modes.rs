//! Modes of base and structure.

use super::resonance::resonances;
use super::{Estimate, Screen};
use crate::effect::{BaseModeShift, FlexibleMode};

impl Estimate for BaseModeShift {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let modes = screen.constants.as_ref().map_or(&[][..], |c| c.modes.as_slice());
        let numbered = || (1..).map(f64::from).zip(modes);
        // Where the missing force rings, a mode may have come to stand; else a coarse grid.
        let seen = resonances(screen, 1);
        let rings = seen.iter().flat_map(|resonance| {
            numbered().map(|(number, mode)| vec![number, resonance.frequency_hz / mode.frequency_hz(), 1.0])
        });
        let grid = numbered().flat_map(|(number, _)| {
            [0.3, 0.45, 0.6, 0.85, 0.97, 1.15, 1.6, 2.5].map(|factor| vec![number, factor, 1.0])
        });
        rings.chain(grid).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let count = screen.constants.as_ref().map_or(1, |c| c.modes.len().max(1));
        vec![(1.0, count as f64), (0.2, 5.0), (0.1, 10.0)]
    }
}

impl Estimate for FlexibleMode {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        let nyquist = 0.5 / screen.sample_period_s();
        let (least, most) = (0.1 * screen.moving_mass(), 1e3 * screen.moving_mass());
        let seen =
            resonances(screen, 4).into_iter().map(|r| vec![r.frequency_hz, r.mass.clamp(least, most), 0.03]);
        // Above what the missing force passes, a coarse grid.
        let beyond = (0..10).map(|k| 90.0 * 1.3_f64.powi(k)).filter(|frequency| *frequency < 0.7 * nyquist);
        seen.chain(beyond.map(|frequency| vec![frequency, 8.0 * screen.moving_mass(), 0.03])).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        let (mass, nyquist) = (screen.moving_mass(), 0.5 / screen.sample_period_s());
        vec![(1.0, 0.8 * nyquist), (0.05 * mass, 1e4 * mass), (1e-3, 0.7)]
    }
}
