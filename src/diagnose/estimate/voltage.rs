//! What the amplifier does to the voltage.

use super::{Estimate, Screen};
use crate::effect::{AmplifierOffset, DeadZone, VoltageSaturation};

/// Below this share of the largest effort the motor did not get what was asked for, whatever its noise: a choice of cost.
const WOUND_UP: f64 = 0.8;

impl Estimate for VoltageSaturation {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // The gradient is zero above the largest voltage: start below it, at several depths. Only the tips of a few peaks may be
        // clipped; or the effort that is logged winds up far beyond the limit, and the largest force tells what the motor got.
        let most = screen.largest_voltage();
        let got = screen.largest_force / screen.force_per_volt();
        // The largest current has noise on it.
        let shown = [1.0, 0.95].map(|share| share * got).into_iter();
        let shown = shown.filter(|volts| (f64::MIN_POSITIVE..WOUND_UP * most).contains(volts));
        let depths = [0.995, 0.98, 0.95, 0.9, 0.8, 0.7, 0.5, 0.3, 0.2, 0.12, 0.07];
        depths.iter().map(|share| share * most).chain(shown).map(|volts| vec![volts]).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.02 * screen.largest_voltage(), 1.02 * screen.largest_voltage())]
    }
}

impl Estimate for DeadZone {
    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // Beside a loop that hunts in its dead zone, a fit from a wide one may never come to a narrow one.
        [3e-4, 1e-3, 3e-3, 0.01, 0.05, 0.2]
            .iter()
            .map(|share| vec![share * screen.largest_voltage()])
            .collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(0.0, screen.largest_voltage())]
    }
}

impl Estimate for AmplifierOffset {
    const CUMULATIVE: bool = true;

    fn start(screen: &Screen) -> Vec<Vec<f64>> {
        // Friction that holds the axis at one offset and not at another one bends the way from zero to a large one.
        let shown = screen.missing_voltage.or_else(|| {
            // Without a current the force was computed from the voltage, and lacks what the offset makes.
            screen.four_coefficients().map(|[.., constant]| constant / screen.force_per_volt())
        });
        std::iter::once(0.0).chain(shown).map(|volts| vec![volts]).collect()
    }

    fn range(screen: &Screen) -> Vec<(f64, f64)> {
        vec![(-screen.largest_voltage(), screen.largest_voltage())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An effort that winds up to three times what the force shows: the limit is looked for there too.
    #[test]
    fn exact_a_limit_is_looked_for_at_what_the_force_shows() {
        let screen =
            |largest_force: f64| Screen { largest_force, largest_effort_v: 4.5, ..Screen::default() };
        let [wound_up, followed] = [0.33, 0.9].map(|share| {
            let force = share * 4.5 * screen(1.0).force_per_volt();
            VoltageSaturation::start(&screen(force)).into_iter().flatten().collect::<Vec<f64>>()
        });
        assert_eq!([wound_up.len(), followed.len()], [13, 11]);
        assert!((wound_up[11] - 1.485).abs() < 1e-12 && (wound_up[12] - 1.41075).abs() < 1e-12);
    }

    /// A loop that holds against an offset logs more voltage than any force takes.
    #[test]
    fn exact_an_offset_is_looked_for_up_to_the_logged_effort() {
        let screen = Screen {
            largest_force: 0.01,
            largest_effort_v: 0.05,
            missing_voltage: Some(-0.042),
            ..Screen::default()
        };
        assert_eq!(AmplifierOffset::range(&screen), [(-0.05, 0.05)]);
        assert_eq!(AmplifierOffset::start(&screen), [[0.0], [-0.042]]);
    }
}
