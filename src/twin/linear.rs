//! The loop as a linear sampled system: what of the twin is linear, at a frequency.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Complex;

use crate::controller::{Controller, Filters, Gains, ReferenceDelay};
use crate::drive::motor::Circuit;
use crate::effect::Constants;
use crate::error::{Error, ErrorKind, Result};
use crate::identify::margins::Margins;
use crate::machine::Machine;
use crate::plant::Resonance;
use crate::plant::axis::SampledResponse;
use crate::sensor::VelocityEstimate;

/// Points of the grid per decade of frequency.
const PER_DECADE: i32 = 80;
/// Decades that the grid reaches below half the sampling rate.
const DECADES: i32 = 5;
/// Points of the grid around a resonance, to each side.
const AROUND: i32 = 24;
/// How far they reach, in half widths of the resonance.
const WIDTHS: f64 = 12.0;
/// Least distance of two frequencies of the grid, as a share.
const LEAST_DISTANCE: f64 = 1e-6;
/// Modes of a base up to which a warning looks at the loop: the effort grows with the third power of their number.
const MOST_MODES: usize = 32;
/// Damping ratio below which the grid does not become finer.
const LEAST_DAMPING: f64 = 1e-4;

/// What the linear loop is made of besides its gains: axis, drive, delay, velocity estimate, filters of the effort.
///
/// # Model
/// G from commanded voltage to encoder position: [`SampledResponse`] of the reduced axis, effects that alter constants included.
///
/// # Validity
/// Friction other than viscous, clipping, dead zone, offset, cogging, play, screw and encoder errors and rounding are left out,
/// and so is weight: a constant one moves no frequency, that of a pendulum would act as a spring.
#[derive(Debug, Clone)]
pub struct LinearPlant {
    to_voltage: SampledResponse,
    velocity: VelocityEstimate,
    reference_delay: Option<ReferenceDelay>,
    filters: Filters,
    /// Whether the speed goes on by itself: no drag, no back-EMF.
    is_free: bool,
    grid: Vec<GridPoint>,
}

/// What does not depend on the gains, at one frequency.
#[derive(Debug, Clone, Copy)]
struct GridPoint {
    frequency_hz: f64,
    plant: Complex<f64>,
    velocity: Complex<f64>,
    sum: Complex<f64>,
    filter: Complex<f64>,
}

impl LinearPlant {
    /// The linear part of a machine's twin.
    pub fn of(machine: &Machine) -> Self {
        Self::of_constants(&machine.constants(), machine.description().reference.delay_s)
    }

    /// The linear part of a twin with these constants, whose references reach the controller `reference_delay_s` late.
    pub fn of_constants(constants: &Constants, reference_delay_s: f64) -> Self {
        let to_voltage = SampledResponse::to_voltage(constants);
        let has_back_emf = matches!(constants.circuit, Circuit::Winding { back_emf, .. } if back_emf != 0.0);
        let mut plant = Self {
            velocity: constants.velocity.clone(),
            reference_delay: ReferenceDelay::new(reference_delay_s, constants.sample_period_s),
            filters: Filters::new(
                constants.controller.as_ref().map_or(&[], Controller::filters),
                constants.sample_period_s,
            ),
            is_free: constants.viscous == 0.0 && !has_back_emf,
            grid: Vec::new(),
            to_voltage,
        };
        plant.grid = grid(plant.nyquist_hz(), plant.to_voltage.resonances())
            .into_iter()
            .map(|frequency_hz| plant.at(frequency_hz))
            .collect();
        plant
    }

    /// Sample period in s.
    pub fn period_s(&self) -> f64 {
        self.to_voltage.period_s()
    }

    /// Half the sampling rate, the highest frequency of a sampled response, in Hz.
    pub fn nyquist_hz(&self) -> f64 {
        0.5 / self.period_s()
    }

    /// Oscillations of moving part, drag and base together, by frequency.
    pub fn resonances(&self) -> &[Resonance] {
        self.to_voltage.resonances()
    }

