//! A number that a fit may choose, and its prior.

use super::prior::TOLERANCE_SIGMAS;
use crate::effect::EffectId;

/// Why a number is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freedom {
    /// It belongs to an effect of the hypothesis.
    Cause,
    /// It is a stated constant, free inside its tolerance beside every hypothesis.
    Calibration,
}

/// Ranges over more decades than this are looked at in proportion to the value.
const WIDE: f64 = 1e3;

/// Whether a range is over decades.
pub(super) fn is_wide((low, high): (f64, f64)) -> bool {
    low > 0.0 && high > WIDE * low
}

/// One number that a fit may choose.
#[derive(Debug, Clone, PartialEq)]
pub struct Free {
    /// Effect through which it acts.
    pub effect: EffectId,
    /// Parameter key for this kind of axis.
    pub name: &'static str,
    /// Unit for this kind of axis.
    pub unit: &'static str,
    /// TOML key path.
    pub path: String,
    /// Why it is free.
    pub freedom: Freedom,
    /// Value that leaves the twin as stated.
    pub neutral: f64,
    /// Range of the fit.
    pub range: (f64, f64),
    /// Step by which it is varied and compared: about what a fit should resolve coarsely.
    pub scale: f64,
    /// Whether fits leave it where each start puts it.
    pub held: bool,
    /// What machines have of a number of a cause; none where nothing is known of it.
    pub prior: Option<LogNormal>,
}

/// A number whose logarithm is normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormal {
    /// Its median.
    pub median: f64,
    /// Standard deviation of ln(value/median).
    pub sd: f64,
}

impl LogNormal {
    /// The one that has 95 % of its values between these two, which are more than zero.
    pub(super) fn between((low, high): (f64, f64)) -> Self {
        Self { median: (low * high).sqrt(), sd: (high / low).ln() / (2.0 * TOLERANCE_SIGMAS) }
    }
}

impl Free {
    /// Unit of the steps by which a value is varied: its scale; of a period p that may be decades shorter than the longest one P no more than p²/P, which adds
    /// one period to the P/p that lie in P, or takes one away.
    pub fn reach(&self, value: f64) -> f64 {
        let one_more = value * value / self.range.1;
        if self.is_period() && is_wide(self.range) { self.scale.min(one_more) } else { self.scale }
    }

    /// How many standard deviations of its prior a number is off its median: the tolerance of a calibrated constant, what machines have
    /// of a number of a cause; zero where nothing is known of that.
    pub fn deviation(&self, value: f64) -> f64 {
        match (self.freedom, self.prior) {
            (Freedom::Calibration, _) => TOLERANCE_SIGMAS * (value - self.neutral) / self.scale,
            (Freedom::Cause, Some(LogNormal { median, sd })) => (value / median).ln() / sd,
            (Freedom::Cause, None) => 0.0,
        }
    }

    /// Derivative of [`deviation`](Self::deviation) by the value in units of its scale.
    pub(super) fn deviation_per_scale(&self, value: f64) -> f64 {
        match (self.freedom, self.prior) {
            (Freedom::Calibration, _) => TOLERANCE_SIGMAS,
            (Freedom::Cause, Some(LogNormal { sd, .. })) => self.scale / (value * sd),
            (Freedom::Cause, None) => 0.0,
        }
    }

    /// Whether it is a period or a frequency: searched among many, and nothing by itself.
    pub fn is_line(&self) -> bool {
        self.is_period() || self.name == "frequency_hz"
    }

    /// Whether it is a period over place.
    pub(super) fn is_period(&self) -> bool {
        self.name.starts_with("period_")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::units::Motion;

    /// A number of a cause, from −10 to 10, which leaves the twin as it is at zero.
    pub(in crate::diagnose) fn number(effect: EffectId, name: &'static str) -> Free {
        Free {
            effect,
            name,
            unit: "N",
            path: format!("effect.{}.{name}", effect.name()),
            freedom: Freedom::Cause,
            neutral: 0.0,
            range: (-10.0, 10.0),
            scale: 1.0,
            held: false,
            prior: None,
        }
    }

    /// A width of ten times what machines have at most is 1 + 2·ln 10/ln 30 times as far off as that; one that a file states has no such prior.
    #[test]
    fn exact_a_range_is_of_what_is_not_stated() {
        let width = EffectId::LocalFriction.parameters()[2];
        let range = |stated: f64| width.usual.and_then(|usual| usual.range(Motion::Prismatic, stated));
        let of = |stated: f64| range(stated).map(LogNormal::between);
        let free =
            Free { neutral: f64::NAN, prior: of(f64::NAN), ..number(EffectId::LocalFriction, width.name) };
        for (value, expected) in
            [(0.150, 2.0), (0.005, -2.0), (1.5, 2.0 * (1.0 + 2.0 * 10.0_f64.ln() / 30.0_f64.ln()))]
        {
            assert!((free.deviation(value) - expected).abs() < 1e-12);
        }
        assert_eq!(of(0.3), None);
    }

    /// A period of 20 µm within 80 mm is varied by what makes 4001 of them, or 3999; one of 10 mm by no more than its scale.
    #[test]
    fn exact_a_period_is_varied_by_one_of_the_longest() {
        let period =
            Free { range: (1e-6, 0.08), scale: 1e-4, ..number(EffectId::EncoderPeriodicError, "period_m") };
        let turned = |period: f64, by: f64| 0.08 / period - 0.08 / (period + by);
        assert!((turned(20e-6, period.reach(20e-6)) - 1.0).abs() < 1e-3);
        assert!((period.reach(0.01) - period.scale).abs() < 1e-12);
        // Inside its tolerance a stated one has that.
        let calibrated = Free { range: (1.9e-5, 2.1e-5), ..period.clone() };
        let others = [calibrated, number(EffectId::Cogging, "sine_n")];
        assert!(others.iter().all(|free| (free.reach(20e-6) - free.scale).abs() < 1e-12));
    }

    /// A force constant that is off by √3 is two standard deviations off, either way; the derivative is that of differences.
    #[test]
    fn exact_a_factor_is_off_by_its_logarithm() {
        let parameter = EffectId::ForceConstant.parameters()[0];
        let usual = parameter.usual.and_then(|usual| usual.range(Motion::Prismatic, 1.0));
        let prior = usual.map(LogNormal::between);
        let of_factor = number(EffectId::ForceConstant, parameter.name);
        let free = Free { neutral: 1.0, range: (0.01, 100.0), scale: 0.1, prior, ..of_factor };
        for (value, expected) in [(3.0_f64.sqrt(), 2.0), (1.0, 0.0), (3.0_f64.sqrt().recip(), -2.0)] {
            assert!((free.deviation(value) - expected).abs() < 1e-12);
            let step = 1e-6;
            let slope = (free.deviation(value + step * free.scale)
                - free.deviation(value - step * free.scale))
                / (2.0 * step);
            assert!((free.deviation_per_scale(value) - slope).abs() < 1e-6);
        }
    }
}
