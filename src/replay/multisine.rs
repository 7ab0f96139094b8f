//! Periodic excitations that stay within a machine's limits, predicted linearly and checked on the twin.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;
use realfft::RealFftPlanner;

use super::{PlantChoice, Traces, run};
use crate::drive::motor::Circuit;
use crate::error::{Error, ErrorKind, Result};
use crate::machine::Machine;
use crate::plant::axis::{Axis, SampledResponse};
use crate::plant::{Plant, mujoco::MujocoRig, rapier::Rig};
use crate::twin::{Command, LinearLoop, Sensing, Twin};

/// Where an excitation enters the loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Injection {
    /// Voltage added between controller and amplifier.
    Voltage,
    /// The position reference.
    Reference,
}

/// How its power is spread over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wave {
    /// Every line all the time, phases after Schroeder.
    Multisine,
    /// One line after the other, up the band within each period.
    Sweep,
}

/// What the machine may be asked to do, each to both sides of zero; none: not limited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// In m or rad, from the middle of the travel.
    pub position: Option<f64>,
    /// In m/s or rad/s.
    pub velocity: Option<f64>,
    /// In V.
    pub effort_v: Option<f64>,
    /// In N or N·m.
    pub thrust: Option<f64>,
    /// Injected voltage in V. Below the loop's bandwidth the controller takes most of it back, so that effort alone would not
    /// limit it.
    pub injected_v: Option<f64>,
}

impl Limits {
    /// A share of what joint and amplifier allow; as injected voltage all that the machine can use.
    pub fn of(machine: &Machine, share: f64) -> Self {
        let joint = &machine.solid().joint;
        let limited = |limit: f64| (limit.is_finite() && limit > 0.0).then_some(share * limit);
        Self {
            position: limited(joint.half_travel()),
            velocity: limited(joint.velocity),
            effort_v: machine.constants().effort_limit_v().and_then(limited),
            thrust: limited(joint.effort),
            injected_v: usable_voltage(machine),
        }
    }

    /// The largest factor on `peaks` that stays within the limits; none where nothing limits it.
    fn factor(&self, peaks: &Peaks) -> Option<f64> {
        [
            (self.position, peaks.position),
            (self.velocity, peaks.velocity),
            (self.effort_v, peaks.effort_v),
            (self.thrust, peaks.thrust),
        ]
        .into_iter()
        .filter_map(|(limit, peak)| limit.map(|limit| limit / peak.max(f64::MIN_POSITIVE)))
        .reduce(f64::min)
    }
}

/// The amplifier's voltage where it is stated; else the voltage of the joint's largest force, else of a stroke's ramp to the
/// joint's speed.
fn usable_voltage(machine: &Machine) -> Option<f64> {
    let (joint, constants) = (&machine.solid().joint, machine.constants());
    let usable = |limit: &f64| limit.is_finite() && *limit > 0.0;
    if let Some(limit) = constants.amplifier.voltage_limit_v.filter(usable) {
        return Some(limit);
    }
    let ramp_s = machine.description().reference.acceleration_time_s;
    let of_ramp = (constants.moving_mass / ramp_s + constants.viscous) * joint.velocity;
    let force = Some(joint.effort).filter(usable).or(Some(of_ramp).filter(usable))?;
    let volt_per_force = match constants.circuit {
        Circuit::Direct { force_per_volt } => force_per_volt.recip(),
        Circuit::Winding { resistance_ohm, force_constant, .. } => resistance_ohm / force_constant,
    };
    Some(force * volt_per_force.abs()).filter(usable)
}

/// Largest magnitudes of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peaks {
    /// Encoder position in m or rad, from where the axis stood.
    pub position: f64,
    /// Velocity in m/s or rad/s.
    pub velocity: f64,
    /// Effort in V.
    pub effort_v: f64,
    /// Motor force in N or N·m.
    pub thrust: f64,
}

/// What an excitation shall be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Lowest and highest frequency in Hz.
    pub band_hz: [f64; 2],
    /// Distance of the lines in Hz: one over the period.
    pub resolution_hz: f64,
    /// Where it enters.
    pub injection: Injection,
    /// How its power is spread over time.
    pub wave: Wave,
    /// What the machine may be asked to do.
    pub limits: Limits,
}