    /// G: encoder position over commanded voltage, in m/V or rad/V.
    pub fn plant(&self, frequency_hz: f64) -> Complex<f64> {
        self.to_voltage.position(frequency_hz)
    }

    /// V: velocity estimate over encoder position, in 1/s.
    pub fn velocity_estimate(&self, frequency_hz: f64) -> Complex<f64> {
        self.velocity.response(frequency_hz, self.period_s())
    }

    /// Frequencies on which loops of this plant are looked at, in Hz: evenly over decades, closer around resonances.
    pub fn frequencies_hz(&self) -> impl Iterator<Item = f64> + '_ {
        self.grid.iter().map(|point| point.frequency_hz)
    }

    /// As [`at`](Self::at), G·ω² from the four nearest grid points by Lagrange's polynomial over ln ω: relative error below 1e-5.
    fn near(&self, frequency_hz: f64) -> GridPoint {
        let above = self.grid.partition_point(|point| point.frequency_hz < frequency_hz);
        let from = above.saturating_sub(2).min(self.grid.len().saturating_sub(4));
        let Some(four) = self.grid.get(from..from + 4) else { return self.at(frequency_hz) };
        let place = |k: usize| (four[k].frequency_hz / frequency_hz).ln();
        let x: [f64; 4] = std::array::from_fn(place);
        let mut plant = Complex::default();
        for (k, point) in four.iter().enumerate() {
            let others = (0..4).filter(|j| *j != k);
            let weight: f64 = others.map(|j| x[j] / (x[j] - x[k])).product();
            plant += point.plant * (weight * (2.0 * x[k]).exp());
        }
        let (velocity, step) =
            (self.velocity_estimate(frequency_hz), difference(frequency_hz, self.period_s()));
        let filter = self.filters.response(frequency_hz);
        GridPoint { frequency_hz, plant, velocity, sum: step.inv(), filter }
    }

    fn at(&self, frequency_hz: f64) -> GridPoint {
        GridPoint {
            frequency_hz,
            plant: self.plant(frequency_hz),
            velocity: self.velocity_estimate(frequency_hz),
            sum: difference(frequency_hz, self.period_s()).inv(),
            filter: self.filters.response(frequency_hz),
        }
    }
}

/// 1 − z⁻¹ without taking two numbers near 1 apart.
fn difference(frequency_hz: f64, period_s: f64) -> Complex<f64> {
    let half = PI * frequency_hz * period_s;
    Complex::new(0.0, 2.0 * half.sin()) * Complex::from_polar(1.0, -half)
}

/// Frequencies up to `highest_hz`, evenly over decades and closer around resonances.
fn grid(highest_hz: f64, resonances: &[Resonance]) -> Vec<f64> {
    let even =
        (-DECADES * PER_DECADE..=0).map(|k| highest_hz * 10f64.powf(f64::from(k) / f64::from(PER_DECADE)));
    let around = resonances.iter().flat_map(|r| {
        let half_width = r.damping_ratio.max(LEAST_DAMPING) * r.frequency_hz;
        (-AROUND..=AROUND).map(move |k| {
            let share = f64::from(k) / f64::from(AROUND);
            // Closer near the peak.
            r.frequency_hz + WIDTHS * half_width * share * share.abs()
        })
    });
    let lowest_hz = highest_hz * 10f64.powi(-DECADES);
    let mut all: Vec<f64> = even.chain(around).filter(|f| (lowest_hz..=highest_hz).contains(f)).collect();
    all.sort_by(f64::total_cmp);
    // Points that nearly coincide would spoil what is interpolated between them.
    all.dedup_by(|a, b| *a - *b <= LEAST_DISTANCE * *b && *a < highest_hz);
    all
}

