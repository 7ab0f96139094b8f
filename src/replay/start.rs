//! How a recorded run begins, read off its first samples.

use crate::drive::motor::Circuit;
use crate::effect::Constants;
use crate::machine::Machine;
use crate::plant::Plant;
use crate::recording::{Kinematics, Run, Signal};
use crate::sensor::LogScale;
use crate::twin::{InitialForces, Twin};
use statrs::statistics::Statistics;

/// How a recorded run begins, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Position at the first sample.
    pub position: f64,
    /// Velocity at the first sample; exactly zero where the run begins at rest.
    pub velocity: f64,
    /// Acceleration at the first sample, where enough samples tell it; zero at rest and where their scatter explains it.
    pub acceleration: Option<f64>,
    /// Commanded voltage at the first sample, where it was logged.
    pub effort_v: Option<f64>,
    /// Commanded voltage of an axis that rests, mean over the first samples; none where it was not logged, the drive is off or the run begins in motion.
    pub resting_effort_v: Option<f64>,
    /// Motor current at the first sample, where it was logged.
    pub current: Option<f64>,
    /// Half width in A of the interval of that current; without limit where the axis rests steadily, and its effort tells the current.
    pub current_interval: f64,
    /// Position and velocity that the controller saw at the first sample, where its effort is that of one sample
    /// and not a mean.
    pub reading: Option<(f64, f64)>,
    /// What the second sensor shows at the first sample, where there is one.
    pub load_position: Option<f64>,
    /// Voltage fed forward beside the effort at the first sample.
    pub feedforward_v: f64,
    /// Supply of an amplifier that is commanded by a duty cycle at the first sample, in V, where it was logged.
    pub supply_v: Option<f64>,
}

/// Samples at the beginning of a moving run from which its start is read.
pub(super) const START_SAMPLES: usize = 8;
/// A torque-enable signal from here on says that the drive is on.
pub(super) const ENABLED: f64 = 0.5;
/// A parabola through fewer samples says nothing of its scatter.
const FEWEST_SAMPLES: usize = 5;
/// Time in s over which a moving run's acceleration is read, where that is more than [`START_SAMPLES`]: as long as the window around
/// a cut in a longer run. Position noise of 42 nm at 4 kHz then leaves a standard error of 3 mm/s².
const ACCELERATION_S: f64 = 8e-3;
/// A mean current that is off by more standard errors from what the effort makes has not settled: noise of [`START_SAMPLES`] normal samples does that in
/// 2 % of the starts (Student's t).
const UNSETTLED_STANDARD_ERRORS: f64 = 3.0;
/// At most so much standstill is averaged, in s.
const REST_S: f64 = 0.1;

impl Start {
    /// Reads the start off the first samples: means over the standstill before the reference first moves, else
    /// a parabola through the first positions.
    pub fn of(run: &Run, reference: &[f64], position: &[f64]) -> Self {
        let period = run.sample_period_s();
        let still = reference.iter().take_while(|r| **r == reference[0]).count();
        let still = still.min((REST_S / period) as usize);
        let effort = run.signal(Signal::ControlEffort);
        let drives = run.signal(Signal::TorqueEnabled).is_none_or(|enabled| enabled[0] >= ENABLED);
        if still >= START_SAMPLES
            && is_steady(&position[..still])
            && effort.is_none_or(|effort| is_steady(&effort[..still]))
        {
            let mean = |samples: &[f64]| samples[..still].mean();
            return Self {
                position: mean(position),
                velocity: 0.0,
                acceleration: Some(0.0),
                effort_v: effort.map(mean),
                resting_effort_v: effort.filter(|_| drives).map(mean),
                current: run.signal(Signal::Current).map(mean),
                current_interval: f64::INFINITY,
                reading: None,
                load_position: run.signal(Signal::LoadPosition).map(mean),
                feedforward_v: 0.0,
                supply_v: run.signal(Signal::SupplyVoltage).map(mean),
            };
        }
        let count = position.len().min(START_SAMPLES);
        let mean = |samples: &[f64]| samples[..count].mean();
        let moving = moving_start(run, position);
        // What was cut out of a longer run begins in a state that is known better.
        let (position, velocity, acceleration) = match run.entry() {
            Some([position, velocity, acceleration]) => (position, velocity, Some(acceleration)),
            None => moving.unwrap_or((mean(position), 0.0, Some(0.0))),
        };
        let moves = velocity != 0.0;
        let first_of = |signal| run.signal(signal).and_then(|samples| samples.first().copied());
        Self {
            position,
            velocity,
            acceleration,
            effort_v: first_of(Signal::ControlEffort),
            resting_effort_v: effort.filter(|_| drives && !moves).map(mean),
            current: match run.signal(Signal::Current) {
                // One sample of a noisy current would kick the axis; at rest a few milliseconds change little.
                Some(current) if !moves => Some(mean(current)),
                _ => first_of(Signal::Current),
            },
            current_interval: run
                .signal(Signal::Current)
                .map_or(0.0, |current| UNSETTLED_STANDARD_ERRORS * standard_error(&current[..count])),
            reading: first_of(Signal::Position).zip(first_of(Signal::Velocity)),
            load_position: first_of(Signal::LoadPosition),
            feedforward_v: 0.0,
            supply_v: first_of(Signal::SupplyVoltage),
        }
    }