impl Request {
    /// Refuses what would take more than ten million samples.
    ///
    /// # Errors
    /// So many periods that are longer together.
    pub fn check_length(&self, periods: usize, sample_period_s: f64) -> Result<()> {
        let samples = periods as f64 / (self.resolution_hz * sample_period_s);
        if samples <= MOST_SAMPLES {
            return Ok(());
        }
        Err(Error::new(ErrorKind::OutOfRange)
            .key("--resolution")
            .found(format!("{} Hz: {samples:.3e} samples in {periods} periods", self.resolution_hz))
            .expected("at most ten million samples")
            .remedy("give a coarser --resolution, or play fewer periods"))
    }
}

/// A periodic excitation for a machine.
///
/// # Model
/// ```text
///   w[i] = A·Σ cos(2π·k_j·i/N + φ_j),   φ_j = −π·j·(j − 1)/J       lines k_1 … k_J, equal amplitudes
/// ```
/// on the whole lines of a period of N samples inside the band; a sweep is a sine whose frequency rises in proportion to time
/// from end to end of the band, cut to those lines. A is the largest with which position, velocity, effort and
/// thrust stay within the limits: in the steady state of the [`LinearLoop`] first, then on the reduced axis with all its laws
/// from standstill, where it is made smaller if a peak exceeds its limit. The axis stands in the middle of its travel.
///
/// # Source
/// Schroeder (1970), *Synthesis of low-peak-factor signals*, IEEE Trans. Information Theory 16, for equal amplitudes.
#[derive(Debug, Clone, PartialEq)]
pub struct Multisine {
    /// One period, in V, m or rad; a reference from where the axis stands.
    pub period: Vec<f64>,
    /// Where the axis stands before, in m or rad: the middle of its travel.
    pub centre: f64,
    /// Excited lines: whole turns in a period.
    pub lines: Vec<usize>,
    /// Where it enters.
    pub injection: Injection,
    /// Sample period in s.
    pub sample_period_s: f64,
    /// Peaks that the linear loop predicts in the steady state.
    pub predicted: Peaks,
    /// Peaks of the twin on the reduced axis, from standstill.
    pub simulated: Peaks,
}

/// Periods in which the start is looked at.
const CHECKED_PERIODS: usize = 3;
/// Times that the amplitude is made smaller after a simulation.
const CORRECTIONS: usize = 4;
/// Where nothing limits an excitation: peak voltage in V, or reference in m or rad.
const WITHOUT_LIMITS: [f64; 2] = [1.0, 1e-3];
/// Most samples of a period, and of all periods that are played.
const MOST_SAMPLES: f64 = 1e7;

impl Multisine {
    /// The excitation of a machine's closed loop.
    ///
    /// # Errors
    /// A machine without a controller, a loop that is unstable, a band that does not lie between 0 and half the sampling rate or
    /// holds no line, a resolution that is not > 0.
    pub fn design(machine: &Machine, request: &Request) -> Result<Self> {
        let linear = LinearLoop::of(machine)?;
        linear.check_stable(machine)?;
        let sample_period_s = machine.description().sample_period_s;
        let (samples, lines) = lines(request, sample_period_s)?;
        let phasors = phasors(request.wave, samples, &lines);
        let hz = |line: usize| line as f64 / (samples as f64 * sample_period_s);
        let through = |of: &dyn Fn(f64) -> Complex<f64>| -> Vec<f64> {
            synthesised(samples, lines.iter().zip(&phasors).map(|(line, p)| (*line, *p * of(hz(*line)))))
        };
        let to_effort = |f: f64| match request.injection {
            Injection::Voltage => linear.sensitivity(f),
            Injection::Reference => linear.reference_to_effort(f),
        };
        let to_position = |f: f64| to_effort(f) * linear.plant(f);
        // What force, held over each sample, moves the axis so.
        let to_force = SampledResponse::to_force(&machine.constants());
        let to_thrust = |f: f64| to_position(f) / to_force.position(f);
        let one = Peaks {
            position: peak(&through(&to_position)),
            velocity: peak(&through(&|f| to_position(f) * Complex::new(0.0, TAU * f))),
            effort_v: peak(&through(&to_effort)),
            thrust: peak(&through(&to_thrust)),
        };
        let wave = through(&|_| Complex::from(1.0));
        let largest = match request.injection {
            Injection::Voltage => WITHOUT_LIMITS[0],
            Injection::Reference => WITHOUT_LIMITS[1],
        };
        let mut factor = request.limits.factor(&one).unwrap_or(largest / peak(&wave));
        if let (Injection::Voltage, Some(limit)) = (request.injection, request.limits.injected_v) {
            factor = factor.min(limit / peak(&wave));
        }
        let mut found = Self {
            period: Vec::new(),
            centre: machine.solid().joint.middle(),
            lines,
            injection: request.injection,
            sample_period_s,
            predicted: one,
            simulated: one,
        };
        for _ in 0..CORRECTIONS {
            found.period = wave.iter().map(|w| factor * w).collect();
            let traces = found.excite(machine, PlantChoice::Axis, Sensing::Perfect, CHECKED_PERIODS)?;
            found.simulated = Peaks::about(found.centre, &traces);
            match request.limits.factor(&found.simulated) {
                Some(excess) if excess < 1.0 => factor *= excess,
                _ => break,
            }
        }
        let Peaks { position, velocity, effort_v, thrust } = one;
        found.predicted = Peaks {
            position: factor * position,
            velocity: factor * velocity,
            effort_v: factor * effort_v,
            thrust: factor * thrust,
        };
        Ok(found)
    }