/// The loop of a twin as a linear sampled system, exact at every frequency up to half the sampling rate.
///
/// # Model
/// At z = e^{iωT}, with G the plant, V the velocity estimate, S = 1/(1 − z⁻¹), V_r = 1/(S·T), D the reference delay and the
/// controller's [`Gains`]:
/// ```text
///   C  = integral·S + error
///   K  = F·(C·(position + V) + velocity·V)      F: filters of the effort
///   L  = G·K                                    open loop, broken at the effort; u = −L·u
///   T_x = D·G·F·C·(position + feedforward·V_r)/(1 + L)     position reference → encoder position
///   S_u = 1/(1 + L)                             injected voltage → effort
/// ```
///
/// # Validity
/// As [`LinearPlant`], and without a limit of the controller's effort. The loop is broken where voltage is injected, so L can be measured there.
///
/// # Source
/// Åström, Wittenmark (1997), *Computer-Controlled Systems*, section 3.5.
#[derive(Debug, Clone)]
pub struct LinearLoop {
    plant: Arc<LinearPlant>,
    gains: Gains,
}

impl LinearLoop {
    /// The loop of a machine with the gains of its controller.
    ///
    /// # Errors
    /// A machine without a controller.
    pub fn of(machine: &Machine) -> Result<Self> {
        let period_s = machine.description().sample_period_s;
        let Some(controller) = machine.constants().controller else {
            return Err(machine
                .lacks_controller()
                .found("a machine without a control law, which has no loop")
                .remedy("state the control law, or ask for the plant alone"));
        };
        Ok(Self::new(Arc::new(LinearPlant::of(machine)), controller.gains(period_s)))
    }

    /// The loop of a plant and these gains.
    pub fn new(plant: Arc<LinearPlant>, gains: Gains) -> Self {
        Self { plant, gains }
    }

    /// The loop of the same plant with other gains; the plant's response is shared, not computed anew.
    #[must_use]
    pub fn retuned(&self, gains: Gains) -> Self {
        Self { plant: Arc::clone(&self.plant), gains }
    }

    /// The gains.
    pub fn gains(&self) -> Gains {
        self.gains
    }

    /// What the loop is made of besides its gains.
    pub fn linear_plant(&self) -> &LinearPlant {
        &self.plant
    }

    /// G: encoder position over commanded voltage, in m/V or rad/V.
    pub fn plant(&self, frequency_hz: f64) -> Complex<f64> {
        self.plant.plant(frequency_hz)
    }

    /// K: effort over reading with its sign turned, in V/m or V/rad.
    pub fn feedback(&self, frequency_hz: f64) -> Complex<f64> {
        let sum = difference(frequency_hz, self.plant.period_s()).inv();
        let filter = self.plant.filters.response(frequency_hz);
        self.gains.feedback(sum, self.plant.velocity_estimate(frequency_hz)) * filter
    }

    /// L: the loop broken at the effort.
    pub fn open_loop(&self, frequency_hz: f64) -> Complex<f64> {
        self.open_loop_at(&self.plant.at(frequency_hz))
    }

    /// Position reference to encoder position.
    pub fn closed_loop(&self, frequency_hz: f64) -> Complex<f64> {
        self.plant(frequency_hz) * self.reference_to_effort(frequency_hz)
    }

    /// Position reference to effort, in V/m or V/rad.
    pub fn reference_to_effort(&self, frequency_hz: f64) -> Complex<f64> {
        let period_s = self.plant.period_s();
        let step = difference(frequency_hz, period_s);
        let delay =
            self.plant.reference_delay.as_ref().map_or(Complex::from(1.0), |d| d.response(frequency_hz));
        let filter = self.plant.filters.response(frequency_hz);
        let forward = self.gains.forward(step.inv(), step / period_s) * filter;
        delay * forward * self.sensitivity(frequency_hz)
    }

    /// 1/(1 + L): voltage injected between controller and amplifier to effort.
    pub fn sensitivity(&self, frequency_hz: f64) -> Complex<f64> {
        (self.open_loop(frequency_hz) + 1.0).inv()
    }

