//! A scale or a screw that grows as it warms.

use super::{digits, on_steps, reading_steps, remade};
use crate::effect::Prior;
use crate::error::Result;
use crate::machine::Machine;
use crate::recording::{Run, Signal};
use rand::RngExt;
use rand::rngs::StdRng;
use serde::{Deserialize, Serialize};

/// A linear scale, or the screw before it, that grows during the session, which begins after a cold start.
///
/// # Model
/// With the time t of the session and the place x that the sensor would show cold, counted from the axis' zero, where
/// the scale is fixed:
/// ```text
///   reading = x·(1 + α·ΔT∞·s(t)) + z∞·s(t)        s(t) = 1 − e^(−t/τ)
/// ```
/// z∞ is how far the mounting point moves. A scale that grows has its marks further apart and shows less: α is negative.
/// A screw between the encoder and a cold scale at the load takes the load further: α is positive.
///
/// Where the position loop is closed on the sensor, the controller sees the reading: the forged plant shows it in the place
/// of its position. An encoder beside it stays cold: its readings are taken back to the place when they are logged. Forces of
/// position that the twin's walk applies are then taken beside the place, by at most 0.035 % of x and some µm: far
/// below every period of such a force. The forged plant's own laws are taken at the place.
///
/// # Validity
/// A sensor alone in the loop shows what the controller wants, warm or cold: only forces are off, by the ppm of α·ΔT. The effect
/// shows between two sensors; see [`ForeignKind::shows`](super::ForeignKind::shows). The rate of growth, some nm/s, is
/// neglected in velocities.
///
/// # Ranges
/// |α|: 8 (glass), 10 and 11.5 (steel), 23 ppm/K (aluminium); ΔT∞: 1–15 K; z∞: up to 8 µm to either side. τ: 5–60 min, but
/// no more than thirty sessions or six minutes, whichever is longer: in a session of seconds, some per cent of
/// the growth are all that is seen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct WarmingScale {
    /// Which sensor shows it.
    pub sensor: WarmSensor,
    /// α in ppm/K.
    pub expansion_ppm_per_k: f64,
    /// ΔT∞ in K.
    pub warming_k: f64,
    /// τ in s.
    pub time_constant_s: f64,
    /// z∞ in m.
    pub zero_m: f64,
}

/// The sensor that shows the growth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarmSensor {
    /// The axis' own and only one, on which its loops are closed.
    Own,
    /// The second one at the load, which is only logged.
    Load,
    /// The second one at the load, on which the position loop is closed.
    LoadInLoop,
}

impl WarmSensor {
    /// The one that a machine has: the second sensor where there is one.
    pub fn of(machine: &Machine) -> Self {
        match &machine.description().load_sensor {
            None => Self::Own,
            Some(sensor) if sensor.closes_position_loop => Self::LoadInLoop,
            Some(_) => Self::Load,
        }
    }

    /// Whether the position loop is closed on it.
    pub fn is_in_loop(self) -> bool {
        self != Self::Load
    }
}

const EXPANSIONS_PPM_PER_K: [f64; 4] = [8.0, 10.0, 11.5, 23.0];
const WARMINGS_K: (f64, f64) = (1.0, 15.0);
const TIME_CONSTANTS_S: (f64, f64) = (300.0, 3600.0);
/// The longest time constant as sessions, and what it is at least, in s.
const MOST_SESSIONS: f64 = 30.0;
const LEAST_LONGEST_S: f64 = 360.0;
const MOST_ZERO_M: f64 = 8e-6;

impl WarmingScale {
    /// Draws the growth that a sensor shows in a session of `session_s`.
    pub fn draw(sensor: WarmSensor, session_s: f64, random: &mut StdRng) -> Self {
        let expansion = EXPANSIONS_PPM_PER_K[random.random_range(0..EXPANSIONS_PPM_PER_K.len())];
        let is_screw = Prior::new(random).sign() > 0.0 && sensor != WarmSensor::Own;
        let longest_s = (MOST_SESSIONS * session_s).min(TIME_CONSTANTS_S.1).max(LEAST_LONGEST_S);
        Self {
            sensor,
            expansion_ppm_per_k: if is_screw { expansion } else { -expansion },
            warming_k: digits(random.random_range(WARMINGS_K.0..WARMINGS_K.1)),
            time_constant_s: digits(Prior::new(random).log_uniform(TIME_CONSTANTS_S.0, longest_s)),
            zero_m: digits(random.random_range(-MOST_ZERO_M..MOST_ZERO_M)),
        }
    }

    /// Growth α·ΔT and shift of the zero in m at a time of the session in s.
    ///
    /// ```
    /// use slideway::trial::foreign::{WarmSensor, WarmingScale};
    /// let scale = WarmingScale {
    ///     sensor: WarmSensor::Load,
    ///     expansion_ppm_per_k: 10.0,
    ///     warming_k: 4.0,
    ///     time_constant_s: 600.0,
    ///     zero_m: 2e-6,
    /// };
    /// let half_warm_s = 600.0 * 2.0_f64.ln();
    /// let [growth, zero_m] = scale.growth(half_warm_s);
    /// assert!((growth - 20e-6).abs() < 1e-18 && (zero_m - 1e-6).abs() < 1e-18);
    /// assert_eq!(scale.growth(-1.0), [0.0, 0.0]);
    /// ```
    pub fn growth(&self, clock_s: f64) -> [f64; 2] {
        let share = -(-clock_s.max(0.0) / self.time_constant_s).exp_m1();
        [1e-6 * self.expansion_ppm_per_k * self.warming_k * share, self.zero_m * share]
    }

    /// The reading in m of a place in m at a time of the session in s.
    pub fn reading(&self, place: f64, clock_s: f64) -> f64 {
        let [growth, zero] = self.growth(clock_s);
        place * (1.0 + growth) + zero
    }

    /// The place in m of a reading in m at a time of the session in s.
    pub fn place(&self, reading: f64, clock_s: f64) -> f64 {
        let [growth, zero] = self.growth(clock_s);
        (reading - zero) / (1.0 + growth)
    }

    /// What is logged of a run: readings of the second sensor warm, those of an encoder beside it cold.
    pub(super) fn logged(&self, run: &Run, machine: &Machine) -> Result<Run> {
        let shown = |signal: Signal, value: f64, clock_s: f64| match (self.sensor, signal) {
            (WarmSensor::Load, Signal::LoadPosition) => self.reading(value, clock_s),
            (WarmSensor::LoadInLoop, Signal::Position) => self.place(value, clock_s),
            (WarmSensor::LoadInLoop, Signal::Velocity) => value / (1.0 + self.growth(clock_s)[0]),
            _ => value,
        };
        let mut signals = run.signals().clone();
        for (signal, samples) in &mut signals {
            let steps = reading_steps(*signal, machine);
            for (k, sample) in samples.iter_mut().enumerate() {
                let clock_s = run.begins_s + k as f64 * run.sample_period_s();
                let value = shown(*signal, *sample, clock_s);
                if value != *sample {
                    *sample = on_steps(value, steps);
                }
            }
        }
        remade(run, signals, run.extra_columns().clone())
    }
}