    /// Frequencies of the lines in Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        let duration = self.period.len() as f64 * self.sample_period_s;
        self.lines.iter().map(|line| *line as f64 / duration).collect()
    }

    /// Length of a period in s.
    pub fn duration_s(&self) -> f64 {
        self.period.len() as f64 * self.sample_period_s
    }

    /// The wave's largest magnitude, in V, m or rad.
    pub fn peak(&self) -> f64 {
        peak(&self.period)
    }

    /// Peak over root mean square.
    pub fn crest_factor(&self) -> f64 {
        let square: f64 = self.period.iter().map(|w| w * w).sum();
        peak(&self.period) / (square / self.period.len() as f64).sqrt()
    }

    /// So many periods of the command: the injected voltage, or the position reference.
    pub fn command(&self, periods: usize) -> Vec<f64> {
        let offset = match self.injection {
            Injection::Voltage => 0.0,
            Injection::Reference => self.centre,
        };
        self.period.iter().map(|w| offset + w).collect::<Vec<_>>().repeat(periods)
    }

    /// The position reference under it.
    pub fn reference(&self, periods: usize) -> Vec<f64> {
        match self.injection {
            Injection::Voltage => vec![self.centre; self.period.len() * periods],
            Injection::Reference => self.command(periods),
        }
    }

    /// The machine's twin under so many periods, from standstill.
    ///
    /// # Errors
    /// What the scene refuses; a motion beyond the joint's travel.
    pub fn excite(
        &self,
        machine: &Machine,
        plant: PlantChoice,
        sensing: Sensing,
        periods: usize,
    ) -> Result<Traces> {
        let drive = Drive { machine, sensing, centre: self.centre, commands: self.commands(periods) };
        Ok(match plant {
            PlantChoice::Rapier => drive.on(Rig::new(machine)?),
            PlantChoice::Axis => drive.on(Axis::of(&machine.constants())),
            PlantChoice::Mujoco => drive.on(MujocoRig::new(machine)?),
        })
    }

    fn commands(&self, periods: usize) -> Vec<Command> {
        let (wave, centre) = (self.command(periods), self.centre);
        let injection = self.injection;
        let before = std::iter::once(centre).chain(wave.iter().copied());
        wave.iter()
            .zip(before)
            .map(|(now, before)| match injection {
                Injection::Voltage => Command { disturbance_v: *now, ..Command::follow(centre, 0.0) },
                Injection::Reference => Command::follow(*now, (now - before) / self.sample_period_s),
            })
            .collect()
    }
}

impl Peaks {
    /// Of a simulated run that stood at `centre`.
    pub fn about(centre: f64, traces: &Traces) -> Self {
        Self {
            position: traces.position.iter().fold(0.0, |most, x| most.max((x - centre).abs())),
            velocity: peak(&traces.velocity),
            effort_v: peak(&traces.effort_v),
            thrust: peak(&traces.thrust),
        }
    }
}