    /// Margins of L, its crossings refined between the grid's points; a setting costs some ten microseconds.
    pub fn margins(&self) -> Margins {
        let on_grid: Vec<(f64, Complex<f64>)> =
            self.plant.grid.iter().map(|point| (point.frequency_hz, self.open_loop_at(point))).collect();
        Margins::refined(&on_grid, |frequency| self.open_loop_at(&self.plant.near(frequency)))
    }

    /// Whether the closed loop is stable and holds a position, by the Nyquist criterion.
    ///
    /// # Model
    /// 1 + L is the closed loop's characteristic polynomial over the open loop's. On the way of z along the unit circle from 1
    /// to −1 its angle grows by p·π/2 − Z·π with p poles of L at z = 1 and Z closed-loop poles outside the circle. It begins at
    /// −p·π/2, and half a turn further where L·(1 − z⁻¹)^p is negative at z = 1.
    ///
    /// # Validity
    /// No open-loop pole outside the circle (drag and damping are not negative). Frequencies below the grid, 1e-5 of half the
    /// sampling rate, are taken to be ruled by the integrators. A loop that does not feed the position back keeps the plant's
    /// pole at z = 1, so that it is not stable.
    pub fn is_stable(&self) -> bool {
        let Gains { position, integral, error, .. } = self.gains;
        if position == 0.0 || (integral == 0.0 && error == 0.0) {
            return false;
        }
        let integrators = 1 + i32::from(self.plant.is_free) + i32::from(integral != 0.0);
        let Some(lowest) = self.plant.grid.first() else { return false };
        let mut values = self.plant.grid.iter().map(|point| self.open_loop_at(point) + 1.0);
        let Some(first) = values.next() else { return false };
        let (mut last, mut turns) = (first, 0);
        for value in values {
            // Whole turns change where the negative real axis is crossed.
            let side = last.re * value.im - value.re * last.im;
            turns += match (last.im < 0.0, value.im < 0.0) {
                (true, false) if side < 0.0 => -1,
                (false, true) if side > 0.0 => 1,
                _ => 0,
            };
            last = value;
        }
        let turned = last.arg() - first.arg() + f64::from(turns) * 2.0 * PI;
        // Angle at which the integrators begin, against the first angle of the grid.
        let of_controller = position * if integral == 0.0 { error } else { integral };
        // Down there a plant of positive gain lags by 90° to 180°: the middle of both is turned to 0°.
        let of_plant = (lowest.plant * Complex::from_polar(1.0, 0.75 * PI)).re;
        let half_turn = if of_controller * of_plant < 0.0 { PI } else { 0.0 };
        let begun = half_turn - f64::from(integrators) * 0.5 * PI;
        let off = first.arg() - begun;
        let off = off - 2.0 * PI * (off / (2.0 * PI)).round();
        let outside = (f64::from(integrators) * 0.5 * PI - (turned + off)) / PI;
        outside.round() == 0.0
    }

    /// A sentence where the closed loop of a machine is known not to be stable; none where it is, or where no law is stated.
    pub fn warning(machine: &Machine) -> Option<String> {
        if machine.constants().modes.as_slice().len() > MOST_MODES {
            return None;
        }
        Self::of(machine).ok().filter(|looped| !looped.is_stable()).map(|_| {
            format!(
                "The closed loop of {} is not stable, or does not hold a position: look at its gains, delays and signs.",
                machine.description().name
            )
        })
    }

    /// Refuses a loop that is not stable.
    ///
    /// # Errors
    /// An unstable loop: an experiment on it says nothing.
    pub fn check_stable(&self, machine: &Machine) -> Result<()> {
        if self.is_stable() {
            return Ok(());
        }
        Err(Error::new(ErrorKind::OutOfRange)
            .file(machine.file())
            .key("controller")
            .found("gains with which the closed loop is not stable: the twin would run away or not hold its position")
            .expected("a stable loop to excite")
            .remedy("correct the gains, the delay or the sign of the force constant; `slideway tune` finds stable gains"))
    }

    #[inline]
    fn open_loop_at(&self, point: &GridPoint) -> Complex<f64> {
        point.plant * point.filter * self.gains.feedback(point.sum, point.velocity)
    }
}