    /// The start as it was, of one that was logged in these scales.
    #[must_use]
    pub fn unscaled(self, scale: LogScale) -> Self {
        let effort = |u: Option<f64>| u.map(|u| u / scale.effort);
        Self {
            effort_v: effort(self.effort_v),
            resting_effort_v: effort(self.resting_effort_v),
            current: self.current.map(|i| i / scale.current),
            current_interval: self.current_interval / scale.current.abs(),
            ..self
        }
    }

    /// Voltage commanded to the amplifier at the first sample, where the effort was logged.
    pub fn commanded_v(&self) -> Option<f64> {
        self.effort_v.map(|effort_v| effort_v + self.feedforward_v)
    }

    /// The motor's current in A, positive where it drives the axis in its positive direction; 0 of a motor without a winding or where nothing tells it.
    ///
    /// # Model
    /// The current that the effort u settles at, with u_ff fed forward, the amplifier's gain s and its output as in
    /// [`Amplifier`](crate::drive::amplifier::Amplifier):
    /// ```text
    ///   i = (s·output(u + u_ff) − Ke·v)/R
    /// ```
    /// An axis that rests begins with it. Dry friction holds it against the motor's force, and a force that is off by the noise of a current sensor would
    /// let bristles give way as soon as the twin's own drive replaces it. Where the start is no steady rest, the logged current counts if it is beyond its
    /// interval from there; so it does of an axis in motion, and what the effort settles at only where no current was logged.
    ///
    /// # Validity
    /// Settled winding and amplifier. Logged currents that are all alike within the first samples, of a coarse sensor, count as exact.
    ///
    /// # Source
    /// Voltage balance of the winding at di/dt = 0.
    pub fn current_a(&self, constants: &Constants) -> f64 {
        let settled = |effort_v: f64| match constants.circuit {
            Circuit::Winding { resistance_ohm, back_emf, .. } => {
                let amplifier = &constants.amplifier;
                let commanded_v = effort_v + self.feedforward_v;
                let applied_v = amplifier.gain_under(self.supply_v) * amplifier.output_v(commanded_v);
                (applied_v - back_emf * self.velocity) / resistance_ohm
            }
            Circuit::Direct { .. } => 0.0,
        };
        match (self.resting_effort_v.map(settled), self.current) {
            (Some(resting), Some(current)) if (resting - current).abs() > self.current_interval => current,
            (Some(resting), _) => resting,
            (None, current) => current.or_else(|| self.effort_v.map(settled)).unwrap_or(0.0),
        }
    }

    /// The motor's force or torque in proportion to its current, in N or N·m.
    pub fn motor_force(&self, constants: &Constants) -> f64 {
        match constants.circuit {
            Circuit::Winding { force_constant, .. } => force_constant * self.current_a(constants),
            Circuit::Direct { force_per_volt } => {
                let amplifier = &constants.amplifier;
                let gain = amplifier.gain_under(self.supply_v);
                let applied_v = |commanded_v| gain * amplifier.output_v(commanded_v);
                force_per_volt * self.commanded_v().map_or(0.0, applied_v)
            }
        }
    }

    /// Sets a twin that was started here: its current, its clock, and the initial state of its friction.
    pub(super) fn initialise<P: Plant>(&self, twin: &mut Twin<P>, machine: &Machine, begins_s: f64) {
        let constants = machine.constants();
        twin.set_current(self.current_a(&constants));
        twin.set_clock(begins_s);
        let (motor, weight) = (self.motor_force(&constants), machine.weight());
        let taken = |acceleration| constants.moving_mass * acceleration + constants.viscous * self.velocity;
        twin.initialise_friction(InitialForces {
            motor,
            weight: weight.map_or(0.0, |weight| weight.effort(twin.state()[0])),
            inertial: self.acceleration.map(taken),
        });
    }
}

/// Standard error of the mean of samples that scatter.
fn standard_error(samples: &[f64]) -> f64 {
    (samples.variance() / samples.len() as f64).sqrt()
}

/// Halves of a standstill whose means differ by more standard errors are no steady state.
const STEADY_STANDARD_ERRORS: f64 = 6.0;

/// Whether a standstill shows scatter about one value, not a transient.
pub fn is_steady(samples: &[f64]) -> bool {
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let (first, second) = samples.split_at(samples.len() / 2);
    let (a, b) = (mean(first), mean(second));
    let squares = |part: &[f64], m: f64| part.iter().map(|x| (x - m) * (x - m)).sum::<f64>();
    let variance = (squares(first, a) + squares(second, b)) / samples.len() as f64;
    let rounding = 1e-12 * a.abs();
    (a - b).abs() <= STEADY_STANDARD_ERRORS * (4.0 * variance / samples.len() as f64).sqrt() + rounding
}

/// Position, velocity and acceleration at the first sample of a run that begins in motion; none for one that begins at rest. The
/// acceleration is none where too few samples tell it.
fn moving_start(run: &Run, position: &[f64]) -> Option<(f64, f64, Option<f64>)> {
    let fit = |count: usize| {
        let count = count.min(position.len());
        let times_s = (0..count).map(|row| run.time_s(row) - run.time_s(0));
        Kinematics::fit(times_s, &position[..count]).filter(|_| count >= FEWEST_SAMPLES)
    };
    let start = fit(START_SAMPLES)?;
    let velocity = start.significant_velocity()?;
    let longer = fit(START_SAMPLES.max((ACCELERATION_S / run.sample_period_s()).round() as usize));
    let acceleration = longer.map(|fit| fit.significant_acceleration().unwrap_or(0.0));
    Some((start.state[0], velocity, acceleration))
}