/// A twin's run but for its plant.
struct Drive<'a> {
    machine: &'a Machine,
    sensing: Sensing,
    centre: f64,
    commands: Vec<Command>,
}

impl Drive<'_> {
    fn on<P: Plant>(self, plant: P) -> Traces {
        let mut twin = Twin::new(self.machine, plant, self.sensing);
        twin.start(self.centre, 0.0, 0.0);
        let periods = (super::commands::STOOD_S / twin.period_s()).round() as usize;
        run(&mut twin, std::iter::repeat_n(Command::follow(self.centre, 0.0), periods), |_| ());
        run(&mut twin, self.commands.into_iter(), |_| ())
    }
}

fn peak(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// Samples of a period and the lines in the band.
fn lines(request: &Request, sample_period_s: f64) -> Result<(usize, Vec<usize>)> {
    let ([from, to], nyquist) = (request.band_hz, 0.5 / sample_period_s);
    if !(from > 0.0 && from < to && to <= nyquist) {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key("--band")
            .found(format!("{from}..{to}"))
            .expected(format!("two frequencies in Hz, 0 < from < to ≤ {nyquist} (half the sampling rate)"))
            .remedy("write for instance 5..300"));
    }
    let samples = 1.0 / (request.resolution_hz * sample_period_s);
    if !(request.resolution_hz > 0.0 && (8.0..MOST_SAMPLES).contains(&samples)) {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key("--resolution")
            .found(request.resolution_hz.to_string())
            .expected("a distance of the lines in Hz above 0 that gives a period of 8 to ten million samples")
            .remedy("give for instance 0.5"));
    }
    let samples = samples.round() as usize;
    let duration = samples as f64 * sample_period_s;
    let (first, last) = ((from * duration - 1e-6).ceil() as usize, (to * duration + 1e-6).floor() as usize);
    let lines: Vec<usize> = (first.max(1)..=last.min((samples - 1) / 2)).collect();
    if lines.is_empty() {
        return Err(Error::new(ErrorKind::OutOfRange)
            .key("--band")
            .found(format!("{from}..{to} without a line every {} Hz", 1.0 / duration))
            .expected("at least one line in the band")
            .remedy("widen the band or give a finer --resolution"));
    }
    Ok((samples, lines))
}

/// Complex amplitude of each line.
fn phasors(wave: Wave, samples: usize, lines: &[usize]) -> Vec<Complex<f64>> {
    let count = lines.len() as f64;
    match wave {
        Wave::Multisine => {
            let schroeder = |j: usize| -PI * ((j * j.saturating_sub(1)) as f64 / count);
            (1..=lines.len()).map(|j| Complex::from_polar(1.0, schroeder(j))).collect()
        }
        Wave::Sweep => {
            let (from, to) = (lines[0] as f64, lines[lines.len() - 1] as f64);
            let turns = |t: f64| from * t + 0.5 * (to - from) * t * t;
            let mut sweep: Vec<f64> =
                (0..samples).map(|i| (TAU * turns(i as f64 / samples as f64)).sin()).collect();
            let transform = RealFftPlanner::new().plan_fft_forward(samples);
            let mut spectrum = transform.make_output_vec();
            // Lengths are its own: it does not fail.
            let _ = transform.process(&mut sweep, &mut spectrum);
            lines.iter().map(|line| spectrum[*line] * (2.0 / samples as f64)).collect()
        }
    }
}

/// The real signal Re Σ A·e^(2πi·k·n/N) over one period.
fn synthesised(samples: usize, lines: impl Iterator<Item = (usize, Complex<f64>)>) -> Vec<f64> {
    let transform = RealFftPlanner::new().plan_fft_inverse(samples);
    let mut spectrum = transform.make_input_vec();
    lines.for_each(|(line, amplitude)| spectrum[line] = amplitude * 0.5);
    let mut signal = transform.make_output_vec();
    // Lengths are its own, and the first line is empty: it does not fail.
    let _ = transform.process(&mut spectrum, &mut signal);
    signal
}
